"""Every verb with every kind of bag: what comes out is right, or the verb says in plain words why not."""

from __future__ import annotations

import json
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from bag_kinds import JOINTS, KINDS, QOS, STORE, by_mcap, cdr, definition, header, new, run
from flexsim.bag import Bag
from mcap.writer import Writer
from processes import flexsim_here

TIMES = {"of the wall": (None, 1_780_000_000 * 10**9), "from zero": (0, 0)}


@pytest.mark.parametrize(
    ("kind", "base"),
    [(kind, "of the wall") for kind in KINDS]
    + [
        (kind, "from zero")
        for kind in ("mcap, zstd", "mcap, two files", "mcap, no summary", "rosbag2, sqlite3")
    ],
)
def test_each_verb_with_each_kind(kind: str, base: str, tmp_path: Path) -> None:
    """The same run, however it is stored and whatever its clock: the same counts, times and numbers."""
    clock, t0 = TIMES[base]
    rows = run(30, t0=t0, clock=clock)
    path = KINDS[kind](tmp_path / "run", rows)
    info = flexsim_here("info", path, "--json", cwd=tmp_path)
    told = json.loads(info.stdout)
    assert told["complete"] and told["messages"] == len(rows)
    assert told["duration"] == pytest.approx((rows[-1].time - rows[0].time) * 1e-9)
    # These writers count the messages of all topics together, or not at all: that tells no loss.
    assert {topic["lost"] for topic in told["topics"].values()} == {None}
    assert told["topics"]["/stop"]["messages"] == 30 and told["topics"]["/stop"]["interval"] == pytest.approx(
        0.01
    )
    bag = Bag(path)
    # Of the arm and the gripper on one topic the larger set of joints is meant.
    with pytest.warns(UserWarning, match="of a, b, c, which are taken, and of finger"):
        position = bag.columns("/joint_states", ["position"], by_joint=True)[1]["position"]
    wanted = [r.message.position for r in rows if r.topic == "/joint_states" and len(r.message.name) == 3]
    np.testing.assert_array_equal(position, wanted)
    assert [data for _, data in bag.messages("/said")][7][8:14] == b"word 7"
    report = flexsim_here("report", path, "--json", "-o", tmp_path / "x.html", cwd=tmp_path)
    assert report.returncode == 0, report.stderr
    assert json.loads(report.stdout)["messages"] == len(rows)
    view = flexsim_here("view", path, "--save", tmp_path / "x.rrd", "--json", cwd=tmp_path)
    assert view.returncode == 0, view.stderr
    assert json.loads(view.stdout)["rows"]["joints/position"] == 30


def test_empty_bags_are_said_to_be_empty(tmp_path: Path) -> None:
    """Without messages, topics, bytes or files: each verb says which."""
    nothing = by_mcap(tmp_path / "nothing.mcap", [])
    zero = tmp_path / "zero" / "zero_0.mcap"
    zero.parent.mkdir()
    zero.write_bytes(b"")
    described = KINDS["rosbag2, mcap"](tmp_path / "described", run(2))
    for file in described.glob("*.mcap"):
        file.unlink()
    bare = tmp_path / "bare"
    bare.mkdir()
    for path, words in (
        (nothing, "holds no messages, nor topics"),
        (zero.parent, "holds no messages: zero_0.mcap, byte 0: the file is empty"),
        (described, "has no file of its bag: its metadata.yaml lists described.mcap"),
        (bare, "holds no .mcap file and no .db3 file, nor anything else"),
    ):
        for verb in (
            ("report",),
            ("view", "--save", tmp_path / "x.rrd"),
            ("export", "-o", tmp_path / "out"),
            ("play",),
        ):
            done = flexsim_here(verb[0], path, *verb[1:], cwd=tmp_path)
            assert done.returncode == 1, (verb, path)
            assert words in done.stderr, (verb, done.stderr)


def test_what_is_no_bag_is_named(tmp_path: Path) -> None:
    """A bag of ROS 1 and a ULog are called what they are, with the way to convert them."""
    for name, data, words in (
        ("run.bag", b"#ROSBAG V2.0\n" + bytes(50), "a bag of ROS 1. Convert it: rosbags-convert"),
        ("log.ulg", b"ULog\x01\x12\x35\x01" + bytes(50), "a ULog of PX4, which is no bag. Convert it"),
        ("notes.txt", b"some words\n" * 9, "is not an MCAP file, nor an sqlite3 database: it is no bag"),
    ):
        (tmp_path / name).write_bytes(data)
        for verb in ("info", "play", "recover", "report"):
            done = flexsim_here(verb, tmp_path / name, cwd=tmp_path)
            assert done.returncode == 1 and words in done.stderr, (verb, done.stderr)


