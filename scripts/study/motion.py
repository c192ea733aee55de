"""A motion of tips and joints over time, as studies compare it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .point import Array


@dataclass(frozen=True)
class Motion:
    """The tips (K, tips, 3), m, and the joints (K, m), rad or m, over time."""

    tip: Array
    angle: Array

    @property
    def size(self) -> Array:
        """How far from the origin it goes, m, and rad or m."""
        reach = np.max(np.linalg.norm(self.tip, axis=-1), initial=0.0)
        return np.array([float(reach), float(np.max(np.abs(self.angle), initial=0.0))])

    def beyond(self, coarser: Motion, order: float) -> Motion:
        """Extrapolated to no step, or no element, from this one and one of twice that (Richardson)."""
        n = 2.0**order
        return Motion((n * self.tip - coarser.tip) / (n - 1.0), (n * self.angle - coarser.angle) / (n - 1.0))

    def shifted(self, start: Motion, end: Motion) -> Motion:
        """This motion changed by what leads from `start` to `end`."""
        return Motion(self.tip + end.tip - start.tip, self.angle + end.angle - start.angle)

    def apart(self, other: Motion) -> Array:
        """Largest distance of a tip, m, and of any joint, rad or m."""
        return np.array([far(self.tip, other.tip), float(np.max(np.abs(self.angle - other.angle)))])


def far(a: Array, b: Array) -> float:
    """The largest distance between two sets of paths (K, ..., 3), m."""
    return float(np.max(np.linalg.norm(a - b, axis=-1)))
