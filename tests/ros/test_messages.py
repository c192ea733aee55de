"""flexsim_msgs, as generated and installed by make: every user of the venv can send them."""

import json
import os
import subprocess
import sys
from pathlib import Path

import flexsim_msgs.msg as flexsim_msgs
import numpy as np
import pytest
from ament_index_python.packages import get_package_share_directory
from rclpy.serialization import deserialize_message, serialize_message

pytestmark = pytest.mark.ros
SCHEMA = Path(__file__).parents[2] / "msgs_schema" / "msg"
NAMES = sorted(path.stem for path in SCHEMA.glob("*.msg"))
SAMPLES = {
    "string": "name",
    "double": 0.1,
    "sequence<double>": [1.5, -2.5e-9, 3.0],
    "sequence<string>": ["link_1", "link_2"],
    "sequence<uint32>": [0, 7, 4294967295],
    "sequence<boolean>": [True, False],
}


@pytest.mark.parametrize("name", NAMES)
def test_a_message_arrives_as_it_was_sent(name: str) -> None:
    message_type = getattr(flexsim_msgs, name)
    sent = message_type()
    for field, kind in message_type.get_fields_and_field_types().items():
        if kind == "std_msgs/Header":
            sent.header.stamp.sec, sent.header.frame_id = 12, "base"
        else:
            setattr(sent, field, SAMPLES[kind])
    assert deserialize_message(serialize_message(sent), message_type) == sent


def test_numbers_are_read_without_a_copy_of_each() -> None:
    state = flexsim_msgs.ElasticState(displacement=[0.0, 1e-3, 0.0, 0.0, 0.0, 2e-3])
    assert np.frombuffer(state.displacement).reshape(-1, 6)[0, 5] == 2e-3


@pytest.mark.parametrize("name", NAMES)
def test_bags_can_name_the_type_by_its_hash(name: str) -> None:
    share = Path(get_package_share_directory("flexsim_msgs"))
    description = json.loads((share / "msg" / f"{name}.json").read_text())
    hashes = {entry["type_name"]: entry["hash_string"] for entry in description["type_hashes"]}
    assert hashes[f"flexsim_msgs/msg/{name}"].startswith("RIHS01_")
    assert (share / "msg" / f"{name}.msg").read_text() == (SCHEMA / f"{name}.msg").read_text()


@pytest.mark.parametrize(
    "environment",
    [{}, {"_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1"}],
    ids=["bare", "started by the Python of another venv"],
)
def test_the_venv_needs_no_set_up_file_sourced(environment: dict[str, str]) -> None:
    program = (
        "from flexsim_msgs.msg import ElasticState\n"
        "from rclpy.serialization import serialize_message\n"
        "from ament_index_python.packages import get_package_share_directory\n"
        "serialize_message(ElasticState())\n"
        "print(get_package_share_directory('flexsim_msgs'))\n"
    )
    python = Path(sys.prefix) / "bin" / "python"
    result = subprocess.run(
        [python, "-c", program],
        env={"PATH": os.defpath, **environment},
        cwd="/",
        capture_output=True,
        text=True,
        check=False,
    )
    assert result.stdout.strip() == f"{sys.prefix}/share/flexsim_msgs", result.stderr
