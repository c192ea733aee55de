"""Scene files: YAML in, a checked and immutable `Scene` out; refusals say file, line and remedy."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexsim_core.refusals import explain
from flexsim_core.scene_files import SceneError, line_of, override, plain, read_scene
from pydantic import ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.events import AliasEvent, CollectionEndEvent, CollectionStartEvent

from .schema import Scene

__all__ = ["Scene", "SceneError", "load_scene"]

INNER = ("source",)
"""Keys that a scene's file does not write."""


def load_scene(scene: str | Path | Mapping[str, Any], overrides: Mapping[str, Any] | None = None) -> Scene:
    """Read and check a robot scene.

    Parameters
    ----------
    scene : path of a YAML file, or its content as a dict
    overrides : dotted keys and values that replace what the scene says, e.g. {"solver.step": 5e-4},
        {"links.link_1.beam.elements": 4}

    Raises
    ------
    SceneError
        One line: file, line, key, what is wrong and what would be right.
    """
    if isinstance(scene, Mapping):
        source, document = "scene", scene
    else:
        source = str(scene)
        document = read_scene(Path(scene), "model, name, links")
    kind = document.get("model")
    if kind != "robot":
        line = line_of(document, ("model",))
        where = f"{source}:{line}" if line else source
        raise SceneError(f"{where}: model: is {kind!r}; give 'robot' for a flexible robot")
    given = plain(document)
    overridden = [override(given, str(key), plain(value)) for key, value in (overrides or {}).items()]
    try:
        return Scene.model_validate(given)
    except ValidationError as problem:
        raise SceneError(
            explain(Scene, problem.errors(), given, document, source, overridden, INNER)
        ) from None


LONGEST_FAULTS = 10_000  # characters
DEEPEST_FAULTS = 4  # list, fault, inertia, its rows


def faults_from_text(text: str) -> list[Any]:
    """Read a list of faults as a scene's `faults:` has it, from YAML that somebody sent.

    Raises
    ------
    SceneError
    """
    right = "give a list such as [{kind: delay, time: 0.005}], or [] for none"
    if len(text) > LONGEST_FAULTS:
        raise SceneError(f"faults: has {len(text)} characters; give at most {LONGEST_FAULTS}")
    try:
        # Aliases can stand for ever more of themselves, and deep nesting takes the parser for ever.
        depth = 0
        for event in YAML(typ="safe", pure=True).parse(text):
            depth += isinstance(event, CollectionStartEvent) - isinstance(event, CollectionEndEvent)
            if isinstance(event, AliasEvent) or depth > DEEPEST_FAULTS:
                raise SceneError(f"faults: has a YAML alias, or lists in lists; {right}")
        found = YAML(typ="safe", pure=True).load(text)
    except SceneError:
        raise
    except Exception as problem:  # ruamel raises several kinds for broken documents
        reason = " ".join(str(problem).split())[:200]
        raise SceneError(f"faults: not YAML: {reason}; {right}") from None
    if not isinstance(found, list):
        raise SceneError(f"faults: is no list; {right}")
    return found
