"""Bags whose content is known, made without a simulator."""

from __future__ import annotations

import array
from collections.abc import Mapping
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from flexsim.bag import BagWriter, qos
from flexsim_msgs.msg import ElasticLayout, ElasticState
from rclpy.serialization import serialize_message
from sensor_msgs.msg import JointState

SECOND = 10**9
START = 1_700_000_000 * SECOND


def stamp(seconds: float) -> Time:
    """Return a time; zero means "no time" to ROS."""
    nanoseconds = max(1, round(seconds * SECOND))
    return Time(sec=nanoseconds // SECOND, nanosec=nanoseconds % SECOND)


def at(seconds: float) -> int:
    """Return a log time."""
    return START + round(seconds * SECOND)


def joint_state(time: float, names: list[str], position: Any, velocity: Any, effort: Any) -> bytes:
    """Return a joint state."""
    message = JointState(name=names, position=list(position), velocity=list(velocity), effort=list(effort))
    message.header.stamp = stamp(time)
    return serialize_message(message)


def diagnostics(
    time: float,
    statuses: Mapping[str, tuple[int, str, Mapping[str, object]]],
    who: str = "flexsim_node",
    hardware: str = "",
) -> bytes:
    """Return what a simulator says: task to level, message and values."""
    message = DiagnosticArray()
    message.header.stamp = stamp(time)
    message.status = [
        DiagnosticStatus(
            name=f"{who}: {task}",
            level=bytes([level]),
            message=words,
            hardware_id=hardware,
            values=[KeyValue(key=k, value=str(v)) for k, v in values.items()],
        )
        for task, (level, words, values) in statuses.items()
    ]
    return serialize_message(message)


def elastic_state(time: float, displacement: Any, position: Any, rigid: Any) -> bytes:
    """Return an elastic state: (N, 6), (N, 3), (N, 3)."""
    message = ElasticState(status="ok")
    message.header.stamp = stamp(time)
    message.displacement = array.array("d", np.asarray(displacement, dtype=float).tobytes())
    message.position = array.array("d", np.asarray(position, dtype=float).tobytes())
    message.rigid_position = array.array("d", np.asarray(rigid, dtype=float).tobytes())
    return serialize_message(message)


def elastic_layout(nodes_of: Mapping[str, int], width: float, depth: float) -> bytes:
    """Return the layout of links that have so many nodes."""
    message = ElasticLayout(link_names=list(nodes_of))
    first = 0
    for number, (name, count) in enumerate(nodes_of.items()):
        message.node_names += [f"{name}/{i}" for i in range(count)]
        message.node_link.extend([number] * count)
        for i in range(first, first + count - 1):
            message.segments.extend((i, i + 1))
            message.segment_width.append(width)
            message.segment_depth.append(depth)
        first += count
    return serialize_message(message)


LATCHED = [qos.offered(durability="transient_local", depth=1)]
TYPES = {
    "/joint_states": "sensor_msgs/msg/JointState",
    "/flexsim_node/elastic_state": "flexsim_msgs/msg/ElasticState",
    "/flexsim_node/elastic_layout": "flexsim_msgs/msg/ElasticLayout",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/clock": "rosgraph_msgs/msg/Clock",
}


class Topics:
    """The topics of a bag that is written, opened as they are needed."""

    def __init__(self, bag: BagWriter) -> None:
        self.bag = bag
        self._numbers: dict[str, int] = {}

    def write(self, topic: str, data: bytes, time: float, sequence: int = 0, kind: str = "") -> None:
        """Write a message that came at a time, s since the bag's start."""
        if topic not in self._numbers:
            profiles = LATCHED if topic.endswith("layout") else None
            self._numbers[topic] = self.bag.add_topic(topic, kind or TYPES[topic], profiles)
        self.bag.write(self._numbers[topic], data, at(time), at(time), sequence)
