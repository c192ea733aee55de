"""Rates, jitter, gaps and clock jumps of a bag's topics, from the times of their messages alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag, BagError
from ..bag.messages import Messages

SECOND = 1_000_000_000
# A pause is a gap where it is so many usual intervals long. Below a millisecond nothing is one: the
# scheduler of an ordinary system does that.
GAP = 5.0
LEAST_GAP = 1e-3  # s
# Of a topic with fewer messages no usual interval is known.
LEAST = 20
# A topic is regular where the middle half of its intervals lies within this factor of the median.
REGULAR = 3.0
# Simulated time may run ahead of its own pace by so much before it is called a jump, s.
JUMP = 0.5
# Counts and stamps that step back more often than this are those of several publishers on one topic.
SEVERAL = 0.05
# A count that begins anew more often is none.
MOST_RUNS = 1000
CLOCK = ("clock.sec", "clock.nanosec")
HEADER = ("header.stamp.sec", "header.stamp.nanosec")


@dataclass(frozen=True)
class Gap:
    """Times when a topic was silent or slow, s since the bag's start; `messages` came within.

    `still` where simulated time stood still meanwhile: then nothing is missing.
    """

    begin: float
    end: float
    messages: int = 0
    still: bool = False


@dataclass(frozen=True)
class Loss:
    """Messages that the publisher counted between two that are in the bag, s since its start."""

    begin: float
    end: float
    count: int


@dataclass(frozen=True)
class Jump:
    """Simulated time that leapt: when, s since the bag's start, and from where to where, s."""

    at: float
    before: float
    after: float


@dataclass
class Timing:
    """How a topic's messages came.

    Attributes
    ----------
    interval : s, the median; None of fewer than twenty messages
    regular : bool
        Whether the intervals are much the same, so that jitter and gaps mean something.
    jitter : s, the 99th percentile of how far an interval is from the median
    longest : Gap or None, the longest interval
    gaps : list of Gap, intervals of five medians and more, those in a row as one
    lost : int or None
        Messages that the publisher counted and the bag lacks; None where it does not count.
    losses : list of Loss, where
    stamped : s, the median interval of the messages' own stamps; None without stamps
    missing : int, messages that a regular sequence of stamps lacks
    latency : s, the median from sending to receipt; None where the sender's time is not known
    backwards : int, messages that were logged before the one before them
    jumps : list of Jump, of the stamps
    """

    topic: str
    count: int = 0
    interval: float | None = None
    regular: bool = False
    jitter: float | None = None
    longest: Gap | None = None
    gaps: list[Gap] = field(default_factory=list)
    lost: int | None = None
    losses: list[Loss] = field(default_factory=list)
    stamped: float | None = None
    missing: int = 0
    latency: float | None = None
    backwards: int = 0
    jumps: list[Jump] = field(default_factory=list)


class Times:
    """Collects the times of a topic's messages as a bag is read."""

    def __init__(self, bag: Bag, topic: str) -> None:
        self.bag = bag
        self.topic = topic
        self._decoder = None if bag.why_not(topic) else bag.decoder(topic)
        self._fields: tuple[str, str] | None = None
        self._looked = False
        self._log: list[NDArray[np.int64]] = []
        self._publish: list[NDArray[np.int64]] = []
        self._sequence: list[NDArray[np.int64]] = []
        self._stamp: list[NDArray[np.int64]] = []

    def add(self, messages: Messages) -> None:
        """Take up messages."""
        self._log.append(messages.log_time)
        self._publish.append(messages.publish_time)
        self._sequence.append(messages.sequence)
        if not self._looked and len(messages):
            self._looked = True
            try:
                places = set(self._decoder.fields(messages)) if self._decoder is not None else set()
            except BagError:
                places = set()
            self._fields = next((f for f in (HEADER, CLOCK) if set(f) <= places), None)
        if self._fields is not None and self._decoder is not None:
            try:
                columns = self._decoder.columns(messages, [*self._fields])
            except BagError:  # not what its definition says: then its stamps are not known
                self._fields, self._stamp = None, []
                return
            sec, nanosec = (columns[name].astype(np.int64) for name in self._fields)
            self._stamp.append(sec * SECOND + nanosec)

    def counts(self) -> NDArray[np.int64]:
        """Return the publisher's count of each message."""
        return np.concatenate(self._sequence) if self._sequence else np.empty(0, np.int64)

    def timing(self, counted_together: bool = False) -> Timing:
        """Return what is known at the end.

        counted_together : whether the counts are those of all topics together, so that they tell no loss
        """
        found = Timing(self.topic)
        if not self._log:
            return found
        log, publish = np.concatenate(self._log), np.concatenate(self._publish)
        found.count = len(log)
        found.backwards = int(np.sum(np.diff(log) < 0))
        sequence = np.concatenate(self._sequence)
        seconds = self.bag.seconds(log)
        if not counted_together and counted(sequence):
            found.losses = losses(seconds, sequence)
            found.lost = sum(loss.count for loss in found.losses)
        if (publish != log).any() and (publish > 0).all():
            found.latency = float(np.median(log - publish)) / SECOND
        stamp = np.concatenate(self._stamp) if self._stamp else np.empty(0, np.int64)
        # Time that was never filled in.
        if len(stamp) and not stamp.any():
            stamp = np.empty(0, np.int64)
        # Each of several nodes may stamp by a clock of its own; of /clock there is to be one.
        if len(stamp) and not (self._fields == HEADER and interleaved(stamp)):
            found.jumps = jumps(seconds, stamp)
        if len(log) < LEAST:
            return found
        interval = np.maximum(np.diff(seconds), 0.0)
        usual = float(np.median(interval))
        found.interval = usual
        low, high = np.quantile(interval, [0.25, 0.75])
        found.regular = bool(usual > 0.0 and high <= REGULAR * usual and REGULAR * low >= usual)
        found.jitter = float(np.quantile(np.abs(interval - usual), 0.99))
        k = int(np.argmax(interval))
        found.longest = Gap(float(seconds[k]), float(seconds[k + 1]))
        if found.regular:
            found.gaps = gaps(seconds, max(GAP * usual, LEAST_GAP), stamp)
        if len(stamp):
            step = np.diff(stamp)
            on = step[step > 0]
            if len(on):
                found.stamped = float(np.median(on)) / SECOND
                found.missing = missing(on)
        return found


