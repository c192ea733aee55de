"""How much two runs differ, field by field, and what of them could not be compared."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

SECOND = 1_000_000_000


@dataclass
class Difference:
    """How much a field differs.

    Attributes
    ----------
    compared, only_first, only_second : messages that both, or one of the runs, have
    exact : whether every bit is the same
    largest : the greatest difference, in the field's unit
    at : s, its time
    component : which number of the field it is
    rms : root of the mean square of all differences
    size : the greatest absolute value of the first run
    since : s, the first time that differs; nan: none does
    why : what differs, where it is not a value: "length", "only in A"
    """

    name: str
    compared: int = 0
    only_first: int = 0
    only_second: int = 0
    exact: bool = True
    largest: float = 0.0
    at: float = np.nan
    component: int = 0
    size: float = 0.0
    since: float = np.nan
    why: str = ""
    squares: float = 0.0
    numbers: int = 0  # that were compared and are measures

    @property
    def rms(self) -> float:
        """Root of the mean square of all differences."""
        return float(np.sqrt(self.squares / self.numbers)) if self.numbers else 0.0

    @property
    def relative(self) -> float:
        """The greatest difference as a part of the greatest value."""
        if self.exact:
            return 0.0
        if self.why or not self.numbers:
            return np.inf
        return self.largest / self.size if self.size else np.inf

    def add(self, time: NDArray[np.int64], first: NDArray[Any], second: NDArray[Any]) -> None:
        """Take up some numbers (K, ...) of both runs."""
        self.compared += len(time)
        if not len(time):
            return
        a, b = (v if v.ndim == 2 else v.reshape(len(time), -1) for v in (first, second))
        if a.shape != b.shape:
            self.differs(time, "length")
            return
        if a.dtype != b.dtype:
            self.differs(time, f"{a.dtype} and {b.dtype}")
            return
        alike = bits(a) == bits(b)
        same = alike.all(axis=1)
        self.note(time, same)
        if a.dtype.kind != "f":  # counts, flags and bytes are the same or not
            return
        self.measures(a)
        if same.all():
            return
        with np.errstate(invalid="ignore", over="ignore"):
            off = np.abs(b.astype(np.float64, copy=False) - a.astype(np.float64, copy=False))
            # What is not a number differs without end, unless its bits are the same.
            off = np.where(alike, 0.0, off)
            off = np.where(np.isnan(off), np.inf, off)
            self.squares += float((off**2).sum())
        worst = int(off.argmax())
        if off.flat[worst] > self.largest:
            self.largest = float(off.flat[worst])
            row, self.component = divmod(worst, a.shape[1])
            self.at = time[row] / SECOND

    def measures(self, values: NDArray[Any]) -> None:
        """Take up how large the first run's numbers are."""
        self.numbers += values.size
        if values.size:
            self.size = max(self.size, greatest(values))

    def note(self, time: NDArray[np.int64], same: NDArray[np.bool_]) -> None:
        """Note which messages are the same."""
        if not same.all():
            self.exact = False
            self.since = np.fmin(self.since, time[int(np.argmin(same))] / SECOND)

    def differs(self, time: NDArray[np.int64], why: str) -> None:
        """Note that the messages differ in what is no value."""
        if len(time):
            self.exact, self.why = False, self.why or why
            self.since = np.fmin(self.since, time[0] / SECOND)


@dataclass
class Compared:
    """What came of a topic.

    Attributes
    ----------
    by : how its messages were paired
    pairs, only_first, only_second : messages that both, or one of the runs, have
    moved : messages that came in another order, and were not compared
    crossed : messages that came in another order among those of other joints, and were compared
    fields : by name
    """

    topic: str
    by: str
    pairs: int = 0
    only_first: int = 0
    only_second: int = 0
    moved: int = 0
    crossed: int = 0
    fields: dict[str, Difference] = field(default_factory=dict)

    def of(self, name: str) -> Difference:
        """Return what gathers the differences of a field."""
        if name not in self.fields:
            said = f"{self.topic} {name}" if name else self.topic
            self.fields[name] = Difference(said, 0, self.only_first, self.only_second)
        return self.fields[name]

    def told(self) -> list[Difference]:
        """Return what is worth telling: what is no measure and the same says nothing beside others."""
        measures = [d for d in self.fields.values() if d.numbers or not d.exact]
        some = measures or [*self.fields.values()][:1]
        return some or [Difference(self.topic, self.pairs, self.only_first, self.only_second)]


@dataclass
class Comparison:
    """What came of comparing two runs.

    Attributes
    ----------
    topics : what was compared, by topic
    not_compared : why something could not be, by what it is
    left_out : what was not to be compared, with the reason
    """

    topics: dict[str, Compared] = field(default_factory=dict)
    not_compared: dict[str, str] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)

    @property
    def differences(self) -> list[Difference]:
        """All that is worth telling."""
        return [difference for topic in self.topics.values() for difference in topic.told()]

    @property
    def pairs(self) -> int:
        """Messages that were compared."""
        return sum(topic.pairs for topic in self.topics.values())

    @property
    def complete(self) -> bool:
        """Whether all that either run holds was compared, in its order."""
        return not self.not_compared and not any(
            t.only_first or t.only_second or t.moved for t in self.topics.values()
        )

    @property
    def alike(self) -> bool:
        """Whether all that was compared is the same to the bit, and something was."""
        return self.pairs > 0 and all(d.exact for t in self.topics.values() for d in t.fields.values())

    @property
    def exact(self) -> bool:
        """Whether the runs are the same to the bit."""
        return self.alike and self.complete and not any(t.crossed for t in self.topics.values())

    @property
    def since(self) -> float | None:
        """The first time that differs, s; None where none does."""
        times = [d.since for t in self.topics.values() for d in t.fields.values() if d.since == d.since]
        return min(times, default=None)

    def gaps(self) -> list[str]:
        """Say what keeps the runs from being the same though no value differs."""
        said = []
        for t in self.topics.values():
            if t.only_first:
                said.append(f"{t.topic}: {t.only_first} messages are in A only")
            if t.only_second:
                said.append(f"{t.topic}: {t.only_second} messages are in B only")
            if t.moved:
                said.append(f"{t.topic}: {t.moved} messages came in another order and were not compared")
            if t.crossed:
                said.append(f"{t.topic}: {t.crossed} messages came before or after others than in A")
        return said + [f"{what}: not compared, {why}" for what, why in self.not_compared.items()]


def greatest(values: NDArray[Any]) -> float:
    """Return the greatest absolute value of those that are finite."""
    high, low = float(values.max()), float(values.min())
    if not (np.isfinite(high) and np.isfinite(low)):
        finite = values[np.isfinite(values)]
        high, low = (float(finite.max()), float(finite.min())) if finite.size else (0.0, 0.0)
    return max(high, -low)


def bits(values: NDArray[Any]) -> NDArray[Any]:
    """Return numbers as whole numbers of their bits, of the same shape."""
    return values.view(f"u{values.dtype.itemsize}")
