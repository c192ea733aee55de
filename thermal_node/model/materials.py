"""Materials of a fire door: how they conduct, store heat, stretch and soften.

A material is a density and curves over temperature. A curve is a list of knots, its
values there and the exact integral of the curve up to each knot; between knots the integral
is the cubic that has those values and slopes, so a piecewise linear table is integrated
exactly and the Eurocode's closed forms to rounding. The heat solver only ever asks for the
integrals (enthalpy, and the conductivity integral of Kirchhoff) and their slopes.

Sources: EN 1993-1-2:2005 clauses 3.4.1.1 (elongation), 3.4.1.2 (specific heat), 3.4.1.3
(conductivity), table 3.1 (reduction factors).
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..scene.reactions_part import ReactionPart

Array = NDArray[np.float64]

EUROCODE_LOW, EUROCODE_HIGH = 20.0, 1200.0
"""°C between which EN 1993-1-2 defines steel; outside, the end value is held."""
STEEL_DENSITY = 7800.0
"""kg/m3, as the thesis takes it (section 3.4.1); EN 1993-1-2 clause 3.2.2 has 7850."""


@dataclass(frozen=True)
class Curve:
    """A property over temperature.

    Attributes
    ----------
    knots : ndarray (n,), °C, increasing
    values : ndarray (n,), the property at the knots
    integral : ndarray (n,), the property integrated from the first knot
    refuse_below, refuse_above : °C; the solver stops with the reason beyond these
    """

    knots: Array
    values: Array
    integral: Array
    refuse_below: float = -np.inf
    refuse_above: float = np.inf

    def __call__(self, temperature: ArrayLike) -> Array:
        """The property at `temperature` (°C), end values held."""
        return np.interp(np.asarray(temperature, dtype=float), self.knots, self.values)

    def integrated(self, temperature: ArrayLike) -> Array:
        """The property integrated from the first knot to `temperature` (°C)."""
        t = np.asarray(temperature, dtype=float)
        j = np.clip(np.searchsorted(self.knots, t, side="right") - 1, 0, len(self.knots) - 2)
        width = self.knots[j + 1] - self.knots[j]
        s = (t - self.knots[j]) / width
        inside = _hermite(
            s, width, self.integral[j], self.integral[j + 1], self.values[j], self.values[j + 1]
        )
        below = self.values[0] * (t - self.knots[0])
        above = self.integral[-1] + self.values[-1] * (t - self.knots[-1])
        return np.where(t < self.knots[0], below, np.where(t > self.knots[-1], above, inside))


def _hermite(s: Array, width: Array, y0: Array, y1: Array, d0: Array, d1: Array) -> Array:
    s2, s3 = s * s, s * s * s
    return (
        y0 * (2 * s3 - 3 * s2 + 1)
        + y1 * (3 * s2 - 2 * s3)
        + width * (d0 * (s3 - 2 * s2 + s) + d1 * (s3 - s2))
    )


def constant(value: float) -> Curve:
    """A property that does not depend on temperature."""
    knots = np.array([0.0, 1000.0])
    return Curve(knots, np.full(2, value), value * knots)


def table(temperature: ArrayLike, value: ArrayLike, beyond: str = "refuse") -> Curve:
    """A property given at temperatures (°C, increasing), straight between them.

    `beyond` says what holds outside the table. Above its last temperature: `refuse` (the run
    stops and says where), `hold` (the last value) or `extend` (the last slope). Below its
    first temperature the first value is held, whatever `beyond` is.
    """
    t = np.array(temperature, dtype=float)
    v = np.array(value, dtype=float)
    if beyond == "extend":
        slope = (v[-1] - v[-2]) / (t[-1] - t[-2])
        end = 3000.0 if slope >= 0.0 else min(3000.0, t[-1] - 0.5 * v[-1] / slope)
        t, v = np.append(t, end), np.append(v, v[-1] + slope * (end - t[-1]))
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))])
    return Curve(t, v, integral, refuse_above=t[-1] if beyond == "refuse" else np.inf)


def steel_specific_heat(temperature: ArrayLike) -> Array:
    """Specific heat of carbon steel, J/(kg K), EN 1993-1-2 clause 3.4.1.2."""
    t = np.clip(np.asarray(temperature, dtype=float), EUROCODE_LOW, EUROCODE_HIGH)
    return np.select(
        [t < 600.0, t < 735.0, t < 900.0],
        [
            425.0 + t * (0.773 + t * (-1.69e-3 + t * 2.22e-6)),
            666.0 + 13002.0 / np.maximum(738.0 - t, 1.0),
            545.0 + 17820.0 / np.maximum(t - 731.0, 1.0),
        ],
        650.0,
    )


def steel_enthalpy(temperature: ArrayLike) -> Array:
    """Specific heat of steel integrated from 20 °C, J/kg, in closed form."""
    t = np.asarray(temperature, dtype=float)
    c = np.clip(t, EUROCODE_LOW, EUROCODE_HIGH)

    def polynomial(x: Array | float) -> Array | float:
        return x * (425.0 + x * (0.773 / 2 + x * (-1.69e-3 / 3 + x * 2.22e-6 / 4)))

    low = polynomial(np.minimum(c, 600.0)) - polynomial(EUROCODE_LOW)
    x = np.clip(c, 600.0, 735.0)
    rising = 666.0 * (x - 600.0) - 13002.0 * np.log((738.0 - x) / 138.0)
    x = np.clip(c, 735.0, 900.0)
    falling = 545.0 * (x - 735.0) + 17820.0 * np.log((x - 731.0) / 4.0)
    high = 650.0 * np.maximum(c - 900.0, 0.0)
    outside = np.where(t < c, steel_specific_heat(c) * (t - c), 650.0 * (t - c))
    return np.asarray(low + rising + falling + high + outside)


def steel_conductivity(temperature: ArrayLike) -> Array:
    """Conductivity of carbon steel, W/(m K), EN 1993-1-2 clause 3.4.1.3."""
    t = np.clip(np.asarray(temperature, dtype=float), EUROCODE_LOW, EUROCODE_HIGH)
    return np.where(t < 800.0, 54.0 - 3.33e-2 * t, 27.3)


def steel_elongation(temperature: ArrayLike) -> Array:
    """Thermal elongation of carbon steel from 20 °C, -, EN 1993-1-2 clause 3.4.1.1.

    Below 20 °C the slope at 20 °C is continued (the clause begins there).
    """
    t = np.asarray(temperature, dtype=float)
    cold = 1.2e-5 * 20.0 + 0.4e-8 * 400.0 - 2.416e-4 + (1.2e-5 + 0.8e-8 * 20.0) * (t - 20.0)
    return np.select(
        [t < 20.0, t < 750.0, t < 860.0],
        [cold, 1.2e-5 * t + 0.4e-8 * t * t - 2.416e-4, 0.011],
        2e-5 * t - 6.2e-3,
    )


_FACTOR_TEMPERATURE = np.array(
    [20, 100, 200, 300, 400, 500, 600, 700, 800, 900, 1000, 1100, 1200], dtype=float
)
_MODULUS_FACTOR = np.array([1, 1, 0.9, 0.8, 0.7, 0.6, 0.31, 0.13, 0.09, 0.0675, 0.045, 0.0225, 0.0])
_YIELD_FACTOR = np.array([1, 1, 1, 1, 1, 0.78, 0.47, 0.23, 0.11, 0.06, 0.04, 0.02, 0.0])


def steel_modulus_factor(temperature: ArrayLike) -> Array:
    """E(T) / E(20 °C) of carbon steel, -, EN 1993-1-2 table 3.1."""
    return np.interp(np.asarray(temperature, dtype=float), _FACTOR_TEMPERATURE, _MODULUS_FACTOR)


def steel_yield_factor(temperature: ArrayLike) -> Array:
    """Effective yield strength over that at 20 °C, -, EN 1993-1-2 table 3.1."""
    return np.interp(np.asarray(temperature, dtype=float), _FACTOR_TEMPERATURE, _YIELD_FACTOR)


@dataclass(frozen=True)
class Material:
    """One material.

    density : kg/m3; specific_heat : curve, J/(kg K); conductivity : curve, W/(m K)
    youngs_modulus : curve, Pa; poissons_ratio : -; elongation : curve, - from 20 °C
    """

    name: str
    density: float
    specific_heat: Curve
    conductivity: Curve
    youngs_modulus: Curve = field(default_factory=lambda: constant(1.0))
    poissons_ratio: float = 0.0
    elongation: Curve = field(default_factory=lambda: constant(0.0))
    reactions: tuple[ReactionPart, ...] = ()
    oxygen_diffusivity: float = 0.0

    @property
    def remaining(self) -> float:
        """Density of what stays in a fire, kg/m3."""
        return self.density * (1.0 - sum(r.share * (1.0 - r.residue) for r in self.reactions))

    def enthalpy(self, temperature: ArrayLike) -> Array:
        """Heat per volume of what stays, from the specific heat's first knot, J/m3."""
        return self.remaining * self.specific_heat.integrated(temperature)


def _steel_knots() -> Array:
    approach = np.geomspace(0.05, 135.0, 60)
    return np.unique(
        np.concatenate(
            [
                np.linspace(20.0, 900.0, 89),
                735.0 - approach,
                735.0 + approach,
                [600.0, 735.0, 800.0, 900.0, 1200.0],
            ]
        )
    )


def steel(density: float = STEEL_DENSITY, youngs_modulus: float = 2.1e11) -> Material:
    """Carbon steel of EN 1993-1-2, with its specific heat peak of 5000 J/(kg K) at 735 °C."""
    knots = _steel_knots()
    k = steel_conductivity(knots)
    stretch = np.arange(-250.0, 1251.0, 10.0)
    return Material(
        name="steel",
        density=density,
        specific_heat=Curve(knots, steel_specific_heat(knots), steel_enthalpy(knots)),
        conductivity=Curve(
            knots, k, np.concatenate([[0.0], np.cumsum(0.5 * (k[1:] + k[:-1]) * np.diff(knots))])
        ),
        youngs_modulus=table(_FACTOR_TEMPERATURE, youngs_modulus * _MODULUS_FACTOR, "hold"),
        poissons_ratio=0.3,
        elongation=table(stretch, steel_elongation(stretch), "extend"),
    )
