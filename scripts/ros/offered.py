"""What a player offers on a topic: as much as any of the recorded publishers, or what is asked for."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ruamel.yaml import YAML

from ..bag import BagError, Topic
from ..bag.qos import UNREADABLE, Qos, in_word

if TYPE_CHECKING:
    from rclpy.qos import QoSProfile

POLICIES = {
    "history": ("keep_last", "keep_all", "system_default"),
    "reliability": ("reliable", "best_effort", "system_default"),
    "durability": ("volatile", "transient_local", "system_default"),
}
# Whose messages all count for a late subscriber, though each publisher latches one.
ALL_COUNT = "tf_static"
LEAST, MOST = 10, 10_000


def read_overrides(path: Path) -> dict[str, Qos]:
    """Read a file of profiles by topic, as rosbag2 has it; raises BagError with what is wrong."""
    try:
        told = YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8"))
    except OSError as problem:
        raise BagError(f"{path} can't be read: {problem.strerror}") from None
    except UNREADABLE as problem:
        raise BagError(f"{path} is not YAML: {str(problem).splitlines()[0]}") from None
    if not isinstance(told, dict) or not all(isinstance(p, dict) for p in told.values()):
        raise BagError(f"{path} does not list profiles by topic: give /topic: {{reliability: best_effort}}")
    return {str(topic): checked(profile, f"{path}, {topic}") for topic, profile in told.items()}


def override(words: str) -> tuple[str, Qos]:
    """Read TOPIC=POLICY:VALUE,...; raises BagError."""
    topic, equals, rest = words.partition("=")
    pairs = [pair.partition(":") for pair in rest.split(",")]
    if not (topic.startswith("/") and equals and all(colon and value for _, colon, value in pairs)):
        raise BagError(f"'{words}': give /topic=reliability:best_effort,depth:5")
    return topic, checked({key.strip(): value.strip() for key, _, value in pairs}, f"'{words}'")


def checked(profile: Qos, where: str) -> Qos:
    """Return a profile's policies as words and numbers; raises BagError for one that is none."""
    found: Qos = {}
    for key, value in profile.items():
        if key == "depth":
            try:
                found[key] = int(value)
            except (TypeError, ValueError):
                raise BagError(f"{where}: depth is a number, not '{value}'") from None
            if not 0 < found[key] <= MOST:
                raise BagError(f"{where}: depth is from 1 to {MOST}, not {value}")
        elif key in POLICIES:
            found[key] = in_word(key, value)
            if found[key] not in POLICIES[key]:
                raise BagError(f"{where}: {key} is {', '.join(POLICIES[key])}, not '{value}'")
        elif key not in ("deadline", "lifespan", "liveliness", "liveliness_lease_duration",
                         "avoid_ros_namespace_conventions"):  # fmt: skip
            raise BagError(f"{where}: there is no policy '{key}'; there are depth, {', '.join(POLICIES)}")
    return found


def is_latched(topic: Topic) -> bool:
    """Say whether a late subscriber got messages of before."""
    return any(p.get("durability") == "transient_local" for p in topic.profiles)


def profile_of(topic: Topic, asked: Qos | None = None) -> QoSProfile:
    """Return what to offer: as strong as any of the recorded publishers, so that all can listen.

    A policy that is not known, or left to the system, counts as reliable, which is what ROS makes of it.
    """
    from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

    asked = asked or {}
    said = topic.profiles
    weak = bool(said) and all(p.get("reliability") == "best_effort" for p in said)
    latched = is_latched(topic)
    depths = [depth_of(p) for p in said]
    if latched:
        # Of several publishers each latched its own.
        depth = topic.count if topic.name.endswith(ALL_COUNT) else sum(depths)
        depth = min(max(1, depth), MOST)
    else:
        depth = min(max([LEAST, *depths]), MOST)
    reliability = asked.get("reliability", "best_effort" if weak else "reliable")
    durability = asked.get("durability", "transient_local" if latched else "volatile")
    keep_all = asked.get("history") == "keep_all"
    return QoSProfile(
        history=HistoryPolicy.KEEP_ALL if keep_all else HistoryPolicy.KEEP_LAST,
        depth=int(asked.get("depth", depth)),
        reliability=ReliabilityPolicy.BEST_EFFORT
        if reliability == "best_effort"
        else ReliabilityPolicy.RELIABLE,
        durability=(
            DurabilityPolicy.TRANSIENT_LOCAL if durability == "transient_local" else DurabilityPolicy.VOLATILE
        ),
    )


def depth_of(profile: Qos) -> int:
    """Return how many messages a publisher kept."""
    value: Any = profile.get("depth")
    return min(max(value, 0), MOST) if isinstance(value, int) else 0
