"""The two robots that peers are compared on, and the motion that is right."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

DATA = Path(__file__).resolve().parents[2] / "tests" / "robot" / "data"
YOUNG = 2.0e11


@dataclass(frozen=True)
class Link:
    """A straight steel beam: length, m; its direction at the start; its sides, m, along y and z, where z
    is the last joint's axis and y = z x direction."""

    length: float
    direction: tuple[float, float, float]
    side_y: float
    side_z: float

    @property
    def area(self) -> float:
        return self.side_y * self.side_z

    @property
    def bending(self) -> tuple[float, float, float]:
        """Torsion constant and the second moments about y and z, m4."""
        long, short = max(self.side_y, self.side_z), min(self.side_y, self.side_z)
        ratio = short / long
        torsion = long * short**3 * (1.0 / 3.0 - 0.21 * ratio * (1.0 - ratio**4 / 12.0))
        return torsion, self.side_y * self.side_z**3 / 12.0, self.side_z * self.side_y**3 / 12.0


@dataclass(frozen=True)
class Problem:
    """links, the axes (base frame, at the start) of the joints at their beginnings, gravity, and

    torque : amplitude, N m, of a sine of 1 Hz on the first joint
    section_inertia : whether the sections' own inertia is counted
    reference (K, 1 + 3): time and tip
    """

    name: str
    links: tuple[Link, ...]
    axes: tuple[tuple[float, float, float], ...]
    gravity: tuple[float, float, float]
    density: float
    poisson: float
    torque: float
    section_inertia: bool
    reference: np.ndarray

    @property
    def duration(self) -> float:
        return float(self.reference[-1, 0])

    @property
    def period(self) -> float:
        return float(self.reference[1, 0] - self.reference[0, 0])

    def error(self, tip: np.ndarray) -> float:
        """The largest distance (m) of a tip (K, 3) from the reference."""
        if tip.shape != self.reference[:, 1:].shape or not np.all(np.isfinite(tip)):
            return float("inf")
        return float(np.max(np.linalg.norm(tip - self.reference[:, 1:], axis=1)))


def falling() -> Problem:
    """The thesis' planar robot of steel (table 2.3), released from horizontal."""
    table = np.loadtxt(DATA / "falling_two_link_steel.csv", delimiter=",", comments="#")
    tip = np.column_stack([table[:, 0], table[:, 3:5], np.zeros(len(table))])
    return Problem(
        "falling two-link robot",
        (Link(0.5, (1, 0, 0), 0.03, 0.01), Link(0.5, (1, 0, 0), 0.01, 0.03)),
        ((0, 0, 1), (0, 0, 1)),
        (0.0, -9.81, 0.0),
        7840.0,
        0.3,
        0.0,
        False,
        tip,
    )


def driven() -> Problem:
    """The thesis' anthropomorphic robot of steel (table 2.2), its first joint driven by 5 sin(2 pi t)."""
    table = np.loadtxt(DATA / "driven_anthropomorphic_steel.csv", delimiter=",", comments="#")
    tip = np.column_stack([table[:, 0], table[:, -3:]])
    return Problem(
        "driven anthropomorphic robot",
        (
            Link(0.5, (0, 0, 1), 0.01, 0.03),
            Link(0.5, (1, 0, 0), 0.01, 0.03),
            Link(0.5, (1, 0, 0), 0.01, 0.03),
        ),
        ((0, 0, 1), (0, -1, 0), (0, -1, 0)),
        (0.0, 0.0, -9.81),
        7800.0,
        0.33,
        5.0,
        True,
        tip,
    )