def gaps(time: NDArray[np.float64], longest: float, stamp: NDArray[np.int64]) -> list[Gap]:
    """Return the intervals that are longer, those in a row as one; stamps (K,) or none."""
    wide = np.flatnonzero(np.diff(time) > longest)
    if not len(wide):
        return []
    found = []
    for run in np.split(wide, np.flatnonzero(np.diff(wide) > 1) + 1):
        a, b = int(run[0]), int(run[-1] + 1)
        # The last interval is that in which time may have gone on again.
        still = len(stamp) > 0 and b - a > 1 and bool(stamp[a] == stamp[b - 1])
        found.append(Gap(float(time[a]), float(time[b]), len(run) - 1, still))
    return found


def counted(sequence: NDArray[np.int64]) -> bool:
    """Say whether one publisher counted the messages: of several the counts can't be told apart."""
    return len(sequence) > 1 and bool((sequence != sequence[0]).any()) and not interleaved(sequence)


def interleaved(values: NDArray[np.int64]) -> bool:
    """Say whether they step back so often that they come from several publishers."""
    back = int(np.sum(np.diff(values.astype(np.int64)) < 0))
    return back > max(2, SEVERAL * len(values))


def losses(time: NDArray[np.float64], sequence: NDArray[np.int64]) -> list[Loss]:
    """Return where a publisher's count leaps; a count that begins anew loses nothing."""
    step = np.diff(sequence.astype(np.int64))
    return [
        Loss(float(time[k]), float(time[k + 1]), int(step[k] - 1)) for k in np.flatnonzero(step > 1).tolist()
    ]


def missing(step: NDArray[np.int64]) -> int:
    """Return how many messages a regular sequence of stamps lacks; steps > 0, ns."""
    usual = np.median(step)
    ratio = step / usual
    whole = np.rint(ratio)
    # What is not paced regularly lacks nothing.
    if np.mean(np.abs(ratio - whole) < 0.1) < 0.95:
        return 0
    return int(np.sum(whole[whole > 1] - 1))


def jumps(time: NDArray[np.float64], stamp: NDArray[np.int64]) -> list[Jump]:
    """Return where stamps run backwards, or ahead of the pace at which they go."""
    step, passed = np.diff(stamp) / SECOND, np.maximum(np.diff(time), 0.0)
    span = float(time[-1] - time[0])
    pace = max(1.0, float(np.sum(step[step > 0.0])) / span) if span > 0.0 else 1.0
    # A publisher that stands still for a while and then catches up has not jumped.
    usual = float(np.median(step[step > 0.0])) if (step > 0.0).any() else 0.0
    ahead = step > pace * passed + max(JUMP, GAP * usual)
    where = np.flatnonzero((step < 0.0) | ahead)
    return [Jump(float(time[k + 1]), stamp[k] / SECOND, stamp[k + 1] / SECOND) for k in where.tolist()]


def timings(
    bag: Bag,
    also: Mapping[str, list[Callable[[Messages], Any]]] | None = None,
    progress: Callable[[int], None] = lambda _: None,
) -> dict[str, Timing]:
    """Read a bag once and return each topic's timing.

    Parameters
    ----------
    bag : Bag
    also : dict
        What else is to be called with a topic's messages.
    progress : callable
        Called with the number of messages read so far.
    """
    times = {name: Times(bag, name) for name in bag.topics}
    read = 0
    for messages in bag.read([*times]):
        for name, some in messages.items():
            times[name].add(some)
            for taker in (also or {}).get(name, ()):
                taker(some)
            read += len(some)
        progress(read)
    whole = one_counter([found.counts() for found in times.values()])
    return {name: found.timing(whole) for name, found in times.items()}


def one_counter(sequences: list[NDArray[np.int64]]) -> bool:
    """Say whether one count went over all topics, as converters have it: then no count tells a loss.

    It may begin anew, as in each file of a split bag; then the n-th runs of all topics go together.
    """
    runs = [(s, np.flatnonzero(np.diff(s) <= 0) + 1) for s in sequences if len(s)]
    if len(runs) < 2 or any(len(begins) >= MOST_RUNS for _, begins in runs):
        return False
    parts = [np.split(s, begins) for s, begins in runs]
    for n in range(max(map(len, parts))):
        together = np.concatenate([part[n] for part in parts if n < len(part)])
        apart = np.unique(together)
        if len(apart) != len(together) or int(apart[-1] - apart[0]) + 1 != len(apart):
            return False
    return True
