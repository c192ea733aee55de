"""The main job, shortened: what it says is there, and others read the bag of a real node."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from processes import Background, command, flexsim, ros_environment
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from test_view import rows

# The robot of the demo keeps its deadlines, and the recorder has to keep up.
pytestmark = [pytest.mark.ros, pytest.mark.slow, pytest.mark.alone]
TYPES = {
    "/clock": "rosgraph_msgs/msg/Clock",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/flexsim_node/commands": "std_msgs/msg/Float64MultiArray",
    "/flexsim_node/deformed_shape": "sensor_msgs/msg/PointCloud2",
    "/flexsim_node/elastic_layout": "flexsim_msgs/msg/ElasticLayout",
    "/flexsim_node/elastic_state": "flexsim_msgs/msg/ElasticState",
    "/flexsim_node/scene": "std_msgs/msg/String",
    "/joint_states": "sensor_msgs/msg/JointState",
    "/robot_description": "std_msgs/msg/String",
}
LATCHED = ("/flexsim_node/elastic_layout", "/flexsim_node/scene", "/robot_description")
DURATION = 2.5


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> dict[str, object]:
    folder = tmp_path_factory.mktemp("demo")
    done = flexsim("demo", "--duration", DURATION, "--json", cwd=folder, timeout=400)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    return {**found, **{k: folder / found[k] for k in ("bag", "recording", "picture")}}


def test_the_table(demo: dict[str, object]) -> None:
    """The arm is held and swings; commands are heard and show in the state."""
    assert demo["duration"] == DURATION
    assert demo["ticks"] > 1e3 * DURATION
    assert 0.0 < demo["step_time_p50"] <= demo["step_time_p99"] <= demo["step_time_worst"]
    assert demo["commands"] > 100
    assert demo["commands_refused"] == 0
    assert 0.0 < demo["latency_p50"] <= demo["latency_p99"]
    assert 2e-3 < demo["tip_deflection_rms"] < demo["tip_deflection_peak"] < 0.2
    assert demo["bag_bytes"] > 100_000


def test_rosbags_reads_the_bag(demo: dict[str, object]) -> None:
    """Types, counts and quality of service of a real node's bag are as another program expects."""
    store = get_typestore(Stores.ROS2_JAZZY)
    seen = dict.fromkeys(TYPES, 0)
    with Reader(demo["bag"]) as reader:
        found = {c.topic: c for c in reader.connections}
        assert {t: c.msgtype for t, c in found.items() if t in TYPES} == TYPES
        for c in reader.connections:
            if c.msgtype not in store.types:
                store.register(get_types_from_msg(c.msgdef.data, c.msgtype))
            offered = {(q.reliability.name, q.durability.name) for q in c.ext.offered_qos_profiles}
            if c.topic in TYPES:
                latched = "TRANSIENT_LOCAL" if c.topic in LATCHED else "VOLATILE"
                assert offered == {("RELIABLE", latched)}, c.topic
        for connection, _, raw in reader.messages():
            message = store.deserialize_cdr(raw, connection.msgtype)
            if connection.topic in seen:
                seen[connection.topic] += 1
            if connection.topic == "/joint_states":
                assert message.name == ["joint_1", "joint_2", "joint_3"]
                assert len(message.position) == len(message.velocity) == len(message.effort) == 3
                assert np.isfinite(message.position).all()
            elif connection.topic == "/flexsim_node/deformed_shape":
                assert [f.name for f in message.fields][:3] == ["x", "y", "z"]
                assert len(message.data) == message.width * message.point_step
        assert seen == {t: found[t].msgcount for t in TYPES}
    assert seen["/joint_states"] > 1e3 * DURATION * 0.9
    assert seen["/flexsim_node/elastic_layout"] == seen["/robot_description"] == 1


def test_rerun_reads_bag_and_recording(demo: dict[str, object], tmp_path: Path) -> None:
    """rerun's own loader makes entities of every topic; the recording has the robot."""
    file = next(demo["bag"].glob("*.mcap"))
    rrd = tmp_path / "loaded.rrd"
    words = [sys.executable, "-m", "rerun", "mcap", "convert", str(file), "-o", str(rrd)]
    subprocess.run(words, check=True, capture_output=True, timeout=120)
    loaded = rows(rrd)
    with Reader(demo["bag"]) as reader:
        for c in reader.connections:
            if c.topic in TYPES:
                assert loaded[c.topic] >= c.msgcount, c.topic
    shown = rows(demo["recording"])
    assert shown["/robot/deformed"] > 50
    assert demo["picture"].read_bytes().startswith(b"\x89PNG")


def test_nothing_is_written_over(tmp_path: Path) -> None:
    """A folder with something in it is refused in one sentence."""
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "notes.txt").write_text("mine")
    done = flexsim("demo", "--output", "run", cwd=tmp_path)
    assert done.returncode == 1
    assert "exists already" in done.stderr
    assert [f.name for f in (tmp_path / "run").iterdir()] == ["notes.txt"]


def test_ctrl_c_leaves_no_process(tmp_path: Path) -> None:
    """Ctrl-C in the middle ends robot, recorder and controller with the demo."""
    environment = ros_environment() | {"FLEXSIM_TEST_MARK": str(tmp_path)}
    words = command("demo", "--output", tmp_path / "run")
    running = Background(words, environment, tmp_path)
    running.wait_for("the arm moves", timeout=300.0)
    assert len(marked(tmp_path)) == 4
    assert running.end(signal.SIGINT) == 130
    assert marked(tmp_path) == []
    assert "Traceback" not in running.errors.read_text()


def marked(mark: Path) -> list[int]:
    """Return the processes that were started with this mark in their environment."""
    found = []
    for entry in Path("/proc").glob("[0-9]*/environ"):
        try:
            if f"FLEXSIM_TEST_MARK={mark}".encode() in entry.read_bytes():
                found.append(int(entry.parent.name))
        except OSError:
            continue
    return found
