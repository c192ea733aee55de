"""Static equilibrium: the shape and the torques that hold a robot still."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..equations.dynamics.tangent import forces
from ..model.chain import workspace
from ..model.model import build_model
from ..motion.assembly import Assembly
from ..motion.rest_shape import check_position, rest_shape, unknowns_at
from ..scene.schema import Scene
from ..sensors.observation import Observation
from .decide import decided


@dataclass(frozen=True)
class StaticEquilibrium:
    """A robot at rest.

    Attributes
    ----------
    torque : (m,) that holds the joints, N m or N
    node_displacement : (N, 6) in link frames, m and rad
    node_position : (N, 3), link_end : (L, 3) in the base frame, m
    """

    torque: np.ndarray
    node_displacement: np.ndarray
    node_position: np.ndarray
    link_end: np.ndarray


def static_equilibrium(scene: Scene, position: np.ndarray | list[float]) -> StaticEquilibrium:
    """Shape and holding torques with the joints at `position` (m,).

    With loops the actuated joints are held and the passive ones' positions are guesses.

    Raises
    ------
    ArithmeticError
        where no equilibrium is found (the links buckle under their load)
    SceneError
        where a loop can't be closed
    """
    # all joints are held: `auto` then means root, as for any prescribed motion
    driven = scene.joint_names if scene.erls.zeroed == "auto" else ()
    model = build_model(decided(scene), driven=driven)
    q = check_position(scene, position)
    view = Observation(model)
    if scene.loops:
        assembly = Assembly(model)
        x, push = assembly.rest(unknowns_at(model, q), model.actuated)
        torque = np.where(model.actuated, -assembly.force(x, push)[model.turned], 0.0)
    else:
        x = rest_shape(model, q)
        torque = -forces(model, x)[model.turned]
    view.look(workspace(model.chain), x)
    return StaticEquilibrium(torque, view.displacement, view.position, view.link_end)
