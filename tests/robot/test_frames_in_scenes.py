"""Scenes of links by frames: what is written is what is meant, whatever links their points become."""

from __future__ import annotations

import copy
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
import pinocchio
import pytest
from flexsim.study.robot_grid import RobotGrid
from framed_robots import by_frames
from random_robots import random_robot

from flexsim_node import linearize, natural_frequencies
from flexsim_node.scene.load import SceneError, load_scene
from flexsim_node.service.robot_description import robot_description

CONFIG = Path(__file__).parents[2] / "config"
BEAM = {"width": 0.02, "depth": 0.02, "density": 2700.0, "youngs_modulus": 7e10, "elements": 2}
# The first link begins beside the base and has two points: three more links come before the second beam.
ROBOT = {
    "model": "robot", "name": "r", "tolerance": 1e-3,
    "links": [
        {"name": "foot", "frame": {"xyz": [0, 0, 0.2]}, "end": [0, 0, 0.3], "beam": BEAM,
         "points": {"lamp": [0, 0.1, 0.3], "plug": [0, 0, 0.25]}},
        {"name": "head", "frame": {"xyz": [0, 0, 0.3]}, "end": [0.4, 0, 0], "beam": BEAM,
         "points": {"eye": [0.4, 0, 0.1]}},
    ],
}  # fmt: skip


def test_mesh_of_a_study_is_of_the_links_in_the_file():
    """Elements and reductions of a study go to the links that bend, which the file counts otherwise."""
    scene = load_scene(ROBOT)
    assert [k.name for k in scene.links if k.beam] == ["foot", "head"] and len(scene.links) == 6
    for names in (("foot", "head"), ("1", "0")):  # a link may bear the number of another
        made = copy.deepcopy(ROBOT)
        for link, name in zip(made["links"], names, strict=True):
            link["name"] = name
        made["links"][1]["reduction"] = {"modes": 2}
        grid = RobotGrid(made, {}, load_scene(made), 1e-3, {}, False)
        fine = load_scene(made, grid.meshed(8, 5))
        assert [k.beam.elements for k in fine.links if k.beam] == [8, 8]
        assert [fine.modes_of(k) for k in fine.links if k.beam] == [5, 5]


def test_instrument_without_a_link_is_on_the_last_one_written():
    """It is the last link's end, or a gauge on its beam; not one of its points."""
    sensors = [
        {"name": "imu", "type": "imu"},
        {"name": "gauge", "type": "strain_gauge", "fraction": 0.1, "side": "+z"},
        {"name": "lamp", "type": "pose", "link": "foot/lamp"},
    ]
    scene = load_scene(ROBOT | {"sensors": sensors})
    assert [sensor.link for sensor in scene.sensors] == ["head", "head", "foot/lamp"]


def test_complaints_count_links_as_the_file_does():
    """A link is named by the number that it has in the file."""
    made = copy.deepcopy(ROBOT)
    made["links"][1]["reduction"] = {"modes": 2}
    with pytest.raises(SceneError, match=r"links\.1\.reduction: takes formulation: erls"):
        load_scene(made, {"formulation": "co_moving"})
    made["links"].append({"name": "foot/lamp", "frame": {"xyz": [0.4, 0, 0]}})
    with pytest.raises(SceneError, match=r"links\.2\.name: is 'foot/lamp', as a point of foot is called"):
        load_scene(made)


@pytest.mark.parametrize("place", [[0, 0, 0], [0, 0.02, 0.1]])
def test_point_at_a_beams_start_is_refused(place):
    """It would move with the beam's end, where it is not."""
    with pytest.raises(SceneError, match=r"links\.0\.points\.low: is nearer to the start"):
        load_scene(ROBOT, {"links.foot.points": {"low": place}})


def test_keys_of_frames_are_set_by_name():
    """Frames, axes, ends and points take overrides, as all keys do."""
    scene = load_scene(
        ROBOT,
        {"links.head.joint.axis": [0, 1, 0], "links.foot.frame.xyz.2": 0.5, "links.foot.points.lamp.1": 0.3,
         "links.head.end": [0.5, 0, 0]},
    )  # fmt: skip
    links = {link.name: link for link in scene.links}
    assert links["head"].joint.axis == (0, 1, 0) and links["foot/start"].end == (0, 0, 0.5)
    assert links["foot/lamp"].end == pytest.approx((0, 0.3, 0)) and links["head"].length == 0.5
    with pytest.raises(SceneError, match="no 'foot/lamp' in links; give one of foot, head"):
        load_scene(ROBOT, {"links.foot/lamp.end": [0, 0, 1]})


@pytest.mark.parametrize("name", ["anthropomorphic.yaml", "planar_double_pendulum.yaml", "delta.yaml"])
def test_scenes_by_denavit_hartenberg_keep_their_keys(name):
    """What a node publishes of them is as before there were frames: bags of older runs keep their hash."""
    new = {"attach", "frame", "end", "points", "visuals"}
    for link in load_scene(CONFIG / name).model_dump()["links"]:
        assert {"name", "parent", "dh", "joint", "beam", "payload"} <= set(link) and not new & set(link)
        assert "axis" not in link["joint"]
    found = load_scene(ROBOT, {"links.head.joint.axis": [0, 1, 0]})
    assert load_scene(found.model_dump()) == found == load_scene(found.model_dump(mode="json"))


