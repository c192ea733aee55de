"""What simulators and others said of themselves on /diagnostics: warnings, overruns, validity."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

from ..bag.diagnostics import LEVELS, OK, Status

# s after which a status that is not repeated counts as a further episode.
LONGEST_SILENCE = 5.0
LIMITS = re.compile(r"^(?P<name>.+), limits$")
ENERGIES = ("kinetic energy, J", "elastic energy, J", "gravitational energy, J")


@dataclass
class Episode:
    """A status that was not well for some time: from when to when, s since the bag's start."""

    name: str
    begin: float
    end: float
    level: int
    message: str
    times: int = 1

    @property
    def word(self) -> str:
        """`warning`, `error` or `stale`."""
        return LEVELS.get(self.level, "error")


@dataclass
class Overruns:
    """Deadlines that were missed between two reports."""

    at: float
    count: int


@dataclass
class Largest:
    """The largest value of a figure of the validity watch, when, and its limits."""

    value: float
    at: float
    warn: float | None = None
    stop: float | None = None


@dataclass
class Said:
    """What was said, as it was read.

    Attributes
    ----------
    episodes : by begin
    overruns : those that were reported, by time
    ticks : int, deadlines in all
    values : the last of each number, by status and key
    validity : the largest of each figure
    energy : (time of the bag, simulated time, total, kinetic energy) of each report, s, s, J, J
    steps : (time of the bag, status' own step times by key) of each report, s, µs
    scene : the name of that whose validity, energy and steps are taken, where there are several; "": all
    """

    episodes: list[Episode] = field(default_factory=list)
    overruns: list[Overruns] = field(default_factory=list)
    values: dict[str, dict[str, str]] = field(default_factory=dict)
    validity: dict[str, Largest] = field(default_factory=dict)
    energy: list[tuple[float, float, float, float]] = field(default_factory=list)
    steps: list[tuple[float, dict[str, float]]] = field(default_factory=list)
    scene: str = ""
    _open: dict[tuple[str, str], Episode] = field(default_factory=dict)
    _missed: dict[tuple[str, str], float] = field(default_factory=dict)

    def add(self, time: float, statuses: Iterable[Status]) -> None:
        """Take up a message that came at a time, s since the bag's start."""
        for status in statuses:
            self.values[status.name] = status.values
            self._level(time, status)
            self._overruns(time, status)
            if self.scene and status.hardware not in ("", self.scene):
                continue
            if "validity" in status.name.lower():
                self._validity(time, status)
            parts = [status.number(key) for key in ENERGIES]
            known = [e for e in parts if e is not None]
            if len(known) == len(ENERGIES):
                self.energy.append((time, status.stamp, sum(known), known[0]))
            step = {k: n for k in status.values if k.endswith(", µs") and (n := status.number(k)) is not None}
            if step:
                self.steps.append((time, step))

    def number(self, key: str) -> float | None:
        """Return the last value of a key that any status had."""
        for values in self.values.values():
            if key in values:
                try:
                    return float(values[key])
                except ValueError:
                    return None
        return None

    @property
    def missed(self) -> int:
        """Deadlines missed in all."""
        return sum(o.count for o in self.overruns)

    def _level(self, time: float, status: Status) -> None:
        running = self._open.get(whose(status))
        if status.level == OK:
            self._open.pop(whose(status), None)
            return
        if running is None or time - running.end > LONGEST_SILENCE:
            new = Episode(status.name, time, time, status.level, status.message)
            self._open[whose(status)] = new
            self.episodes.append(new)
            return
        running.end = time
        running.times += 1
        if status.level > running.level:
            running.level, running.message = status.level, status.message

    def _overruns(self, time: float, status: Status) -> None:
        now = status.number("overruns")
        if now is None:
            return
        # A count that has become less is that of a simulator that was started anew.
        before = self._missed.get(whose(status), 0.0)
        more = now - before if now >= before else now
        self._missed[whose(status)] = now
        if more > 0:
            self.overruns.append(Overruns(time, int(more)))

    def _validity(self, time: float, status: Status) -> None:
        for key in status.values:
            value = status.number(key)
            if value is None or LIMITS.match(key):
                continue
            known = self.validity.get(key)
            if known is None or value > known.value:
                self.validity[key] = Largest(value, time, *limits(status.values.get(f"{key}, limits", "")))


def whose(status: Status) -> tuple[str, str]:
    """Return what tells a status from that of another simulator."""
    return status.name, status.hardware


def limits(words: str) -> tuple[float | None, float | None]:
    """Read the limits of a figure as they are said: `warn, stop`."""
    try:
        warn, stop = (float(word) for word in words.split(","))
    except ValueError:
        return None, None
    inf = float("inf")
    return (warn if warn < inf else None), (stop if stop < inf else None)
