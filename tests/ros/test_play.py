"""A recorded run is played: as it was, and once more through the simulator, the same to the bit."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flexsim.bag import Bag, BagError
from flexsim.bag.robot import robot_in
from flexsim.replay.drive import read_drive
from listening import PATIENCE
from played import listener, other_bag
from processes import Background, command, flexsim, ros_environment
from rclpy.qos import DurabilityPolicy, QoSProfile
from robot_process import SCENE, words
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray, String

from flexsim_node import load_scene

# A recorder that has to keep up, and a player whose timing is looked at.
pytestmark = [pytest.mark.ros, pytest.mark.alone]

SECOND = 10**9


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record a robot in real time, under torques that come when they please."""
    folder = tmp_path_factory.mktemp("run")
    environment = ros_environment()
    bag = folder / "run"
    recorder = Background(command("record", "-o", bag, "--json"), environment, folder)
    # Its time stands still until the first torque, by when the recorder is there.
    robot = Background(
        words(scene=SCENE, rate=500.0, elastic_rate=500.0, wait_for_command=True,
              override__solver__step=0.001), environment, folder
    )  # fmt: skip
    robot.wait_for("kernels ready", PATIENCE)
    recorder.wait_for("+ /joint_states")
    recorder.wait_for("+ scene of /flexsim_node: anthropomorphic")
    random = np.random.default_rng(1)
    states = {"/joint_states": (JointState, QoSProfile(depth=1))}
    with listener(environment, states) as (heard, listen, node):
        torques = node.create_publisher(Float64MultiArray, "flexsim_node/commands", QoSProfile(depth=10))

        def drive(until: Any, timeout: float) -> None:
            end = time.monotonic() + timeout
            while not until() and time.monotonic() < end:
                torques.publish(Float64MultiArray(data=random.normal(0.0, 2.0, 3).tolist()))
                listen(lambda: False, float(random.uniform(0.0, 0.02)))

        # Until it hears them, which takes as long as the middleware takes to make them known.
        drive(lambda: heard["/joint_states"] and heard["/joint_states"][-1][1].header.stamp.nanosec > 1, 40.0)
        drive(lambda: False, 1.5)
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
    """A bag explains itself: the scene that the node ran, and its parameters, as it published them."""
    bag = Bag(run)
    told = robot_in(bag).scene
    assert told is not None and told.overrides == {"solver.step": 0.001}
    assert load_scene(told.scene) == load_scene(SCENE, {"solver.step": 0.001})
    parameters = bag.notes()["/flexsim_node"]
    assert json.loads(parameters["override.solver.step"]) == 0.001
    assert json.loads(parameters["scene"]) == str(SCENE)


def test_reproduced_to_the_bit(run: Path, tmp_path: Path) -> None:
    """The simulator, driven in lock-step by what was recorded, does what it did, bit by bit."""
    again = tmp_path / "again"
    done = flexsim("play", run, "--lockstep", "-o", again, "--json", timeout=300)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    comparison = said["comparison"]
    assert comparison["exact"]
    assert comparison["scenes"]["/flexsim_node"]["same"]
    assert said["stopped"] == ""
    states = comparison["fields"]["/joint_states position"]
    assert states["compared"] > 600
    assert states["only_first"] == 0
    assert comparison["fields"]["/flexsim_node/elastic_state displacement"]["compared"] > 600
    # The robot did move, and the new bag can be driven again in its turn.
    _, position = Bag(again).array("/joint_states", "position")
    assert np.ptp(position, axis=0).min() > 0.01
    # It has a state for each tick, of which the first bag has perhaps every second one.
    held, torque = read_drive(Bag(run)).torque, read_drive(Bag(again)).torque
    ticks = len(torque) // len(held)
    np.testing.assert_array_equal(torque[ticks - 1 :: ticks], held)

    # Offline it is the same as well.
    saved = tmp_path / "again.npz"
    done = flexsim("simulate", run, "--save", saved, timeout=300)
    assert done.returncode == 0, done.stderr
    arrays = np.load(saved)
    time, position = states_of(run)
    every = round(time[-1] / (len(time) - 1) / (arrays["time"][1] * SECOND))
    offline = arrays["joint_position"][::every][: len(time)]
    np.testing.assert_allclose(offline, position, rtol=0, atol=1e-9)


def test_compare_finds_what_was_changed(run: Path, tmp_path: Path) -> None:
    """A coarser model differs, by how much and since when is said; pictures and recordings show it."""
    coarse = tmp_path / "coarse"
    done = flexsim(
        "play", run, "--lockstep", "--set", "links.link_3.payload.mass=0.05", "-o", coarse, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert "differ since 0.00" in done.stdout
    picture, recording = tmp_path / "both.png", tmp_path / "both.rrd"
    done = flexsim("compare", run, coarse, "--plot", picture, "--save", recording, "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    position = said["fields"]["/joint_states position"]
    first, second = states_of(run), states_of(coarse)
    _, i, j = np.intersect1d(first[0], second[0], return_indices=True)
    off = np.abs(second[1][j] - first[1][i])
    assert position["largest"] == off.max()
    assert position["rms"] == pytest.approx(np.sqrt((off**2).mean()), rel=1e-12)
    assert 0.0 < said["since"] <= 0.002
    assert picture.stat().st_size > 20_000
    assert {"a/robot/deformed", "b/robot/deformed", "between"} <= set(said["rows"])
    assert flexsim("compare", run, coarse, "--exact").returncode == 1
    assert flexsim("compare", run, coarse, "--tolerance", 1e-9).returncode == 1
    assert flexsim("compare", run, run, "--exact", "--tolerance", 0).returncode == 0


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


def test_keys(tmp_path: Path) -> None:
    """In a terminal it waits for the space bar, steps by a message, goes on, and ends with q."""
    environment = ros_environment()
    bag = other_bag(tmp_path)
    terminal, end = pty.openpty()
    with listener(environment, OTHER) as (heard, listen, node):
        process = subprocess.Popen(
            command("play", bag, "/numbers", "--wait", 20, "--start-paused"),
            env=environment, stdin=end, stdout=subprocess.DEVNULL, stderr=end,
        )  # fmt: skip
        os.close(end)

        def press(key: str, count: int) -> list[float]:
            os.write(terminal, key.encode())
            listen(lambda: len(heard["/numbers"]) >= count, 10.0)
            listen(lambda: False, 0.15)
            return [m.data[0] for _, m in heard["/numbers"]]

        # Its publisher is there when it has taken the terminal's keys.
        listen(lambda: node.count_publishers("/numbers"))
        listen(lambda: False, 1.0)
        assert not heard["/numbers"]
        assert press("s", 1) == [0.0]
        assert press("\x1b[C", 2) == [0.0, 1.0]
        assert press(" ", 50) == list(range(50))
        assert process.wait(10) == 0
    os.close(terminal)


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
