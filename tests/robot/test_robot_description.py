"""The URDF is the scene's rigid robot: mass, inertia and kinematics, as Pinocchio reads it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from flexsim_node import load_scene
from flexsim_node.model.chain import workspace
from flexsim_node.model.model import build_model
from flexsim_node.sensors.observation import Observation
from flexsim_node.service.robot_description import rigid_inertia, robot_description

CONFIG = Path(__file__).parents[2] / "config"
SCENES = [
    "anthropomorphic_geared",
    "anthropomorphic_spherical_wrist",
    "dlr_spherical_wrist",
    "planar_double_pendulum",
    "spatial_double_pendulum",
]


@pytest.mark.parametrize("name", SCENES)
def test_mass_inertia_and_kinematics(name: str) -> None:
    """Of the whole robot at random angles: ends of links, total mass, centre of mass, spatial inertia."""
    scene = load_scene(CONFIG / f"{name}.yaml")
    model = pin.buildModelFromXML(robot_description(scene))
    data = model.createData()
    assert [j for j in model.names if j != "universe"] == list(scene.joint_names)
    ours = build_model(scene)
    work, view = workspace(ours.chain), Observation(ours)
    rng = np.random.default_rng(3)
    for _ in range(5):
        q = rng.uniform(-1.5, 1.5, ours.joints)
        x = np.zeros(ours.unknowns)
        x[: ours.joints] = q
        view.look(work, x)
        given = []
        for k, joint in enumerate(scene.joints):
            given += [q[k]] if joint.type == "prismatic" else [np.cos(q[k]), np.sin(q[k])]
        pin.forwardKinematics(model, data, np.array(given))
        pin.updateFramePlacements(model, data)
        frames = [*(link.name for link in scene.links[1:]), "tip"]  # a URDF link's frame is at its joint
        places = [data.oMf[model.getFrameId(frame)].translation for frame in frames]
        np.testing.assert_allclose(places, view.rigid_position[view.ends], atol=1e-9)
        pin.centerOfMass(model, data, np.array(given))
        mass = sum(rigid_inertia(link)[0] for link in scene.links)
        base = scene.links[0].joint.type == "fixed"
        if not base:
            assert data.mass[0] == pytest.approx(mass, rel=1e-9)
        # the weight's torques: centre of mass and mass of every link at once
        rigid = pin.computeGeneralizedGravity(model, data, np.array(given))
        energy = []
        for k in range(ours.joints):
            shifted = []
            for step in (-1e-5, 1e-5):
                x[: ours.joints] = q
                x[k] += step
                view.look(work, x)
                total = 0.0
                for n, link in enumerate(scene.links):
                    body_mass, centre, _ = rigid_inertia(link)
                    frame = view.pose[n, 3:].reshape(3, 3) @ ours.axes[n].T
                    end = np.array([link.dh.a, 0.0, link.dh.d])
                    turned = pose_of_joint(frame, link) @ (centre - end)
                    total += 9.81 * body_mass * (view.rigid_position[view.ends[n]] + turned)[2]
                shifted.append(total)
            energy.append((shifted[1] - shifted[0]) / 2e-5)
        np.testing.assert_allclose(rigid, energy, atol=1e-5)


def pose_of_joint(frame: np.ndarray, link) -> np.ndarray:
    """Rotation of a link's URDF frame, which lacks the turn by alpha that Denavit and Hartenberg end with."""
    c, s = np.cos(link.dh.alpha), np.sin(link.dh.alpha)
    return frame @ np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]).T


def test_inertia_of_a_link() -> None:
    """A box of steel about its own centre, as a handbook has it."""
    scene = load_scene(CONFIG / "anthropomorphic_geared.yaml")
    mass, centre, inertia = rigid_inertia(scene.links[1])
    w, d, length = 0.01, 0.03, 0.5
    assert mass == pytest.approx(7800.0 * w * d * length)
    np.testing.assert_allclose(centre, [0.25, 0.0, 0.0], atol=1e-12)
    expected = mass / 12.0 * np.array([w**2 + d**2, length**2 + d**2, length**2 + w**2])
    np.testing.assert_allclose(np.diag(inertia), expected, rtol=1e-9)
