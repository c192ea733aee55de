"""Which messages of two runs belong together: by their own stamps, by elapsed time, by receipt, or by order.

Only times are held in memory, eight bytes a message, so that whatever the runs' clocks did is known before
the first message is compared: whether time was reset, whether several publishers share a topic.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag, BagError
from ..bag.cdr import Decoder
from ..bag.layout import HEADER
from ..bag.messages import Messages, window

SECOND = 1_000_000_000
STAMPS = (("header.stamp.sec", "header.stamp.nanosec"), ("clock.sec", "clock.nanosec"))
# A stamp that steps back by more than this is a reset of time, ns; but not where that happens all the time,
# as where several publishers with clocks of their own share a topic.
RESET, SEVERAL = SECOND // 2, 0.05
# Joint states tell by name whose they are.
TIME = "builtin_interfaces/msg/Time"
GROUPED = "sensor_msgs/msg/JointState"
APART = 10**6 * SECOND
STAMP, ELAPSED, RECEIPT, ORDER = "stamp", "elapsed", "receipt", "order"


@dataclass
class Sequence:
    """The messages of one topic in one run, of which only the times are kept.

    Attributes
    ----------
    receipt : (K,) ns, log times
    stamp : (K,) ns, the messages' own; None where they bear none
    group : (K,) whose they are: of joint states the number of the set of names, else 0
    """

    receipt: NDArray[np.int64]
    stamp: NDArray[np.int64] | None
    group: NDArray[np.int64]


@dataclass
class Pairs:
    """Messages of a group of a topic that belong together.

    Attributes
    ----------
    first, second : (n,) rows of the topic in either run, both rising
    time : (n,) ns, of the first run
    only_first, only_second : messages without a counterpart
    moved : messages that came in another order
    by : how they were paired
    """

    first: NDArray[np.int64]
    second: NDArray[np.int64]
    time: NDArray[np.int64]
    only_first: int
    only_second: int
    moved: int
    by: str


@dataclass
class _Gathering:
    receipt: list[NDArray[np.int64]] = field(default_factory=list)
    stamp: list[NDArray[np.int64]] = field(default_factory=list)
    group: list[NDArray[np.int64]] = field(default_factory=list)
    stamped: bool = True


def sequences(
    bag: Bag, topics: list[str], names: dict[tuple[str, ...], int], progress: Callable[[int], None]
) -> dict[str, Sequence]:
    """Read the times of some topics; `names` gathers sets of joints over both runs."""
    found = {topic: _Gathering() for topic in topics}
    count = 0
    for chunk in bag.read(topics):
        for topic, messages in chunk.items():
            told = found[topic]
            told.receipt.append(messages.log_time)
            stamp, group = times_of(bag, topic, messages, names) if told.stamped else (None, None)
            if stamp is None:
                told.stamped = False
            else:
                told.stamp.append(stamp)
            if group is None:
                group = np.zeros(len(messages), np.int64)
            told.group.append(group)
            count += len(messages)
        progress(count)
    return {topic: sequence(told) for topic, told in found.items()}


def sequence(told: _Gathering) -> Sequence:
    """Return what was gathered of a topic."""
    none = np.empty(0, np.int64)
    receipt = np.concatenate(told.receipt) if told.receipt else none
    stamp = np.concatenate(told.stamp) if told.stamped and told.stamp else None
    if stamp is not None and not stamp.any():
        stamp = None  # never filled in
    # What can't be decoded throughout is not told apart either.
    group = np.concatenate(told.group) if told.stamped and told.group else np.zeros(len(receipt), np.int64)
    return Sequence(receipt, stamp, group)


def times_of(
    bag: Bag, topic: str, messages: Messages, names: dict[tuple[str, ...], int] | None = None
) -> tuple[NDArray[np.int64] | None, NDArray[np.int64] | None]:
    """Return the stamps of some messages, None where there are none, and with `names` their groups."""
    stamp = np.empty(len(messages), np.int64)
    group = np.zeros(len(messages), np.int64)
    at_once = stamps_that_come_first(bag, topic, messages, names is not None)
    if at_once is not None:
        return at_once, group
    try:
        for index, layout, some in bag.decoder(topic).groups(messages):
            which: Any = slice(None) if index is None else index
            fields = next((f for f in STAMPS if set(f) <= layout.fields.keys()), None)
            if fields is None:
                return None, None
            sec, nanosec = (layout.cut(name, some).astype(np.int64) for name in fields)
            stamp[which] = sec * SECOND + nanosec
            if names is not None and layout.kind == GROUPED and "name" in layout.fields:
                group[which] = numbered(layout.cut("name", some), names)
    except BagError:  # not what its definition says, or not CDR
        return None, None
    return stamp, group


def stamps_that_come_first(
    bag: Bag, topic: str, messages: Messages, grouped: bool
) -> NDArray[np.int64] | None:
    """Return the stamps of messages that begin with theirs, as nearly all do; None of others.

    grouped : whether joint states are others, because their names count too
    """
    kinds = [kind for number in bag.topic(topic).numbers if (kind := bag.decoder_of(number))]
    kind = kinds[0]
    if len(kinds) != 1 or isinstance(kind, BagError) or not begins_with_time(kind):
        return None
    if grouped and kind.type == GROUPED:
        return None
    if int(messages.size.min()) < HEADER + 8:
        return None
    heads = window(messages.buffer, messages.start, HEADER + 8)
    if not (heads[:, :2] == (0, 1)).all():
        return None
    sec = np.ascontiguousarray(heads[:, HEADER : HEADER + 4]).view("<i4")[:, 0].astype(np.int64)
    nanosec = np.ascontiguousarray(heads[:, HEADER + 4 :]).view("<u4")[:, 0].astype(np.int64)
    return np.asarray(sec * SECOND + nanosec)


def begins_with_time(kind: Decoder) -> bool:
    """Say whether a type's messages begin with a header, or are a clock."""
    first = kind.types[kind.type][:1]
    if [m.type for m in first] == ["std_msgs/msg/Header"] and first[0].name == "header":
        first = kind.types[first[0].type][:1]
        name = "stamp"
    else:
        name = "clock"
    fits = [(m.name, m.type, m.size) for m in first] == [(name, TIME, None)]
    return fits and [(m.name, m.type) for m in kind.types[TIME]] == [("sec", "int32"), ("nanosec", "uint32")]


