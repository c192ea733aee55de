"""What is run at points of a study: the scene with its keys replaced, and the key of all it depends on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import flexsim_core
from flexsim_core.scene_files import SceneError, override, plain, read_scene

from ..study.machine import versions
from .inputs import Input
from .runs import SceneRun, Task, content_of
from .study_file import Study
from .table import key_of

NOWHERE = object()


@dataclass(frozen=True)
class Programs:
    """Versions and sources that rows of a kind of scene depend on, where it is called."""

    kind: str

    def __call__(self) -> dict[str, str]:
        scripts = Path(__file__).parents[1]
        package = scripts.parent / ("flexsim_node" if self.kind == "robot" else "thermal_node")
        return versions(package, Path(flexsim_core.__file__).parent, scripts / "sweep")


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
        study.kind, document, str(study.scene.absolute()), study.duration, study.sample_period, study.observe
    )
    base = _loaded(work, {})
    _apart(study, document)
    for one in study.vary:
        if one.scale and _is_zero(_said(document, one.key)):
            raise SceneError(
                f"{study.source}: vary: {one.key}: scale: is 0 in the scene, and so is any factor of it; give"
                " values"
            )
        middle = one.at(0.5)
        try:
            _loaded(work, overrides_of(document, (one,), {one.key: middle}))
        except SceneError as problem:
            # A value may be impossible and only fail its row; a key that is nowhere is a slip.
            if _said(base, one.key) is NOWHERE:
                raise SceneError(f"{study.source}: vary: {one.key}: {problem}") from None
    return work


def _apart(study: Study, document: dict[str, Any]) -> None:
    """Refuse two keys that mean one place, by name and by number, or one in the other: the last would win."""

    def place_of(key: str, of: str) -> tuple[str, ...]:
        try:
            return tuple(override(_copied(document), key, None, _tables(study.kind)).split("."))
        except SceneError as problem:
            raise SceneError(f"{study.source}: {of}: {key}: {problem}") from None

    places: dict[str, tuple[str, ...]] = {}
    for one in study.vary:
        place = place_of(one.key, "vary")
        for key, other in places.items():
            if place[: len(other)] == other[: len(place)]:
                raise SceneError(
                    f"{study.source}: vary: {key} and {one.key} change the same of the scene; leave one out"
                )
        places[one.key] = place
    for key in study.settings:
        place = place_of(key, "set")
        for varied, other in places.items():
            if place[: len(other)] == other:
                raise SceneError(
                    f"{study.source}: set: {key} varies already, by {varied}; leave it out of one of them"
                )


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
    """What stands at a key; NOWHERE where there is no such place."""
    place = document
    for part in key.split("."):
        if isinstance(place, list):
            names = [entry.get("name") if isinstance(entry, dict) else None for entry in place]
            at = names.index(part) if part in names else int(part) if part.isdigit() else len(place)
            place = place[at] if at < len(place) else NOWHERE
        else:
            place = place.get(part, NOWHERE) if isinstance(place, dict) else NOWHERE
    return place


def _is_zero(said: Any) -> bool:
    return all(map(_is_zero, said)) if isinstance(said, list) else said == 0


def _times(said: Any, factor: float, key: str) -> Any:
    if isinstance(said, list):
        return [_times(v, factor, key) for v in said]
    if isinstance(said, (int, float)) and not isinstance(said, bool):
        return said * factor
    found = "nothing" if said is NOWHERE else repr(said)
    raise SceneError(
        f"{key}: scale needs a number or a list of numbers there, and the scene's file has {found}; give"
        " such a key, or values instead of scale"
    )


def tasks_of(
    work: SceneRun, inputs: tuple[Input, ...], points: list[dict[str, Any]], depends: Mapping[str, str]
) -> list[Task]:
    """Rows to be run for points, each with the key of all that it depends on."""
    said = {"kind": work.kind, "duration": work.duration, "sample_period": work.sample_period,
            "observe": dict(work.observe), "versions": dict(depends)}  # fmt: skip
    tasks: list[Task] = []
    contents: dict[str, str] = {}
    for point in points:
        overrides = plain(overrides_of(work.document, inputs, point))
        whole = _copied(work.document)
        for key, value in overrides.items():
            override(whole, key, _copied(value), _tables(work.kind))
        path = _log(whole, work.source)
        if path is not None and path not in contents:
            contents[path] = content_of(path)
        files = {} if path is None else {path: contents[path]}
        # The log by its content alone: it may lie elsewhere on another machine.
        run = {**said, "scene": whole, "files": list(files.values())}
        tasks.append(Task(key_of(run), plain(point), overrides, files))
    return tasks


def _copied(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _copied(v) for k, v in value.items()}
    return [_copied(v) for v in value] if isinstance(value, list) else value


def _log(document: Mapping[str, Any], source: str) -> str | None:
    """The path of the furnace's log, where that lies in a file of its own."""
    furnace = document.get("furnace")
    name = furnace.get("file") if isinstance(furnace, dict) else None
    return str(Path(source).parent / name) if isinstance(name, str) else None
