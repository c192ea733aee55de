"""Links placed by frames: the same robot as by Denavit-Hartenberg, and Pinocchio's for any axes."""

from __future__ import annotations

import numpy as np
import pinocchio
import pytest
from framed_robots import by_frames
from random_robots import KINDS, body, random_robot

from flexsim_node import SceneError, load_scene, simulate, static_equilibrium
from flexsim_node.equations.dynamics.acceleration import acceleration
from flexsim_node.equations.dynamics.energy import energy
from flexsim_node.model.chain import workspace
from flexsim_node.model.model import build_model
from flexsim_node.sensors.observation import Observation
from flexsim_node.service.robot_description import robot_description

pytestmark = pytest.mark.equations
FORMULATIONS = ("erls", "co_moving")


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("seed", range(2))
def test_frames_are_denavit_hartenbergs_robot(kind, seed):
    """The same unknowns, and at random states the same accelerations, energies and places."""
    made = random_robot(seed, kind)
    rng = np.random.default_rng(seed)
    for formulation in FORMULATIONS:
        scenes = [load_scene(s, {"formulation": formulation}) for s in (made, by_frames(made))]
        models = [build_model(scene) for scene in scenes]
        assert len(scenes[0].links) == len(scenes[1].links)  # equal cost
        assert models[0].unknowns == models[1].unknowns
        assert models[0].planar == models[1].planar == (kind == "planar")
        n, m = models[0].unknowns, models[0].joints
        x, v = 1e-3 * rng.standard_normal(n), rng.standard_normal(n)
        x[:m], effort = rng.uniform(-1, 1, m), rng.uniform(-5, 5, m)
        found = []
        for model in models:
            work, a, joules = workspace(model.chain), np.zeros(n), np.zeros(3)
            assert acceleration(model.chain, work, x, v, effort, a) == 0
            energy(model.chain, work, x, v, joules)
            view = Observation(model)
            view.look(work, x)
            found.append((a, joules, view.link_end.copy()))
        for one, two in zip(*found, strict=True):
            assert np.allclose(one, two, rtol=0, atol=1e-9 * (1.0 + np.max(np.abs(one))))


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_frames_move_as_denavit_hartenbergs_robot(formulation):
    """A run of a flexible robot is the same to 1e-9 m."""
    made = random_robot(3, "serial", modulus=2e10)
    runs = []
    for scene in (made, by_frames(made)):
        loaded = load_scene(scene, {"formulation": formulation})
        effort = np.full(len(loaded.joints), 2.0)
        runs.append(simulate(loaded, lambda t, effort=effort: effort, 0.01, 1e-3))
    assert runs[0].status == runs[1].status == "ok"
    assert np.max(np.abs(runs[0].link_end - runs[0].link_end[0])) > 1e-4
    assert np.allclose(runs[0].link_end, runs[1].link_end, rtol=0, atol=1e-9)
    assert np.allclose(runs[0].joint_position, runs[1].joint_position, rtol=0, atol=1e-9)


def tree(seed: int) -> dict:
    """Rigid links at any place with any axis, several on one, some at named points."""
    rng = np.random.default_rng(seed)
    links: list[dict] = []
    for n in range(6):
        parent = int(rng.integers(-1, n))
        link = {
            "name": "abcdef"[n],
            "parent": "base" if parent < 0 else links[parent]["name"],
            "frame": {"xyz": rng.uniform(-0.4, 0.4, 3).tolist(), "rpy": rng.uniform(-1.5, 1.5, 3).tolist()},
            "joint": {"type": str(rng.choice(["revolute", "prismatic", "fixed"], p=[0.6, 0.2, 0.2]))},
            "points": {
                "tool": rng.uniform(-0.3, 0.3, 3).tolist(),
                "side": rng.uniform(-0.3, 0.3, 3).tolist(),
            },
            "rigid": body(rng, False),
        }
        if n == 0:
            link["joint"]["type"] = "revolute"
        if link["joint"]["type"] != "fixed":
            link["joint"]["axis"] = rng.standard_normal(3).tolist()
        if rng.random() < 0.4:
            link["end"] = rng.uniform(-0.3, 0.3, 3).tolist()
        if parent >= 0 and rng.random() < 0.5:
            link["attach"] = "side"
        if rng.random() < 0.4:
            link["payload"] = body(rng, False)
            link.setdefault("end", rng.uniform(-0.3, 0.3, 3).tolist())
        links.append(link)
    return {"model": "robot", "name": f"tree_{seed}", "gravity": [1.0, -2.0, -9.0], "links": links}


