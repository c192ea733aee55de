"""The leaf as bricks: thermo-elastic, linear, E(T), free elongation of each layer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csc_matrix
from skfem import ElementHex1, MeshHex

from ..model.materials import Material
from .brick import element_stress, shape_functions, stiffness_and_load

Array = NDArray[np.float64]

SOFTEST = 1e-3
"""Least share of a material's stiffness at 20 °C that is kept, so that a melted sheet stays."""


class SolidLeaf:
    """Bricks of the whole leaf and their supports.

    x, y, z : lines of the grid, m; material (bz, by, bx) : index into materials
    supports : list of (point (3,), axes) - the nearest node is held along the axes
    """

    def __init__(
        self,
        x: Array,
        y: Array,
        z: Array,
        material: NDArray[np.int64],
        materials: tuple[Material, ...],
        supports: list[tuple[tuple[float, float, float], tuple[int, ...]]],
    ) -> None:
        self.lines = (x, y, z)
        mesh = MeshHex.init_tensor(x, y, z)
        # Nodes as everywhere here, x fastest; scikit-fem numbers them its own way.
        rank = np.lexsort(mesh.p)
        place = np.empty_like(rank)
        place[rank] = np.arange(len(rank))
        self.nodes = mesh.p.T[rank]
        element = place[mesh.t.T]
        corner = self.nodes[element]
        low, high = corner.min(axis=1), corner.max(axis=1)
        self._element = element[:, _corner_order(corner[0])]
        self.size = high - low
        middle = 0.5 * (low + high)
        i, j, k = (np.searchsorted(line, middle[:, a]) - 1 for a, line in enumerate((x, y, z)))
        self.material = material[k, j, i]
        self._materials = materials
        dof = (3 * self._element[:, :, None] + np.arange(3)).reshape(len(self.size), 24)
        self._dof = dof
        self._rows = np.repeat(dof, 24, axis=1).ravel()
        self._columns = np.tile(dof, (1, 24)).ravel()
        held = []
        for point, axes in supports:
            node = int(np.argmin(np.linalg.norm(self.nodes - np.array(point), axis=1)))
            held += [3 * node + axis for axis in axes]
        self.held = np.array(held, dtype=int)

    def mirror_in_y(self, y: float) -> None:
        """Make the nodes at y a plane of symmetry: they do not move along y."""
        at = np.flatnonzero(np.abs(self.nodes[:, 1] - y) < 1e-12)
        self.held = np.concatenate([self.held, 3 * at + 1])

    def unknown(self, point: tuple[float, float, float]) -> int:
        """Number of the movement through the plane of the node nearest to a point, m."""
        return 3 * int(np.argmin(np.linalg.norm(self.nodes - np.array(point), axis=1))) + 2

    def rigid_motions(self) -> Array:
        """Motions (n, 3) of the leaf as a rigid body: through its plane, and turns w = x and w = y.

        They turn about the unexposed face, where the leaf is held in its plane.
        """
        motion = np.zeros((len(self.nodes), 3, 3))
        motion[:, 2, 0] = 1.0
        motion[:, 2, 1:] = self.nodes[:, :2]
        motion[:, 0, 1] = motion[:, 1, 2] = self.lines[2][-1] - self.nodes[:, 2]
        return motion.reshape(-1, 3)

    def equations(self, temperature: Array) -> tuple[csc_matrix, Array]:
        """Stiffness (n, n), N/m, and thermal load (n,), N, at the nodes' temperatures (N,), °C."""
        modulus, strain, ratio = self._elastic(temperature)
        stiffness, load = stiffness_and_load(self.size, modulus, ratio, strain)
        count = 3 * len(self.nodes)
        matrix = coo_matrix((stiffness.ravel(), (self._rows, self._columns)), shape=(count, count)).tocsc()
        force = np.bincount(self._dof.ravel(), weights=load.ravel(), minlength=count)
        return matrix, np.asarray(force, dtype=float)

    def stress(self, temperature: Array, u: Array, only: NDArray[np.bool_]) -> tuple[Array, Array, Array]:
        """Von Mises stress, Pa, temperature, °C, and place (8 Gauss points, 3), m, of some bricks."""
        modulus, strain, ratio = self._elastic(temperature)
        found = element_stress(self.size[only], modulus[only], ratio[only], strain[only], u[self._dof[only]])
        value, _ = shape_functions()
        place = np.einsum("gk,nkc->ngc", value, self.nodes[self._element[only]])
        return found, temperature[self._element[only]] @ value.T, place

    def _elastic(self, temperature: Array) -> tuple[Array, Array, Array]:
        value, _ = shape_functions()
        at = temperature[self._element] @ value.T
        modulus, strain = np.zeros_like(at), np.zeros_like(at)
        ratio = np.zeros(len(at))
        for m, material in enumerate(self._materials):
            mine = self.material == m
            cold = float(material.youngs_modulus(20.0))
            modulus[mine] = np.maximum(material.youngs_modulus(at[mine]), SOFTEST * cold)
            strain[mine] = material.elongation(at[mine])
            ratio[mine] = material.poissons_ratio
        return modulus, strain, ratio


def _corner_order(corner: Array) -> NDArray[np.int64]:
    """For scikit-fem's parent corners in turn, the element's corner at that place."""
    parent = np.asarray(ElementHex1().doflocs)
    place = (corner - corner.min(axis=0)) / (corner.max(axis=0) - corner.min(axis=0))
    return np.array([int(np.argmin(np.abs(place - p).sum(axis=1))) for p in parent])
