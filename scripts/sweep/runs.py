"""One row: a scene with some keys replaced, run, and what is observed of it."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from .expression import Absent, Expression, ExpressionError, Series, Undefined
from .table import Row

ROBOT = frozenset({
    "position", "velocity", "torque", "x", "y", "z", "deflection", "energy", "loop_gap", "conditioning",
    "reading", "validity", "time",
})  # fmt: skip
DOOR = frozenset({
    "unexposed_mean", "unexposed_maximum", "furnace", "probe", "bow", "gap", "failure_time", "criterion",
    "held", "awarded", "verdict", "utilisation", "time",
})  # fmt: skip
KNOWN = {"robot": ROBOT, "fire_door": DOOR}
KINDS = ["insulation", "insulation1", "insulation2", "integrity", "radiation"]
UNEARNED = re.compile(r", (?:[0-9.]+ min of integrity not reached yet|integrity not judged)")
"""What stands behind a class of a verdict that the door has not earned."""
STEADY = "a steady state is no fire test: nothing fails at a time, or holds for one"


@dataclass(frozen=True)
class Task:
    """A row to be run: its key in the table, what is varied, and the keys of the scene that it replaces.

    files : paths of what its scene reads besides, to hashes of what was in them when the key was made
    """

    key: str
    inputs: Mapping[str, Any]
    overrides: Mapping[str, Any]
    files: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Misasked:
    """A row whose scene does not have what is observed: of the first row a mistake of the study's."""

    row: Row


@dataclass(frozen=True)
class SceneRun:
    """Runs rows of one scene; picklable. The scene's file is not read again.

    sample_period : s, or None for the step of each row's scene
    """

    kind: str
    document: Mapping[str, Any]
    source: str
    duration: float
    sample_period: float | None
    observe: Mapping[str, str]

    def __call__(self, task: Task) -> Row | Misasked:
        """Run a row; what is wrong with it is its reason.

        Raises
        ------
        OSError, ImportError
            The machine's trouble, such as a full disk, or a file of the scene's that has changed: no fault of
            the row's, so it is not kept as one.
        """
        try:
            outputs, warnings = RUNS[self.kind](self, task.overrides)
        except (OSError, ImportError):
            raise
        except Exception as problem:  # one row's trouble is no other's
            expected = isinstance(problem, (ValueError, ArithmeticError, RuntimeError)) and str(problem)
            said = str(problem) if expected else f"unexpected {type(problem).__name__}: {problem}"
            # The same wherever it is run from: a merge compares reasons.
            said = said.replace(f"{Path(self.source).parent}/", "")
            outputs, warnings = {}, ()
        else:
            said = ""
        for path, content in task.files.items():
            if content_of(path) != content:
                raise OSError(f"{path} is not what it was when the sweep began; run the sweep again")
        if said:
            return Row(task.key, task.inputs, None, said)
        observed: dict[str, Any] = {}
        for name, text in self.observe.items():
            try:
                observed[name] = Expression(text, KNOWN[self.kind])(outputs)
            except Undefined as problem:
                return Row(task.key, task.inputs, None, f"{name}: {problem}")
            except ExpressionError as problem:
                return Misasked(Row(task.key, task.inputs, None, f"observe: {name}: {problem}"))
        return Row(task.key, task.inputs, observed, warnings=tuple(warnings))


class Failed(RuntimeError):
    """A run that did not come to its end: why."""


Came = tuple[dict[str, Any], tuple[str, ...]]
"""Outputs of a run by name, and what it warned of."""


def _robot(row: SceneRun, overrides: Mapping[str, Any]) -> Came:
    from flexsim_node import load_scene, simulate

    scene = load_scene(row.document, overrides)
    run = simulate(scene, duration=row.duration, sample_period=row.sample_period)
    if run.status != "ok":
        raise Failed(run.status)
    joints, links = list(scene.joint_names), list(scene.link_names)
    ends = {name: n for n, node in enumerate(run.node_names) for name in [node.rpartition("/")[0]]}
    tips = [links[n] for n in scene.tips]

    def series(values: Any) -> Series:
        return Series(run.time, np.asarray(values, float))

    def joint(values: Any) -> Callable[[Any], Series]:
        return lambda name: series(values[:, _place("joint", name, joints)])

    def one_tip(of: str) -> str:
        if len(tips) > 1:
            raise ExpressionError(
                f"{of}(): the robot has tips {', '.join(tips)}; give one, {of}({tips[0]!r})"
            )
        return tips[0]

    def end(of: str) -> Callable[..., Series]:
        def at(name: Any = None) -> Series:
            link = _place("link", one_tip(of) if name is None else name, links)
            return series(run.link_end[:, link, "xyz".index(of)])

        return at

    def deflection(name: Any = None) -> Series:
        """m between a link's end and where it would be on rigid links."""
        node = ends[_named("link", one_tip("deflection") if name is None else name, list(ends))]
        return series(np.linalg.norm(run.node_position[:, node] - run.rigid_position[:, node], axis=1))

    def reading(name: Any, column: Any = 0.0) -> Series:
        values = run.sensors[_named("sensor", name, list(run.sensors))]
        values = values.reshape(len(values), -1)
        return series(values[:, _place("column", column, list(range(values.shape[1])))])

    outputs = {
        "time": series(run.time),
        "position": joint(run.joint_position),
        "velocity": joint(run.joint_velocity),
        "torque": joint(run.torque),
        "x": end("x"), "y": end("y"), "z": end("z"),
        "deflection": deflection,
        "energy": series(run.energy),
        "loop_gap": series(run.loop_gap.max(axis=1, initial=0.0)),
        "conditioning": series(run.conditioning),
        "reading": reading,
        "validity": lambda name: float(run.validity[_named("figure", name, list(run.validity))]),
    }  # fmt: skip
    return outputs, run.warnings


