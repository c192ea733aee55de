"""A solved shape of the leaf: what it moved, its bow, its gaps."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SupportForce:
    """What one support bears: force on the leaf, N, positive away from the fire.

    points : of a stop, how many nodes of the leaf's edge touch it; None of a hinge or lock
    """

    name: str
    force: float
    points: int | None = None


@dataclass(frozen=True)
class Utilisation:
    """Where the leaf is nearest to its yield strength, or beyond it.

    share : von Mises stress over yield strength at the temperature there
    stress, strength : Pa; temperature : °C; position : m; material
    plastic_strain : the largest anywhere, -; None where yielding was not computed
    """

    share: float
    stress: float
    strength: float
    temperature: float
    position: tuple[float, float, float]
    material: str
    plastic_strain: float | None = None

    def __str__(self) -> str:
        x, y, z = self.position
        where = f"{self.material} at x {x:.3f}, y {y:.3f}, z {z:.4f} m, {self.temperature:.0f} °C"
        yielded = "" if self.plastic_strain is None else f"; plastic strain up to {self.plastic_strain:.2%}"
        return (
            f"{self.share:.2f} of the yield strength ({1e-6 * self.stress:.0f} of"
            f" {1e-6 * self.strength:.0f} MPa, {where}){yielded}"
        )


@dataclass(frozen=True)
class YieldState:
    """What a leaf that yields remembers: temperature, °C, and plastic strains xx, yy, xy at its points."""

    temperature: Array
    plastic_strain: Array


@dataclass(frozen=True)
class Deflection:
    """A solved shape.

    displacement (N, 3) : m, of the model's nodes
    bow : m, how far the leaf's middle stands out of the plane through its corners, positive
        towards the fire
    edge_gap : m, the largest distance by which each edge has left the frame's plane
    edge_place, edge_moved {edge: (E,)} : m along each edge, and out of the frame's plane there
    latch : the edge opposite to the hinges
    support_forces : of hinges, locks and the stop
    utilisation : of the yield strength, None where no material of the leaf has one
    state : where layers yield, what the next shape goes on from
    """

    displacement: Array
    bow: float
    edge_gap: dict[str, float]
    edge_place: dict[str, Array] = field(default_factory=dict)
    edge_moved: dict[str, Array] = field(default_factory=dict)
    latch: str = "right"
    support_forces: tuple[SupportForce, ...] = ()
    utilisation: Utilisation | None = None
    state: YieldState | None = None

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
