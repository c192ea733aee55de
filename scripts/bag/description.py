"""What a bag's index says, and which scenes ran."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from .opening import described
from .reader import Bag
from .scenes import scenes_in


def describe(bag: Bag) -> dict[str, Any]:
    """Return what the index says, and which scenes ran, for the table and for --json."""
    return {
        "bag": str(bag.path),
        **described(bag.opened),
        "files": [file.name for file in bag.opened.names],
        "bytes": bag.size,
        "start": moment(bag.start) if bag.count else None,
        "duration": round(bag.duration, 6),
        "messages": bag.count,
        "complete": bag.complete,
        "damages": [str(damage) for damage in bag.damages],
        "scenes": {
            node: {
                "name": one.scene.name,
                "hash": one.scene.hash,
                "file": one.scene.file,
                "overrides": dict(one.scene.overrides),
                "versions": dict(one.scene.versions),
            }
            if one.scene
            else {"why_not": one.why_not}
            for node, one in scenes_in(bag).items()
        },
        "topics": {
            topic.name: {
                "type": topic.type,
                "types": topic.types,
                "encoding": topic.encoding,
                "not_decoded": bag.why_not(topic.name),
                "hash": topic.hash,
                "messages": topic.count,
                "rate": round(topic.count / bag.duration, 3) if bag.duration else None,
                "qos": topic.profiles,
            }
            for topic in sorted(bag.topics.values(), key=lambda t: t.name)
        },
    }


def moment(time: int) -> str:
    """Write a log time, ns since the epoch; as seconds where no calendar has it."""
    try:
        return datetime.fromtimestamp(time * 1e-9).astimezone().isoformat()
    except (ValueError, OverflowError, OSError):
        return f"{time * 1e-9:.0f} s"
