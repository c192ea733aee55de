"""`flexsim import`: where joints are held, where those that follow others are; places by Pinocchio."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest
from click.testing import CliRunner
from flexsim.cli import flexsim
from flexsim.robot_import.account import Account
from flexsim.robot_import.determined import mass_matrix
from flexsim.robot_import.scene import Choices, scene_of
from flexsim.robot_import.urdf import read_urdf
from flexsim.robot_import.xml_file import ImportRefused, parse_xml
from urdf_robots import ARM, BODY, joint, link, robot

from flexsim_node.rotations.roll_pitch_yaw import roll_pitch_yaw, rotation

LEANING = BODY.replace("0 0 0.1", "0.1 0.05 0.1")


def scene(text: str, **choices) -> tuple[dict, str]:
    """A URDF's scene, and what was said."""
    account = Account()
    urdf = read_urdf(parse_xml(text.encode(), "r.urdf"), Path())
    return scene_of(urdf, Choices(**choices), account, "r.urdf"), str(account.lines)


def pinocchios(text: str, **angles: float) -> tuple[pinocchio.Model, np.ndarray]:
    """Pinocchio's mass matrix with the joints so."""
    model = pinocchio.buildModelFromXML(text)
    data, q = model.createData(), pinocchio.neutral(model)
    for name, angle in angles.items():
        found = model.joints[model.getJointId(name)]
        q[found.idx_q : found.idx_q + found.nq] = [np.cos(angle), np.sin(angle)] if found.nq == 2 else [angle]
    pinocchio.crba(model, data, q)
    return model, np.triu(data.M) + np.triu(data.M, 1).T


def three(kind: str, inside: str = "") -> str:
    """Three bodies, of which the second hangs on a joint of a kind with a skew axis."""
    first = '<limit lower="0.4" upper="0.8" effort="1" velocity="1"/>'
    limit = '<limit lower="-3" upper="3" effort="1" velocity="1"/>'
    return robot(
        link("a", LEANING), joint("one", "ground", "a", inside=first),
        link("b", LEANING), joint("two", "a", "b", kind, f'<axis xyz="0.6 0 0.8"/>{limit}{inside}'),
        link("c", LEANING), joint("three", "b", "c", inside=limit),
    )  # fmt: skip


@pytest.mark.parametrize("kind", ["revolute", "prismatic"])
def test_held_joint_is_where_it_is_held(kind):
    """The rest of the robot is Pinocchio's with that joint so, and the table says so."""
    text = three(kind)
    found, said = scene(text, hold={"two": 0.7})
    _, whole = pinocchios(text, one=0.2, two=0.7, three=-0.3)
    right = whole[np.ix_([0, 2], [0, 2])]
    assert np.allclose(mass_matrix(found["links"], np.array([0.2, -0.3])), right, rtol=0, atol=1e-12)
    assert "held at 0.7" in said and "outside" not in said
    assert "held at 4, outside its limits" in scene(text, hold={"two": 4.0})[1]


def test_follower_starts_and_is_held_where_it_follows():
    """Multiplier times the other's start (the middle of limits that leave out 0), and offset."""
    text = three("revolute", '<mimic joint="one" multiplier="-2" offset="0.5"/>')
    free, said = scene(text)
    assert free["initial"]["position"] == pytest.approx({"one": 0.6, "two": -0.7})
    assert "follows one in the URDF; here it moves on its own, from -0.7" in said
    held, _ = scene(text, hold_mimics=True)
    _, whole = pinocchios(text, one=0.6, two=-0.7, three=0.4)
    right = whole[np.ix_([0, 2], [0, 2])]
    assert np.allclose(mass_matrix(held["links"], np.array([0.6, 0.4])), right, rtol=0, atol=1e-12)
    _, said = scene(three("revolute", '<mimic joint="one" multiplier="9"/>'))
    assert "start outside their limits" in said


def test_followers_of_nobody_and_in_circles():
    """A joint that follows one which is not there is in doubt; joints that follow each other are refused."""
    _, said = scene(three("revolute", '<mimic joint="four"/>'))
    assert "follow a joint that is not in the file" in said
    circle = three("revolute", '<mimic joint="three"/>').replace(
        "</joint>\n</robot>", '<mimic joint="two"/></joint>\n</robot>'
    )
    with pytest.raises(ImportRefused, match="in a circle"):
        scene(circle)


def test_words_of_hold(tmp_path):
    """JOINT or JOINT=VALUE, of a joint that can move, once."""
    path = tmp_path / "r.urdf"
    path.write_text(ARM)
    for words, code, said in (
        (["elbow=0.3"], 0, "held at 0.3"),
        (["elbow=far"], 2, "give JOINT or JOINT=VALUE"),
        (["elbow=nan"], 2, "give JOINT or JOINT=VALUE"),
        (["elbow", "elbow=1"], 2, "is given twice"),
        (["flange"], 1, "is no joint that can move; give one of shoulder, elbow"),
    ):
        options = [word for value in words for word in ("--hold", value)]
        done = CliRunner().invoke(
            flexsim, ["import", str(path), "-o", str(tmp_path / "r.yaml"), "--force", *options]
        )
        assert done.exit_code == code, words
        assert said in " ".join((done.output + str(done.exception)).split())


@pytest.mark.parametrize("pitch", [np.pi / 2, 1.57079632679, -1.5707963, 1.5708, 0.3])
def test_turns_straight_up_are_exact(pitch):
    """Roll, pitch and yaw of frames put together: exact where x nearly looks along z, as in many URDFs."""
    rng = np.random.default_rng(0)
    for _ in range(20):
        around = rotation(rng.uniform(-3, 3, 3) * [1, 0, 0])
        turn = around @ rotation(np.array([0.3, pitch, 0.2])) @ rotation(rng.uniform(-1e-9, 1e-9, 3))
        assert np.allclose(rotation(roll_pitch_yaw(turn)), turn, rtol=0, atol=1e-14)
