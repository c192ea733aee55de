"""What a scene gives as a table over time: a furnace, what it radiates, a flux."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ..scene.furnace_part import FluxPart, RadiationPart

STEFAN_BOLTZMANN = 5.670374419e-8
"""W/(m2 K4), CODATA 2018; the kernels have their own, a room apart."""
ABSOLUTE_ZERO = -273.15


@dataclass(frozen=True)
class Table:
    """A value over time: straight between those given (K,), which begin at 0 s; the last is held."""

    time: NDArray[np.float64]
    value: NDArray[np.float64]

    def __call__(self, time: float) -> float:
        return float(np.interp(time, self.time, self.value))

    @property
    def end(self) -> float:
        """s; infinite for what stays as it is."""
        return float(self.time[-1]) if len(self.time) > 1 else np.inf


@dataclass(frozen=True)
class Radiation:
    """Radiation temperature, °C, of a furnace whose gas has another: EN 1991-1-2 clause 3.1 (6).

    An incident flux G, W/m2, is that of a black surrounding at (G / sigma)^(1/4).
    """

    table: Table
    is_flux: bool

    def __call__(self, time: float) -> float:
        value = self.table(time)
        return (value / STEFAN_BOLTZMANN) ** 0.25 + ABSOLUTE_ZERO if self.is_flux else value


def table_of(time: tuple[float, ...] | None, value: float | tuple[float, ...]) -> Table:
    """A table of what a scene gives: a number, or times and values."""
    if isinstance(value, tuple):
        return Table(np.array(time, dtype=float), np.array(value, dtype=float))
    return Table(np.zeros(1), np.array([value], dtype=float))


def radiation_of(part: RadiationPart | None) -> Radiation | None:
    """What a scene says of its furnace's radiation; None where it is that of the gas."""
    if part is None:
        return None
    if part.incident_flux is not None:
        return Radiation(table_of(part.time, part.incident_flux), True)
    assert part.temperature is not None
    return Radiation(table_of(part.time, part.temperature), False)


def flux_of(part: FluxPart | None) -> Table | None:
    """The heat flux that a scene prescribes on a surface, W/m2."""
    return None if part is None else table_of(part.time, part.value)