def numbered(told: NDArray[Any], names: dict[tuple[str, ...], int]) -> list[int]:
    """Return the number of each message's set of names; most messages share one list."""
    known: dict[int, int] = {}
    found = []
    for one in told:
        number = known.get(id(one))
        if number is None:
            number = known[id(one)] = names.setdefault(tuple(sorted(one)), len(names))
        found.append(number)
    return found


def pairs(
    first: Sequence,
    second: Sequence,
    align: str,
    offset: int,
    origins: tuple[int, int],
    once: bool = False,
) -> list[Pairs]:
    """Pair the messages of a topic, group by group.

    align : STAMP, ELAPSED or RECEIPT
    offset : ns, to be added to the second run's times
    origins : ns, when each run began, by the clock that counts
    once : whether of messages that bear one stamp only the first counts, as of a state that is repeated
        while time stands still
    """
    found = []
    for group in np.union1d(first.group, second.group).tolist():
        rows = [np.flatnonzero(s.group == group) for s in (first, second)]
        found.append(of_group(first, second, rows, align, offset, origins, once))
    return found


def of_group(
    first: Sequence,
    second: Sequence,
    rows: list[NDArray[np.intp]],
    align: str,
    offset: int,
    origins: tuple[int, int],
    once: bool,
) -> Pairs:
    """Pair the messages of one group."""
    a, b = rows
    stamped = first.stamp is not None and second.stamp is not None
    clock = first.receipt[a]
    if align == RECEIPT or (align == ELAPSED and not stamped):
        times = [
            s.receipt[r] - o for s, r, o in zip((first, second), rows, begun(first, second), strict=True)
        ]
        i, j = nearest(times[0], times[1] + offset)
        by = RECEIPT
    elif align == ELAPSED:
        assert first.stamp is not None and second.stamp is not None
        clock = first.stamp[a]
        i, j = nearest(elapsed(clock, origins[0]), elapsed(second.stamp[b], origins[1]) + offset)
        by = ELAPSED
    elif stamped:
        assert first.stamp is not None and second.stamp is not None
        if once:
            a, b = a[is_first(first.stamp[a])], b[is_first(second.stamp[b])]
        clock = first.stamp[a]
        i, j = equal(clock, second.stamp[b] + offset)
        by = STAMP
    else:
        i = j = np.arange(min(len(a), len(b)))
        by = ORDER
    rising = longest_rising(j)
    moved = len(j) - len(rising)
    i, j = i[rising], j[rising]
    return Pairs(
        a[i].astype(np.int64), b[j].astype(np.int64), clock[i], len(a) - len(i), len(b) - len(j), moved, by
    )


def elapsed(stamp: NDArray[np.int64], origin: int) -> NDArray[np.int64]:
    """Return how long after the run's beginning messages are stamped, ns; each reset begins apart."""
    segment = segments(stamp)
    if not segment.any():
        return stamp - origin
    first = np.flatnonzero(np.diff(segment, prepend=0))
    begins = np.concatenate([[origin], stamp[first]])
    return np.asarray(stamp - begins[segment] + segment * APART)


