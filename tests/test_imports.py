"""Imports are as docs/architecture.md says: rooms one way, no circle, verbs apart, physics without ROS."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import flexsim_node

ROOT = Path(__file__).parents[1]


def test_imports_go_one_way() -> None:
    """The contracts of pyproject.toml hold; what breaks one is told with its chain of imports."""
    linter = Path(sys.executable).parent / "lint-imports"
    done = subprocess.run([linter, "--no-logo"], cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr


LIGHT = """
import sys
from click.testing import CliRunner
from flexsim.cli import flexsim
for words in (["import", "arm.urdf", "-o", "arm.yaml"], ["new", "-o", "first.yaml"], ["schema", "robot"]):
    done = CliRunner().invoke(flexsim, words)
    assert done.exit_code == 0, done.output
heavy = {"numba", "scipy", "llvmlite", "rclpy", "rerun"} & set(sys.modules)
assert not heavy, heavy
"""
PENDULUM = """<robot name="pendulum"><link name="ground"/><link name="bob"><inertial><origin xyz="0 0 1"/>
<mass value="1"/></inertial></link><joint name="pivot" type="continuous"><parent link="ground"/>
<child link="bob"/><axis xyz="0 1 0"/></joint></robot>"""


def test_what_makes_scenes_waits_for_no_compiler(tmp_path: Path) -> None:
    """Importing a robot, a first scene and the schema load nothing that takes a second to load."""
    (tmp_path / "arm.urdf").write_text(PENDULUM)
    done = subprocess.run(
        [sys.executable, "-c", LIGHT], cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr


def test_the_robots_names_are_all_there() -> None:
    """Each public name is found when it is asked for, and none that is not."""
    for name in flexsim_node.__all__:
        assert getattr(flexsim_node, name).__name__ == name
    assert set(flexsim_node.__all__) <= set(dir(flexsim_node))
    with pytest.raises(ImportError, match="simulat"):
        exec("from flexsim_node import simulat")
