"""What all parts of a scene share: numbers with their ranges and units, and refusals that say where."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from pydantic import AfterValidator, BaseModel, ConfigDict


class Misplaced(ValueError):
    """A refusal of a key below the part that is being checked."""

    def __init__(self, path: tuple[str | int, ...], message: str) -> None:
        super().__init__(message)
        self.path = path


class Part(BaseModel):
    """A section of a scene: nothing unknown in it, nothing changed after it is read."""

    model_config = ConfigDict(extra="forbid", frozen=True)


def unknown(path: tuple[str | int, ...], name: str, known: Sequence[str]) -> Misplaced:
    """What to raise of a name that is not there."""
    near = difflib.get_close_matches(name, known, 1)
    choice = near[0] if near else "one of " + ", ".join(known)
    return Misplaced(path, f"is {name!r}, which does not exist; give {choice}")


def each_once(
    path: tuple[str | int, ...],
    names: Iterable[str | None],
    remedy: str,
    below: tuple[str | int, ...] = (),
    said: str = "is {!r}",
) -> None:
    """Refuse a list in which two entries bear one name, and name both.

    path : of the list; names : one an entry, None where it has none; below : keys from an entry to its name
    said : how the sentence begins, with the name in it

    Raises
    ------
    Misplaced
    """
    first: dict[str, int] = {}
    for n, name in enumerate(names):
        if name is None:
            continue
        if name in first:
            other = ".".join(str(key) for key in (*path, first[name]))
            raise Misplaced((*path, n, *below), f"{said.format(name)} like {other}; {remedy}")
        first[name] = n


def number_in(units: str) -> Callable[[Any], Any]:
    """A check for a finite number as it stands; `units` says which are understood without being written."""

    def number(value: Any) -> Any:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            hint = f" (without its unit; {units} are understood)" if isinstance(value, str) else ""
            raise ValueError(f"is {value!r}; give a number{hint}")
        if not math.isfinite(value):
            raise ValueError(f"is {value!r}; give a finite number")
        return float(value)

    return number


@dataclass(frozen=True)
class Range(AfterValidator):
    """A check of a number's range that JSON Schema has too."""

    low: float = -math.inf
    high: float = math.inf
    open_low: bool = False
    unit: str = ""

    def __get_pydantic_json_schema__(self, schema: Any, handler: Any) -> dict[str, Any]:
        found: dict[str, Any] = dict(handler(schema))
        if math.isfinite(self.low):
            found["exclusiveMinimum" if self.open_low else "minimum"] = self.low
        if math.isfinite(self.high):
            found["maximum"] = self.high
        return found | ({"description": f"in {self.unit}"} if self.unit else {})


def between(low: float, high: float, unit: str, advice: str = "", open_low: bool = False) -> Any:
    """A check of a number's range, in words."""

    def check(value: float) -> float:
        if not low <= value <= high or (open_low and value == low):
            bracket = "more than" if open_low else "at least"
            most = "" if math.isinf(high) else f" and at most {high:g}"
            raise ValueError(
                f"is {value:g}; give {bracket} {low:g}{most} {unit}".rstrip()
                + (f" ({advice})" if advice else "")
            )
        return value

    return Range(check, low, high, open_low, unit)
