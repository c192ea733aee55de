"""Finds topics as they appear and moves their messages into a bag."""

from __future__ import annotations

import json
import sys
import time
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

from ..bag.definitions import definition
from .parameters import ParameterQuestion, scene_of
from .raw_topic import RawTopic, Received
from .simulator import SimulatorWatch

if TYPE_CHECKING:
    from rclpy.node import Node

    from ..bag import BagWriter

POLL_PERIOD = 0.01
DISCOVERY_PERIOD = 0.1
# Who publishes these is a simulator, whose scene and parameters belong into the bag.
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
        self._questions: dict[str, ParameterQuestion | None] = {}
        self._nameless: set[str] = set()
        self._watches: dict[str, SimulatorWatch] = {}
        self._gone: set[str] = set()

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
        for name, types in self.node.get_topic_names_and_types():
            if name in self.skipped or not self.wanted(name):
                continue
            publishers = [p for p in self.node.get_publishers_info_by_topic(name) if p.node_name != own]
            if name in self.topics:
                self.topics[name].follow(publishers)
            elif len(types) > 1:
                self.skip(name, f"published with several types: {', '.join(types)}")
            elif publishers:
                self.open(name, types[0], publishers)
            if SIMULATED.intersection(types):
                self.meet(name, {f"{p.node_namespace.rstrip('/')}/{p.node_name}" for p in publishers})
        for name, question in self._questions.items():
            if question is not None:
                self.ask(name, question)
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
        """Ask the simulators that publish a topic for their parameters, each once its name is known."""
        named = {who for who in simulators if not who.endswith(NAMELESS)}
        for who in named - self._questions.keys():
            self._questions[who] = ParameterQuestion(self.node, who)
            self._watches[who] = SimulatorWatch(self.node, who)
        if named == simulators:
            self._nameless.discard(topic)
        else:
            self._nameless.add(topic)

    def ask(self, name: str, question: ParameterQuestion) -> None:
        """Put a simulator's parameters and its scene into the bag as soon as it has told them."""
        parameters = question.step()
        if parameters is None:
            return
        question.close()
        self._questions[name] = None
        self.bag.note(name, {key: json.dumps(value) for key, value in parameters.items()})
        scene = scene_of(parameters)
        if scene is not None:
            self.bag.attach(scene[0], "application/yaml", scene[1])
        kept = "parameters" if scene is None else f"parameters and {scene[0]}"
        print(f"+ {kept} of {name}", file=sys.stderr, flush=True)

    @property
    def asked(self) -> set[str]:
        """The simulators that were asked for their parameters."""
        return set(self._questions)

    @property
    def asking(self) -> bool:
        """Whether a simulator has yet to tell its parameters."""
        return bool(self._nameless) or any(q is not None for q in self._questions.values())

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

    @property
    def stopped(self) -> dict[str, str]:
        """Why simulators whose runs were recorded stood still at the end, or were gone, by name."""
        said = {name: watch.trouble or watch.gone for name, watch in self._watches.items()}
        return {name: why for name, why in said.items() if why}

    def close(self) -> None:
        """End what was asked and not answered."""
        for question in self._questions.values():
            if question is not None:
                question.close()

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
            "lost": self.bag.lost,
            "error": error,
        }
