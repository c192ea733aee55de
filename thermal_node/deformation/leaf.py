"""How the leaf bends: the scene's supports, the field on the structural grid, gap and bow.

deformation = Deformation(model)
deflection = deformation.solve(heat.temperature)
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..mesh.grading import graded_from_end
from ..mesh.whole import whole_leaf
from ..model.door_model import DoorModel, material_of
from ..model.materials import Material
from ..model.probes import weights_at
from ..model.strength import strength_at, yield_strength
from ..scene.load import SceneError
from ..scene.schema import Scene
from ..scene.supports import mechanism, supports, symmetric
from .deflection import Deflection, Utilisation, YieldState
from .holding import Holding
from .shell import ShellLeaf
from .solid import SolidLeaf
from .utilisation import equivalent_strain, most_used, von_mises
from .yielding import plane_stress, yielded

Array = NDArray[np.float64]

FIRST_BRICK = 0.01
"""m; width of the structural brick beside the rim."""
THICK_BRICKS = {"solid": 3, "shell": 6}
THIN = 3e-3


class Deformation:
    """The structural model of a scene's leaf, built once.

    Hinges hold their points on the unexposed face against moving through the leaf's plane, the
    middle one in the plane as well; locks hold their points against moving through the plane, and the
    frame's stop holds the leaf's edge one way. Raises SceneError where a material says nothing of its
    stiffness.
    """

    def __init__(self, model: DoorModel) -> None:
        scene = model.scene
        self.model = model
        self.kind = "solid" if scene.deformation.model == "none" else scene.deformation.model
        names = model.mesh.material_names
        materials = tuple(_stiff(name, scene) for name in names)
        half_y = 0.5 * scene.leaf.height
        self.mirrored = "y" in model.mesh.mirror and symmetric(scene.leaf, scene.deformation)
        x, y, z = self._lines(scene)
        material, rim = _bricks(scene, names, x, y, z)
        self._holding = Holding(scene, self.mirrored)
        held = self._holding.held()
        whole = np.union1d(y, -y) if self.mirrored else y
        placed = [replace(s, y=_nearest(whole, s.y)) for s in supports(scene.leaf, scene.deformation)]
        free = mechanism(scene.leaf, scene.deformation, placed)
        if free:
            raise SceneError(
                f"{scene.source}: deformation: on its mesh it {free}; give a finer deformation.in_plane"
            )
        if self.kind == "solid":
            self._solid = SolidLeaf(x, y, z, material, materials, held)
            self._grid: SolidLeaf | ShellLeaf = self._solid
            self._field = weights_at(model, self._solid.nodes)
        else:
            self._shell = ShellLeaf(x, y, z, material, materials, rim, held)
            self._grid = self._shell
            place = self._shell.gauss_points()
            points = np.empty((*place.shape[:2], len(self._shell.z), 3))
            points[..., :2] = place[:, :, None, :]
            points[..., 2] = self._shell.z
            self._shape = points.shape[:3]
            self._field = weights_at(model, points.reshape(-1, 3))
        if self.mirrored:
            self._grid.mirror_in_y(0.0)
        self._holding.place(self._grid)
        self._strengths = tuple(yield_strength(name, scene) for name in names)
        if scene.deformation.yielding == "layered" and all(curve is None for curve in self._strengths):
            raise SceneError(
                f"{scene.source}: deformation.yielding: is layered, and no material of the leaf has a"
                " yield_strength; give one, Pa, or yielding: none"
            )
        self._edges = {
            "left": np.array([[-0.5 * scene.leaf.width, s * half_y] for s in _ALONG]),
            "right": np.array([[0.5 * scene.leaf.width, s * half_y] for s in _ALONG]),
            "top": np.array([[s * 0.5 * scene.leaf.width, half_y] for s in _ALONG]),
            "bottom": np.array([[s * 0.5 * scene.leaf.width, -half_y] for s in _ALONG]),
        }

    def solve(self, temperature: Array, before: Deflection | None = None) -> Deflection:
        """The shape at node temperatures (N,), °C.

        before : the shape from which a leaf that yields goes on; left out, from the cold one

        Raises
        ------
        Unsettled
            Where the supports that hold, or the layers that yield, were not found.
        """
        index, weight = self._field
        at = np.einsum("pj,pj->p", weight, temperature[index])
        state = None
        if self.kind == "solid":
            matrix, load = self._solid.equations(at)
            solved = self._holding.equilibrium(matrix)
            u, forces = solved.solve(load)
            utilisation = self._used_solid(at, u)
        else:
            at = at.reshape(self._shape)
            if self.model.scene.deformation.yielding == "layered":
                earlier = before.state if before is not None else None
                found = yielded(self._shell, self._holding, self._strengths, self.model.initial, at, earlier)
                matrix, load, solved, u, forces, state = found
            else:
                matrix, load = self._shell.equations(at)
                solved = self._holding.equilibrium(matrix)
                u, forces = solved.solve(load)
            utilisation = self._used_shell(at, u, state)
        self._u = u.reshape(-1, 3 if self.kind == "solid" else 5)
        support_forces = self._holding.support_forces(solved, forces, matrix @ u - load)
        leaf = self.model.scene.leaf
        x, y, t = 0.5 * leaf.width, 0.5 * leaf.height, leaf.thickness
        key = np.array([[-x, -y, t], [x, -y, t], [-x, y, t], [x, y, t], [0.0, 0.0, t]])
        w = self.displacement_at(key)[:, 2]
        moved = {
            name: self.displacement_at(np.c_[points, np.full(len(points), t)])[:, 2]
            for name, points in self._edges.items()
        }
        return Deflection(
            displacement=self.displacement_at(self.model.nodes),
            bow=float(w[:4].mean() - w[4]),
            edge_gap={name: float(np.abs(out).max()) for name, out in moved.items()},
            edge_place={
                name: points[:, 1 if name in ("left", "right") else 0] for name, points in self._edges.items()
            },
            edge_moved=moved,
            latch="right" if self.model.scene.deformation.hinge_side == "left" else "left",
            support_forces=support_forces,
            utilisation=utilisation,
            state=state,
        )

    def _used_solid(self, at: Array, u: Array) -> Utilisation | None:
        if all(curve is None for curve in self._strengths):
            return None
        strong = np.array([curve is not None for curve in self._strengths])[self._solid.material]
        stress, temperature, place = self._solid.stress(at, u, strong)
        kind = np.broadcast_to(self._solid.material[strong][:, None], stress.shape)
        strength = strength_at(self._strengths, kind, temperature)
        names = self.model.mesh.material_names
        return most_used(stress, strength, temperature, place, kind, names)

    def _used_shell(self, at: Array, u: Array, state: YieldState | None) -> Utilisation | None:
        if all(curve is None for curve in self._strengths):
            return None
        elastic = self._shell.strain(u) - (0.0 if state is None else state.plastic_strain)
        stress = von_mises(plane_stress(self._shell, at, elastic))
        kind = np.broadcast_to(self._shell.kind_at()[:, None, :], at.shape)
        place = np.empty((*at.shape, 3))
        place[..., :2] = self._shell.gauss_points()[:, :, None, :]
        place[..., 2] = self._shell.z
        strength = strength_at(self._strengths, kind, at)
        found = most_used(stress, strength, at, place, kind, self.model.mesh.material_names)
        if found is None or state is None:
            return found
        return replace(found, plastic_strain=equivalent_strain(state.plastic_strain))

    def displacement_at(self, position: Array) -> Array:
        """Displacement (P, 3), m, of the last solution at positions (P, 3), m."""
        where = position.copy()
        below = self.mirrored & (where[:, 1] < 0.0)
        where[below, 1] *= -1.0
        lines = self._solid.lines if self.kind == "solid" else self._shell.lines
        if self.kind == "solid":
            u = _on_grid(lines, where, self._u)
        else:
            v = _on_grid((lines[0], lines[1], np.zeros(1)), where, self._u)
            z = (where[:, 2] - self._shell.middle)[:, None]
            u = np.concatenate([v[:, :2] + z * v[:, 3:], v[:, 2:3]], axis=1)
        u[below, 1] *= -1.0
        return u

    def whole(self) -> Array:
        """Displacement of the whole leaf's nodes (see mesh.whole), m."""
        leaf = self.model.scene.leaf
        return self.displacement_at(whole_leaf(self.model.mesh, leaf.width, leaf.height).nodes)

    def _lines(self, scene: Scene) -> tuple[Array, Array, Array]:
        leaf, part = scene.leaf, scene.deformation
        x = _line(leaf.width, part.in_plane[0], scene)
        y = _line(leaf.height, part.in_plane[1], scene)
        if self.mirrored:
            y = _half_line(leaf.height, max(part.in_plane[1] // 2, 2), scene)
        counts = part.layers or tuple(
            1 if layer.thickness <= THIN else THICK_BRICKS[self.kind] for layer in leaf.layers
        )
        z = [np.zeros(1)]
        for layer, count in zip(leaf.layers, counts, strict=True):
            z.append(z[-1][-1] + np.linspace(0.0, layer.thickness, count + 1)[1:])
        return x, y, np.concatenate(z)


_ALONG = np.linspace(-1.0, 1.0, 41)


def _stiff(name: str, scene: Scene) -> Material:
    part = scene.materials.get(name)
    eurocode = name == "steel" or (part is not None and part.standard is not None)
    if not eurocode and (part is None or part.youngs_modulus is None):
        raise SceneError(
            f"{scene.source}: materials.{name}: lacks youngs_modulus; give it in Pa for the"
            " deformation (rock wool: about 5e5, steel 2.1e11)"
        )
    return material_of(name, scene)


def _line(size: float, count: int, scene: Scene) -> Array:
    rim = scene.leaf.rim
    if rim is None:
        return np.linspace(-0.5 * size, 0.5 * size, count + 1, dtype=np.float64)
    inner = size - 2.0 * rim.thickness
    x = graded_from_end(inner, max(count - 2, 1), FIRST_BRICK, both=True) - 0.5 * inner
    return np.concatenate([[-0.5 * size], x, [0.5 * size]])


def _half_line(size: float, count: int, scene: Scene) -> Array:
    rim = scene.leaf.rim
    if rim is None:
        return np.linspace(0.0, 0.5 * size, count + 1, dtype=np.float64)
    return np.append(graded_from_end(0.5 * size - rim.thickness, max(count - 1, 1), FIRST_BRICK), 0.5 * size)


def _bricks(
    scene: Scene, names: tuple[str, ...], x: Array, y: Array, z: Array
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Material of each brick, and where the rim's web stands across x (1) or y (2)."""
    faces = np.cumsum([layer.thickness for layer in scene.leaf.layers])
    middle = 0.5 * (z[:-1] + z[1:])
    layer_of = np.minimum(np.searchsorted(faces, middle), len(faces) - 1)
    index = np.array([names.index(layer.material) for layer in scene.leaf.layers])
    shape = (len(z) - 1, len(y) - 1, len(x) - 1)
    material = np.broadcast_to(index[layer_of][:, None, None], shape).copy()
    rim = np.zeros(shape[1:], dtype=np.int64)
    if scene.leaf.rim is not None:
        edge_x = 0.5 * scene.leaf.width - scene.leaf.rim.thickness
        edge_y = 0.5 * scene.leaf.height - scene.leaf.rim.thickness
        rim[:, np.abs(0.5 * (x[:-1] + x[1:])) > edge_x] |= 1
        rim[np.abs(0.5 * (y[:-1] + y[1:])) > edge_y] |= 2
        web = names.index(scene.leaf.rim.material)
        material = np.where((rim > 0)[None], web, material)
    return material, rim


def _nearest(line: Array, at: float) -> float:
    return float(line[np.argmin(np.abs(line - at))])


def _on_grid(lines: tuple[Array, Array, Array], position: Array, value: Array) -> Array:
    """Trilinear values (P, c) at positions from values (N, c) on a tensor grid, x fastest."""
    shape = tuple(len(line) for line in lines)
    index: list[NDArray[np.int64]] = []
    weight: list[Array] = []
    for axis, line in enumerate(lines):
        if len(line) == 1:
            index.append(np.zeros((len(position), 1), dtype=np.int64))
            weight.append(np.ones((len(position), 1)))
            continue
        i = np.clip(np.searchsorted(line, position[:, axis], side="right") - 1, 0, len(line) - 2)
        s = (position[:, axis] - line[i]) / (line[i + 1] - line[i])
        index.append(np.stack([i, i + 1], axis=1))
        weight.append(np.stack([1.0 - s, s], axis=1))
    out = np.zeros((len(position), value.shape[1]))
    for c in range(index[2].shape[1]):
        for b in range(2):
            for a in range(2):
                node = (index[2][:, c] * shape[1] + index[1][:, b]) * shape[0] + index[0][:, a]
                w = weight[2][:, c] * weight[1][:, b] * weight[0][:, a]
                out += w[:, None] * value[node]
    return out
