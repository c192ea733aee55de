"""What reduced links cost and how far they are off: full against 6 modes a link, in one process.

    python benchmarks/reduction.py [--quick] [--json]

Three links of eight elements, in space and in a plane, with the links' frames at their roots (`zeroed: root`,
as the shipped scenes have it: two factorisations a step) and along their chords (the default: one), shaken by
their torques.  Full and reduced
robots take turns, step by step, each from the same states again and again, so that whatever else the machine
does falls on both; the ratio is the median of the pairs', with its quartiles.

Vibration is the largest deflection of the tip from the rigid robot whose frames are at the links' roots:
where q follows the chords a link's end hardly leaves its frame, however much it vibrates.  How far the full
model's runs with frames at the roots and along the chords part, by the time integration alone, says what a
difference of the tips means.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from typing import Any

import numpy as np
from step_cost import machine

from flexsim_node import Scene, load_scene, simulate
from flexsim_node.motion.simulation import Simulation

MODES = 6


def arm(spatial: bool, modes: int | None, elements: int = 8, zeroed: str = "auto") -> Scene:
    """An anthropomorphic arm, or three links in a plane, of the thesis' beams."""
    beam = {"density": 7800.0, "youngs_modulus": 2e11, "poissons_ratio": 0.33, "elements": elements}
    wide, high = {"width": 0.01, "depth": 0.03, **beam}, {"width": 0.03, "depth": 0.01, **beam}
    if spatial:
        places = [{"d": 0.5, "alpha": 1.5707963267948966}, {"a": 0.5}, {"a": 0.5}]
    else:
        places = [{"a": 0.5}] * 3
    return load_scene(
        {
            "model": "robot",
            "name": "arm",
            "gravity": [0.0, 0.0, -9.81] if spatial else [0.0, -9.81, 0.0],
            "damping": {"alpha": 0.0, "beta": 2e-6},
            "erls": {"zeroed": zeroed},
            "links": [
                {
                    "name": f"link_{k + 1}",
                    "dh": dh,
                    "joint": {"viscous_friction": 2.0},
                    "beam": wide if spatial or k % 2 else high,
                }
                for k, dh in enumerate(places)
            ],
            **({} if modes is None else {"reduction": {"modes": modes}}),
        }
    )


def torque(t: float) -> np.ndarray:
    """Steps and tones that shake every link."""
    kick = 8.0 if t < 0.05 else (-8.0 if t < 0.1 else 0.0)
    return np.array([kick + 2.0 * np.sin(150.0 * t), 12.0 + kick + np.sin(250.0 * t), 4.0 - 0.5 * kick])


def timed(robot: Simulation, state: tuple[np.ndarray, ...]) -> float:
    """Seconds of one step from a state; the step before it from there warms the caches."""
    for _ in range(2):
        for place, value in zip((robot.x, robot.v, robot.work.memory), state, strict=True):
            place[:] = value
        begin = time.perf_counter()
        status = robot.step()
        spent = time.perf_counter() - begin
    if status != 0:
        raise RuntimeError(f"{robot.scene.name}: {robot.reason}")
    return spent


def measure(spatial: bool, zeroed: str, quick: bool) -> dict[str, Any]:
    """Costs, their ratio and the tips' distance for one kind of arm, and one kind of frames."""
    rounds, states = (5, 2) if quick else (400, 10)
    scenes = [arm(spatial, modes, zeroed=zeroed) for modes in (None, MODES)]
    robots = [Simulation(scene) for scene in scenes]
    for robot in robots:
        robot.prepare()
        robot.warm()
    costs = []
    for k in range(states):
        held = []
        for robot in robots:
            for n in range(20):
                robot.command(torque(1e-3 * (20 * k + n)))
                robot.step()
            held.append((robot.x.copy(), robot.v.copy(), robot.work.memory.copy()))
        costs += [[timed(r, s) for r, s in zip(robots, held, strict=True)] for _ in range(rounds)]
        for robot, state in zip(robots, held, strict=True):
            timed(robot, state)
    cost = np.array(costs)
    ratio = cost[:, 1] / cost[:, 0]
    duration = 0.02 if quick else 0.3
    applied = np.array([torque(k * 1e-3) for k in range(round(duration / 1e-3))])
    full, part, rooted = (
        simulate(scene, applied, duration) for scene in (*scenes, arm(spatial, None, zeroed="root"))
    )
    vibration = np.max(np.linalg.norm(rooted.node_position[:, -1] - rooted.rigid_position[:, -1], axis=1))
    apart, own = (
        np.max(np.linalg.norm(full.link_end[:, -1] - run.link_end[:, -1], axis=1)) for run in (part, rooted)
    )
    return {
        "unknowns": [robot.model.unknowns for robot in robots],
        "full_us": 1e6 * float(np.median(cost[:, 0])),
        "reduced_us": 1e6 * float(np.median(cost[:, 1])),
        "ratio": float(np.median(ratio)),
        "ratio_quartiles": [float(np.percentile(ratio, p)) for p in (25, 75)],
        "ratio_of_best": float(cost[:, 1].min() / cost[:, 0].min()),
        "vibration_mm": 1e3 * float(vibration),
        "difference_mm": 1e3 * float(apart),
        "full_models_apart_mm": 1e3 * float(own),
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--quick", action="store_true", help="a smoke run: figures mean nothing")
    parser.add_argument("--json", action="store_true", help="one object for programs")
    arguments = parser.parse_args()
    found = {"machine": machine()}
    found |= {
        kind: {zeroed: measure(kind == "spatial", zeroed, arguments.quick) for zeroed in ("root", "chord")}
        for kind in ("spatial", "planar")
    }
    if arguments.json:
        json.dump(found, sys.stdout, indent=1)
        return
    print(", ".join(f"{key} {value}" for key, value in found["machine"].items()))
    print(f"{'3 links of 8 elements':24}{'unknowns':>12}{'us a step':>18}{'ratio':>8}{'quartiles':>15}"
          f"{'tip, mm of mm':>18}")  # fmt: skip
    for kind in ("spatial", "planar"):
        for zeroed, f in found[kind].items():
            low, high = f["ratio_quartiles"]
            print(
                f"{f'{kind}, zeroed {zeroed}':24}{'{} -> {}'.format(*f['unknowns']):>12}"
                f"{'{:.1f} -> {:.1f}'.format(f['full_us'], f['reduced_us']):>18}{f['ratio']:8.3f}"
                f"{f'{low:.2f}..{high:.2f}':>15}"
                f"{'{difference_mm:.4f} of {vibration_mm:.2f}'.format(**f):>18}"
            )


if __name__ == "__main__":
    main()
