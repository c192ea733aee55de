"""`flexsim new`: what it writes is a scene, of the robot that the flags say."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner
from flexsim.cli import flexsim

from flexsim_node.scene.load import load_scene
from thermal_node.scene.load import load_scene as load_door


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
        (["--size", "1x2"], 2, "--size is not of a robot"),
        (["door", "--axes", "zy"], 2, "--axes is not of a door"),
        (["door", "--size", "1"], 2, "is no size"),
        (["door", "--size", "0x2"], 1, "leaf.width"),
        (["door", "--size", "1000x2000"], 1, "leaf.height"),
        (["door", "--layers", "steel"], 2, "is no layer"),
        (["door", "--layers", "stone_wol_100:0.05"], 1, "did you mean 'stone_wool_100'"),
        (["door", "--layers", "steel:nan"], 1, "thickness"),
        (["door", "--minutes", "0"], 2, "minutes"),
        (["tree"], 2, "is not one of 'robot', 'door'"),
    ],
)
def test_wrong_words(tmp_path, words, code, said):
    """What can't be is refused with the reason, and nothing is written."""
    path = tmp_path / "arm.yaml"
    done = CliRunner().invoke(flexsim, ["new", "-o", str(path), *words])
    assert done.exit_code == code and said in done.output + done.stderr
    assert not path.exists()


def test_first_door(tmp_path):
    """Size, layers and minutes are those asked for, materials are the library's."""
    path = tmp_path / "door.yaml"
    words = ["new", "door", "-o", str(path), "--size", "0.9x2", "--minutes", "30"]
    done = CliRunner().invoke(flexsim, [*words, "--layers", "stainless_steel:0.001,stone_wool_65:0.06"])
    assert done.exit_code == 0, done.output
    scene = load_door(path)
    assert (scene.leaf.width, scene.leaf.height, scene.criteria.minutes) == (0.9, 2.0, 30)
    assert [(k.material, k.thickness) for k in scene.leaf.layers] == [
        ("stainless_steel", 0.001), ("stone_wool_65", 0.06),
    ]  # fmt: skip
    assert scene.name == "door" and "rad" not in path.read_text().splitlines()[0]
    assert CliRunner().invoke(flexsim, ["new", "door", "-o", str(tmp_path / "d.yaml")]).exit_code == 0


def test_questions(tmp_path, monkeypatch):
    """All that is not given is asked for, a wrong answer once more, and an empty one takes the default."""
    monkeypatch.chdir(tmp_path)
    answers = "robot\n\nzw\nzy\n0.3,0.4\n\n2\n"
    done = CliRunner().invoke(flexsim, ["new", "--ask", "--json"], input=answers)
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["joints"] == ["joint_1", "joint_2"]
    assert "give letters from x, y and z" in done.stderr
    scene = load_scene("arm.yaml")
    assert [link.length for link in scene.links] == pytest.approx([0.3, 0.4])
    assert scene.links[-1].payload.mass == 2.0 and scene.links[0].beam.width == 0.02
    done = CliRunner().invoke(flexsim, ["new", "door", "--ask", "--minutes", "90"], input="\n\n\n")
    assert done.exit_code == 0 and load_door("door.yaml").criteria.minutes == 90
    for words, code in ((["new"], 2), (["new", "--ask"], 1)):  # nowhere to write; nobody answers
        assert CliRunner().invoke(flexsim, words, input="").exit_code == code
