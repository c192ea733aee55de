"""The scene that a bag's robot was simulated from: what the recorder put into it, or what is given."""

from __future__ import annotations

import tempfile
from pathlib import Path

from flexsim_node import Scene, load_scene

from ..bag import Bag
from ..bag.robot import robot_in
from ..replay.drive import overrides_of


def scene_of(bag: Bag, given: Path | None) -> tuple[Scene | None, str]:
    """Return the scene, or None and why there is none.

    A scene that is given counts as it is; that of the bag with what its node changed of it.

    Raises
    ------
    SceneError
        The scene that is given is wrong.
    """
    if given is not None:
        return load_scene(given), ""
    robot = robot_in(bag)
    name, text = robot.scene_name, robot.scene
    if text is None:
        return None, "the bag does not hold its scene; name it: --scene SCENE.yaml"
    with tempfile.TemporaryDirectory(prefix="flexsim_") as folder:
        path = Path(folder) / Path(name).name
        path.write_bytes(text)
        try:
            return load_scene(path, overrides=overrides_of(robot.parameters)), ""
        except ValueError as problem:
            reason = str(problem).replace(str(path), name)
            return None, f"the bag's scene can't be read: {reason}; name another: --scene SCENE.yaml"
