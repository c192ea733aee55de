"""`compare` accounts for all that two runs hold: what differs, and what could not be compared."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_kinds import ARRAY, JOINTS, T0, Row, by_mcap, copied, joint_state, new, run
from flexsim.bag import Bag
from flexsim.comparison.bags import compare_bags
from flexsim.comparison.difference import Comparison
from processes import flexsim_here


def flexsim(*words: Any) -> Any:
    return flexsim_here(*words, cwd=Path.cwd())


def only(rows: list[Row], *topics: str) -> list[Row]:
    return [row for row in rows if row.topic in topics]


def compared(folder: Path, first: list[Row], second: list[Row], **how: Any) -> Comparison:
    paths = [by_mcap(folder / f"{name}.mcap", rows) for name, rows in (("a", first), ("b", second))]
    return compare_bags(Bag(paths[0]), Bag(paths[1]), **how)


def worst(found: Comparison) -> dict[str, float]:
    return {d.name: d.largest for d in found.differences if not d.exact}


def test_after_a_reset_of_time(tmp_path: Path) -> None:
    """A run that differs only after simulated time was reset differs."""
    first = only(run(20, resets=1, clock=0), "/joint_states")
    second = [copied(row) for row in first]
    for row in second[40:]:
        row.message.position[:] += 0.5
    found = compared(tmp_path, first, second)
    assert worst(found) == {"/joint_states position": pytest.approx(0.5)}
    assert found.pairs == 80 and found.complete


def test_lists_that_grow_and_shrink(tmp_path: Path) -> None:
    """Elements beyond those of the first message count; a list that changes its length is as itself."""
    first = only(run(20), "/path", "/tf")
    second = [copied(row) for row in first]
    for row in second:
        if row.topic == "/path" and len(row.message.poses) > 3:
            row.message.poses[3].pose.position.x += 1.0
    found = compared(tmp_path, first, second)
    assert worst(found) == {"/path poses[].pose.position.x": pytest.approx(1.0)}
    shorter = [copied(row) for row in first]
    shorter[5].message.transforms.pop()
    assert "length" in {d.why for d in compared(tmp_path, first, shorter).differences if not d.exact}
    paths = only(first, "/path")
    backwards = [replace(a, message=b.message) for a, b in zip(paths, paths[::-1], strict=True)]
    assert compared(tmp_path, backwards, backwards).exact


def test_two_days_have_no_stamp_in_common(tmp_path: Path) -> None:
    """Runs of different days are not the same because nothing differs; by elapsed time they compare."""
    first = only(run(30), "/joint_states")
    second = [copied(row) for row in only(run(30, t0=T0 + 86_400 * 10**9 + 1_234_567), "/joint_states")]
    for row in second:
        row.message.position[:] += 0.05
    paths = [by_mcap(tmp_path / f"{n}.mcap", rows) for n, rows in (("monday", first), ("tuesday", second))]
    for check in ("--exact", "--tolerance=0.5"):
        done = flexsim("compare", *paths, check)
        assert done.returncode == 1
        assert "nothing in common to compare" in done.stderr
        assert "same" not in done.stdout
    done = flexsim("compare", *paths, "--align", "elapsed", "--json")
    told = json.loads(done.stdout)
    assert told["fields"]["/joint_states position"]["largest"] == pytest.approx(0.05)
    assert told["topics"]["/joint_states"]["compared"] == 60
    assert flexsim("compare", *paths, "--align", "elapsed", "--tolerance", 0.06).returncode == 0
    shifted = compare_bags(Bag(paths[0]), Bag(paths[1]), offset=-86_400.001234567)
    assert shifted.pairs == 60 and shifted.complete


@pytest.mark.parametrize("align", ["elapsed", "receipt"])
def test_clocks_that_never_agree(align: str, tmp_path: Path) -> None:
    """Times that are a little off go with the nearest one."""
    first = only(run(30), "/joint_states")[::2]
    second = [replace(copied(r), time=r.time + 10**12 + 300_000 * (k % 3)) for k, r in enumerate(first)]
    for row in second:
        own = row.message.header.stamp
        own.sec, own.nanosec = own.sec + 1000, (own.nanosec + 123_456) % 10**9
    found = compared(tmp_path, first, second, align=align)
    assert found.pairs == 30
    assert not worst(found)


def test_topics_without_stamps(tmp_path: Path) -> None:
    """Commands and transforms bear no stamp: they are compared one after the other."""
    first = only(run(10), "/arm/commands", "/tf", "/joint_states", "/stop")
    second = [copied(row) for row in first]
    second[-2].message.data[1] += 1.0
    found = compared(tmp_path, first, second)
    assert worst(found) == {"/arm/commands data": 1.0}
    assert {t.topic: t.by for t in found.topics.values()} == {
        "/arm/commands": "order", "/tf": "order", "/joint_states": "stamp", "/stop": "order",
    }  # fmt: skip


def test_what_only_one_run_has(tmp_path: Path) -> None:
    """A topic in one bag only, or of another type, is named and makes --exact and --tolerance fail."""
    first = only(run(5), "/joint_states", "/tf")
    second = [copied(row) for row in first if row.topic == "/joint_states"]
    found = compared(tmp_path, first, second)
    assert found.alike and not found.exact
    assert found.not_compared == {"/tf": f"B, {tmp_path}/b.mcap, has no such topic"}
    for words in (("--exact",), ("--tolerance", 1.0)):
        done = flexsim("compare", tmp_path / "a.mcap", tmp_path / "b.mcap", *words)
        assert done.returncode == 1
        assert "not all could be compared: /tf" in done.stderr
        assert "same to the bit" not in done.stdout
        assert (
            flexsim(
                "compare", tmp_path / "a.mcap", tmp_path / "b.mcap", *words, "--without", "/tf"
            ).returncode
            == 0
        )
    layout = new("std_msgs/msg/MultiArrayLayout", [], 0)
    import bag_kinds

    numbers = [
        Row("/tf", row.time, new(ARRAY, layout, np.arange(2.0))) for row in first if row.topic == "/tf"
    ]
    bag_kinds.TOPICS["/tf"], before = ARRAY, bag_kinds.TOPICS["/tf"]
    try:
        by_mcap(tmp_path / "b.mcap", sorted(second + numbers, key=lambda row: row.time))
    finally:
        bag_kinds.TOPICS["/tf"] = before
    found = compare_bags(Bag(tmp_path / "a.mcap"), Bag(tmp_path / "b.mcap"))
    assert found.not_compared["/tf"].startswith("of another type: tf2_msgs/msg/TFMessage in A")
    assert not found.exact


def test_joints_by_name(tmp_path: Path) -> None:
    """An arm and a gripper on one topic are told apart; joints that change their order go by name."""
    first = only(run(20), "/joint_states")
    second = [copied(row) for row in first]
    for k, row in enumerate(second):
        if k % 4 == 0:
            message = row.message
            row.message = joint_state(row.time, message.name[::-1], message.position[::-1])
            row.message.header = message.header
    found = compared(tmp_path, first, second)
    assert {d.name for d in found.differences if not d.exact} == {"/joint_states name"}
    # The gripper came first in each pair: the same values, in another order.
    crossed = [replace(r, time=r.time + (2000 if len(r.message.name) == 3 else 0)) for r in first]
    found = compared(tmp_path, first, sorted(crossed, key=lambda row: row.time))
    assert found.alike and found.complete and not found.exact
    assert "before or after" in found.gaps()[0]


def test_a_definition_that_changed(tmp_path: Path) -> None:
    """Fields that both definitions have are compared by name, and those of one are named."""
    import struct

    from mcap.writer import Writer

    old, more = "float64 force\nfloat64 moment\n", "float64 temperature\n"
    for name, text, values in (("a", old, (1.0, 2.0)), ("b", more + old, (25.0, 1.0, 2.0))):
        with (tmp_path / f"{name}.mcap").open("wb") as stream:
            writer = Writer(stream)
            writer.start(profile="ros2", library="test")
            channel = writer.register_channel(
                "/grip", "cdr", writer.register_schema("cell_msgs/msg/Grip", "ros2msg", text.encode())
            )
            for k in range(5):
                writer.add_message(channel, k, b"\0\1\0\0" + struct.pack(f"<{len(values)}d", *values), k)
            writer.finish()
    found = compare_bags(Bag(tmp_path / "a.mcap"), Bag(tmp_path / "b.mcap"))
    assert {d.name: d.why for d in found.differences if not d.exact} == {"/grip temperature": "only in B"}
    assert all(d.compared == 5 for d in found.differences)


def test_nothing_and_damage_are_not_the_same(tmp_path: Path) -> None:
    """Of empty bags nothing is said to be the same, nor of a bag that could not be read whole."""
    nothing = by_mcap(tmp_path / "nothing.mcap", [])
    done = flexsim("compare", nothing, nothing, "--exact")
    assert done.returncode == 1 and "nothing in common" in done.stdout
    whole = by_mcap(tmp_path / "whole.mcap", run(10))
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole.read_bytes()[:-300])
    assert compare_bags(Bag(whole), Bag(whole)).exact
    found = compare_bags(Bag(cut), Bag(cut))
    assert not found.exact and "cut.mcap" in found.gaps()[0]


def test_times_of_the_wall_are_told(tmp_path: Path) -> None:
    """A difference at an epoch time is told to the millisecond, not in three digits."""
    first = only(run(5), "/joint_states")
    second = [copied(row) for row in first]
    second[4].message.position[0] += 1.0
    done = flexsim("compare", *(by_mcap(tmp_path / f"{n}.mcap", r) for n, r in (("a", first), ("b", second))))
    assert "differ since 1780000000.030000 s" in done.stdout


def test_messages_that_are_not_cdr(tmp_path: Path) -> None:
    """JSON is not decoded; its bytes are the same or not."""
    from mcap.writer import Writer

    for name, word in (("a", b"1"), ("b", b"2")):
        with (tmp_path / f"{name}.mcap").open("wb") as stream:
            writer = Writer(stream)
            writer.start()
            channel = writer.register_channel("/free", "json", 0)
            for k in range(5):
                writer.add_message(channel, k, b'{"x": ' + (word if k == 3 else b"0") + b"}", k)
            writer.finish()
    a, b = (Bag(tmp_path / f"{n}.mcap") for n in "ab")
    assert compare_bags(a, a).exact
    found = compare_bags(a, b)
    assert [d.name for d in found.differences if not d.exact] == ["/free (bytes)"]
    assert JOINTS not in found.not_compared
