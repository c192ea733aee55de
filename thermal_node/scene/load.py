"""Scene files of fire doors: YAML in, a checked and immutable `Scene` out.

Every refusal is one line: FILE:LINE: key.path: what is wrong; what would be right.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.error import MarkedYAMLError

from .quantities import Misplaced
from .schema import Scene, keys_beside

__all__ = ["Scene", "SceneError", "changed", "load_scene"]


LARGEST_FILE = 2**20  # bytes
MOST_VALUES, DEEPEST = 1_000_000, 50


class SceneError(ValueError):
    """A scene that can't be simulated: FILE:LINE: key: what is wrong; what would be right."""


def load_scene(scene: str | Path | Mapping[str, Any], overrides: Mapping[str, Any] | None = None) -> Scene:
    """Read and check a fire door's scene.

    Parameters
    ----------
    scene : path of a YAML file, or its content as a dict (arrays may be NumPy's)
    overrides : dotted keys and values that replace what the scene says, e.g.
        {"solver.step": 10.0}, {"leaf.layers.1.thickness": 0.1}

    Raises
    ------
    SceneError
        One line: file, line, key, what is wrong and what would be right.
    """
    if isinstance(scene, Mapping):
        source, document = str(scene.get("source") or "scene"), scene
    else:
        source = str(scene)
        document = _read(Path(scene))
    if document.get("model") != "fire_door":
        line = _line(document, ("model",)) or 1
        where = source if isinstance(scene, Mapping) else f"{source}:{line}"
        raise SceneError(f"{where}: model: is {document.get('model')!r}; give 'fire_door' for a fire door")
    plain = _plain(document)
    for key, value in (overrides or {}).items():
        _override(plain, key, _plain(value))
    plain["source"] = source
    try:
        return Scene.model_validate(plain)
    except ValidationError as problem:
        errors = problem.errors()
        # A misspelt key also leaves its right name missing; the misspelling is the news.
        errors.sort(key=lambda error: error["type"] != "extra_forbidden")
        raise SceneError(_explain(errors[0], document, source)) from None


def changed(scene: Scene, overrides: Mapping[str, Any]) -> Scene:
    """The scene with dotted keys replaced, checked again."""
    return load_scene(scene.model_dump(), overrides)


def _read(path: Path) -> Mapping[str, Any]:
    try:
        size = path.stat().st_size
        if not path.is_file() or size > LARGEST_FILE:  # a device may never end, a pipe never begin
            raise SceneError(f"{path}: is no file of at most {LARGEST_FILE} bytes; give a YAML file")
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise SceneError(f"{path}: no such file; give the path of a scene") from None
    except (OSError, UnicodeDecodeError) as problem:
        raise SceneError(f"{path}: can't be read ({problem}); give a YAML file") from None
    try:
        document = YAML(typ="rt", pure=True).load(text)
    except MarkedYAMLError as problem:
        mark = problem.problem_mark
        raise SceneError(
            f"{path}:{mark.line + 1 if mark else 1}: not YAML: {problem.problem}; mend it there"
        ) from None
    except Exception as problem:  # ruamel raises several kinds for broken documents
        raise SceneError(f"{path}: not YAML: {problem}") from None
    if not isinstance(document, Mapping):
        raise SceneError(f"{path}:1: not a scene; give keys such as model, leaf, furnace")
    _count_values(document, path)
    return document


def _count_values(document: Any, path: Path) -> None:
    """Refuse a document whose aliases stand for ever more of themselves, before it is unfolded."""
    count, waiting = 0, [(document, 0)]
    while waiting:
        value, depth = waiting.pop()
        count += 1
        if count > MOST_VALUES or depth > DEEPEST:
            raise SceneError(
                f"{path}: unfolds to more than {MOST_VALUES} values or {DEEPEST} levels;"
                " give fewer YAML aliases"
            )
        if isinstance(value, Mapping):
            waiting.extend((v, depth + 1) for v in value.values())
        elif isinstance(value, (list, tuple)):
            waiting.extend((v, depth + 1) for v in value)


def _plain(value: Any) -> Any:
    """Nested dicts, lists and numbers of Python's own, from ruamel's or NumPy's."""
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    if isinstance(value, bool) or value is None:
        return value
    for kind in (int, float, str):
        if isinstance(value, kind):
            return kind(value)
    return value


def _override(document: dict[str, Any], key: str, value: Any) -> None:
    """Set a dotted key, as in `leaf.layers.1.thickness`, in a plain document."""
    parts = key.split(".")
    place: Any = document
    for n, part in enumerate(parts):
        last = n == len(parts) - 1
        above = ".".join(parts[:n])
        if isinstance(place, list):
            if not part.isdigit() or int(part) >= len(place):
                raise SceneError(f"override {key}: no {part!r} in {above}; give 0 to {len(place) - 1}")
            if last:
                place[int(part)] = value
            else:
                place = place[int(part)]
        elif isinstance(place, dict):
            if last:
                place[part] = value
            else:
                if place.get(part) is None:
                    place[part] = {}
                elif part in PROPERTIES:
                    place[part] = _as_table(place[part])
                place = place[part]
        else:
            raise SceneError(f"override {key}: {above} is {place!r} and has no keys below it; give {above}")


PROPERTIES = ("specific_heat", "conductivity", "youngs_modulus", "elongation")


def _as_table(value: Any) -> Any:
    """Keys of a property that was one number give a table in its place."""
    return value if isinstance(value, (dict, list)) else {}


def _line(document: Any, path: tuple[Any, ...]) -> int | None:
    """Line (from 1) of a key in a ruamel document, or of its nearest parent that has one."""
    line = None
    for key in path:
        try:
            mapping = isinstance(document, Mapping)
            place = document.lc.key(key) if mapping else document.lc.item(key)
            line = place[0] + 1
            document = document[key]
        except (AttributeError, KeyError, IndexError, TypeError):
            break
    return line


def _explain(error: Any, document: Any, source: str) -> str:
    """One line for pydantic's first complaint."""
    path = tuple(error["loc"])
    cause = (error.get("ctx") or {}).get("error")
    if isinstance(cause, Misplaced):
        path = (*path, *cause.path)
    path = tuple(k for k in path if not _names_a_choice(k))
    line = _line(document, path)
    where = f"{source}:{line}" if line else source
    key = ".".join(str(k) for k in path) or "scene"
    message = str(error["msg"])
    if error["type"] == "extra_forbidden":
        allowed = keys_beside(path)
        near = difflib.get_close_matches(str(path[-1]), allowed, 1)
        right = f"did you mean {near[0]!r}?" if near else f"known here: {', '.join(allowed)}"
        return f"{where}: {key}: unknown key; {right}"
    if error["type"] == "missing":
        return f"{where}: {key}: is missing; give it"
    if error["type"] == "value_error":
        return f"{where}: {key}: {message.removeprefix('Value error, ')}"
    value = error.get("input")
    shown = type(value).__name__ if isinstance(value, (Mapping, list)) else repr(value)
    message = message.replace("Input should be", "give").replace("a valid ", "a ")
    return f"{where}: {key}: is {shown}; {message[0].lower() + message[1:]}"


def _names_a_choice(key: Any) -> bool:
    """Whether pydantic put this into a path to say which choice of several it tried."""
    return isinstance(key, str) and ("[" in key or key in ("float", "int", "bool", "str", "tuple"))
