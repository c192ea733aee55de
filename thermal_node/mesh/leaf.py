"""The leaf as a structured grid of bricks: layers through the thickness, a rim around them.

x runs across the width and y up the height, both from the leaf's centre; z runs from the
exposed to the unexposed face.

Finite volumes: heat is balanced around nodes (vertex-centred):
what a brick holds is shared among nodes by `quadrature.shares`, and along each edge between two
nodes the bricks' share of cross-section conducts. No node can be colder than all it exchanges heat
with, however flat the brick; a steel sheet 1 mm thick with nodes 25 mm apart needs that. The shares
are those of a cubic, along every direction and layer by layer, for heat, surfaces and cross-sections
alike, so that twelve bricks do for wool what some twenty would. At a face whose temperature is held
they are the trapezium rule's: its heat is not asked for.

Finite elements: trilinear bricks with consistent capacity, as most programs have them; surfaces are
lumped at their nodes.

Gaps (gaps.py) come after all materials. They exchange heat along z alone, weighed by their area, and hold
none, in either discretisation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .exchange import Exchange
from .quadrature import halves, shares

Array = NDArray[np.float64]

CONTACT = -1
"""The layer of a brick that is a contact between two layers, 0 m thick."""
BRIDGED = 1e-6
"""m of its own material by which a rim bridges a contact: it goes on there as if there were none."""
MARK = 1e-12
"""m3 for 1 m2 by which a gap's nodes are marked as its own; it holds no heat."""


