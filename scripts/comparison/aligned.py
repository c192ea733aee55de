"""The messages of two bags that bear the same time, piece by piece."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag, BagError

SECOND = 1_000_000_000
STAMPS = (["header.stamp.sec", "header.stamp.nanosec"], ["clock.sec", "clock.nanosec"])
Columns = dict[str, NDArray[Any]]


@dataclass
class Stream:
    """A topic's messages by their own stamps: rising, each time once, some at a time."""

    bag: Bag
    topic: str
    fields: list[str]
    stamp: list[str]
    time: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    columns: Columns = field(default_factory=dict)
    ended: bool = False

    def __post_init__(self) -> None:
        self._batches = self.bag.batches(self.topic, [*self.fields, *self.stamp])
        self._last = -1

    def more(self) -> None:
        """Take up the next piece."""
        found = next(self._batches, None)
        if found is None:
            self.ended = True
            return
        columns = found[1]
        time = columns[self.stamp[0]].astype(np.int64) * SECOND + columns[self.stamp[1]]
        # A state that is repeated while time stands still counts once.
        order = np.maximum.accumulate(np.concatenate([[self._last], time]))
        news = np.diff(order) > 0
        if news.any():
            # Copies cost more than the comparison: none is made where all is taken as it came.
            which: Any = slice(None) if news.all() else news
            self._last = int(time[which][-1])
            self.time = np.concatenate([self.time, time[which]])
            for name in self.fields:
                old, new = self.columns.get(name), columns[name][which]
                if old is not None and old.shape[1:] != new.shape[1:]:
                    raise BagError(f"{self.bag.path}: the length of '{name}' changes within {self.topic}")
                self.columns[name] = new if old is None or not len(old) else np.concatenate([old, new])

    def until(self, time: int) -> tuple[NDArray[np.int64], Columns]:
        """Give away all up to a time."""
        n = int(np.searchsorted(self.time, time, side="right"))
        taken = self.time[:n], {name: values[:n] for name, values in self.columns.items()}
        self.time = self.time[n:]
        self.columns = {name: values[n:] for name, values in self.columns.items()}
        return taken


@dataclass
class Piece:
    """K messages of both bags with equal stamps, and how many had no counterpart."""

    time: NDArray[np.int64]
    first: Columns
    second: Columns
    only_first: int
    only_second: int


def aligned(first: Stream, second: Stream) -> Iterator[Piece]:
    """Give what two streams have in common, in order of time."""
    while True:
        for stream in (first, second):
            while not stream.ended and not len(stream.time):
                stream.more()
        if first.ended and second.ended and not (len(first.time) or len(second.time)):
            return
        # All up to here is known of both; of one that has ended, all.
        known = [int(s.time[-1]) for s in (first, second) if not s.ended]
        until = min(known) if known else np.iinfo(np.int64).max
        time_a, columns_a = first.until(until)
        time_b, columns_b = second.until(until)
        i: Any = slice(None)
        j: Any = slice(None)
        common = time_a
        if not np.array_equal(time_a, time_b):
            common, i, j = np.intersect1d(time_a, time_b, assume_unique=True, return_indices=True)
        yield Piece(
            common,
            {n: v[i] for n, v in columns_a.items()},
            {n: v[j] for n, v in columns_b.items()},
            len(time_a) - len(common),
            len(time_b) - len(common),
        )
        for stream in (first, second):
            if not stream.ended and not len(stream.time):
                stream.more()
