"""The nouns of a study: a point of the grid, what it came to, the reference and the study itself."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Measure:
    """One kind of error: its name, what a user calls it, its unit and how many of it make that unit."""

    name: str
    label: str
    unit: str
    scale: float = 1.0

    def show(self, value: float | None) -> str:
        """For example 0.012 mm."""
        if value is None or not math.isfinite(value):
            return ""
        return f"{value * self.scale:.3g} {self.unit}"


@dataclass(frozen=True)
class Point:
    """One way to simulate the scene.

    curve : points of one curve differ in `size` alone; size : the step (s) or the tolerance
    overrides : what it changes in the scene, by dotted keys
    effect : whether it changes what is simulated rather than how; shown, but never advised
    """

    curve: str
    size: float
    overrides: Mapping[str, Any]
    effect: bool = False

    @property
    def name(self) -> str:
        return f"{self.curve}, {self.size:g}"


@dataclass
class Outcome:
    """What a point came to.

    status : "ok", or why it has no error; errors {measure: error in SI units, or None}
    seconds : each repetition's time for one simulated second (a robot) or for the whole test (a door), s
    late : each repetition's 99th percentile over its median of a step's time
    step : s of simulated time for one step, None where the method chooses
    effect : as the point's
    model : formulation, or the door's model, that it is simulated with
    """

    point: str
    curve: str
    size: float
    overrides: dict[str, Any]
    status: str
    errors: dict[str, float | None] = field(default_factory=dict)
    seconds: list[float] = field(default_factory=list)
    step: float | None = None
    effect: bool = False
    late: list[float] = field(default_factory=list)
    model: str = ""

    @property
    def ok(self) -> bool:
        return self.status == "ok" and bool(self.seconds)

    @property
    def median(self) -> float:
        return float(np.median(self.seconds))

    @property
    def least(self) -> float:
        """The least time: other programs only add."""
        return float(min(self.seconds))

    @property
    def p99(self) -> float:
        """The 99th percentile over the median of a step's time, of the least disturbed repetition."""
        return float(min(self.late, default=1.0))

    @property
    def spread(self) -> float:
        """Half the range of the repetitions, relative to their median."""
        return (max(self.seconds) - min(self.seconds)) / (2.0 * self.median)

    def error(self, measure: str) -> float:
        """The error, infinite where there is none."""
        value = self.errors.get(measure)
        return math.inf if value is None else value

    def record(self) -> dict[str, Any]:
        """The outcome as JSON says it."""
        return asdict(self)


@dataclass
class Reference:
    """The best answer, a bound on its own error, and how it was found.

    arrays : what points are compared with; error {measure: a bound on its own error, infinite where it has
        not settled}; how : a sentence; finer : what would make the bound smaller
    formulations : {another formulation, or model: {"distance" of its converged tip from the reference, m,
        and the "uncertainty" of that}}, or {"refused": why that isn't known}
    orders : {what was refined: the order that it showed}
    """

    arrays: dict[str, Array]
    error: dict[str, float]
    how: str
    formulations: dict[str, dict[str, Any]] = field(default_factory=dict)
    finer: str = ""
    orders: dict[str, float] = field(default_factory=dict)


class Study(Protocol):
    """What robots and doors have in common."""

    kind: str
    measures: tuple[Measure, ...]

    @property
    def fingerprint(self) -> dict[str, Any]:
        """What a kept point depends on."""
        ...

    def points(self) -> list[Point]:
        """The grid, cheapest first."""
        ...

    def reference(self, progress: Callable[[str], None]) -> Reference:
        """Make the reference."""
        ...

    def measure(self, point: Point, reference: Reference) -> Outcome:
        """Run a point."""
        ...

    def conditions(self, outcome: Outcome, reference: Reference, tolerance: float | None) -> dict[str, Any]:
        """What the advice depends on: other durations, motions nearby, times taken alone."""
        ...
