"""Fire resistance criteria, judged while a door burns, and the verdict in words.

Each standard judges by its own points and rules (standards.py), and only while the furnace is its own.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..deformation.deflection import Deflection
from ..furnace.furnace import CURVES, Curve
from ..heat.conduction import Array
from ..model.probes import Probes
from ..scene.criteria_part import CriteriaPart
from ..scene.doubts import doubts
from ..scene.standards import leaf_points
from .criterion import Criterion
from .judgement import Judgement

LOOK = 5.0
"""s between looks at the furnace, at most."""


class Criteria:
    """The criteria of a scene, watched as time goes on.

    judgements : one a standard, the first one foremost; own : criteria of the scene's own limits
    """

    def __init__(self, part: CriteriaPart, probes: Probes, initial: float) -> None:
        self.minutes = part.minutes
        keys = part.standards
        self.judgements = [Judgement(key, probes, alone=i == 0) for i, key in enumerate(keys)]
        self._initial = initial
        self._five = np.array([probes.name.index(name) for name in leaf_points(1.0, 1.0)])
        self.own: list[Criterion] = []
        self._mean = self._own("own mean temperature rise", "K", part.mean_rise)
        self._maximum = self._own("own maximum temperature rise", "K", part.maximum_rise)
        self._gap = self._own("gap at the edge", "m", part.gap)
        self._deflection = self._own("deflection", "m", part.deflection)
        self.doubts = doubts(probes.scene)
        self.time = 0.0
        self._furnace_time: float | None = None

    def _own(self, name: str, unit: str, limit: float | None) -> Criterion | None:
        if limit is None:
            return None
        self.own.append(Criterion(name, unit, limit, clause="the scene's criteria"))
        return self.own[-1]

    @property
    def each(self) -> list[Criterion]:
        """Every criterion, the foremost standard's first."""
        return [c for j in self.judgements for c in j.criteria] + self.own

    def watch(self, time: float, readings: Array, radiated: float | None = None) -> None:
        """Judge the probes' readings (P,), °C, and the radiation at 1 m, W/m2, at a time, s."""
        rise = readings - self._initial
        for judgement in self.judgements:
            judgement.watch(time, rise, radiated)
        if self._mean is not None:
            self._mean.watch(time, float(rise[self._five].mean()))
        if self._maximum is not None:
            self._maximum.watch(time, float(rise[self._five].max()))
        self.time = time

    def watch_furnace(self, time: float, furnace: Callable[[float], float]) -> None:
        """Judge the furnace from where it was last looked at to `time`, s."""
        since = self._furnace_time
        self._furnace_time = time
        for judgement in self.judgements:
            curve = CURVES[judgement.standard.curve]
            if isinstance(furnace, Curve) and furnace.function is curve:
                judgement.tolerance.follow(time, float(curve(time)))
                continue
            count = 1 if since is None else max(1, int(np.ceil((time - since) / LOOK)))
            looks = [time] if since is None else list(np.linspace(since, time, count + 1)[1:])
            each = getattr(furnace, "thermocouples", None)
            for at, standard in zip(looks, curve(np.array(looks)), strict=True):
                seen = np.array([furnace(at)]) if each is None else each(at)
                judgement.tolerance.watch(float(at), float(standard), seen)

    def watch_deflection(self, time: float, shape: Deflection) -> None:
        """Judge a solved shape."""
        for judgement in self.judgements:
            judgement.watch_deflection(time, shape)
        if self._gap is not None:
            self._gap.watch(time, shape.gap)
        if self._deflection is not None:
            self._deflection.watch(time, shape.largest)

    def excess(self, time: float, shape: Deflection) -> Array:
        """How far a shape is beyond each limit of gaps and deflection, m."""
        found = [v for j in self.judgements for v in j.excess(time, shape)]
        if self._gap is not None:
            found.append(shape.gap - self._gap.limit)
        if self._deflection is not None:
            found.append(shape.largest - self._deflection.limit)
        return np.array(found)

    @property
    def first_failure(self) -> Criterion | None:
        """The criterion of the foremost standard's class, or of one's own, that failed first."""
        first = self.judgements[0]
        found = [first.first(first.foremost), first.first("integrity"), *self.own]
        failed = [c for c in found if c is not None and c.failed]
        return min(failed, key=lambda c: c.time_of_failure or 0.0) if failed else None

    @property
    def time_to_failure(self) -> float | None:
        """s, or None while everything holds."""
        first = self.first_failure
        return None if first is None else first.time_of_failure

    def verdict(self, stopped: str = "") -> str:
        """What the door is worth, for people: the classes, then why, standard by standard."""
        several = len(self.judgements) > 1
        names = ", ".join(j.name for j in self.judgements)
        told = []
        for j in self.judgements:
            words = j.details(self.minutes)
            told.append(f"{j.standard.title}: {words}" if several else words)
        own = [
            f"{c.name} exceeded {c.limit:g} {c.unit} at {c.time_of_failure / 60.0:.1f} min"
            for c in self.own
            if c.time_of_failure is not None
        ]
        text = "; ".join([f"{names}: {' | '.join(told)}", *own, *(f"in doubt: {d}" for d in self.doubts)])
        return f"{text}; {stopped}" if stopped else text
