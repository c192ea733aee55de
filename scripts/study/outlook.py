"""What a study's advice depends on: longer runs, motions nearby, and times taken alone."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np

from flexsim_node import Run, Scene

from .motion import Motion, far
from .point import Array, Outcome
from .robot_grid import STEPS, RobotGrid

LONGER = (1, 2, 4)
"""Durations that an advice is measured at, in those studied."""
NUDGE = 0.05
"""rad or m that the joints of a motion nearby begin elsewhere."""
LOUDER = 1.1
"""Times the torques of a motion nearby."""
ALONE = 9
"""Runs whose times are taken alone."""


class Moving(Protocol):
    """A study whose motion can be run: RobotStudy."""

    duration: float
    period: float
    sines: dict[str, tuple[float, float]]
    grid: RobotGrid

    def scene_with(self, overrides: Mapping[str, Any]) -> Scene:
        """The scene with overrides."""

    def sample_of(self, scene: Scene) -> float:
        """The time between samples, s."""

    def move(
        self,
        scene: Scene,
        duration: float | None = None,
        exact: bool = False,
        louder: float = 1.0,
        sample: float | None = None,
    ) -> Run:
        """Run the motion."""

    def motion(self, run: Run) -> Motion:
        """The tips and joints of a run."""


def outlook(study: Moving, outcome: Outcome, tolerance: float | None) -> dict[str, Any]:
    """The chosen point's error over longer durations and on motions nearby.

    Each is held against two runs of the grid's finest mesh whose steps are the grid's finest and half that,
    with every jump at a step's end; what these two differ by is what the comparison itself may be off.

    Returns
    -------
    longer : for each duration that could be run {"times", "duration", "error", "unsure"}, s and m
    stopped : why longer ones could not be, or ""
    hopeless : s from which on the two references part by more than the tolerance (or the error), or None
    nearby : {what was changed: {"error", "unsure"}}, m
    """
    scene = study.scene_with(outcome.overrides)
    found: dict[str, Any] = {"longer": [], "stopped": "", "hopeless": None, "nearby": {}}
    run, best, check, found["stopped"] = _compared(study, scene, LONGER[-1] * study.duration, {})
    if len(run):
        off, unsure = (_so_far(a, best) for a in (run, check))
        times = study.sample_of(scene) * np.arange(len(off))
        for n in LONGER:
            until = n * study.duration * (1.0 + 1e-9)
            if times[-1] >= n * study.duration * (1.0 - 1e-9):
                k = int(np.sum(times <= until)) - 1
                found["longer"].append(
                    {
                        "times": n,
                        "duration": n * study.duration,
                        "error": float(off[k]),
                        "unsure": float(unsure[k]),
                    }
                )
        first = float(found["longer"][0]["error"]) if found["longer"] else math.inf
        parted = np.flatnonzero(unsure > (first if tolerance is None else tolerance))
        found["hopeless"] = float(times[parted[0]]) if len(parted) else None
    for name, changed in _nearby(study, scene).items():
        run, best, check, trouble = _compared(study, scene, study.duration, changed)
        if not trouble:
            found["nearby"][name] = {"error": far(run, best), "unsure": far(check, best)}
    return found


def _nearby(study: Moving, scene: Scene) -> dict[str, dict[str, Any]]:
    """Motions nearby: what is changed of the run, by what is said of it."""
    start = scene.start("position") + NUDGE * np.array([j.actuated for j in scene.joints])
    found: dict[str, dict[str, Any]] = {
        f"begun {NUDGE:g} rad or m beside": {"initial.position": [float(q) for q in start]}
    }
    if study.sines or scene.torque:
        found[f"with {LOUDER - 1.0:.0%} more torque"] = {"louder": LOUDER}
    return found


def _compared(
    study: Moving, scene: Scene, duration: float, changed: Mapping[str, Any]
) -> tuple[Array, Array, Array, str]:
    """The scene's tips (K, tips, 3) beside two references', as far as all run, and why not further."""
    louder = float(changed.get("louder", 1.0))
    update: dict[str, Any] = {}
    if "initial.position" in changed:
        start = tuple(changed["initial.position"])
        update["initial"] = scene.initial.model_copy(update={"position": start})
    finest = study.grid.elements[-1]
    links = tuple(
        link.model_copy(update={"beam": link.beam.model_copy(update={"elements": finest}), "reduction": None})
        if link.beam is not None and link.flexible
        else link
        for link in scene.links
    )
    sample = study.sample_of(scene)

    def run(step: float | None) -> tuple[Motion, Run]:
        given = scene.model_copy(update=update)
        if step is not None:
            solver = given.solver.model_copy(update={"method": "rosenbrock_w", "step": step})
            given = given.model_copy(update={"solver": solver, "links": links, "reduction": None})
        done = study.move(given, duration, exact=step is not None, louder=louder, sample=sample)
        return study.motion(done), done

    try:
        several = [run(step) for step in (None, STEPS[-1] / 2.0, STEPS[-1])]
    except (ValueError, ArithmeticError) as problem:
        empty = np.zeros((0, 1, 3))
        return empty, empty, empty, str(problem)
    least = min(len(m.tip) for m, _ in several)
    trouble = next((r.status for _, r in several if r.status != "ok"), "")
    own, best, check = (m.tip[:least] for m, _ in several)
    return own, best, check, trouble


def _so_far(a: Array, b: Array) -> Array:
    """(K,) the largest distance of any tip until each sample, m."""
    return np.maximum.accumulate(np.linalg.norm(a - b, axis=-1).max(axis=1))


def taken_alone(study: Moving, outcome: Outcome) -> dict[str, Any]:
    """A step's time, s: median and 99th percentile over runs of the choice alone, and their spread.

    busy : the machine's load over its cores before; above 1 the times are not the point's own
    """
    busy = os.getloadavg()[0] / len(os.sched_getaffinity(0))
    scene = study.scene_with(outcome.overrides)
    study.move(scene, study.period)
    runs = [np.quantile(study.move(scene).step_time, [0.5, 0.99]) for _ in range(ALONE)]
    p50, p99 = np.transpose(runs)
    # Of nine runs the middle; another run may well lie beyond these nine, so their range counts twice.
    return {
        "p50": float(np.median(p50)),
        "p99": float(np.median(p99)),
        "p50_spread": float(np.ptp(p50)),
        "p99_spread": float(np.ptp(p99)),
        "busy": busy,
    }
