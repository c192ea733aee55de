"""`flexsim new`: what it writes is a scene, of the robot that the flags say."""

from __future__ import annotations

import pytest
from click.testing import CliRunner
from flexsim.cli import flexsim

from flexsim_node.scene.load import load_scene


def test_first_scene(tmp_path):
    """Joints, lengths, section and payload are those asked for; a scene is not written over."""
    path = tmp_path / "arm.yaml"
    words = ["new", "-o", str(path), "--axes", "zyx", "--lengths", "0.2,0.5,0.4", "--payload", "1.5"]
    words += ["--beam", "tube:0.04x0.003,steel,3"]
    done = CliRunner().invoke(flexsim, words)
    assert done.exit_code == 0, done.output
    scene = load_scene(path)
    assert [link.length for link in scene.links] == pytest.approx([0.2, 0.5, 0.4])
    assert [link.joint.axis for link in scene.links] == [(0, 0, 1), (0, 1, 0), (1, 0, 0)]
    assert all(link.beam.elements == 3 and link.beam.density == 7850.0 for link in scene.links)
    assert scene.links[-1].payload.mass == 1.5 and scene.name == "arm"
    assert CliRunner().invoke(flexsim, words).exit_code == 1


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--axes", "zw"], 2, "give letters from x, y and z"),
        (["--axes", ""], 2, "give letters from x, y and z"),
        (["--lengths", "1,2"], 2, "give 1 or 3"),
        (["--lengths", "long"], 2, "is no list of numbers"),
        (["--lengths", "0"], 1, "has a beam but no length"),
        (["--lengths", "nan"], 1, "give a finite number"),
        (["--lengths", "500"], 1, "metres, not millimetres"),
        (["--payload", "-1"], 1, "payload.mass"),
        (["--beam", "wood"], 2, "is no beam"),
    ],
)
def test_wrong_words(tmp_path, words, code, said):
    """What can't be is refused with the reason, and nothing is written."""
    path = tmp_path / "arm.yaml"
    done = CliRunner().invoke(flexsim, ["new", "-o", str(path), *words])
    assert done.exit_code == code and said in done.output + done.stderr
    assert not path.exists()
