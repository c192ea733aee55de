"""Who commands a simulator: more than one is said, since each thinks that it is alone."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.node import Node


def others(node: Node, topics: Sequence[str]) -> list[str]:
    """Names of those who publish on a node's topics, where there are several, each once.

    One that publishes twice, or bears the name of another, counts twice: "name (2)".
    """
    if sum(map(node.count_publishers, topics)) < 2:
        return []
    found = [
        f"{p.node_namespace.rstrip('/')}/{p.node_name}"
        for topic in topics
        for p in node.get_publishers_info_by_topic(topic)
    ]
    if len(found) < 2:
        return []
    return [
        name if found.count(name) == 1 else f"{name} ({found.count(name)})" for name in sorted(set(found))
    ]
