"""The scene that a bag's robot was simulated from: what its node published, or what is given."""

from __future__ import annotations

from pathlib import Path

from flexsim_node import Scene, load_scene, resolve_effects

from ..bag import Bag
from ..bag.robot import robot_in


def scene_of(bag: Bag, given: Path | None) -> tuple[Scene | None, str]:
    """Return the scene, or None and why there is none.

    A scene that is given counts as it is; what it leaves to `auto` is decided as a run would.

    Raises
    ------
    SceneError
        The scene that is given is wrong.
    """
    if given is not None:
        scene = load_scene(given)
        try:
            return (resolve_effects(scene).scene if scene.undecided else scene), ""
        except ArithmeticError as problem:
            return None, f"what {given} leaves to auto can't be decided: {problem}"
    told = robot_in(bag)
    if told.scene is None:
        return None, f"{told.why_not}; name it: --scene SCENE.yaml"
    try:
        return load_scene(told.scene.scene), ""
    except ValueError as problem:
        return None, f"the bag's scene can't be read: {problem}; name another: --scene SCENE.yaml"
