"""Finds topics as they appear and moves their messages into a bag."""

from __future__ import annotations

import json
import sys
import time
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

from flexsim_ros.published_scene import TOPIC, TYPE, PublishedScene, SceneSpoilt, read_published_scene

from ..bag.cdr import Decoder
from ..bag.definitions import definition
from ..bag.scenes import attached
from .raw_topic import RawTopic, Received
from .simulator import SimulatorWatch

if TYPE_CHECKING:
    from rclpy.node import Node

    from ..bag import BagWriter

POLL_PERIOD = 0.01
DISCOVERY_PERIOD = 0.1
# Who publishes these is a simulator, whose scene belongs into the bag.
SIMULATED = {"flexsim_msgs/msg/ElasticLayout", "flexsim_msgs/msg/LeafMesh"}
# What the middleware calls a node of which it knows a publisher, but not yet the name.
NAMELESS = "_NODE_NAME_UNKNOWN_"


class Recorder:
    """Records the topics that match patterns; the one who has it calls `step` again and again.

    Parameters
    ----------
    node : rclpy.node.Node
    bag : BagWriter
    patterns : list of str
    """

    def __init__(self, node: Node, bag: BagWriter, patterns: list[str]) -> None:
        self.node = node
        self.bag = bag
        self.patterns = patterns
        self.topics: dict[str, RawTopic] = {}
        self.skipped: dict[str, str] = {}
        self._numbers: dict[str, int] = {}
        self._held: list[Received] = []
        self._next_discovery = 0.0
        # Of whom a scene is expected, who has told it, their topics; topics of nameless publishers.
        self._simulators: set[str] = set()
        self._told: set[str] = set()
        self._scenes: set[str] = set()
        self._nameless: set[str] = set()
        self._watches: dict[str, SimulatorWatch] = {}
        self._gone: set[str] = set()
        self._texts = Decoder(TYPE, definition(TYPE))

    def step(self) -> None:
        """Look for topics if it is time, and write what came in; raises OSError where that fails."""
        now = time.monotonic()
        if now >= self._next_discovery:
            self.discover()
            self._next_discovery = now + DISCOVERY_PERIOD
        self.drain()
        self.bag.flush_if_due()

    def discover(self) -> None:
        """Subscribe to what is new, and follow publishers whose offers changed."""
        own = self.node.get_name()
        there = dict(self.node.get_topic_names_and_types())
        scenes: set[str] = set()
        for name, types in there.items():
            if name in self.skipped or not (self.wanted(name) or name in self._scenes):
                continue
            publishers = [p for p in self.node.get_publishers_info_by_topic(name) if p.node_name != own]
            if name in self.topics:
                self.topics[name].follow(publishers)
            elif len(types) > 1:
                self.skip(name, f"published with several types: {', '.join(types)}")
            elif publishers:
                self.open(name, types[0], publishers)
            nodes = {f"{p.node_namespace.rstrip('/')}/{p.node_name}" for p in publishers}
            # What a simulator publishes means nothing without its scene, which is recorded with any of it.
            scenes |= {f"{node}/{TOPIC}" for node in nodes if there.get(f"{node}/{TOPIC}") == [TYPE]}
            if SIMULATED.intersection(types):
                self.meet(name, nodes)
        if scenes - self._scenes:
            self._scenes |= scenes
            self._next_discovery = 0.0
        for name, watch in self._watches.items():
            if (gone := watch.look()) and name not in self._gone:
                self._gone.add(name)
                print(f"- {gone}", file=sys.stderr, flush=True)

    def wanted(self, name: str) -> bool:
        """Say whether a topic is to be recorded; hidden topics only when named whole."""
        if "/_" in name and name not in self.patterns:
            return False
        return any(fnmatchcase(name, pattern) for pattern in self.patterns)

    def open(self, name: str, type_name: str, publishers: list[Any]) -> None:
        """Subscribe to a topic and open its channel."""
        try:
            definition(type_name)
            topic = RawTopic(self.node, name, type_name, publishers)
        except (LookupError, ValueError) as error:
            self.skip(name, str(error))
            return
        self._numbers[name] = self.bag.add_topic(name, type_name, topic.offers)
        self.topics[name] = topic
        print(f"+ {name} ({type_name})", file=sys.stderr, flush=True)

    def meet(self, topic: str, simulators: set[str]) -> None:
        """Expect the scenes of those who publish a topic, each once its name is known."""
        named = {who for who in simulators if not who.endswith(NAMELESS)}
        for who in named - self._watches.keys():
            self._watches[who] = SimulatorWatch(self.node, who)
        self._simulators |= named
        if named == simulators:
            self._nameless.discard(topic)
        else:
            self._nameless.add(topic)

    def keep_scene(self, topic: str, data: bytes) -> None:
        """Attach a scene that was published to each file of the bag, so that any of them explains itself."""
        who = topic.removesuffix(f"/{TOPIC}")
        text = str(self._texts.columns([data], ["data"])["data"][0])
        try:
            told = read_published_scene(text)
        except SceneSpoilt as problem:
            print(f"- the scene of {who} {problem}", file=sys.stderr, flush=True)
            return
        if told is None:
            return
        self.bag.note(who, {key: json.dumps(value) for key, value in parameters(told).items()})
        self.bag.attach(attached(who), "application/json", text.encode())
        self._told.add(who)
        print(f"+ scene of {who}: {told.name}", file=sys.stderr, flush=True)

    @property
    def met(self) -> set[str]:
        """The simulators that are recorded, as far as their names are known."""
        return set(self._simulators)

    @property
    def without_scene(self) -> list[str]:
        """Those of them that have not published their scenes."""
        return sorted(self._simulators - self._told)

    @property
    def expecting(self) -> bool:
        """Whether a simulator has yet to publish its scene."""
        return bool(self._nameless or self.without_scene)

    def skip(self, name: str, why: str) -> None:
        """Leave a topic out, and say so once."""
        self.skipped[name] = why
        print(f"- {name} is not recorded: {why}", file=sys.stderr, flush=True)

    def drain(self, *, everything: bool = False) -> None:
        """Write what came in, in the order it came in over all topics."""
        # What arrives while the queues are read waits for the next round: an earlier message
        # of another topic may still be in its queue.
        horizon = time.time_ns()
        waiting = self._held
        for topic in self.topics.values():
            waiting.extend(topic.take())
        waiting.sort(key=lambda message: message.log_time)
        self._held = []
        for message in waiting:
            if message.log_time > horizon and not everything:
                self._held.append(message)
                continue
            self.bag.write(
                self._numbers[message.topic.name],
                message.data,
                message.log_time,
                message.publish_time,
                message.sequence,
            )
            if message.topic.type == TYPE and message.topic.name.endswith(f"/{TOPIC}"):
                self.keep_scene(message.topic.name, message.data)

    @property
    def stopped(self) -> dict[str, str]:
        """Why simulators whose runs were recorded stood still at the end, or were gone, by name."""
        said = {name: watch.trouble or watch.gone for name, watch in self._watches.items()}
        return {name: why for name, why in said.items() if why}

    def close(self) -> None:
        """Say what is missing."""
        for who in self.without_scene:
            print(f"- no scene of {who}: it published none", file=sys.stderr, flush=True)

    def line(self, elapsed: float) -> str:
        """Return the line that shows how it goes."""
        drops = sum(t.drops or 0 for t in self.topics.values())
        rate = self.bag.size / elapsed if elapsed else 0.0
        return (
            f"{elapsed:6.0f} s  {len(self.topics)} topics  {self.bag.count} messages  "
            f"{self.bag.size / 1e6:.1f} MB, {rate / 1e6:.2f} MB/s  {drops} dropped"
        )

    def summary(self, elapsed: float, error: str) -> dict[str, Any]:
        """Return what was recorded, for the table and for --json."""
        return {
            "bag": str(self.bag.path),
            "duration": round(elapsed, 3),
            "messages": self.bag.count,
            "bytes": sum(f.stat().st_size for f in self.bag.path.iterdir()),
            "files": len(self.bag.parts),
            "topics": {
                t.name: {
                    "type": t.type,
                    "messages": t.count,
                    "bytes": t.bytes,
                    "rate": round(t.rate, 3),
                    "dropped": t.drops,
                }
                for t in sorted(self.topics.values(), key=lambda t: t.name)
            },
            "skipped": self.skipped,
            "stopped": self.stopped,
            "without_scene": self.without_scene,
            "lost": self.bag.lost,
            "error": error,
        }


def parameters(told: PublishedScene) -> dict[str, Any]:
    """Return a node's parameters by name, as ROS has them."""
    overrides = {f"override.{key}": value for key, value in told.overrides.items()}
    return {**told.parameters, **overrides}
