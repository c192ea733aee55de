"""Air that moves in a cavity: by how much more it conducts than air at rest.

Air: conductivity and viscosity by the U.S. Standard Atmosphere (1976), equations 53 and 51; an ideal gas at
1 atm. Nusselt numbers of a closed upright cavity:

    EN_673      Nu = 0.035 (Gr Pr)^0.38, at least 1 (EN 673:2011 clause 5.3.2, vertical)
    ELSHERBINY  the largest of three branches, with Ra = Gr Pr and the aspect ratio A = height / width
                (ElSherbiny, Raithby and Hollands 1982, J. Heat Transfer 104, 96-102):
                0.0605 Ra^(1/3);  (1 + (0.104 Ra^0.293 / (1 + (6310/Ra)^1.36))^3)^(1/3);  0.242 (Ra/A)^0.272

All at the mean of the faces' temperatures. Both rules were measured near room temperature.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..compiled.arithmetic import FAST
from ..mesh.exchange import Exchange

Array = NDArray[np.float64]

EN_673, ELSHERBINY = 1, 2
GRAVITY = 9.80665
GAS_CONSTANT = 287.05287
"""Of air, J/(kg K)."""
SPECIFIC_HEAT = 1008.0
"""Of air, J/(kg K): EN 673:2011 table 1."""
PRESSURE = 101325.0
STEEPER = 1.4
"""The flow grows about as the difference of temperatures to this power."""


class Cavities(NamedTuple):
    """The cavities whose air moves.

    material (C,) : each one's gap among the materials; rule (C,) : EN_673 or ELSHERBINY
    width, height (C,) : m
    """

    material: NDArray[np.int64]
    rule: NDArray[np.int64]
    width: Array
    height: Array


@njit(cache=True, fastmath=FAST)
def air_conductivity(t: float) -> float:
    """W/(m K) at t, °C."""
    kelvin = t + 273.15
    return 2.64638e-3 * kelvin**1.5 / (kelvin + 245.4 * 10.0 ** (-12.0 / kelvin))


@njit(cache=True, fastmath=FAST)
def nusselt(rule: int, width: float, height: float, mean: float, difference: float) -> float:
    """Nusselt number of a cavity; mean : °C, difference : K of its faces."""
    kelvin = mean + 273.15
    viscosity = 1.458e-6 * kelvin**1.5 / (kelvin + 110.4)
    density = PRESSURE / (GAS_CONSTANT * kelvin)
    grashof = GRAVITY * width**3 * abs(difference) * density**2 / (kelvin * viscosity**2)
    rayleigh = grashof * viscosity * SPECIFIC_HEAT / air_conductivity(mean)
    if rayleigh < 1.0:
        return 1.0
    if rule == EN_673:
        return max(1.0, 0.035 * rayleigh**0.38)
    turbulent = 0.0605 * rayleigh ** (1.0 / 3.0)
    middle = 0.104 * rayleigh**0.293 / (1.0 + (6310.0 / rayleigh) ** 1.36)
    laminar = 0.242 * (rayleigh * width / height) ** 0.272
    return max(turbulent, max((1.0 + middle**3) ** (1.0 / 3.0), laminar))


@njit(cache=True, fastmath=FAST)
def add_convection(
    temperature: Array, cavities: Cavities, conduction: Exchange, total: Exchange, flow: Array, plane: int
) -> None:
    """Add what moving air carries beyond air at rest to flow (N,), W, and its slope to total."""
    for c in range(cavities.material.size):
        area = conduction.z[cavities.material[c]].reshape(temperature.size)
        width, height, rule = cavities.width[c], cavities.height[c], cavities.rule[c]
        for i in range(temperature.size - plane):
            if area[i] > 0.0:
                one, two = temperature[i], temperature[i + plane]
                mean = max(0.5 * (one + two), -200.0)
                beyond = nusselt(rule, width, height, mean, one - two) - 1.0
                g = area[i] * beyond * air_conductivity(mean) / width
                flow[i] -= g * (one - two)
                flow[i + plane] += g * (one - two)
                total.z[i] += STEEPER * g
