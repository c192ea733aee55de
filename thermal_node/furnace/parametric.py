"""Parametric temperature-time curve of a natural fire in a compartment, EN 1991-1-2:2002 Annex A.

Holds for compartments of up to 500 m2 floor and 4 m height without openings in the roof, whose fire load
burns out completely, A (1): what the scene can't know of the compartment is not checked.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

SHORTEST = {"slow": 25.0, "medium": 20.0, "fast": 15.0}
"""t_lim, minutes, by the fire's growth rate, Annex A (10)."""
REFERENCE = 0.04 / 1160.0
"""Opening factor over absorptivity at which Gamma is 1, (A.2a)."""


@dataclass(frozen=True)
class ParametricFire:
    """Gas temperature, °C, of a fire that grows, burns out and cools to 20 °C.

    opening_factor : O, m^0.5, 0.02 to 0.20; absorptivity : b, J/(m2 s^0.5 K), 100 to 2200
    fire_load : q_td, MJ/m2 of the whole enclosing surface, 50 to 1000; growth : slow, medium or fast
    """

    opening_factor: float
    absorptivity: float
    fire_load: float
    growth: str = "medium"

    @property
    def expansion(self) -> float:
        """Gamma, by which time is stretched, (A.2a)."""
        return (self.opening_factor / self.absorptivity / REFERENCE) ** 2

    @property
    def ventilation_time(self) -> float:
        """0.2e-3 q_td / O, hours: how long the openings let the load burn, (A.7)."""
        return 0.2e-3 * self.fire_load / self.opening_factor

    @property
    def fuel_controlled(self) -> bool:
        """Whether the load burns faster than the openings limit it, (A.7)."""
        return self.ventilation_time <= SHORTEST[self.growth] / 60.0

    @property
    def hottest_time(self) -> float:
        """t_max, hours, (A.7)."""
        return max(self.ventilation_time, SHORTEST[self.growth] / 60.0)

    @property
    def heating_expansion(self) -> float:
        """Gamma while the fire heats; Gamma_lim of (A.8) to (A.10) where it is controlled by its fuel."""
        if not self.fuel_controlled:
            return self.expansion
        opening, load, b = self.opening_factor, self.fire_load, self.absorptivity
        limited = 0.1e-3 * load / self.hottest_time
        gamma = (limited / b / REFERENCE) ** 2
        if opening > 0.04 and load < 75.0 and b < 1160.0:
            gamma *= 1.0 + (opening - 0.04) / 0.04 * (load - 75.0) / 75.0 * (1160.0 - b) / 1160.0
        return gamma

    @property
    def hottest(self) -> float:
        """Theta_max, °C."""
        return float(_heating(self.hottest_time * self.heating_expansion))

    def at(self, time: ArrayLike) -> Array:
        """Gas temperature, °C, at times, s, (A.1) and (A.11)."""
        hours = np.maximum(np.asarray(time, dtype=float), 0.0) / 3600.0
        # While it cools, t* counts with Gamma whatever it was before, (A.12).
        full = self.ventilation_time * self.expansion
        start = self.hottest_time * self.expansion
        since = hours * self.expansion - start
        fall = float(np.clip(250.0 * (3.0 - full), 250.0, 625.0))
        cooled = np.maximum(self.hottest - fall * since, 20.0)
        heated = _heating(hours * self.heating_expansion)
        return np.where(hours <= self.hottest_time, heated, cooled)

    def __call__(self, time: float) -> float:
        return float(self.at(time))


def _heating(t: ArrayLike) -> Array:
    """(A.1), °C, of the stretched time t*, hours."""
    h = np.asarray(t, dtype=float)
    return 20.0 + 1325.0 * (
        1.0 - 0.324 * np.exp(-0.2 * h) - 0.204 * np.exp(-1.7 * h) - 0.472 * np.exp(-19.0 * h)
    )
