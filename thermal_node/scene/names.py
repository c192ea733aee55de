"""Names that two things of a scene share: refused, since one would stand silently for the other."""

from __future__ import annotations

from collections.abc import Mapping

from flexsim_core.quantities import Misplaced, each_once

from .criteria_part import CriteriaPart
from .deformation_part import DeformationPart
from .leaf_part import CAVITY, Leaf
from .parts import MaterialPart, ProbesPart
from .reactions_part import MOISTURE

RESERVED = ("ftp_", "en_", "en1_", "ul_", "astm_", "unexposed_")
"""Beginnings of names that the standards' points, and what is read of the whole face, have."""
INTERIOR = ("exposed_centre", "interior_third", "interior_half", "interior_two_thirds")
"""Points of the set `interior`."""


def check_names(
    leaf: Leaf,
    materials: Mapping[str, MaterialPart],
    probes: ProbesPart,
    criteria: CriteriaPart,
    deformation: DeformationPart,
) -> None:
    """Refuse two things of one name, and name both their places; raises Misplaced."""
    for name, part in materials.items():
        _reactions(name, part)
    cavities = [n for n, layer in enumerate(leaf.layers) if layer.is_cavity]
    if cavities and CAVITY in materials:  # layers are listed by their materials
        raise Misplaced(
            ("materials", CAVITY),
            f"is named like the cavity leaf.layers.{cavities[0]}; give the material another name",
        )
    _points(probes)
    each_once(("criteria", "standard"), criteria.standard or (), "give each standard once")
    each_once(("criteria", "points"), criteria.points, "give each point once")
    _supports(leaf, deformation)


def _reactions(name: str, part: MaterialPart) -> None:
    path = ("materials", name, "reactions")
    names = [reaction.name or None for reaction in part.reactions]
    each_once(path, names, "give each reaction its own name", ("name",))
    if part.moisture is not None and MOISTURE in names:
        raise Misplaced(
            (*path, names.index(MOISTURE), "name"),
            f"is {MOISTURE!r} like materials.{name}.moisture; give each its own name",
        )


def _points(probes: ProbesPart) -> None:
    each_once(("probes", "sets"), probes.sets, "give each set once")
    for name in probes.points:
        if name.startswith(RESERVED):
            raise Misplaced(
                ("probes", "points", name), "is named like a point of a standard; give another name"
            )
        if name in INTERIOR and "interior" in probes.sets:
            raise Misplaced(
                ("probes", "points", name),
                "is named like a point of the set interior in probes.sets; give another name, or leave that"
                " set out",
            )


def _supports(leaf: Leaf, deformation: DeformationPart) -> None:
    """Hinges and locks are named after their places."""
    heights = [f"{hinge.height:g}" for hinge in deformation.hinges or ()]
    each_once(("deformation", "hinges"), heights, "give each hinge its own height", said="is at {} m")
    latch = 0.5 * leaf.width * (1.0 if deformation.hinge_side == "left" else -1.0)
    places = [
        f"{lock.height:g} m, {latch if lock.across is None else lock.across:g} m across"
        for lock in deformation.lock
    ]
    each_once(("deformation", "lock"), places, "give each lock its own place", said="is at {}")
    if deformation.stop is not None:
        each_once(("deformation", "stop", "edges"), deformation.stop.edges, "give each edge once")
