"""The study of a robot: one motion of the scene, and its links ringing with the joints held."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from flexsim_node import Run, Scene, load_scene, natural_frequencies, simulate

from .point import Array, Measure, Outcome, Point, Reference
from .ringing import ringing
from .robot_grid import STEPS, RobotGrid

SAMPLES = 100
RINGS = 8
"""Periods of the slowest vibration that are listened to."""
PUSH = 0.02
"""rad or m that every joint is moved to make the links ring."""
REPEATS = 3
LIMIT = 10.0
"""s that one run of a point may take."""
PROBE = 0.02
"""Part of a run that tells how long the whole would take."""
MESH_ORDER = {"erls": 4, "co_moving": 2}
"""Order of the tip's error in the length of an element."""


@dataclass(frozen=True)
class Motion:
    """The tip (K, 3), m, and the joints (K, m), rad or m, over time."""

    tip: Array
    angle: Array

    def beyond(self, coarser: Motion, order: int) -> Motion:
        """Extrapolated to no step, or no element, from this one and one of twice that (Richardson)."""
        n = 2.0**order
        return Motion((n * self.tip - coarser.tip) / (n - 1.0), (n * self.angle - coarser.angle) / (n - 1.0))

    def apart(self, other: Motion) -> Array:
        """Largest distance of the tips, m, and of any joint, rad or m."""
        return np.array([far(self.tip, other.tip), float(np.max(np.abs(self.angle - other.angle)))])


