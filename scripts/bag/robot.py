"""Which topics, scene and parameters of a bag belong to the same robot, where it holds several simulators."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from typing import Any

from flexsim_ros.published_scene import PublishedScene

from .reader import Bag, BagError
from .scenes import found_scene, scenes_in

STATE = "flexsim_msgs/msg/ElasticState"
LAYOUT = "flexsim_msgs/msg/ElasticLayout"
JOINTS = "sensor_msgs/msg/JointState"
ROBOT = "flexsim_node"


@dataclass(frozen=True)
class Robot:
    """A robot of a bag.

    Attributes
    ----------
    node : its simulator's full name; "" where it is not known
    joints, state, layout : its topics of joint states, elastic states and their layout, or None
    parameters : of its simulator
    scene : what it simulated, as it published it; None where the bag lacks it
    why_not : why there is no scene, in a sentence
    others : simulators of further robots that the bag holds
    """

    node: str
    joints: str | None
    state: str | None
    layout: str | None
    parameters: dict[str, Any] = field(default_factory=dict)
    scene: PublishedScene | None = None
    why_not: str = ""
    others: tuple[str, ...] = ()

    @property
    def model(self) -> str:
        """The scene's own name; "" where it is not known."""
        return "" if self.scene is None else self.scene.name


def robot_in(bag: Bag) -> Robot:
    """Return a bag's robot: of several the one that is meant, else the first with most kinds of states.

    Raises
    ------
    BagError
        The bag holds no robot of that name.
    """
    notes = {node: told for node, told in bag.notes().items() if "scene" in told}
    scenes = scenes_in(bag)
    noted = {node for node, told in notes.items() if "elastic_rate" in told}
    ran = {node for node, one in scenes.items() if one.scene is None or one.scene.simulator == ROBOT}
    nodes = [*(noted | (ran - notes.keys()))]
    nodes = nodes or [name.rpartition("/")[0] for name in names(bag, STATE)] or [""]
    found = [of_node(bag, node) for node in sorted(nodes)]
    meant = [r for r in found if r.node == f"/{bag.robot.strip('/')}"] if bag.robot else found
    if not meant:
        held = ", ".join(r.node for r in found if r.node) or "none whose name is known"
        raise BagError(f"{bag.path} holds no robot {bag.robot}; it holds {held}")
    chosen = max(meant, key=lambda r: (r.state is not None) + (r.joints is not None))
    of_scene = found_scene(bag, chosen.node)
    if of_scene.scene is not None:
        parameters = dict(of_scene.scene.parameters)
    else:
        told = notes.get(chosen.node, {})
        parameters = {name: value for name in told if (value := parameter(told, name)) is not None}
    theirs = {topic for r in found if r is not chosen for topic in (r.joints, r.state, r.layout)}

    def left(topics: list[str]) -> str | None:
        """Return the first topic that is not another robot's."""
        return next((topic for topic in topics if topic not in theirs), None)

    return Robot(
        chosen.node,
        chosen.joints or left(joint_topics(bag)),
        chosen.state or left(names(bag, STATE)),
        chosen.layout or left(names(bag, LAYOUT)),
        parameters,
        of_scene.scene,
        of_scene.why_not,
        tuple(r.node for r in found if r is not chosen),
    )


def parameter(pairs: dict[str, str], name: str) -> Any:
    """Return a parameter that a recorder noted; None where it is not there, or is not what it writes."""
    try:
        return json.loads(pairs.get(name, "null"))
    except (ValueError, RecursionError):
        return None


def of_node(bag: Bag, node: str) -> Robot:
    """Return the topics that a simulator of this name publishes, as far as the bag has them."""
    own = f"{node.rpartition('/')[0]}/joint_states"
    state, layout = (
        next((name for name in names(bag, kind) if name.startswith(node + "/")), None)
        for kind in (STATE, LAYOUT)
    )
    return Robot(node, own if own in names(bag, JOINTS) else None, state, layout)


def names(bag: Bag, kind: str) -> list[str]:
    """Return the topics of a type that hold something."""
    return [t.name for t in bag.topics.values() if t.type == kind and t.count]


def joint_topics(bag: Bag) -> list[str]:
    """Return the topics of joint states, those that are named so first."""
    return sorted(names(bag, JOINTS), key=lambda n: (not n.endswith("joint_states"), len(n), n))
