"""The skin of a door leaf: what of its bricks is seen from outside, bent and coloured."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# Corners of a VTK_HEXAHEDRON's six faces, each counter-clockwise seen from outside, and which way
# they look: x, y, z of the leaf, which is a box.
FACES = np.array([[0, 3, 2, 1], [4, 5, 6, 7], [0, 4, 7, 3], [1, 2, 6, 5], [0, 1, 5, 4], [3, 7, 6, 2]])
NORMALS = np.array([[0, 0, -1], [0, 0, 1], [-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0]], dtype=np.float32)
FIRE_SIDE, UNEXPOSED_SIDE = 0, 1
EDGES = (2, 3, 4, 5)


@dataclass(frozen=True)
class Skin:
    """One side of the leaf with its edges.

    Attributes
    ----------
    node (V,) : the node that each vertex is
    triangles (T, 3) : of vertices
    normals (V, 3)
    """

    node: NDArray[np.int64]
    triangles: NDArray[np.uint32]
    normals: NDArray[np.float32]


def skins(hexahedra: NDArray[np.integer]) -> tuple[Skin, Skin]:
    """Return the skins of the fire's side and of the unexposed side from bricks (C, 8)."""
    quads = hexahedra[:, FACES].astype(np.int64)  # (C, 6, 4)
    # Two bricks share each inner face.
    key = np.sort(quads.reshape(-1, 4), axis=1)
    _, which, count = np.unique(key, axis=0, return_inverse=True, return_counts=True)
    outside = (count[which.ravel()] == 1).reshape(quads.shape[:2])
    sides = [quads[outside[:, side], side] for side in range(len(FACES))]
    fire, unexposed = (
        _joined([(side, sides[side]) for side in (first, *EDGES)]) for first in (FIRE_SIDE, UNEXPOSED_SIDE)
    )
    return fire, unexposed


def _joined(sides: list[tuple[int, NDArray[np.int64]]]) -> Skin:
    """Join sides; each keeps its own vertices, so that edges stay sharp."""
    nodes, triangles, normals, start = [], [], [], 0
    for side, quads in sides:
        node, index = np.unique(quads, return_inverse=True)
        corner = index.reshape(-1, 4) + start
        triangles += [corner[:, [0, 1, 2]], corner[:, [0, 2, 3]]]
        nodes.append(node)
        normals.append(np.tile(NORMALS[side], (len(node), 1)))
        start += len(node)
    return Skin(
        np.concatenate(nodes),
        np.concatenate(triangles).astype(np.uint32),
        np.concatenate(normals),
    )


def outline(nodes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the cold leaf's edges as strips (6, 5, 3), m: two faces, and four lines between."""
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    x, y = [low[0], high[0], high[0], low[0], low[0]], [low[1], low[1], high[1], high[1], low[1]]
    faces = [np.column_stack([x, y, np.full(5, z)]) for z in (low[2], high[2])]
    between = [np.array([faces[0][k]] + [faces[1][k]] * 4) for k in range(4)]
    return np.array([*faces, *between])