@dataclass(frozen=True)
class LeafMesh:
    """Nodes, and what belongs to them. Node (i, j, k) is row (k ny + j) nx + i.

    Attributes
    ----------
    x (nx,), y (ny,), z (nz,) : m; one entry where the model does not resolve a direction; z twice where
        layers touch with a resistance
    volume (M, nz, ny, nx) : m3 of each material at each node; of a gap more than 0 where it has nodes
    conduction : of each material, m; for an edge its cross-section over its length; of a gap its area, m2
    mass : of each material, m3; what a consistent capacity has beside the lumped one
    exposed_area, unexposed_area (ny, nx) : m2; lateral_area (nz, ny, nx) : m2, a cavity's mouth left out
    brick_layer (bz,) : layer of each brick through the thickness, or CONTACT
    brick_material (bz, by, bx) : index into material_names; gaps come after those
    mirror : the directions ("x", "y") in which the modelled part is mirrored to the whole
    finite_elements : whether bricks are trilinear elements, not finite volumes
    gaps : how many gaps there are; arrays of all materials (M) have them last
    """

    x: Array
    y: Array
    z: Array
    volume: Array
    conduction: Exchange
    mass: Exchange
    exposed_area: Array
    unexposed_area: Array
    lateral_area: Array
    material_names: tuple[str, ...]
    brick_layer: NDArray[np.int64]
    brick_material: NDArray[np.int64]
    mirror: tuple[str, ...]
    finite_elements: bool
    gaps: int = 0

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
    finite_elements: bool = False,
    gaps: int = 0,
) -> LeafMesh:
    """Collect the bricks of a tensor grid at its nodes.

    x, y, z : node positions, m; a single position stands for a unit width that is not resolved
    brick_material (bz, by, bx) : index into `material_names` (1 brick where not resolved)
    through_factor (bz, by, bx) : scales conduction along z (a rim with poor contact)
    held : whether the exposed and the unexposed face are held at a temperature
    finite_elements : trilinear bricks instead of finite volumes; gaps : how many there are
    lateral : whether the sides at -x, +x, -y, +y are the leaf's edge and not a symmetry plane
    """
    dx, dy, dz = (np.diff(c) if len(c) > 1 else np.ones(1) for c in (x, y, z))
    nz, ny, nx = len(z), len(y), len(x)
    count = len(material_names) + gaps
    if through_factor is None:
        through_factor = np.ones(brick_material.shape)
    size = dz[:, None, None] * dy[None, :, None] * dx[None, None, :]
    if brick_layer is None:
        brick_layer = np.zeros(len(dz), dtype=np.int64)
    if finite_elements:
        across, up, through = halves(nx), halves(ny), halves(nz)
    else:
        across = shares(x, _runs(brick_material, 2), ("x" in mirror, False))
        up = shares(y, _runs(brick_material, 1), ("y" in mirror, False))
        through = shares(z, _stretches(brick_layer), held)

    def to_nodes(bricks: Array, axes: str) -> Array:
        """Share what bricks hold among their nodes along each of `axes`; elsewhere by edge."""
        if "z" in axes:
            bricks = np.einsum("nb,bji->nji", through, bricks)
        if "y" in axes:
            bricks = np.einsum("nb,kbi->kni", up, bricks)
        if "x" in axes:
            bricks = np.einsum("nb,kjb->kjn", across, bricks)
        return bricks

    def part(bricks: Array, along: str) -> Array:
        """What parts that stretch along some axes have of the bricks (M, bz, by, bx), at first nodes."""
        out = np.zeros((count, nz, ny, nx))
        for m in range(count):
            found = to_nodes(bricks[m], "".join(axis for axis in "xyz" if axis not in along))
            out[m, : found.shape[0], : found.shape[1], : found.shape[2]] = found
        return out

    resolved = "".join(axis for axis, nodes in zip("xyz", (nx, ny, nz), strict=True) if nodes > 1)
    there = [along for along in Exchange._fields if set(along) <= set(resolved)]
    is_of = np.stack([brick_material == m for m in range(count)])
    is_gap = (np.arange(count) >= count - gaps)[:, None, None, None]
    mine: Array = is_of * ~is_gap * size
    area = np.broadcast_to(dy[:, None] * dx, size.shape)
    length = np.where(dz > 0.0, dz, BRIDGED)[:, None, None]
    conducts = {"x": mine / dx**2, "y": mine / dy[:, None] ** 2}
    conducts["z"] = np.where(is_gap, is_of * area, is_of * area * (through_factor / length))
    nothing: Array = np.zeros((count, 0, 0, 0))
    conduction = dict.fromkeys(Exchange._fields, nothing)
    mass = dict.fromkeys(Exchange._fields, nothing)
    for along in there:
        order = len(along)
        if order == 1 or finite_elements:
            sides = np.sum([conducts[axis] for axis in along], axis=0)
            if order > 1:
                sides = sides * ~is_gap
            conduction[along] = part((-1 / 6) ** (order - 1) * sides, along)
        if finite_elements:
            mass[along] = part(-((-1 / 6) ** order) * mine, along)
    face = to_nodes((dy[:, None] * dx)[None], "xy")[0]
    # A cavity is closed: where no rim bridges it, its mouth takes no part.
    solid = brick_material < len(material_names)
    side_x, side_y = dz[:, None] * dy, dz[:, None] * dx
    side = np.zeros((nz, ny, nx))
    for end, at in ((0, 0), (1, -1)):
        if lateral[end]:
            side[:, :, at] += to_nodes((solid[:, :, at] * side_x)[:, :, None], "yz")[:, :, 0]
        if lateral[2 + end]:
            side[:, at, :] += to_nodes((solid[:, at, :] * side_y)[:, None, :], "xz")[:, 0, :]
    return LeafMesh(
        x=x,
        y=y,
        z=z,
        volume=np.stack([to_nodes(m, "xyz") for m in np.where(is_gap, is_of * area * MARK, mine)]),
        conduction=Exchange(**conduction),
        mass=Exchange(**mass),
        exposed_area=face,
        unexposed_area=face.copy(),
        lateral_area=side,
        material_names=material_names,
        brick_layer=brick_layer,
        brick_material=brick_material,
        mirror=mirror,
        finite_elements=finite_elements,
        gaps=gaps,
    )


def _stretches(brick_layer: NDArray[np.int64]) -> NDArray[np.int64]:
    """Which layer or gap each brick through the thickness belongs to, counted from 0."""
    return np.concatenate([[0], np.cumsum(np.diff(brick_layer) != 0)])


def _runs(brick_material: NDArray[np.int64], axis: int) -> NDArray[np.int64]:
    """Which stretch of like bricks along an axis each line of bricks belongs to."""
    lines = np.moveaxis(brick_material, axis, 0).reshape(brick_material.shape[axis], -1)
    return np.concatenate([[0], np.cumsum(np.any(lines[1:] != lines[:-1], axis=1))])
