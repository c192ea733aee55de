"""`play` as users of rosbag2 know it: the clock, other names, other profiles, late subscribers."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bag_kinds import ARRAY, EMPTY, KINDS, QOS, header, run
from flexsim.bag.definitions import type_hash
from played import SECOND, listener, other_bag
from processes import Background, command, flexsim, ros_environment
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64MultiArray, String

pytestmark = [pytest.mark.ros, pytest.mark.alone]
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def test_clock_remap_and_profiles(tmp_path: Path) -> None:
    """The recorded time comes on /clock as often as asked for, a topic under its new name and profile."""
    environment = ros_environment()
    bag = other_bag(tmp_path)
    profiles = tmp_path / "profiles.yaml"
    profiles.write_text("/numbers:\n  reliability: best_effort\n  history: keep_last\n  depth: 7\n")
    topics = {
        "/clock": (Clock, QoSProfile(depth=1000)),
        "/again": (Float64MultiArray, QoSProfile(depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)),
        "/numbers": (Float64MultiArray, QoSProfile(depth=100)),
    }
    with listener(environment, topics) as (heard, listen, node):
        words = command("play", bag, "/numbers", "--wait", 20, "--clock", 100, "--rate", 0.5, "--json",
                        "--remap", "/numbers:=/again", "--qos-profile-overrides-path", profiles)  # fmt: skip
        player = Background(words, environment, tmp_path)
        offered: list[Any] = []

        def all_there() -> bool:
            offered.extend(node.get_publishers_info_by_topic("/again"))
            return len(heard["/again"]) >= 45

        listen(all_there)
        assert player.process.wait(20) == 0, player.errors.read_text()
        listen(lambda: False, 0.2)
    assert not heard["/numbers"]
    assert offered[0].qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
    told = [m.clock.sec + 1e-9 * m.clock.nanosec for _, m in heard["/clock"]]
    assert told == sorted(told)
    # It begins with the bag, at 1 s, and ends with it; twice as many ticks as at the recorded pace.
    assert told[0] == pytest.approx(1.0, abs=0.2) and told[-1] == pytest.approx(1.49, abs=0.05)
    assert 50 <= len(told) <= 110


def test_late_subscribers_get_what_was_latched(tmp_path: Path) -> None:
    """Who comes when the message is long gone gets it all the same."""
    environment = ros_environment()
    bag = other_bag(tmp_path)
    player = Background(command("play", bag, "--rate", 0.05), environment, tmp_path)
    with listener(environment, {"/numbers": (Float64MultiArray, QoSProfile(depth=10))}) as (heard, listen, _):
        listen(lambda: len(heard["/numbers"]) > 2)
    with listener(environment, {"/description": (String, LATCHED)}) as (heard, listen, _):
        listen(lambda: heard["/description"], 20.0)
        assert [m.data for _, m in heard["/description"]] == ["an arm"]
    player.end(2)


@pytest.mark.parametrize("kind", ["rosbag2, sqlite3", "rosbag2, mcap by message", "rosbag2, mcap by file"])
def test_bags_of_other_storages_play(kind: str, tmp_path: Path) -> None:
    """What is published is what was sent, not its compressed bytes."""
    environment = ros_environment()
    bag = KINDS[kind](tmp_path / "run", run(5))
    with listener(environment, {"/said": (String, QoSProfile(depth=10))}) as (heard, listen, _):
        words = command("play", bag, "/said", "/cell", "--wait", 20, "--json")
        player = Background(words, environment, tmp_path)
        listen(lambda: len(heard["/said"]) == 5)
        assert player.process.wait(20) == 0, player.errors.read_text()
    assert [m.data for _, m in heard["/said"]] == [f"word {k}" for k in range(5)]
    told = json.loads(player.output.read_text())
    assert told["topics"] == {"/said": 5}
    assert told["skipped"]["/cell"] == "no message type cell_msgs/msg/Mixed is installed"


def test_what_can_not_be_played_is_said(tmp_path: Path) -> None:
    """An odd name, a type that is a module, another definition, JSON: named, and the rest is played.

    And a jump of the recorded clock is said, not waited for.
    """
    from mcap.writer import Writer

    path = tmp_path / "odd.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="test")
        qos = {"offered_qos_profiles": QOS}

        def channel(topic: str, kind: str, text: str, encoding: str = "cdr") -> int:
            return writer.register_channel(
                topic, encoding, writer.register_schema(kind, "ros2msg", text.encode()), qos
            )

        numbers = {
            "sound": channel("/stop", EMPTY, ""),
            "name": channel("/odd \x1b[2J name!", EMPTY, ""),
            "module": channel("/module", "os/path/join", "bool x\n"),
            "other": channel("/other", ARRAY, "int8 quite_different\n"),
            "json": channel("/json", EMPTY, "", "json"),
        }
        for k in range(4):
            for number in numbers.values():
                writer.add_message(
                    number, k * SECOND // 100 + (SECOND * 86400 if k > 1 else 0), b"\0\1\0\0\0", 0
                )
        writer.finish()
    done = flexsim("play", path, "--json")
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["topics"] == {"/stop": 4}
    why = {name: told["skipped"][name] for name in told["skipped"]}
    assert "no such name" in why["/odd \x1b[2J name!"]
    assert why["/module"] == "no message type os/path/join is installed"
    assert "defined otherwise" in why["/other"] and "json, not CDR" in why["/json"]
    assert "jumps ahead by 86400 s, which is not waited for" in done.stderr
    assert "\x1b" not in done.stderr


def test_transforms_play(tmp_path: Path) -> None:
    """/tf, whose type no wheel has, is published as it was recorded."""
    from tf2_msgs.msg import TFMessage

    environment = ros_environment()
    bag = KINDS["mcap, zstd"](tmp_path / "run", run(5))
    with listener(environment, {"/tf": (TFMessage, QoSProfile(depth=100))}) as (heard, listen, _):
        player = Background(command("play", bag, "/tf", "--wait", 20), environment, tmp_path)
        listen(lambda: len(heard["/tf"]) == 5)
        assert player.process.wait(20) == 0, player.errors.read_text()
    assert [t.child_frame_id for t in heard["/tf"][4][1].transforms] == ["link_0", "link_1", "link_2"]
    assert heard["/tf"][4][1].transforms[0].transform.translation.x == pytest.approx(0.4)


def test_a_controllers_state_plays(tmp_path: Path) -> None:
    """control_msgs, which no wheel has either, is Jazzy's: what a robot's bag holds of it is published."""
    from control_msgs.msg import JointTrajectoryControllerState

    kind = "control_msgs/msg/JointTrajectoryControllerState"
    point, several = "trajectory_msgs/JointTrajectoryPoint", "trajectory_msgs/MultiDOFJointTrajectoryPoint"
    parts = ("reference", "feedback", "error", "output")
    text = "\n".join(
        ["std_msgs/Header header", "string[] joint_names", *(f"{point} {part}" for part in parts),
         "string[] multi_dof_joint_names", *(f"{several} multi_dof_{part}" for part in parts),
         "float64 speed_scaling_factor\n"]
    )  # fmt: skip
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(get_types_from_msg(text, kind))
    assert store.hash_rihs01(kind) == type_hash(kind)
    none = np.array([])
    still = store.types["builtin_interfaces/msg/Duration"](0, 0)

    def state(k: int) -> Any:
        made = store.types["trajectory_msgs/msg/JointTrajectoryPoint"]
        points = [made(np.array([k + 0.1 * i, 2.0]), none, none, none, still) for i in range(4)]
        nothing = [store.types["trajectory_msgs/msg/MultiDOFJointTrajectoryPoint"]([], [], [], still)] * 4
        return store.types[kind](header(SECOND + k), ["a", "b"], *points, [], *nothing, 0.5)

    bag = tmp_path / "run"
    with Writer(bag, version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        states = writer.add_connection("/controller_state", kind, typestore=store)
        for k in range(5):
            writer.write(states, SECOND + k * SECOND // 100, store.serialize_cdr(state(k), kind))
    environment = ros_environment()
    topics = {"/controller_state": (JointTrajectoryControllerState, QoSProfile(depth=100))}
    with listener(environment, topics) as (heard, listen, _):
        player = Background(command("play", bag, "--wait", 20), environment, tmp_path)
        listen(lambda: len(heard["/controller_state"]) == 5)
        assert player.process.wait(20) == 0, player.errors.read_text()
    last = heard["/controller_state"][4][1]
    assert list(last.joint_names) == ["a", "b"]
    assert [list(getattr(last, part).positions) for part in parts] == [
        [pytest.approx(4 + 0.1 * i), 2.0] for i in range(4)
    ]
    assert last.speed_scaling_factor == 0.5


def test_wrong_words_about_topics(tmp_path: Path) -> None:
    """One sentence each, before anything is published."""
    bag = other_bag(tmp_path)
    for words, sentence in (
        (("--remap", "/numbers"), "give OLD:=NEW"),
        (("--remap", "/nothing:=/x"), "no topic /nothing"),
        (("--qos", "/numbers=reliability:sometimes"), "reliability is reliable, best_effort"),
        (("--qos", "/numbers=colour:red"), "there is no policy 'colour'"),
        (("--qos-profile-overrides-path", tmp_path / "none.yaml"), "none.yaml can't be read"),
    ):
        done = flexsim("play", bag, *words)
        assert done.returncode in (1, 2) and sentence in done.stderr, done.stderr
