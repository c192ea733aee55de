"""The robot's links drawn as tubes: a smooth curve through each link's nodes, and a skin on it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

SIDES = 8
POINTS_PER_LINK = 12
THIN, ALONE = 0.5, 0.005  # radius of what has no section: of the thinnest beam's; m where there is none
LAYOUT_FIELDS = ["node_names", "segments", "segment_width", "segment_depth"]

Array = NDArray[np.float32]


@dataclass(frozen=True)
class Skeleton:
    """Where a robot's nodes are and how they are joined, as ElasticLayout says.

    Attributes
    ----------
    node_names : tuple of N str
    segments : tuple of (first, second) node indices
    radius : ndarray (S,), m
        Of the circle with the area of each segment's section; rigid links, which have none, are thin.
    outer : ndarray (S,), m
        From each section's middle to its outermost fibre.
    """

    node_names: tuple[str, ...]
    segments: tuple[tuple[int, int], ...]
    radius: NDArray[np.float64]
    outer: NDArray[np.float64]

    @classmethod
    def from_layout(cls, layout: Mapping[str, NDArray]) -> Skeleton:
        """Read columns of ElasticLayout messages, the last of which counts."""
        width, depth = layout["segment_width"][-1], layout["segment_depth"][-1]
        radius = np.sqrt(width * depth / np.pi)
        drawn = radius > 0.0
        return cls(
            node_names=tuple(layout["node_names"][-1]),
            segments=tuple((int(a), int(b)) for a, b in layout["segments"][-1].reshape(-1, 2)),
            radius=np.where(drawn, radius, THIN * radius[drawn].min() if drawn.any() else ALONE),
            outer=np.maximum(width, depth) / 2.0,
        )

    @property
    def chains(self) -> list[list[int]]:
        """Segments that follow one another: lists of segment indices, one a link."""
        chains: list[list[int]] = []
        for i, (first, _) in enumerate(self.segments):
            if chains and self.segments[chains[-1][-1]][1] == first and self.same_link(i):
                chains[-1].append(i)
            else:
                chains.append([i])
        return chains

    def rigid(self) -> Skeleton:
        """Return the same robot with each link one straight segment from end to end."""
        return Skeleton(
            self.node_names,
            tuple((self.segments[c[0]][0], self.segments[c[-1]][1]) for c in self.chains),
            np.array([self.radius[c].mean() for c in self.chains]),
            np.array([self.outer[c].max() for c in self.chains]),
        )

    def same_link(self, segment: int) -> bool:
        """Say whether a segment goes on in the link of the one before it."""
        before, here = self.segments[segment - 1][1], self.segments[segment][1]
        return self.node_names[before].rpartition("/")[0] == self.node_names[here].rpartition("/")[0]


class Tube:
    """Turns node positions into a skin.

    Each link's curve goes through its nodes; between them the elastic displacement is a
    polynomial along the link, as smooth as the nodes allow. All frames are done at once.

    Parameters
    ----------
    skeleton : Skeleton
    """

    def __init__(self, skeleton: Skeleton) -> None:
        self.nodes = len(skeleton.node_names)
        rows, radii, starts = [np.zeros((0, self.nodes))], [np.zeros(0)], [0]
        for chain in skeleton.chains:
            nodes = [skeleton.segments[chain[0]][0]] + [skeleton.segments[s][1] for s in chain]
            weights = curve_weights(len(nodes))
            block = np.zeros((len(weights), self.nodes))
            block[:, nodes] = weights
            rows.append(block)
            fine = (len(weights) - 1) // len(chain)
            segment = np.minimum(np.arange(len(weights)) // fine, len(chain) - 1)
            radii.append(skeleton.radius[np.asarray(chain)[segment]])
            starts.append(starts[-1] + len(weights))
        self.weights = np.concatenate(rows).astype(np.float32)  # (P, N)
        self.radii = np.concatenate(radii).astype(np.float32)  # (P,)
        self.starts = starts
        skins = [skin(a, b - a) for a, b in pairwise(starts)]
        self.triangles = np.concatenate([np.zeros((0, 3), np.uint32), *skins])

    def centre(self, nodes: NDArray[np.floating]) -> Array:
        """Return the curve's points: nodes (K, N, 3) in, (K, P, 3) out, m."""
        return np.einsum("pn,knx->kpx", self.weights, nodes.astype(np.float32), optimize=True)

    def vertices(self, centre: Array, swell: float = 1.0) -> tuple[Array, Array]:
        """Return the skin's vertices and normals.

        Parameters
        ----------
        centre : ndarray (K, P, 3), m
        swell : float
            Factor on the radius.

        Returns
        -------
        vertices, normals : ndarray (K, P * SIDES, 3)
        """
        tangent = np.empty_like(centre)
        for a, b in pairwise(self.starts):
            tangent[:, a:b] = np.gradient(centre[:, a:b], axis=1)
        tangent /= np.maximum(np.linalg.norm(tangent, axis=2, keepdims=True), 1e-12)
        # Any direction that is not along the link starts the ring; one a link, so no ring twists.
        across = np.empty_like(centre)
        for a, b in pairwise(self.starts):
            chord = tangent[:, a:b].mean(axis=1)
            least = np.eye(3, dtype=np.float32)[np.abs(chord).argmin(axis=1)]
            across[:, a:b] = np.cross(tangent[:, a:b], least[:, None, :])
        across /= np.maximum(np.linalg.norm(across, axis=2, keepdims=True), 1e-12)
        third = np.cross(tangent, across)
        angle = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False, dtype=np.float32)
        normals = (
            np.cos(angle)[:, None] * across[:, :, None, :] + np.sin(angle)[:, None] * third[:, :, None, :]
        )
        vertices = centre[:, :, None, :] + swell * self.radii[:, None, None] * normals
        shape = (len(centre), -1, 3)
        return vertices.reshape(shape), normals.reshape(shape)

    def over_vertices(self, values: NDArray) -> NDArray:
        """Spread values (K, P) of the curve's points over the skin: (K, P * SIDES)."""
        return np.repeat(values, SIDES, axis=1)


