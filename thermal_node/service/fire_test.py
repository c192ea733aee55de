"""A door under test: heat, probes, criteria and the furnace, stepped together."""

from __future__ import annotations

import numpy as np

from ..burning.march import Heat, Saved
from ..burning.status import State, Status
from ..criteria.criteria import Criteria
from ..criteria.tolerance import FurnaceTolerance
from ..furnace.furnace import Measured
from ..heat.conduction import Array
from ..mesh.whole import whole_leaf
from ..model.door_model import door_model
from ..model.probes import InfraredView, Radiometer, probes_of
from ..model.reacted import Reacted
from ..scene.load import Scene

KEPT = 1000
"""Measured values that are remembered; the march only asks for the latest."""


class FireTest:
    """A door that burns.

    Attributes
    ----------
    time : s of fire exposure
    readings (P,) : °C, of `probes`
    temperature (N,) : °C, of the whole leaf's nodes (mesh.whole)
    reactions (R,) : how far each of `reacted` has gone, 0 to 1
    measured : the furnace's log, or None while the scene's own furnace burns
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.model = door_model(scene)
        self.heat = Heat(self.model)
        self.probes = probes_of(self.model)
        self.infrared = InfraredView(self.model)
        self._radiometer = Radiometer(self.model)
        self.reacted = Reacted(self.model)
        self.whole = whole_leaf(self.model.mesh, scene.leaf.width, scene.leaf.height)
        self.reset()

    def warm(self) -> None:
        """Compile, or load, the kernels."""
        self.heat.advance(2.0)
        self.reset()

    def reset(self) -> None:
        """Back to the cold door and the scene's own furnace."""
        self.measured: Measured | None = None
        self.heat.furnace = self.model.furnace
        self.heat.reset()
        self.criteria = Criteria(self.scene.criteria, self.probes, self.model.initial)
        self._broken = Status()
        self._before: Saved | None = None
        self._look()

    @property
    def tolerance(self) -> FurnaceTolerance:
        """How the furnace keeps to the curve of the foremost standard."""
        return self.criteria.judgements[0].tolerance

    @property
    def time(self) -> float:
        return self.heat.time

    @property
    def status(self) -> Status:
        """Whether the test goes on, or why not."""
        return self.heat.status if self._broken.ok else self._broken

    @property
    def temperature(self) -> Array:
        return np.asarray(self.heat.temperature[self.whole.source])

    @property
    def reactions(self) -> Array:
        return self.reacted.read(self.heat.degree)

    @property
    def furnace(self) -> float:
        """The furnace's temperature now, °C."""
        return float(self.heat.furnace(self.heat.time))

    @property
    def stale(self) -> float:
        """s since the last measured temperature; 0 where nothing was measured."""
        return 0.0 if self.measured is None else self.heat.time - self.measured.time[-1]

    def measure(self, temperature: float) -> None:
        """From now on the furnace is at this temperature, °C, until the next one."""
        if self.measured is None:
            self.measured = Measured()
            self.heat.furnace = self.measured
        if not self.measured.add(self.heat.time, temperature):
            self.measured.temperature[-1] = temperature
        del self.measured.time[:-KEPT], self.measured.temperature[:-KEPT]
        if self.heat.time == 0.0:
            self.heat.reset()  # its first step is chosen by what the furnace does

    def advance(self, time: float) -> Status:
        """March to `time`, s; where the march has to stop, the last good state stays."""
        if not self.status.ok:
            return self.status
        seen: list[tuple[float, Array, float]] = []
        if self.measured is not None:
            self._before = self.heat.save()
        self.heat.advance(time, lambda: self._read(seen))
        if not np.isfinite(self.heat.temperature).all():
            self._broken = Status(
                State.NOT_FINITE, f"stopped at {self.time:.3f} s: a temperature is not finite"
            )
        if self.status.ok or self.measured is None:
            self._judge(seen)  # a tick that may be undone, see go_on, is not judged
        return self.status

    def go_on(self) -> bool:
        """After a stop, be where this tick began, for what the furnace measures now; whether that can be.

        Only a measured furnace may do otherwise at the same time: all else would stop there again.
        """
        if self.status.ok or self._before is None:
            return False
        steps, rejected = self.heat.steps, self.heat.rejected
        self.heat.restore(self._before)
        self.heat.steps, self.heat.rejected = steps, rejected
        self._broken = Status()
        self._read([])
        return True

    def _look(self) -> None:
        """Judge the state as it is now."""
        seen: list[tuple[float, Array, float]] = []
        self._read(seen)
        self._judge(seen)

    def _read(self, seen: list[tuple[float, Array, float]]) -> None:
        """Note what the criteria judge: time, readings, radiation."""
        temperature = self.heat.temperature
        if np.isfinite(temperature).all():
            self.readings = self.probes.read(temperature)
            seen.append((self.time, self.readings, self._radiometer.read(temperature)))

    def _judge(self, seen: list[tuple[float, Array, float]]) -> None:
        for time, readings, radiated in seen:
            self.criteria.watch(time, readings, radiated)
            self.criteria.watch_furnace(time, self.heat.furnace)
