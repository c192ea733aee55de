"""The scenes that a bag's simulators ran, as they published them; nothing else counts as one."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from weakref import WeakKeyDictionary

from flexsim_ros.published_scene import TOPIC, TYPE, PublishedScene, SceneSpoilt, read_published_scene

from .reader import Bag, BagError

_read: WeakKeyDictionary[Bag, dict[str, Found]] = WeakKeyDictionary()


@dataclass(frozen=True)
class Found:
    """What a bag holds of one simulator's scene.

    Attributes
    ----------
    scene : the one that ran, or None
    why_not : why there is none; "" where there is one
    """

    scene: PublishedScene | None
    why_not: str = ""


def attached(node: str) -> str:
    """Return the name under which the recorder attaches a simulator's scene to each file of a bag."""
    return f"{node.strip('/')}/{TOPIC}.json"


def scenes_in(bag: Bag) -> dict[str, Found]:
    """Return the scenes of a bag by the full name of their simulator."""
    if bag not in _read:
        topic, file = f"/{TOPIC}", f"/{TOPIC}.json"
        strings = [name for name, t in bag.topics.items() if t.type == TYPE and t.count]
        nodes = {name.removesuffix(topic) for name in strings if name.endswith(topic)}
        nodes |= {f"/{name.removesuffix(file)}" for name in bag.attachments() if name.endswith(file)}
        found = {node: scene_of_node(bag, node) for node in sorted(nodes)}
        _read[bag] = {node: one for node, one in found.items() if one is not None}
    return _read[bag]


def found_scene(bag: Bag, node: str) -> Found:
    """Return the scene of one simulator, or why the bag has none."""
    found = scenes_in(bag).get(node)
    if found is not None:
        return found
    of = f" of {node}" if node else ""
    old = [name for name in bag.attachments() if name.endswith((".yaml", ".yml"))]
    if old:
        return Found(
            None,
            f"the bag holds no scene that its simulator{of} published. {', '.join(old)} in it is what an"
            " earlier version's recorder found on its own disk, which may be another",
        )
    return Found(None, f"the bag does not hold its scene{f': none that {node} published' if node else ''}")


def scene_of_node(bag: Bag, node: str) -> Found | None:
    """Read what a simulator published; None where its topic bears something else."""
    try:
        told = [scene for scene in map(read_published_scene, texts(bag, node)) if scene is not None]
    except SceneSpoilt as problem:
        return Found(None, f"the scene that {node} published {problem}")
    if not told:
        return None
    # What was replaced before a tick was taken never ran.
    ran = [a for a, b in pairwise(told) if a.ticks != b.ticks] + told[-1:]
    changes = [f"{what(a, b)} at {b.since:g} s" for a, b in pairwise(ran) if a.hash != b.hash]
    if changes:
        return Found(None, f"the scene of {node} is not one throughout: {'; '.join(changes)}")
    return Found(ran[-1])


def texts(bag: Bag, node: str) -> list[str]:
    """Return what a simulator's topic bore, in order; of a file of a split bag what the recorder attached."""
    topic = f"{node}/{TOPIC}"
    if topic in bag.topics and bag.topics[topic].type == TYPE:
        read = [data for _, data in bag.messages(topic)]
        if read:
            try:
                return [str(text) for text in bag.decoder(topic).columns(read, ["data"])["data"]]
            except BagError:  # cut off
                pass
    data = bag.attachment(attached(node))
    return [] if data is None else [data.decode("utf-8", "replace")]


def what(first: PublishedScene, second: PublishedScene) -> str:
    """Return the keys in which two scenes differ, a few of them."""
    keys = differing(first.scene, second.scene)
    return ", ".join(keys[:3]) + (" and more" if len(keys) > 3 else "")


def differing(first: object, second: object, above: str = "") -> list[str]:
    """Return the keys whose values differ between two scenes, `links.1.beam.elements`."""
    if isinstance(first, dict) and isinstance(second, dict):
        parts = [(str(k), first.get(k), second.get(k)) for k in dict.fromkeys([*first, *second])]
    elif isinstance(first, list) and isinstance(second, list) and len(first) == len(second):
        parts = [(str(k), a, b) for k, (a, b) in enumerate(zip(first, second, strict=True))]
    else:
        return [] if first == second else [above or "the scene"]
    return [key for k, a, b in parts for key in differing(a, b, f"{above}.{k}" if above else k)]
