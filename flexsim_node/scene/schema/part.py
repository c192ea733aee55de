"""What all parts of a scene share: numbers with their ranges and units, and complaints that say where."""

from __future__ import annotations

import difflib
import math
from collections.abc import Sequence
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field


class Misplaced(ValueError):
    """A complaint about a key below the part that is being checked."""

    def __init__(self, path: tuple[str | int, ...], message: str) -> None:
        super().__init__(message)
        self.path = path


def unknown(path: tuple[str | int, ...], name: str, known: Sequence[str]) -> Misplaced:
    """What to raise of a name that is not there."""
    near = difflib.get_close_matches(name, known, 1)
    choice = near[0] if near else "one of " + ", ".join(known)
    return Misplaced(path, f"is {name!r}, which does not exist; give {choice}")


def _number(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        hint = " (without its unit; SI units are understood)" if isinstance(value, str) else ""
        raise ValueError(f"is {value!r}; give a number{hint}")
    if not math.isfinite(value):
        raise ValueError(f"is {value!r}; give a finite number")
    return float(value)


def between(low: float, high: float, unit: str, advice: str = "", open_low: bool = False) -> Any:
    def check(value: float) -> float:
        if value > high or value < low or (open_low and value <= low):
            bracket = "more than" if open_low else "at least"
            most = f" and at most {high:g}" if math.isfinite(high) else ""
            raise ValueError(
                f"is {value:g}; give {bracket} {low:g}{most} {unit}".rstrip()
                + (f" ({advice})" if advice else "")
            )
        return value

    return AfterValidator(check)


Number = Annotated[float, BeforeValidator(_number)]
Length = Annotated[Number, between(-1e2, 1e2, "m", "metres, not millimetres")]
Angle = Annotated[Number, between(-4 * math.pi, 4 * math.pi, "rad", "radians, not degrees")]
Side = Annotated[Number, between(0.0, 10.0, "m", "metres, not millimetres", open_low=True)]
Density = Annotated[Number, between(10.0, 1e5, "kg/m3", "steel has 7800 kg/m3, not 7.8 g/cm3", open_low=True)]
Modulus = Annotated[Number, between(1e4, 1e15, "Pa", "steel has 2e11 Pa, not 200 GPa", open_low=True)]
Positive = Annotated[Number, between(0.0, math.inf, "", open_low=True)]
NotNegative = Annotated[Number, between(0.0, math.inf, "")]
Vector = Annotated[tuple[Number, ...], Field(min_length=3, max_length=3)]
Name = Annotated[str, Field(min_length=1)]


class Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=False)
