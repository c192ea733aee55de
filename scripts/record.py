"""`flexsim record`: writes topics to a bag as they are published."""

from __future__ import annotations

import sys
import time
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .terminal.report import print_json, print_table
from .terminal.stop import Stop, stopped_by_signals

if TYPE_CHECKING:
    from rclpy.node import Node

    from .bag import BagWriter
    from .ros.raw_topic import RawTopic, Received

POLL_PERIOD = 0.01
DISCOVERY_PERIOD = 0.1


@click.command()
@click.argument("topics", nargs=-1, metavar="[TOPIC]...")
@click.option("-o", "--output", type=click.Path(), metavar="BAG",
              help="The bag's folder; if not given, named by the time.")  # fmt: skip
@click.option("--all", "everything", is_flag=True, help="All topics: also what no TOPIC means.")
@click.option("-d", "--duration", type=click.FloatRange(0.0, min_open=True), metavar="SECONDS",
              help="Stop after this time; else Ctrl-C or SIGTERM stops.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object at the end.")
def command(
    topics: tuple[str, ...],
    output: str | None,
    everything: bool,
    duration: float | None,
    as_json: bool,
) -> None:
    """Record ROS topics to a bag (MCAP in rosbag2's layout).

    TOPIC is a topic's name, or a pattern such as '/door/*'; without one, all are recorded.

    \b
    Example:
      flexsim record -o run /joint_states '/flexsim_node/*'
    """
    if everything and topics:
        raise click.UsageError("Give either --all or TOPICs, not both.")
    patterns = [t if t.startswith(("/", "*")) else f"/{t}" for t in topics] or ["*"]
    path = Path(output or time.strftime("flexsim_%Y-%m-%d_%H-%M-%S"))
    if path.exists():
        raise click.ClickException(f"{path} exists already; name another bag or remove it")
    with stopped_by_signals() as stopped:
        recorded = record(path, patterns, duration, stopped, live=not as_json)
    if as_json:
        print_json(recorded)
    else:
        print_summary(recorded)
    if recorded["error"]:
        raise click.ClickException(recorded["error"])


def record(
    path: Path, patterns: list[str], duration: float | None, stopped: Stop, *, live: bool
) -> dict[str, Any]:
    """Record until asked to stop; returns what was recorded."""
    from .bag import BagWriter
    from .ros.context import tool_node

    with tool_node("flexsim_record") as node:
        bag = BagWriter(path)
        recorder = Recorder(node, bag, patterns)
        error = ""
        print(f"recording to {path}", file=sys.stderr, flush=True)
        begun = time.monotonic()
        shown = begun
        try:
            try:
                while not stopped.asked:
                    now = time.monotonic()
                    if duration is not None and now - begun >= duration:
                        break
                    recorder.step()
                    if live and sys.stderr.isatty() and now - shown >= 1.0:
                        print(f"\r\x1b[K{recorder.line(now - begun)}", end="", file=sys.stderr)
                        shown = now
                    time.sleep(POLL_PERIOD)
                recorder.drain(everything=True)
            finally:
                bag.close()
        except OSError as failure:
            error = f"writing {path} failed: {failure.strerror or failure}"
        if live and sys.stderr.isatty():
            print("\r\x1b[K", end="", file=sys.stderr)
        return recorder.summary(time.monotonic() - begun, error)


class Recorder:
    """Finds topics as they appear and moves their messages into the bag."""

    def __init__(self, node: Node, bag: BagWriter, patterns: list[str]) -> None:
        self.node = node
        self.bag = bag
        self.patterns = patterns
        self.topics: dict[str, RawTopic] = {}
        self.channels: dict[str, int] = {}
        self.skipped: dict[str, str] = {}
        self._held: list[Received] = []
        self._next_discovery = 0.0

    def step(self) -> None:
        """Look for topics if it is time, and write what came in."""
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
            publishers = [
                p for p in self.node.get_publishers_info_by_topic(name) if p.node_name != own
            ]
            if name in self.topics:
                self.topics[name].follow(publishers)
            elif len(types) > 1:
                self.skip(name, f"published with several types: {', '.join(types)}")
            elif publishers:
                self.open(name, types[0], publishers)

    def wanted(self, name: str) -> bool:
        """Say whether a topic is to be recorded; hidden topics only when named whole."""
        if "/_" in name and name not in self.patterns:
            return False
        return any(fnmatchcase(name, pattern) for pattern in self.patterns)

    def open(self, name: str, type_name: str, publishers: list[Any]) -> None:
        """Subscribe to a topic and open its channel."""
        from .bag.definitions import definition
        from .ros.raw_topic import RawTopic

        try:
            definition(type_name)
            topic = RawTopic(self.node, name, type_name, publishers)
        except (LookupError, ValueError) as error:
            self.skip(name, str(error))
            return
        self.channels[name] = self.bag.add_topic(name, type_name, topic.offers)
        self.topics[name] = topic
        print(f"+ {name} ({type_name})", file=sys.stderr, flush=True)

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
                self.channels[message.topic.name],
                message.data,
                message.log_time,
                message.publish_time,
                message.sequence,
            )

    def line(self, elapsed: float) -> str:
        """Return the line that shows how it goes."""
        drops = sum(t.drops or 0 for t in self.topics.values())
        return (
            f"{elapsed:6.0f} s  {len(self.topics)} topics  {self.bag.count} messages  "
            f"{self.bag.size / 1e6:.1f} MB  {drops} dropped"
        )

    def summary(self, elapsed: float, error: str) -> dict[str, Any]:
        """Return what was recorded, for the table and for --json."""
        return {
            "bag": str(self.bag.path),
            "duration": round(elapsed, 3),
            "messages": self.bag.count,
            "bytes": sum(f.stat().st_size for f in self.bag.path.iterdir()),
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
            "error": error,
        }


def print_summary(recorded: dict[str, Any]) -> None:
    """Print the table of what was recorded."""
    size = recorded["bytes"] / 1e6
    title = (
        f"{recorded['bag']}: {recorded['messages']} messages, {size:.1f} MB, "
        f"{recorded['duration']:.1f} s"
    )
    rows = [
        [name, t["type"], t["messages"], f"{t['rate']:.1f}",
         "unknown" if t["dropped"] is None else t["dropped"]]
        for name, t in recorded["topics"].items()
    ]  # fmt: skip
    print_table(title, ["topic", "type", "messages", "rate, Hz", "dropped"], rows)
