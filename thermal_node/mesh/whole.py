"""The whole leaf from its modelled part: for pictures, for the deformation, for a viewer."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .leaf import Array, LeafMesh


@dataclass(frozen=True)
class WholeLeaf:
    """Nodes and bricks of the whole leaf.

    nodes (N, 3), m; source (N,) : the modelled node that each stands for
    hexahedra (C, 8) : VTK_HEXAHEDRON order; layer (C,); contacts, 0 m thick, are none of them
    x (nx,), y (ny,), z (nz,) : the grid's lines, m
    """

    nodes: Array
    source: NDArray[np.int64]
    hexahedra: NDArray[np.int64]
    layer: NDArray[np.int64]
    x: Array
    y: Array
    z: Array


def whole_leaf(mesh: LeafMesh, width: float, height: float) -> WholeLeaf:
    """Mirror the modelled part, and stretch what a direction does not resolve over its size."""
    x, ix = _line(mesh.x, "x" in mesh.mirror, width)
    y, iy = _line(mesh.y, "y" in mesh.mirror, height)
    z, iz = mesh.z, np.arange(len(mesh.z))
    nx, ny = len(mesh.x), len(mesh.y)
    source = (iz[:, None, None] * ny + iy[None, :, None]) * nx + ix[None, None, :]
    zz, yy, xx = np.meshgrid(z, y, x, indexing="ij")
    by, bx = len(y) - 1, len(x) - 1
    there = np.flatnonzero(np.diff(z) > 0.0)
    k, j, i = np.meshgrid(there, np.arange(by), np.arange(bx), indexing="ij")
    base = ((k * len(y) + j) * len(x) + i).ravel()
    row, plane = len(x), len(x) * len(y)
    corner = np.array([0, 1, row + 1, row])
    return WholeLeaf(
        nodes=np.stack([xx.ravel(), yy.ravel(), zz.ravel()], axis=1),
        source=source.ravel(),
        hexahedra=base[:, None] + np.concatenate([corner, corner + plane]),
        layer=mesh.brick_layer[k.ravel()],
        x=x,
        y=y,
        z=z,
    )


def _line(line: Array, mirrored: bool, size: float) -> tuple[Array, NDArray[np.int64]]:
    if len(line) == 1:
        return np.array([-0.5 * size, 0.5 * size]), np.zeros(2, dtype=np.int64)
    index = np.arange(len(line))
    if not mirrored:
        return line, index
    return np.concatenate([-line[:0:-1], line]), np.concatenate([index[:0:-1], index])
