"""Whatever single thing differs between two runs, `compare` finds it, in any bag."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_kinds import KINDS, Row, by_mcap, cdr, copied, leaves, other, run
from flexsim.bag import Bag
from flexsim.comparison import bags, streams
from flexsim.comparison.bags import compare_bags
from flexsim.comparison.difference import Comparison

RUNS = {"plain": (6, 0, None), "simulated time": (5, 0, 0), "two resets": (3, 2, 0)}


def mutated(rows: list[Row], random: np.random.Generator) -> tuple[list[Row], str]:
    """Return a copy in which a single thing is another, and what that is."""
    found = [copied(row) for row in rows]
    while True:
        how = ["changed", "dropped", "added", "reordered"][int(random.choice(4, p=[0.55, 0.15, 0.15, 0.15]))]
        k = int(random.integers(len(found)))
        if how == "changed":
            there = leaves(found[k].message)
            if not there:
                continue
            owner, place = there[int(random.integers(len(there)))]
            if isinstance(place, str):
                setattr(owner, place, other(getattr(owner, place), random))
            else:
                owner[place] = other(owner[place], random)
            if cdr(found[k]) == cdr(rows[k]):
                continue
            return found, f"{how}: {rows[k].topic}, row {k}, {type(owner).__name__} {place}"
        if how == "dropped":
            del found[k]
        elif how == "added":
            found.insert(k, copied(found[k]))
        else:
            later = [i for i in range(k + 1, len(found)) if found[i].topic == found[k].topic]
            if not later:
                continue
            i = later[0]
            if cdr(found[i]) == cdr(found[k]):
                continue  # nobody can tell
            found[k].message, found[i].message = found[i].message, found[k].message
        return found, f"{how}: {rows[k].topic}, row {k}"


def told(found: Comparison) -> list[Any]:
    """Return all that a comparison says, with sums rounded."""
    topics = found.topics.values()
    fields = [d for t in topics for _, d in sorted(t.fields.items())]
    return [
        found.gaps(), found.left_out,
        [(t.topic, t.by, t.pairs, t.only_first, t.only_second, t.moved, t.crossed) for t in topics],
        [(d.name, d.compared, d.exact, d.why, d.component, d.numbers) for d in fields],
        [f"{d.largest} {d.size} {d.at} {d.since} {d.rms:.9e}" for d in fields],
    ]  # fmt: skip


def check(folder: Path, count: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    kinds = [*KINDS]
    runs = {name: run(messages, resets, clock=clock) for name, (messages, resets, clock) in RUNS.items()}
    whole: dict[tuple[str, str], Bag] = {}

    def stored(name: str, kind: str) -> Bag:
        """Return a run that is stored in a way; it is written and opened once."""
        if (name, kind) not in whole:
            there = folder / f"whole_{len(whole)}"
            there.mkdir()
            whole[name, kind] = Bag(KINDS[kind](there / "run", runs[name]))
        return whole[name, kind]

    for number in range(count):
        name = [*RUNS][number % len(RUNS)]
        rows = runs[name]
        first, second = (kinds[int(random.integers(len(kinds)))] for _ in range(2))
        one = stored(name, first)
        same = compare_bags(one, stored(name, second))
        assert same.exact, (name, first, second, told(same))
        assert same.pairs == len(rows)
        others, what = mutated(rows, random)
        there = folder / f"{number}"
        there.mkdir()
        differing = Bag(KINDS[second](there / "other", others))
        found = compare_bags(one, differing)
        assert not found.exact, (name, first, second, what)
        assert found.gaps() or any(not d.exact for d in found.differences), (first, second, what)
        # Whether the times of all messages are looked at first makes no difference.
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(bags, "compare_straight", lambda a, b, topics, *_: topics)
            assert told(found) == told(compare_bags(one, differing)), (first, second, what)


def test_any_single_change_is_found(tmp_path: Path) -> None:
    """A field changed in its last bit, a message dropped, added or moved: never are the runs called the same.

    And a copy in another storage, compression, endianness or schema language is the same to the bit.
    """
    check(tmp_path, 100, 1)


def late_stamp(rows: list[Row]) -> None:
    rows[30].message.header.stamp.nanosec += 7


def two_stamps_exchanged(rows: list[Row]) -> None:
    one, other = rows[30].message.header, rows[32].message.header
    one.stamp, other.stamp = other.stamp, one.stamp


def other_order_of_joints(rows: list[Row]) -> None:
    rows[30].message.name[:2] = rows[30].message.name[1::-1]


def other_joints(rows: list[Row]) -> None:
    rows[30].message, rows[31].message = rows[31].message, rows[30].message


def one_dropped_one_added(rows: list[Row]) -> None:
    del rows[30]
    rows.append(copied(rows[-1]))


@pytest.mark.parametrize(
    "change", [late_stamp, two_stamps_exchanged, other_order_of_joints, other_joints, one_dropped_one_added]
)
def test_what_no_longer_goes_message_by_message(
    change: Callable[[list[Row]], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Runs of which messages belong together up to the middle: as if all times had been looked at first."""
    monkeypatch.setattr(streams, "AT_ONCE", 4)
    rows = [row for row in run(24) if row.topic == "/joint_states"]
    others = [copied(row) for row in rows]
    change(others)
    one, other = (
        Bag(by_mcap(tmp_path / f"{name}.mcap", some, chunk_size=1))
        for name, some in (("a", rows), ("b", others))
    )
    straight = []
    true = bags.compare_straight

    def noted(*given: Any) -> list[str]:
        straight.append(true(*given))
        return straight[-1]

    monkeypatch.setattr(bags, "compare_straight", noted)
    found = compare_bags(one, other)
    assert straight == [["/joint_states"]] and not found.exact
    monkeypatch.setattr(bags, "compare_straight", lambda a, b, topics, *_: topics)
    assert told(found) == told(compare_bags(one, other))


@pytest.mark.nightly
def test_a_thousand_changes_are_found(tmp_path: Path) -> None:
    """The same, a thousand times."""
    check(tmp_path, 1000, 2)
