"""The thesis' two robots beside Exudyn and MuJoCo, in one run: time at matched tip error.

    pip install exudyn mujoco           # the optional extra: pip install -e '.[peers]'
    python benchmarks/peers_robot.py [--json FILE] [--repeats 3] [--only falling|driven]

Error: the largest distance of the tip from the reference motion (tests/robot/data: geometrically exact
or ANCF beams of Exudyn, converged to about 0.01 mm), sampled each 10 ms. Time: processor time of the
steps for a simulated second, each tool once a round; ours with Python's call of every step, the peers' in
their own loops. Everything is undamped. A peer that is not
installed is left out and named.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import time
from collections.abc import Callable, Iterator
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from peers import exudyn_floating, exudyn_robot, mujoco_robot
from peers.exudyn_robot import Attempt
from peers.problem import YOUNG, Problem, driven, falling

from flexsim_node import load_scene
from flexsim_node.motion.simulation import Simulation

MUJOCO = (
    ("implicitfast", 2, 2e-4), ("implicitfast", 2, 1e-4), ("implicitfast", 4, 5e-5),
    ("RK4", 2, 5e-4), ("RK4", 2, 2.5e-4), ("RK4", 2, 2e-4), ("RK4", 3, 2.5e-4), ("RK4", 3, 1e-4),
    ("RK4", 4, 2e-4), ("RK4", 4, 1e-4), ("RK4", 8, 5e-5),
)  # fmt: skip
"""Integrator, springs a link, step; those that come apart are shown as unstable."""
TOLD = 1e-5
"""m: what the reference motions are converged to; smaller errors are not told apart."""


def scene(problem: Problem) -> dict[str, Any]:
    """The problem as a scene of ours."""
    links = []
    for number, link in enumerate(problem.links):
        upright = link.direction[2] == 1
        dh = {"d": link.length, "alpha": 0.5 * np.pi} if upright else {"a": link.length}
        beam = {
            "width": link.side_y,
            "depth": link.side_z,
            "density": problem.density,
            "youngs_modulus": YOUNG,
            "poissons_ratio": problem.poisson,
        }
        links.append({"name": f"link_{number + 1}", "dh": dh, "beam": beam})
    return {
        "model": "robot",
        "name": problem.name,
        "gravity": list(problem.gravity),
        "links": links,
        "effects": {"rotary_inertia": problem.section_inertia},
    }


def ours(problem: Problem, method: str, elements: int, step: float, repeats: int) -> Attempt:
    """Simulate the problem with flexsim."""
    overrides: dict[str, Any] = {"solver.method": method, "solver.step": step}
    overrides |= {f"links.{k}.beam.elements": elements for k in range(len(problem.links))}
    made = load_scene(scene(problem), overrides)
    every = round(problem.period / step)
    drive = problem.torque * np.sin(2.0 * np.pi * np.arange(2 * every * (len(problem.reference) - 1) + 1)
                                    * 0.5 * step)  # fmt: skip
    seconds, tip = [], np.zeros((len(problem.reference), 3))
    for _ in range(repeats):
        robot = Simulation(made)
        robot.prepare()
        robot.warm()
        tip[0] = robot.look().link_end[-1]
        took = 0.0
        for k in range(1, len(tip)):
            begun = time.process_time()
            for n in range((k - 1) * every, k * every):
                robot.torque[:, 0] = drive[2 * n : 2 * n + 3]
                robot.step()
            took += time.process_time() - begun
            tip[k] = robot.look().link_end[-1]
        if robot.status != 0:
            raise RuntimeError(robot.reason)
        seconds.append(took / problem.duration)
    return Attempt(seconds, tip.copy())


def ways(problem: Problem) -> Iterator[tuple[str, str, int, float, Callable[..., Attempt]]]:
    """Tool, method, elements, modes or springs a link, step, and what runs it so many times."""
    planar = all(axis == (0, 0, 1) for axis in problem.axes)
    for method in ("rosenbrock_w", "generalized_alpha"):
        for elements in (1, 2, 4):
            for step in (2e-3, 1e-3, 5e-4, 2.5e-4):
                yield "flexsim", method, elements, step, partial(ours, problem, method, elements, step)
    if installed("exudyn"):
        peer = exudyn_robot.planar_ancf if planar else exudyn_robot.spatial_exact
        name = "planar ANCF cable" if planar else "geometrically exact"
        for elements in (2, 4):
            for step in (2e-3, 1e-3, 5e-4, 2.5e-4) if planar else (2e-3, 1e-3):
                yield "Exudyn", name, elements, step, partial(peer, problem, elements, step)
        for vibrations in (0, 1, 3):
            modes = vibrations + (3 if planar else 6)
            for step in (2e-3, 1e-3, 5e-4):
                way = partial(exudyn_floating.attempt, problem, vibrations, step, planar)
                yield "Exudyn", "floating frame", modes, step, way
    if installed("mujoco"):
        for cut in ("middles", "equal"):
            for integrator, springs, step in MUJOCO:
                way = partial(mujoco_robot.attempt, problem, cut, springs, step, integrator, planar)
                yield "MuJoCo", f"chain, {cut}, {integrator}", springs, step, way


def installed(package: str) -> bool:
    """Whether a peer is there."""
    try:
        version(package)
    except PackageNotFoundError:
        return False
    return True


def matched(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Each peer's time over ours at the smallest error that both reach and the reference can tell.

    `least`: the same at whichever larger error is best for the peer. A peer is a tool with a kind of element
    or an integrator; its best cut, springs and step are taken.
    """
    found = []
    rows = [r | {"peer": peer_of(r)} for r in rows if r["error"] is not None and np.isfinite(r["error"])]
    mine = [r for r in rows if r["tool"] == "flexsim"]
    for peer in dict.fromkeys(r["peer"] for r in rows if r["tool"] != "flexsim"):
        theirs = [r for r in rows if r["peer"] == peer]
        error = max(TOLD, min(r["error"] for r in mine), min(r["error"] for r in theirs))

        def cheapest(group: list[dict[str, Any]], error: float) -> dict[str, Any]:
            return min((r for r in group if r["error"] <= error * 1.0001), key=lambda r: r["seconds"])

        ours, other = cheapest(mine, error), cheapest(theirs, error)
        least = min(
            cheapest(theirs, e)["seconds"] / cheapest(mine, e)["seconds"]
            for e in [error, *(r["error"] for r in theirs if r["error"] > error)]
        )
        found.append(
            {"peer": peer, "error": error, "ours": ours, "theirs": other,
             "ratio": other["seconds"] / ours["seconds"], "least": least}
        )  # fmt: skip
    return found


