"""A flexsim_node in a process of its own, and what a user's node hears of it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar

from diagnostic_msgs.msg import DiagnosticArray
from flexsim_msgs.msg import ElasticLayout, ElasticState
from listening import PATIENCE, Listener, node_words, running, seconds
from processes import Background
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, PointCloud2
from std_msgs.msg import Float64MultiArray, String

SCENE = Path(__file__).parents[2] / "config" / "anthropomorphic.yaml"


def words(scene: Path | str | None = SCENE, **parameters: object) -> list[str]:
    """Return the command line of a node; a parameter's dots are written as __."""
    return node_words("flexsim_node.node", scene, **parameters)


class Robot(Listener):
    """A running flexsim_node, and who commands it."""

    topics: ClassVar[dict[str, Any]] = {
        "joint_states": JointState,
        "flexsim_node/elastic_state": ElasticState,
        "flexsim_node/deformed_shape": PointCloud2,
        "flexsim_node/elastic_layout": ElasticLayout,
        "robot_description": String,
        "/clock": Clock,
        "/diagnostics": DiagnosticArray,
    }
    latched = ("flexsim_node/elastic_layout", "robot_description")

    def __init__(self, process: Background, domain: int) -> None:
        super().__init__(process, domain)
        self._torques = self.node.create_publisher(
            Float64MultiArray, "flexsim_node/commands", QoSProfile(depth=100)
        )
        self._by_name = self.node.create_publisher(JointState, "robot_joint_commands", QoSProfile(depth=100))

    def connected(self) -> None:
        """Wait until the node hears what is sent."""
        self.until(
            lambda: self._torques.get_subscription_count() and self._by_name.get_subscription_count(),
            PATIENCE,
        )
        self.until(lambda: self.heard["joint_states"], PATIENCE)

    def command(self, torque: Any) -> None:
        """Send torques in joint order."""
        self._torques.publish(Float64MultiArray(data=[float(x) for x in torque]))

    def command_by_name(self, names: list[str], effort: list[float]) -> None:
        """Send torques by joint name."""
        self._by_name.publish(JointState(name=names, effort=effort))

    def states(self) -> list[JointState]:
        """Return the joint states so far."""
        return self.heard["joint_states"]

    def time(self) -> float:
        """Return the simulated time of the last joint state, s."""
        return seconds(self.states()[-1])


@contextmanager
def robot(folder: Path, **parameters: object) -> Iterator[Robot]:
    """Run a node with these parameters while a test lasts."""
    with running(Robot, words(**parameters), folder) as found:
        yield found