def test_link_called_tip():
    """The published URDF's own tip gives way: each name is there once."""
    made = copy.deepcopy(ROBOT)
    made["links"][1]["name"] = "tip"
    root = xml.fromstring(robot_description(load_scene(made)))
    for kind in ("link", "joint"):
        names = [element.get("name") for element in root.findall(kind)]
        assert len(set(names)) == len(names)
    ends = [joint.find("child").get("link") for joint in root.findall("joint")]
    assert sorted(ends) == sorted(e.get("name") for e in root.findall("link") if e.get("name") != "base")


@pytest.mark.parametrize("pitch", [1.570796, 1.5708, np.pi / 2, -1.57079632679])
def test_description_is_exact_where_a_link_points_straight_up(pitch):
    """Pinocchio has links, points and tip where the scene's frames put them, one frame looking along z."""
    made = copy.deepcopy(ROBOT)
    made["links"][0]["frame"]["rpy"] = [0.4, pitch, 0.3]
    made["links"][1]["frame"]["rpy"] = [0.1, 0.2, 0.3]
    model = pinocchio.buildModelFromXML(robot_description(load_scene(made)))
    data = model.createData()
    pinocchio.framesForwardKinematics(model, data, pinocchio.neutral(model))
    foot, head = (pinocchio.rpy.rpyToMatrix(*link["frame"]["rpy"]) for link in made["links"])
    eye = np.array([0, 0, 0.2]) + foot @ (np.array([0, 0, 0.3]) + head @ [0.4, 0, 0.1])
    place, base = np.array([0, 0, 0.2]), np.array([0, 0, 0.3])
    for name, there in (
        ("foot/start", place), ("foot", place), ("foot/lamp", place + foot @ [0, 0.1, 0.3]),
        ("foot/plug", place + foot @ [0, 0, 0.25]), ("head", place + foot @ base), ("head/eye", eye),
    ):  # fmt: skip
        at = data.oMf[model.getFrameId(name, pinocchio.FrameType.BODY)].translation
        assert np.allclose(at, there, rtol=0, atol=1e-11), name
    found = data.oMf[model.getFrameId("tip")]
    assert np.allclose(found.translation, eye, rtol=0, atol=1e-11)
    assert np.allclose(found.rotation, foot @ head, rtol=0, atol=1e-11)


def test_visuals_are_published_where_they_are():
    """Path, place, turn and scale of a mesh are the scene's."""
    made = copy.deepcopy(ROBOT)
    made["links"][0]["visuals"] = [
        {"mesh": "package://r/foot.stl", "scale": [1e-3, 1e-3, -1e-3],
         "frame": {"xyz": [0.1, 0.2, 0.3], "rpy": [0.1, 0.2, 0.3]}}
    ]  # fmt: skip
    root = xml.fromstring(robot_description(load_scene(made)))
    visual = root.find("link[@name='foot']/visual")
    mesh, origin = visual.find("geometry/mesh"), visual.find("origin")
    assert mesh.get("filename") == "package://r/foot.stl"
    assert [float(x) for x in mesh.get("scale").split()] == [1e-3, 1e-3, -1e-3]
    for key, right in (("xyz", [0.1, 0.2, 0.3]), ("rpy", [0.1, 0.2, 0.3])):
        assert np.allclose([float(x) for x in origin.get(key).split()], right, rtol=0, atol=1e-12)


def test_frames_have_denavit_hartenbergs_modes_and_description():
    """Natural frequencies, the linear model, and the robot that Pinocchio reads from the published URDF."""
    made = random_robot(3, "serial", modulus=2e10)
    scenes = [load_scene(scene) for scene in (made, by_frames(made))]
    place = 0.3 + 0.2 * np.arange(len(scenes[0].joints))
    frequencies = [natural_frequencies(scene, place) for scene in scenes]
    assert np.allclose(*frequencies, rtol=1e-9, atol=0) and np.all(frequencies[0] > 0.0)
    linear = [linearize(scene, place, ("joint_position", "tip_position")) for scene in scenes]
    assert linear[0].state_names == linear[1].state_names
    for key in ("A", "B", "C"):
        one, two = (getattr(model, key) for model in linear)
        assert np.allclose(one, two, rtol=0, atol=1e-9 * np.max(np.abs(one)))
    tips, torques = [], []
    for scene in scenes:
        model = pinocchio.buildModelFromXML(robot_description(scene))
        assert tuple(model.names)[1:] == scene.joint_names
        data, q = model.createData(), pinocchio.neutral(model)
        for name, angle in zip(scene.joint_names, place, strict=True):
            joint = model.joints[model.getJointId(name)]
            both = [np.cos(angle), np.sin(angle)] if joint.nq == 2 else [angle]
            q[joint.idx_q : joint.idx_q + joint.nq] = both
        pinocchio.framesForwardKinematics(model, data, q)
        tips.append(data.oMf[model.getFrameId("tip")].homogeneous)
        torques.append(pinocchio.rnea(model, data, q, np.ones(model.nv), np.ones(model.nv)))
    assert np.allclose(*tips, rtol=0, atol=1e-12)
    assert np.allclose(*torques, rtol=0, atol=1e-9 * np.max(np.abs(torques[0])))