def begun(first: Sequence, second: Sequence) -> tuple[int, int]:
    """Return when receipt began on a topic in either run, ns."""
    return (
        int(first.receipt.min()) if len(first.receipt) else 0,
        int(second.receipt.min()) if len(second.receipt) else 0,
    )


def segments(stamp: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return of each message how often time was reset before it."""
    back = np.diff(stamp) < -RESET
    if len(stamp) and back.sum() > max(2, SEVERAL * len(stamp)):
        return np.zeros(len(stamp), np.int64)
    return np.concatenate([[0], np.cumsum(back)]).astype(np.int64) if len(stamp) else np.empty(0, np.int64)


def equal(first: NDArray[np.int64], second: NDArray[np.int64]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pair equal stamps: within each segment of time, the k-th that bears a stamp with the k-th."""
    if np.array_equal(first, second):
        return np.arange(len(first)), np.arange(len(second))
    keys = [(segments(stamp), stamp, often(segments(stamp), stamp)) for stamp in (first, second)]
    # Equal keys get equal numbers, so that one array can be met with the other.
    rows = np.concatenate([np.stack(key, axis=1) for key in keys])
    _, number = np.unique(rows, axis=0, return_inverse=True)
    number = number.ravel()
    a, b = number[: len(first)], number[len(first) :]
    _, i, j = np.intersect1d(a, b, assume_unique=True, return_indices=True)
    order = np.argsort(i, kind="stable")
    return i[order], j[order]


def is_first(stamp: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Say which messages are the first of their segment that bear their stamp."""
    return np.asarray(often(segments(stamp), stamp) == 0)


def often(segment: NDArray[np.int64], stamp: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return how many messages before each one, in its segment, bear its stamp."""
    order = np.lexsort((np.arange(len(stamp)), stamp, segment))
    s, t = segment[order], stamp[order]
    new = np.ones(len(stamp), bool)
    new[1:] = (s[1:] != s[:-1]) | (t[1:] != t[:-1])
    at = np.arange(len(stamp))
    found = np.empty(len(stamp), np.int64)
    found[order] = at - np.maximum.accumulate(np.where(new, at, 0))
    return found


def nearest(first: NDArray[np.int64], second: NDArray[np.int64]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Pair each time with the nearest one, not farther than half an interval; each is taken once."""
    if not len(first) or not len(second):
        return np.empty(0, np.intp), np.empty(0, np.intp)
    a, b = np.argsort(first, kind="stable"), np.argsort(second, kind="stable")
    x, y = first[a], second[b]
    steps = [np.diff(t)[np.diff(t) > 0] for t in (x, y)]
    most = max((float(np.median(s)) for s in steps if len(s)), default=0.0) / 2
    after = np.clip(np.searchsorted(y, x), 0, len(y) - 1)
    before = np.maximum(after - 1, 0)
    closer = np.abs(y[before] - x) <= np.abs(y[after] - x)
    found = np.where(closer, before, after)
    off = np.abs(y[found] - x)
    # Of those that are nearest to the same one, the nearest has it.
    order = np.lexsort((off, found))
    once = np.ones(len(order), bool)
    once[1:] = found[order][1:] != found[order][:-1]
    kept = np.sort(order[once])
    kept = kept[off[kept] <= most]
    i, j = a[kept], b[found[kept]]
    rank = np.argsort(i, kind="stable")
    return i[rank], j[rank]


def crossed(pairs: list[Pairs]) -> int:
    """Return how many messages came in another order among those of the topic's other groups."""
    if len(pairs) < 2:
        return 0
    order = np.argsort(np.concatenate([p.first for p in pairs]), kind="stable")
    second = np.concatenate([p.second for p in pairs])[order]
    return len(second) - len(longest_rising(second))


def longest_rising(values: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return which values, as many as can be, rise from each to the next."""
    if len(values) < 2 or bool((np.diff(values) > 0).all()):
        return np.arange(len(values))
    ends: list[int] = []  # the smallest value with which a rising row of each length ends
    at: list[int] = []
    before: list[int] = []
    for k, value in enumerate(values.tolist()):
        n = bisect_left(ends, value)
        before.append(at[n - 1] if n else -1)
        if n == len(ends):
            ends.append(value)
            at.append(k)
        else:
            ends[n], at[n] = value, k
    row, k = [], at[-1]
    while k >= 0:
        row.append(k)
        k = before[k]
    return np.array(row[::-1], dtype=np.intp)
