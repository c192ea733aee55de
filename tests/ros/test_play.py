"""A recorded run is played: as it was, and once more through the simulator, the same to the bit."""

from __future__ import annotations

import json
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from flexsim.bag import Bag, BagError
from flexsim.replay.drive import read_drive
from processes import Background, command, flexsim, ros_environment
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from robot_process import PATIENCE, SCENE, words
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from std_msgs.msg import Float64MultiArray, String

pytestmark = pytest.mark.ros

SECOND = 10**9


@contextmanager
def listener(environment: dict[str, str], topics: dict[str, tuple[Any, QoSProfile]]) -> Iterator[Any]:
    """Listen in another node; gives what was heard, by topic, and a function that listens on."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=int(environment["ROS_DOMAIN_ID"]))
    node = rclpy.create_node("listener", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    heard: dict[str, list[tuple[float, Any]]] = {name: [] for name in topics}
    for name, (kind, profile) in topics.items():
        node.create_subscription(
            kind, name, lambda m, n=name: heard[n].append((time.monotonic(), m)), profile
        )

    def listen(until: Any, timeout: float = 40.0) -> None:
        end = time.monotonic() + timeout
        while not until() and time.monotonic() < end:
            executor.spin_once(timeout_sec=0.01)

    try:
        yield heard, listen, node
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.shutdown(context=context)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record a robot in real time, under torques that come when they please."""
    folder = tmp_path_factory.mktemp("run")
    environment = ros_environment()
    bag = folder / "run"
    recorder = Background(command("record", "-o", bag, "--json"), environment, folder)
    robot = Background(
        words(scene=SCENE, rate=500.0, elastic_rate=500.0, override__solver__step=0.001), environment, folder
    )
    robot.wait_for("kernels ready", PATIENCE)
    recorder.wait_for("+ /joint_states")
    recorder.wait_for("+ parameters and anthropomorphic.yaml of /flexsim_node")
    random = np.random.default_rng(1)
    with listener(environment, {}) as (_, _, node):
        torques = node.create_publisher(Float64MultiArray, "flexsim_node/commands", QoSProfile(depth=10))
        begun = time.monotonic()
        while time.monotonic() < begun + 1.5:
            torques.publish(Float64MultiArray(data=random.normal(0.0, 2.0, 3).tolist()))
            time.sleep(float(random.uniform(0.0, 0.02)))
    assert robot.end(signal.SIGINT) == 0, robot.errors.read_text()
    assert recorder.end(signal.SIGINT) == 0, recorder.errors.read_text()
    return bag


