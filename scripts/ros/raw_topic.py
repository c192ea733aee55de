"""A topic received as bytes, with the quality of service that its publishers offer.

The queue is emptied by polling, not by an executor: taking twenty waiting messages at once
costs a twentieth of the wake-ups, and the middleware has noted when each one came in.
"""

from __future__ import annotations

import importlib
import re
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

from ..bag import qos
from ..bag.definitions import message_file

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.topic_endpoint_info import TopicEndpointInfo

# Two seconds of a 1 kHz topic, should the disk stall.
DEPTH = 2000
TYPE_NAME = re.compile(r"[a-z][a-z0-9_]*/msg/[A-Z][A-Za-z0-9]*\Z")
NO_SEQUENCE = 2**64 - 1


@dataclass(slots=True)
class Received:
    """One message as it came in; times in ns since the epoch."""

    topic: RawTopic
    data: bytes
    log_time: int
    publish_time: int
    sequence: int


class RawTopic:
    """One subscription.

    Parameters
    ----------
    node : rclpy.node.Node
    name, type_name : str
        The topic and its `pkg/msg/Type`.
    publishers : list of TopicEndpointInfo
        Whose offers the subscription adapts to.

    Raises
    ------
    LookupError
        The type's Python package is not installed.
    """

    def __init__(self, node: Node, name: str, type_name: str, publishers: list[TopicEndpointInfo]) -> None:
        self.node = node
        self.name = name
        self.type = type_name
        self.offers = [qos.from_profile(p.qos_profile) for p in publishers]
        self.count = 0
        self.bytes = 0
        self.publishers = len(publishers)
        self.first, self.last = 0, 0
        self._type = load(type_name)
        self._profile = adapted(publishers)
        self._first_sequence = NO_SEQUENCE
        self._last_sequence = NO_SEQUENCE
        self._subscribe()

    @property
    def rate(self) -> float:
        """Messages a second from the first to the last, Hz; 0 for fewer than two."""
        span = self.last - self.first
        return (self.count - 1) * 1e9 / span if span > 0 else 0.0

    @property
    def drops(self) -> int | None:
        """Messages that were sent and never came; None where that cannot be known.

        The middleware numbers messages for each publisher, so one publisher can be told only.
        """
        if self.publishers > 1 or self._first_sequence == NO_SEQUENCE:
            return None
        return max(0, self._last_sequence - self._first_sequence + 1 - self.count)

    def follow(self, publishers: list[TopicEndpointInfo]) -> None:
        """Subscribe anew where a publisher came that the subscription does not suit."""
        self.publishers = max(self.publishers, len(publishers))
        profile = adapted(publishers)
        weaker = (profile.reliability, profile.durability) != (
            self._profile.reliability,
            self._profile.durability,
        )
        if publishers and weaker and self._profile.reliability != ReliabilityPolicy.BEST_EFFORT:
            self.close()
            self._profile = profile
            self._subscribe()

    def take(self) -> list[Received]:
        """Return all waiting messages."""
        taken = []
        handle = self._subscription.handle
        with handle:
            while (message := handle.take_message(self._type, True)) is not None:
                data, info = message
                # Not every middleware notes the time of arrival.
                log_time = info["received_timestamp"] or time.time_ns()
                sequence = info.get("publication_sequence_number") or NO_SEQUENCE
                if sequence != NO_SEQUENCE:
                    if self._first_sequence == NO_SEQUENCE:
                        self._first_sequence = sequence
                    self._last_sequence = sequence
                self.first, self.last = self.first or log_time, log_time
                self.count += 1
                self.bytes += len(data)
                taken.append(
                    Received(
                        self,
                        data,
                        log_time,
                        info["source_timestamp"] or log_time,
                        sequence & 0xFFFFFFFF if sequence != NO_SEQUENCE else 0,
                    )
                )
        return taken

    def close(self) -> None:
        """End the subscription."""
        self.node.destroy_subscription(self._subscription)

    def _subscribe(self) -> None:
        self._subscription = self.node.create_subscription(
            self._type, self.name, lambda _: None, self._profile, raw=True
        )


def adapted(publishers: list[TopicEndpointInfo]) -> QoSProfile:
    """Return the strongest profile that every publisher can serve."""
    reliable = all(p.qos_profile.reliability == ReliabilityPolicy.RELIABLE for p in publishers)
    latched = all(p.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for p in publishers)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=DEPTH,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def load(type_name: str) -> Any:
    """Return the Python class of `pkg/msg/Type`; raises LookupError where no ROS package has that type.

    The name may come from a file, so only what an installed ROS package says of itself is imported.
    """
    try:
        if not TYPE_NAME.match(type_name):
            raise ValueError
        message_file(type_name, ".msg")
        package, folder, name = type_name.split("/")
        return getattr(importlib.import_module(f"{package}.{folder}"), name)
    except (ImportError, AttributeError, ValueError):
        raise LookupError(f"no message type {type_name or 'without a name'} is installed") from None
