"""Publishes a bag's messages as they were recorded: the same bytes, with the same timing."""

from __future__ import annotations

import heapq
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..bag import Bag, Topic
from ..bag.qos import Qos
from .raw_topic import load

if TYPE_CHECKING:
    from rclpy.node import Node
    from rclpy.qos import QoSProfile

SECOND = 1_000_000_000
# The longest sleep: keys and Ctrl-C are heard within it.
NAP = 0.02
# At the end of a wait: sleeping takes some tens of microseconds longer than it says.
WATCH = 100_000
# s that a subscriber has, at the end, to take what is left.
ACKNOWLEDGED = 2.0
# s that other nodes have to be seen before something is published beside them.
LOOKED_ROUND = 0.5
# Who hears commands and obeys none: recorders, ours and ROS 2's, and views.
LISTENERS = ("flexsim_record_", "flexsim_view_", "rosbag2_", "_")
# Topics that move a simulator.
COMMANDS = ("commands", "robot_joint_commands", "wrench", "measured_temperature")


@dataclass
class Timing:
    """How a bag is played.

    Attributes
    ----------
    rate : recorded seconds a second
    offset : s from the bag's beginning, where to begin
    loop : whether to begin again at the end
    """

    rate: float = 1.0
    offset: float = 0.0
    loop: bool = False


class Player:
    """Plays a bag.

    Parameters
    ----------
    node : rclpy.node.Node
    bag : Bag
    topics : list of str
        Those to play.

    Attributes
    ----------
    counts : messages published, by topic
    skipped : why a topic is not played
    late : s, by how much the latest message came too late
    """

    def __init__(self, node: Node, bag: Bag, topics: list[str]) -> None:
        self.node = node
        self.bag = bag
        self.counts: dict[str, int] = {}
        self.skipped: dict[str, str] = {}
        self.late = 0.0
        self.paused = False
        self.position = 0  # ns, log time
        self._step = False
        self._origin = 0
        self._next_tick = 0
        self._publishers: dict[str, Any] = {}
        for name in topics:
            topic = bag.topic(name)
            try:
                kind = load(topic.type)
            except (LookupError, ValueError) as problem:
                self.skipped[name] = str(problem)
                continue
            self._publishers[name] = node.create_publisher(kind, name, profile_of(topic))
            self.counts[name] = 0

    def wait_for_listeners(self, names: list[str], timeout: float, stopped: Any) -> bool:
        """Wait until each of these topics has a subscriber; says whether they have."""
        end = time.monotonic() + timeout
        while any(self._publishers[n].get_subscription_count() == 0 for n in names):
            if stopped.asked or time.monotonic() > end:
                return False
            time.sleep(0.01)
        return True

    def beside(self, timeout: float = LOOKED_ROUND) -> dict[str, list[str]]:
        """Look round for a while: who else publishes on the topics, and whom commands would move."""
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            time.sleep(NAP)
        found: dict[str, list[str]] = {}
        for name in self._publishers:
            own = self.node.get_name()
            who = {full_name(p) for p in self.node.get_publishers_info_by_topic(name) if p.node_name != own}
            if is_command(self.bag.topic(name)):
                heard = self.node.get_subscriptions_info_by_topic(name)
                who |= {
                    full_name(s)
                    for s in heard
                    if s.node_name != own and not s.node_name.startswith(LISTENERS)
                }
            if who:
                found[name] = sorted(who)
        return found

    def play(self, timing: Timing, stopped: Any, tick: Any) -> None:
        """Publish until the bag is over or the program is asked to end.

        `tick` is called some fifty times a second; it may set `paused` and call `step_once`.
        """
        while not stopped.asked:
            published = self._once(timing, stopped, tick)
            if not timing.loop or not published:
                return

    def step_once(self) -> None:
        """Publish one message more, while paused."""
        self._step = True

    def set_rate(self, timing: Timing, rate: float) -> None:
        """Go on faster or slower from where we are."""
        now = time.monotonic_ns()
        self._origin = now - round((now - self._origin) * timing.rate / rate)
        timing.rate = rate

    def finish(self) -> None:
        """Wait a moment until all is received."""
        from rclpy.duration import Duration

        for publisher in self._publishers.values():
            publisher.wait_for_all_acked(Duration(seconds=ACKNOWLEDGED))

    def _once(self, timing: Timing, stopped: Any, tick: Any) -> int:
        start = self.bag.start + round(timing.offset * SECOND)
        self._origin = time.monotonic_ns()  # when `start` was, or would have been, published
        count = 0
        for log_time, name, data in self.ordered(start):
            self._wait(log_time - start, timing, stopped, tick)
            if stopped.asked:
                break
            self.position = log_time
            self._publishers[name].publish(data)
            self.counts[name] += 1
            count += 1
        return count

    def _wait(self, after: int, timing: Timing, stopped: Any, tick: Any) -> None:
        """Wait until so many recorded ns have gone by; pauses do not count."""
        while not stopped.asked:
            now = time.monotonic_ns()
            if now >= self._next_tick:
                tick()
                now = time.monotonic_ns()
                self._next_tick = now + round(NAP * SECOND)
                if self.paused:
                    while self.paused and not self._step and not stopped.asked:
                        time.sleep(NAP)
                        tick()
                    self._origin += time.monotonic_ns() - now
                    if self._step:
                        # This message is due now, and the next one is asked for again.
                        self._step = False
                        self._next_tick = 0
                        self._origin = time.monotonic_ns() - round(after / timing.rate)
                        return
                    continue
            left = self._origin + round(after / timing.rate) - now
            if left <= 0:
                self.late = max(self.late, -left / SECOND)
                return
            if left > WATCH:
                time.sleep(min(NAP, (left - WATCH) / SECOND))

    def ordered(self, start: int) -> Iterator[tuple[int, str, bytes]]:
        """Give the bag's messages from a time on, in the order in which they came in.

        What was latched before `start` comes first, as a late subscriber would have got it.
        """
        if start > self.bag.start:
            yield from self._latched(start)
        # Some tools write chunks whose times overlap, so the latest are held back.
        held: list[tuple[int, int, str, bytes]] = []
        number = 0
        for chunk in self.bag.read([*self._publishers]):
            last = max(int(some.log_time[-1]) for some in chunk.values())
            for name, some in chunk.items():
                some = some[some.log_time >= start]
                for log_time, data in zip(some.log_time.tolist(), some.data(), strict=True):
                    heapq.heappush(held, (log_time, number, name, data))
                    number += 1
            while held and held[0][0] < last:
                log_time, _, name, data = heapq.heappop(held)
                yield log_time, name, data
        while held:
            log_time, _, name, data = heapq.heappop(held)
            yield log_time, name, data

    def _latched(self, start: int) -> Iterator[tuple[int, str, bytes]]:
        for name in self._publishers:
            if is_latched(self.bag.topic(name)):
                before = [data for log_time, data in self.bag.messages(name) if log_time < start]
                if before:
                    yield start, name, before[-1]


