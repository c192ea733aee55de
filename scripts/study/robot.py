"""The study of a robot: one motion of the scene, and its links ringing with the joints held."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from flexsim_node import Run, Scene, load_scene, natural_frequencies, simulate
from flexsim_node.motion.faults import COMMANDS, SENSORS
from flexsim_node.motion.jumps import torque_jumps
from flexsim_node.scene.variants import in_formulation

from .document import read_document
from .estimate import SAFETY, settle
from .motion import Motion, far
from .outlook import outlook, taken_alone
from .point import Array, Measure, Outcome, Point, Reference
from .ringing import ringing
from .robot_grid import STEPS, RobotGrid

SAMPLES = 100
FINER = 4
"""Samples of an error for each of the longest step."""
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
LEAST_FINEST = 8
"""Elements a link of the mesh at which a reference's steps are refined."""
MESH_STEP = 2.0
"""Step at which a reference's meshes are refined, as a multiple of the shortest one plotted."""
MOST_KINKS = 200
"""Rows of torque tables at which the reference's steps end."""


class RobotStudy:
    """Work and precision of a robot scene.

    sines : joint name to (amplitude in N m or N, frequency in Hz) of a sine torque
    vary : further axes, a scene key to its values
    quick : the smallest grid that still shows something
    finer : times that the reference's steps are halved and its mesh doubled beyond what is usual

    The file is read once.  Effects that it leaves to `auto` are on; where it leaves the formulation to that,
    the study is in co-moving frames, which hold however far links turn, if they take the scene.
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
        finer: int = 0,
    ) -> None:
        self.path, self.given = path, dict(overrides)
        self.sines, self.vary, self.quick, self.finer = dict(sines), dict(vary), quick, finer
        scene = load_scene(path, self.given)  # which says what is wrong with the file, and where
        self.document = read_document(path)
        self.opened = scene.effects.undecided
        self.left_open = scene.formulation == "auto"
        if self.opened:
            switches = {n: value == "auto" or value for n, value in scene.effects}
            self.given = {k: v for k, v in self.given.items() if k.partition(".")[0] != "effects"}
            self.given["effects"] = switches
        self.others: dict[str, dict[str, Any]] = {}
        self.taken = ""
        if self.left_open:
            self._take_formulation()
        self.scene = load_scene(self.document, self.given)
        unknown = [name for name in sines if name not in self.scene.joint_names]
        if unknown:
            raise ValueError(
                f"--sine {unknown[0]}: no such joint; there are {', '.join(self.scene.joint_names)}"
            )
        # Every step of the grid divides the time between samples, so that none is shortened.
        self.period = STEPS[0] * max(1, round(duration / SAMPLES / STEPS[0]))
        self.duration = self.period * max(1, round(duration / self.period))
        # A command comes with every sample: there, all runs take the same ones.
        commanded = any(f.kind in COMMANDS or f.kind == "lag" for f in self.scene.faults)
        self.sample = self.period if commanded or self.scene.faults else self.period / FINER
        self.grid = RobotGrid(
            self.document, self.given, self.scene, self.period, self.vary, quick, self.others, self.left_open
        )

    def _take_formulation(self) -> None:
        """Begin in co-moving frames, or with the ERLS where they don't take the scene, and say which."""
        scene = load_scene(self.document, self.given)
        zeroed = scene.model_dump(mode="json")["erls"]["zeroed"]
        try:
            in_formulation(scene, "co_moving")
        except ValueError as problem:
            self.given["formulation"] = "erls"
            self.taken = f"The formulation is left to auto; this study is in erls, for {problem}."
            return
        self.given["formulation"] = "co_moving"
        if zeroed == "chord":
            self.given["erls.zeroed"] = "auto"
            self.others["erls"] = {"erls.zeroed": zeroed}
        self.taken = (
            "The formulation is left to auto: the reference is in co_moving, and each point says which it"
            " has."
        )

    @property
    def changes(self) -> dict[str, Any]:
        """What the study changes in the scene, whatever its choice."""
        return dict(self.given)

    @property
    def fingerprint(self) -> dict[str, Any]:
        return {
            "scene": self.scene.model_dump(mode="json", exclude={"source"}),
            "duration": self.duration,
            "sines": {k: list(v) for k, v in self.sines.items()},
            "vary": self.vary,
            "quick": self.quick,
            "finer": self.finer,
            **({"formulation": "auto"} if self.left_open else {}),
        }

    def points(self) -> list[Point]:
        """The grid."""
        return self.grid.points()

    # Runs

    def scene_with(self, overrides: Mapping[str, Any]) -> Scene:
        """The scene with overrides, and without the faults of sensors, which move nothing."""
        scene = load_scene(self.document, {**self.given, **overrides})
        return scene.model_copy(update={"faults": tuple(f for f in scene.faults if f.kind not in SENSORS)})

    def _torque(self, t: float) -> Array:
        out = np.zeros(len(self.scene.joint_names))
        for name, (amplitude, frequency) in self.sines.items():
            out[self.scene.joint_names.index(name)] = amplitude * np.sin(2.0 * np.pi * frequency * t)
        return out

    def move(
        self,
        scene: Scene,
        duration: float | None = None,
        exact: bool = False,
        louder: float = 1.0,
        sample: float | None = None,
    ) -> Run:
        """Run the motion.

        exact : with every jump, kink and fault at a step's end; louder : times the torques
        """
        duration = self.duration if duration is None else duration
        sample = sample or (self.sample if exact else self.sample_of(scene))
        torque: Callable[[float], Array] | None = None
        jumps: list[float] = []
        if self.sines:
            torque = self._torque if louder == 1.0 else lambda t: louder * self._torque(t)
        else:
            kinks = torque_jumps(scene, kinks=True)
            jumps = kinks if exact and len(kinks) <= MOST_KINKS else []
            if louder != 1.0 and scene.torque:
                entries = tuple(
                    e.model_copy(
                        update={
                            "amplitude": louder * e.amplitude,
                            "offset": louder * e.offset,
                            "value": tuple(louder * v for v in e.value),
                        }
                    )
                    for e in scene.torque
                )
                scene = scene.model_copy(update={"torque": entries})
        faults = exact and bool(scene.faults)
        return simulate(scene, torque, duration, sample_period=sample, jumps=jumps, exact_faults=faults)

    def sample_of(self, scene: Scene) -> float:
        """The shortest time between samples that this scene's step divides."""
        for parts in (FINER, FINER // 2):
            sample = self.period / parts
            steps = sample / scene.solver.step
            if sample >= self.sample and steps > 1.0 - 1e-9 and abs(steps - round(steps)) < 1e-6:
                return sample
        return self.period

    def motion(self, run: Run) -> Motion:
        """The tips and joints of a run."""
        return Motion(run.link_end[:, list(self.scene.tips)], run.joint_position)

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
            run = simulate(
                scene, None, rise + RINGS / slowest, sample_period=sample, prescribed=moved, jumps=[rise]
            )
        except ValueError:
            return None
        heard = run.time >= rise - 1e-9
        if run.status != "ok" or heard.sum() < 40:
            return None
        tips = run.link_end[heard][:, list(self.scene.tips)].reshape(int(heard.sum()), -1)
        try:
            return ringing(tips, sample, near)
        except (ValueError, np.linalg.LinAlgError):
            return None

    # Reference

    def reference(self, progress: Callable[[str], None]) -> Reference:
        """Twice the finest mesh of the scene's own formulation, and two methods without error of the step.

        Two families of steps that share none, one a method, each of four; the mesh likewise.  Each
        order is measured.  The bound is SAFETY times the largest sign of an error: what extrapolation still
        changes, what the two methods differ by, and what the mesh leaves.  Steps end at every jump and kink
        of the torque and at every fault.  The other formulations are taken to their own end likewise: how
        far they then are is what their model changes.
        """
        finest = max(LEAST_FINEST, 2 * self.grid.elements[-1]) * 2**self.finer
        base = STEPS[-1] / 2**self.finer
        fine, half = self.grid.meshed(finest), self.grid.meshed(finest // 2)
        families = {"rosenbrock_w": base, "generalized_alpha": 4.0 / 3.0 * base}
        runs: dict[str, Motion] = {}
        orders: dict[str, float] = {}

        def moved(method: str, h: float, changed: dict[str, Any]) -> Motion:
            key = f"{method} {h!r} {sorted(changed.items(), key=str)}"
            if key not in runs:
                said = f", {changed['formulation']}" if "formulation" in changed else ""
                progress(f"reference: {method}, {h:.3g} s{said}")
                scene = self.scene_with({**changed, "solver.method": method, "solver.step": h})
                run = self.move(scene, exact=True)
                if run.status != "ok":
                    raise ValueError(f"the reference {run.status}; study a motion that the scene can do")
                runs[key] = self.motion(run)
            return runs[key]

        def without_steps(method: str, changed: dict[str, Any]):
            h = families[method]
            return settle([moved(method, h / n, changed) for n in (0.5, 1, 2, 4)], 2.0)

        def both(changed: dict[str, Any], where: str) -> tuple[Motion, Array]:
            """The best without error of the step, and the largest sign of its error."""
            one, other = (without_steps(m, changed) for m in families)
            for name, found in zip(families, (one, other), strict=True):
                orders[f"{name}{where}"] = float(found.order[0])
            return one.best, np.maximum(one.error, one.best.apart(other.best))

        def mesh(best: Motion, changed: dict[str, Any], order: int) -> tuple[Motion, Array]:
            """The same without the mesh's error as far as it can be taken out, and what may be left.

            Meshes up to four times finer are compared at a longer step, so that they cost little more than
            the runs above; how far that step changes the comparison is part of what may be left.
            """
            if not self.grid.flexible:
                return best, np.zeros(2)
            meshes = [half, fine, self.grid.meshed(2 * finest), self.grid.meshed(4 * finest)]
            several = [moved("rosenbrock_w", MESH_STEP * base, {**changed, **m}) for m in meshes]
            found = settle(several, float(order))
            name = changed.get("formulation", self.scene.formulation)
            orders[f"mesh, {name}"] = float(found.order[0])
            coarse, near = (moved("rosenbrock_w", base / 2.0, {**changed, **m}) for m in (half, fine))
            crossed = near.apart(several[1].shifted(several[0], coarse))
            return best.shifted(several[1], found.best), found.error + crossed

        own = self.scene.formulation
        best, steps = both(fine, "")
        best, left = mesh(best, {}, MESH_ORDER[own])
        error = SAFETY * (steps + left)
        same, same_error = both({}, ", own mesh") if self.grid.flexible else (best, steps)
        arrays = {"tip": best.tip, "angle": best.angle, f"time_{own}": same.tip}
        bounds = {
            "tip": float(error[0]),
            "angle": float(error[1]),
            "time": float(SAFETY * same_error[0]),
        }
        finest_step = base / 4.0
        how = (
            f"rosenbrock_w and generalized_alpha without error of the step, steps down to {finest_step:.3g} s"
            " that end at every jump"
        )
        if self.grid.flexible:
            how += f", meshes of {finest // 2} to {4 * finest} elements a link"
        formulations: dict[str, dict[str, Any]] = {}
        for name, changed in self.grid.other_formulations().items():
            refused = self.grid.refusal(changed)
            if refused or not self.grid.flexible:
                formulations[name] = {"refused": refused or "nothing bends"}
                continue
            try:
                there = without_steps("rosenbrock_w", {**changed, **fine})
                end, rest = mesh(there.best, changed, MESH_ORDER[name])
                along = without_steps("rosenbrock_w", changed)
            except ValueError as problem:
                formulations[name] = {"refused": str(problem)}
                continue
            off = SAFETY * (there.error + rest)
            arrays[f"time_{name}"] = along.best.tip
            arrays[f"tip_{name}"], arrays[f"angle_{name}"] = end.tip, end.angle
            bounds[f"tip_{name}"], bounds[f"angle_{name}"] = float(off[0]), float(off[1])
            formulations[name] = {
                "distance": float(end.apart(best)[0]),
                "uncertainty": float(off[0] + error[0]),
            }
        self._ringing(progress, arrays, bounds, fine, half, base)
        steps_count = "steps" if not self.grid.flexible else (
            "steps" if steps[0] > left[0] else "mesh")  # fmt: skip
        finer = (
            f"its {steps_count} limit it: --finer {self.finer + 1} halves the steps and doubles the mesh"
            if math.isfinite(bounds["tip"])
            else f"its {steps_count} have not settled: --finer {self.finer + 1}, or a shorter or smoother"
            " motion"
        )
        return Reference(arrays, bounds, how, formulations, finer, orders)

    def _ringing(
        self,
        progress: Callable[[str], None],
        arrays: dict[str, Array],
        bounds: dict[str, float],
        fine: dict[str, Any],
        half: dict[str, Any],
        step: float,
    ) -> None:
        """Add how the links ring, where they do."""

        def rung(method: str, mesh: dict[str, Any], near: float | None, h: float) -> Array | None:
            scene = self.scene_with({**mesh, "solver.method": method, "solver.step": h})
            found = self._ring(scene, near)
            return None if found is None else np.array(found)

        progress("reference: the links ring")
        first = rung("rosenbrock_w", fine, None, step / 2.0)
        if first is None:
            return
        near = float(first[0])
        others = [
            rung("generalized_alpha", fine, near, step / 2.0),
            rung("rosenbrock_w", half, near, step / 2.0),
            rung("rosenbrock_w", fine, near, step),
        ]
        if all(r is not None for r in others):
            arrays["ringing"] = first
            own = SAFETY * np.max([np.abs(first - r) for r in others if r is not None], axis=0)
            bounds["frequency"] = float(own[0] / first[0])
            bounds["decay"] = float(own[1] / max(abs(first[1]), 1e-9))

    # Points

    def measure(self, point: Point, reference: Reference) -> Outcome:
        """Run a point: its errors against its own formulation's end, and its time by repetition."""
        outcome = Outcome(point.name, point.curve, point.size, dict(point.overrides), "ok")
        outcome.effect = point.effect
        try:
            scene = self.scene_with(point.overrides)
            outcome.model = scene.formulation
            self.move(scene, 0.0)
            probe = self.move(scene, max(self.period, PROBE * self.duration))
            adaptive = scene.solver.method in ("radau", "dop853")
            took = self._cost(probe, adaptive) * self.duration if probe.status == "ok" else 0.0
            if probe.status == "ok" and took > LIMIT:
                outcome.status = f"left out: would take {took:.0f} s"
                return outcome
            run = self.move(scene)
        except ValueError as problem:
            outcome.status = str(problem)
            return outcome
        if run.status != "ok":
            outcome.status = run.status
            return outcome
        runs = [run]
        if took <= 0.2 * LIMIT:
            runs += [self.move(scene) for _ in range(REPEATS - 1)]
        outcome.seconds = [self._cost(r, adaptive) for r in runs]
        if not adaptive:
            outcome.late = [late(r) for r in runs]
        outcome.step = None if adaptive else self.duration / len(run.step_time)
        outcome.errors.update(self.errors(run, scene, reference))
        right = reference.arrays.get("ringing")
        ring = None if right is None or adaptive else self._ring(scene, float(right[0]))
        if ring is not None and right is not None:
            outcome.errors["frequency"] = abs(ring[0] / right[0] - 1.0)
            outcome.errors["decay"] = abs(ring[1] - right[1]) / max(abs(right[1]), 1e-9)
        return outcome

    def errors(self, run: Run, scene: Scene, reference: Reference) -> dict[str, float | None]:
        """How far a run is from the end of its own formulation."""
        found: dict[str, float | None] = {}
        moved = self.motion(run)
        suffix = f"_{scene.formulation}" if f"tip_{scene.formulation}" in reference.arrays else ""
        tip, angle = (reference.arrays[f"{name}{suffix}"] for name in ("tip", "angle"))
        every = (len(tip) - 1) // max(len(moved.tip) - 1, 1)
        found["tip"] = far(moved.tip, tip[::every])
        found["angle"] = float(np.max(np.abs(moved.angle - angle[::every])))
        same = reference.arrays.get(f"time_{scene.formulation}")
        if same is not None and self._same_physics(scene):
            found["time"] = far(moved.tip, same[::every])
        return found

    def conditions(self, outcome: Outcome, reference: Reference, tolerance: float | None) -> dict[str, Any]:
        """How the error of the choice grows with duration, what it is nearby, and its times taken alone."""
        found = outlook(self, outcome, tolerance)
        found["alone"] = taken_alone(self, outcome)
        return found

    def _same_physics(self, scene: Scene) -> bool:
        """Whether nothing but the integrator, and the formulation, is not the scene's own."""
        own = {name: getattr(self.scene, name) for name in ("solver", "formulation", "faults")}
        if scene.formulation != self.scene.formulation:
            own["erls"] = self.scene.erls
        return scene.model_copy(update=own) == self.scene

    def _cost(self, run: Run, adaptive: bool) -> float:
        """Time for a simulated second; a fixed step's median, since other programs only add time."""
        total = run.step_time.sum() if adaptive else np.median(run.step_time) * len(run.step_time)
        return float(total) / max(run.time[-1], self.period)


def late(run: Run) -> float:
    """The 99th percentile of a run's steps over their median."""
    p50, p99 = np.quantile(run.step_time, [0.5, 0.99])
    return float(p99 / max(p50, 1e-12))
