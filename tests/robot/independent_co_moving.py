"""The co-moving formulation by the road of independent_chain.py: Lagrange's equations of sampled points.

Every element has a frame of its own, turned from the section before it by half of the element's end rotation;
rotations are sums of the exponential series, and all derivatives complex steps.
"""

from __future__ import annotations

import numpy as np
from independent_chain import (
    IndependentChain,
    Moving,
    build_body,
    build_element,
    cross_matrix,
    rotation_x,
    rotation_z,
)

from flexsim_node.scene.load import Scene


def exponential(t: np.ndarray, rate: np.ndarray) -> Moving:
    """exp([t]x) with its rate, by the series."""
    x = Moving(cross_matrix(t), cross_matrix(rate))
    total = term = Moving(np.eye(3))
    for k in range(1, 30):
        term = term @ x
        term = Moving(term.value / k, term.rate / k)
        total = total + term
    return total


class IndependentCoMoving(IndependentChain):
    """Mass matrix, forces and accelerations of a scene's chain with `formulation: co_moving`."""

    def __init__(self, scene: Scene, planar: bool = False) -> None:
        super().__init__(scene, planar)
        self.turning = False
        for k, (link, along, axes, step, own, nodes, elements, bodies) in enumerate(self.links):
            flexible = bool(link.beam is not None and link.flexible)
            elements = [build_element(scene, link, 0.0, step, flexible, False) for _ in elements]
            bodies = [build_body(b, 0.0, axes, False) for b in (link.rigid, link.payload) if b and b.mass > 0]
            self.links[k] = (link, along, axes, step, own, nodes, elements, bodies)

    def motion(self, z: np.ndarray, zd: np.ndarray) -> list:
        """(part, origin, basis, rows (12,)) of every element and body, each but the part Moving."""
        return self.walk(z, zd)[0]

    def walk(self, z: np.ndarray, zd: np.ndarray) -> tuple[list, dict]:
        """`motion`, and where each link's end is (-1 the base), turned as its frame, not as its beam."""
        ends = {-1: (Moving(np.zeros(3)), Moving(np.eye(3)))}
        k, out = 0, []
        for n, (link, _, axes, step, _, nodes, elements, bodies) in enumerate(self.links):
            origin, section = ends[self.scene.parents[n]]
            q = qd = 0.0
            if link.joint.type != "fixed":
                q, qd, k = z[k], zd[k], k + 1
            revolute, slides = link.joint.type == "revolute", link.joint.type == "prismatic"
            origin = origin + section @ Moving(
                [0.0, 0.0, q if slides else 0.0], [0, 0, qd if slides else 0.0]
            )
            section = section @ rotation_z(link.dh.theta + (q if revolute else 0.0), qd if revolute else 0.0)
            basis = section @ Moving(rotation_x(link.dh.alpha) @ axes)
            for i, (place, *_) in enumerate(nodes):
                y, yd = np.zeros(6, dtype=complex), np.zeros(6, dtype=complex)
                for j, p in place.items():
                    y[j], yd[j] = z[p], zd[p]
                # stretch, chord about y and z from the start, twist, end about y and z from the chord
                to_chord = [np.array([0.5 * w[3], w[2], w[1]]) for w in (y, yd)]
                to_end = [np.array([0.5 * w[3], w[4], w[5]]) for w in (y, yd)]
                basis = basis @ exponential(*to_chord)
                stretch = [np.array([w[0], 0.0 * w[0], 0.0 * w[0]]) for w in (y, yd)]
                if i < len(elements):
                    rows = [
                        np.concatenate([np.zeros(3), -b, u, c])
                        for u, b, c in zip(stretch, to_chord, to_end, strict=True)
                    ]
                    out.append((elements[i], origin, basis, Moving(*rows)))
                origin = origin + basis @ Moving(np.array([step, 0.0, 0.0]) + stretch[0], stretch[1])
                basis = basis @ exponential(*to_end)
            out += [(body, origin, basis, Moving(np.zeros(12), np.zeros(12))) for body in bodies]
            ends[n] = origin, basis @ Moving(axes.T)
        return out, ends

    def on_ends(self, z: np.ndarray, zd: np.ndarray):
        """independent_chain.py's, on the rigid sections there."""
        _, ends = self.walk(z, zd)

        def on_end(n: int, vector, point: bool) -> Moving:
            origin, section = ends[n]
            return origin + section @ Moving(vector) if point else section @ Moving(vector)

        return on_end

    def pieces(self, motion: list):
        """(element or body, origin, basis, rows (12,)) one after the other."""
        return motion

    def softening_force(self, z: np.ndarray, zd: np.ndarray) -> np.ndarray:
        """Nothing: the frames' geometry holds softening and stiffening, which can't be left out."""
        return np.zeros(self.unknowns)

    def damping_force(self, z: np.ndarray, zd: np.ndarray) -> np.ndarray:
        """alpha M on the velocities with the joints at rest, beta K on the strains' rates, each by its own
        virtual work."""
        alpha, beta = self.damping
        points = self.velocities(z, self.elastic_rates(zd)).real
        strain = self.strain(z, zd).rate.real
        force = np.zeros(self.unknowns)
        for k, unit in enumerate(np.eye(self.unknowns)):
            force[k] -= alpha * (self.velocities(z, self.elastic_rates(unit)).real @ points)
            force[k] -= beta * (self.strain(z, unit).rate.real @ strain)
        return force
