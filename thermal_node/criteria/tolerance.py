"""Whether a furnace kept to its standard's curve, so that the test is one."""

from __future__ import annotations

import numpy as np

from ..heat.conduction import Array
from ..scene.standards import STANDARDS, Tolerance

HOUR = 60.0


class FurnaceTolerance:
    """A furnace against its curve: EN 1363-1 clause 5.1.2 where no other rule is given.

    The area under the measured curve may differ from the standard's by a share that narrows with time; from
    10 min on, no thermocouple may be off by more than 100 °C. American standards judge the whole test's area
    alone.

    deviation, allowed : of the area now, %; farthest : °C, of a thermocouple now
    broken : what was first out of tolerance, or nothing; broken_at : s
    """

    def __init__(self, rule: Tolerance = STANDARDS["en_1634"].tolerance) -> None:
        self.rule = rule
        self.measured = self.standard = 0.0
        self.deviation = self.allowed = 0.0
        self.farthest = 0.0
        self._broken = ""
        self.broken_at: float | None = None
        self._last: tuple[float, float, float] | None = None

    @property
    def broken(self) -> str:
        """What is out of tolerance, or nothing."""
        if self._broken or self.rule.area != "american" or abs(self.deviation) <= self.allowed:
            return self._broken
        assert self._last is not None
        return self._area_said(self._last[0] / 60.0)

    def watch(self, time: float, standard: float, thermocouples: Array) -> bool:
        """Take the furnace's thermocouples, °C, at a time, s; True while within tolerance."""
        mean = float(np.mean(thermocouples))
        if self._last is not None:
            then, standard_then, mean_then = self._last
            self.standard += 0.5 * (standard + standard_then) * (time - then)
            self.measured += 0.5 * (mean + mean_then) * (time - then)
        self._last = (time, standard, mean)
        minutes = time / 60.0
        rule = self.rule
        self.allowed = allowed_deviation(minutes) if rule.area == "narrowing" else american_deviation(minutes)
        if self.standard > 0.0:
            self.deviation = 100.0 * (self.measured - self.standard) / self.standard
        self.farthest = float(np.max(np.abs(np.asarray(thermocouples) - standard)))
        if self._broken or rule.area == "american":
            return not self.broken
        # The first seconds' area is next to nothing; the standards sum it minute by minute.
        if time >= max(rule.since, 60.0) and abs(self.deviation) > self.allowed:
            self._broken, self.broken_at = self._area_said(minutes), time
        elif rule.each is not None and minutes >= 10.0 and self.farthest > rule.each:
            self._broken = (
                f"at {minutes:.1f} min a furnace thermocouple is {self.farthest:.0f} °C off, allowed"
                f" {rule.each:g} °C"
            )
            self.broken_at = time
        return not self._broken

    def follow(self, time: float, standard: float) -> None:
        """Take a furnace that is exactly on its curve, °C, at a time, s."""
        if self._last is not None:
            then, standard_then, mean_then = self._last
            self.standard += 0.5 * (standard + standard_then) * (time - then)
            self.measured += 0.5 * (standard + mean_then) * (time - then)
        self._last = (time, standard, standard)

    def _area_said(self, minutes: float) -> str:
        return (
            f"at {minutes:.1f} min the area under the furnace's curve is off by"
            f" {self.deviation:.1f} %, allowed {self.allowed:.1f} %"
        )


def allowed_deviation(minutes: float) -> float:
    """Allowed deviation of the area under the furnace's curve, %: EN 1363-1 5.1.2, FTP Code 8.3.1.3."""
    if minutes <= 10.0:
        return 15.0
    if minutes <= 30.0:
        return 15.0 - 0.5 * (minutes - 10.0)
    if minutes <= 60.0:
        return 5.0 - 0.083 * (minutes - 30.0)
    return 2.5


def american_deviation(minutes: float) -> float:
    """The same of UL 10B, UL 10C (5.4) and ASTM E119, by how long the whole test lasts, %."""
    if minutes <= HOUR:
        return 10.0
    return 7.5 if minutes <= 2.0 * HOUR else 5.0
