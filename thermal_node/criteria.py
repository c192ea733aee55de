"""Fire resistance criteria, judged while a door burns, and the verdict in words.

Insulation: the FTP Code 2010 part 3 (A class: mean rise 140 K, any thermocouple 180 K; B and F:
140 and 225 K) and EN 1634-1 (140 and 180 K). A class holds for as many whole minutes of its
list as no criterion has failed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .conduction import Array
from .probes import Probes
from .schema import CriteriaPart

CLASSES = {"A": (0, 15, 30, 60), "B": (0, 15), "F": (0,)}
"""Minutes in a class' name: SOLAS II-2 regulation 3, FTP Code part 3."""
EI_MINUTES = (15, 20, 30, 45, 60, 90, 120, 180, 240)
"""EN 13501-2 clause 7.5.5."""
LIMITS = {"A": (140.0, 180.0), "B": (140.0, 225.0), "F": (140.0, 225.0)}


@dataclass
class Criterion:
    """One criterion: its value and limit in `unit`; when it failed, s, or None."""

    name: str
    unit: str
    limit: float
    value: float = 0.0
    time_of_failure: float | None = None
    _time: float = 0.0

    @property
    def failed(self) -> bool:
        """Whether the limit has ever been exceeded."""
        return self.time_of_failure is not None

    def watch(self, time: float, value: float) -> None:
        """Take a value at a time, s; the failure's time is interpolated between values."""
        if self.time_of_failure is None and value > self.limit:
            span = value - self.value
            share = (self.limit - self.value) / span if span > 0.0 else 1.0
            share = min(max(share, 0.0), 1.0)
            self.time_of_failure = self._time + share * (time - self._time)
        self.value, self._time = value, time


class Criteria:
    """The criteria of a scene, watched as time goes on."""

    def __init__(self, part: CriteriaPart, probes: Probes, initial: float) -> None:
        mean, maximum = LIMITS[part.division]
        self.division = part.division
        self.minutes = part.minutes
        self.mean_rise = Criterion("mean temperature rise", "K", part.mean_rise or mean)
        self.maximum_rise = Criterion("maximum temperature rise", "K", part.maximum_rise or maximum)
        self.each = [self.mean_rise, self.maximum_rise]
        self.gap = Criterion("gap at the edge", "m", part.gap) if part.gap else None
        self.deflection = Criterion("deflection", "m", part.deflection) if part.deflection else None
        self.each += [c for c in (self.gap, self.deflection) if c is not None]
        self.time = 0.0
        self._probes = probes
        self._initial = initial

    def watch(self, time: float, readings: Array) -> None:
        """Judge the probes' readings (P,), °C, at a time, s."""
        rise = readings - self._initial
        self.mean_rise.watch(time, float(rise[self._probes.mean_of].mean()))
        self.maximum_rise.watch(time, float(rise[self._probes.judged].max()))
        self.time = time

    def watch_deflection(self, time: float, gap: float, deflection: float) -> None:
        """Judge the largest gap and deflection, m."""
        if self.gap is not None:
            self.gap.watch(time, gap)
        if self.deflection is not None:
            self.deflection.watch(time, deflection)

    @property
    def first_failure(self) -> Criterion | None:
        """The criterion that failed first."""
        failed = [c for c in self.each if c.time_of_failure is not None]
        return min(failed, key=lambda c: c.time_of_failure or 0.0) if failed else None

    @property
    def time_to_failure(self) -> float | None:
        """s, or None while everything holds."""
        first = self.first_failure
        return None if first is None else first.time_of_failure

    def marine_class(self) -> str:
        """For example A-60: the class that the time so far has earned."""
        held = self._held_minutes()
        minutes = [m for m in CLASSES[self.division] if m <= held]
        return f"{self.division}-{minutes[-1]}"

    def building_class(self) -> str:
        """For example EI 60, or no EI class."""
        held = self._held_minutes()
        minutes = [m for m in EI_MINUTES if m <= held]
        return f"EI {minutes[-1]}" if minutes else "no EI class"

    def _held_minutes(self) -> float:
        end = self.time_to_failure
        return ((self.time if end is None else end) + 1e-6) / 60.0

    def verdict(self, stopped: str = "") -> str:
        """What the door is worth, for people."""
        first = self.first_failure
        name = self.marine_class()
        if self.division == "A":
            name += f" ({self.building_class()})"
        if first is None:
            text = (
                f"{name}: every criterion holds after {self.time / 60.0:.0f} min;"
                f" mean rise {round(self.mean_rise.value)} of {self.mean_rise.limit:.0f} K,"
                f" maximum {round(self.maximum_rise.value)} of {self.maximum_rise.limit:.0f} K"
            )
        else:
            assert first.time_of_failure is not None
            text = (
                f"{name}: {first.name} exceeded {first.limit:g} {first.unit}"
                f" at {first.time_of_failure / 60.0:.1f} min"
            )
        if self.minutes is not None:
            asked = f"{self.division}-{self.minutes:g}"
            if self._held_minutes() >= self.minutes:
                text += f"; {asked} as asked: passed"
            elif first is None:
                text += f"; {asked} as asked: not reached yet"
            else:
                text += f"; {asked} as asked: failed"
        return f"{text}; {stopped}" if stopped else text


class FurnaceTolerance:
    """Whether a furnace keeps to its curve: EN 1363-1 clause 5.1.2, ISO 834-1 clause 6.1.2.

    From 5 min on, the area under the measured curve may differ from the standard's by a share
    that narrows with time; from 10 min on, no thermocouple may be off by more than 100 °C.
    """

    def __init__(self) -> None:
        self.measured = self.standard = 0.0
        self.deviation = self.allowed = 0.0
        self.farthest = 0.0
        self.broken: str = ""
        self._last: tuple[float, float, float] | None = None

    def watch(self, time: float, standard: float, thermocouples: Array) -> bool:
        """Take the furnace's thermocouples, °C, at a time, s; True while within tolerance."""
        mean = float(np.mean(thermocouples))
        if self._last is not None:
            then, standard_then, mean_then = self._last
            self.standard += 0.5 * (standard + standard_then) * (time - then)
            self.measured += 0.5 * (mean + mean_then) * (time - then)
        self._last = (time, standard, mean)
        minutes = time / 60.0
        self.allowed = allowed_deviation(minutes)
        if self.standard > 0.0:
            self.deviation = 100.0 * (self.measured - self.standard) / self.standard
        self.farthest = float(np.max(np.abs(np.asarray(thermocouples) - standard)))
        if self.broken:
            return False
        if minutes >= 5.0 and abs(self.deviation) > self.allowed:
            self.broken = (
                f"at {minutes:.1f} min the area under the furnace's curve is off by"
                f" {self.deviation:.1f} %, allowed {self.allowed:.1f} %"
            )
        elif minutes >= 10.0 and self.farthest > 100.0:
            self.broken = (
                f"at {minutes:.1f} min a furnace thermocouple is {self.farthest:.0f} °C off, allowed 100 °C"
            )
        return not self.broken


def allowed_deviation(minutes: float) -> float:
    """Allowed deviation of the area under the furnace's curve, %."""
    if minutes <= 10.0:
        return 15.0
    if minutes <= 30.0:
        return 15.0 - 0.5 * (minutes - 10.0)
    if minutes <= 60.0:
        return 5.0 - 0.083 * (minutes - 30.0)
    return 2.5
