"""The scene's sensors as messages: every number where its field says, stamps and frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from flexsim_msgs.msg import StrainGauges
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import Imu

from flexsim_node import load_scene, resolve_effects
from flexsim_node.motion.simulation import Simulation
from flexsim_node.service.conversions import effects_status
from flexsim_node.service.robot_description import BASE
from flexsim_node.service.sensor_messages import SensorMessages

pytestmark = pytest.mark.ros
SCENE = Path(__file__).parents[2] / "config" / "planar_double_pendulum.yaml"
SENSORS = [
    {"name": "gauge", "type": "strain_gauge", "link": "link_1", "at": 0.02, "side": "+y"},
    {"name": "tip_imu", "type": "imu"},
    {"name": "tip", "type": "pose"},
    {"name": "load", "type": "section_force", "link": "link_2", "at": 0.0},
    {"name": "other", "type": "strain_gauge", "link": "link_1", "at": 0.02, "side": "-y"},
]


@pytest.fixture(scope="module")
def robot() -> Simulation:
    """A pendulum some steps after it was let go."""
    robot = Simulation(load_scene(SCENE, {"sensors": SENSORS}))
    for _ in range(5):
        robot.step()
    return robot


def test_numbers_lie_in_their_fields(robot: Simulation) -> None:
    messages = SensorMessages(robot)
    assert messages.topics == {
        "strain_gauges": StrainGauges, "tip_imu": Imu, "tip": PoseStamped, "load": WrenchStamped,
    }  # fmt: skip
    sent = messages.serialized(3_000_000_005)
    found = {name: deserialize_message(data, messages.topics[name]) for name, data in sent.items()}
    read = robot.sense()
    for message in found.values():
        assert (message.header.stamp.sec, message.header.stamp.nanosec) == (3, 5)
    gauges = found["strain_gauges"]
    assert list(gauges.name) == ["gauge", "other"]
    assert list(gauges.strain) == [read["gauge"][0], read["other"][0]]
    assert gauges.strain[0] != 0.0
    imu = found["tip_imu"]
    assert imu.header.frame_id == "tip_imu"
    spin, push, turn = imu.angular_velocity, imu.linear_acceleration, imu.orientation
    numbers = [spin.x, spin.y, spin.z, push.x, push.y, push.z, turn.x, turn.y, turn.z, turn.w]
    assert numbers == read["tip_imu"].tolist()
    assert np.all(imu.angular_velocity_covariance == 0.0)
    place, turn = found["tip"].pose.position, found["tip"].pose.orientation
    assert found["tip"].header.frame_id == BASE
    assert [place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w] == read["tip"].tolist()
    force, moment = found["load"].wrench.force, found["load"].wrench.torque
    assert [force.x, force.y, force.z, moment.x, moment.y, moment.z] == read["load"].tolist()


def test_messages_follow_the_robot(robot: Simulation) -> None:
    """The bytes are written anew each time."""
    messages = SensorMessages(robot)
    first = deserialize_message(messages.serialized(10)["tip"], PoseStamped)
    robot.step()
    second = deserialize_message(messages.serialized(20)["tip"], PoseStamped)
    assert second.header.stamp.nanosec == 20
    assert second.pose.position.y < first.pose.position.y  # it falls


def test_a_scene_without_sensors_has_no_topics() -> None:
    assert SensorMessages(Simulation(load_scene(SCENE))).topics == {}


def test_decided_effects_in_diagnostics() -> None:
    """Each open effect with what it changes, and what is left out."""
    keys = {"effects": {"torsion": "auto", "gravity": "auto"}, "tolerance": 1e-4, "duration": 0.05}
    decision = resolve_effects(load_scene(SCENE, keys))
    status = effects_status(decision, "pendulum")
    values = {pair.key: pair.value for pair in status.values}
    assert status.level == DiagnosticStatus.OK
    assert status.name == "effects"
    assert values["torsion"].startswith("off, 0 m")
    assert values["gravity"].startswith("on, ")
    assert "left out: torsion" in status.message


def test_a_decided_formulation_in_diagnostics() -> None:
    """The one taken, and how far the ERLS is from co-moving frames."""
    keys = {"formulation": "auto", "tolerance": 1e-4, "duration": 0.05, "erls.zeroed": "auto",
            "solver.method": "rosenbrock_w"}  # fmt: skip
    decision = resolve_effects(load_scene(SCENE, keys))
    status = effects_status(decision, "pendulum")
    values = {pair.key: pair.value for pair in status.values}
    assert values["formulation"] == decision.scene.formulation
    assert status.message == decision.sentences()[0]
    apart = decision.chosen.apart
    assert values["erls from co_moving, m"] == (
        "not measured" if apart is None else f"{apart.distance:.3g} +- {apart.unsure:.3g}"
    )
