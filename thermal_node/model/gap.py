"""What crosses a gap between two layers, in the form in which materials conduct.

The flow through a contact, W/m2, is (T1 - T2) / R, and that between the faces of a cavity is

    e sigma (T1^4 - T2^4) + (K(T1) - K(T2)) / d,    1/e = 1/e1 + 1/e2 - 1

with grey faces (EN 673:2011 clause 5.3.3, infinite parallel plates) and K the integral of the conductivity of
air: both are differences of a function of one temperature, as conduction is of Kirchhoff's integral. So a gap
is a material whose "conductivity" is the slope of that function, W/(m2 K), and its flow is exact. Air that
moves conducts Nu times as much; that depends on both temperatures (heat/convection.py).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ..heat.conduction import ABSOLUTE_ZERO, STEFAN_BOLTZMANN
from ..heat.convection import ELSHERBINY, EN_673, Cavities, air_conductivity
from ..mesh.gaps import Gap, gaps_of
from ..scene.leaf_part import CavityLayer, Leaf
from .materials import Array, Curve, Material, constant

RULES = {"en_673": EN_673, "elsherbiny": ELSHERBINY}
_NO_INDEX, _NO_NUMBER = np.zeros(0, dtype=np.int64), np.zeros(0)
NO_CAVITIES = Cavities(_NO_INDEX, _NO_INDEX, _NO_NUMBER, _NO_NUMBER)
COLDEST, HOTTEST, SPACING = -270.0, 3000.0, 5.0
"""°C and K of a cavity's knots; between them its flow is cubic, off by less than 1e-5 W/m2."""


def gap_material(gap: Gap) -> Material:
    """The gap as a material without heat."""
    if gap.resistance is not None:
        slope = constant(1.0 / gap.resistance)
    else:
        assert gap.cavity is not None
        slope = _cavity(gap.cavity)
    return Material(name=gap.name, density=0.0, specific_heat=constant(1.0), conductivity=slope)


def effective_emissivity(first: float, second: float) -> float:
    """Of two grey faces, -: EN 673:2011 clause 5.3.3."""
    return 1.0 / (1.0 / first + 1.0 / second - 1.0)


def _cavity(cavity: CavityLayer) -> Curve:
    knots = np.arange(COLDEST, HOTTEST + 1.0, SPACING, dtype=np.float64)
    e = effective_emissivity(*cavity.emissivity) * STEFAN_BOLTZMANN
    kelvin = knots - ABSOLUTE_ZERO
    return Curve(
        knots,
        4.0 * e * kelvin**3 + air_conductivities(knots) / cavity.thickness,
        e * (kelvin**4 - kelvin[0] ** 4) + _integrated(knots) / cavity.thickness,
    )


def air_conductivities(temperature: ArrayLike) -> Array:
    """Conductivity of air, W/(m K), at temperatures in °C; see convection.air_conductivity."""
    return np.array([air_conductivity(float(t)) for t in np.atleast_1d(temperature)])


def _integrated(knots: Array) -> Array:
    """Integral of the conductivity of air from the first knot, W/m, by Gauss points between them."""
    place, weight = np.polynomial.legendre.leggauss(4)
    middle, half = 0.5 * (knots[1:] + knots[:-1]), 0.5 * np.diff(knots)
    value = air_conductivities((middle[:, None] + half[:, None] * place).ravel()).reshape(-1, len(place))
    return np.asarray(np.concatenate([[0.0], np.cumsum(half * (value @ weight))]))


def cavities_of(leaf: Leaf, first: int) -> Cavities | None:
    """What the kernels need of cavities whose air moves; first : the first gap's number among materials."""
    moving = [
        (first + k, RULES[gap.cavity.convection], gap.cavity.thickness)
        for k, gap in enumerate(gaps_of(leaf))
        if gap.cavity is not None and gap.cavity.convection != "still"
    ]
    if not moving:
        return None
    material, rule, width = zip(*moving, strict=True)
    return Cavities(np.array(material), np.array(rule), np.array(width), np.full(len(width), leaf.height))
