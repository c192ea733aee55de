"""One row: a scene with some keys replaced, run, and what is observed of it."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from flexsim_core.scene_files import SceneError, override, plain, read_scene

from .expression import Absent, Expression, ExpressionError, Series, Undefined
from .inputs import Input
from .study_file import Study
from .table import Row, key_of

ROBOT = frozenset({
    "position", "velocity", "torque", "x", "y", "z", "deflection", "energy", "loop_gap", "conditioning",
    "reading", "validity", "time",
})  # fmt: skip
DOOR = frozenset({
    "unexposed_mean", "unexposed_maximum", "furnace", "probe", "bow", "gap", "failure_time", "criterion",
    "held", "awarded", "verdict", "utilisation", "time",
})  # fmt: skip
KNOWN = {"robot": ROBOT, "fire_door": DOOR}
KINDS = ["insulation", "integrity", "radiation"]


@dataclass(frozen=True)
class Task:
    """A row to be run: its key in the table, what is varied, and the keys of the scene that it replaces."""

    key: str
    inputs: Mapping[str, Any]
    overrides: Mapping[str, Any]


@dataclass(frozen=True)
class Misasked:
    """A row whose scene does not have what is observed: of the first row a mistake of the study's."""

    row: Row


@dataclass(frozen=True)
class SceneRun:
    """Runs rows of one scene; picklable, and it reads no file of the scene's again."""

    kind: str
    document: Mapping[str, Any]
    source: str
    duration: float
    sample_period: float
    observe: Mapping[str, str]

    def __call__(self, task: Task) -> Row | Misasked:
        """Run a row; what is wrong with it is its reason."""
        try:
            outputs = RUNS[self.kind](self, task.overrides)
        except Exception as problem:  # one row's trouble is no other's
            expected = isinstance(problem, (ValueError, ArithmeticError, RuntimeError)) and str(problem)
            said = str(problem) if expected else f"unexpected {type(problem).__name__}: {problem}"
            # The same wherever it is run from: a merge compares reasons.
            return Row(task.key, task.inputs, None, said.replace(self.source, Path(self.source).name))
        observed: dict[str, Any] = {}
        for name, text in self.observe.items():
            try:
                observed[name] = Expression(text, KNOWN[self.kind])(outputs)
            except Undefined as problem:
                return Row(task.key, task.inputs, None, f"{name}: {problem}")
            except ExpressionError as problem:
                return Misasked(Row(task.key, task.inputs, None, f"observe: {name}: {problem}"))
        return Row(task.key, task.inputs, observed)


class Failed(RuntimeError):
    """A run that did not come to its end: why."""


def _robot(row: SceneRun, overrides: Mapping[str, Any]) -> dict[str, Any]:
    from flexsim_node import load_scene, simulate

    scene = load_scene(row.document, overrides)
    run = simulate(scene, duration=row.duration, sample_period=row.sample_period)
    if run.status != "ok":
        raise Failed(f"stopped at {run.time[-1]:g} s: {run.status}")
    joints, links = list(scene.joint_names), list(scene.link_names)
    ends = {name: n for n, node in enumerate(run.node_names) for name in [node.rpartition("/")[0]]}
    tip = links[scene.tips[0]]

    def series(values: Any) -> Series:
        return Series(run.time, np.asarray(values, float))

    def joint(values: Any) -> Callable[[Any], Series]:
        return lambda name: series(values[:, _place("joint", name, joints)])

    def end(axis: int) -> Callable[..., Series]:
        return lambda name=tip: series(run.link_end[:, _place("link", name, links), axis])

    def deflection(name: Any = tip) -> Series:
        """m between a link's end and where it would be on rigid links."""
        node = ends[_named("link", name, list(ends))]
        return series(np.linalg.norm(run.node_position[:, node] - run.rigid_position[:, node], axis=1))

    def reading(name: Any, column: Any = 0.0) -> Series:
        values = run.sensors[_named("sensor", name, list(run.sensors))]
        values = values.reshape(len(values), -1)
        return series(values[:, _place("column", column, list(range(values.shape[1])))])

    return {
        "time": series(run.time),
        "position": joint(run.joint_position),
        "velocity": joint(run.joint_velocity),
        "torque": joint(run.torque),
        "x": end(0), "y": end(1), "z": end(2),
        "deflection": deflection,
        "energy": series(run.energy),
        "loop_gap": series(run.loop_gap.max(axis=1, initial=0.0)),
        "conditioning": series(run.conditioning),
        "reading": reading,
        "validity": lambda name: float(run.validity[_named("figure", name, list(run.validity))]),
    }  # fmt: skip