def _door(row: SceneRun, overrides: Mapping[str, Any]) -> Came:
    from thermal_node import load_scene, simulate
    from thermal_node.scene.doubts import doubts

    scene = load_scene({**row.document, "source": row.source}, overrides)
    assert row.sample_period is not None
    run = simulate(scene, row.duration, row.sample_period)
    if not run.status.ok:
        at = f"stopped at {run.time[-1]:g} s: " if len(run.time) else ""
        raise Failed(f"{at}{run.status.reason}")
    criteria = {c.name: c for c in run.criteria}
    judged = [c for c in run.criteria if c.watched]
    steady = scene.solver.model == "steady"

    def series(values: Any) -> Series:
        return Series(run.time, np.asarray(values, float))

    def of_a_shape(values: Any) -> Any:
        if values is None:
            return Absent("the scene computes no deformation; set deformation.model for bow and gap")
        return series(values)

    def timed() -> None:
        if steady:
            raise ExpressionError(STEADY)

    def criterion(name: Any) -> Any:
        found = criteria[_named("criterion", name, list(criteria))]
        if not found.watched:
            raise ExpressionError(f"criterion {name!r} is not judged in this scene")
        return found

    def failure_time(name: Any = None) -> float:
        """s at which a criterion, or the first that a class depends on, failed; inf where it holds."""
        timed()
        # What a standard only reads is no failure.
        these = [c for c in judged if c.kind != "read"] if name is None else [criterion(name)]
        if not these:
            raise ExpressionError("no criterion that could fail is judged in this scene")
        return min((c.time_of_failure for c in these if c.time_of_failure is not None), default=math.inf)

    def held(kind: Any) -> float:
        """Minutes that the criteria of a kind have held, of every standard; those of the run at most."""
        timed()
        _named("kind", kind, KINDS)
        # A criterion of kind insulation is of each insulation class.
        these = [c for c in judged if c.kind.startswith(kind) or kind.startswith(c.kind)]
        if not these:
            raise ExpressionError(f"no criterion of {kind} is judged in this scene")
        ends = [run.time[-1] if c.time_of_failure is None else c.time_of_failure for c in these]
        return float((min(ends) + 1e-6) / 60.0)

    def awarded(name: Any) -> bool:
        """Whether the verdict has a class of this name, by insulation alone or not."""
        timed()
        classes = UNEARNED.sub(" is not earned", run.verdict.partition(":")[0]).split(", ")
        return any(c in (name, f"{name} by insulation alone") for c in classes)

    outputs = {
        "time": series(run.time),
        "unexposed_mean": series(run.probes["unexposed_mean"]),
        "unexposed_maximum": series(run.probes["unexposed_maximum"]),
        "furnace": series(run.furnace),
        "probe": lambda name: series(run.probes[_named("probe", name, list(run.probes))]),
        "bow": of_a_shape(run.bow),
        "gap": of_a_shape(run.gap),
        "failure_time": failure_time,
        "criterion": lambda name: float(criterion(name).value),
        "held": held,
        "awarded": awarded,
        "verdict": run.verdict,
        "utilisation": Absent("no material of the leaf has a yield strength, or no shape was solved")
        if run.utilisation is None
        else float(run.utilisation.share),
    }  # fmt: skip
    return outputs, (*doubts(scene), *getattr(run.model.furnace, "notes", ()))


RUNS: dict[str, Callable[[SceneRun, Mapping[str, Any]], Came]] = {
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


def content_of(path: str) -> str:
    """A hash of what is in a file."""
    try:
        return hashlib.sha256(Path(path).read_bytes()).hexdigest()
    except OSError:
        return "can't be read"
