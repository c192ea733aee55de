"""A solved shape of the leaf: what it moved, its bow, its gaps."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Deflection:
    """A solved shape.

    displacement (N, 3) : m, of the model's nodes
    bow : m, how far the leaf's middle stands out of the plane through its corners, positive
        towards the fire
    edge_gap : m, the largest distance by which each edge has left the frame's plane
    edge_place, edge_moved {edge: (E,)} : m along each edge, and out of the frame's plane there
    latch : the edge opposite to the hinges
    """

    displacement: Array
    bow: float
    edge_gap: dict[str, float]
    edge_place: dict[str, Array] = field(default_factory=dict)
    edge_moved: dict[str, Array] = field(default_factory=dict)
    latch: str = "right"

    @property
    def gap(self) -> float:
        """The largest gap of any edge, m."""
        return max(self.edge_gap.values())

    @property
    def largest(self) -> float:
        """Largest displacement through the leaf's plane, m."""
        return float(np.abs(self.displacement[:, 2]).max())

    def lasting_gap(self, length: float) -> float:
        """The largest gap, m, that some stretch of an edge, `length` m long, exceeds throughout."""
        best = 0.0
        for name, place in self.edge_place.items():
            fine = np.linspace(place[0], place[-1], 401)
            gap = np.interp(fine, place, np.abs(self.edge_moved[name]))
            count = min(len(fine), int(np.ceil(length / (fine[1] - fine[0]))) + 1)
            windows = np.lib.stride_tricks.sliding_window_view(gap, count)
            best = max(best, float(windows.min(axis=1).max()))
        return best