def states_of(bag: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return the stamps, ns, and the joint positions of a bag, each time once."""
    stamp = ["header.stamp.sec", "header.stamp.nanosec"]
    _, columns = Bag(bag).columns("/joint_states", ["position", *stamp])
    time, first = np.unique(columns[stamp[0]] * SECOND + columns[stamp[1]], return_index=True)
    return time, columns["position"][first]


def test_the_recorder_keeps_the_scene(run: Path) -> None:
    """A bag explains itself: the scene's text, and the parameters of the node that simulated it."""
    bag = Bag(run)
    assert bag.attachment(SCENE.name) == SCENE.read_bytes()
    parameters = bag.notes()["/flexsim_node"]
    assert json.loads(parameters["override.solver.step"]) == 0.001
    assert json.loads(parameters["scene"]) == str(SCENE)


def test_a_run_that_is_not_all_there_is_refused(run: Path, tmp_path: Path) -> None:
    """Where a state is missing it is not known what drove the robot, and that is said."""
    from flexsim.bag import BagWriter

    whole = Bag(run)
    for name, left_out, words_of_it in (
        ("late", range(20), "begins at"),
        ("gap", range(300, 310), "lacks 10 states behind"),
    ):
        with BagWriter(tmp_path / name) as bag:
            topic = bag.add_topic("/joint_states", "sensor_msgs/msg/JointState")
            seen: set[bytes] = set()
            for log_time, data in whole.messages("/joint_states"):
                seen.add(data[4:12])
                if len(seen) - 1 not in left_out:
                    bag.write(topic, data, log_time)
        with pytest.raises(BagError, match=words_of_it):
            read_drive(Bag(tmp_path / name))
    done = flexsim("play", tmp_path / "gap", "--lockstep")
    assert done.returncode == 1
    assert "lacks 10 states" in done.stderr


def other_bag(folder: Path) -> Path:
    """A bag of another tool: two topics, one of them latched, 100 Hz for half a second."""
    store = get_typestore(Stores.ROS2_JAZZY)
    from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

    forever = QosTime(9223372036, 854775807)

    def profile(durability: QosDurability) -> Qos:
        return Qos(QosHistory.KEEP_LAST, 10, QosReliability.RELIABLE, durability, forever, forever,
                   QosLiveliness.AUTOMATIC, forever, False)  # fmt: skip

    path = folder / "other"
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        names = writer.add_connection(
            "/description", "std_msgs/msg/String", typestore=store,
            offered_qos_profiles=[profile(QosDurability.TRANSIENT_LOCAL)],
        )  # fmt: skip
        numbers = writer.add_connection(
            "/numbers", "std_msgs/msg/Float64MultiArray", typestore=store,
            offered_qos_profiles=[profile(QosDurability.VOLATILE)],
        )  # fmt: skip
        text = store.types["std_msgs/msg/String"]("an arm")
        writer.write(names, SECOND, store.serialize_cdr(text, "std_msgs/msg/String"))
        layout = store.types["std_msgs/msg/MultiArrayLayout"]([], 0)
        for k in range(50):
            message = store.types["std_msgs/msg/Float64MultiArray"](layout, np.array([float(k)]))
            data = store.serialize_cdr(message, "std_msgs/msg/Float64MultiArray")
            writer.write(numbers, SECOND + k * SECOND // 100, data)
    return path


LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
OTHER = {"/numbers": (Float64MultiArray, QoSProfile(depth=100)), "/description": (String, LATCHED)}


def test_a_bag_of_another_tool_plays(tmp_path: Path) -> None:
    """Each message comes once, in order, with the recorded timing, and with what its publisher offered."""
    environment = ros_environment()
    bag = other_bag(tmp_path)
    with listener(environment, OTHER) as (heard, listen, _):
        words_ = command("play", bag, "--wait", 20, "--rate", 0.5, "--json")
        player = Background(words_, environment, tmp_path)
        listen(lambda: len(heard["/numbers"]) == 50 and heard["/description"])
        assert player.process.wait(20) == 0, player.errors.read_text()
    times, messages = zip(*heard["/numbers"], strict=True)
    assert [m.data[0] for m in messages] == list(range(50))
    assert heard["/description"][0][1].data == "an arm"
    assert times[-1] - times[0] == pytest.approx(0.98, abs=0.25)  # 0.49 s at half the rate
    said = json.loads(player.output.read_text())
    assert said["topics"] == {"/numbers": 50, "/description": 1}


def test_offset_topics_and_loop(tmp_path: Path) -> None:
    """From an offset on, only what was asked for, again and again until Ctrl-C."""
    environment = ros_environment()
    bag = other_bag(tmp_path)
    with listener(environment, OTHER) as (heard, listen, _):
        words_ = command("play", bag, "/num*", "--start-offset", 0.4, "--loop", "--wait", 20, "--rate", 2)
        player = Background(words_, environment, tmp_path)
        listen(lambda: len(heard["/numbers"]) >= 35)
        assert player.end(signal.SIGINT) == 0, player.errors.read_text()
    values = [m.data[0] for _, m in heard["/numbers"]]
    assert values[:30] == 3 * list(range(40, 50))
    assert not heard["/description"]
    wrong = flexsim("play", bag, "/nothing")
    assert wrong.returncode == 1
    assert "no topic /nothing; it has /description, /numbers" in wrong.stderr
    assert flexsim("play", bag, "--start-offset", 9).returncode == 2


def test_latched_messages_come_before_the_offset(tmp_path: Path) -> None:
    environment = ros_environment()
    bag = other_bag(tmp_path)
    with listener(environment, OTHER) as (heard, listen, _):
        player = Background(command("play", bag, "--start-offset", 0.4, "--wait", 20), environment, tmp_path)
        listen(lambda: len(heard["/numbers"]) == 10 and heard["/description"])
        assert player.process.wait(20) == 0
    assert len(heard["/description"]) == 1


def test_wrong_words(tmp_path: Path, run: Path) -> None:
    """Options that do not go together are refused; a bag without its scene asks for it."""
    assert flexsim("play", run, "--scene", SCENE).returncode == 2
    assert flexsim("play", run, "--lockstep", "--rate", 2).returncode == 2
    done = flexsim("play", run, "--lockstep", "-o", run)
    assert done.returncode == 1
    assert "exists already" in done.stderr
    done = flexsim("play", other_bag(tmp_path), "--lockstep")
    assert done.returncode == 1
    assert "holds no joint states" in done.stderr
