"""Where temperatures are read, and the leaf's unexposed face as an infrared camera sees it.

A reading is a weighted sum of nodes: cubic through the four nearest lines in each direction (the
temperature falls off steeply beside the rim, and bricks are wide further in), through the
thickness without leaving the point's layer, since layers meet with a kink. Where that overshoots
what the corners of the point's own brick hold, on a mesh too coarse for it, it is cut off there.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..heat.conduction import ABSOLUTE_ZERO, STEFAN_BOLTZMANN, Array
from ..mesh.whole import whole_leaf
from ..scene.schema import Scene
from ..scene.standards import EDGE_STRIP, STANDARDS, en_points, leaf_points
from .door_model import DoorModel


@dataclass(frozen=True)
class Probes:
    """Points and their weights.

    name (P,); position (P, 3), m; index, weight (P, 64)
    corner (P, 8) : the nodes of the brick that the point is in
    blind (P,) : whether the model knows nothing of the edge that the point is near
    scene : whose they are
    """

    name: tuple[str, ...]
    position: Array
    index: NDArray[np.int64]
    weight: Array
    corner: NDArray[np.int64]
    blind: NDArray[np.bool_]
    scene: Scene

    def read(self, temperature: Array) -> Array:
        """Readings (P,), °C, from node temperatures (N,)."""
        cubic = np.einsum("pj,pj->p", self.weight, temperature[self.index])
        brick = temperature[self.corner]
        return np.clip(cubic, brick.min(axis=1), brick.max(axis=1))


def standard_points(scene: Scene) -> dict[str, tuple[float, float, float]]:
    """The points of the sets that a scene asks for, m.

    The thesis shows its twelve thermocouples only in photographs that were not at hand: here
    they are the five leaf points, and seven beside the rim that show it as a bridge.
    """
    w, h, t = scene.leaf.width, scene.leaf.height, scene.leaf.thickness
    edge = min(EDGE_STRIP, 0.2 * w, 0.2 * h)
    rim = min(0.025, 0.1 * w, 0.1 * h)
    right, top = 0.5 * w, 0.5 * h
    leaf = leaf_points(w, h)
    points: dict[str, tuple[float, float, float]] = {}
    if "thesis" in scene.probes.sets:
        beside = [
            (right - edge, 0.0),
            (-right + edge, 0.0),
            (0.0, top - edge),
            (right - rim, 0.0),
            (-right + rim, 0.0),
            (0.0, top - rim),
            (right - rim, top - rim),
        ]
        for number, (x, y) in enumerate([*leaf.values(), *beside], start=1):
            points[f"tc_{number}"] = (x, y, t)
    if "en_1634" in scene.probes.sets:
        points |= {name: (x, y, t) for name, (x, y) in en_points(w, h).items()}
    if "interior" in scene.probes.sets:
        points |= {
            "exposed_centre": (0.0, 0.0, 0.0),
            "interior_third": (0.0, 0.0, t / 3.0),
            "interior_half": (0.0, 0.0, t / 2.0),
            "interior_two_thirds": (0.0, 0.0, 2.0 * t / 3.0),
        }
    return points


def probes_of(model: DoorModel) -> Probes:
    """The scene's probes; the points that its standards judge are always among them."""
    scene = model.scene
    t = scene.leaf.thickness
    points = {name: (x, y, t) for name, (x, y) in leaf_points(*_size(scene)).items()}
    points |= standard_points(scene)
    for standard in scene.criteria.standards:
        for rise in STANDARDS[standard].rises:
            for places in rise.of:
                points |= {name: (x, y, t) for name, (x, y) in places(*_size(scene)).items()}
    for name, p in scene.probes.points.items():
        points[name] = (p.x, p.y, t if p.z is None else p.z)
    position = np.array(list(points.values()))
    index, weight = weights_at(model, position)
    inside = np.array([0.5 * s for s in _size(scene)]) - np.abs(position[:, :2])
    edge = scene.leaf.rim is not None or bool(scene.lateral.film_coefficient or scene.lateral.emissivity)
    near = (inside < EDGE_STRIP + 1e-9) & edge
    dimension = scene.solver.dimension
    unseen = {"column": near.any(axis=1), "column_rim": near[:, 1], "full": np.zeros(len(near), dtype=bool)}
    return Probes(
        name=tuple(points),
        position=position,
        index=index,
        weight=weight,
        corner=_corners(model, position),
        blind=unseen[dimension],
        scene=scene,
    )


def _size(scene: Scene) -> tuple[float, float]:
    return scene.leaf.width, scene.leaf.height


def weights_at(model: DoorModel, position: Array) -> tuple[NDArray[np.int64], Array]:
    """Nodes and weights (P, 64) that interpolate the field at positions (P, 3), m."""
    whole = whole_leaf(model.mesh, *_size(model.scene))
    nx, ny = len(whole.x), len(whole.y)
    ix, wx = _lagrange(whole.x, position[:, 0], 4)
    iy, wy = _lagrange(whole.y, position[:, 1], 4)
    iz, wz = _through(whole.z, model.mesh.brick_layer, position[:, 2])
    node = (iz[:, :, None, None] * ny + iy[:, None, :, None]) * nx + ix[:, None, None, :]
    weight = wz[:, :, None, None] * wy[:, None, :, None] * wx[:, None, None, :]
    count = len(position)
    return whole.source[node.reshape(count, -1)], weight.reshape(count, -1)


