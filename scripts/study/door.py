"""The study of a fire door: its unexposed face over the test, and when it fails."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from thermal_node import Run, load_scene, simulate

from .document import read_document
from .estimate import LEAST_ORDER, SAFETY
from .point import Measure, Outcome, Point, Reference

QUIET = {"deformation.model": "none"}
TOLERANCES = (1.0, 0.3, 0.1, 0.03, 0.01)
STEPS = (60.0, 30.0, 20.0, 10.0, 5.0)
METHODS = ("tr_bdf2", "sdirk2", "implicit_euler")
REPEATS = 3
LIMIT = 120.0
COARSER = 0.7
"""Part of the bricks that a reference's mesh keeps from one to the next."""


class DoorStudy:
    """Work and precision of a fire door's scene.

    vary : further axes, a scene key to its values; quick : the smallest grid that shows something
    finer : times that the reference's mesh is half as fine again beyond what is usual

    The file is read once.
    """

    kind = "fire_door"
    measures = (
        Measure("unexposed", "unexposed temperatures", "K"),
        Measure("exposed", "exposed face, middle", "K"),
        Measure("failure", "time at which a criterion falls", "s"),
    )

    def __init__(
        self,
        path: str,
        overrides: Mapping[str, Any],
        duration: float,
        vary: Mapping[str, list[Any]],
        quick: bool = False,
        finer: int = 0,
    ) -> None:
        self.path, self.duration = path, duration
        self.changes = dict(overrides)
        self.given = {**QUIET, **overrides}
        self.vary, self.quick, self.finer = dict(vary), quick, finer
        self.scene = load_scene(path, self.given)
        self.document = read_document(path)
        self.period = min(60.0, duration / 10.0)

    @property
    def fingerprint(self) -> dict[str, Any]:
        return {
            "scene": self.scene.model_dump(mode="json", exclude={"source"}),
            "duration": self.duration,
            "vary": self.vary,
            "quick": self.quick,
            "finer": self.finer,
        }

    def _scaled(self, in_plane: float, through: float) -> dict[str, Any]:
        """The scene's mesh with so many times the bricks."""
        from thermal_node.mesh.door import THICK_BRICKS

        scene = self.scene
        counts = scene.mesh.layers or tuple(
            layer.bricks(THICK_BRICKS[scene.solver.dimension]) for layer in scene.leaf.layers
        )
        found: dict[str, Any] = {"mesh.layers": [max(1, round(n * through)) if n > 1 else 1 for n in counts]}
        if scene.solver.dimension != "column":
            found["mesh.in_plane"] = [max(4, round(n * in_plane)) for n in scene.mesh.in_plane]
        return found

    def points(self) -> list[Point]:
        """Models and meshes by tolerance, methods by step."""
        found: list[Point] = []
        models = {"full": ("column", "column_rim", "full"), "column_rim": ("column", "column_rim")}
        own = self.scene.solver.model
        tolerances = TOLERANCES[1:4] if self.quick else TOLERANCES
        for model in models.get(own, (own,)):
            for tolerance in tolerances:
                found.append(
                    Point(
                        f"{model}, tr_bdf2, adaptive",
                        tolerance,
                        {"solver.model": model, "solver.step": "auto", "solver.method": "tr_bdf2",
                         "solver.tolerance": tolerance},
                    )
                )  # fmt: skip
        for method in METHODS[:1] if self.quick else METHODS:
            for step in STEPS[:3] if self.quick else STEPS:
                overrides = {"solver.method": method, "solver.step": step}
                found.append(Point(f"{own}, {method}", step, overrides))
        meshes = ((0.5, 1.0), (1.0, 0.5)) if self.quick else (
            (0.5, 0.5), (0.5, 1.0), (1.0, 0.5), (1.0, 2.0), (1.5, 1.0), (1.5, 2.0))  # fmt: skip
        for in_plane, through in meshes:
            mesh = self._scaled(in_plane, through)
            if own == "column" and in_plane != 1.0:
                continue
            layers = " + ".join(map(str, mesh["mesh.layers"]))
            across = " x ".join(map(str, mesh.get("mesh.in_plane", [])))
            said = f"{own}, {across + ' x ' if across else ''}{layers} bricks"
            found.append(Point(said, self.scene.solver.tolerance, mesh))
        for key, values in self.vary.items():
            found += [Point(f"{key}={value}", self.scene.solver.tolerance, {key: value}) for value in values]
        return found

    def _burn(self, overrides: Mapping[str, Any]) -> tuple[Run, float]:
        begun = time.process_time()
        run = simulate(load_scene(self.document, {**self.given, **overrides}), self.duration, self.period)
        return run, time.process_time() - begun

    def _read(self, run: Run) -> dict[str, np.ndarray]:
        """Readings (P, K) of the probes on the unexposed face, the exposed middle, times of failure."""
        thickness = self.scene.leaf.thickness
        from thermal_node import probes_of

        probes = probes_of(run.model)
        names = [n for n, p in zip(probes.name, probes.position, strict=True) if p[2] > thickness - 1e-9]
        falls = [math.inf if c.time_of_failure is None else c.time_of_failure for c in run.criteria]
        return {
            "unexposed": np.array([run.probes[n] for n in names]),
            "exposed": run.temperature[:, 0][None],
            "failure": np.array(falls),
        }

    def reference(self, progress: Callable[[str], None]) -> Reference:
        """A finer mesh at a tenth of the tolerance, its error bounded by three meshes and another method.

        What the mesh leaves follows from the order that three meshes show, each 0.7 times as fine as the one
        before; what the march does, from SDIRK2 with a hundredth of the steps' length and from half of those,
        on the strip where the leaf is full.  The bound is SAFETY times their sum.  How far a cheaper model is
        from `full` is measured too: no mesh takes that away.
        """
        full = self.scene.solver.model in ("full", "steady")
        scale = (1.25 if self.quick else 1.5 if full else 5.0) * 1.5**self.finer
        tight = {"solver.step": "auto", "solver.method": "tr_bdf2",
                 "solver.tolerance": 0.1 * self.scene.solver.tolerance}  # fmt: skip
        first = self.scene.mesh.first_brick

        def finer(factor: float) -> dict[str, Any]:
            return {**self._scaled(factor, 2.0 * factor), "mesh.first_brick": first / factor}

        fine = finer(scale)
        progress("reference: " + " x ".join(map(str, fine.get("mesh.in_plane", fine["mesh.layers"]))))
        run, _ = self._burn({**tight, **fine})
        if not run.status.ok:
            raise ValueError(f"the reference {run.status.reason}")
        best = self._read(run)
        coarser = []
        for factor in (COARSER, COARSER**2):
            progress(f"reference: the same, {factor:.2g} times as fine")
            coarser.append(self._read(self._burn({**tight, **finer(factor * scale)})[0]))
        strip = {"solver.model": "column_rim"} if self.scene.solver.model == "full" else {}
        step = self.duration / (360.0 if self.quick else 1800.0)
        progress(f"reference: sdirk2, {step:g} s")
        one = self._read(self._burn({**tight, **strip})[0])
        others = [
            self._read(self._burn({**strip, "solver.method": "sdirk2", "solver.step": h})[0])
            for h in (step, 2.0 * step)
        ]
        own, orders = {}, {}
        for name in best:
            far, near = _apart(coarser[0][name], coarser[1][name]), _apart(best[name], coarser[0][name])
            mesh, orders[f"mesh, {name}"] = _left_by_mesh(far, near)
            march = max(_apart(one[name], others[0][name]), _apart(others[0][name], others[1][name]))
            own[name] = SAFETY * (mesh + march)
        how = (
            f"mesh {scale:g} times finer in plane and {2 * scale:g} times through, a tenth of the tolerance;"
            f" against meshes 0.7 and 0.49 times as fine, and SDIRK2 with steps of {step:g} s and twice that"
        )
        models = self._models(progress, best, own)
        finer_said = f"--finer {self.finer + 1} makes its mesh half as fine again"
        return Reference(
            best, own, how, models, finer_said, {k: v for k, v in orders.items() if math.isfinite(v)}
        )

    def _models(
        self, progress: Callable[[str], None], best: dict[str, np.ndarray], own: dict[str, float]
    ) -> dict[str, dict[str, Any]]:
        """How far the scene's model is from `full`, which knows all of the leaf."""
        model = self.scene.solver.model
        if model not in ("column", "column_rim"):
            return {}
        progress("reference: the full leaf")
        try:
            run, _ = self._burn({"solver.model": "full", "solver.step": "auto", "solver.method": "tr_bdf2"})
        except ValueError as problem:
            return {"full": {"refused": str(problem)}}
        if not run.status.ok:
            return {"full": {"refused": run.status.reason}}
        read = self._read(run)
        if read["unexposed"].shape != best["unexposed"].shape:
            # The strip is read at fewer places: each of them is held against every one of the leaf.
            apart = max(min(_apart(row, other) for row in best["unexposed"]) for other in read["unexposed"])
        else:
            apart = _apart(read["unexposed"], best["unexposed"])
        return {"full": {"distance": apart, "uncertainty": own["unexposed"]}}

    def conditions(self, outcome: Outcome, reference: Reference, tolerance: float | None) -> dict[str, Any]:
        """Nothing further: a test has its duration, and its time is that of the whole."""
        return {}

    def measure(self, point: Point, reference: Reference) -> Outcome:
        """Run a point: its errors, and its processor time by repetition."""
        outcome = Outcome(point.name, point.curve, point.size, dict(point.overrides), "ok")
        try:
            run, first = self._burn(point.overrides)
        except ValueError as problem:
            outcome.status = str(problem)
            return outcome
        if not run.status.ok:
            outcome.status = run.status.reason
            return outcome
        repeats = 1 if first > LIMIT / REPEATS else REPEATS
        outcome.seconds = [first] + [self._burn(point.overrides)[1] for _ in range(repeats - 1)]
        solver = load_scene(self.document, {**self.given, **point.overrides}).solver
        outcome.step, outcome.model = solver.step, solver.model
        read = self._read(run)
        for name, right in reference.arrays.items():
            if read[name].shape == right.shape:
                error = _apart(read[name], right)
                outcome.errors[name] = error if math.isfinite(error) else None
        return outcome


def _left_by_mesh(far: float, near: float) -> tuple[float, float]:
    """What a mesh leaves, and the order shown, from what two refinements of 1 / COARSER change."""
    if near == 0.0 or not math.isfinite(near):
        return near, 2.0
    if not math.isfinite(far):
        return math.inf, math.nan
    order = math.log(far / near) / math.log(1.0 / COARSER) if far > 0.0 else -math.inf
    if order < LEAST_ORDER:
        # no fall seen: what the coarser ones differ by is left
        return max(far, near) / (COARSER**-LEAST_ORDER - 1.0), order
    order = min(order, 2.0)
    return max(near, far * COARSER**order) / (COARSER**-order - 1.0), order


def _apart(a: np.ndarray, b: np.ndarray) -> float:
    """The largest difference; both infinite is none, one infinite is infinite."""
    if a.shape != b.shape or a.size == 0:
        return math.inf
    same = np.isinf(a) & np.isinf(b)
    with np.errstate(invalid="ignore"):
        return float(np.max(np.where(same, 0.0, np.abs(a - b))))
