"""Foxglove's own readers open a bag and decode every message: @mcap/core, @foxglove/rosmsg2-serialization.

They are npm packages, pinned in foxglove/package-lock.json, installed once into pytest's cache.
"""

from __future__ import annotations

import array
import hashlib
import inspect
import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import flexsim_msgs.msg
import numpy as np
import pytest
from flexsim.bag import BagWriter
from processes import Recorded
from rclpy.serialization import serialize_message
from synthetic_robot import JOINTS, shape

pytestmark = pytest.mark.ros

HERE = Path(__file__).with_name("foxglove")
KINDS = {
    f"/kinds/{name.lower()}": kind for name, kind in inspect.getmembers(flexsim_msgs.msg, inspect.isclass)
}


@pytest.fixture(scope="module")
def reader(request: pytest.FixtureRequest) -> Path:
    """Return the reading program beside its installed packages; skip where they can't be had."""
    node, npm = shutil.which("node"), shutil.which("npm")
    if node is None or npm is None:
        pytest.skip("Node.js and npm are not installed (Debian: apt-get install npm)")
    lock = (HERE / "package-lock.json").read_bytes()
    folder = Path(request.config.cache.mkdir(f"foxglove_{hashlib.sha256(lock).hexdigest()[:12]}"))
    stamp = folder / "installed"
    for file in HERE.iterdir():
        shutil.copy(file, folder)
    if not stamp.exists():
        words = [npm, "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--fetch-retries=1"]
        try:
            done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=120)
        except subprocess.TimeoutExpired:
            pytest.skip("the npm registry does not answer")
        unreachable = ("ENOTFOUND", "EAI_AGAIN", "ECONNREFUSED", "ETIMEDOUT", "ENETUNREACH", "ENOTCACHED")
        if done.returncode and any(word in done.stderr for word in unreachable):
            pytest.skip("the npm registry is not reachable")
        assert done.returncode == 0, done.stderr
        stamp.touch()
    return folder / "read.mjs"


def read(reader: Path, bag: Path) -> dict[str, Any]:
    """Return all topics of a bag's one file, decoded."""
    (file,) = bag.glob("*.mcap")
    done = subprocess.run(["node", str(reader), str(file)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_a_recorded_run(reader: Path, recorded: Recorded) -> None:
    """Every number of every message of a recorded robot is the one that was sent."""
    found = read(reader, recorded.bag)
    assert found["profile"] == "ros2"
    topics = found["topics"]
    assert found["counted"] == sum(len(topic["messages"]) for topic in topics.values())
    t = (1 + np.arange(recorded.messages)) / recorded.rate
    q, rigid, deformed = shape(t, 3)
    joints = topics["/joint_states"]
    assert joints["type"] == "sensor_msgs/msg/JointState"
    assert all(m["name"] == JOINTS for m in joints["messages"])
    np.testing.assert_array_equal([m["position"] for m in joints["messages"]], q)
    stamps = [
        m["header"]["stamp"]["sec"] * 10**9 + m["header"]["stamp"]["nanosec"] for m in joints["messages"]
    ]
    np.testing.assert_array_equal(stamps, np.rint(t * 1e9).astype(np.int64))
    states = topics["/flexsim_node/elastic_state"]["messages"]
    np.testing.assert_array_equal([m["position"] for m in states], deformed.reshape(len(t), -1))
    np.testing.assert_array_equal([m["rigid_position"] for m in states], rigid.reshape(len(t), -1))
    assert states[-1]["status"] == "rotation beyond 0.1 rad"
    (layout,) = topics["/flexsim_node/elastic_layout"]["messages"]
    assert layout["link_names"] == ["link_1", "link_2", "link_3"]
    assert topics["/diagnostics"]["messages"][0]["status"][0]["message"] == "end"


def filled(kind: type, seed: int) -> Any:
    """Return a message whose every field holds something of its own."""
    message = kind()
    for n, (name, words) in enumerate(kind.get_fields_and_field_types().items()):
        number = 10 * seed + n + 1
        if name == "header":
            message.header.stamp.sec, message.header.frame_id = number, "leaf"
        elif words == "sequence<double>":
            setattr(message, name, array.array("d", [number / 7.0, -1e300, 5e-324]))
        elif words == "sequence<uint32>":
            setattr(message, name, array.array("I", [number, 2**32 - 1]))
        elif words == "sequence<string>":
            setattr(message, name, ["", f"tür {number}", "x" * number])
        elif words == "sequence<boolean>":
            setattr(message, name, [True, False, True])
        elif words == "string":
            setattr(message, name, f"°C {number}")
        elif words == "double":
            setattr(message, name, number / 3.0)
        else:
            raise AssertionError(f"{kind.__name__}.{name}: {words} is new here")
    return message


def test_all_of_our_types(reader: Path, tmp_path: Path) -> None:
    """Each type of flexsim_msgs, decoded by the schema that the bag carries."""
    sent = {topic: [filled(kind, 1), kind(), filled(kind, 2)] for topic, kind in KINDS.items()}
    with BagWriter(tmp_path / "run") as bag:
        for topic, messages in sent.items():
            channel = bag.add_topic(topic, f"flexsim_msgs/msg/{KINDS[topic].__name__}")
            for k, message in enumerate(messages):
                bag.write(channel, serialize_message(message), k + 1)
    found = read(reader, tmp_path / "run")["topics"]
    assert len(sent) >= 8
    assert set(found) == set(sent)
    for topic, messages in sent.items():
        for message, seen in zip(messages, found[topic]["messages"], strict=True):
            assert found[topic]["type"] == f"flexsim_msgs/msg/{KINDS[topic].__name__}"
            for name in message.get_fields_and_field_types():
                value = getattr(message, name)
                if name == "header":
                    assert seen[name]["stamp"]["sec"] == value.stamp.sec
                    assert seen[name]["frame_id"] == value.frame_id
                else:
                    plain = list(value) if not isinstance(value, (str, float)) else value
                    assert seen[name] == plain, (topic, name)
