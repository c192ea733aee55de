"""The leaf as a structured grid of bricks: layers through the thickness, a rim around them.

x runs across the width and y up the height, both from the leaf's centre; z runs from the
exposed to the unexposed face. Heat is balanced around nodes (vertex-centred finite volumes):
what a brick holds is shared among nodes by `quadrature.shares`, and along each edge between two
nodes the bricks' share of cross-section conducts. No node can be colder than all it exchanges heat
with, however flat the brick; a steel sheet 1 mm thick with nodes 25 mm apart needs that. The shares
are those of a cubic, along every direction and layer by layer, for heat, surfaces and cross-sections
alike, so that twelve bricks do for wool what some twenty would. At a face whose temperature is held
they are the trapezium rule's: its heat is not asked for.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .quadrature import shares

Array = NDArray[np.float64]


@dataclass(frozen=True)
class LeafMesh:
    """Nodes, and what belongs to them. Node (i, j, k) is row (k ny + j) nx + i.

    Attributes
    ----------
    x (nx,), y (ny,), z (nz,) : m; one entry where the model does not resolve a direction
    volume (M, nz, ny, nx) : m3 of each material at each node
    conductance_x, conductance_y, conductance_z (M, nz, ny, nx) : m, cross-section over
        distance of each material from a node to its neighbour in the positive direction
    exposed_area, unexposed_area (ny, nx) : m2; lateral_area (nz, ny, nx) : m2
    brick_layer (bz,) : layer of each brick through the thickness
    brick_material (bz, by, bx) : index into material_names
    mirror : the directions ("x", "y") in which the modelled part is mirrored to the whole
    """

    x: Array
    y: Array
    z: Array
    volume: Array
    conductance_x: Array
    conductance_y: Array
    conductance_z: Array
    exposed_area: Array
    unexposed_area: Array
    lateral_area: Array
    material_names: tuple[str, ...]
    brick_layer: NDArray[np.int64]
    brick_material: NDArray[np.int64]
    mirror: tuple[str, ...]

    @property
    def shape(self) -> tuple[int, int, int]:
        """(nz, ny, nx)."""
        return len(self.z), len(self.y), len(self.x)

    @property
    def nodes(self) -> Array:
        """Node positions (N, 3), m."""
        z, y, x = np.meshgrid(self.z, self.y, self.x, indexing="ij")
        return np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)

    @property
    def parts(self) -> int:
        """How many times the modelled part makes up the whole leaf."""
        return 2 ** len(self.mirror)


def leaf_mesh(
    x: Array,
    y: Array,
    z: Array,
    brick_material: NDArray[np.int64],
    material_names: tuple[str, ...],
    through_factor: Array | None = None,
    lateral: tuple[bool, bool, bool, bool] = (False, False, False, False),
    brick_layer: NDArray[np.int64] | None = None,
    mirror: tuple[str, ...] = (),
    held: tuple[bool, bool] = (False, False),
) -> LeafMesh:
    """Collect the bricks of a tensor grid at its nodes.

    x, y, z : node positions, m; a single position stands for a unit width that is not resolved
    brick_material (bz, by, bx) : index into `material_names` (1 brick where not resolved)
    through_factor (bz, by, bx) : scales conduction along z (a rim with poor contact)
    held : whether the exposed and the unexposed face are held at a temperature
    lateral : whether the sides at -x, +x, -y, +y are the leaf's edge and not a symmetry plane
    """
    dx, dy, dz = (np.diff(c) if len(c) > 1 else np.ones(1) for c in (x, y, z))
    nz, ny, nx = len(z), len(y), len(x)
    count = len(material_names)
    if through_factor is None:
        through_factor = np.ones(brick_material.shape)
    area_x = dz[:, None, None] * dy[None, :, None] * np.ones_like(dx)[None, None, :]
    area_y = dz[:, None, None] * np.ones_like(dy)[None, :, None] * dx[None, None, :]
    area_z = np.ones_like(dz)[:, None, None] * dy[None, :, None] * dx[None, None, :]
    if brick_layer is None:
        brick_layer = np.zeros(len(dz), dtype=np.int64)
    across = shares(x, _runs(brick_material, 2), ("x" in mirror, False))
    up = shares(y, _runs(brick_material, 1), ("y" in mirror, False))
    through = shares(z, brick_layer, held)

    def to_nodes(bricks: Array, axes: str) -> Array:
        """Share what bricks hold among their nodes along each of `axes`; elsewhere by edge."""
        if "z" in axes:
            bricks = np.einsum("nb,bji->nji", through, bricks)
        if "y" in axes:
            bricks = np.einsum("nb,kbi->kni", up, bricks)
        if "x" in axes:
            bricks = np.einsum("nb,kjb->kjn", across, bricks)
        return bricks

    volume = np.zeros((count, nz, ny, nx))
    gx, gy, gz = np.zeros_like(volume), np.zeros_like(volume), np.zeros_like(volume)
    for m in range(count):
        mine = (brick_material == m).astype(float)
        volume[m] = to_nodes(mine * area_x * dx, "xyz")
        if nx > 1:
            gx[m, :, :, :-1] = to_nodes(mine * area_x / dx, "yz")
        if ny > 1:
            gy[m, :, :-1, :] = to_nodes(mine * area_y / dy[:, None], "xz")
        if nz > 1:
            gz[m, :-1] = to_nodes(mine * through_factor * area_z / dz[:, None, None], "xy")
    face = to_nodes((dy[:, None] * dx)[None], "xy")[0]
    side_x = to_nodes((dz[:, None] * dy)[:, :, None], "yz")[:, :, 0]
    side_y = to_nodes(dz[:, None, None] * dx, "xz")[:, 0, :]
    side = np.zeros((nz, ny, nx))
    if lateral[0]:
        side[:, :, 0] += side_x
    if lateral[1]:
        side[:, :, -1] += side_x
    if lateral[2]:
        side[:, 0, :] += side_y
    if lateral[3]:
        side[:, -1, :] += side_y
    return LeafMesh(
        x=x,
        y=y,
        z=z,
        volume=volume,
        conductance_x=gx,
        conductance_y=gy,
        conductance_z=gz,
        exposed_area=face,
        unexposed_area=face.copy(),
        lateral_area=side,
        material_names=material_names,
        brick_layer=brick_layer,
        brick_material=brick_material,
        mirror=mirror,
    )


def _runs(brick_material: NDArray[np.int64], axis: int) -> NDArray[np.int64]:
    """Which stretch of like bricks along an axis each line of bricks belongs to."""
    lines = np.moveaxis(brick_material, axis, 0).reshape(brick_material.shape[axis], -1)
    return np.concatenate([[0], np.cumsum(np.any(lines[1:] != lines[:-1], axis=1))])
