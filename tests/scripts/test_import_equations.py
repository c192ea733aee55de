"""An imported robot is Pinocchio's robot of the same URDF."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio
import pytest
from flexsim.robot_import.account import Account
from flexsim.robot_import.additions import add
from flexsim.robot_import.scene import Choices, scene_of
from flexsim.robot_import.urdf import read_urdf
from flexsim.robot_import.writing import scene_text
from flexsim.robot_import.xml_file import parse_xml
from ruamel.yaml import YAML
from urdf_robots import ARM, random_urdf

from flexsim_node import load_scene, static_equilibrium
from flexsim_node.equations.dynamics.acceleration import acceleration
from flexsim_node.model.chain import workspace
from flexsim_node.model.model import build_model
from flexsim_node.sensors.observation import Observation
from flexsim_node.service.robot_description import robot_description

pytestmark = pytest.mark.equations


def imported(text: str, **choices) -> dict:
    """The scene of a URDF, written and read."""
    document = scene_of(
        read_urdf(parse_xml(text.encode(), "r.urdf"), Path()), Choices(**choices), Account(), "r.urdf"
    )
    return YAML(typ="safe").load(scene_text(document, "r.urdf"))


def state(model: pinocchio.Model, names, q) -> tuple[np.ndarray, list[int]]:
    """Pinocchio's coordinates of the joints' angles q, and where it has their rates."""
    there, order = pinocchio.neutral(model), []
    for name, angle in zip(names, q, strict=True):
        joint = model.joints[model.getJointId(name)]
        both = [np.cos(angle), np.sin(angle)] if joint.nq == 2 else [angle]
        there[joint.idx_q : joint.idx_q + joint.nq] = both
        order.append(joint.idx_v)
    return there, order


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("keep_fixed", [False, True])
def test_imported_robot_is_pinocchios(seed, keep_fixed):
    """Mass matrix, gravity's torques, accelerations and frames at a random state, to 1e-9."""
    text = random_urdf(seed)
    scene = load_scene(imported(text, keep_fixed=keep_fixed))
    model, other = build_model(scene), pinocchio.buildModelFromXML(text)
    work, data, m = workspace(model.chain), other.createData(), model.joints
    assert m == other.nv == model.unknowns
    rng = np.random.default_rng(seed)
    q, v, effort = rng.uniform(-2, 2, m), rng.uniform(-3, 3, m), rng.uniform(-5, 5, m)
    there, order = state(other, scene.joint_names, q)
    columns = np.zeros((m + 1, m))
    for k, extra in enumerate([np.zeros(m), *np.eye(m)]):
        assert acceleration(model.chain, work, q, v, effort + extra, columns[k]) == 0
    pinocchio.crba(other, data, there)
    mass = (np.triu(data.M) + np.triu(data.M, 1).T)[np.ix_(order, order)]
    found = np.linalg.inv(columns[1:] - columns[0])
    assert np.allclose(found, mass, rtol=0, atol=1e-9 * np.max(mass))
    rates, torques = np.zeros(m), np.zeros(m)
    rates[order], torques[order] = v, effort
    right = pinocchio.aba(other, data, there, rates, torques)[order]
    assert np.allclose(columns[0], right, rtol=0, atol=1e-9 * np.max(np.abs(right)))
    holds = pinocchio.computeGeneralizedGravity(other, data, there)[order]
    assert np.allclose(static_equilibrium(scene, q).torque, holds, rtol=0, atol=1e-9 * np.max(np.abs(holds)))
    view = Observation(model)
    view.look(work, q)
    pinocchio.framesForwardKinematics(other, data, there)
    seen = 0
    for n, part in enumerate(scene.links):
        name = part.name.rpartition("/")[2]
        if name == "start":
            continue
        frame = data.oMf[other.getFrameId(name, pinocchio.FrameType.BODY)]
        end = frame.act(np.array(part.end)) if "/" not in part.name else frame.translation
        assert np.allclose(view.link_end[n], end, rtol=0, atol=1e-9)
        seen += 1
    assert seen >= m


@pytest.mark.parametrize("seed", range(2))
def test_published_again_and_imported_again(seed):
    """The URDF that a scene publishes, imported, is the same robot: equal accelerations."""
    first = load_scene(imported(random_urdf(seed)))
    again = load_scene(imported(robot_description(first)))
    assert again.joint_names == first.joint_names
    m = len(first.joints)
    rng = np.random.default_rng(seed)
    q, v, effort = rng.uniform(-1, 1, m), rng.uniform(-1, 1, m), rng.uniform(-5, 5, m)
    found = np.zeros((2, m))
    for row, scene in zip(found, (first, again), strict=True):
        chain = build_model(scene).chain
        assert acceleration(chain, workspace(chain), q, v, effort, row) == 0
    assert np.allclose(found[0], found[1], rtol=0, atol=1e-9 * np.max(np.abs(found[0])))


def test_bending_link_weighs_what_it_weighed():
    """With a beam inside, the robot made rigid has the URDF's mass matrix: the rest rides on the end."""
    document = imported(ARM)
    add(document, {}, {"upper": "tube:0.03x0.002,aluminium,3"}, Account())
    scene = load_scene(document)
    assert build_model(scene).unknowns > 2
    stiff = load_scene(document, {"links.upper.flexible": False})
    # of Pinocchio's joints only continuous ones need no limits
    other, model = pinocchio.buildModelFromXML(ARM.replace("revolute", "continuous")), build_model(stiff)
    data, q = other.createData(), np.array([0.4, -0.7])
    there, _ = state(other, stiff.joint_names, q)
    columns, work = np.zeros((3, 2)), workspace(model.chain)
    for k, effort in enumerate([np.zeros(2), *np.eye(2)]):
        assert acceleration(model.chain, work, q, np.zeros(2), effort, columns[k]) == 0
    pinocchio.crba(other, data, there)
    mass = np.triu(data.M) + np.triu(data.M, 1).T
    assert np.allclose(np.linalg.inv(columns[1:] - columns[0]), mass, rtol=0, atol=1e-9 * np.max(mass))
