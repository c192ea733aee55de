"""The quantities of a robot's scene: what is possible, and what is only plausible in other units."""

from __future__ import annotations

import math
from typing import Annotated, Any

from flexsim_core.quantities import Misplaced, Part, between, each_once, number_in, unknown
from pydantic import BeforeValidator, Field

__all__ = [
    "Angle",
    "Density",
    "Length",
    "Misplaced",
    "Modulus",
    "Name",
    "NotNegative",
    "Number",
    "Part",
    "Place",
    "Positive",
    "Side",
    "Vector",
    "between",
    "each_once",
    "unknown",
    "without_defaults",
]

Number = Annotated[float, BeforeValidator(number_in("SI units"))]
Length = Annotated[Number, between(-1e2, 1e2, "m", "metres, not millimetres")]
Angle = Annotated[Number, between(-4 * math.pi, 4 * math.pi, "rad", "radians, not degrees")]
Side = Annotated[Number, between(0.0, 10.0, "m", "metres, not millimetres", open_low=True)]
Density = Annotated[Number, between(10.0, 1e5, "kg/m3", "steel has 7800 kg/m3, not 7.8 g/cm3", open_low=True)]
Modulus = Annotated[Number, between(1e4, 1e15, "Pa", "steel has 2e11 Pa, not 200 GPa", open_low=True)]
Positive = Annotated[Number, between(0.0, math.inf, "", open_low=True)]
NotNegative = Annotated[Number, between(0.0, math.inf, "")]
Vector = Annotated[tuple[Number, ...], Field(min_length=3, max_length=3)]
Place = Annotated[tuple[Length, ...], Field(min_length=3, max_length=3)]
Name = Annotated[str, Field(min_length=1)]


def without_defaults(part: Part, keys: tuple[str, ...], dumped: dict[str, Any]) -> dict[str, Any]:
    """A dumped part without those of its keys that say nothing: what has no use for them keeps its hash."""
    fields = type(part).model_fields
    idle = {key for key in keys if getattr(part, key) == fields[key].get_default(call_default_factory=True)}
    return {key: value for key, value in dumped.items() if key not in idle}
