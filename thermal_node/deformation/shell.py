"""The leaf as a layered shell: one flat element through all layers, first-order shear.

u(z) = u0 + z bx, v(z) = v0 + z by, w. Layers are integrated through the thickness with their
own E(T) and free elongation, in plane stress. The transverse shear stiffness is the one whose
energy is that of the shear stresses in equilibrium with the bending stresses, so a soft core
between stiff sheets shears as a sandwich does. A rim's web resists the sliding of one sheet over
the other along itself by its shear, and across itself only as a thin plate that bends,
S = E t^2 d^2 / h^3 with its thickness t, height h and the sheets' distance d. Shear strains are
tied as in MITC4 (Bathe and Dvorkin 1985, IJNME 21, 367), so that flat elements do not lock.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csc_matrix

from ..model.materials import Material
from .solid import SOFTEST

Array = NDArray[np.float64]

_GAUSS = np.array([-1.0, 1.0]) / np.sqrt(3.0)
_CORNER = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=float)


class ShellLeaf:
    """Rectangular shell elements of the whole leaf and their supports.

    x, y : lines of the grid, m; z : faces of the layers' bricks through the thickness
    material (bz, by, bx) : index into materials
    rim (by, bx) : 0 inside, 1 where the web stands across x, 2 across y, 3 both (corners)
    supports : list of (point (3,), axes) - the nearest node is held along the axes
    """

    def __init__(
        self,
        x: Array,
        y: Array,
        z: Array,
        material: NDArray[np.int64],
        materials: tuple[Material, ...],
        rim: NDArray[np.int64],
        supports: list[tuple[tuple[float, float, float], tuple[int, ...]]],
    ) -> None:
        self.lines = (x, y, z)
        nx, ny = len(x), len(y)
        grid_x, grid_y = np.meshgrid(x, y)
        self.nodes = np.stack([grid_x.ravel(), grid_y.ravel()], axis=1)
        j, i = np.divmod(np.arange((nx - 1) * (ny - 1)), nx - 1)
        first = j * nx + i
        self.element = np.stack([first, first + 1, first + nx + 1, first + nx], axis=1)
        self.size = np.stack([np.diff(x)[i], np.diff(y)[j]], axis=1)
        self._material = material[:, j, i]
        self._materials = materials
        self._rim = rim[j, i]
        point = np.concatenate([0.5 * (z[:-1] + z[1:]) + s * np.diff(z) / 2 for s in _GAUSS])
        self.z = point
        self._z_weight = np.tile(0.5 * np.diff(z), 2)
        self._z_brick = np.tile(np.arange(len(z) - 1), 2)
        self.middle = 0.5 * (z[0] + z[-1])
        self._height = z[-1] - z[0]
        dof = (5 * self.element[:, :, None] + np.arange(5)).reshape(-1, 20)
        self._dof = dof
        held = []
        for at, axes in supports:
            node = int(np.argmin(np.linalg.norm(self.nodes - np.array(at[:2]), axis=1)))
            held += [5 * node + axis for axis in axes]
        self.held = np.array(held, dtype=int)

    def mirror_in_y(self, y: float) -> None:
        """Make the line of nodes at y a plane of symmetry: v = 0 and by = 0 there."""
        at = np.flatnonzero(np.abs(self.nodes[:, 1] - y) < 1e-12)
        self.held = np.concatenate([self.held, 5 * at + 1, 5 * at + 4])

    def unknown(self, point: tuple[float, float, float]) -> int:
        """Number of the movement through the plane of the node nearest to a point, m."""
        return 5 * int(np.argmin(np.linalg.norm(self.nodes - np.array(point[:2]), axis=1))) + 2

    def rigid_motions(self) -> Array:
        """Motions (n, 3) of the leaf as a rigid plate: through its plane, and turns w = x and w = y."""
        motion = np.zeros((len(self.nodes), 5, 3))
        motion[:, 2, 0] = 1.0
        motion[:, 2, 1:] = self.nodes
        motion[:, 3, 1] = motion[:, 4, 2] = -1.0
        return motion.reshape(-1, 3)

    def equations(self, temperature_at: Array) -> tuple[csc_matrix, Array]:
        """Stiffness (n, n), N/m, and thermal load (n,), N.

        Unknowns node by node: u0, v0, w at mid-thickness, m, and rotations bx, by.
        temperature_at (elements, 4 Gauss points, z points) : °C at gauss_points() and self.z
        """
        count = len(self.size)
        stiffness, load = np.zeros((count, 20, 20)), np.zeros((count, 20))
        plane, shear, force = self._section(temperature_at)
        area = self.size.prod(axis=1) / 4.0
        for g, (gx, gy) in enumerate((a, b) for b in _GAUSS for a in _GAUSS):
            b, s = self._strains(gx, gy)
            stiffness += area[:, None, None] * (b.transpose(0, 2, 1) @ (plane[:, g] @ b))
            stiffness += area[:, None, None] * (s.transpose(0, 2, 1) @ (shear[:, g] @ s))
            load += area[:, None] * np.einsum("nij,ni->nj", b, force[:, g])
        n = 5 * len(self.nodes)
        rows = np.repeat(self._dof, 20, axis=1).ravel()
        columns = np.tile(self._dof, (1, 20)).ravel()
        matrix = coo_matrix((stiffness.ravel(), (rows, columns)), shape=(n, n)).tocsc()
        total = np.bincount(self._dof.ravel(), weights=load.ravel(), minlength=n)
        return matrix, np.asarray(total, dtype=float)

    def load(self, stress: Array) -> Array:
        """Forces (n,), N, in balance with stresses xx, yy, xy (elements, 4, z points, 3), Pa."""
        area = self.size.prod(axis=1) / 4.0
        layered = stress * self._z_weight[:, None]
        section = np.concatenate(
            [layered.sum(axis=2), (layered * (self.z - self.middle)[:, None]).sum(axis=2)], axis=2
        )
        load = np.zeros((len(self.size), 20))
        for g, (gx, gy) in enumerate((a, b) for b in _GAUSS for a in _GAUSS):
            b, _ = self._strains(gx, gy)
            load += area[:, None] * np.einsum("nij,ni->nj", b, section[:, g])
        return np.asarray(
            np.bincount(self._dof.ravel(), weights=load.ravel(), minlength=5 * len(self.nodes)), dtype=float
        )

    def strain(self, u: Array) -> Array:
        """Strains xx, yy, xy (engineering) (elements, 4, z points, 3) of unknowns (n,)."""
        mine = u[self._dof]
        z = (self.z - self.middle)[:, None]
        found = np.empty((len(self.size), 4, len(self.z), 3))
        for g, (gx, gy) in enumerate((a, b) for b in _GAUSS for a in _GAUSS):
            b, _ = self._strains(gx, gy)
            e = np.einsum("nij,nj->ni", b, mine)
            found[:, g] = e[:, None, :3] + z * e[:, None, 3:]
        return found

    def kind_at(self) -> NDArray[np.int64]:
        """Index of the material (elements, z points)."""
        return np.asarray(self._material[self._z_brick].T)

    def gauss_points(self) -> Array:
        """Places (elements, 4, 2) in the plane, m, where temperatures are wanted."""
        corner = self.nodes[self.element]
        low = corner.min(axis=1)
        places = np.array([[a, b] for b in _GAUSS for a in _GAUSS])
        return low[:, None, :] + 0.5 * (places + 1.0) * self.size[:, None, :]

    def elastic(self, temperature: Array) -> tuple[Array, Array, Array]:
        """Modulus, Pa, Poisson's ratio (elements, 1, z points), free strain, at the temperatures' points."""
        kind = self._material[self._z_brick].T
        modulus = np.zeros_like(temperature)
        strain = np.zeros_like(temperature)
        ratio = np.zeros((len(self.size), 1, len(self.z)))
        for m, material in enumerate(self._materials):
            mine = np.broadcast_to((kind == m)[:, None, :], temperature.shape)
            cold = float(material.youngs_modulus(20.0))
            at = temperature[mine]
            modulus[mine] = np.maximum(material.youngs_modulus(at), SOFTEST * cold)
            strain[mine] = material.elongation(at)
            ratio[(kind == m)[:, None, :]] = material.poissons_ratio
        return modulus, ratio, strain

    def _section(self, temperature: Array) -> tuple[Array, Array, Array]:
        """Stiffness of the section (n, 4, 6, 6), of shear (n, 4, 2, 2), thermal force (n, 4, 6)."""
        count = len(self.size)
        modulus, ratio, strain = self.elastic(temperature)
        z = self.z - self.middle
        q = modulus / (1.0 - ratio**2) * self._z_weight
        moments = [np.sum(q * z**p, axis=2) for p in range(3)]
        coupled = [np.sum(q * ratio * z**p, axis=2) for p in range(3)]
        twist = [np.sum(q * (1.0 - ratio) / 2.0 * z**p, axis=2) for p in range(3)]
        plane = np.zeros((count, 4, 6, 6))
        for row, column, p in ((0, 0, 0), (0, 3, 1), (3, 0, 1), (3, 3, 2)):
            for a in range(2):
                plane[:, :, row + a, column + a] = moments[p]
                plane[:, :, row + a, column + 1 - a] = coupled[p]
            plane[:, :, row + 2, column + 2] = twist[p]
        push = q * (1.0 + ratio) * strain
        force = np.zeros((count, 4, 6))
        force[:, :, :2] = push.sum(axis=2)[:, :, None]
        force[:, :, 3:5] = (push * z).sum(axis=2)[:, :, None]
        return plane, self._shear(modulus, ratio), force

    def _shear(self, modulus: Array, ratio: Array) -> Array:
        """Transverse shear stiffness (n, 4, 2, 2), N/m, from equilibrium of the layers."""
        order = np.argsort(self.z)
        z = self.z[order]
        weight = self._z_weight[order]
        e = modulus[:, :, order]
        g = e / (2.0 * (1.0 + ratio[:, :, order]))
        axial = e * weight
        neutral = (axial * z).sum(axis=2) / axial.sum(axis=2)
        lever = z - neutral[:, :, None]
        moment = axial * lever
        flow = np.cumsum(moment, axis=2) - 0.5 * moment
        bending = (moment * lever).sum(axis=2)
        stiffness = bending**2 / (flow**2 / g * weight).sum(axis=2)
        shear = np.zeros((*stiffness.shape, 2, 2))
        across = (self._rim & 1 > 0, self._rim & 2 > 0)
        for axis in range(2):
            thickness = self.size[:, axis]
            web = e.mean(axis=2) * (thickness**2 / self._height)[:, None]
            shear[:, :, axis, axis] = np.where(across[axis][:, None], web, stiffness)
        return shear

    def _strains(self, gx: float, gy: float) -> tuple[Array, Array]:
        """Strain (n, 6, 20): membrane and curvature; transverse shear (n, 2, 20)."""
        count = len(self.size)
        _, slope = _functions(gx, gy)
        dx = slope[:, 0] * 2.0 / self.size[:, :1]
        dy = slope[:, 1] * 2.0 / self.size[:, 1:]
        b = np.zeros((count, 6, 4, 5))
        for first, (u, v) in ((0, (0, 1)), (3, (3, 4))):
            b[:, first, :, u] = dx
            b[:, first + 1, :, v] = dy
            b[:, first + 2, :, u] = dy
            b[:, first + 2, :, v] = dx
        s = np.zeros((count, 2, 4, 5))
        value, slope = _functions(0.0, gy)
        s[:, 0, :, 2] = slope[:, 0] * 2.0 / self.size[:, :1]
        s[:, 0, :, 3] = value
        value, slope = _functions(gx, 0.0)
        s[:, 1, :, 2] = slope[:, 1] * 2.0 / self.size[:, 1:]
        s[:, 1, :, 4] = value
        return b.reshape(count, 6, 20), s.reshape(count, 2, 20)


def _functions(gx: float, gy: float) -> tuple[Array, Array]:
    """Bilinear functions (4,) and their derivatives (4, 2) on the square -1..1."""
    a, b = _CORNER[:, 0], _CORNER[:, 1]
    value = (1.0 + a * gx) * (1.0 + b * gy) / 4.0
    slope = np.stack([a * (1.0 + b * gy), b * (1.0 + a * gx)], axis=1) / 4.0
    return value, slope
