"""Scene files: YAML in, a checked and immutable `Scene` out; refusals say file, line and remedy."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from flexsim_core.quantities import Misplaced
from flexsim_core.scene_files import SceneError, line_of, override, plain, read_scene
from pydantic import ValidationError
from ruamel.yaml import YAML
from ruamel.yaml.events import AliasEvent, CollectionEndEvent, CollectionStartEvent

from .schema import Scene

__all__ = ["Scene", "SceneError", "load_scene"]


BRANCHES = ("tuple[", "dict[", "literal[")  # pydantic's words for a union's branches


def _keys_beside(document: Any, path: tuple[Any, ...]) -> list[str]:
    """Field names that a scene may have where the unknown key `path` stands."""
    model: Any = Scene
    for key in path[:-1]:
        if isinstance(key, int):
            continue
        field = getattr(model, "model_fields", {}).get(key)
        if field is None:
            return []
        found = [a for a in _annotations(field.annotation) if hasattr(a, "model_fields")]
        if not found:
            return []
        model = found[0]
    return list(model.model_fields)


def _annotations(annotation: Any) -> list[Any]:
    inner = getattr(annotation, "__args__", ())
    return [annotation] + [a for part in inner for a in _annotations(part)]


def _key_path(error: Any) -> tuple[Any, ...]:
    """Keys down to what an error is about, without pydantic's words for a union's branches."""
    cause = error.get("ctx", {}).get("error")
    own = cause.path if isinstance(cause, Misplaced) else ()
    return (
        *(
            k
            for k in error["loc"]
            if isinstance(k, int)
            or not (any(b in k for b in BRANCHES) or "function-" in k or k in ("bool", "Payload"))
        ),
        *own,
    )


def _remedy(error: Any, path: tuple[Any, ...], document: Any) -> str:
    """What would be right, for pydantic's own complaints."""
    kind, context = error["type"], error.get("ctx", {})
    if kind == "literal_error":
        return f"give {context['expected']}"
    if kind in ("tuple_type", "list_type"):
        return "give a list"
    if kind in ("too_short", "too_long"):
        least = "at least" if kind == "too_short" else "at most"
        return f"give {least} {context.get('min_length', context.get('max_length'))} values"
    if kind in ("model_type", "model_attributes_type", "dict_type"):
        return f"give keys such as {', '.join(_keys_beside(document, (*path, '')))}"
    if kind.startswith("int_"):
        return "give a whole number"
    if kind.startswith("bool_"):
        return "give true, false or auto" if "effects" in path else "give true or false"
    if kind in ("string_type", "string_too_short"):
        return "give a name"
    if kind == "greater_than_equal":
        return f"give at least {context['ge']}"
    if kind == "less_than_equal":
        return f"give at most {context['le']}"
    return str(error["msg"])


def _explain(errors: list[Any], document: Any, source: str, overridden: list[str]) -> str:
    """One line for pydantic's first complaint; of a union's branches the one that got furthest."""
    first = _key_path(errors[0])
    error = max((e for e in errors if _key_path(e)[: len(first)] == first), key=lambda e: len(_key_path(e)))
    path = _key_path(error)
    line = line_of(document, path)
    where = f"{source}:{line}" if line else source
    key = ".".join(str(k) for k in path) or "scene"
    if any(key == o or key.startswith(o + ".") for o in overridden):
        where = f"{source}, override"
    kind, message = error["type"], error["msg"]
    if kind == "extra_forbidden":
        allowed = _keys_beside(document, path)
        near = difflib.get_close_matches(str(path[-1]), allowed, 1)
        right = f"did you mean {near[0]!r}?" if near else f"known here: {', '.join(allowed)}"
        return f"{where}: {key}: unknown key; {right}"
    if kind == "missing":
        return f"{where}: {key}: is missing; give it"
    if kind == "value_error":
        return f"{where}: {key}: {message.removeprefix('Value error, ')}"
    value = error.get("input")
    several = isinstance(value, (list, tuple))
    shown = f"a list of {len(value)}" if several else repr(value)
    shown = "a set of keys" if isinstance(value, Mapping) else shown
    return f"{where}: {key}: is {shown}; {_remedy(error, path, document)}"


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
        raise SceneError(_explain(problem.errors(), document, source, overridden)) from None


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
