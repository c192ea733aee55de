"""Compares messages that belong together: every field of both, lists of any length, to the bit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag, BagError
from ..bag.cdr import Decoder
from ..bag.layout import LIST, Field, Layout, numbers, words
from ..bag.messages import Messages, window
from .difference import Compared
from .pairing import ELAPSED, GROUPED, RECEIPT

Progress = Callable[[str], None]
BYTES, BEYOND, TYPE = "(bytes)", "(beyond its definition)", "(type)"
STAMPED = ("stamp.sec", "stamp.nanosec", "clock.sec", "clock.nanosec")
# What may follow a message to fill it up to a multiple of four bytes.
PADDING = 3


class Comparer:
    """Compares the messages of a topic.

    Parameters
    ----------
    found : Compared
        What takes up the differences.
    decoders : of either bag; None: its messages are compared as bytes
    stamps : whether stamps count; they do not where the runs are of different times
    """

    def __init__(
        self, found: Compared, decoders: tuple[Decoder | None, Decoder | None], stamps: bool = True
    ) -> None:
        self.found, self.decoders, self.stamps = found, decoders, stamps
        # Bytes that are the same say the same only where they are read by the same definition.
        defined = [None if decoder is None else decoder.definition for decoder in decoders]
        self._one_definition = defined[0] is not None and defined[0] == defined[1]

    def add(self, time: NDArray[np.int64], first: Messages, second: Messages) -> None:
        """Take up K messages of either run; time (K,), ns."""
        self.found.pairs += len(time)
        a, b = self.decoders
        if a is None or b is None:
            self._bytes(time, first, second)
            return
        try:
            groups = a.groups(first), b.groups(second)
        except BagError:  # not what its definition says
            if len(time) == 1:
                self._bytes(time, first, second)
                return
            self.found.pairs -= len(time)
            half = len(time) // 2
            self.add(time[:half], first[:half], second[:half])
            self.add(time[half:], first[half:], second[half:])
            return
        label = [np.zeros(len(time), np.int64) for _ in groups]
        for which, some in zip(label, groups, strict=True):
            for number, (index, _, _) in enumerate(some):
                if index is not None:
                    which[index] = number
        both = label[0] * len(groups[1]) + label[1]
        for number in np.unique(both).tolist():
            i, j = divmod(number, len(groups[1]))
            rows = np.flatnonzero(both == number)
            all_of_them = len(rows) == len(time)
            self._alike(
                time[rows],
                groups[0][i][1],
                groups[0][i][2] if all_of_them else first[rows],
                groups[1][j][1],
                groups[1][j][2] if all_of_them else second[rows],
            )

    def _alike(
        self, time: NDArray[np.int64], a: Layout, first: Messages, b: Layout, second: Messages
    ) -> None:
        """Compare messages that have one layout in either run."""
        if a.kind != b.kind:
            self.found.of(TYPE).differs(time, f"{a.kind} and {b.kind}")
            self.found.of(TYPE).compared += len(time)
            return
        if self._one_definition and identical(first, second):
            self._same(time, a, first)
            self._beyond(time, a, first, b, second)
            return
        for name in uneven(a, b):
            self.found.of(name.removesuffix(LIST)).differs(time, "length")
        turned = self._turned(a, first, b, second)
        for name in dict.fromkeys([*a.fields, *b.fields]):
            if not self.stamps and name.endswith(STAMPED):
                continue
            difference = self.found.of(name)
            one, other = a.fields.get(name), b.fields.get(name)
            if one is None or other is None:
                difference.compared += len(time)
                difference.differs(time, "only in A" if other is None else "only in B")
            elif one.is_text or other.is_text:
                difference.compared += len(time)
                same = same_words(first, one, a.order, second, other, b.order)
                difference.note(time, same)
            else:
                x = numbers(first, one, a.order, views=True)
                y = numbers(second, other, b.order, views=True)
                if turned is not None and y.ndim == 2 and y.shape == turned.shape:
                    y = np.take_along_axis(y, turned, axis=1)
                difference.add(time, x, y)
        self._beyond(time, a, first, b, second)

    def _same(self, time: NDArray[np.int64], layout: Layout, messages: Messages) -> None:
        """Note that messages of one layout are the same byte by byte, and so in each field."""
        for name, field in layout.fields.items():
            if not self.stamps and name.endswith(STAMPED):
                continue
            difference = self.found.of(name)
            difference.compared += len(time)
            if not field.is_text and field.dtype.startswith("f"):
                difference.measures(numbers(messages, field, layout.order, views=True))

    def _turned(self, a: Layout, first: Messages, b: Layout, second: Messages) -> NDArray[np.int64] | None:
        """Return which of B's numbers is which of A's, where joints are named in another order."""
        if a.kind != GROUPED or "name" not in a.fields or "name" not in b.fields:
            return None
        names = words(first, a.fields["name"], a.order), words(second, b.fields["name"], b.order)
        pairs = list(zip(*names, strict=True))
        if all(x == y for x, y in pairs) or any(sorted(x) != sorted(y) for x, y in pairs):
            return None
        return np.array([order(x, y) for x, y in pairs], dtype=np.int64)

    def _beyond(
        self, time: NDArray[np.int64], a: Layout, first: Messages, b: Layout, second: Messages
    ) -> None:
        rests = a.size - a.end, b.size - b.end
        if max(rests) <= PADDING:
            return
        difference = self.found.of(BEYOND)
        difference.compared += len(time)
        if rests[0] != rests[1]:
            difference.differs(time, "length")
            return
        cut = [
            window(some.buffer, some.start + layout.end, rests[0])
            for some, layout in ((first, a), (second, b))
        ]
        difference.note(time, (cut[0] == cut[1]).all(axis=1))

    def _bytes(self, time: NDArray[np.int64], first: Messages, second: Messages) -> None:
        difference = self.found.of(BYTES)
        difference.compared += len(time)
        same = [x == y for x, y in zip(first.data(), second.data(), strict=True)]
        difference.note(time, np.array(same, dtype=bool))


def comparer(first: Bag, second: Bag, topic: Compared) -> Comparer:
    """Return what compares a topic's messages."""
    decoders: list[Decoder | None] = []
    for bag in (first, second):
        try:
            decoders.append(bag.decoder(topic.topic))
        except BagError:
            decoders.append(None)
    stamps = not {ELAPSED, RECEIPT} & set(topic.by.split(", "))
    return Comparer(topic, (decoders[0], decoders[1]), stamps)


