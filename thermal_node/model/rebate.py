"""The part of a leaf's edge that a rebate leaves free: from the exposed face to some depth."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..heat.conduction import Array
from ..mesh.leaf import LeafMesh


def free_edge(mesh: LeafMesh, depth: float) -> Array:
    """Areas (nz, ny, nx), m2, of the edge's nodes from the exposed face to `depth` m; the rest is covered.

    A node has the integral of its linear function over that part: the areas' sum is exactly the part's, and
    a flux that is linear in z is integrated exactly.
    """
    z = mesh.z
    weight = np.zeros(len(z))
    # What stands at the leaf's edge, which is at the last nodes of every model.
    solid = mesh.brick_material[:, -1, -1] < len(mesh.material_names)
    for k, (low, high) in enumerate(pairwise(z)):
        if not solid[k] or high <= low:  # a cavity's mouth, or a contact between layers
            continue
        end = min(high, depth)
        if end <= low:
            break
        share = (end - low) / (high - low)
        weight[k] += (end - low) * (1.0 - 0.5 * share)
        weight[k + 1] += (end - low) * 0.5 * share
    return np.asarray(weight[:, None, None] * (mesh.lateral_area.sum(axis=0) / np.diff(z)[solid].sum()))
