"""Where the links' ends are and how they move, bending included."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..equations.dynamics.acceleration import acceleration
from ..model.chain import workspace
from ..model.model import Model
from ..sensors.observation import Observation

# s; positions are followed so far along the motion to difference them: error below 1e-7 of the value.
SHORT = 1e-4


@dataclass(frozen=True)
class LinkMotion:
    """Motion of L links' ends in the base frame; SI units.

    Attributes
    ----------
    position, velocity, acceleration : (L, 3) m, m/s, m/s2
    rotation : (L, 3, 3) from the bent link's end frame (Denavit-Hartenberg's, turned with the beam)
    angular_velocity, angular_acceleration : (L, 3) rad/s, rad/s2
    """

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    rotation: np.ndarray
    angular_velocity: np.ndarray
    angular_acceleration: np.ndarray


def link_motion(model: Model, x: np.ndarray, v: np.ndarray, torque: np.ndarray) -> LinkMotion:
    """Motion of every link's end at unknowns x (n,), rates v (n,), torque (m,).

    It works on arrays of its own, so that a thread may ask while another one steps.
    """
    work = workspace(model.chain)
    a = np.zeros_like(x)
    acceleration(model.chain, work, x, v, torque, a)
    view = Observation(model)
    places, turns = [], []
    for t in (-SHORT, 0.0, SHORT):
        view.look(work, x + t * v + 0.5 * t**2 * a)
        places.append(view.link_end.copy())
        turns.append(end_rotations(model, view))
    before, now, after = places
    spin_before, spin_after = (
        np.array([rotation_vector(late @ early.T) for early, late in zip(*pair, strict=True)]) / SHORT
        for pair in ((turns[0], turns[1]), (turns[1], turns[2]))
    )
    return LinkMotion(
        position=now,
        velocity=(after - before) / (2.0 * SHORT),
        acceleration=(after - 2.0 * now + before) / SHORT**2,
        rotation=turns[1],
        angular_velocity=0.5 * (spin_after + spin_before),
        angular_acceleration=(spin_after - spin_before) / SHORT,
    )


def end_rotations(model: Model, view: Observation) -> np.ndarray:
    """(L, 3, 3) rotation of every link's end, the elastic rotation included."""
    turns = np.empty((len(view.ends), 3, 3))
    for n, end in enumerate(view.ends):
        frame = view.pose[n, 3:].reshape(3, 3) @ model.axes[n].T
        turns[n] = rotation_matrix(frame @ view.displacement[end, 3:]) @ frame
    return turns


def rotation_matrix(vector: np.ndarray) -> np.ndarray:
    """(3, 3) rotation by a vector (3,), rad (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    x, y, z = vector
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    # sin(a)/a and (1 - cos a)/a^2, whose series is exact to rounding where a is small
    first, second = (
        (1.0 - angle**2 / 6.0, 0.5 - angle**2 / 24.0)
        if angle < 1e-4
        else (np.sin(angle) / angle, (1.0 - np.cos(angle)) / angle**2)
    )
    return np.asarray(np.eye(3) + first * cross + second * cross @ cross)


def rotation_vector(turn: np.ndarray) -> np.ndarray:
    """(3,) rad, of a rotation by much less than pi."""
    axis = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    sine = float(np.linalg.norm(axis))
    return axis if sine < 1e-9 else axis * (np.arcsin(min(1.0, sine)) / sine)
