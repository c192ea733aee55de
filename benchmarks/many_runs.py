"""Many runs at once: throughput of simulate_many beside that of bare steps, and of MuJoCo's rollouts.

    python benchmarks/many_runs.py [--runs 4096] [--rounds 7] [--json FILE]
    pip install mujoco                  # for the second table: the optional extra, pip install -e '.[peers]'

First: runs of 1 s of config/anthropomorphic.yaml at 1 ms, each from a start of its own, driven by a compiled
PD law. "Bare steps" is the processor's time of the same number of steps of one robot, called one by one.
All is measured in turns. Then the peers' driven robot (peers_robot.py), with the settings that are cheapest
there at the same error of the tip: MuJoCo's own batch (`mujoco.rollout`) and ours, under the same torques.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from peers.mujoco_robot import chain
from peers.problem import Problem, driven
from peers_robot import scene as scene_of

from flexsim_node import load_scene, simulate_many, static_equilibrium
from flexsim_node.motion.law import CompiledLaw
from flexsim_node.motion.simulation import Simulation

CONFIG = Path(__file__).resolve().parents[1] / "config"
STEPS = 1000
BATCH = 64  # runs of one turn
# cheapest at the same error in docs/accuracy.md: cut, springs, step, integrator
PEER = ("middles", 4, 1e-4, "RK4")
OURS = {"solver.method": "rosenbrock_w", "solver.step": 2e-3, "links.0.beam.elements": 1,
        "links.1.beam.elements": 1, "links.2.beam.elements": 1}  # fmt: skip


def pd(time, position, velocity, given, memory, torque):
    """Joint PD about zero with the weight fed forward: stiffness, damping and weight, a value a joint."""
    n = torque.size
    for i in range(n):
        torque[i] = given[2 * n + i] - given[i] * position[i] - given[n + i] * velocity[i]


def bare(robot: Simulation) -> float:
    """Processor time of STEPS steps, s."""
    robot.reset()
    begun = time.process_time()
    for _ in range(STEPS):
        robot.advance(robot.arrays, robot.step_size, robot.option, False)  # type: ignore[misc]
    return time.process_time() - begun


def throughput(runs: int, rounds: int, cores: int) -> dict[str, Any]:
    """Steps a second, bare and in many runs, and what memory all runs take."""
    scene = load_scene(CONFIG / "anthropomorphic.yaml")
    weight = static_equilibrium(scene, np.zeros(3)).torque
    given = np.concatenate([[3.0, 3.0, 1.0], [0.1, 0.1, 0.03], weight])
    law, rng = CompiledLaw(pd), np.random.default_rng(0)
    robot = Simulation(scene)
    robot.warm()

    def many(count: int, threads: int) -> float:
        start = rng.uniform(-0.3, 0.3, (count, 3))
        begun = time.perf_counter()
        found = simulate_many(
            scene, position=start, law=law, given=given, duration=STEPS * scene.solver.step,
            sample_period=0.01, control_period=scene.solver.step, threads=threads,
        )  # fmt: skip
        took = time.perf_counter() - begun
        assert set(found.status) == {"ok"}, set(found.status)
        return took / count

    many(2, 1)
    rows = []
    for _ in range(rounds):
        before = bare(robot)
        one, all_of = many(BATCH, 1), many(BATCH, cores)
        rows.append((0.5 * (before + bare(robot)), one, all_of))
    steps, one, all_of = np.array(rows).T
    begun = time.perf_counter()
    many(runs, cores)
    took = time.perf_counter() - begun
    return {
        "bare_step_us": spread(1e6 * steps / STEPS),
        "of_bare_on_one_core": spread(steps / one),
        "cores": cores,
        "of_one_core_on_all": spread(one / all_of),
        "runs": runs,
        "runs_s": took,
        "steps_per_s": runs * STEPS / took,
        "memory_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def beside_mujoco(rounds: int, cores: int) -> dict[str, Any]:
    """Robot seconds a second of both, with the error of each from the reference."""
    import mujoco
    from mujoco.rollout import rollout

    problem: Problem = driven()
    duration, period = problem.duration, problem.period
    model = mujoco.MjModel.from_xml_string(chain(problem, *PEER, False))
    every, count = round(period / PEER[2]), len(problem.reference)
    steps = every * (count - 1)
    torque = problem.torque * np.sin(2.0 * np.pi * (np.arange(steps) * PEER[2] + 0.5 * PEER[2]))
    state = mujoco.mjtState.mjSTATE_FULLPHYSICS
    start = np.zeros((cores, mujoco.mj_stateSize(model, state)))
    data = [mujoco.MjData(model) for _ in range(cores)]
    mujoco.mj_getState(model, data[0], start[0], state)
    start[:] = start[0]
    held = np.tile(torque.reshape(1, steps, 1), (cores, 1, 1))
    scene = load_scene(scene_of(problem), OURS)
    wave = lambda t: np.array([problem.torque * np.sin(2.0 * np.pi * t), 0.0, 0.0])  # noqa: E731
    theirs, mine, tips = [], [], {}
    for _ in range(rounds):
        begun = time.perf_counter()
        found, _ = rollout(model, data, start, held)
        theirs.append((time.perf_counter() - begun) / cores)
        begun = time.perf_counter()
        runs = simulate_many(
            [scene] * BATCH, torque=wave, duration=duration, sample_period=period, outputs=("link_end",),
            threads=cores,
        )  # fmt: skip
        mine.append((time.perf_counter() - begun) / BATCH)
        tips["flexsim"] = runs.link_end[0, :, -1]
    tip = np.zeros((count, 3))
    for k in range(count):
        mujoco.mj_setState(model, data[0], start[0] if k == 0 else found[0, every * k - 1], state)
        mujoco.mj_kinematics(model, data[0])
        tip[k] = data[0].site("tip").xpos
    tips["MuJoCo"] = tip
    return {
        "version": version("mujoco"),
        "error_mm": {name: 1e3 * problem.error(values) for name, values in tips.items()},
        "s_per_robot_s": {
            "MuJoCo": spread(np.array(theirs) / duration),
            "flexsim": spread(np.array(mine) / duration),
        },
        "ratio": spread(np.array(theirs) / np.array(mine)),
    }


def spread(values: np.ndarray) -> list[float]:
    """Median and quartiles."""
    return [float(x) for x in np.quantile(values, [0.5, 0.25, 0.75])]


def main() -> None:
    """Print both tables, or write one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--runs", type=int, default=4096)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--json", metavar="FILE")
    arguments = parser.parse_args()
    cores = len(os.sched_getaffinity(0))
    result: dict[str, Any] = {
        "load": os.getloadavg()[0],
        "throughput": throughput(arguments.runs, arguments.rounds, cores),
    }
    try:
        version("mujoco")
        result["beside_mujoco"] = beside_mujoco(arguments.rounds, cores)
    except PackageNotFoundError:
        print("mujoco is not installed: left out")
    text = json.dumps(result, indent=1)
    print(text)
    if arguments.json:
        Path(arguments.json).write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
