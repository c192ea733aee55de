"""What holds a leaf, on its grid: the scene's hinges, locks and stop as held unknowns and bounds."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

from ..scene.schema import Scene
from ..scene.supports import Support, stop_of, supports
from .deflection import SupportForce
from .equilibrium import Equilibrium, Hold, joined

Array = NDArray[np.float64]


class Grid(Protocol):
    """What is held: a shell or bricks; see shell.py and solid.py."""

    lines: tuple[Array, Array, Array]
    held: NDArray[np.int64]

    def unknown(self, point: tuple[float, float, float]) -> int:
        """Number of the movement through the plane of the node nearest to a point."""

    def rigid_motions(self) -> Array:
        """Motions (n, 3) of the leaf as a rigid body: through its plane, turns w = x and w = y."""


class Holding:
    """The supports of a leaf, whose modelled part may be the half that its middle mirrors."""

    def __init__(self, scene: Scene, mirrored: bool) -> None:
        leaf, part = scene.leaf, scene.deformation
        self._whole = supports(leaf, part)
        self._points = supports(leaf, part, half=mirrored)
        self._stop = stop_of(part)
        self._mirrored = mirrored
        self._thickness = leaf.thickness
        self.loose = self._stop is not None or any(
            s.play > 0.0 or s.stiffness is not None for s in self._points
        )

    def held(self) -> list[tuple[tuple[float, float, float], tuple[int, ...]]]:
        """Points, m, and the axes along which they are simply held: all of them where nothing has play."""
        return [(self._at(s), tuple(a for a in s.axes if a < 2 or not self.loose)) for s in self._points]

    def place(self, grid: Grid) -> None:
        """Find the supports on a grid."""
        x, y, _ = grid.lines
        self._held, self._rigid = grid.held, grid.rigid_motions()
        self._unknown = [grid.unknown(self._at(s)) for s in self._points]
        top = float(y[-1])
        corners = (
            [(x[0], top), (x[-1], top)] if self._mirrored else [(x[0], y[0]), (x[-1], y[0]), (x[0], top)]
        )
        self._pinned = np.array([grid.unknown((a, b, self._thickness)) for a, b in corners])
        if self._mirrored:
            self._rigid = self._rigid[:, :2]
        self._holds = [
            Hold(
                unknown,
                -s.play,
                s.play,
                number,
                number,
                0.0 if s.stiffness is None else 1.0 / s.stiffness,
                self._share(s.y),
            )
            for number, (s, unknown) in enumerate(zip(self._points, self._unknown, strict=True))
        ]
        if self._stop is None:
            return
        lines = {
            "left": [(x[0], b) for b in y],
            "right": [(x[-1], b) for b in y],
            "top": [(a, top) for a in x],
            "bottom": [(a, y[0]) for a in x],
        }
        fire = self._stop.side < 0
        bound = (-self._stop.clearance, np.inf) if fire else (-np.inf, self._stop.clearance)
        face = 0.0 if fire else self._thickness
        seen: set[int] = set()
        for number, edge in enumerate(self._stop.edges, start=len(self._points)):
            for a, b in [] if self._mirrored and edge == "bottom" else lines[edge]:
                unknown = grid.unknown((float(a), float(b), face))
                if unknown not in seen:
                    seen.add(unknown)
                    self._holds.append(Hold(unknown, *bound, number, number, share=self._share(b)))

    def equilibrium(self, matrix: csc_matrix) -> Equilibrium:
        """The leaf of a stiffness (n, n), held."""
        if not self.loose:
            return Equilibrium(matrix, self._held)
        return Equilibrium(matrix, self._held, joined(self._holds), self._pinned, self._rigid)

    def support_forces(self, solved: Equilibrium, forces: Array, residual: Array) -> tuple[SupportForce, ...]:
        """What each support of the whole leaf bears.

        forces (m,) : of the holds on the modelled part, N
        residual (n,) : K u - f, N, which is the force where an unknown is simply held
        """
        count = len(self._points)
        edges = self._stop.edges if self._stop is not None else ()
        borne, touching = np.zeros(count + len(edges)), np.zeros(count + len(edges), dtype=int)
        for hold, force in zip(solved.holds, forces, strict=True):
            number = hold.at_low if force > 0.0 else hold.at_high
            if number < count:
                borne[number] += force / hold.share
            elif force != 0.0:
                # What touches an upright edge of the half touches the other half as well.
                both = self._mirrored and edges[number - count] in ("left", "right")
                borne[number] += 2.0 * force if both else force
                touching[number] += 2 if both and hold.share == 1.0 else 1
        if not self.loose:
            borne[:] = [
                residual[u] / self._unknown.count(u) / self._share(s.y)
                for s, u in zip(self._points, self._unknown, strict=True)
            ]
        found = []
        for s in self._whole:
            height = abs(s.y) if self._mirrored else s.y
            off = [np.hypot(p.x - s.x, p.y - height) for p in self._points]
            found.append(SupportForce(s.name, float(borne[int(np.argmin(off))])))
        for edge in edges:
            modelled = "top" if self._mirrored and edge == "bottom" else edge
            number = count + edges.index(modelled)
            found.append(SupportForce(f"stop, {edge} edge", float(borne[number]), int(touching[number])))
        return tuple(found)

    def _share(self, y: float) -> float:
        return 0.5 if self._mirrored and abs(y) < 1e-12 else 1.0

    def _at(self, s: Support) -> tuple[float, float, float]:
        return s.x, s.y, self._thickness
