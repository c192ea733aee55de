"""Who looks at a running robot by a scene's file is told where the robot's scene is another."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from flexsim.ros.running_scene import differences
from processes import flexsim, ros_environment
from robot_process import SCENE
from test_waiting import node

pytestmark = pytest.mark.ros


def test_where_two_scenes_part() -> None:
    asked = {"a": 1, "b": "auto", "c": [{"d": 2.0}, {"d": 3.0}], "e": [1, 2], "f": {"g": 1}, "h": 0}
    told = {"a": 1.0, "b": {"x": True}, "c": [{"d": 2.0}, {"d": 4.0}], "e": [1], "f": 1, "i": 0}
    assert list(differences(asked, told)) == [
        "c.1.d is 4.0 there, 3.0 here",
        "e is 1 entries there, 2 entries here",
        "f is 1 there, a group of keys here",
        "h is missing in what runs",
        "i is there in what runs",
    ]


def test_a_file_that_was_changed_since_is_not_what_is_shown(tmp_path: Path) -> None:
    """Same name, same path; the mass of a payload is another.  The same file as it was: nothing is said."""
    environment = ros_environment()
    scene = tmp_path / "arm.yaml"
    shutil.copy(SCENE, scene)
    words = ("view", scene, "--save", tmp_path / "live.rrd", "-d", "0.2")
    with node("flexsim_node", tmp_path, environment, scene=scene):
        done = flexsim(*words, env=environment)
        assert done.returncode == 0, done.stderr
        assert "simulates" not in done.stderr
        text = scene.read_text()
        scene.write_text(text.replace("gravity: [", "gravity: [1.5, 0.0, 0.0]  # [", 1))
        done = flexsim(*words, env=environment)
        assert done.returncode == 0, done.stderr
        assert "gravity.0 is 0.0 there, 1.5 here" in done.stderr