def _corners(model: DoorModel, position: Array) -> NDArray[np.int64]:
    """The modelled nodes (P, 8) of the brick that holds each position (P, 3), m."""
    whole = whole_leaf(model.mesh, *_size(model.scene))
    nx, ny = len(whole.x), len(whole.y)
    ix, _ = _lagrange(whole.x, position[:, 0], 2)
    iy, _ = _lagrange(whole.y, position[:, 1], 2)
    iz, _ = _lagrange(whole.z, position[:, 2], 2)
    node = (iz[:, :, None, None] * ny + iy[:, None, :, None]) * nx + ix[:, None, None, :]
    return whole.source[node.reshape(len(position), -1)]


def _through(z: Array, brick_layer: NDArray[np.int64], at: Array) -> tuple[NDArray[np.int64], Array]:
    """Nodes and weights (P, 4) within the layer of each point."""
    index, weight = np.zeros((len(at), 4), dtype=np.int64), np.zeros((len(at), 4))
    brick = np.clip(np.searchsorted(z, at, side="right") - 1, 0, len(z) - 2)
    for layer in np.unique(brick_layer[brick]):
        here = np.flatnonzero(brick_layer[brick] == layer)
        mine = np.flatnonzero(brick_layer == layer)
        i, w = _lagrange(z[mine[0] : mine[-1] + 2], at[here], 4)
        index[here[:, None], np.arange(i.shape[1])] = i + mine[0]
        weight[here[:, None], np.arange(i.shape[1])] = w
    return index, weight


def _lagrange(line: Array, at: Array, points: int) -> tuple[NDArray[np.int64], Array]:
    """Nodes and weights (P, points) of the polynomial through the nearest nodes."""
    points = min(points, len(line))
    below = np.clip(np.searchsorted(line, at, side="right") - 1, 0, len(line) - 2)
    first = np.clip(below - (points // 2 - 1), 0, len(line) - points)
    index = first[:, None] + np.arange(points)
    x = line[index]
    weight = np.ones_like(x)
    for i in range(points):
        for j in range(points):
            if i != j:
                weight[:, i] *= (at - x[:, j]) / (x[:, i] - x[:, j])
    return index, weight


def unexposed_mean(model: DoorModel, temperature: Array) -> float:
    """Area mean of the unexposed face, °C."""
    area = model.mesh.unexposed_area.ravel()
    return float(area @ temperature[-len(area) :] / area.sum())


def unexposed_maximum(model: DoorModel, temperature: Array) -> float:
    """Hottest node of the unexposed face, rim and all, °C."""
    return float(temperature[-model.mesh.unexposed_area.size :].max())


class Radiometer:
    """Radiation of the unexposed face at 1 m from its centre, W/m2: EN 13501-2 5.2.4, EN 1363-2.

    The sum of emissivity sigma T^4 over the face, each part by its view factor d^2 / (pi r^4). A face whose
    emissivity the scene leaves in its film coefficient is taken as black.
    """

    def __init__(self, model: DoorModel, distance: float = 1.0) -> None:
        leaf = model.scene.leaf
        whole = whole_leaf(model.mesh, leaf.width, leaf.height)
        across, up = (((np.arange(200) + 0.5) / 200 - 0.5) * size for size in (leaf.width, leaf.height))
        area = leaf.width * leaf.height / 200**2
        r2 = across[None, :] ** 2 + up[:, None] ** 2 + distance**2
        view = area * distance**2 / (np.pi * r2**2)
        weight = _dense(whole.y, up).T @ view @ _dense(whole.x, across)
        nz, ny, nx = len(whole.z), len(whole.y), len(whole.x)
        source = whole.source.reshape(nz, ny, nx)[-1].ravel()
        self._face = model.mesh.unexposed_area.size
        first = model.nodes.shape[0] - self._face
        emissivity = model.scene.unexposed.emissivity or 1.0
        self._weight = emissivity * STEFAN_BOLTZMANN * np.bincount(source - first, weight.ravel(), self._face)

    def read(self, temperature: Array) -> float:
        """W/m2, from node temperatures (N,), °C."""
        kelvin = temperature[-self._face :] - ABSOLUTE_ZERO
        return float(self._weight @ kelvin**4)


class InfraredView:
    """The unexposed face as rows of pixels, row 0 on top, seen from the unexposed side.

    Whoever looks against +z, with +y up, has +x on the right: column 0 is at -x, the left edge of the probes'
    names. height, width : pixels; emissivity-corrected, so true °C.
    """

    def __init__(self, model: DoorModel, width: int = 96) -> None:
        leaf = model.scene.leaf
        self.width = width
        self.height = max(1, round(width * leaf.height / leaf.width))
        whole = whole_leaf(model.mesh, leaf.width, leaf.height)
        x = 0.5 * leaf.width * ((2.0 * np.arange(self.width) + 1.0) / self.width - 1.0)
        y = 0.5 * leaf.height * (1.0 - (2.0 * np.arange(self.height) + 1.0) / self.height)
        self._across = _dense(whole.x, x)
        self._up = _dense(whole.y, y)
        nz, ny, nx = len(whole.z), len(whole.y), len(whole.x)
        self._source = whole.source.reshape(nz, ny, nx)[-1]

    def image(self, temperature: Array) -> NDArray[np.float32]:
        """(height, width), °C."""
        face = temperature[self._source]
        return (self._up @ face @ self._across.T).astype(np.float32)


def _dense(line: Array, at: Array) -> Array:
    index, weight = _lagrange(line, at, 2)
    out = np.zeros((len(at), len(line)))
    np.put_along_axis(out, index, weight, axis=1)
    return out
