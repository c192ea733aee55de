"""What is asked of rows: expressions over what was observed and varied."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .expression import Expression, ExpressionError
from .inputs import Input

NAMES = frozenset({"input"})


def aim(text: Any, observed: frozenset[str], inputs: tuple[Input, ...]) -> Expression:
    """Read an aim or a condition: over names that are observed, input('KEY'), or a key alone.

    Raises
    ------
    ExpressionError
    """
    keys = [one.key for one in inputs]
    words = str(text).strip()
    if words in keys:
        words = f"input({words!r})"
    return Expression(words, observed | NAMES)


def seen(point: Mapping[str, Any], observed: Mapping[str, Any]) -> dict[str, Any]:
    """What an aim may name of a row."""

    def varied(key: Any) -> Any:
        if key not in point:
            raise ExpressionError(f"input({key!r}) does not vary; known are {', '.join(point)}")
        value = point[key]
        if not isinstance(value, (int, float, str)):
            raise ExpressionError(f"input({key!r}) is no number; an aim takes numbers and words")
        return value

    return {**observed, "input": varied}


def number_of(wanted: Expression, names: Mapping[str, Any]) -> float:
    """Return an aim's value, which is to be a number.

    Raises
    ------
    ExpressionError, Undefined
    """
    value = wanted(names)
    if isinstance(value, str):
        raise ExpressionError(f"{wanted.text!r} is the word {value!r}; an aim is a number")
    return float(value)
