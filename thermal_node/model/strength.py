"""Yield strength over temperature: a scene's, or carbon steel's by EN 1993-1-2 table 3.1."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..scene.parts import MaterialPart
from ..scene.schema import Scene
from .materials import Array, Curve, constant, steel_yield_factor, table

S235 = 235e6
"""Pa at 20 °C of steel whose scene says nothing: EN 1993-1-1 table 3.1, the weakest of its steels."""
SOFTEST = 1e-3
"""Least share of a strength at 20 °C that is kept, as of the stiffness."""
_FACTOR_TEMPERATURE = np.array([20.0, *np.arange(100.0, 1201.0, 100.0)])


def yield_strength(name: str, scene: Scene) -> Curve | None:
    """Of the scene's material of that name, Pa; None where it has none and is taken as elastic.

    A number is the strength at 20 °C: of Eurocode's steel it falls by table 3.1, else it is constant.
    """
    part = scene.materials.get(name, MaterialPart())
    given = part.yield_strength
    eurocode = name == "steel" or part.standard is not None
    if given is not None and given.temperature is not None and given.value is not None:
        return table(given.temperature, given.value, "extend" if given.beyond == "extend" else "hold")
    if not eurocode:
        return None if given is None or given.constant is None else constant(given.constant)
    cold = S235 if given is None or given.constant is None else given.constant
    return table(_FACTOR_TEMPERATURE, cold * steel_yield_factor(_FACTOR_TEMPERATURE), "hold")


def strength_at(curves: tuple[Curve | None, ...], kind: NDArray[np.int64], temperature: Array) -> Array:
    """Strength, Pa, of material `kind` at temperatures of the same shape; infinite where it has none."""
    found = np.full(temperature.shape, np.inf)
    for m, curve in enumerate(curves):
        if curve is not None:
            mine = kind == m
            found[mine] = np.maximum(curve(temperature[mine]), SOFTEST * float(curve(20.0)))
    return found
