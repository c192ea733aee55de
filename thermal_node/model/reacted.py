"""How far the materials of a whole leaf have reacted, from the degrees at its nodes."""

from __future__ import annotations

import numpy as np

from ..heat.conduction import Array
from .door_model import DoorModel


class Reacted:
    """Means of the degrees of reaction.

    name (P,) : material and reaction of each; a reaction whose material the model's mesh lacks is left out
    """

    def __init__(self, model: DoorModel) -> None:
        each = [
            (m, material.name, r.name)
            for m, material in enumerate(model.materials)
            for r in material.reactions
        ]
        volume = model.grid.volume.reshape(len(model.materials), -1)
        self._there = [p for p, (m, _, _) in enumerate(each) if volume[m].any()]
        self.name = tuple(each[p][1:] for p in self._there)
        share = volume[[each[p][0] for p in self._there]]
        self._weight = share / share.sum(axis=1, keepdims=True)

    def read(self, degree: Array | None) -> Array:
        """Mean (P,) over each material's mass, 0 to 1, of degrees at the nodes (all reactions, N)."""
        if degree is None:
            return np.zeros(0)
        return np.clip(np.einsum("pn,pn->p", self._weight, degree[self._there]), 0.0, 1.0)
