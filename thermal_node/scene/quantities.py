"""The quantities of a scene: what is possible, and what is only plausible in other units."""

from __future__ import annotations

import math
from typing import Annotated, Any

from flexsim_core.quantities import between, number_in
from pydantic import BeforeValidator

number = number_in("SI units and °C")
THINNEST = 1e-5
"""m; a thinner layer settles within nanoseconds, and the march would follow it there."""
Number = Annotated[float, BeforeValidator(number)]
Thickness = Annotated[
    Number,
    between(0.0, 2.0, "m", "metres, not millimetres", open_low=True),
    between(THINNEST, 2.0, "m", "add a thinner coating to its sheet"),
]
Size = Annotated[Number, between(0.0, 30.0, "m", "metres, not millimetres", open_low=True)]
Position = Annotated[Number, between(-30.0, 30.0, "m", "metres, not millimetres")]
Density = Annotated[Number, between(0.5, 3e4, "kg/m3", "steel has 7850 kg/m3, not 7.85 g/cm3")]
FilmCoefficient = Annotated[Number, between(0.0, 1e6, "W/(m2 K)")]
Emissivity = Annotated[Number, between(0.0, 1.0, "")]
GreyEmissivity = Annotated[Number, between(0.0, 1.0, "", open_low=True)]
ContactResistance = Annotated[Number, between(0.0, 10.0, "m2 K/W", open_low=True)]
Temperature = Annotated[Number, between(-273.15, 3000.0, "°C")]
Ambient = Annotated[Number, between(-100.0, 200.0, "°C", "degrees Celsius, not kelvin")]
Positive = Annotated[Number, between(0.0, math.inf, "", open_low=True)]
NotNegative = Annotated[Number, between(0.0, math.inf, "")]
Fraction = Annotated[Number, between(0.0, 1.0, "")]


def count(value: Any) -> Any:
    """A whole number from 1."""
    if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= 2000:
        raise ValueError(f"is {value!r}; give a whole number from 1 to 2000")
    return value


Count = Annotated[int, BeforeValidator(count)]