def _door(row: SceneRun, overrides: Mapping[str, Any]) -> dict[str, Any]:
    from thermal_node import load_scene, simulate

    scene = load_scene({**row.document, "source": row.source}, overrides)
    run = simulate(scene, row.duration, row.sample_period)
    if not run.status.ok:
        at = f"stopped at {run.time[-1]:g} s: " if len(run.time) else ""
        raise Failed(f"{at}{run.status.reason}")
    criteria = {c.name: c for c in run.criteria}
    judged = [c for c in run.criteria if c.watched]

    def series(values: Any) -> Series:
        return Series(run.time, np.asarray(values, float))

    def of_a_shape(values: Any) -> Any:
        if values is None:
            return Absent("the scene computes no deformation; set deformation.model for bow and gap")
        return series(values)

    def failure_time(name: Any = None) -> float:
        """s at which a criterion, or the first that is judged, failed; inf where it holds to the end."""
        if name is None:
            times = [c.time_of_failure for c in judged]
        else:
            found = criteria[_named("criterion", name, list(criteria))]
            if not found.watched:
                raise ExpressionError(f"criterion {name!r} is not judged in this scene")
            times = [found.time_of_failure]
        return min((t for t in times if t is not None), default=math.inf)

    def held(kind: Any) -> float:
        """Minutes that the criteria of a kind have held, of every standard; those of the run at most."""
        _named("kind", kind, KINDS)
        these = [c for c in judged if c.kind.startswith(kind)]
        if not these:
            raise ExpressionError(f"no criterion of {kind} is judged in this scene")
        ends = [run.time[-1] if c.time_of_failure is None else c.time_of_failure for c in these]
        return float((min(ends) + 1e-6) / 60.0)

    def awarded(name: Any) -> bool:
        """Whether the verdict has a class of this name, whatever is said behind it."""
        classes = run.verdict.partition(":")[0].split(", ")
        return any(c == name or c.startswith(f"{name} by ") for c in classes)

    return {
        "time": series(run.time),
        "unexposed_mean": series(run.probes["unexposed_mean"]),
        "unexposed_maximum": series(run.probes["unexposed_maximum"]),
        "furnace": series(run.furnace),
        "probe": lambda name: series(run.probes[_named("probe", name, list(run.probes))]),
        "bow": of_a_shape(run.bow),
        "gap": of_a_shape(run.gap),
        "failure_time": failure_time,
        "criterion": lambda name: float(criteria[_named("criterion", name, list(criteria))].value),
        "held": held,
        "awarded": awarded,
        "verdict": run.verdict,
        "utilisation": Absent("no material of the leaf has a yield strength, or no shape was solved")
        if run.utilisation is None
        else float(run.utilisation.share),
    }  # fmt: skip


RUNS: dict[str, Callable[[SceneRun, Mapping[str, Any]], dict[str, Any]]] = {
    "robot": _robot,
    "fire_door": _door,
}


def _named(kind: str, name: Any, known: list[Any]) -> Any:
    if name not in known:
        import difflib

        near = difflib.get_close_matches(str(name), map(str, known), 1)
        listed = ", ".join(map(str, known[:30])) or "none"
        raise ExpressionError(
            f"no {kind} {name!r}; " + (f"did you mean {near[0]!r}?" if near else f"there are: {listed}")
        )
    return name


def _place(kind: str, name: Any, known: list[Any]) -> int:
    return known.index(_named(kind, name, known))


