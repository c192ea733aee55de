"""A scene's rigid chain in Pinocchio, whose articulated-body algorithm is the rigid limit's
reference.
"""

from __future__ import annotations

import numpy as np
import pinocchio
from independent_chain import beam_axes, rotation_x

from flexsim_node.scene.schema import Link, Scene


def rotation_z(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def bodies(link: Link):
    """Rigid bodies of a link, in the link's frame."""
    along, axes = beam_axes(link)
    beam = link.beam
    if beam is not None:
        length = float(np.linalg.norm(along))
        mass = beam.density * beam.width * beam.depth * length
        x, y, z = length**2, beam.width**2, beam.depth**2
        inertia = axes @ np.diag([y + z, x + z, x + y]) @ axes.T * mass / 12
        yield pinocchio.Inertia(mass, -0.5 * along, inertia)
    for body in (link.rigid, link.payload):
        if body is not None and body.mass > 0:
            inertia = np.zeros((3, 3)) if body.inertia is None else np.array(body.inertia)
            yield pinocchio.Inertia(body.mass, np.array(body.center_of_mass), inertia)


def pinocchio_model(scene: Scene) -> pinocchio.Model:
    """The chain as Pinocchio's model; joint frames are turned by theta, so q = 0 is the scene's."""
    model = pinocchio.Model()
    model.gravity.linear = np.array(scene.gravity)
    ends = {-1: (0, pinocchio.SE3.Identity())}
    armature = []
    for n, link in enumerate(scene.links):
        joint, place = ends[scene.parents[n]]
        dh = link.dh
        place = place * pinocchio.SE3(rotation_z(dh.theta), np.zeros(3))
        if link.joint.type != "fixed":
            turns = link.joint.type == "revolute"
            kind = pinocchio.JointModelRZ() if turns else pinocchio.JointModelPZ()
            joint = model.addJoint(joint, kind, place, link.name)
            place = pinocchio.SE3.Identity()
            armature.append(link.joint.rotor_inertia * link.joint.gear_ratio**2)
        place = place * pinocchio.SE3(rotation_x(dh.alpha), np.array([dh.a, 0, dh.d]))
        ends[n] = joint, place
        for body in bodies(link):
            model.appendBodyToJoint(joint, body, place)
    model.armature = np.array(armature)
    return model


def friction(scene: Scene, velocity: np.ndarray) -> np.ndarray:
    """Viscous and smooth Coulomb friction; without the latter its speed does not matter."""
    return np.array(
        [
            -j.viscous_friction * v - j.coulomb_friction * np.tanh(v / (j.coulomb_speed or 1.0))
            for j, v in zip(scene.joints, velocity, strict=True)
        ]
    )
