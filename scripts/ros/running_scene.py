"""The scene that a simulator runs, as it publishes it, and how it differs from a scene's file."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexsim_core.scene_files import plain
from flexsim_ros.published_scene import TOPIC, PublishedScene, SceneSpoilt, read_published_scene

from ..terminal.stop import Stop

if TYPE_CHECKING:
    from rclpy.node import Node

MOST_TOLD = 3
OPEN = "auto"


def running_scene(node: Node, name: str, patience: float, stopped: Stop) -> PublishedScene | None:
    """Hear what the simulator `name` runs; None where it does not say so within `patience`, s."""
    from flexsim_ros.status import LATCHED
    from std_msgs.msg import String

    subscription = node.create_subscription(String, f"{name}/{TOPIC}", lambda _: None, LATCHED)
    try:
        end = time.monotonic() + patience
        while time.monotonic() < end and not stopped.asked:
            with subscription.handle:
                taken = subscription.handle.take_message(String, False)
            if taken is not None:
                try:
                    return read_published_scene(taken[0].data)
                except SceneSpoilt:
                    return None
            time.sleep(0.02)
        return None
    finally:
        node.destroy_subscription(subscription)


def not_the_file(told: PublishedScene | None, path: Path, door: bool, what: str) -> str:
    """Say, in a sentence, that what runs is not this file's scene or can't be held against it; else nothing.

    What the file leaves to `auto` is as it says, however it was decided.
    """
    if told is None:
        return f"the running {what} does not publish its scene: whether it is {path} can't be told"
    from flexsim_core.scene_files import SceneError

    try:
        if door:
            from thermal_node.scene.load import load_scene as load_door

            asked = load_door(path).model_dump(exclude={"source"})
        else:
            from flexsim_node.scene.load import load_scene

            asked = load_scene(path).model_dump()
    except (SceneError, OSError, UnicodeDecodeError) as problem:
        return f"the running {what} simulates {told.name}; {path} can't be held against it: {problem}"
    found = list(differences(plain(asked), plain(told.scene)))
    if not found:
        return ""
    more = f" and {len(found) - MOST_TOLD} more" if len(found) > MOST_TOLD else ""
    return (
        f"the running {what} simulates {told.name} of {told.file or 'no file'}, not {path} as it is now:"
        f" {', '.join(found[:MOST_TOLD])}{more}"
    )


def differences(asked: Any, told: Any, key: str = "") -> Iterator[str]:
    """Where two scenes part: dotted keys, with what runs and what was asked for."""
    if asked == OPEN:
        return
    if isinstance(asked, Mapping) and isinstance(told, Mapping):
        for name in sorted(asked.keys() | told.keys()):
            inner = f"{key}.{name}" if key else str(name)
            if name not in asked or name not in told:
                yield f"{inner} is {'missing' if name in asked else 'there'} in what runs"
            else:
                yield from differences(asked[name], told[name], inner)
    elif isinstance(asked, list) and isinstance(told, list) and len(asked) == len(told):
        for n, (a, b) in enumerate(zip(asked, told, strict=True)):
            yield from differences(a, b, f"{key}.{n}")
    elif asked != told:
        yield f"{key} is {short(told)} there, {short(asked)} here"


def short(value: Any) -> str:
    """A value in a sentence."""
    if isinstance(value, list):
        return f"{len(value)} entries"
    return "a group of keys" if isinstance(value, Mapping) else str(value)
