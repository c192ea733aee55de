"""Publishes a bag's messages as they were recorded: the same bytes, with the same timing."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..bag import Bag, BagError, Topic
from ..bag.cdr import Decoder
from ..bag.definitions import definition, type_hash
from ..bag.qos import Qos
from ..bag.schema import DTYPES, Types, types_of
from .offered import ALL_COUNT, is_latched, profile_of
from .raw_topic import load

if TYPE_CHECKING:
    from rclpy.node import Node

SECOND = 1_000_000_000
# The longest sleep: keys and Ctrl-C are heard within it.
NAP = 0.02
# At the end of a wait: sleeping takes some tens of microseconds longer than it says.
WATCH = 100_000
# s that a subscriber has, at the end, to take what is left.
ACKNOWLEDGED = 2.0
# s that other nodes have to be seen before something is published beside them.
LOOKED_ROUND = 0.5
# Where nothing was recorded for so long, s, that is said; for longer than the second, it is left out.
SILENCE, MOST_SILENCE = 10.0, 600.0
CLOCK = "/clock"
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
    remap : dict of str to str
        Under which other names.
    overrides : dict of topic to profile
        What is offered instead of what was recorded, by the bag's names.
    clock : float, Hz
        How often the recorded time is published on /clock; 0: never.
    tell : callable
        Called with what the user should know, as it happens.

    Attributes
    ----------
    counts : messages published, by topic
    skipped : why a topic is not played
    late : s, by how much the latest message came too late
    played : channels that are played, by topic
    """

    def __init__(
        self,
        node: Node,
        bag: Bag,
        topics: list[str],
        remap: Mapping[str, str] | None = None,
        overrides: Mapping[str, Qos] | None = None,
        clock: float = 0.0,
        tell: Callable[[str], None] = lambda _: None,
    ) -> None:
        from rclpy.exceptions import InvalidTopicNameException, NameValidationException

        self.node = node
        self.tell = tell
        self.played: dict[str, set[int]] = {}
        self._left_out = 0  # ns of silence that were
        self.bag = bag
        self.counts: dict[str, int] = {}
        self.skipped: dict[str, str] = {}
        self.late = 0.0
        self.paused = False
        self.position = 0  # ns, log time
        self._step = False
        self._origin = self._begun = 0
        self._next_tick = 0
        self._publishers: dict[str, Any] = {}
        for name in topics:
            topic = bag.topic(name)
            if clock and (remap or {}).get(name, name) == CLOCK:
                self.skipped[name] = "--clock publishes the time instead"
                continue
            try:
                kind = load(topic.type)
                self.played[name] = playable(bag, topic)
                offer = profile_of(topic, (overrides or {}).get(name))
                self._publishers[name] = node.create_publisher(kind, (remap or {}).get(name, name), offer)
            except (LookupError, BagError) as problem:
                self.skipped[name] = str(problem)
                continue
            except (InvalidTopicNameException, NameValidationException, ValueError, RuntimeError, TypeError):
                self.skipped[name] = "ROS takes no such name for a topic; --remap gives it another"
                continue
            self.counts[name] = 0
            others = [t for t in topic.types if t != topic.type]
            if others:
                self.skipped[f"{name}, {', '.join(others)}"] = (
                    f"a topic has one type, and {topic.type} came first"
                )
        self._clock = self._clock_of(node, clock)
        self._clock_period = round(SECOND / clock) if clock else 0
        self._next_clock = 0

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
        for name, publisher in self._publishers.items():
            own = self.node.get_name()
            where = publisher.topic_name
            who = {full_name(p) for p in self.node.get_publishers_info_by_topic(where) if p.node_name != own}
            if is_command(self.bag.topic(name)):
                heard = self.node.get_subscriptions_info_by_topic(where)
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
        self._begun = start
        self._origin = time.monotonic_ns()  # when `start` was, or would have been, published
        count = 0
        self._left_out = 0
        before = start
        for log_time, name, data in self.ordered(start):
            self._jump(log_time - before)
            before = log_time
            self._wait(log_time - start - self._left_out, timing, stopped, tick)
            if stopped.asked:
                break
            self.position = log_time
            self._publishers[name].publish(data)
            self.counts[name] += 1
            count += 1
        return count

    def _jump(self, silence: int) -> None:
        """Say where nothing was recorded for long, and don't wait where it would be minutes."""
        if abs(silence) < SILENCE * SECOND:
            return
        if 0 < silence <= MOST_SILENCE * SECOND:
            self.tell(f"nothing was recorded for {silence / SECOND:.0f} s")
            return
        way = "ahead" if silence > 0 else "back"
        self.tell(f"the recorded time jumps {way} by {abs(silence) / SECOND:.0f} s, which is not waited for")
        self._left_out += silence

    def _clock_of(self, node: Node, rate: float) -> Any:
        """Return what publishes the recorded time, or None."""
        if not rate:
            return None
        from rosgraph_msgs.msg import Clock

        return node.create_publisher(Clock, CLOCK, 10)

    def _tell_time(self, now: int, start: int, rate: float) -> None:
        """Publish the recorded time where it is due."""
        if self._clock is None or now < self._next_clock:
            return
        from builtin_interfaces.msg import Time
        from rosgraph_msgs.msg import Clock

        at = start + self._left_out + round((now - self._origin) * rate)
        self._clock.publish(Clock(clock=Time(sec=min(at // SECOND, 2**31 - 1), nanosec=at % SECOND)))
        self._next_clock = now + self._clock_period

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
            self._tell_time(now, self._begun, timing.rate)
            left = self._origin + round(after / timing.rate) - now
            if left <= 0:
                self.late = max(self.late, -left / SECOND)
                return
            if left > WATCH:
                nap = min(NAP, (left - WATCH) / SECOND)
                if self._clock is not None:
                    nap = min(nap, max(self._next_clock - now, WATCH) / SECOND)
                time.sleep(nap)

    def ordered(self, start: int) -> Iterator[tuple[int, str, bytes]]:
        """Give the bag's messages from a time on, in the order of their log times.

        What was latched before `start` comes first, as a late subscriber would have got it.
        """
        if start > self.bag.start:
            yield from self._latched(start)
        numbers = {name: self.played[name] for name in self._publishers}
        for log_time, name, channel, data in self.bag.by_time([*self._publishers]):
            if log_time >= start and channel in numbers[name]:
                yield log_time, name, data

    def _latched(self, start: int) -> Iterator[tuple[int, str, bytes]]:
        for name in self._publishers:
            topic = self.bag.topic(name)
            if is_latched(topic):
                before = [data for log_time, data in self.bag.messages(name) if log_time < start]
                for data in before if name.endswith(ALL_COUNT) else before[-1:]:
                    yield start, name, data


def playable(bag: Bag, topic: Topic) -> set[int]:
    """Return the channels of a topic that can be published as its type.

    Raises
    ------
    BagError
        None can: what was recorded is not CDR, or not what the installed type is.
    """
    installed = types_of(topic.type, "ros2msg", definition(topic.type))
    found: set[int] = set()
    why = ""
    for number in topic.numbers:
        kind = bag.kinds[number]
        if kind.type != topic.type:
            continue
        if kind.encoding != "cdr":
            why = f"its messages are {kind.encoding or 'of an unknown encoding'}, not CDR"
            continue
        described = bag.decoder_of(number)
        said = dict(kind.metadata).get("topic_type_hash", "")
        if isinstance(described, Decoder):
            differs = not alike(described.types, installed, topic.type)
        else:
            differs = bool(said) and said != type_hash(topic.type)
        if differs:
            why = f"{topic.type} is defined otherwise in the bag than it is installed here"
            continue
        found.add(number)
    if not found:
        raise BagError(why or "nothing describes its messages")
    return found


def alike(first: Types, second: Types, kind: str) -> bool:
    """Say whether two definitions of a type lay out its messages alike."""
    one, other = first.get(kind), second.get(kind)
    if one is None or other is None or len(one) != len(other):
        return False
    return all(
        (a.name, a.size) == (b.name, b.size)
        and (
            DTYPES.get(a.type, a.type) == DTYPES.get(b.type, b.type)
            if a.type not in first
            else a.type == b.type and alike(first, second, a.type)
        )
        for a, b in zip(one, other, strict=True)
    )


def full_name(endpoint: Any) -> str:
    """Return the full name of the node that an endpoint belongs to."""
    return f"{endpoint.node_namespace.rstrip('/')}/{endpoint.node_name}"


def is_command(topic: Topic) -> bool:
    """Say whether a topic moves a simulator that listens to it."""
    return topic.name.rpartition("/")[2] in COMMANDS
