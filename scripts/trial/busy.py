"""Whether the machine was too busy for a trial in real time, in figures: load comes before what it led to."""

from __future__ import annotations

import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from ..bag import Bag, BagError
from ..bag.diagnostics import TYPE, statuses

# Share of deadlines that a machine which has the time misses at most, and how far behind it falls.
MISSED = 0.01
LATE = 5e-3  # s, the 99th percentile: a controller at 500 Hz then answers states that are long gone


@dataclass(frozen=True)
class Pace:
    """How a simulator kept its deadlines, by its own last word.

    Attributes
    ----------
    ticks, overruns : deadlines, and those that were missed; run : the most of these in a row
    late_p99, late_worst, lost : s
    """

    ticks: int
    overruns: int
    run: int
    late_p99: float
    late_worst: float
    lost: float

    @property
    def kept(self) -> bool:
        """Whether the deadlines were kept, on the whole."""
        return self.overruns <= MISSED * self.ticks and self.late_p99 < LATE and self.lost == 0.0


def pace_of(folder: Path) -> Pace | None:
    """Read how a trial's simulator kept its deadlines; None where its bag does not say."""
    found: dict[str, float | None] = {}
    with suppress(BagError, OSError):
        bag = Bag(folder)
        topic = next((t.name for t in bag.topics.values() if t.type == TYPE and t.count), None)
        for _, data in bag.messages(topic) if topic else ():
            for status in statuses(data):
                if "overruns" in status.values:
                    found = {key: status.number(key) for key in KEYS}
    if not found or any(value is None for value in found.values()):
        return None
    ticks, overruns, run, late, worst, lost = (found[key] or 0.0 for key in KEYS)
    return Pace(int(ticks), int(overruns), int(run), 1e-6 * late, 1e-6 * worst, lost)


KEYS = (
    "ticks",
    "overruns",
    "overruns in a row, worst",
    "lateness p99, µs",
    "lateness worst, µs",
    "lost time, s",
)


def too_busy(folder: Path) -> str:
    """Say that the machine was too busy, with the figures; "" where a trial's robot had the time it needs."""
    pace = pace_of(folder)
    if pace is None or pace.kept:
        return ""
    load, cores = os.getloadavg()[0], len(os.sched_getaffinity(0))
    return (
        f"this machine was too busy for real time: {pace.overruns} of {pace.ticks} deadlines missed,"
        f" {pace.run} in a row, up to {1e3 * pace.late_worst:.1f} ms late, {pace.lost:.2f} s lost;"
        f" load {load:.1f} on {cores} processors"
    )
