"""A simulator in a process of its own, and a node beside it that listens to all it says."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, ClassVar, TypeVar

import pytest
import rclpy
from processes import Background, ros_environment
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile

# The kernels may have to be compiled first.
PATIENCE = 600.0


def node_words(module: str, scene: Path | str | None, **parameters: object) -> list[str]:
    """Return the command line of a node; a parameter's dots are written as __."""
    given = {} if scene is None else {"scene": scene}
    given |= {name.replace("__", "."): value for name, value in parameters.items()}
    pairs = [f"{name}:={str(value).lower() if isinstance(value, bool) else value}"
             for name, value in given.items()]  # fmt: skip
    options = [word for pair in pairs for word in ("-p", pair)]
    return [sys.executable, "-m", module, *(["--ros-args", *options] if options else [])]


class Listener:
    """A running node, and a node beside it that listens to all it says.

    Attributes
    ----------
    heard : topic to the messages that came in, in order
    """

    topics: ClassVar[dict[str, Any]]
    latched: ClassVar[tuple[str, ...]]

    def __init__(self, process: Background, domain: int) -> None:
        self.process = process
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node("listener", context=self.context)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        # What it says is taken from the queues, which costs a tenth of an executor's callbacks: on a busy
        # machine who is told of a thousand states a second hears of the past.
        self.ears = rclpy.create_node("ears", context=self.context)
        self.subscriptions: dict[str, Any] = {}
        self.heard: dict[str, list[Any]] = {}
        self.listen()

    def listen(self) -> None:
        """Subscribe anew to everything, as one who comes late."""
        for topic, kind in self.topics.items():
            self.heard[topic] = []
            profile = QoSProfile(depth=1000)
            if topic in self.latched:
                profile.durability = DurabilityPolicy.TRANSIENT_LOCAL
            if topic in self.subscriptions:
                self.ears.destroy_subscription(self.subscriptions[topic])
            self.subscriptions[topic] = self.ears.create_subscription(kind, topic, lambda _: None, profile)

    def hear(self, timeout: float = 0.0) -> None:
        """Take all that has come; let the executor wait so long for other work, s, and do it."""
        self.executor.spin_once(timeout_sec=timeout)
        for topic, subscription in self.subscriptions.items():
            with subscription.handle:
                while taken := subscription.handle.take_message(self.topics[topic], False):
                    self.heard[topic].append(taken[0])

    def until(self, condition: Callable[[], Any], timeout: float = 40.0) -> Any:
        """Listen until something is true, and return it."""
        end = time.monotonic() + timeout
        while not (found := condition()):
            if time.monotonic() > end:
                pytest.fail(f"it did not come: {self.process.errors.read_text()}")
            if self.process.process.poll() is not None:
                pytest.fail(f"the node has ended: {self.process.errors.read_text()}")
            self.hear(0.002)
        return found

    def diagnostics(self) -> dict[str, str]:
        """Return the values of the last diagnostics, by key; empty before the first."""
        last = self.heard["/diagnostics"][-1:]
        return {pair.key: pair.value for m in last for status in m.status for pair in status.values}

    def close(self) -> None:
        """End listening."""
        self.executor.shutdown()
        self.node.destroy_node()
        self.ears.destroy_node()
        rclpy.shutdown(context=self.context)


Kind = TypeVar("Kind", bound=Listener)


@contextmanager
def running(kind: type[Kind], words: list[str], folder: Path) -> Iterator[Kind]:
    """Run a node while a test lasts, and listen; it must end well and without a traceback."""
    environment = ros_environment()
    process = Background(words, environment, folder)
    found = kind(process, int(environment["ROS_DOMAIN_ID"]))
    try:
        yield found
    finally:
        found.close()
        code = process.end()
        errors = process.errors.read_text()
        assert code == 0, errors
        assert "Traceback" not in errors, errors


def seconds(message: Any) -> float:
    """Return a message's time, s."""
    stamp = message.header.stamp
    return stamp.sec + 1e-9 * stamp.nanosec
