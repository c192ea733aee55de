"""The mesh that a scene asks for."""

from __future__ import annotations

import numpy as np

from ..scene.leaf_part import Leaf
from ..scene.schema import Scene
from .gaps import gaps_of
from .grading import Array, graded_both, graded_from_end
from .leaf import CONTACT, LeafMesh, leaf_mesh

THICK_BRICKS = {"full": 12, "column_rim": 24, "column": 60}
MIDDLE_TO_FACE = 1.5
"""How much wider a thick layer's middle bricks are than those at its faces."""


def door_mesh(scene: Scene) -> LeafMesh:
    """Bricks for the scene's leaf and model.

    A column is 1 m2, a column with its rim a strip 1 m high; the full leaf is a quarter, the
    half at +x, or the whole.
    """
    leaf, dimension = scene.leaf, scene.solver.dimension
    counts = scene.mesh.layers or tuple(layer.bricks(THICK_BRICKS[dimension]) for layer in leaf.layers)
    z, stations = _through(leaf, counts)
    mirror: tuple[str, ...] = ()
    x: Array = np.zeros(1)
    y: Array = np.zeros(1)
    symmetry = scene.mesh.symmetry
    if dimension != "column":
        mirror_x = symmetry != "none"
        x = _across(scene, leaf.width, scene.mesh.in_plane[0], mirror_x)
        mirror += ("x",) if mirror_x else ()
    if dimension == "full":
        mirror_y = symmetry == "quarter"
        y = _across(scene, leaf.height, scene.mesh.in_plane[1], mirror_y)
        mirror += ("y",) if mirror_y else ()

    names = tuple(dict.fromkeys(layer.material for layer in leaf.layers if not layer.is_cavity))
    if leaf.rim is not None and leaf.rim.material not in names:
        names += (leaf.rim.material,)
    bricks = (len(z) - 1, max(len(y) - 1, 1), max(len(x) - 1, 1))
    material = np.empty(bricks, dtype=np.int64)
    gaps = gaps_of(leaf)
    solids, at = len(names), 0
    for k, (index, is_contact) in enumerate(stations):
        if is_contact or leaf.layers[index].is_cavity:
            material[k] = solids + at
            at += 1
        else:
            material[k] = names.index(leaf.layers[index].material)
    through = np.ones(bricks)
    lateral = (
        len(x) > 1 and "x" not in mirror,
        len(x) > 1,
        len(y) > 1 and "y" not in mirror,
        len(y) > 1,
    )
    if leaf.rim is not None:
        edge = np.zeros(bricks, dtype=bool)
        for side, wanted in enumerate(lateral):
            if wanted:
                at = -1 if side % 2 else 0
                if side < 2:
                    edge[:, :, at] = True
                else:
                    edge[:, at, :] = True
        rim = names.index(leaf.rim.material)
        edge &= material != rim
        material[edge] = rim
        through[edge] = leaf.rim.contact
    steady = scene.solver.model == "steady" and scene.exposed.held is None
    held = (bool(scene.exposed.held) or steady, bool(scene.unexposed.held))
    finite_elements = scene.mesh.discretisation == "finite_element"
    layer_of = np.array([CONTACT if is_contact else index for index, is_contact in stations])
    return leaf_mesh(
        x, y, z, material, names, through, lateral, layer_of, mirror, held, finite_elements, len(gaps)
    )


def _through(leaf: Leaf, counts: tuple[int, ...]) -> tuple[Array, list[tuple[int, bool]]]:
    """Nodes through the thickness, and of each brick its layer and whether it is the contact before it."""
    z: list[Array] = [np.zeros(1)]
    stations: list[tuple[int, bool]] = []
    for index, (layer, count) in enumerate(zip(leaf.layers, counts, strict=True)):
        if layer.contact_resistance is not None:
            z.append(z[-1][-1:])
            stations.append((index, True))
        z.append(z[-1][-1] + graded_both(layer.thickness, count, MIDDLE_TO_FACE)[1:])
        stations += [(index, False)] * count
    return np.concatenate(z), stations


def _across(scene: Scene, size: float, count: int, mirrored: bool) -> Array:
    """Nodes from the centre (or the far edge) to the leaf's edge, the rim's brick last."""
    rim, lateral = scene.leaf.rim, scene.lateral
    graded = rim is not None or bool(lateral.film_coefficient or lateral.emissivity)
    first = scene.mesh.first_brick if graded else size
    thickness = 0.0 if rim is None else rim.thickness
    if mirrored:
        inner = count if rim is None else count - 1
        x = graded_from_end(0.5 * size - thickness, inner, first)
        return x if rim is None else np.append(x, 0.5 * size)
    inner = count if rim is None else count - 2
    x = graded_from_end(size - 2.0 * thickness, inner, first, both=True)
    x = x - 0.5 * x[-1]
    return x if rim is None else np.concatenate([[-0.5 * size], x, [0.5 * size]])
