"""Scene files of fire doors: YAML in, a checked and immutable `Scene` out.

Every refusal is one line: FILE:LINE: key.path: what is wrong; what would be right.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexsim_core.refusals import explain
from flexsim_core.scene_files import SceneError, line_of, override, plain, read_scene
from pydantic import ValidationError

from .schema import Scene

__all__ = ["Scene", "SceneError", "changed", "load_scene"]

INNER = ("source", "constant", "rule")
"""Keys that a scene's file does not write."""


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
        raise SceneError(
            explain(Scene, problem.errors(), given, document, source, overridden, INNER)
        ) from None


def changed(scene: Scene, overrides: Mapping[str, Any]) -> Scene:
    """The scene with dotted keys replaced, checked again."""
    return load_scene(scene.model_dump(), overrides)


PROPERTIES = ("specific_heat", "conductivity", "youngs_modulus", "elongation", "yield_strength")
"""Keys of a property that was one number give a table in its place."""
