"""The arrays of a model's reactions, from what its materials say of them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from ..heat.conduction import Array
from ..heat.reactions import ARRHENIUS, EQUILIBRIUM, TABLE, Reactions
from ..mesh.leaf import BRIDGED, LeafMesh
from ..scene.reactions_part import OXYGEN, ReactionPart
from .materials import Material

GAS = 8.314462618
"""J/(mol K), CODATA 2018."""
_NO_INDEX, _NO_NUMBER = np.zeros(0, dtype=np.int64), np.zeros(0)
NO_REACTIONS = Reactions(
    material=_NO_INDEX,
    kind=_NO_INDEX,
    taken=_NO_NUMBER,
    leaving=_NO_NUMBER,
    held_at=_NO_NUMBER,
    factor=_NO_NUMBER,
    activation=_NO_NUMBER,
    order=_NO_NUMBER,
    least=_NO_NUMBER,
    start=np.zeros(1, dtype=np.int64),
    knot=_NO_NUMBER,
    value=_NO_NUMBER,
    oxygen=_NO_NUMBER,
    diffusion=_NO_NUMBER,
    open=_NO_NUMBER,
)
NOTICED = 1e-3
"""1/s at which a reaction's heat is taken to hold as given; it then takes a quarter of an hour."""
FREE_AIR = 2.05e-5
"""m2/s, oxygen in air at 20 °C, of a cavity or a contact."""


def reactions_of(materials: tuple[Material, ...], mesh: LeafMesh) -> Reactions | None:
    """The reactions of a model's materials, or None."""
    each = [(m, r) for m, material in enumerate(materials) for r in material.reactions]
    if not each:
        return None
    density = np.array([materials[m].density for m, _ in each])
    held_at = np.array([held_at_of(r) for _, r in each])
    specific = [
        float(materials[m].specific_heat(t)) if r.specific_heat is None else r.specific_heat
        for (m, r), t in zip(each, held_at, strict=True)
    ]
    leaves = np.array([r.share * (1.0 - r.residue) for _, r in each])
    tables = [_table(r) for _, r in each]
    kinetics = [r.kinetics for _, r in each]
    limited = any(r.oxygen == "diffusion" for _, r in each)
    diffusion, reached = _ways_of_air(materials, mesh) if limited else (np.zeros(0), np.zeros(0))
    return Reactions(
        material=np.array([m for m, _ in each]),
        kind=np.array([_kind(r) for _, r in each]),
        taken=density * np.array([r.share * _taken(r) for _, r in each]),
        leaving=density * leaves * np.array(specific),
        held_at=held_at,
        factor=np.array([k.frequency_factor if k else 0.0 for k in kinetics]),
        activation=np.array([k.activation_energy / GAS if k else 0.0 for k in kinetics]),
        order=np.array([k.order if k else 1.0 for k in kinetics]),
        least=np.array([k.above if k else -np.inf for k in kinetics]),
        start=np.concatenate([[0], np.cumsum([len(t[0]) for t in tables])]).astype(np.int64),
        knot=np.concatenate([t[0] for t in tables]),
        value=np.concatenate([t[1] for t in tables]),
        oxygen=density
        * np.array([r.share * -_taken(r) / OXYGEN if r.oxygen == "diffusion" else 0.0 for _, r in each]),
        diffusion=diffusion,
        open=reached,
    )


def held_at_of(reaction: ReactionPart) -> float:
    """Temperature, °C, at which a reaction's heat is as given.

    The mean of an equilibrium's range; of a rate where it has reached NOTICED, or half its most.
    """
    if reaction.temperature is not None:
        temperature, degree = reaction.course()
        steps = zip(pairwise(temperature), pairwise(degree), strict=True)
        return sum(0.5 * (a + b) * (y - x) for (a, b), (x, y) in steps)
    if reaction.rate is not None:
        rate = reaction.rate
        enough = np.array(rate.value) >= min(NOTICED, 0.5 * max(rate.value))
        return float(rate.temperature[int(np.argmax(enough))])
    assert reaction.kinetics is not None
    k = reaction.kinetics
    quick = np.log(k.frequency_factor / NOTICED)
    kelvin = k.activation_energy / GAS / quick if quick > 0.0 else np.inf
    return float(np.clip(kelvin - 273.15, 20.0, 1000.0))


def _kind(reaction: ReactionPart) -> int:
    if reaction.temperature is not None:
        return EQUILIBRIUM
    return TABLE if reaction.rate is not None else ARRHENIUS


def _taken(reaction: ReactionPart) -> float:
    """J/kg; negative where it gives."""
    if reaction.latent_heat is not None:
        return reaction.latent_heat
    assert reaction.heat_of_combustion is not None
    return -reaction.heat_of_combustion


def _table(reaction: ReactionPart) -> tuple[Array, Array]:
    if reaction.temperature is not None:
        temperature, degree = reaction.course()
        return np.array(temperature), np.array(degree)
    if reaction.rate is not None:
        return np.array(reaction.rate.temperature), np.array(reaction.rate.value)
    return np.zeros(0), np.zeros(0)


def _ways_of_air(materials: tuple[Material, ...], mesh: LeafMesh) -> tuple[Array, Array]:
    """Diffusivity at 20 °C times cross-section over length of edges along z (N,), m3/s, and whether air
    reaches the unexposed face's nodes (plane,)."""
    solids = len(mesh.material_names)
    nz, ny, nx = mesh.shape
    brick = mesh.brick_material
    through = np.array([m.oxygen_diffusivity for m in materials[:solids]] + [FREE_AIR] * mesh.gaps)
    length = np.maximum(np.diff(mesh.z), BRIDGED)[:, None, None]
    # Nodes stand in the corners of bricks: the way behind a node is as wide as the bricks around it are open.
    free = _to_nodes(through[brick] / length, ny, nx)
    area = mesh.exposed_area
    diffusion = np.zeros((nz, ny, nx))
    diffusion[:-1] = free * area
    return diffusion.ravel(), (free[-1] > 0.0).astype(float).ravel()


def _to_nodes(bricks: Array, ny: int, nx: int) -> Array:
    """Mean of the bricks around each line of nodes (bz, ny, nx)."""
    for axis, nodes in ((1, ny), (2, nx)):
        if nodes > 1:
            low = np.take(bricks, [0, *range(nodes - 1)], axis=axis)
            high = np.take(bricks, [*range(nodes - 1), nodes - 2], axis=axis)
            bricks = 0.5 * (low + high)
    return bricks
