"""A thermal_node in a process of its own, and what a user's node hears of it."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar

from diagnostic_msgs.msg import DiagnosticArray
from flexsim_msgs.msg import (
    FireCriteria,
    LeafDeflection,
    LeafMesh,
    Reactions,
    TemperatureField,
    Thermocouples,
)
from listening import PATIENCE, Listener, node_words, running, seconds
from processes import Background
from rclpy.qos import QoSProfile
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image, PointCloud2, Temperature

SCENE = Path(__file__).parents[2] / "config" / "thesis_door.yaml"
# Small enough that a node is up at once: nine bricks each way.
SMALL = {
    "override__mesh__in_plane": [6, 8],
    "override__mesh__layers": [1, 4, 1],
    "override__deformation__in_plane": [6, 8],
}


def words(scene: Path | str | None = SCENE, **parameters: object) -> list[str]:
    """Return the command line of a node; a parameter's dots are written as __."""
    return node_words("thermal_node.node", scene, **parameters)


class Door(Listener):
    """A running thermal_node, and a furnace's thermocouple."""

    topics: ClassVar[dict[str, Any]] = {
        "furnace/temperature": Temperature,
        "door/thermocouples": Thermocouples,
        "door/criteria": FireCriteria,
        "door/reactions": Reactions,
        "door/temperature_field": TemperatureField,
        "door/temperature_points": PointCloud2,
        "door/unexposed/image": Image,
        "door/deflection": LeafDeflection,
        "door/mesh": LeafMesh,
        "/clock": Clock,
        "/diagnostics": DiagnosticArray,
    }
    latched = ("door/mesh",)

    def __init__(self, process: Background, domain: int) -> None:
        super().__init__(process, domain)
        self._furnace = self.node.create_publisher(
            Temperature, "furnace/measured_temperature", QoSProfile(depth=10)
        )

    def until(self, condition: Callable[[], Any], timeout: float = PATIENCE) -> Any:
        """Listen until something is true, and return it; a door computes longer than a robot."""
        return super().until(condition, timeout)

    def at(self, topic: str, time: float) -> Any:
        """Wait for the message of a topic with a stamp, s."""
        return self.until(lambda: next((m for m in self.heard[topic] if abs(seconds(m) - time) < 1e-6), None))

    def measure(self, temperature: float) -> None:
        """Send a measured temperature."""
        self._furnace.publish(Temperature(temperature=temperature))

    def measure_on(self, temperature: float) -> None:
        """Send a measured temperature again and again, as thermocouples do, until one drives the door.

        Measurements are taken without acknowledgement: of who has just begun to speak the first are lost.
        """
        sent = time.monotonic() - 1.0

        def driven() -> bool:
            nonlocal sent
            if time.monotonic() > sent + 0.1:
                self.measure(temperature)
                sent = time.monotonic()
            return self.diagnostics().get("source") == "measured"

        self.until(driven)


@contextmanager
def door(folder: Path, **parameters: object) -> Iterator[Door]:
    """Run a node with these parameters while a test lasts."""
    with running(Door, words(**(SMALL | parameters)), folder) as found:
        yield found
