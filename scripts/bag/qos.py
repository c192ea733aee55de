"""Quality of service as rosbag2 writes it: a list of plain mappings, one a publisher."""

from __future__ import annotations

import json
from copy import deepcopy
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from .yaml_text import dump

if TYPE_CHECKING:
    from rclpy.qos import QoSProfile

NANOSECONDS = 1_000_000_000
INFINITE = {"sec": 9223372036, "nsec": 854775807}

Qos = dict[str, Any]
# What reading YAML that is none may raise.
UNREADABLE = (
    YAMLError, ValueError, TypeError, RecursionError, AttributeError, LookupError, ArithmeticError,
)  # fmt: skip
# Before Jazzy rosbag2 wrote the numbers of rmw's enumerations.
WORDS = {
    "history": ("system_default", "keep_last", "keep_all", "unknown"),
    "reliability": ("system_default", "reliable", "best_effort", "unknown", "best_available"),
    "durability": ("system_default", "transient_local", "volatile", "unknown", "best_available"),
    "liveliness": ("system_default", "automatic", "manual_by_node", "manual_by_topic", "unknown"),
}
LARGEST = 1 << 18  # of a text, as much as a thousand publishers need


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
    return _written(json.dumps(profiles))


@lru_cache(maxsize=256)
def _written(profiles: str) -> str:
    # Most topics offer the same, and YAML is slow to write.
    return dump(json.loads(profiles))


def from_yaml(text: str) -> list[Qos]:
    """Read a channel's `offered_qos_profiles`; an unreadable text counts as no profile."""
    return deepcopy(_parsed(text))


@lru_cache(maxsize=256)
def _parsed(text: str) -> list[Qos]:
    # Most topics of a bag offer the same, and YAML is slow to read.
    try:
        profiles = YAML(typ="safe", pure=True).load(text) if len(text) < LARGEST else None
    except UNREADABLE:
        return []
    if not isinstance(profiles, list):
        return []
    return [{str(k): in_word(str(k), v) for k, v in p.items()} for p in profiles if isinstance(p, dict)]


def in_word(key: str, value: Any) -> Any:
    """Return a policy as a word, whether it was written as one or as its number."""
    words = WORDS.get(key)
    if words is None or isinstance(value, bool):
        return value
    if isinstance(value, int):
        return words[value] if 0 <= value < len(words) else "unknown"
    return str(value).lower()