def depth_first(links: list[dict], parent: str) -> list[dict]:
    """The links beyond one, in the order that Pinocchio's composite bodies take for granted."""
    return [
        k for link in links if link["parent"] == parent for k in (link, *depth_first(links, link["name"]))
    ]


def reference(made: dict) -> tuple[pinocchio.Model, dict[str, tuple[int, pinocchio.SE3]]]:
    """The tree in Pinocchio; and for each link and point the joint that carries it and its place there."""
    model = pinocchio.Model()
    model.gravity.linear = np.array(made["gravity"])
    places = {"base": (0, pinocchio.SE3.Identity())}
    for link in depth_first(made["links"], "base"):
        parent, frame = link["parent"], link["frame"]
        joint, place = places[f"{parent}/{link['attach']}" if "attach" in link else parent]
        place = place * pinocchio.SE3(pinocchio.rpy.rpyToMatrix(*frame["rpy"]), np.array(frame["xyz"]))
        if link["joint"]["type"] != "fixed":
            axis = np.array(link["joint"]["axis"]) / np.linalg.norm(link["joint"]["axis"])
            turns = link["joint"]["type"] == "revolute"
            sort = pinocchio.JointModelRevoluteUnaligned if turns else pinocchio.JointModelPrismaticUnaligned
            joint, place = model.addJoint(joint, sort(axis), place, link["name"]), pinocchio.SE3.Identity()
        places[link["name"]] = joint, place
        for point, at in link["points"].items():
            places[f"{link['name']}/{point}"] = joint, place * pinocchio.SE3(np.eye(3), np.array(at))
        for key, root in (("rigid", np.zeros(3)), ("payload", np.array(link.get("end", [0, 0, 0])))):
            if key in link:
                b = link[key]
                centre = np.array(b["center_of_mass"]) + root
                model.appendBodyToJoint(
                    joint, pinocchio.Inertia(b["mass"], centre, np.array(b["inertia"])), place
                )
    return model, places


