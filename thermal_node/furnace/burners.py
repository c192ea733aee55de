"""A lumped furnace whose burners follow a setpoint curve, for when nothing was measured.

The gas (ideal, at constant pressure) is heated by burners through a first-order lag and loses
heat to its walls, a thick solid of given effusivity e = sqrt(k rho c):

    C dT/dt = P(t) - q_wall A,     P' = (u P_max - P) / lag

The controller holds the mean at the setpoint: proportional and integral action on the error,
limited to 0..1 with the integral stopped at the limits. Each burner has its own part of the
gas and the walls, so that four thermocouples read four temperatures. The wall is a column of
nodes in the depth z sqrt(rho c / k), s^0.5, in which its effusivity is both conductivity and
heat capacity.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..scene.furnace_part import Burners

AIR_PRESSURE_HEAT = 101325.0 * 1005.0 / 287.05
"""rho c_p T of air at 1 atm, J/m3: the heat capacity per volume is this over T in kelvin."""
TICK = 0.5
"""s, step of the furnace's own march."""
UNEVEN = (1.0, 0.97, 1.02, 1.01)
"""How much of the mean power a burner's part of the furnace gets, repeated over the burners."""


WALL_DEPTH = np.concatenate([[0.0], np.cumsum(1.5 * 1.35 ** np.arange(10))])
"""Nodes in the wall, s^0.5; the first spacing keeps an explicit tick stable."""


class LumpedFurnace:
    """A furnace that tries to follow `setpoint`; call it for the mean gas temperature, °C."""

    def __init__(self, setpoint: Callable[[float], float], burners: Burners) -> None:
        self.setpoint = setpoint
        self.burners = burners
        start = setpoint(0.0)
        count = burners.count
        share = np.resize(UNEVEN, count)
        self._share = share / share.mean()
        self._gas = np.full(count, start)
        self._wall = np.full((len(WALL_DEPTH), count), start)
        self._power = np.zeros(count)
        self._integral = 0.0
        self._log = [self._gas.copy()]

    def thermocouples(self, time: float) -> np.ndarray:
        """One temperature a burner (count,), °C, at a time, s."""
        self._march(time)
        place = max(time, 0.0) / TICK
        i = min(int(place), len(self._log) - 2)
        return self._log[i] + (self._log[i + 1] - self._log[i]) * (place - i)

    def __call__(self, time: float) -> float:
        return float(self.thermocouples(time).mean())

    def _march(self, time: float) -> None:
        while (len(self._log) - 2) * TICK < time or len(self._log) < 2:
            self._tick((len(self._log) - 1) * TICK)

    def _tick(self, time: float) -> None:
        b = self.burners
        error = self.setpoint(time + TICK) - self._gas.mean()
        wanted = b.gain * (error + self._integral / b.integral_time)
        command = float(np.clip(wanted, 0.0, 1.0))
        if command == wanted or error * wanted < 0.0:
            self._integral += error * TICK
        self._power += (command * b.power - self._power) * (1.0 - np.exp(-TICK / max(b.lag, 1e-6)))
        capacity = AIR_PRESSURE_HEAT / (self._gas + 273.15) * b.volume / b.count
        area = b.wall_area / b.count
        surface = self._wall[0]
        film = 25.0 + 4.0 * 5.67e-8 * 0.8 * ((self._gas + surface) / 2.0 + 273.15) ** 3
        # Linearly implicit in the gas: it is far faster than the tick.
        supply = self._power * self._share + area * film * surface
        gas = (capacity / TICK * self._gas + supply) / (capacity / TICK + area * film)
        spacing = np.diff(WALL_DEPTH)[:, None]
        flux = b.wall_effusivity * -np.diff(self._wall, axis=0) / spacing
        inflow = np.vstack([film * (gas - surface), flux])
        outflow = np.vstack([flux, np.zeros((1, b.count))])
        half = np.pad(0.5 * spacing[:, 0], 1)
        width = b.wall_effusivity * (half[:-1] + half[1:])[:, None]
        self._wall = self._wall + TICK * (inflow - outflow) / width
        self._gas = gas
        self._log.append(self._gas.copy())
