"""Scene files of fire doors: YAML in, a checked and immutable `Scene` out.

Every refusal is one line: FILE:LINE: key.path: what is wrong; what would be right.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexsim_core.quantities import Misplaced
from flexsim_core.scene_files import SceneError, line_of, override, plain, read_scene
from pydantic import ValidationError

from .schema import Scene, keys_beside

__all__ = ["Scene", "SceneError", "changed", "load_scene"]


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
        document = read_scene(Path(scene), "model, leaf, furnace")
    if document.get("model") != "fire_door":
        line = line_of(document, ("model",)) or 1
        where = source if isinstance(scene, Mapping) else f"{source}:{line}"
        raise SceneError(f"{where}: model: is {document.get('model')!r}; give 'fire_door' for a fire door")
    given = plain(document)
    overridden = [
        override(given, str(key), plain(value), PROPERTIES) for key, value in (overrides or {}).items()
    ]
    given["source"] = source
    try:
        return Scene.model_validate(given)
    except ValidationError as problem:
        errors = problem.errors()
        # A misspelt key also leaves its right name missing; the misspelling is the news.
        errors.sort(key=lambda error: error["type"] != "extra_forbidden")
        raise SceneError(_explain(errors[0], document, source, overridden)) from None


def changed(scene: Scene, overrides: Mapping[str, Any]) -> Scene:
    """The scene with dotted keys replaced, checked again."""
    return load_scene(scene.model_dump(), overrides)


PROPERTIES = ("specific_heat", "conductivity", "youngs_modulus", "elongation", "yield_strength")
"""Keys of a property that was one number give a table in its place."""


def _explain(error: Any, document: Any, source: str, overridden: list[str]) -> str:
    """One line for pydantic's first complaint."""
    path = tuple(error["loc"])
    cause = (error.get("ctx") or {}).get("error")
    if isinstance(cause, Misplaced):
        path = (*path, *cause.path)
    cavity = "[cavity]" in path
    path = tuple(k for k in path if not _names_a_choice(k))
    line = line_of(document, path)
    where = f"{source}:{line}" if line else source
    key = ".".join(str(k) for k in path) or "scene"
    if any(key == o or key.startswith(o + ".") for o in overridden):
        where = f"{source}, override"
    message = str(error["msg"])
    if error["type"] == "extra_forbidden":
        allowed = keys_beside(path, cavity)
        near = difflib.get_close_matches(str(path[-1]), allowed, 1)
        right = f"did you mean {near[0]!r}?" if near else f"known here: {', '.join(allowed)}"
        return f"{where}: {key}: unknown key; {right}"
    if error["type"] == "missing":
        return f"{where}: {key}: is missing; give it"
    if error["type"] == "value_error":
        return f"{where}: {key}: {message.removeprefix('Value error, ')}"
    value = error.get("input")
    shown = "a set of keys" if isinstance(value, Mapping) else repr(value)
    shown = f"a list of {len(value)}" if isinstance(value, (list, tuple)) else shown
    message = message.replace("Input should be", "give").replace("a valid ", "a ").replace("tuple", "list")
    return f"{where}: {key}: is {shown}; {message[0].lower() + message[1:]}"


def _names_a_choice(key: Any) -> bool:
    """Whether pydantic put this into a path to say which choice of several it tried."""
    return isinstance(key, str) and ("[" in key or key in ("float", "int", "bool", "str", "tuple"))
