"""Who commands a simulator: more than one is said, since each thinks that it is alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from rclpy.node import Node


def others(node: Node, topics: Sequence[str]) -> list[str]:
    """Names of those who publish on a node's topics, where there are several.

    Two of one name, or one that publishes twice on a topic, are shown as "name (2)".
    """
    if sum(map(node.count_publishers, topics)) < 2:
        return []
    counts: Counter[str] = Counter()
    for topic in topics:  # who uses two of the topics is still one
        found = node.get_publishers_info_by_topic(topic)
        counts |= Counter(f"{p.node_namespace.rstrip('/')}/{p.node_name}" for p in found)
    if counts.total() < 2:
        return []
    return [name if count == 1 else f"{name} ({count})" for name, count in sorted(counts.items())]
