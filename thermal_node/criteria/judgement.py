"""What one standard makes of a door: its criteria, its furnace, its class, in words."""

from __future__ import annotations

import numpy as np

from ..deformation.deflection import Deflection
from ..heat.conduction import Array
from ..model.probes import Probes
from ..scene.schema import Scene
from ..scene.standards import STANDARDS, UL_RISE_TIME, UL_RISES, Standard
from .criterion import Criterion
from .tolerance import FurnaceTolerance

GAUGE, GAUGE_LENGTH, WIDE_GAUGE = 6e-3, 0.15, 25e-3
"""m: a gauge of 6 mm that can be moved over 150 mm, one of 25 mm; EN 1363-1 10.4.5, FTP Code app. 1 8.4.4."""
RADIATION_LIMIT = 15e3
"""W/m2 at 1 m: EN 13501-2 5.2.4."""


class Judgement:
    """A door judged by one standard.

    criteria : its criteria; tolerance : its furnace; missing : what could not be judged, in words
    """

    def __init__(self, key: str, probes: Probes, alone: bool) -> None:
        self.standard: Standard = STANDARDS[key]
        self.scene: Scene = probes.scene
        self.tolerance = FurnaceTolerance(self.standard.tolerance)
        suffix = "" if alone else f", {self.standard.title}"
        self.criteria: list[Criterion] = []
        self._rises: list[tuple[Criterion, Array, bool]] = []
        blind: set[str] = set()
        leaf = self.scene.leaf
        for rise in self.standard.rises:
            names = [name for places in rise.of for name in places(leaf.width, leaf.height)]
            names += self.scene.criteria.points if rise.extra else ()
            index = np.array([probes.name.index(name) for name in names])
            if probes.blind[index].any():
                blind.add(rise.name)
            made = Criterion(
                rise.name + suffix,
                "K",
                rise.limit,
                clause=rise.clause,
                kind=f"insulation{rise.kind}" if self.standard.insulation else "read",
                until=UL_RISE_TIME if self.standard.latch else np.inf,
            )
            self.criteria.append(made)
            self._rises.append((made, index, rise.mean))
        clause = self.standard.integrity_clause
        if self.standard.latch:
            self.latch = Criterion("movement of the latch edge" + suffix, "m", leaf.thickness, clause=clause)
            self.gauges = [self.latch]
        else:
            self.gauges = [
                Criterion(f"gap over {1e3 * GAUGE_LENGTH:g} mm" + suffix, "m", GAUGE, clause=clause),
                Criterion("gap anywhere" + suffix, "m", WIDE_GAUGE, clause=clause),
            ]
        for gauge in self.gauges:
            gauge.kind = "integrity"
        if self.scene.deformation.model != "none":
            self.criteria.extend(self.gauges)
        self.radiation = None
        if self.standard.radiation:
            self.radiation = Criterion(
                "radiation at 1 m" + suffix,
                "kW/m2",
                1e-3 * RADIATION_LIMIT,
                clause="EN 13501-2 5.2.4",
                kind="radiation",
            )
            self.criteria.append(self.radiation)
        self.blind = tuple(sorted(blind))
        self.time = 0.0

    def watch(self, time: float, rise: Array, radiated: float | None) -> None:
        """Judge the rises (P,), K, of all probes and the radiation at 1 m, W/m2, at a time, s."""
        self.time = time
        for criterion, index, mean in self._rises:
            at = rise[index]
            criterion.watch(time, float(at.mean() if mean else at.max()))
        if self.radiation is not None and radiated is not None:
            self.radiation.watch(time, 1e-3 * radiated)

    def watch_deflection(self, time: float, shape: Deflection) -> None:
        """Judge a solved shape: gap gauges, or the latch edge."""
        if self.standard.latch:
            self.latch.limit = self._latch_limit(time)
        for gauge, value in zip(self.gauges, self._openings(time, shape), strict=True):
            gauge.watch(time, value)

    def excess(self, time: float, shape: Deflection) -> list[float]:
        """How far a shape is beyond each limit of integrity, m."""
        limits = [self._latch_limit(time)] if self.standard.latch else [g.limit for g in self.gauges]
        return [v - limit for v, limit in zip(self._openings(time, shape), limits, strict=True)]

    def _latch_limit(self, time: float) -> float:
        """The leaf's thickness in the first half of the rating asked for, then half as much again, m."""
        asked = self.scene.criteria.minutes
        late = asked is not None and time > 30.0 * asked
        return self.scene.leaf.thickness * (1.5 if late else 1.0)

    def _openings(self, time: float, shape: Deflection) -> list[float]:
        if self.standard.latch:
            return [shape.edge_gap[shape.latch]]
        seals = self.scene.seals
        closed = 0.0 if seals.until is not None and time > seals.until else seals.bridged
        return [max(0.0, shape.lasting_gap(GAUGE_LENGTH) - closed), max(0.0, shape.gap - closed)]

    @property
    def integrity_judged(self) -> bool:
        """Whether a deformation was solved, by which gaps are judged."""
        return self.gauges[0].watched

    def held(self, kind: str) -> float:
        """Minutes that every criterion of a kind has held: insulation2, integrity, radiation."""
        ends = [
            self.time if c.time_of_failure is None else c.time_of_failure
            for c in self.criteria
            if c.kind == kind or (kind.startswith("insulation") and c.kind == "insulation")
        ]
        return (min(ends, default=self.time) + 1e-6) / 60.0

    def first(self, kind: str) -> Criterion | None:
        """The criterion of a kind that failed first; of an insulation class also those of every class."""
        failed = [
            c
            for c in self.criteria
            if c.time_of_failure is not None
            and (c.kind == kind or (kind.startswith("insulation") and c.kind == "insulation"))
        ]
        return min(failed, key=lambda c: c.time_of_failure or 0.0) if failed else None

    @property
    def foremost(self) -> str:
        """Kind of the foremost insulation class."""
        return f"insulation{self.standard.insulation[0]}" if self.standard.insulation else "read"

    def _class_of(self, minutes: float) -> int | None:
        reached = [m for m in self.standard.minutes if m <= minutes]
        return reached[-1] if reached else None

    @property
    def invalid(self) -> str:
        """Why this is no test of the standard, or nothing."""
        if not self.tolerance.broken:
            return ""
        return f"{self.tolerance.broken} ({self.standard.tolerance.clause}, curve {self.standard.curve})"

    @property
    def name(self) -> str:
        """The class that the time so far has earned, for example A-60 or EI2 30."""
        standard = self.standard
        if self.invalid:
            return f"no {standard.title} class"
        alone = "" if self.integrity_judged else " by insulation alone"
        if standard.latch:
            found = self._class_of(self.held("integrity"))
            name = f"{standard.title} {found} min" if found else f"no {standard.title} rating"
            return name if self.integrity_judged else f"{standard.title}, integrity not judged"
        if standard.integrity is not None:
            first = self.first("integrity")
            if first is not None and self.held("integrity") < standard.integrity:
                return f"no {standard.title} class"
            if self.integrity_judged and self.held("integrity") < standard.integrity:
                alone = f", {standard.integrity:g} min of integrity not reached yet"
            return f"{standard.mark}{self._class_of(self.held(self.foremost))}{alone}"
        minutes = self.held(self.foremost)
        if self.integrity_judged:
            minutes = min(minutes, self.held("integrity"))
        found = self._class_of(minutes)
        if standard.key == "astm_e119":
            return f"ASTM E119 {found} min{alone}" if found else "no ASTM E119 rating"
        mark = standard.mark if self.integrity_judged else standard.mark[1:]
        return f"{mark}{found}{'' if self.integrity_judged else alone}" if found else "no EI class"

    def details(self, asked: float | None, stopped: str = "") -> str:
        """What happened, for people."""
        if self.invalid:
            words = [f"not a valid {self.standard.title} test: {self.invalid}"]
            first = min(
                (c for c in self.criteria if c.failed), key=lambda c: c.time_of_failure or 0.0, default=None
            )
            if first is not None:
                words.append(_exceeded(first))
            return "; ".join(words)
        words = [self._held_or_not()]
        words += self._each_class()
        words += self._integrity_said()
        if self.blind:
            model = self.scene.solver.dimension
            words.append(
                f"the model ({model}) knows nothing of the edges that {', '.join(self.blind)} asks for"
            )
        if asked is not None:
            words.append(self._as_asked(asked))
        return "; ".join(words)

    def _held_or_not(self) -> str:
        failures = [c for c in (self.first(self.foremost), self.first("integrity")) if c is not None]
        failures.sort(key=lambda c: c.time_of_failure or 0.0)
        if failures:
            return ", ".join(_exceeded(c) for c in failures)
        numbers = [
            f"{c.name.split(',')[0].removesuffix(' temperature rise')} {c.value:.0f} of {c.limit:.0f} K"
            for c, _, _ in self._rises
            if c.kind in ("insulation", self.foremost)
        ]
        text = f"every criterion that was judged holds after {self.time / 60.0:.0f} min"
        return f"{text}; rise: {', '.join(numbers)}" if numbers else text

    def _each_class(self) -> list[str]:
        standard = self.standard
        if standard.latch:
            rise = self.criteria[0].value
            reached = [f for f, k in UL_RISES.items() if rise <= k]
            if self.time < UL_RISE_TIME - 1e-6:
                return [f"temperature rise {rise:.0f} K so far; it is read at 30 min"]
            word = f"class {reached[0]} °F" if reached else "no class of temperature rise"
            return [f"temperature rise at 30 min {rise:.0f} K: {word}"]
        if standard.key != "en_1634":
            return []
        words = []
        for kind, mark in (
            ("insulation1", "I1"),
            ("insulation2", "I2"),
            ("integrity", "E"),
            ("radiation", "W"),
        ):
            if kind == "integrity" and not self.integrity_judged:
                continue
            if kind == "radiation" and not (self.radiation and self.radiation.watched):
                continue
            words.append(f"{mark} {self._class_of(self.held(kind)) or 'none'}")
        return [", ".join(words)]

    def _integrity_said(self) -> list[str]:
        if not self.integrity_judged:
            return ["integrity not judged: no deformation was solved"]
        return [f"not computed: {self.standard.beside}"]

    def _as_asked(self, asked: float) -> str:
        mark = self.standard.mark or f"{self.standard.title} "
        name = f"{mark}{asked:g} as asked"
        needed = max(asked, self.standard.integrity or 0.0)
        insulated = self.held(self.foremost) >= asked if self.standard.insulation else True
        if self.first(self.foremost) is not None and not insulated:
            return f"{name}: failed"
        if self.integrity_judged and self.first("integrity") is not None and self.held("integrity") < needed:
            return f"{name}: failed"
        if not insulated or (self.integrity_judged and self.held("integrity") < needed):
            return f"{name}: not reached yet"
        if self.blind:
            return f"{name}: holds where it was computed, not at the edges"
        if not self.integrity_judged:
            return f"{name}: insulation passed, integrity not judged"
        return f"{name}: passed, but for what is not computed"


def _exceeded(c: Criterion) -> str:
    assert c.time_of_failure is not None
    return f"{c.name} exceeded {c.limit:g} {c.unit} at {c.time_of_failure / 60.0:.1f} min"
