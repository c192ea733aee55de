"""`flexsim record`: writes topics to a bag as they are published."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import click

from ..terminal.report import print_json, print_table
from ..terminal.stop import Stop, stopped_by_signals

MEGABYTE = 1_000_000


@click.command()
@click.argument("topics", nargs=-1, metavar="[TOPIC]...")
@click.option("-o", "--output", type=click.Path(), metavar="BAG",
              help="The bag's folder; if not given, named by the time.")  # fmt: skip
@click.option("--all", "everything", is_flag=True, help="All topics: also what no TOPIC means.")
@click.option("-d", "--duration", type=click.FloatRange(0.0, min_open=True), metavar="SECONDS",
              help="Stop after this time; else Ctrl-C or SIGTERM stops.")  # fmt: skip
@click.option("--max-size", type=click.FloatRange(1.0), metavar="MB",
              help="Begin a new file of the bag before one grows beyond this.")  # fmt: skip
@click.option("--max-duration", type=click.FloatRange(1.0), metavar="SECONDS",
              help="Begin a new file of the bag when one is as long as this.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object at the end.")
def command(
    topics: tuple[str, ...],
    output: str | None,
    everything: bool,
    duration: float | None,
    max_size: float | None,
    max_duration: float | None,
    as_json: bool,
) -> None:
    """Record ROS topics to a bag (MCAP in rosbag2's layout).

    TOPIC is a topic's name, or a pattern such as '/door/*'; without one, all are recorded.

    \b
    Example:
      flexsim record -o run /joint_states '/flexsim_node/*'
      flexsim record -o run --max-size 500
    """
    if everything and topics:
        raise click.UsageError("Give either --all or TOPICs, not both.")
    patterns = [t if t.startswith(("/", "*")) else f"/{t}" for t in topics] or ["*"]
    path = Path(output or time.strftime("flexsim_%Y-%m-%d_%H-%M-%S"))
    if path.exists():
        raise click.ClickException(f"{path} exists already; name another bag or remove it")
    with stopped_by_signals() as stopped:
        recorded = record(
            path,
            patterns,
            duration,
            stopped,
            live=not as_json,
            max_size=round((max_size or 0.0) * MEGABYTE),
            max_duration=max_duration or 0.0,
        )
    if as_json:
        print_json(recorded)
    else:
        print_summary(recorded)
    if recorded["error"]:
        raise click.ClickException(recorded["error"])


def record(
    path: Path,
    patterns: list[str],
    duration: float | None,
    stopped: Stop,
    *,
    live: bool,
    max_size: int = 0,
    max_duration: float = 0.0,
) -> dict[str, Any]:
    """Record until asked to stop; returns what was recorded."""
    from ..bag import BagWriter
    from ..ros.context import tool_node
    from ..ros.recorder import POLL_PERIOD, Recorder

    with tool_node("flexsim_record") as node:
        try:
            bag = BagWriter(path, max_size=max_size, max_duration=max_duration)
        except OSError as failure:
            raise click.ClickException(f"can't write {path}: {failure.strerror or failure}") from None
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
                recorder.close()
                bag.close()
        except OSError as failure:
            error = f"writing {path} failed: {failure.strerror or failure}"
        if live and sys.stderr.isatty():
            print("\r\x1b[K", end="", file=sys.stderr)
        return recorder.summary(time.monotonic() - begun, error)


def print_summary(recorded: dict[str, Any]) -> None:
    """Print the table of what was recorded."""
    size = recorded["bytes"] / 1e6
    title = f"{recorded['bag']}: {recorded['messages']} messages, {size:.1f} MB, {recorded['duration']:.1f} s"
    rows = [
        [name, t["type"], t["messages"], f"{t['rate']:.1f}",
         "unknown" if t["dropped"] is None else t["dropped"]]
        for name, t in recorded["topics"].items()
    ]  # fmt: skip
    print_table(title, ["topic", "type", "messages", "rate, Hz", "dropped"], rows)
