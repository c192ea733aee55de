"""Of several simulators in one bag, what belongs to one robot is taken for one robot."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flexsim.bag import Bag, BagError, BagWriter
from flexsim.bag.robot import JOINTS, LAYOUT, STATE, robot_in
from flexsim.bag.scenes import scenes_in
from flexsim.bag_report import motion, tracking
from flexsim.bag_report.reading import Reading
from flexsim.comparison.saved_run import read
from flexsim.health.examination import examine
from flexsim.replay.drive import read_drive
from flexsim.rerun_view import robot_bag
from flexsim_ros.published_scene import scene_text
from made_bags import at, diagnostics, elastic_layout, elastic_state, joint_state
from processes import flexsim
from rclpy.serialization import serialize_message
from std_msgs.msg import String

pytestmark = pytest.mark.ros
ARM, SECOND, DOOR = "/cell/arm", "/second", "/a_door"
STRING = "std_msgs/msg/String"


def tell(bag: BagWriter, node: str, name: str = "", rate: float = 100.0, **more: Any) -> str:
    """Write the scene that a simulator publishes, a few keys of it, and return it."""
    door = node == DOOR
    own = {} if door else {"elastic_rate": 100.0}
    text = scene_text(
        "thermal_node" if door else "flexsim_node", {"name": name or node[1:]} | more.pop("scene", {}),
        {"scene": f"/home/user/{node[1:]}.yaml", "rate": rate} | own, overrides={}, **more,
    )  # fmt: skip
    topic = bag.add_topic(f"{node}/scene", STRING)
    bag.write(topic, serialize_message(String(data=text)), at(0.0))
    return text


def write(path: Path, nodes: tuple[str, ...], told: bool = True) -> Bag:
    """Write a bag of simulators: robots with states, in this order, and the scene of each."""
    with BagWriter(path) as bag:
        for node in nodes:
            if told:
                tell(bag, node)
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
    assert robot.scene is not None and robot.model == ARM[1:]
    assert robot.parameters["rate"] == 100.0
    assert robot.others == (SECOND,)
    drive = read_drive(bag)
    assert (drive.torque == 3.0).all()
    assert drive.scene == robot.scene
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
            tell(bag, node)
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
    """Where no scene is in the bag the topics' names tell, and it is said; no scene is guessed at."""
    robot = robot_in(write(tmp_path / "run", (SECOND, ARM), told=False))
    assert (robot.joints, robot.state) == ("/cell/joint_states", f"{ARM}/elastic_state")
    assert (
        robot.scene is None and robot.why_not == f"the bag does not hold its scene: none that {ARM} published"
    )


def test_a_bag_of_an_earlier_version(tmp_path: Path) -> None:
    """What an earlier recorder read from its own disk may be another robot: it is named, and not used."""
    with BagWriter(tmp_path / "run") as bag:
        bag.note(
            SECOND, {"scene": json.dumps("/home/user/arm.yaml"), "elastic_rate": "100.0", "rate": "50.0"}
        )
        bag.attach("arm.yaml", "application/yaml", b"model: robot\nname: arm\n")
        joints = bag.add_topic("/joint_states", JOINTS)
        for k in range(5):
            bag.write(joints, joint_state(0.01 * k, ["a"], [0.1 * k], [0.0], [1.0]), at(0.01 * k))
    robot = robot_in(Bag(tmp_path / "run"))
    assert robot.scene is None and robot.parameters["rate"] == 50.0  # which its node did tell
    for words in (("play", "run", "--lockstep"), ("simulate", "run")):
        done = flexsim(*words, cwd=tmp_path)
        assert done.returncode == 1
        assert "no scene that its simulator of /second published. arm.yaml in it" in done.stderr


def test_a_scene_that_was_tampered_with(tmp_path: Path) -> None:
    """A scene that does not fit its hash is not used; a text on another's topic is no scene at all."""
    with BagWriter(tmp_path / "run") as bag:
        text = tell(bag, ARM)
        later = json.dumps({"scene": {}, "hash": "", "simulator": "x", "format": 2})
        changed = text.replace("cell/arm", "cell/leg")
        for node, told in ((SECOND, changed), ("/camera", "a street"), ("/b", later)):
            bag.write(bag.add_topic(f"{node}/scene", STRING), serialize_message(String(data=told)), at(0.0))
    found = scenes_in(Bag(tmp_path / "run"))
    assert set(found) == {ARM, SECOND, "/b"}
    assert found[ARM].scene is not None and found[ARM].scene.name == "cell/arm"
    assert "/second published does not fit its hash" in found[SECOND].why_not
    assert "has format 2; this version reads 1" in found["/b"].why_not


def test_a_scene_that_changes(tmp_path: Path) -> None:
    """One that replaced another before the first tick ran alone; later neither is the run's."""
    for ticks, why in ((0, ""), (30, "is not one throughout: faults at 0.3 s")):
        with BagWriter(tmp_path / f"run_{ticks}") as bag:
            topic = bag.add_topic(f"{ARM}/scene", STRING)
            for faults, since, count in (([], 0.0, 0), ([{"kind": "lag"}], 0.01 * ticks, ticks)):
                text = scene_text("flexsim_node", {"name": "a", "faults": faults}, {}, overrides={},
                                       since=since, ticks=count)  # fmt: skip
                bag.write(topic, serialize_message(String(data=text)), at(since))
        found = scenes_in(Bag(tmp_path / f"run_{ticks}"))[ARM]
        assert why in found.why_not
        assert (found.scene is None) == bool(why)


def test_compare_says_whether_the_scenes_are_one(tmp_path: Path) -> None:
    """Equal hashes, the keys that differ, or that it is not known."""
    for name, elements in (("a", 2), ("b", 2), ("c", 4), ("d", None)):
        with BagWriter(tmp_path / name) as bag:
            if elements:
                tell(bag, SECOND, scene={"links": [{"beam": {"elements": elements}}]})
            joints = bag.add_topic("/joint_states", JOINTS)
            for k in range(5):
                bag.write(joints, joint_state(0.01 * k, ["a"], [0.1 * k], [0.0], [1.0]), at(0.01 * k))
    said = {other: flexsim("compare", "a", other, cwd=tmp_path).stdout for other in "bcd"}
    assert "scene of /second: the same, sha256:" in said["b"]
    assert "scene of /second: differs in links.0.beam.elements\n" in said["c"]
    assert "scene of /second: not compared, d holds no scene of it" in said["d"]
