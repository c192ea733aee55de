"""Quality of service as rosbag2 writes it: a list of plain mappings, one a publisher."""

from __future__ import annotations

from io import StringIO
from typing import TYPE_CHECKING, Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

if TYPE_CHECKING:
    from rclpy.qos import QoSProfile

NANOSECONDS = 1_000_000_000
INFINITE = {"sec": 9223372036, "nsec": 854775807}

Qos = dict[str, Any]


def offered(*, reliability: str = "reliable", durability: str = "volatile", depth: int = 10) -> Qos:
    """Return the mapping of a publisher that keeps its last `depth` messages."""
    return {
        "history": "keep_last",
        "depth": depth,
        "reliability": reliability,
        "durability": durability,
        "deadline": dict(INFINITE),
        "lifespan": dict(INFINITE),
        "liveliness": "automatic",
        "liveliness_lease_duration": dict(INFINITE),
        "avoid_ros_namespace_conventions": False,
    }


def from_profile(profile: QoSProfile) -> Qos:
    """Return the mapping of an rclpy profile."""

    def duration(value: Any) -> dict[str, int]:
        sec, nsec = divmod(value.nanoseconds, NANOSECONDS)
        return {"sec": sec, "nsec": nsec}

    return {
        "history": profile.history.name.lower(),
        "depth": profile.depth,
        "reliability": profile.reliability.name.lower(),
        "durability": profile.durability.name.lower(),
        "deadline": duration(profile.deadline),
        "lifespan": duration(profile.lifespan),
        "liveliness": profile.liveliness.name.lower(),
        "liveliness_lease_duration": duration(profile.liveliness_lease_duration),
        "avoid_ros_namespace_conventions": profile.avoid_ros_namespace_conventions,
    }


def to_yaml(profiles: list[Qos]) -> str:
    """Return the text of a channel's `offered_qos_profiles`."""
    stream = StringIO()
    YAML(typ="safe", pure=True).dump(profiles, stream)
    return stream.getvalue()


def from_yaml(text: str) -> list[Qos]:
    """Read a channel's `offered_qos_profiles`; an unreadable text counts as no profile."""
    try:
        profiles = YAML(typ="safe", pure=True).load(text)
    except YAMLError:
        return []
    return [dict(p) for p in profiles] if isinstance(profiles, list) else []
