"""Two bags side by side: what bears the same time is paired, whatever the order in which it was recorded."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from flexsim.bag import Bag, BagWriter
from flexsim.comparison import streams
from flexsim.comparison.bags import compare_bags
from flexsim.comparison.difference import Difference
from flexsim.comparison.pairing import STAMP, equal, longest_rising, nearest, pairs, sequences

pytestmark = pytest.mark.ros
SECOND = 10**9
TEMPERATURE = "sensor_msgs/msg/Temperature"
COUNT = 400


def temperature(stamp: int, value: float) -> bytes:
    head = struct.pack("<4xiII", stamp // SECOND, stamp % SECOND, 1)[4:] + b"\0"
    body = head + bytes(-len(head) % 8) + struct.pack("<dd", value, 0.0)
    return b"\0\1\0\0" + body


def write(path: Path, topics: dict[str, list[tuple[int, int, float]]]) -> Bag:
    """Write a bag of temperatures: of each topic (log time, stamp, value), in the order of log times."""
    with BagWriter(path) as bag:
        channels = {name: bag.add_topic(name, TEMPERATURE) for name in topics}
        all_of_them = [(log, name, stamp, v) for name, some in topics.items() for log, stamp, v in some]
        for log, name, stamp, value in sorted(all_of_them):
            bag.write(channels[name], temperature(stamp, value), log)
    return Bag(path)


def evenly(
    period: int, value: float = 0.0, since: int = 0, pace: float = 1.0
) -> list[tuple[int, int, float]]:
    """Return messages stamped evenly since a time, received at a pace."""
    stamps = range(since + period, since + period * COUNT + 1, period)
    return [(SECOND + round((t - since) / pace), t, value + t / SECOND) for t in stamps]


@pytest.mark.parametrize("most", [1 << 28, 4096])
def test_clocks_of_their_own(most: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Topics are paired by stamp, though the second run was half as fast and one topic bears the wall's time.

    So too where only little may wait in memory: such a topic is read once more, by itself.
    """
    monkeypatch.setattr(streams, "MOST_WAITING", most)
    monkeypatch.setattr(streams, "AT_ONCE", 8)
    own = 10**7
    first = write(
        tmp_path / "a",
        {"/same": evenly(own), "/off": evenly(own), "/late": evenly(own), "/wall": evenly(own, since=SECOND)},
    )
    second = write(
        tmp_path / "b",
        {"/same": evenly(own, pace=0.5), "/off": evenly(own, 0.25, pace=0.5),
         "/late": evenly(own, since=3 * SECOND, pace=0.5), "/wall": evenly(own, since=2 * SECOND, pace=0.1)},
    )  # fmt: skip
    compared = compare_bags(first, second)
    found = {d.name: d for d in compared.differences}

    def told(name: str) -> Difference:
        return found[f"{name} temperature"]

    same, off, late, wall = map(told, ("/same", "/off", "/late", "/wall"))
    assert same.exact and (same.compared, same.only_first, same.only_second) == (COUNT, 0, 0)
    assert (off.since, off.compared) == (own / SECOND, COUNT)
    assert off.largest == pytest.approx(0.25)
    assert off.rms == pytest.approx(0.25)
    assert late.exact and (late.compared, late.only_first, late.only_second) == (100, 300, 300)
    assert wall.exact and (wall.compared, wall.only_first, wall.only_second) == (300, 100, 100)
    assert wall.size == pytest.approx(5.0)
    # What is in one run only is no difference of values, and yet the runs are not the same.
    assert not compared.exact and compared.since == own / SECOND
    sides = [sequences(bag, [*bag.topics], {}, lambda _: None) for bag in (first, second)]
    those = {n: pairs(sides[0][n], sides[1][n], STAMP, 0, (0, 0)) for n in first.topics}
    begun_anew = [piece for piece in streams.paired(first, second, those) if isinstance(piece, str)]
    assert bool(begun_anew) == (most < 1 << 28)


def test_one_number_of_one_message(tmp_path: Path) -> None:
    """A last bit that differs is found, with its time."""
    changed = [
        (log, t, np.nextafter(v, 9.0) if k == 237 else v) for k, (log, t, v) in enumerate(evenly(10**7))
    ]
    first, second = write(tmp_path / "a", {"/t": evenly(10**7)}), write(tmp_path / "b", {"/t": changed})
    (found,) = (d for d in compare_bags(first, second).differences if d.name == "/t temperature")
    assert (found.exact, found.since, found.at) == (False, 2.38, 2.38)
    assert 0.0 < found.largest < 1e-15


def test_equal_stamps_by_segment_and_turn() -> None:
    """After a reset of time the second run of the clock is held against the second; repeats in turn."""
    ten = np.arange(1, 11) * SECOND
    twice = np.concatenate([ten, ten])
    i, j = equal(twice, np.concatenate([ten[:5], ten]))
    # The first five of the first segment, then all ten of the second.
    assert i.tolist() == [*range(5), *range(10, 20)]
    assert j.tolist() == [*range(15)]
    i, j = equal(np.array([1, 1, 2]), np.array([1, 2, 2]))
    assert (i.tolist(), j.tolist()) == ([0, 2], [0, 1])


def test_nearest_times_once_each() -> None:
    """Times that are never equal go with the nearest, within half an interval, and each only once."""
    i, j = nearest(np.array([0, 100, 200, 300]), np.array([12, 90, 205, 206, 700]))
    assert (i.tolist(), j.tolist()) == ([0, 1, 2], [0, 1, 2])


@pytest.mark.parametrize("values", [[0, 1, 2], [2, 1, 0], [3, 0, 1, 2], [0, 2, 1, 3], []])
def test_longest_rising(values: list[int]) -> None:
    """Of messages in another order as many as can be are still compared."""
    from itertools import combinations

    best = max(
        (n for n in range(len(values) + 1) for c in combinations(values, n) if list(c) == sorted(c)),
        default=0,
    )
    found = np.array(values)[longest_rising(np.array(values, dtype=np.intp))].tolist() if values else []
    assert len(found) == best and found == sorted(found)


def test_a_state_that_is_repeated_while_time_stands_still(tmp_path: Path) -> None:
    """Where it is asked for, only the first message of a stamp counts; else each does."""
    still = [(SECOND + k, 10**7, 1.0) for k in range(5)]
    going = [(2 * SECOND + k, 10**7 * k, float(k)) for k in range(2, 9)]
    first, second = (
        write(tmp_path / "a", {"/t": still + going}),
        write(tmp_path / "b", {"/t": still[:1] + going}),
    )
    once = compare_bags(first, second, once=True)
    assert once.exact and once.pairs == 8
    each = compare_bags(first, second)
    assert not each.exact and each.topics["/t"].only_first == 4
