"""A listener in another node, and a bag of another tool: what tests of `play` share."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import QoSProfile
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

SECOND = 10**9


@contextmanager
def listener(environment: dict[str, str], topics: dict[str, tuple[Any, QoSProfile]]) -> Iterator[Any]:
    """Listen in another node; gives what was heard, by topic, and a function that listens on."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=int(environment["ROS_DOMAIN_ID"]))
    node = rclpy.create_node("listener", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    heard: dict[str, list[tuple[float, Any]]] = {name: [] for name in topics}
    for name, (kind, profile) in topics.items():
        node.create_subscription(
            kind, name, lambda m, n=name: heard[n].append((time.monotonic(), m)), profile
        )

    def listen(until: Any, timeout: float = 40.0) -> None:
        end = time.monotonic() + timeout
        while not until() and time.monotonic() < end:
            executor.spin_once(timeout_sec=0.01)

    try:
        yield heard, listen, node
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.shutdown(context=context)


def other_bag(folder: Path) -> Path:
    """A bag of another tool: two topics, one of them latched, 100 Hz for half a second."""
    store = get_typestore(Stores.ROS2_JAZZY)
    from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

    forever = QosTime(9223372036, 854775807)

    def profile(durability: QosDurability) -> Qos:
        return Qos(QosHistory.KEEP_LAST, 10, QosReliability.RELIABLE, durability, forever, forever,
                   QosLiveliness.AUTOMATIC, forever, False)  # fmt: skip

    path = folder / "other"
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        names = writer.add_connection(
            "/description", "std_msgs/msg/String", typestore=store,
            offered_qos_profiles=[profile(QosDurability.TRANSIENT_LOCAL)],
        )  # fmt: skip
        numbers = writer.add_connection(
            "/numbers", "std_msgs/msg/Float64MultiArray", typestore=store,
            offered_qos_profiles=[profile(QosDurability.VOLATILE)],
        )  # fmt: skip
        text = store.types["std_msgs/msg/String"]("an arm")
        writer.write(names, SECOND, store.serialize_cdr(text, "std_msgs/msg/String"))
        layout = store.types["std_msgs/msg/MultiArrayLayout"]([], 0)
        for k in range(50):
            message = store.types["std_msgs/msg/Float64MultiArray"](layout, np.array([float(k)]))
            data = store.serialize_cdr(message, "std_msgs/msg/Float64MultiArray")
            writer.write(numbers, SECOND + k * SECOND // 100, data)
    return path
