"""Why a scene is refused, in one line: what pydantic found, in the words of the scene's keys."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Mapping, Sequence
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, Tag

from .quantities import Misplaced
from .scene_files import line_of

LONGEST_SHOWN = 60
"""Characters of a value that a refusal repeats."""
COMPARED = {
    "greater_than_equal": ("at least", "ge"),
    "less_than_equal": ("at most", "le"),
    "greater_than": ("more than", "gt"),
    "less_than": ("less than", "lt"),
}

Choice = tuple[str, Any]
"""One of the types that a key may have, and pydantic's word for it."""


def explain(
    scene: type[BaseModel],
    errors: Sequence[Any],
    given: Any,
    document: Any,
    source: str,
    overridden: Collection[str] = (),
    inner: Collection[str] = (),
) -> str:
    """One line, FILE:LINE: key: what is wrong; what would be right.

    scene : what the scene was checked against; errors : pydantic's complaints
    given : the plain document that was checked; document : the one that knows its lines
    overridden : keys that were replaced from outside; inner : field names that a user does not write
    """
    # A misspelt key also leaves its right name missing; the misspelling is the news.
    ordered = sorted(errors, key=lambda error: error["type"] != "extra_forbidden")
    places = [_Place(scene, error, given) for error in ordered]
    # Of the choices that a key has, the one that got furthest.
    first = places[0].path
    place = max((p for p in places if p.path[: len(first)] == first), key=lambda p: len(p.path))
    path, said = place.complaint(inner)
    key = ".".join(str(k) for k in path) or "scene"
    line = line_of(document, path)
    where = f"{source}:{line}" if line else source
    if any(key == o or key.startswith(o + ".") for o in overridden):
        where = f"{source}, override"
    return f"{where}: {key}: {said}"


class _Place:
    """Where an error is.

    path : keys down to it; around : the choices that have the last key
    choices : those for its value; tried : of these the ones that the error is about
    """

    def __init__(self, scene: type[BaseModel], error: Any, given: Any) -> None:
        self.error = error
        self.around: list[Choice] = []
        self.choices = self.tried = _choices(scene)
        path: list[str | int] = []
        for n, key in enumerate(error["loc"]):
            below = [c for _, kind in self.tried for c in _below(kind, key, given)]
            if below or (error["type"] == "extra_forbidden" and n == len(error["loc"]) - 1):
                self.around, self.choices, self.tried = self.tried, below, below
                given = _value(given, key)
                path.append(key)
            else:  # pydantic's word for the choice that it tried
                self.tried = [c for c in self.tried if c[0] == key] or self.tried
        cause = (error.get("ctx") or {}).get("error")
        self.path = (*path, *(cause.path if isinstance(cause, Misplaced) else ()))

    def complaint(self, inner: Collection[str]) -> tuple[tuple[str | int, ...], str]:
        """The keys that it is about, and the sentence."""
        path, error = self.path, self.error
        kind, value = error["type"], error.get("input")
        if kind == "value_error":
            return path, str(error["msg"]).removeprefix("Value error, ")
        if kind == "extra_forbidden":
            known = _keys(self.around, inner)
            near = difflib.get_close_matches(str(path[-1]), known, 1)
            right = f"did you mean {near[0]!r}?" if near else f"known here: {', '.join(known)}"
            return path, f"unknown key; {right}"
        if kind == "missing" and path and isinstance(path[-1], int):
            return path[:-1], f"is a list of {len(value)}; {_count(self.around)}"
        if kind == "missing":
            return path, "is missing; give it"
        return path, f"is {_shown(value)}; {_remedy(error, self, inner)}"


def _choices(annotation: Any, word: str = "") -> list[Choice]:
    """The types that an annotation allows, None left out."""
    if get_origin(annotation) is Annotated:
        bare, *about = get_args(annotation)
        return _choices(bare, next((a.tag for a in about if isinstance(a, Tag)), word))
    if get_origin(annotation) in (Union, UnionType):
        return [c for part in get_args(annotation) for c in _choices(part)]
    if annotation is type(None):
        return []
    return [(word or getattr(annotation, "__name__", ""), annotation)]


def _below(kind: Any, key: Any, given: Any) -> list[Choice]:
    """What may stand at a key of something of this kind."""
    if _is_part(kind):
        field = kind.model_fields.get(key) if isinstance(key, str) else None
        return [] if field is None else _choices(field.annotation) or [("", None)]
    origin, parts = get_origin(kind), get_args(kind)
    if origin in (tuple, list) and isinstance(key, int) and parts:
        alike = origin is list or parts[-1] is Ellipsis
        return _choices(parts[0] if alike else parts[min(key, len(parts) - 1)])
    if origin is dict and isinstance(given, Mapping) and key in given:
        return _choices(parts[1])
    return []


def _value(given: Any, key: Any) -> Any:
    try:
        return given[key]
    except (KeyError, IndexError, TypeError):
        return None


def _is_part(kind: Any) -> bool:
    return isinstance(kind, type) and issubclass(kind, BaseModel)


def _keys(choices: list[Choice], inner: Collection[str]) -> list[str]:
    """Keys of the parts among some choices."""
    names = [name for _, kind in choices if _is_part(kind) for name in kind.model_fields]
    return [name for name in dict.fromkeys(names) if name not in inner]


def _count(choices: list[Choice]) -> str:
    """How many values a list of a fixed length has."""
    fixed = [len(get_args(kind)) for _, kind in choices if _is_of_fixed_length(kind)]
    return f"give {fixed[0]} values" if fixed else "give more values"


def _is_of_fixed_length(kind: Any) -> bool:
    return get_origin(kind) is tuple and get_args(kind)[-1] is not Ellipsis


def _shown(value: Any) -> str:
    """A value as a sentence repeats it."""
    if isinstance(value, Mapping):
        return "a set of keys"
    if isinstance(value, (list, tuple)):
        return f"a list of {len(value)}"
    shown = repr(value) if value is None or isinstance(value, (str, int, float)) else str(value)
    return shown if len(shown) <= LONGEST_SHOWN else f"{shown[:LONGEST_SHOWN]}..."


def _remedy(error: Any, place: _Place, inner: Collection[str]) -> str:
    """What would be right, for pydantic's own complaints."""
    kind, context, choices = error["type"], error.get("ctx") or {}, place.tried
    if kind.startswith("bool_"):
        words = [str(v) for _, k in place.choices if get_origin(k) is Literal for v in get_args(k)]
        return f"give true, false or {' or '.join(words)}" if words else "give true or false"
    if kind == "literal_error":
        return f"give {context['expected']}"
    if kind in ("tuple_type", "list_type"):
        return "give a list"
    if kind in ("too_short", "too_long"):
        if any(_is_of_fixed_length(k) for _, k in choices):
            return _count(choices)
        least = "at least" if kind == "too_short" else "at most"
        number = context.get("min_length", context.get("max_length"))
        return f"give {least} {number} {'value' if number == 1 else 'values'}"
    if kind in ("model_type", "model_attributes_type"):
        return f"give keys such as {', '.join(_keys(choices, inner))}"
    if kind == "dict_type":
        parts = [c for _, k in choices if get_origin(k) is dict for c in _choices(get_args(k)[1])]
        keys = _keys(parts, inner)
        return "give names, each with " + (f"keys such as {', '.join(keys)}" if keys else "its value")
    if kind.startswith("int_"):
        return "give a whole number"
    if kind in ("string_type", "string_too_short"):
        return "give a name"
    if kind in COMPARED:
        compared, limit = COMPARED[kind]
        return f"give {compared} {context[limit]}"
    return f"give another value ({error['msg']})"
