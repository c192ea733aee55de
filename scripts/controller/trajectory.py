"""A wanted motion: points in time, joined by cubics (trajectory_msgs/JointTrajectory)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .shaping import Shaper

Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Trajectory:
    """Positions and velocities at K times; at rest before the first and after the last.

    Attributes
    ----------
    time : (K,) s, rising
    position, velocity : (K, m) rad or m, and their rates
    """

    time: Vector
    position: Vector
    velocity: Vector

    def at(self, t: float) -> tuple[Vector, Vector]:
        """Wanted position and velocity (m,) at time t, s."""
        time = self.time
        k = int(np.clip(np.searchsorted(time, t, side="right") - 1, 0, len(time) - 2))
        h = time[k + 1] - time[k]
        s = np.clip((t - time[k]) / h, 0.0, 1.0)
        inside = time[0] <= t <= time[-1]
        start, end = self.position[k], self.position[k + 1]
        slope, last = h * self.velocity[k], h * self.velocity[k + 1]
        jump = end - start
        # Hermite's cubic
        square, cube = 3.0 * jump - 2.0 * slope - last, slope + last - 2.0 * jump
        position = start + s * (slope + s * (square + s * cube))
        velocity = (slope + s * (2.0 * square + 3.0 * s * cube)) / h
        return position, velocity if inside else np.zeros_like(velocity)

    def shaped(self, shaper: Shaper, t: float) -> tuple[Vector, Vector]:
        """The same, convolved with a shaper's impulses: late by its length, but without what it takes out."""
        parts = [self.at(t - delay) for delay in shaper.times]
        position = np.sum([a * p for a, (p, _) in zip(shaper.amplitudes, parts, strict=True)], axis=0)
        velocity = np.sum([a * v for a, (_, v) in zip(shaper.amplitudes, parts, strict=True)], axis=0)
        return position, velocity
