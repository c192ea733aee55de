"""Degrees of freedom of a scene's nodes: x, y, z and the rotations about them, or those of the plane."""

from __future__ import annotations

import numpy as np

from ..scene.load import Scene
from ..scene.schema import Link, Payload
from .erls import joint_axis
from .loops import flat

PLANAR_DOFS = [0, 1, 5]


def is_planar(scene: Scene) -> bool:
    """Whether nothing in the scene can leave the plane of its joints."""

    def level(body: Payload | None) -> bool:
        if body is None or body.mass == 0.0:
            return True
        i = body.inertia
        return body.center_of_mass[2] == 0.0 and (i is None or (i[0][2] == 0.0 and i[1][2] == 0.0))

    zeroed = scene.erls.zeroed
    return (
        (scene.gravity[2] == 0.0 or not scene.effects.gravity)
        and all(
            _in_plane(link) and link.joint.type != "prismatic" and level(link.payload) and level(link.rigid)
            for link in scene.links
        )
        and all(flat(loop) for loop in scene.loops)
        and (isinstance(zeroed, str) or all(z.dof in ("x", "y", "rz") for z in zeroed))
    )


def _in_plane(link: Link) -> bool:
    """Whether a link stays in the plane in which it begins."""
    if link.frame is None:
        return abs(link.dh.alpha) < 1e-12 and link.dh.d == 0.0
    level = link.frame.rpy[0] == link.frame.rpy[1] == 0.0 and (link.end is None or link.end[2] == 0.0)
    return level and bool(joint_axis(link)[2] == 1.0)


def follow(comp: int, length: float) -> np.ndarray:
    """(12,) dependency of a dof that moves with the node before as with a rigid body."""
    row = np.zeros(12)
    row[6 + comp] = 1.0
    if comp == 1:
        row[6 + 5] = length
    if comp == 2:
        row[6 + 4] = -length
    return row
