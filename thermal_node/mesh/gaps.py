"""Gaps of a leaf: contacts between layers and cavities, which heat crosses from face to face.

A gap is a brick that holds no heat. Of a contact both faces lie in one plane: two nodes at one place with two
temperatures.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..scene.leaf_part import CavityLayer, Leaf


@dataclass(frozen=True)
class Gap:
    """What heat crosses between two layers: a contact's resistance, m2 K/W, or a cavity."""

    name: str
    resistance: float | None = None
    cavity: CavityLayer | None = None


def gaps_of(leaf: Leaf) -> tuple[Gap, ...]:
    """The gaps of a leaf, from the exposed face on."""
    found = []
    for index, layer in enumerate(leaf.layers):
        if isinstance(layer, CavityLayer):
            found.append(Gap(f"leaf.layers.{index}, the cavity", cavity=layer))
        elif layer.contact_resistance is not None:
            found.append(Gap(f"leaf.layers.{index}, its contact", resistance=layer.contact_resistance))
    return tuple(found)
