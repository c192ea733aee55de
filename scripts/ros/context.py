"""A ROS node for tools: discovery on this host only, signals left to the program."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rclpy.node import Node


@contextmanager
def tool_node(name: str) -> Iterator[Node]:
    """Give a node that publishes nothing of its own beyond what rclpy insists on.

    Parameters
    ----------
    name : str
        Its name gets the process number, so that two tools of a kind can run together.
    """
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    try:
        import rclpy
        from rclpy.signals import SignalHandlerOptions
    except ImportError as error:
        raise RuntimeError(f"this verb needs ROS 2 (rclpy), which does not load: {error}") from None

    context = rclpy.Context()
    rclpy.init(context=context, signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node(
        f"{name}_{os.getpid()}",
        context=context,
        enable_rosout=False,
        start_parameter_services=False,
    )
    try:
        yield node
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)