class RobotStudy:
    """Work and precision of a robot scene.

    sines : joint name to (amplitude in N m or N, frequency in Hz) of a sine torque
    vary : further axes, a scene key to its values
    quick : the smallest grid that still shows something
    """

    kind = "robot"
    measures = (
        Measure("tip", "tip position", "mm", 1e3),
        Measure("angle", "joint angle", "mrad", 1e3),
        Measure("frequency", "vibration frequency", "%", 1e2),
        Measure("decay", "vibration decay", "%", 1e2),
        Measure("time", "tip position, of the step alone", "mm", 1e3),
    )

    def __init__(
        self,
        path: str,
        overrides: Mapping[str, Any],
        duration: float,
        sines: Mapping[str, tuple[float, float]],
        vary: Mapping[str, list[Any]],
        quick: bool = False,
    ) -> None:
        self.path, self.given = path, dict(overrides)
        self.sines, self.vary, self.quick = dict(sines), dict(vary), quick
        self.scene = load_scene(path, self.given)
        unknown = [name for name in sines if name not in self.scene.joint_names]
        if unknown:
            raise ValueError(
                f"--sine {unknown[0]}: no such joint; there are {', '.join(self.scene.joint_names)}"
            )
        # Every step of the grid divides the time between samples, so that none is shortened.
        self.period = STEPS[0] * max(1, round(duration / SAMPLES / STEPS[0]))
        self.duration = self.period * max(1, round(duration / self.period))
        self.grid = RobotGrid(path, self.given, self.scene, self.period, self.vary, quick)

    @property
    def fingerprint(self) -> dict[str, Any]:
        return {
            "scene": self.scene.model_dump(mode="json", exclude={"source"}),
            "duration": self.duration,
            "sines": {k: list(v) for k, v in self.sines.items()},
            "vary": self.vary,
            "quick": self.quick,
        }

    def points(self) -> list[Point]:
        """The grid."""
        return self.grid.points()

    # Runs

    def _scene(self, overrides: Mapping[str, Any]) -> Scene:
        return load_scene(self.path, {**self.given, **overrides})

    def _torque(self, t: float) -> Array:
        out = np.zeros(len(self.scene.joint_names))
        for name, (amplitude, frequency) in self.sines.items():
            out[self.scene.joint_names.index(name)] = amplitude * np.sin(2.0 * np.pi * frequency * t)
        return out

    def _move(self, scene: Scene, duration: float | None = None) -> Run:
        torque = self._torque if self.sines else None
        duration = self.duration if duration is None else duration
        return simulate(scene, torque, duration, sample_period=self.period)

    @cached_property
    def _start(self) -> Array:
        """Where the joints begin, rad or m."""
        return simulate(self.scene, duration=0.0).joint_position[0]

    @cached_property
    def _slowest(self) -> float | None:
        """The slowest vibration with the joints held, Hz."""
        if not self.grid.flexible:
            return None
        try:
            frequencies = np.asarray(natural_frequencies(self.scene, self._start, locked=True))
        except (ValueError, np.linalg.LinAlgError):
            return None
        heard = frequencies[frequencies > 1e-3]
        return float(heard[0]) if len(heard) else None

    def _ring(self, scene: Scene, near: float | None = None) -> tuple[float, float] | None:
        """Frequency and decay after every joint was moved a little and held; None where that can't be.

        near : the vibration that is meant, Hz; the strongest one where None
        """
        slowest = self._slowest
        if slowest is None:
            return None
        rise = 0.5 / slowest
        starts = self._start

        def pushed(start: float) -> Callable[[float], tuple[float, float, float]]:
            def motion(t: float) -> tuple[float, float, float]:
                if t >= rise:
                    return start + PUSH, 0.0, 0.0
                w = np.pi / rise
                return (
                    start + 0.5 * PUSH * (1.0 - np.cos(w * t)),
                    0.5 * PUSH * w * np.sin(w * t),
                    0.5 * PUSH * w * w * np.cos(w * t),
                )

            return motion

        moved = {n: pushed(q) for n, q in zip(scene.joint_names, starts, strict=True)}
        sample = 1.0 / (20.0 * slowest)
        try:
            run = simulate(scene, None, rise + RINGS / slowest, sample_period=sample, prescribed=moved)
        except ValueError:
            return None
        heard = run.time >= rise - 1e-9
        if run.status != "ok" or heard.sum() < 40:
            return None
        try:
            return ringing(run.link_end[heard, -1], sample, near)
        except (ValueError, np.linalg.LinAlgError):
            return None

    # Reference

    def reference(self, progress: Callable[[str], None]) -> Reference:
        """Twice the finest mesh of the scene's own formulation, both methods extrapolated to no step.

        The error of the step is what the two methods differ by; that of the mesh follows from what half as
        many elements change and the formulation's order, where that is two after it is extrapolated.
        The other formulations are taken to their own end likewise: how far they then are is what their
        model changes.
        """
        finest = 2 * self.grid.elements[-1]
        step = self.grid.steps[-1] / 2.0
        fine, half, quarter = (self.grid.meshed(finest // n) for n in (1, 2, 4))

        def extrapolated(method: str, changed: dict[str, Any]) -> Motion:
            both = []
            for h in (step, step / 2.0):
                said = f", {changed['formulation']}" if "formulation" in changed else ""
                progress(f"reference: {method}, {h:g} s{said}")
                run = self._move(self._scene({**changed, "solver.method": method, "solver.step": h}))
                if run.status != "ok":
                    raise ValueError(f"the reference {run.status}; study a motion that the scene can do")
                both.append(Motion(run.link_end[:, -1], run.joint_position))
            return both[1].beyond(both[0], 2)

        order = MESH_ORDER[self.scene.formulation]
        best, check = (extrapolated(m, fine) for m in ("rosenbrock_w", "generalized_alpha"))
        own = best.apart(check)
        how = f"rosenbrock_w and generalized_alpha extrapolated from {step:g} and {step / 2:g} s"
        if self.grid.flexible:
            coarse = extrapolated("rosenbrock_w", half)
            how += f", {finest} elements a link against {finest // 2}"
            if order < 4:
                coarser = extrapolated("rosenbrock_w", quarter)
                best, coarse = best.beyond(coarse, order), coarse.beyond(coarser, order)
                how += f" and {finest // 4}, extrapolated"
            own = own + best.apart(coarse) / 15.0
        same_a, same_b = (extrapolated(m, {}) for m in ("rosenbrock_w", "generalized_alpha"))
        arrays = {"tip": best.tip, "angle": best.angle, f"time_{self.scene.formulation}": same_a.tip}
        error = {"tip": float(own[0]), "angle": float(own[1]), "time": float(same_a.apart(same_b)[0])}
        formulations = {}
        for name, changed in self.grid.other_formulations().items():
            if self.grid.refusal(changed) or not self.grid.flexible:
                continue
            try:
                there = [extrapolated("rosenbrock_w", {**changed, **mesh}) for mesh in (fine, half)]
                arrays[f"time_{name}"] = extrapolated("rosenbrock_w", changed).tip
            except ValueError:
                continue  # its points say why
            end = there[0].beyond(there[1], MESH_ORDER[name])
            formulations[name] = {
                "distance": float(end.apart(best)[0]),
                "uncertainty": float(end.apart(there[0])[0]) + error["tip"],
            }

        def rung(method: str, mesh: dict[str, Any], near: float | None) -> tuple[float, float] | None:
            scene = self._scene({**mesh, "solver.method": method, "solver.step": step})
            return self._ring(scene, near)

        progress("reference: the links ring")
        first = rung("rosenbrock_w", fine, None)
        others = [] if first is None else [
            rung("generalized_alpha", fine, first[0]), rung("rosenbrock_w", half, first[0])
        ]  # fmt: skip
        if first is not None and all(r is not None for r in others):
            a, b, c = (np.array(r) for r in (first, *others))
            arrays["ringing"] = a
            own = np.abs(a - b) + np.abs(a - c) / 15.0
            error["frequency"] = float(own[0] / a[0])
            error["decay"] = float(own[1] / max(abs(a[1]), 1e-9))
        return Reference(arrays, error, how, formulations)

    # Points

    def measure(self, point: Point, reference: Reference) -> Outcome:
        """Run a point: its errors, and its time by repetition."""
        outcome = Outcome(point.name, point.curve, point.size, dict(point.overrides), "ok")
        outcome.effect = point.effect
        try:
            scene = self._scene(point.overrides)
            self._move(scene, 0.0)
            probe = self._move(scene, max(self.period, PROBE * self.duration))
            adaptive = scene.solver.method in ("radau", "dop853")
            took = self._cost(probe, adaptive) * self.duration if probe.status == "ok" else 0.0
            if probe.status == "ok" and took > LIMIT:
                outcome.status = f"left out: would take {took:.0f} s"
                return outcome
            run = self._move(scene)
        except ValueError as problem:
            outcome.status = str(problem)
            return outcome
        if run.status != "ok":
            outcome.status = run.status
            return outcome
        repeats = 1 if took > 0.2 * LIMIT else REPEATS
        outcome.seconds = [self._cost(run, adaptive)]
        outcome.seconds += [self._cost(self._move(scene), adaptive) for _ in range(repeats - 1)]
        outcome.step = None if adaptive else self.duration / len(run.step_time)
        tip = run.link_end[:, -1]
        outcome.errors["tip"] = far(tip, reference.arrays["tip"])
        outcome.errors["angle"] = float(np.max(np.abs(run.joint_position - reference.arrays["angle"])))
        same = reference.arrays.get(f"time_{scene.formulation}")
        if same is not None and self._same_physics(scene):
            outcome.errors["time"] = far(tip, same)
        right = reference.arrays.get("ringing")
        ring = None if right is None or adaptive else self._ring(scene, float(right[0]))
        if ring is not None and right is not None:
            outcome.errors["frequency"] = abs(ring[0] / right[0] - 1.0)
            outcome.errors["decay"] = abs(ring[1] - right[1]) / max(abs(right[1]), 1e-9)
        return outcome

    def _same_physics(self, scene: Scene) -> bool:
        """Whether nothing but the integrator, and the formulation, is not the scene's own."""
        own = {name: getattr(self.scene, name) for name in ("solver", "formulation")}
        if scene.formulation != self.scene.formulation:
            own["erls"] = self.scene.erls
        return scene.model_copy(update=own) == self.scene

    def _cost(self, run: Run, adaptive: bool) -> float:
        """Time for a simulated second; a fixed step's median, since other programs only add time."""
        total = run.step_time.sum() if adaptive else np.median(run.step_time) * len(run.step_time)
        return float(total) / max(run.time[-1], self.period)


def far(a: Array, b: Array) -> float:
    """The largest distance between two paths (K, 3), m."""
    return float(np.max(np.linalg.norm(a - b, axis=-1)))
