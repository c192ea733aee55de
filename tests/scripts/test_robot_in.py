"""Of several simulators in one bag, what belongs to one robot is taken for one robot."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from flexsim.bag import Bag, BagError, BagWriter
from flexsim.bag.robot import JOINTS, LAYOUT, STATE, robot_in
from flexsim.bag_report import motion, tracking
from flexsim.bag_report.reading import Reading
from flexsim.comparison.saved_run import read
from flexsim.health.examination import examine
from flexsim.replay.drive import read_drive
from flexsim.rerun_view import robot_bag
from made_bags import at, diagnostics, elastic_layout, elastic_state, joint_state
from processes import flexsim

pytestmark = pytest.mark.ros
ARM, SECOND, DOOR = "/cell/arm", "/second", "/a_door"
SCENES = {ARM: "z_arm.yaml", SECOND: "pendulum.yaml", DOOR: "a_door.yaml"}


def write(path: Path, nodes: tuple[str, ...], told: bool = True) -> Bag:
    """Write a bag of simulators: robots with states, in this order, and what the recorder notes of each."""
    with BagWriter(path) as bag:
        for node in nodes:
            if told:
                own = {"scene": json.dumps(f"/home/user/{SCENES[node]}")}
                bag.note(node, own if node == DOOR else own | {"elastic_rate": "100.0", "rate": "100.0"})
                bag.attach(SCENES[node], "application/yaml", node.encode())
            if node == DOOR:
                continue
            joints = bag.add_topic(f"{node.rpartition('/')[0]}/joint_states", JOINTS)
            state, layout = (bag.add_topic(f"{node}/{t}", k)
                             for t, k in (("elastic_state", STATE), ("elastic_layout", LAYOUT)))  # fmt: skip
            bag.write(layout, elastic_layout({"link": 4}, 0.1, 0.1), at(0.0))
            zeros = np.zeros((4, 3))
            for k in range(5):
                effort = [3.0 if node == ARM else 4.0]
                bag.write(joints, joint_state(0.01 * k, [node[1:]], [0.1 * k], [0.0], effort), at(0.01 * k))
                bag.write(state, elastic_state(0.01 * k, np.zeros((4, 6)), zeros, zeros), at(0.01 * k))
    return Bag(path)


@pytest.mark.parametrize("nodes", [(ARM, SECOND, DOOR), (DOOR, SECOND, ARM)])
def test_one_robot_of_several(nodes: tuple[str, ...], tmp_path: Path) -> None:
    """Joints, states, layout, scene and parameters are one robot's; the other's joints are no wish of it."""
    bag = write(tmp_path / "run", nodes)
    robot = robot_in(bag)
    assert (robot.node, robot.joints, robot.state, robot.layout) == (
        ARM, "/cell/joint_states", f"{ARM}/elastic_state", f"{ARM}/elastic_layout")  # fmt: skip
    assert (robot.scene_name, robot.scene) == ("z_arm.yaml", ARM.encode())
    assert robot.others == (SECOND,)
    drive = read_drive(bag)
    assert (drive.torque == 3.0).all()
    assert drive.scene == ARM.encode()
    assert robot_bag.topics(bag)[robot_bag.JOINTS] == "/cell/joint_states"
    measured = motion.joints(Reading(bag), "/cell/joint_states")
    assert tracking.wanted(Reading(bag), measured) is None


def test_the_robot_that_is_meant(tmp_path: Path) -> None:
    """By the name of its simulator, with or without the first slash; a name that none bears is refused."""
    write(tmp_path / "run", (ARM, SECOND, DOOR))
    for name in (SECOND, SECOND[1:]):
        bag = Bag(tmp_path / "run", name)
        robot = robot_in(bag)
        assert (robot.node, robot.joints, robot.others) == (SECOND, "/joint_states", (ARM,))
        assert (read_drive(bag).torque == 4.0).all()
        assert robot_bag.topics(bag)[robot_bag.JOINTS] == "/joint_states"
        assert read(tmp_path / "run", robot=name).joint_names == (SECOND[1:],)
    with pytest.raises(BagError, match=f"no robot /third; it holds {ARM}, {SECOND}"):
        robot_in(Bag(tmp_path / "run", "/third"))
    words = ("report", tmp_path / "run", "-o", tmp_path / "out.html")
    assert flexsim(*words, "--robot", SECOND).returncode == 0
    assert f"this is {SECOND}; further ones, for --robot: {ARM}" in (tmp_path / "out.html").read_text()
    done = flexsim(*words, "--robot", "/third")
    assert done.returncode == 1 and "holds no robot /third" in done.stderr


@pytest.mark.parametrize(
    "words",
    [
        ("compare", "run", "run"),
        ("simulate", "scene.yaml"),
        ("effects", "scene.yaml"),
        ("play", "run"),
        ("view", "scene.yaml", "--save", "view.rrd"),
    ],
)
def test_a_choice_that_nobody_makes(words: tuple[str, ...], tmp_path: Path) -> None:
    """Where no robot is chosen by it --robot is refused, and not passed over in silence."""
    write(tmp_path / "run", (ARM, SECOND))
    (tmp_path / "scene.yaml").write_text("model: robot\n")
    done = flexsim(*words, "--robot", SECOND, cwd=tmp_path)
    assert done.returncode == 2 and "--robot" in done.stderr


def test_another_robot_s_energy(tmp_path: Path) -> None:
    """What another simulator says of its energy is not held against this robot's work."""
    with BagWriter(tmp_path / "run") as bag:
        joints = bag.add_topic("/cell/joint_states", JOINTS)
        said = bag.add_topic("/diagnostics", "diagnostic_msgs/msg/DiagnosticArray")
        for node in (ARM, SECOND):
            bag.note(node, {"scene": json.dumps(SCENES[node]), "elastic_rate": "100.0"})
            bag.attach(SCENES[node], "application/yaml", f"model: robot\nname: {node[1:]}  # so\n".encode())
        for k in range(501):
            bag.write(joints, joint_state(0.01 * k, ["a"], [0.0], [0.0], [0.0]), at(0.01 * k))
            if k % 100 == 50:
                for who, energy in (("cell/arm", 1.0), ("second", 5.0)):
                    values = {f"{kind} energy, J": energy for kind in ("kinetic", "elastic", "gravitational")}
                    told = {"energy": (0, "", values | {"overruns": 7 if who == "second" else 0})}
                    bag.write(said, diagnostics(0.01 * k, told, hardware=who), at(0.01 * k))
    found = examine(Bag(tmp_path / "run"))
    assert (found.energy_checked, found.gained) == (4, [])
    assert found.said.missed == 7
    assert [energy for _, _, energy, _ in found.said.energy] == [3.0] * 5


def test_nothing_is_taken_from_a_door(tmp_path: Path) -> None:
    """A bag of a door holds no robot, and its scene is not one."""
    robot = robot_in(write(tmp_path / "run", (DOOR,)))
    assert (robot.joints, robot.state, robot.scene) == (None, None, None)
    with pytest.raises(BagError, match="holds no joint states"):
        read_drive(Bag(tmp_path / "run"))


def test_another_recorder(tmp_path: Path) -> None:
    """Where the recorder noted nothing the topics' names tell."""
    robot = robot_in(write(tmp_path / "run", (SECOND, ARM), told=False))
    assert (robot.joints, robot.state) == ("/cell/joint_states", f"{ARM}/elastic_state")
    assert robot.scene is None
