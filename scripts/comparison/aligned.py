"""The messages of two bags that bear the same time, piece by piece, each bag being read once."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag, BagError
from ..bag.cdr import Decoder
from ..bag.messages import Gathered, Messages

SECOND = 1_000_000_000
STAMPS = (["header.stamp.sec", "header.stamp.nanosec"], ["clock.sec", "clock.nanosec"])
Columns = dict[str, NDArray[Any]]
Part = tuple[NDArray[np.int64], Columns]
# What is decoded at once, at least: enough for NumPy to be quick, and what one chunk often holds, so that
# nothing is copied twice.
AT_ONCE, BYTES_AT_ONCE = 64, 1 << 18
# Of one topic, bytes that wait for the other bag; a topic of which more would wait is read by itself.
MOST_WAITING = 1 << 28


@dataclass
class Piece:
    """K messages of both bags with equal stamps, and how many had no counterpart."""

    time: NDArray[np.int64]
    first: Columns
    second: Columns
    only_first: int
    only_second: int


class Stream:
    """A topic's messages by their own stamps: rising, each time once, as they are read.

    Parameters
    ----------
    bag : Bag
    topic : str
    fields : list of str
    stamp : list of str, the fields of its stamp
    """

    def __init__(self, bag: Bag, topic: str, fields: list[str], stamp: list[str]) -> None:
        self.path, self.topic, self.fields, self.stamp = bag.path, topic, fields, stamp
        self.waiting = 0  # bytes
        self.ended = False
        self._decoder: Decoder = bag.decoder(topic)
        self._gathered = Gathered(AT_ONCE, BYTES_AT_ONCE)
        self._parts: deque[tuple[NDArray[np.int64], Columns, int]] = deque()
        self._last = -1
        self._shape: dict[str, tuple[int, ...]] = {}

    def add(self, messages: Messages) -> None:
        """Take up messages."""
        ready = self._gathered.add(messages)
        if ready is not None:
            self._decode(ready)

    def end(self) -> None:
        """Say that there are no more."""
        ready = self._gathered.all()
        if ready is not None:
            self._decode(ready)
        self.ended = True

    @property
    def until(self) -> int | None:
        """The time up to which all is known that waits in one piece; None where nothing waits."""
        return int(self._parts[0][0][-1]) if self._parts else None

    def take(self, time: int) -> Part:
        """Give away what waits first, up to a time."""
        if not self._parts:
            return np.empty(0, np.int64), {}
        times, columns, size = self._parts[0]
        n = int(np.searchsorted(times, time, side="right"))
        if n == len(times):
            self._parts.popleft()
            self.waiting -= size
            return times, columns
        self._parts[0] = times[n:], {name: values[n:] for name, values in columns.items()}, size
        return times[:n], {name: values[:n] for name, values in columns.items()}

    def _decode(self, messages: Messages) -> None:
        # They are gathered in a buffer of their own, so that views of it may be kept for a while.
        columns = self._decoder.columns(messages, [*self.fields, *self.stamp], views=True)
        time = columns[self.stamp[0]].astype(np.int64) * SECOND + columns[self.stamp[1]]
        # A state that is repeated while time stands still counts once.
        order = np.maximum.accumulate(np.concatenate([[self._last], time]))
        news = np.diff(order) > 0
        if not news.any():
            return
        # Copies cost more than the comparison: none is made where all is taken as it came.
        which: Any = slice(None) if news.all() else news
        for name in self.fields:
            shape = columns[name].shape[1:]
            if self._shape.setdefault(name, shape) != shape:
                raise BagError(f"{self.path}: the length of '{name}' changes within {self.topic}")
        time = time[which]
        self._last = int(time[-1])
        size = len(messages.buffer)
        self._parts.append((time, {n: columns[n][which] for n in self.fields}, size))
        self.waiting += size


def pieces(first: Stream, second: Stream) -> Iterator[Piece]:
    """Give what two streams have in common, in order of time, as far as is known by now."""
    while True:
        a, b = first.until, second.until
        if a is None and b is None:
            return
        if (a is None and not first.ended) or (b is None and not second.ended):
            return
        known = min(t for t in (a, b) if t is not None)
        time_a, columns_a = first.take(known)
        time_b, columns_b = second.take(known)
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


@dataclass
class Side:
    """One of two bags that are read side by side."""

    bag: Bag
    streams: dict[str, Stream]
    ended: bool = False
    _chunks: Iterator[dict[str, Messages]] = field(init=False)

    def __post_init__(self) -> None:
        self._chunks = self.bag.read([*self.streams])

    @property
    def waiting(self) -> int:
        """Bytes that wait for the other bag."""
        return sum(stream.waiting for stream in self.streams.values())

    def more(self) -> list[str]:
        """Read on a little; returns the topics of which something is new."""
        chunk = next(self._chunks, None)
        if chunk is not None:
            some = [topic for topic in chunk if topic in self.streams]
            for topic in some:
                self.streams[topic].add(chunk[topic])
            return some
        self.ended = True
        for stream in self.streams.values():
            stream.end()
        return [*self.streams]


def aligned(
    first: Bag, second: Bag, topics: dict[str, tuple[list[str], list[str]]]
) -> Iterator[tuple[str, Piece | None]]:
    """Give, topic by topic, what two bags have in common; each topic in order of time.

    Parameters
    ----------
    first, second : Bag
    topics : dict of topic to (fields, fields of its stamp)

    Yields
    ------
    topic, piece
        Without a piece: what came of this topic is to be forgotten, it begins anew.
    """
    sides = [Side(bag, {t: Stream(bag, t, *topics[t]) for t in topics}) for bag in (first, second)]
    later: list[str] = []
    while not all(side.ended for side in sides):
        # Where less waits is what lies behind.
        side = min((s for s in sides if not s.ended), key=lambda s: s.waiting)
        for topic in side.more():
            one, other = (s.streams[topic] for s in sides)
            for piece in pieces(one, other):
                yield topic, piece
            if max(one.waiting, other.waiting) > MOST_WAITING and len(sides[0].streams) > 1:
                # Its clock is not that of the other topics.
                later.append(topic)
                yield topic, None
                for s in sides:
                    del s.streams[topic]
    for topic in later:
        yield from aligned(first, second, {topic: topics[topic]})