def full_name(endpoint: Any) -> str:
    """Return the full name of the node that an endpoint belongs to."""
    return f"{endpoint.node_namespace.rstrip('/')}/{endpoint.node_name}"


def is_command(topic: Topic) -> bool:
    """Say whether a topic moves a simulator that listens to it."""
    return topic.name.rpartition("/")[2] in COMMANDS


def is_latched(topic: Topic) -> bool:
    """Say whether a late subscriber got the last message too."""
    return bool(topic.profiles) and all(latched(p) for p in topic.profiles)


def latched(profile: Qos) -> bool:
    """Say whether a profile keeps messages for late subscribers; rosbag2 before Jazzy wrote numbers."""
    return profile.get("durability") in ("transient_local", 1)


def profile_of(topic: Topic) -> QoSProfile:
    """Return what to offer: as strong as any of the recorded publishers, so that all can listen."""
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

    said = topic.profiles
    reliable = not said or any(p.get("reliability") in ("reliable", 1) for p in said)
    depth = max([int(p.get("depth") or 0) for p in said] or [0])
    return QoSProfile(
        depth=int(np.clip(depth, 10, 10_000)) if not is_latched(topic) else max(1, depth),
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=(DurabilityPolicy.TRANSIENT_LOCAL if is_latched(topic) else DurabilityPolicy.VOLATILE),
    )
