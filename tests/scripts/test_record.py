"""What the recorder writes is all that was sent, in a form that others read."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from flexsim.bag import BagWriter
from flexsim.ros.context import tool_node
from flexsim.ros.recorder import Recorder
from mcap.reader import make_reader
from processes import Background, Recorded, command, flexsim, ros_environment, synthetic_robot
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from ruamel.yaml import YAML
from synthetic_robot import JOINTS, shape

pytestmark = pytest.mark.ros

TYPES = {
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/flexsim_node/commands": "std_msgs/msg/Float64MultiArray",
    "/flexsim_node/elastic_layout": "flexsim_msgs/msg/ElasticLayout",
    "/flexsim_node/elastic_state": "flexsim_msgs/msg/ElasticState",
    "/joint_states": "sensor_msgs/msg/JointState",
}


def counts(recorded: Recorded) -> dict[str, int]:
    once = dict.fromkeys(TYPES, 1)
    states = dict.fromkeys(["/joint_states", "/flexsim_node/elastic_state"], recorded.messages)
    return {**once, **states}


def test_rosbags_decodes_every_message(recorded: Recorded) -> None:
    """An independent reader finds all that was published, the custom types from the bag itself."""
    store = get_typestore(Stores.ROS2_JAZZY)
    seen: dict[str, int] = dict.fromkeys(TYPES, 0)
    t = (1 + np.arange(recorded.messages)) / recorded.rate
    q, rigid, deformed = shape(t, 3)
    with Reader(recorded.bag) as reader:
        assert {c.topic: c.msgtype for c in reader.connections if c.msgcount} == TYPES
        for c in reader.connections:
            if c.msgtype not in store.types:
                store.register(get_types_from_msg(c.msgdef.data, c.msgtype))
            assert store.hash_rihs01(c.msgtype) == c.digest, c.topic
        last = 0
        for connection, log_time, raw in reader.messages():
            assert log_time >= last
            last = log_time
            message = store.deserialize_cdr(raw, connection.msgtype)
            k = seen[connection.topic]
            if connection.topic == "/joint_states":
                assert message.name == JOINTS
                np.testing.assert_array_equal(message.position, q[k])
            elif connection.topic == "/flexsim_node/elastic_state":
                np.testing.assert_array_equal(message.position, deformed[k].ravel())
                np.testing.assert_array_equal(message.rigid_position, rigid[k].ravel())
            seen[connection.topic] += 1
    assert seen == counts(recorded)


def test_quality_of_service_is_what_was_offered(recorded: Recorded) -> None:
    """A player offers what the publishers did; metadata and channel say the same."""
    with Reader(recorded.bag) as reader:
        words = {
            c.topic: [(q.reliability.name, q.durability.name) for q in c.ext.offered_qos_profiles]
            for c in reader.connections
        }
    assert words["/joint_states"] == [("RELIABLE", "VOLATILE")]
    assert words["/flexsim_node/commands"] == [("BEST_EFFORT", "VOLATILE")]
    assert words["/flexsim_node/elastic_layout"] == [("RELIABLE", "TRANSIENT_LOCAL")]

    yaml = YAML(typ="safe", pure=True)
    metadata = yaml.load(recorded.bag / "metadata.yaml")["rosbag2_bagfile_information"]
    with next(recorded.bag.glob("*.mcap")).open("rb") as file:
        channels = make_reader(file).get_summary().channels.values()
    in_channels = {c.topic: c.metadata for c in channels}
    for entry in metadata["topics_with_message_count"]:
        topic = entry["topic_metadata"]
        channel = in_channels[topic["name"]]
        assert yaml.load(channel["offered_qos_profiles"]) == topic["offered_qos_profiles"]
        assert channel["topic_type_hash"] == topic["type_description_hash"]
        assert topic["type_description_hash"].startswith("RIHS01_")


def test_mcap_reader_agrees(recorded: Recorded) -> None:
    """The container is whole by its own library's judgement, checksums included."""
    seen: dict[str, int] = dict.fromkeys(TYPES, 0)
    with next(recorded.bag.glob("*.mcap")).open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        for schema, channel, _ in reader.iter_messages():
            assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
            seen[channel.topic] += 1
    assert seen == counts(recorded)


def test_rerun_loads_it(recorded: Recorded, tmp_path: Path) -> None:
    """rerun's own MCAP loader makes entities of every topic, custom types too."""
    from test_view import rows

    file = next(recorded.bag.glob("*.mcap"))
    rrd = tmp_path / "loaded.rrd"
    words = [sys.executable, "-m", "rerun", "mcap", "convert", str(file), "-o", str(rrd)]
    subprocess.run(words, check=True, capture_output=True, timeout=60)
    loaded = rows(rrd)
    for topic, count in counts(recorded).items():
        assert loaded[topic] >= count, topic
    assert loaded["/joint_states/position"] >= recorded.messages


