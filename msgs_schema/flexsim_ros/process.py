"""A node's process: it starts with one clear line if it can't, and ends well when a signal comes."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.signals import SignalHandlerOptions

from .start import attentive


def handle_signals(handler: Callable[[int, Any], Any]) -> None:
    """Give SIGINT and SIGTERM to `handler`."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, handler)


def spin_through(node: Any, executor: Any, period: float) -> str:
    """Let an executor wait for work for `period` s and do it; what went wrong in it, or nothing.

    Bytes that are no message, and a client that is gone before its answer, raise in here; they are the
    sender's fault and no reason for a node to end.
    """
    try:
        executor.spin_once(timeout_sec=period)
    except Exception as problem:
        if not rclpy.ok():
            raise
        sentence = f"{type(problem).__name__}: {' '.join(str(problem).split())[:200]}"
        node.get_logger().warning(f"an input came to nothing: {sentence}", throttle_duration_sec=1.0)
        return sentence
    return ""


def run_node(
    name: str,
    build: Callable[[], Any],
    run: Callable[[Any, list[int]], int],
    failures: dict[type[Exception], int],
) -> int:
    """Build a node and run it until SIGINT or SIGTERM.

    Parameters
    ----------
    build : makes the node; a signal ends the process as long as it does, and what is compiled is said
    run : gets the node and a list, which is not empty from a signal on; returns the exit code
    failures : what `build` may raise, and its exit code; said in one line

    Returns 2 where ROS does not take the command line, or finds no place for its log.
    """
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    asked: list[int] = []
    node = None
    try:
        with attentive(name, 0, asked):
            try:
                rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
            except Exception as problem:
                print(f"{name}: ROS does not start: {' '.join(str(problem).split())}", file=sys.stderr)
                return 2
            node = build()
            handle_signals(lambda number, _: asked.append(number))
        return 0 if asked else run(node, asked)
    except KeyboardInterrupt:
        return 0
    except tuple(failures) as problem:
        print(f"{name}: {problem}", file=sys.stderr)
        return next(code for kind, code in failures.items() if isinstance(problem, kind))
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