def scene_run(study: Study) -> SceneRun:
    """What runs the rows of a study; the scene's file is read once.

    Raises
    ------
    SceneError
        Where the scene can't be used, or an input or setting names a key that it can't have.
    """
    document = plain(read_scene(study.scene, "model, name, links or leaf"))
    for key, value in study.settings.items():
        override(document, key, plain(value), _tables(study.kind))
    work = SceneRun(
        study.kind, document, str(study.scene), study.duration, study.sample_period, study.observe
    )
    base = _loaded(work, {})
    for one in study.vary:
        middle = one.at(0.5)
        try:
            _loaded(work, overrides_of(document, (one,), {one.key: middle}))
        except SceneError as problem:
            # A value may be impossible and only fail its row; a key that is nowhere is a slip.
            if not _has(base, one.key):
                raise SceneError(f"{study.source}: vary: {one.key}: {problem}") from None
    return work


def _loaded(work: SceneRun, overrides: Mapping[str, Any]) -> dict[str, Any]:
    if work.kind == "robot":
        from flexsim_node import load_scene as robot

        return plain(robot(work.document, overrides).model_dump())
    from thermal_node import load_scene as door

    return plain(door({**work.document, "source": work.source}, overrides).model_dump())


def _tables(kind: str) -> tuple[str, ...]:
    if kind == "robot":
        return ()
    from thermal_node.scene.load import PROPERTIES

    return PROPERTIES


def _has(document: Any, key: str) -> bool:
    place = document
    for part in key.split("."):
        if isinstance(place, list):
            names = [entry.get("name") if isinstance(entry, dict) else None for entry in place]
            if part in names:
                place = place[names.index(part)]
            elif part.isdigit() and int(part) < len(place):
                place = place[int(part)]
            else:
                return False
        elif isinstance(place, dict) and part in place:
            place = place[part]
        else:
            return False
    return True


def overrides_of(
    document: Mapping[str, Any], inputs: tuple[Input, ...], point: Mapping[str, Any]
) -> dict[str, Any]:
    """Keys of the scene and their values; factors are multiplied with what the scene says."""
    found: dict[str, Any] = {}
    for one in inputs:
        value = point[one.key]
        found[one.key] = _times(_said(document, one.key), value, one.key) if one.scale else value
    return found


def _said(document: Any, key: str) -> Any:
    place = document
    for part in key.split("."):
        if isinstance(place, list):
            names = [entry.get("name") if isinstance(entry, dict) else None for entry in place]
            at = names.index(part) if part in names else int(part) if part.isdigit() else len(place)
            place = place[at] if at < len(place) else None
        else:
            place = place.get(part) if isinstance(place, dict) else None
    return place


def _times(said: Any, factor: float, key: str) -> Any:
    if isinstance(said, list):
        return [_times(v, factor, key) for v in said]
    if isinstance(said, (int, float)) and not isinstance(said, bool):
        return said * factor
    raise SceneError(
        f"{key}: scale needs a number or a list of numbers there, and the scene's file has {said!r}; give"
        " such a key, or values instead of scale"
    )


def tasks_of(
    work: SceneRun, inputs: tuple[Input, ...], points: list[dict[str, Any]], versions: Mapping[str, str]
) -> list[Task]:
    """Rows to be run for points, each with the key of all that it depends on."""
    said = {"kind": work.kind, "duration": work.duration, "sample_period": work.sample_period,
            "observe": dict(work.observe), "versions": dict(versions)}  # fmt: skip
    tasks = []
    for point in points:
        overrides = plain(overrides_of(work.document, inputs, point))
        whole = _copied(work.document)
        for key, value in overrides.items():
            override(whole, key, _copied(value), _tables(work.kind))
        run = {**said, "scene": whole, "log": _log(whole, work.source)}
        tasks.append(Task(key_of(run), plain(point), overrides))
    return tasks


def _copied(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _copied(v) for k, v in value.items()}
    return [_copied(v) for v in value] if isinstance(value, list) else value


def _log(document: Mapping[str, Any], source: str) -> str | None:
    """A hash of the furnace's log, which lies in a file of its own."""
    furnace = document.get("furnace")
    name = furnace.get("file") if isinstance(furnace, dict) else None
    if not isinstance(name, str):
        return None
    try:
        return hashlib.sha256((Path(source).parent / name).read_bytes()).hexdigest()
    except OSError:
        return "missing"