def peer_of(row: dict[str, Any]) -> str:
    """Tool and method, without where a chain is cut."""
    return f"{row['tool']}, {row['method'].replace('middles, ', '').replace('equal, ', '')}"


def main() -> None:
    """Print the tables, or write one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--json", metavar="FILE")
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--only", choices=("falling", "driven"))
    arguments = parser.parse_args()
    problems = [falling] if arguments.only != "driven" else []
    problems += [driven] if arguments.only != "falling" else []
    missing = [name for name in ("exudyn", "mujoco") if not installed(name)]
    result: dict[str, Any] = {
        "machine": {"processor": platform.processor() or platform.machine(),
                    "cores": len(os.sched_getaffinity(0)), "load": os.getloadavg()[0]},
        "versions": {n: version(n) for n in ("numpy", "numba", "exudyn", "mujoco") if installed(n)},
        "missing": missing,
        "problems": {},
    }  # fmt: skip
    for make in problems:
        problem = make()
        rows = []
        print(f"{problem.name}\n{'':10}{'method':32}{'elements':>9}{'step, ms':>10}{'tip, mm':>10}"
              f"{'s per s':>10}{'spread':>8}")  # fmt: skip
        tries = list(ways(problem))
        taken: list[list[float]] = [[] for _ in tries]
        tips = [np.zeros((0, 3))] * len(tries)
        for _ in range(arguments.repeats):  # in turns, so that whatever else the machine does falls on all
            for k, (*_, way) in enumerate(tries):
                attempt = way(1)
                taken[k] += attempt.seconds
                tips[k] = attempt.tip
        for (tool, method, elements, step, _), seconds, tip in zip(tries, taken, tips, strict=True):
            error = problem.error(tip)
            # A robot that is half a metre off has fallen apart.
            error = error if error < 0.5 else float("inf")
            median = float(np.median(seconds)) if seconds else float("nan")
            spread = (max(seconds) - min(seconds)) / (2 * median) if seconds else 0.0
            rows.append({"tool": tool, "method": method, "elements": elements, "step": step,
                         "error": error, "seconds": median, "spread": spread})  # fmt: skip
            said = f"{error * 1e3:10.4f}" if np.isfinite(error) else f"{'unstable':>10}"
            print(
                f"{tool:10}{method:32}{elements:9}{step * 1e3:10.3f}{said}{median:10.4f}{spread:8.0%}",
                flush=True,
            )
        found = matched(rows)
        for m in found:
            print(
                f"at {m['error'] * 1e3:.3g} mm: {m['peer']} takes {m['ratio']:.2g} times as long"
                f" ({m['theirs']['seconds']:.3g} against {m['ours']['seconds']:.3g} s per s)"
            )
        for row in rows:
            row["error"] = row["error"] if np.isfinite(row["error"]) else None
        result["problems"][problem.name] = {"rows": rows, "matched": found}
        print()
    if missing:
        print(f"not installed, left out: {', '.join(missing)}")
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
