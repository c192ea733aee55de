"""A thermal_node in a process of its own, and what a user's node hears of it."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from flexsim_msgs.msg import FireCriteria, LeafDeflection, LeafMesh, TemperatureField, Thermocouples
from processes import Background, ros_environment
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image, PointCloud2, Temperature

SCENE = Path(__file__).parents[2] / "config" / "thesis_door.yaml"
# Small enough that a node is up at once: nine bricks each way.
SMALL = {
    "override__mesh__in_plane": [6, 8],
    "override__mesh__layers": [1, 4, 1],
    "override__deformation__in_plane": [6, 8],
}
# The kernels may have to be compiled first.
PATIENCE = 180.0
TOPICS = {
    "furnace/temperature": Temperature,
    "door/thermocouples": Thermocouples,
    "door/criteria": FireCriteria,
    "door/temperature_field": TemperatureField,
    "door/temperature_points": PointCloud2,
    "door/unexposed/image": Image,
    "door/deflection": LeafDeflection,
    "door/mesh": LeafMesh,
    "/clock": Clock,
    "/diagnostics": DiagnosticArray,
}
LATCHED = ("door/mesh",)


def words(scene: Path | str | None = SCENE, **parameters: object) -> list[str]:
    """Return the command line of a node; a parameter's dots are written as __."""
    given = {} if scene is None else {"scene": scene}
    given |= {name.replace("__", "."): value for name, value in parameters.items()}
    pairs = [f"{name}:={str(value).lower() if isinstance(value, bool) else value}"
             for name, value in given.items()]  # fmt: skip
    options = [word for pair in pairs for word in ("-p", pair)]
    return [sys.executable, "-m", "thermal_node.node", *(["--ros-args", *options] if options else [])]


class Door:
    """A running node, and a node beside it that listens to all it says.

    Attributes
    ----------
    heard : topic to the messages that came in, in order
    """

    def __init__(self, process: Background, domain: int) -> None:
        self.process = process
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node("listener", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.heard: dict[str, list[Any]] = {}
        self.listen()
        self._furnace = self.node.create_publisher(
            Temperature, "furnace/measured_temperature", QoSProfile(depth=10)
        )

    def listen(self) -> None:
        """Subscribe anew to everything, as one who comes late."""
        for topic, kind in TOPICS.items():
            self.heard[topic] = []
            profile = QoSProfile(depth=1000)
            if topic in LATCHED:
                profile.durability = DurabilityPolicy.TRANSIENT_LOCAL
            self.node.create_subscription(kind, topic, self.heard[topic].append, profile)

    def until(self, condition: Callable[[], Any], timeout: float = PATIENCE) -> Any:
        """Spin until something is true, and return it."""
        end = time.monotonic() + timeout
        while not (found := condition()):
            if time.monotonic() > end:
                pytest.fail(f"it did not come: {self.process.errors.read_text()}")
            if self.process.process.poll() is not None:
                pytest.fail(f"the node has ended: {self.process.errors.read_text()}")
            self.executor.spin_once(timeout_sec=0.05)
        return found

    def at(self, topic: str, time: float) -> Any:
        """Wait for the message of a topic with a stamp, s."""
        return self.until(lambda: next((m for m in self.heard[topic] if abs(seconds(m) - time) < 1e-6), None))

    def measure(self, temperature: float) -> None:
        """Send a measured temperature once the node listens."""
        self.until(self._furnace.get_subscription_count)
        self._furnace.publish(Temperature(temperature=temperature))

    def diagnostics(self) -> dict[str, str]:
        """Return the values of the last diagnostics, by key; empty before the first."""
        last = self.heard["/diagnostics"][-1:]
        return {pair.key: pair.value for m in last for status in m.status for pair in status.values}

    def close(self) -> None:
        """End listening."""
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)


def seconds(message: Any) -> float:
    """Return a message's time, s."""
    stamp = message.header.stamp
    return stamp.sec + 1e-9 * stamp.nanosec


@contextmanager
def door(folder: Path, **parameters: object) -> Iterator[Door]:
    """Run a node with these parameters while a test lasts."""
    environment = ros_environment()
    process = Background(words(**(SMALL | parameters)), environment, folder)
    found = Door(process, int(environment["ROS_DOMAIN_ID"]))
    try:
        yield found
    finally:
        found.close()
        code = process.end()
        errors = process.errors.read_text()
        assert code == 0, errors
        assert "Traceback" not in errors, errors