@pytest.mark.parametrize("seed", range(4))
def test_frames_are_pinocchios(seed):
    """Mass matrix, gravity's torques, accelerations and the places of links and points at a random state."""
    made = tree(seed)
    rng = np.random.default_rng(seed)
    other, places = reference(made)
    data, m = other.createData(), other.nv
    for formulation in FORMULATIONS:
        scene = load_scene(made, {"formulation": formulation})
        model = build_model(scene)
        assert model.unknowns == m
        q, v, effort = rng.uniform(-2, 2, m), rng.uniform(-3, 3, m), rng.uniform(-5, 5, m)
        # Pinocchio orders joints depth first, a scene as they are written
        order = [other.joints[other.getJointId(scene.links[n].name)].idx_v for n in model.joint_links]
        theirs = [np.zeros(m) for _ in range(3)]
        for there, here in zip(theirs, (q, v, effort), strict=True):
            there[order] = here
        work = workspace(model.chain)
        columns = np.zeros((m + 1, m))
        for k, extra in enumerate([np.zeros(m), *np.eye(m)]):
            assert acceleration(model.chain, work, q, v, effort + extra, columns[k]) == 0
        right = pinocchio.aba(other, data, *theirs)[order]
        assert np.allclose(columns[0], right, rtol=0, atol=1e-9 * np.max(np.abs(right)))
        pinocchio.crba(other, data, theirs[0])
        mass = np.triu(data.M) + np.triu(data.M, 1).T
        found = np.linalg.inv(columns[1:] - columns[0])
        assert np.allclose(found, mass[np.ix_(order, order)], rtol=0, atol=1e-9 * np.max(mass))
        holds = pinocchio.computeGeneralizedGravity(other, data, theirs[0])[order]
        assert np.allclose(
            static_equilibrium(scene, q).torque, holds, rtol=0, atol=1e-9 * np.max(np.abs(holds))
        )
        pinocchio.forwardKinematics(other, data, theirs[0])
        view = Observation(model)
        view.look(work, q)
        names = scene.link_names
        for link in made["links"]:
            end = link.get("end", [0.0, 0.0, 0.0])
            joint, place = places[link["name"]]
            there = (data.oMi[joint] * place).act(np.array(end))
            if "end" in link or not any(k.get("parent") == link["name"] for k in made["links"]):
                assert np.allclose(view.link_end[names.index(link["name"])], there, rtol=0, atol=1e-12)
            for point in link["points"]:
                name = f"{link['name']}/{point}"
                joint, place = places[name]
                there = (data.oMi[joint] * place).translation
                assert np.allclose(view.link_end[names.index(name)], there, rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", range(3))
def test_description_is_the_same_robot(seed):
    """Pinocchio reads the URDF that is published as the scene's robot: mass matrix of any pose."""
    made = tree(seed)
    scene = load_scene(made)
    other, (own, _) = pinocchio.buildModelFromXML(robot_description(scene)), reference(made)
    rng = np.random.default_rng(seed)
    q = dict(zip(scene.joint_names, rng.uniform(-0.9, 0.9, len(scene.joint_names)), strict=True))
    matrices = []
    for model, suffix in ((other, ""), (own, "_joint")):
        data, there = model.createData(), pinocchio.neutral(model)
        order = []
        for name, angle in q.items():
            joint = model.joints[model.getJointId(name if not suffix else name.removesuffix(suffix))]
            there[joint.idx_q : joint.idx_q + joint.nq] = (
                [np.cos(angle), np.sin(angle)] if joint.nq == 2 else [angle]
            )
            order.append(joint.idx_v)
        pinocchio.crba(model, data, there)
        whole = np.triu(data.M) + np.triu(data.M, 1).T
        matrices.append(whole[np.ix_(order, order)])
    assert np.allclose(*matrices, rtol=1e-9, atol=1e-9 * np.max(matrices[1]))


LINK = {"name": "a", "frame": {"xyz": [0, 0, 0.1]}, "rigid": {"mass": 1.0, "center_of_mass": [0.1, 0, 0]}}
BEAM = {"width": 0.02, "depth": 0.02, "density": 2700.0, "youngs_modulus": 7e10}


@pytest.mark.parametrize(
    ("links", "said"),
    [
        ([LINK | {"dh": {"a": 0.2}}], "links.0.frame: is given beside dh"),
        ([{"name": "a", "dh": {"a": 0.2}, "end": [0, 0, 1]}], "links.0.end: goes with frame"),
        ([{"name": "a", "dh": {"a": 0.2}, "points": {"p": [0, 0, 1]}}], "links.0.points: goes with frame"),
        (
            [{"name": "a", "dh": {"a": 0.2}, "joint": {"axis": [0, 1, 0]}}],
            "links.0.joint.axis: goes with frame",
        ),
        ([LINK | {"joint": {"axis": [0, 0, 0]}}], "links.0.joint.axis: is zero"),
        ([LINK | {"joint": {"axis": [0, float("nan"), 1]}}], "links.0.joint.axis"),
        ([LINK | {"frame": {"xyz": [0, 0, 300.0]}}], "metres, not millimetres"),
        ([LINK | {"frame": {"xyz": [0, 0]}}], "links.0.frame.xyz"),
        ([LINK | {"points": {"end": [0, 0, 1]}}], "links.0.points.end: can't be so called"),
        ([LINK, {"name": "b", "attach": "tool", "frame": {}}], "links.1.attach: is 'tool', no point"),
        ([LINK | {"attach": "tool"}], "links.0.attach: is 'tool', no point"),
        ([{"name": "a", "frame": {}, "beam": BEAM}], "end: [x, y, z]"),
        (
            [{"name": "a", "frame": {}, "end": [0, 0, 1], "beam": BEAM}, LINK | {"name": "b"}],
            "links.1.frame: is nearer to the start",
        ),
    ],
)
def test_impossible_places_are_refused(links, said):
    """One sentence: which key, what is wrong."""
    with pytest.raises(SceneError) as problem:
        load_scene({"model": "robot", "name": "r", "links": links})
    assert said in str(problem.value) and "\n" not in str(problem.value)


def test_tips_and_sensors_at_points():
    """A named point can be a tip or bear an instrument; a scene that was read is read again as it was."""
    link = LINK | {"points": {"tool": [0, 0.1, 0.2], "side": [0.1, 0, 0]}}
    sensor = {"name": "hand", "type": "pose", "link": "a/tool"}
    made = {"model": "robot", "name": "r", "links": [link], "tip": "a/tool", "sensors": [sensor]}
    scene = load_scene(made)
    assert [scene.link_names[n] for n in scene.tips] == ["a/tool"]
    assert load_scene(scene.model_dump()) == scene
    with pytest.raises(SceneError, match="names a point 'tol', but a has it not: give a/tool or a/side or a"):
        load_scene(made | {"tip": "a/tol"})
