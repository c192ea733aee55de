"""Quality of service as rosbag2 writes it: a list of plain mappings, one a publisher."""

from __future__ import annotations

from copy import deepcopy
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from .plain_yaml import dump

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
    return dump(profiles)


def from_yaml(text: str) -> list[Qos]:
    """Read a channel's `offered_qos_profiles`; an unreadable text counts as no profile."""
    return deepcopy(_parsed(text))


@lru_cache(maxsize=256)
def _parsed(text: str) -> list[Qos]:
    # Most topics of a bag offer the same, and YAML is slow to read.
    try:
        profiles = YAML(typ="safe", pure=True).load(text)
    except (YAMLError, ValueError, TypeError, RecursionError):
        return []
    return [dict(p) for p in profiles if isinstance(p, dict)] if isinstance(profiles, list) else []