def curve_weights(nodes: int) -> NDArray[np.float64]:
    """Return the weights (P, nodes) of a link's nodes in its curve's points.

    Two nodes give a straight line, three a parabola, more a cubic through the four nearest.
    """
    # A straight line needs its ends only; a fine mesh is as smooth as its nodes.
    fine = 1 if nodes == 2 else max(1, POINTS_PER_LINK // (nodes - 1))
    points = np.linspace(0.0, nodes - 1.0, fine * (nodes - 1) + 1)
    weights = np.zeros((points.size, nodes))
    order = min(nodes, 4)
    for row, s in zip(weights, points, strict=True):
        first = int(np.clip(np.floor(s) - (order - 2) // 2, 0, nodes - order))
        window = np.arange(first, first + order)
        for i in window:
            others = window[window != i]
            row[i] = np.prod((s - others) / (i - others))
    return weights


def skin(start: int, points: int) -> NDArray[np.uint32]:
    """Return the triangles (T, 3) between the rings of one link's curve, and over its ends."""
    ring = np.arange(SIDES)
    nearby = (ring + 1) % SIDES
    a = (start + np.arange(points - 1))[:, None] * SIDES
    quad = [a + ring, a + nearby, a + SIDES + ring, a + SIDES + nearby]
    first = np.stack([quad[0], quad[1], quad[2]], axis=-1).reshape(-1, 3)
    second = np.stack([quad[1], quad[3], quad[2]], axis=-1).reshape(-1, 3)
    fan = np.stack([np.zeros(SIDES - 2, int), ring[1:-1], ring[2:]], axis=-1)
    caps = [start * SIDES + fan[:, ::-1], (start + points - 1) * SIDES + fan]
    return np.concatenate([first, second, *caps]).astype(np.uint32)
