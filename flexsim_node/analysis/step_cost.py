"""What a step of one scene costs beside that of others, measured in turns in one process."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from ..equations.dynamics.acceleration import OK
from ..motion.simulation import Simulation
from ..scene.schema import Scene

ROUNDS = 40
STEPS = 25  # of one turn


@dataclass(frozen=True)
class Cost:
    """A step's time, s, and how many times it is that of the first scene in the same round (medians).

    spread : of the ratio, half of the interval that holds the true median nineteen times in twenty
        (McGill, Tukey & Larsen, The American Statistician 32 (1978) 12: 1.57 interquartile ranges over the
        root of the number of rounds)
    """

    step: float
    ratio: float
    spread: float = 0.0


def step_costs(
    scenes: Mapping[str, Scene | tuple[Scene, bool]],
    drive: Callable[[float], np.ndarray] | None = None,
    rounds: int = ROUNDS,
) -> dict[str, Cost]:
    """Measure the steps of scenes against the first of them.

    Parameters
    ----------
    scenes : name to a scene, or to a scene and whether three dofs a node are carried
    drive : torque (m,) as a function of time

    Every round gives each of them a turn, so that what else the machine does meets them alike.  One that
    stops starts again.
    """
    robots = {}
    for name, given in scenes.items():
        scene, planar = given if isinstance(given, tuple) else (given, None)
        robots[name] = Simulation(scene, planar=planar)
    for robot in robots.values():
        if robot.advance is None:
            raise ValueError(
                f"{robot.scene.name}: solver.method {robot.method}: its steps have no fixed cost;"
                " give rosenbrock_w, generalized_alpha or runge_kutta_4"
            )
        start(robot, drive)
        robot.warm()
    times: dict[str, list[float]] = {name: [] for name in robots}
    for _ in range(rounds):
        for name, robot in robots.items():
            times[name].append(turn(robot, drive))
    first = np.array(next(iter(times.values())))
    found = {}
    for name, values in times.items():
        ratios = np.array(values) / first
        low, middle, high = np.quantile(ratios, [0.25, 0.5, 0.75])
        spread = 1.57 * (high - low) / np.sqrt(len(ratios))
        found[name] = Cost(float(np.median(values)), float(middle), float(spread))
    return found


def start(robot: Simulation, drive: Callable[[float], np.ndarray] | None) -> None:
    """Begin anew."""
    robot.reset()
    if drive is not None:
        robot.command(np.asarray(drive(0.0)))
    robot.prepare()


def turn(robot: Simulation, drive: Callable[[float], np.ndarray] | None) -> float:
    """Mean time of a step over one turn, s; torques are set outside of what is timed."""
    total = 0
    for _ in range(STEPS):
        if drive is not None:
            robot.command(np.asarray(drive(robot.time)))
        begun = time.perf_counter_ns()
        status = robot.step()
        total += time.perf_counter_ns() - begun
        if status != OK:
            start(robot, drive)
    return 1e-9 * total / STEPS