def test_only_listed_files_are_read(tmp_path: Path) -> None:
    """A copy beside the files that metadata.yaml lists does not double the bag, and is named."""
    path = KINDS["rosbag2, mcap"](tmp_path / "run", run(5))
    file = next(path.glob("*.mcap"))
    (path / f"{file.stem}_recovered.mcap").write_bytes(file.read_bytes())
    for given in (path, path / "metadata.yaml"):
        assert Bag(given).count == 40
    assert "not read: run_recovered.mcap" in flexsim_here("info", path, cwd=tmp_path).stdout


def test_each_message_by_its_own_channel(tmp_path: Path) -> None:
    """A definition that changes within a bag, a topic of two types: each message is read by its own."""
    import struct

    path = tmp_path / "run.mcap"
    old, more = "float64 force\nfloat64 moment\n", "float64 temperature\n"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="test")
        for part, (text, values) in enumerate(((old, (1.0, 2.0)), (more + old, (25.0, 1.0, 2.0)))):
            schema = writer.register_schema("cell_msgs/msg/Grip", "ros2msg", text.encode())
            channel = writer.register_channel("/grip", "cdr", schema)
            data = b"\0\1\0\0" + struct.pack(f"<{len(values)}d", *values)
            for k in range(5):
                writer.add_message(channel, 10 * part + k, data, 0)
        kinds = [JOINTS, "std_msgs/msg/Float64MultiArray"]
        rows = [next(r for r in run(1) if r.topic == topic) for topic in ("/joint_states", "/arm/commands")]
        for part, (kind, row) in enumerate(zip(kinds, rows, strict=True)):
            schema = writer.register_schema(kind, "ros2msg", definition(kind).encode())
            channel = writer.register_channel("/command", "cdr", schema, {"offered_qos_profiles": QOS})
            for k in range(5):
                writer.add_message(channel, 100 + 10 * part + k, cdr(row), 0)
        writer.finish()
    bag = Bag(path)
    assert (bag.array("/grip", "force")[1] == 1.0).all()
    assert bag.topics["/command"].types == kinds
    told = flexsim_here("info", path, cwd=tmp_path).stdout
    assert "/command has 2 types; each message is read by its own" in told
    shown = flexsim_here("view", path, "--save", tmp_path / "x.rrd", "--json", cwd=tmp_path)
    assert json.loads(shown.stdout)["rows"]["joints/position"] == 5


def test_foreign_notes_are_foreign(tmp_path: Path) -> None:
    """A metadata record that happens to have our keys makes no bag unreadable, nor a robot of itself."""
    path = tmp_path / "run.mcap"
    row = next(r for r in run(1) if r.topic == "/joint_states")
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="test")
        writer.add_metadata("/cell", {"scene": "at dusk", "elastic_rate": "{", "rate": "fast"})
        channel = writer.register_channel(
            "/joint_states", "cdr", writer.register_schema(JOINTS, "ros2msg", definition(JOINTS).encode())
        )
        for k in range(5):
            writer.add_message(channel, k, cdr(row), 0)
        writer.finish()
    for verb in (("info",), ("view", "--save", tmp_path / "x.rrd"), ("report", "-o", tmp_path / "x.html")):
        done = flexsim_here(verb[0], path, *verb[1:], cwd=tmp_path)
        assert done.returncode == 0, (verb, done.stderr)


def growing(path: Path, count: int) -> Path:
    """Write paths that grow by a pose with each message."""
    from bag_kinds import PATH, Row

    turn = new("geometry_msgs/msg/Quaternion", 0.0, 0.0, 0.0, 1.0)
    point = STORE.types["geometry_msgs/msg/Point"]
    poses = [
        new(
            "geometry_msgs/msg/PoseStamped",
            header(k, "map"),
            new("geometry_msgs/msg/Pose", point(k, 0.0, 0.0), turn),
        )
        for k in range(count)
    ]
    return by_mcap(path, [Row("/path", k, new(PATH, header(k), poses[:k])) for k in range(1, count)])


def test_growing_messages_take_linear_time_and_memory(tmp_path: Path) -> None:
    """Four times as many bytes take about four times as long, and as much memory at most."""
    from flexsim.comparison.bags import compare_bags
    from flexsim.health.examination import examine

    spent, held = [], []
    for count in (60, 120, 240):
        path = growing(tmp_path / f"{count}.mcap", count)
        begun = time.process_time()
        examine(Bag(path))
        assert compare_bags(Bag(path), Bag(path)).exact
        spent.append(time.process_time() - begun)
    for count in (120, 240):
        tracemalloc.start()
        compare_bags(Bag(tmp_path / f"{count}.mcap"), Bag(tmp_path / f"{count}.mcap"))
        held.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    # Twice as many messages are four times as many bytes; squared would be sixteen.
    assert spent[2] < 8 * spent[1]
    assert held[1] < 8 * held[0] and held[1] < 200e6
