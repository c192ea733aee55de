"""Joint PD control with gravity feed-forward, on a move from rest to rest and back."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flexsim_node import Scene, static_equilibrium

Vector = NDArray[np.float64]
# Gravity's torques are tabulated along the path; between so many places they are nearly straight.
GRAVITY_PLACES = 41


@dataclass(frozen=True)
class Move:
    """From `start` to `goal` and back, each from rest to rest in `time` s.

    Velocity rises and falls linearly: the jumps of acceleration at the ends and in the middle are
    what excites vibration.

    Attributes
    ----------
    start, goal : (m,) rad or m
    there, back : s, when each way begins
    time : s that each way takes
    """

    start: tuple[float, ...]
    goal: tuple[float, ...]
    there: float
    back: float
    time: float

    def along(self, t: float | Vector) -> tuple[Vector, Vector]:
        """Return the part of the way covered, 0 to 1, and its rate, 1/s, at time t."""
        ahead, ahead_rate = ramp((np.asarray(t, dtype=float) - self.there) / self.time)
        behind, behind_rate = ramp((np.asarray(t, dtype=float) - self.back) / self.time)
        return ahead - behind, (ahead_rate - behind_rate) / self.time

    def position(self, t: float | Vector) -> Vector:
        """Return the wanted joint positions (..., m)."""
        part, _ = self.along(t)
        way = np.subtract(self.goal, self.start)
        return np.asarray(self.start + part[..., None] * way)

    def velocity(self, t: float | Vector) -> Vector:
        """Return the wanted joint velocities (..., m)."""
        _, rate = self.along(t)
        return np.asarray(rate[..., None] * np.subtract(self.goal, self.start))


def ramp(s: Vector) -> tuple[Vector, Vector]:
    """Rise from 0 to 1 while s does, at constant acceleration, then deceleration; and the slope."""
    s = np.clip(s, 0.0, 1.0)
    rising = s < 0.5
    value = np.where(rising, 2.0 * s**2, 1.0 - 2.0 * (1.0 - s) ** 2)
    return value, np.where(rising, 4.0 * s, 4.0 * (1.0 - s))


class JointPd:
    """The control law.

    Parameters
    ----------
    scene : Scene
        Whose weight is fed forward.
    move : Move
    stiffness, damping : (m,), N m/rad and N m s/rad
    """

    def __init__(self, scene: Scene, move: Move, stiffness: Vector, damping: Vector) -> None:
        m = len(scene.joint_names)
        for name, given in (("start", move.start), ("goal", move.goal),
                            ("stiffness", stiffness), ("damping", damping)):  # fmt: skip
            if len(given) != m:
                raise ValueError(f"{name} has {len(given)} values for {m} joints; give one a joint")
        self.move = move
        self.stiffness, self.damping = np.asarray(stiffness), np.asarray(damping)
        self._places = np.linspace(0.0, 1.0, GRAVITY_PLACES)
        way = np.subtract(move.goal, move.start)
        self._gravity = np.array(
            [static_equilibrium(scene, move.start + s * way).torque for s in self._places]
        )

    def torque(self, t: float, position: Vector, velocity: Vector) -> Vector:
        """Return the torque (m,) for the state (m,), (m,) measured at time t."""
        part, _ = self.move.along(t)
        gravity = [np.interp(part, self._places, column) for column in self._gravity.T]
        return np.asarray(
            gravity
            + self.stiffness * (self.move.position(t) - position)
            + self.damping * (self.move.velocity(t) - velocity)
        )