def identical(first: Messages, second: Messages) -> bool:
    """Say whether messages of one layout in either run are the same to the byte."""
    size = int(first.size[0])
    return size == int(second.size[0]) and bool((first.rows(size) == second.rows(size)).all())


def uneven(a: Layout, b: Layout) -> list[str]:
    """Return the lists that are of different lengths in two layouts."""
    if a is b:
        return []
    names = a.counts.keys() & b.counts.keys()
    return sorted(n for n in names if not np.array_equal(a.counts[n][0], b.counts[n][0]))


def order(first: list[str], second: list[str]) -> list[int]:
    """Return where each word of the first list stands in the second; the k-th of equal ones is the k-th."""
    places: dict[str, list[int]] = {}
    for place, word in enumerate(second):
        places.setdefault(word, []).append(place)
    return [places[word].pop(0) for word in first]


def same_words(
    first: Messages, one: Field, order_a: str, second: Messages, other: Field, order_b: str
) -> NDArray[np.bool_]:
    """Say in which messages a text, or all of a list of texts, is the same, byte by byte."""
    shapes = [[(len(places), count) for places, count in f.parts] for f in (one, other)]
    if shapes[0] != shapes[1] or one.dtype != other.dtype:
        # Somewhere a text is longer: a list of equal length may still begin alike.
        return np.zeros(len(first), dtype=bool)
    if one.dtype == "wstring" and order_a != order_b:
        cells: list[Any] = [words(first, one, order_a), words(second, other, order_b)]
        return np.array([x == y for x, y in zip(*cells, strict=True)], dtype=bool)
    same = np.ones(len(first), dtype=bool)
    for (mine, count), (theirs, _) in zip(one.parts, other.parts, strict=True):
        if count:
            x = window(first.buffer, (first.start[:, None] + mine).ravel(), count)
            y = window(second.buffer, (second.start[:, None] + theirs).ravel(), count)
            same &= (x == y).all(axis=1).reshape(len(first), len(mine)).all(axis=1)
    return same
