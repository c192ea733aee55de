"""Topics of a bag as series over simulated time."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag, BagError
from ..bag.cdr import Decoder
from ..bag.robot import robot_in
from .reading import STAMP, Reading

Array = NDArray[np.float64]
SECOND = 1_000_000_000
JOINT_FIELDS = ["name", "position", "velocity", "effort"]


@dataclass(frozen=True)
class Series:
    """A topic's fields: time (K,) s, rising, each time once; log (K,) s since the bag's start.

    stamped : whether time is the messages' own, or else that of receipt
    notes : what a reader should know of it
    """

    topic: str
    time: Array
    log: Array
    values: dict[str, NDArray[Any]]
    stamped: bool
    notes: tuple[str, ...] = ()

    def evenly(self, values: Array) -> tuple[Array, Array]:
        """Return times (J,) evenly spaced at the usual interval, and values (J, d) there."""
        period = float(np.median(np.diff(self.time)))
        count = round(float(self.time[-1] - self.time[0]) / period) + 1
        even = self.time[0] + period * np.arange(count)
        if count == len(self.time) and np.abs(self.time - even).max() < 1e-3 * period:
            return even, values
        return even, np.stack([np.interp(even, self.time, column) for column in values.T], axis=1)


def read(reading: Reading, topic: str, fields: list[str]) -> Series:
    """Read fields of a topic over simulated time, where its messages are stamped.

    Raises
    ------
    BagError
        It can't be read.
    """
    bag = reading.bag
    log, values, period = reading.columns(topic, fields)
    if not len(log):
        raise BagError(f"{bag.path}: {topic} can't be read")
    seconds = bag.seconds(log)
    notes = [f"every {bag.topic(topic).count / len(log):.0f}th message of {topic}"] if period else []
    time = seconds
    if set(STAMP) <= set(values):
        stamp = values[STAMP[0]].astype(np.int64) * SECOND + values[STAMP[1]]
        if stamp.any() and (len(stamp) < 2 or np.ptp(stamp) > 0):
            part, note = longest_run(stamp)
            notes += [note] if note else []
            _, first = np.unique(stamp[part], return_index=True)
            keep = np.arange(len(stamp))[part][first]
            time = stamp[keep] / SECOND
            wanted = {name: values[name][keep] for name in fields}
            return Series(topic, time, seconds[keep], wanted, True, tuple(notes))
    time, keep = np.unique(time, return_index=True)
    return Series(topic, time, time, {name: values[name][keep] for name in fields}, False, tuple(notes))


def longest_run(stamp: NDArray[np.int64]) -> tuple[slice, str]:
    """Return the part of stamps between two times at which time was set back that is longest."""
    back = np.flatnonzero(np.diff(stamp) < 0) + 1
    if not len(back):
        return slice(None), ""
    edges = [0, *back.tolist(), len(stamp)]
    spans = [int(stamp[b - 1] - stamp[a]) for a, b in pairwise(edges)]
    k = int(np.argmax(spans))
    a, b = edges[k], edges[k + 1]
    note = (
        f"simulated time was set back {len(back)} times; shown is the longest run, from "
        f"{stamp[a] / SECOND:.3f} s to {stamp[b - 1] / SECOND:.3f} s"
    )
    return slice(a, b), note


@dataclass(frozen=True)
class Joints:
    """What a robot's joints did: names (m,), and (K, m) each; a quantity that is not there is None."""

    series: Series
    names: tuple[str, ...]
    position: Array | None
    velocity: Array | None
    effort: Array | None

    def simulated(self, log: Array) -> Array:
        """Return the simulated time at receive times, s since the bag's start."""
        return np.interp(log, self.series.log, self.series.time) if self.series.stamped else log


def joints(reading: Reading, topic: str) -> Joints:
    """Read joint states.

    Raises
    ------
    BagError
        The joints change on the way.
    """
    series = read(reading, topic, JOINT_FIELDS)
    names = tuple(series.values["name"][0])
    if len(set(map(tuple, series.values["name"]))) > 1:
        raise BagError(f"{reading.bag.path}: the joints of {topic} change on the way")

    def quantity(name: str) -> Array | None:
        values = np.asarray(series.values[name], dtype=float)
        fits = values.ndim == 2 and values.shape[1] == len(names) and len(names) > 0
        return values if fits else None

    return Joints(series, names, quantity("position"), quantity("velocity"), quantity("effort"))


@dataclass(frozen=True)
class Layout:
    """What the numbers of elastic states belong to."""

    link_names: tuple[str, ...]
    node_link: NDArray[np.int64]
    segments: NDArray[np.int64] = field(default_factory=lambda: np.empty((0, 2), np.int64))

    @property
    def nodes(self) -> int:
        """How many nodes the robot has."""
        return len(self.node_link)


def layout(bag: Bag) -> Layout | None:
    """Return the robot's last layout; None where the bag has none."""
    name = robot_in(bag).layout
    last = bag.last(name) if name else None
    if name is None or last is None:
        return None
    decoder: Decoder = bag.decoder(name)
    columns = decoder.columns([last], ["link_names", "node_link", "segments"])
    segments = columns["segments"][0].astype(np.int64).reshape(-1, 2)
    return Layout(tuple(columns["link_names"][0]), columns["node_link"][0].astype(np.int64), segments)
