"""The scene's sensors as ROS messages: Imu, PoseStamped, WrenchStamped, and all strain gauges in one.

Each message is serialized once; afterwards only its numbers are written into the bytes, as in conversions.py.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

import numpy as np
from flexsim_msgs.msg import StrainGauges
from geometry_msgs.msg import PoseStamped, WrenchStamped
from rclpy.serialization import serialize_message
from sensor_msgs.msg import Imu

from ..motion.simulation import Simulation
from .conversions import STAMP, Template, stamp
from .realtime import SECOND
from .robot_description import BASE

XYZ, XYZW = "xyz", "xyzw"
GAUGES = "strain_gauges"
# message type, and the places of a reading's numbers in it
LAYOUTS: dict[str, tuple[Any, tuple[str, ...]]] = {
    "imu": (Imu, (
        *(f"angular_velocity.{k}" for k in XYZ), *(f"linear_acceleration.{k}" for k in XYZ),
        *(f"orientation.{k}" for k in XYZW),
    )),
    "pose": (PoseStamped, (
        *(f"pose.position.{k}" for k in XYZ), *(f"pose.orientation.{k}" for k in XYZW),
    )),
    "section_force": (WrenchStamped, (
        *(f"wrench.force.{k}" for k in XYZ), *(f"wrench.torque.{k}" for k in XYZ),
    )),
}  # fmt: skip


class Numbers:
    """A serialized message whose time and float64 fields (by dotted path) are written in place."""

    def __init__(self, message: Any, paths: tuple[str, ...]) -> None:
        marks = np.random.default_rng(0).normal(size=len(paths))
        for path, mark in zip(paths, marks, strict=True):
            *above, last = path.split(".")
            part = message
            for name in above:
                part = getattr(part, name)
            setattr(part, last, float(mark))
        self._bytes = bytearray(serialize_message(message))
        self._places = [self._bytes.find(struct.pack("<d", mark)) for mark in marks]

    def write(self, time: int, values: np.ndarray) -> bytes:
        """Return the message with these values, at simulated time `time`, ns."""
        struct.pack_into("<iI", self._bytes, STAMP, *divmod(max(1, time), SECOND))
        for place, value in zip(self._places, values.tolist(), strict=True):
            struct.pack_into("<d", self._bytes, place, value)
        return bytes(self._bytes)


class SensorMessages:
    """The messages of a robot's sensors; used by the stepping thread alone.

    Attributes
    ----------
    topics : name below ~/sensors/ to the message type
    """

    def __init__(self, robot: Simulation) -> None:
        self.robot = robot
        self.topics: dict[str, Any] = {}
        self._writers: dict[str, Callable[[int, dict[str, np.ndarray]], bytes]] = {}
        kinds = robot.sensors.kinds
        gauges = [name for name in robot.sensors.names if kinds[name] == "strain_gauge"]
        if gauges:
            self.topics[GAUGES] = StrainGauges
            self._writers[GAUGES] = gauge_writer(gauges)
        for name in robot.sensors.names:
            if kinds[name] == "strain_gauge":
                continue
            kind, paths = LAYOUTS[kinds[name]]
            message = kind()
            message.header.stamp = stamp(0)
            # a pose is in the base; the others stand in axes of their own
            message.header.frame_id = BASE if kinds[name] == "pose" else name
            self.topics[name] = kind
            self._writers[name] = number_writer(name, Numbers(message, paths))

    def serialized(self, time: int) -> dict[str, bytes]:
        """Read every sensor once; each topic's message."""
        readings = self.robot.sense()
        return {topic: write(time, readings) for topic, write in self._writers.items()}


def gauge_writer(names: list[str]) -> Callable[[int, dict[str, np.ndarray]], bytes]:
    """Return what writes the strains of gauges into their one message."""
    message = StrainGauges(name=names)
    message.header.stamp = stamp(0)
    message.header.frame_id = BASE
    strain = np.zeros(len(names))
    template = Template(message, {"strain": strain})

    def write(time: int, readings: dict[str, np.ndarray]) -> bytes:
        for k, name in enumerate(names):
            strain[k] = readings[name][0]
        return template.write(time, strain=strain)

    return write


def number_writer(name: str, numbers: Numbers) -> Callable[[int, dict[str, np.ndarray]], bytes]:
    """Return what writes one sensor's reading into its message."""
    return lambda time, readings: numbers.write(time, readings[name])