def test_what_the_recorder_says(recorded: Recorded) -> None:
    """The closing report and `flexsim info` agree with what was sent."""
    said = json.loads(recorded.output)
    assert {t: v["messages"] for t, v in said["topics"].items() if t in TYPES} == counts(recorded)
    assert said["topics"]["/joint_states"]["dropped"] == 0
    assert said["topics"]["/joint_states"]["rate"] == pytest.approx(recorded.rate, rel=0.2)
    assert said["error"] == ""

    info = json.loads(flexsim("info", recorded.bag, "--json").stdout)
    assert {t: v["messages"] for t, v in info["topics"].items() if t in TYPES} == counts(recorded)
    assert {t: v["type"] for t, v in info["topics"].items() if t in TYPES} == TYPES
    assert info["complete"]
    assert info["messages"] == said["messages"]
    shown = flexsim("info", recorded.bag).stdout
    assert "/joint_states" in shown
    assert "transient_local" in shown


def test_topics_chosen_and_ended_by_sigterm(tmp_path: Path) -> None:
    """A pattern picks topics; a topic that appears late is found; SIGTERM finishes the bag."""
    environment = ros_environment()
    bag = tmp_path / "part"
    words = command("record", "-o", bag, "/joint*", "flexsim_node/elastic_layout")
    recorder = Background(words, environment, tmp_path)
    recorder.wait_for("recording to")
    robot = synthetic_robot(environment, tmp_path, 10, 100.0)
    recorder.wait_for("+ /joint_states")
    recorder.wait_for("+ /flexsim_node/elastic_layout")
    assert recorder.end(signal.SIGTERM) == 0
    robot.end(signal.SIGTERM)
    with Reader(bag) as reader:
        topics = {c.topic for c in reader.connections}
    assert topics == {"/joint_states", "/flexsim_node/elastic_layout"}
    assert "Traceback" not in recorder.errors.read_text()


def test_a_scene_is_expected_once_a_name_is_known(tmp_path: Path) -> None:
    """The middleware may know a publisher before it knows whose it is; the recorder waits for the name."""
    with tool_node("recorder") as node, BagWriter(tmp_path / "run") as bag:
        recorder = Recorder(node, bag, ["*"])
        assert not recorder.expecting
        recorder.meet("/arm/elastic_layout", {"_NODE_NAMESPACE_UNKNOWN_/_NODE_NAME_UNKNOWN_"})
        assert recorder.expecting and not recorder.met
        recorder.meet("/arm/elastic_layout", {"/arm/flexsim_node"})
        assert recorder.expecting and recorder.met == {"/arm/flexsim_node"}
        assert recorder.without_scene == ["/arm/flexsim_node"]
        recorder.close()


def test_nothing_to_record(tmp_path: Path) -> None:
    """Silence gives an empty bag that readers open, after the time that was asked for."""
    done = flexsim("record", "-o", tmp_path / "empty", "--duration", "0.3", "/silent", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["messages"] == 0
    with Reader(tmp_path / "empty") as reader:
        assert reader.message_count == 0


def test_an_existing_bag_is_not_touched(recorded: Recorded) -> None:
    """Recording over a bag is refused in one sentence."""
    before = sorted((f.name, f.stat().st_mtime_ns) for f in recorded.bag.iterdir())
    done = flexsim("record", "-o", recorded.bag)
    assert done.returncode == 1
    assert "exists already" in done.stderr
    assert done.stderr.count("\n") == 1
    assert sorted((f.name, f.stat().st_mtime_ns) for f in recorded.bag.iterdir()) == before


def test_a_type_that_is_not_installed_is_said_and_left_out(tmp_path: Path) -> None:
    """What cannot be described in the bag is named on stderr, and the rest is recorded."""
    environment = ros_environment()
    hide = (
        "from flexsim.bag import definitions; found = definitions.message_file\n"
        "def message_file(name, suffix):\n"
        "    if name.startswith('flexsim_msgs'): raise definitions.BagError('no such type')\n"
        "    return found(name, suffix)\n"
        "definitions.message_file = message_file\n"
        "from flexsim.cli import main; main()"
    )
    words = [sys.executable, "-c", hide, "record", "-o", str(tmp_path / "run")]
    recorder = Background(words, environment, tmp_path)
    robot = synthetic_robot(environment, tmp_path, 10, 100.0)
    recorder.wait_for("+ /joint_states")
    recorder.wait_for("- /flexsim_node/elastic_state is not recorded: no such type")
    assert recorder.end(signal.SIGINT) == 0
    robot.end(signal.SIGTERM)
    with Reader(tmp_path / "run") as reader:
        assert "/joint_states" in {c.topic for c in reader.connections}
