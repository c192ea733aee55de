"""Whose diagnostics these are."""

from __future__ import annotations

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node


def named(message: DiagnosticArray, node: Node) -> DiagnosticArray:
    """Put the node's name, and its namespace where it has one, before what each status is about."""
    for status in message.status:
        status.name = f"{node.get_fully_qualified_name().lstrip('/')}: {status.name}"
    return message
