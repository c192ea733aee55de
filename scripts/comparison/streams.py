"""Messages of two bags that belong together, a few at a time, each bag being read once."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag
from ..bag.messages import Gathered, Messages
from .pairing import Pairs

# What is given at once, at least: enough for NumPy to be quick, and what two or three chunks often hold.
AT_ONCE, BYTES_AT_ONCE = 256, 1 << 20
# Of one topic, bytes that wait for the other bag; a topic of which more would wait is read by itself.
MOST_WAITING = 1 << 28


@dataclass
class Piece:
    """Messages of both bags that belong together: of a topic, one of its groups, from a pair on."""

    topic: str
    group: int
    row: int
    first: Messages
    second: Messages


class Stream:
    """The messages of one group of a topic that have a counterpart in the other bag, as they are read.

    Parameters
    ----------
    rows : (n,) rows of the topic, rising
    """

    def __init__(self, rows: NDArray[np.int64]) -> None:
        self.rows = rows
        self.given = 0  # pairs that were taken away
        self.waiting = 0  # bytes
        self._taken = 0  # rows that were found among the messages
        self._begin = int(rows[0]) if len(rows) else 0
        self._dense = len(rows) > 0 and int(rows[-1]) - self._begin + 1 == len(rows)
        self._gathered = Gathered(AT_ONCE, BYTES_AT_ONCE)
        self._parts: deque[Messages] = deque()

    def add(self, messages: Messages, row: int) -> None:
        """Take up messages of the topic, the first of which is its row `row`."""
        a, end = self._taken, row + len(messages)
        if self._dense:  # every message, as mostly, from the first row on
            b = min(max(end - self._begin, a), len(self.rows))
        else:
            b = a + int(np.searchsorted(self.rows[a:], end))
        if a < b:
            self._taken = b
            which = self.rows[a:b] - row
            first, last = int(which[0]), int(which[-1])
            some = slice(first, last + 1) if last - first + 1 == len(which) else which
            self._put(self._gathered.add(messages[some]))

    def end(self) -> None:
        """Say that there are no more."""
        self._put(self._gathered.all())

    @property
    def ready(self) -> int:
        """Messages that can be had at once."""
        return len(self._parts[0]) if self._parts else 0

    def take(self, count: int) -> Messages:
        """Give away what waits first."""
        part = self._parts.popleft()
        self.waiting -= len(part.buffer)
        self.given += count
        if count < len(part):
            self._parts.appendleft(part[count:])
            self.waiting += len(part.buffer)
        return part[:count]

    def _put(self, ready: Messages | None) -> None:
        if ready is not None:
            self._parts.append(ready)
            self.waiting += len(ready.buffer)


@dataclass
class Side:
    """One of two bags that are read side by side."""

    bag: Bag
    streams: dict[str, list[Stream]]
    ended: bool = False
    rows: dict[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._chunks = self.bag.read([*self.streams])

    def waiting(self, topic: str | None = None) -> int:
        """Bytes that wait for the other bag, of all topics or of one."""
        those = self.streams.values() if topic is None else [self.streams[topic]]
        return sum(stream.waiting for streams in those for stream in streams)

    def more(self) -> list[str]:
        """Read on a little; returns the topics of which something is new."""
        chunk = next(self._chunks, None)
        if chunk is None:
            self.ended = True
            for streams in self.streams.values():
                for stream in streams:
                    stream.end()
            return [*self.streams]
        some = [topic for topic in chunk if topic in self.streams]
        for topic in some:
            row = self.rows.get(topic, 0)
            for stream in self.streams[topic]:
                stream.add(chunk[topic], row)
            self.rows[topic] = row + len(chunk[topic])
        return some


class Sides:
    """Two bags that are read side by side.

    Parameters
    ----------
    pairs : of each topic, by group, which messages belong together
    """

    def __init__(self, first: Bag, second: Bag, pairs: dict[str, list[Pairs]]) -> None:
        self.first = Side(first, {topic: [Stream(p.first) for p in some] for topic, some in pairs.items()})
        self.second = Side(second, {topic: [Stream(p.second) for p in some] for topic, some in pairs.items()})

    def forget(self, topic: str) -> None:
        """Read no more of a topic."""
        for side in (self.first, self.second):
            side.streams.pop(topic, None)

    def rows(self, topic: str) -> tuple[int, int]:
        """Return how many messages of a topic were met in either bag."""
        return self.first.rows.get(topic, 0), self.second.rows.get(topic, 0)

    def pieces(self) -> Iterator[Piece | str]:
        """Give the messages that belong together, each group of a topic in order.

        Yields
        ------
        Piece, or the name of a topic that is forgotten, because too much of it would wait.
        """
        a, b = self.first, self.second
        while a.streams and not (a.ended and b.ended):
            # Where less waits is what lies behind.
            side = min((s for s in (a, b) if not s.ended), key=lambda s: s.waiting())
            for topic in side.more():
                if topic in a.streams:
                    yield from pieces(topic, a.streams[topic], b.streams[topic])
                if topic in a.streams and len(a.streams) > 1 and self._waits(topic) > MOST_WAITING:
                    self.forget(topic)
                    yield topic

    def _waits(self, topic: str) -> int:
        return max(side.waiting(topic) for side in (self.first, self.second))


def paired(first: Bag, second: Bag, pairs: dict[str, list[Pairs]]) -> Iterator[Piece | str]:
    """Give the messages that belong together, topic by topic, each group of a topic in order.

    Yields
    ------
    Piece, or the name of a topic: what came of it is to be forgotten, it begins anew.
    """
    later: list[str] = []
    for piece in Sides(first, second, pairs).pieces():
        if isinstance(piece, str):
            later.append(piece)
        yield piece
    for topic in later:
        yield from paired(first, second, {topic: pairs[topic]})


def pieces(topic: str, first: list[Stream], second: list[Stream]) -> Iterator[Piece]:
    """Give what two streams of each group have ready."""
    for group, (a, b) in enumerate(zip(first, second, strict=True)):
        while count := min(a.ready, b.ready):
            row = a.given
            yield Piece(topic, group, row, a.take(count), b.take(count))
