"""`flexsim info`: what is in a bag."""

from __future__ import annotations

from datetime import datetime
from typing import TYPE_CHECKING, Any

import click

from .terminal.report import print_json, print_table

if TYPE_CHECKING:
    from .bag import Bag
    from .bag.qos import Qos


@click.command()
@click.argument("bag", type=click.Path())
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(bag: str, as_json: bool) -> None:
    """Show what is in a bag: topics, types, counts, rates, quality of service.

    BAG is a bag's folder, or one .mcap file.

    \b
    Example:
      flexsim info run
    """
    from .bag import Bag

    found = describe(Bag(bag))
    if as_json:
        print_json(found)
    else:
        print_info(found)


def describe(bag: Bag) -> dict[str, Any]:
    """Return what is in a bag, for the table and for --json."""
    return {
        "bag": str(bag.path),
        "files": [file.name for file in bag.files],
        "bytes": bag.size,
        "start": datetime.fromtimestamp(bag.start * 1e-9).astimezone().isoformat(),
        "duration": round(bag.duration, 6),
        "messages": bag.count,
        "complete": bag.complete,
        "topics": {
            topic.name: {
                "type": topic.type,
                "hash": topic.hash,
                "messages": topic.count,
                "rate": round(topic.count / bag.duration, 3) if bag.duration else None,
                "qos": topic.profiles,
            }
            for topic in sorted(bag.topics.values(), key=lambda t: t.name)
        },
    }


def print_info(found: dict[str, Any]) -> None:
    """Print the table of a bag's topics."""
    title = (
        f"{found['bag']}: {found['messages']} messages, {found['bytes'] / 1e6:.1f} MB, "
        f"{found['duration']:.1f} s from {found['start']}"
    )
    rows = [
        [name, t["type"], t["messages"], "" if t["rate"] is None else f"{t['rate']:.1f}",
         "; ".join(dict.fromkeys(in_words(p) for p in t["qos"]))]
        for name, t in found["topics"].items()
    ]  # fmt: skip
    print_table(title, ["topic", "type", "messages", "rate, Hz", "quality of service"], rows)
    if not found["complete"]:
        click.echo("The end of this bag is missing; what is shown could be read.", err=True)


def in_words(profile: Qos) -> str:
    """Say a profile in the words that matter."""
    depth = f", depth {profile['depth']}" if profile.get("depth") else ""
    return f"{profile.get('reliability')}, {profile.get('durability')}{depth}"
