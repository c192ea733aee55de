"""The study of a robot: one motion of the scene, and its links ringing with the joints held."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, get_args

import numpy as np

from flexsim_node import Run, Scene, load_scene, natural_frequencies, simulate

from .point import Array, Measure, Outcome, Point, Reference
from .ringing import ringing

REAL_TIME = ("rosenbrock_w", "generalized_alpha")
STEPS = (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4)
EXPLICIT_STEPS = (5e-5, 2e-5, 1e-5, 5e-6, 2e-6)
TOLERANCES = (1e-3, 1e-5, 1e-7)
ELEMENTS = (1, 2, 4, 8)
VARIANT_STEPS = (2e-3, 1e-3, 5e-4)
EFFECT_STEP = 1e-3
SAMPLES = 100
RINGS = 8
"""Periods of the slowest vibration that are listened to."""
PUSH = 0.02
"""rad or m that every joint is moved to make the links ring."""
REPEATS = 3
LIMIT = 60.0
"""s that one run of a point may take."""
PROBE = 0.02
"""Part of a run that tells how long the whole would take."""


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

    @property
    def fingerprint(self) -> dict[str, Any]:
        return {
            "scene": self.scene.model_dump(mode="json", exclude={"source"}),
            "duration": self.duration,
            "sines": {k: list(v) for k, v in self.sines.items()},
            "vary": self.vary,
            "quick": self.quick,
        }

    # The grid

    @property
    def _flexible(self) -> list[int]:
        links = enumerate(self.scene.links)
        return [k for k, link in links if link.beam is not None and link.flexible]

    def _meshed(self, elements: int) -> dict[str, Any]:
        return {f"links.{k}.beam.elements": elements for k in self._flexible}

    def points(self) -> list[Point]:
        """Integrators by steps by elements; then each effect, formulation and reduction of its own."""
        found: list[Point] = []
        steps = STEPS[1:4] if self.quick else STEPS
        elements = (ELEMENTS[:2] if self.quick else ELEMENTS) if self._flexible else (0,)

        def add(curve: str, size: float, overrides: dict[str, Any]) -> None:
            found.append(Point(curve, size, overrides))

        for n in elements:
            mesh, said = self._meshed(n), f", {n} element{'s' * (n != 1)} a link" if n else ""
            for method in REAL_TIME:
                for step in steps:
                    add(f"{method}{said}", step, {"solver.method": method, "solver.step": step, **mesh})
        if not self.quick:
            for step in EXPLICIT_STEPS:
                add("runge_kutta_4", step, {"solver.method": "runge_kutta_4", "solver.step": step})
            for method in ("radau", "dop853"):
                for tolerance in TOLERANCES:
                    add(
                        method,
                        tolerance,
                        {
                            "solver.method": method,
                            "solver.step": self.period,
                            "solver.relative_tolerance": tolerance,
                            "solver.absolute_tolerance": 1e-2 * tolerance,
                        },
                    )
        for said, overrides in self._variants():
            for step in steps[:1] if self.quick else VARIANT_STEPS:
                add(said, step, {"solver.step": step, **overrides})
        for said, overrides in self._effects():
            found.append(Point(said, EFFECT_STEP, {"solver.step": EFFECT_STEP, **overrides}, effect=True))
        return found

    def _effects(self) -> list[tuple[str, dict[str, Any]]]:
        """Each effect the other way round."""
        found: list[tuple[str, dict[str, Any]]] = []
        for name, value in self.scene.effects:
            if isinstance(value, bool):
                found.append((f"{name} {'off' if value else 'on'}", {f"effects.{name}": not value}))
        return found[:3] if self.quick else found

    def _variants(self) -> list[tuple[str, dict[str, Any]]]:
        """Each choice that the scene's schema offers beside integrator, step and mesh, one at a time."""
        scene = self.scene
        found: list[tuple[str, dict[str, Any]]] = []
        zeroed = scene.erls.zeroed
        found += [(f"zeroed: {s}", {"erls.zeroed": s}) for s in ("root", "chord") if s != zeroed]
        fields = type(scene).model_fields
        if "formulation" in fields:
            choices = [c for c in get_args(fields["formulation"].annotation) if isinstance(c, str)]
            now = getattr(scene, "formulation", None)
            found += [(f"formulation: {c}", {"formulation": c}) for c in choices if c != now]
        if "reduction" in fields and self._flexible:
            found += [(f"reduction: {n} modes", {"reduction": {"modes": n}}) for n in (1, 2, 4)]
        for key, values in self.vary.items():
            found += [(f"{key}={value}", {key: value}) for value in values]
        return found[:1] if self.quick else found

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
        if not self._flexible:
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
        """Twice the finest mesh, both real-time methods extrapolated to no step (Richardson).

        The error of the step is what the two differ by; that of the mesh is a fifteenth of what half
        as many elements change, for cubic beams' fourth order.
        """
        finest = 2 * (ELEMENTS[1] if self.quick else ELEMENTS[-1])
        step = (STEPS[3] if self.quick else STEPS[-1]) / 2.0

        def extrapolated(method: str, mesh: dict[str, Any]) -> tuple[Array, Array]:
            both = []
            for h in (step, step / 2.0):
                progress(f"reference: {method}, {h:g} s" + (f", {mesh_said(mesh)}" if mesh else ""))
                run = self._move(self._scene({**mesh, "solver.method": method, "solver.step": h}))
                if run.status != "ok":
                    raise ValueError(f"the reference {run.status}; study a motion that the scene can do")
                both.append((run.link_end[:, -1], run.joint_position))
            (tip1, angle1), (tip2, angle2) = both
            return (4.0 * tip2 - tip1) / 3.0, (4.0 * angle2 - angle1) / 3.0

        fine, half = self._meshed(finest), self._meshed(finest // 2)
        tip, angle = extrapolated("rosenbrock_w", fine)
        tip_b, angle_b = extrapolated("generalized_alpha", fine)
        own_tip, own_angle = far(tip, tip_b), float(np.max(np.abs(angle - angle_b)))
        how = f"rosenbrock_w and generalized_alpha extrapolated from {step:g} and {step / 2:g} s"
        if self._flexible:
            coarse, coarse_angle = extrapolated("rosenbrock_w", half)
            own_tip += far(tip, coarse) / 15.0
            own_angle += float(np.max(np.abs(angle - coarse_angle))) / 15.0
            how += f", {finest} elements a link against {finest // 2}"
        same_a, _ = extrapolated("rosenbrock_w", {})
        same_b, _ = extrapolated("generalized_alpha", {})
        arrays = {"tip": tip, "angle": angle, "time": same_a}
        error = {"tip": own_tip, "angle": own_angle, "time": far(same_a, same_b)}

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
        return Reference(arrays, error, how)

    # Points

    def measure(self, point: Point, reference: Reference) -> Outcome:
        """Run a point: its errors, and its time by repetition."""
        outcome = Outcome(point.name, point.curve, point.size, dict(point.overrides), "ok")
        outcome.effect = point.effect
        try:
            scene = self._scene(point.overrides)
            self._move(scene, 0.0)
            probe = self._move(scene, max(self.period, PROBE * self.duration))
            took = float(probe.step_time.sum()) * self.duration / max(probe.time[-1], self.period)
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
        adaptive = scene.solver.method in ("radau", "dop853")
        repeats = 1 if took > 0.2 * LIMIT else REPEATS
        outcome.seconds = [self._cost(run, adaptive)]
        outcome.seconds += [self._cost(self._move(scene), adaptive) for _ in range(repeats - 1)]
        outcome.step = None if adaptive else self.duration / len(run.step_time)
        tip = run.link_end[:, -1]
        outcome.errors["tip"] = far(tip, reference.arrays["tip"])
        outcome.errors["angle"] = float(np.max(np.abs(run.joint_position - reference.arrays["angle"])))
        if self._same_physics(scene):
            outcome.errors["time"] = far(tip, reference.arrays["time"])
        right = reference.arrays.get("ringing")
        ring = None if right is None or adaptive else self._ring(scene, float(right[0]))
        if ring is not None and right is not None:
            outcome.errors["frequency"] = abs(ring[0] / right[0] - 1.0)
            outcome.errors["decay"] = abs(ring[1] - right[1]) / max(abs(right[1]), 1e-9)
        return outcome

    def _same_physics(self, scene: Scene) -> bool:
        return scene.model_copy(update={"solver": self.scene.solver}) == self.scene

    def _cost(self, run: Run, adaptive: bool) -> float:
        """Time for a simulated second; a fixed step's median, since other programs only add time."""
        total = run.step_time.sum() if adaptive else np.median(run.step_time) * len(run.step_time)
        return float(total) / self.duration


def mesh_said(mesh: Mapping[str, Any]) -> str:
    """For example 8 elements a link."""
    return f"{next(iter(mesh.values()))} elements a link"


def far(a: Array, b: Array) -> float:
    """The largest distance between two paths (K, 3), m."""
    return float(np.max(np.linalg.norm(a - b, axis=-1)))
