"""Bags keep what is put into them, and read what others write; rosbags is the judge."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from flexsim.bag import Bag, BagError, BagWriter, qos
from flexsim.bag.definitions import definition, type_hash
from flexsim.bag.messages import Gathered
from rosbags.rosbag2 import Reader, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

pytestmark = pytest.mark.ros

STORE = get_typestore(Stores.ROS2_JAZZY)
JOINTS = "sensor_msgs/msg/JointState"
SECOND = 10**9


def joint_state(k: int, names: list[str]) -> bytes:
    stamp = STORE.types["builtin_interfaces/msg/Time"](k // 1000, k % 1000 * 1_000_000)
    header = STORE.types["std_msgs/msg/Header"](stamp, "base")
    values = k + np.arange(len(names)) / 8
    message = STORE.types[JOINTS](header, names, values, -values, np.empty(0))
    return bytes(STORE.serialize_cdr(message, JOINTS))


def diagnostics(k: int) -> bytes:
    types = STORE.types
    header = types["std_msgs/msg/Header"](types["builtin_interfaces/msg/Time"](k, 0), "")
    pairs = [types["diagnostic_msgs/msg/KeyValue"]("overruns", str(k)) for _ in range(k % 3)]
    status = types["diagnostic_msgs/msg/DiagnosticStatus"]
    parts = [status(0, "robot: timing", "é", "", pairs), status(1, "robot: energy", "b", "x", [])]
    array = types["diagnostic_msgs/msg/DiagnosticArray"](header, parts)
    return bytes(STORE.serialize_cdr(array, "diagnostic_msgs/msg/DiagnosticArray"))


def write(path: Path, count: int, names: list[str] | None = None) -> Path:
    with BagWriter(path) as bag:
        joints = bag.add_topic("/joint_states", JOINTS)
        health = bag.add_topic("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
        for k in range(count):
            bag.write(joints, joint_state(k, names or ["a", "bc", "def"]), SECOND + k * 1_000_000)
            bag.write(health, diagnostics(k), SECOND + k * 1_000_000)
    return path


def test_fields_as_arrays(tmp_path: Path) -> None:
    """Two lines give a field of every message, by receive time or by its own stamp."""
    bag = Bag(write(tmp_path / "run", 5000))
    t, position = bag.array("/joint_states", "position")
    np.testing.assert_allclose(t, np.arange(5000) * 1e-3, atol=1e-12)
    np.testing.assert_array_equal(position, np.arange(5000)[:, None] + np.arange(3) / 8)
    stamp, velocity = bag.array("/joint_states", "velocity", clock="stamp")
    np.testing.assert_allclose(stamp, np.arange(5000) * 1e-3, atol=1e-9)
    np.testing.assert_array_equal(velocity, -position)
    assert bag.array("/joint_states", "effort")[1].shape == (5000, 0)
    assert list(bag.array("/joint_states", "name")[1][-1]) == ["a", "bc", "def"]
    assert (bag.array("/joint_states", "header.frame_id")[1] == "base").all()
    assert (bag.array("/diagnostics", "status[1].level")[1] == 1).all()
    assert (bag.array("/diagnostics", "status[0].message")[1] == "é").all()
    thin, _ = bag.columns("/joint_states", ["position"], period=0.1)
    assert len(thin) == 50


def test_messages_that_change_shape(tmp_path: Path) -> None:
    """Sequences of changing length are read where they can be, and refused where not."""
    path = tmp_path / "run"
    with BagWriter(path) as bag:
        joints = bag.add_topic("/joint_states", JOINTS)
        for k in range(60):
            # Same size, other lengths within: only the lengths tell these apart.
            names = [["a", "b"], ["abcdefgh", ""], ["x", "y", "z"]][k % 3]
            bag.write(joints, joint_state(k, names), k)
    bag = Bag(path)
    assert [list(n) for n in bag.array("/joint_states", "name")[1][:3]] == [
        ["a", "b"],
        ["abcdefgh", ""],
        ["x", "y", "z"],
    ]
    np.testing.assert_array_equal(
        bag.array("/joint_states", "header.stamp.nanosec")[1], np.arange(60) * 1_000_000
    )
    with pytest.raises(BagError, match="length of 'position' changes"):
        bag.array("/joint_states", "position")


def test_messages_gathered_from_many_chunks(tmp_path: Path) -> None:
    """What is gathered a few at a time, in order and of any size, is what was written."""
    path = tmp_path / "run"
    with BagWriter(path) as bag:
        joints = bag.add_topic("/joint_states", JOINTS)
        for k in range(3000):
            bag.write(joints, joint_state(k, ["a", "b"] if k % 700 else ["long name", "another"]), k)
    bag = Bag(path)
    gathered, found = Gathered(500), []
    for messages in bag.read(["/joint_states"]):
        some = messages["/joint_states"]
        for first in range(0, len(some), 7):
            enough = gathered.add(some[first : first + 7])
            found += [] if enough is None else [enough]
    found.append(gathered.all())
    assert gathered.all() is None
    assert all(500 <= len(part) < 507 for part in found[:-1])
    decoder = bag.decoder("/joint_states")
    position = np.concatenate([decoder.columns(part, ["position"])["position"] for part in found])
    np.testing.assert_array_equal(position, np.arange(3000)[:, None] + np.arange(2) / 8)
    np.testing.assert_array_equal(np.concatenate([part.log_time for part in found]), np.arange(3000))


def test_wrong_words_say_what_is_right(tmp_path: Path) -> None:
    bag = Bag(write(tmp_path / "run", 3))
    with pytest.raises(BagError, match="no topic /nothing; it has /diagnostics, /joint_states"):
        bag.array("/nothing", "position")
    with pytest.raises(BagError, match=r"no field 'positions'; it has header\.stamp\.sec, .*position"):
        bag.array("/joint_states", "positions")
    with pytest.raises(BagError, match="no definition of nobody_msgs/msg/Thing is installed"):
        BagWriter(tmp_path / "other").add_topic("/thing", "nobody_msgs/msg/Thing")


def test_times_never_run_backwards(tmp_path: Path) -> None:
    """A clock that is set back does not make a bag that readers refuse."""
    with BagWriter(tmp_path / "run") as bag:
        channel = bag.add_topic("/joint_states", JOINTS)
        for time in (50, 70, 60, 65, 80):
            bag.write(channel, joint_state(0, ["a"]), time)
    assert list(Bag(tmp_path / "run").times("/joint_states")) == [50, 70, 70, 70, 80]


def test_definitions_and_hashes_are_those_of_ros(tmp_path: Path) -> None:
    """rosbags reads our schemas and computes the hashes that we write, custom types too."""
    for name in [
        "ElasticState",
        "ElasticLayout",
        "TemperatureField",
        "LeafMesh",
        "Thermocouples",
        "LeafDeflection",
        "FireCriteria",
        "Reactions",
    ]:
        store = get_typestore(Stores.EMPTY)
        full = f"flexsim_msgs/msg/{name}"
        store.register(get_types_from_msg(definition(full), full))
        assert store.hash_rihs01(full) == type_hash(full)
    for full in (JOINTS, "sensor_msgs/msg/PointCloud2", "diagnostic_msgs/msg/DiagnosticArray"):
        assert STORE.hash_rihs01(full) == type_hash(full)


def test_killed_recorder_loses_little(tmp_path: Path) -> None:
    """Without its end a bag is still read up to the last flush, and says that it is not whole."""
    writer = BagWriter(tmp_path / "run", flush_period=0.0)
    channel = writer.add_topic("/joint_states", JOINTS)
    for k in range(100):
        writer.write(channel, joint_state(k, ["a", "b"]), k)
        if k == 89:
            writer.flush_if_due()
    bag = Bag(tmp_path / "run")  # the writer is still open: what a kill would have left
    assert not bag.complete
    assert bag.topics["/joint_states"].count == 90
    assert bag.array("/joint_states", "position")[1].shape == (90, 2)
    writer.close()
    assert Bag(tmp_path / "run").complete


def test_reads_what_rosbags_writes(tmp_path: Path) -> None:
    """A bag of another tool, with another quality of service, is read alike."""
    path = tmp_path / "other"
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        connection = writer.add_connection("/joint_states", JOINTS, typestore=STORE)
        for k in range(20):
            writer.write(connection, SECOND + k, joint_state(k, ["a", "b"]))
    bag = Bag(path)
    assert bag.topics["/joint_states"].type == JOINTS
    assert bag.start == SECOND
    np.testing.assert_array_equal(bag.array("/joint_states", "position")[1][:, 0], np.arange(20))


def test_offered_quality_survives(tmp_path: Path) -> None:
    """What one offers is what rosbags reads back."""
    offered = [qos.offered(durability="transient_local", depth=1), qos.offered(depth=7)]
    with BagWriter(tmp_path / "run") as bag:
        channel = bag.add_topic("/joint_states", JOINTS, offered)
        bag.write(channel, joint_state(0, ["a"]), 5)
    with Reader(tmp_path / "run") as reader:
        profiles = reader.connections[0].ext.offered_qos_profiles
        assert [(p.durability.name, p.depth) for p in profiles] == [
            ("TRANSIENT_LOCAL", 1),
            ("VOLATILE", 7),
        ]
        assert len(list(reader.messages())) == 1
    assert Bag(tmp_path / "run").topics["/joint_states"].profiles == offered


def test_tables(tmp_path: Path) -> None:
    """A topic becomes a table of Arrow, and through Parquet it comes back the same."""
    from pyarrow import parquet

    bag = Bag(write(tmp_path / "run", 50))
    table = bag.arrow("/joint_states", ["position", "header.frame_id"])
    parquet.write_table(table, tmp_path / "run.parquet")
    again = parquet.read_table(tmp_path / "run.parquet")
    np.testing.assert_array_equal(
        np.array(again["position"].to_pylist()), bag.array("/joint_states", "position")[1]
    )
    assert again["log_time"].cast("int64").to_pylist() == bag.times("/joint_states").tolist()
    assert set(bag.fields("/joint_states")) == {
        "header.stamp.sec", "header.stamp.nanosec", "header.frame_id", "name", "position", "velocity",
        "effort",
    }  # fmt: skip


def test_part_of_an_array(tmp_path: Path) -> None:
    """A slice of a field is read as Python would have it."""
    bag = Bag(write(tmp_path / "run", 20))
    _, all_of_it = bag.array("/joint_states", "position")
    for words, part in (
        ("[-1:]", slice(-1, None)),
        ("[:2]", slice(2)),
        ("[1:2]", slice(1, 2)),
        ("[5:]", slice(5, None)),
    ):
        np.testing.assert_array_equal(bag.array("/joint_states", f"position{words}")[1], all_of_it[:, part])
    with pytest.raises(BagError, match="no field"):
        bag.array("/joint_states", "header.frame_id[1:]")
