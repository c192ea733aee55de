"""Compares topics whose k-th messages belong together, as in a run that is driven again, in one pass.

That their stamps are equal, and that they are of the same joints, is seen from message to message. Where
they are not, what came of the topic is forgotten, and it is compared by the times of all messages.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag
from .difference import Compared, Comparison
from .messages import TYPE, Comparer, Progress, comparer
from .pairing import GROUPED, ORDER, STAMP, Pairs, times_of
from .streams import Piece, Sides


class Straight:
    """A topic that is compared message by message, as long as these belong together."""

    def __init__(self, first: Bag, second: Bag, topic: str) -> None:
        self.bags, self.count = (first, second), first.topics[topic].count
        self.found = Compared(topic, "")
        self.grouped = any(GROUPED in bag.topics[topic].types for bag in self.bags)
        self._comparer: Comparer | None = None

    def pairs(self) -> list[Pairs]:
        """Return each message with the one that comes as late."""
        rows = np.arange(self.count, dtype=np.int64)
        return [Pairs(rows, rows, rows, 0, 0, 0, "")]

    def take(self, piece: Piece) -> bool:
        """Compare some messages; False where they do not belong together, or may not."""
        time = self._time(piece)
        if time is None:
            return False
        if self._comparer is None:
            self._comparer = comparer(*self.bags, self.found)
        self._comparer.add(time, piece.first, piece.second)
        if not self.grouped:
            return True
        names = self.found.fields.get("name")
        return TYPE not in self.found.fields and (names is None or names.exact)

    def _time(self, piece: Piece) -> NDArray[np.int64] | None:
        """Return the time of some messages; None where their stamps differ."""
        sides = zip(self.bags, (piece.first, piece.second), strict=True)
        a, b = (times_of(bag, piece.topic, messages)[0] for bag, messages in sides)
        if not self.found.by:
            self.found.by = ORDER if a is None or b is None else STAMP
            if a is not None and b is not None and not (a.any() and b.any()):
                return None  # perhaps they are never filled in
        if self.found.by == ORDER:
            return piece.first.log_time
        return a if a is not None and b is not None and np.array_equal(a, b) else None


def compare_straight(
    first: Bag, second: Bag, topics: list[str], found: Comparison, progress: Progress
) -> list[str]:
    """Compare what can be compared in one pass; returns the other topics, which `found` does not take up."""
    going = {t: Straight(first, second, t) for t in topics if first.topics[t].count == second.topics[t].count}
    sides = Sides(first, second, {topic: one.pairs() for topic, one in going.items()})
    for piece in sides.pieces():
        topic = piece.topic if isinstance(piece, Piece) else piece
        if topic in going and not (isinstance(piece, Piece) and going[topic].take(piece)):
            del going[topic]
            sides.forget(topic)
        elif topic in going:
            progress(f"{topic}, {going[topic].found.pairs} messages compared")
    for topic, one in going.items():
        # Where something can't be read, the index says more than there is.
        if one.found.pairs == one.count and sides.rows(topic) == (one.count, one.count):
            found.topics[topic] = one.found
    return [topic for topic in topics if topic not in found.topics]
