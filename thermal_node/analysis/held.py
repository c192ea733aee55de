"""What a fit holds as the scene has it, and how far that moves the readings of the logs.

A fit's intervals take what is held for exact. So each held number is made 10 % less and the model is run
again. What moves a reading by more than a thermocouple's error is seen by the logs: where it is wrong, the
error goes into the parameters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..model.door_model import HELD, DoorModel
from ..scene.leaf_part import CavityLayer
from ..scene.parts import MaterialPart, Property
from ..scene.reactions_part import ReactionPart
from ..scene.schema import Scene

CHANGE = 0.1
"""Share by which each is made less."""
SURFACES = ("exposed", "unexposed", "lateral")


@dataclass(frozen=True)
class Change:
    """A held number, and the keys that make it 10 % less; none where it can't be."""

    name: str
    value: str
    unit: str
    overrides: dict[str, Any] = field(default_factory=dict)


def held_by(scene: Scene, model: DoorModel, fitted: Mapping[str, Any], known: float) -> list[Change]:
    """What a scene says besides what is fitted.

    fitted : dotted keys of the scene that are, with their values to begin with
    known : °C up to which a conductivity that is fitted is held
    """
    leaf = scene.leaf
    used = dict.fromkeys(layer.material for layer in leaf.layers if not layer.is_cavity)
    if leaf.rim is not None and scene.solver.dimension != "column":
        used[leaf.rim.material] = None
    found = [c for name in used for c in _of_material(scene, name, fitted, known)]
    for n, layer in enumerate(leaf.layers):
        key = f"leaf.layers.{n}"
        if isinstance(layer, CavityLayer):
            ends = [(1.0 - CHANGE) * e for e in layer.emissivity]
            value = " and ".join(f"{e:g}" for e in layer.emissivity)
            found.append(Change(f"{key} cavity's emissivities", value, "-", {f"{key}.emissivity": ends}))
            found.append(Change(f"{key} cavity's convection", layer.convection, ""))
        elif layer.contact_resistance is not None:
            found.append(_number(f"{key} contact resistance", layer.contact_resistance, "m2 K/W",
                                 f"{key}.contact_resistance"))  # fmt: skip
    if leaf.rim is not None and scene.solver.dimension != "column" and "leaf.rim.contact" not in fitted:
        found.append(_number("rim contact", leaf.rim.contact, "-", "leaf.rim.contact"))
    for n, surface in enumerate(SURFACES):
        film, emissivity = float(model.surface.film[n]), float(model.surface.emissivity[n])
        if film < HELD and model.surface.area[n].any():
            found.append(
                _number(f"{surface} film coefficient", film, "W/(m2 K)", f"{surface}.film_coefficient")
            )
            found.append(_number(f"{surface} emissivity", emissivity, "-", f"{surface}.emissivity"))
    return [c for c in found if c.value != "0"]


def _of_material(scene: Scene, name: str, fitted: Mapping[str, Any], known: float) -> list[Change]:
    part = scene.materials.get(name, MaterialPart())
    key = f"materials.{name}"
    found = []
    by_rule = []
    for what, unit in (("conductivity", "W/(m K)"), ("specific_heat", "J/(kg K)")):
        words = what.replace("_", " ")
        given: Property | None = getattr(part, what)
        if f"{key}.{what}" in fitted:
            table = fitted[f"{key}.{what}"]
            below = [v for t, v in zip(table["temperature"], table["value"], strict=True) if t <= known]
            if below and given is not None and given.constant is None:  # of a constant all is fitted
                less = {**table, "value": [(1.0 - CHANGE) * v for v in below] + table["value"][len(below) :]}
                held = f"{name} {words} to {known:g} °C"
                found.append(Change(held, _range(below), unit, {f"{key}.{what}": less}))
        elif given is None or given.rule is not None:
            by_rule.append(words)
        elif given.constant is not None:
            found.append(_number(f"{name} {words}", given.constant, unit, f"{key}.{what}"))
        elif given.value is not None:
            lower = [(1.0 - CHANGE) * v for v in given.value]
            found.append(Change(f"{name} {words}", _range(given.value), unit, {f"{key}.{what}.value": lower}))
    if by_rule:
        found.append(Change(f"{name} {' and '.join(by_rule)}", "EN 1993-1-2", ""))
    if part.density is not None and f"{key}.density" not in fitted:
        found.append(_number(f"{name} density", part.density, "kg/m3", f"{key}.density"))
    if part.moisture is not None:
        found += _of_reaction(f"{name} moisture", part.moisture.reaction(), f"{key}.moisture")
    every = part.all_reactions()[-len(part.reactions) :] if part.reactions else ()
    for n, reaction in enumerate(every):
        found += _of_reaction(f"{name} {reaction.name}", reaction, f"{key}.reactions.{n}")
    if part.oxygen_diffusivity is not None and any(r.oxygen == "diffusion" for r in part.reactions):
        found.append(_number(f"{name} oxygen diffusivity", part.oxygen_diffusivity, "m2/s",
                             f"{key}.oxygen_diffusivity"))  # fmt: skip
    return found


def _of_reaction(name: str, reaction: ReactionPart, key: str) -> list[Change]:
    found = [_number(f"{name}: share", reaction.share, "-", f"{key}.share")]
    for what in ("latent_heat", "heat_of_combustion"):
        heat = getattr(reaction, what)
        if heat is not None:
            found.append(_number(f"{name}: {what.replace('_', ' ')}", heat, "J/kg", f"{key}.{what}"))
    if reaction.kinetics is not None:
        factor = reaction.kinetics.frequency_factor
        found.append(_number(f"{name}: frequency factor", factor, "1/s", f"{key}.kinetics.frequency_factor"))
    elif reaction.rate is not None:
        less = [(1.0 - CHANGE) * v for v in reaction.rate.value]
        found.append(Change(f"{name}: rate", _range(reaction.rate.value), "1/s", {f"{key}.rate.value": less}))
    elif reaction.temperature is not None:
        ends = f"{reaction.temperature[0]:g} to {reaction.temperature[-1]:g}"
        lower = [(1.0 - CHANGE) * t for t in reaction.temperature]
        found.append(Change(f"{name}: its temperatures", ends, "°C", {f"{key}.temperature": lower}))
    return found


def _number(name: str, value: float, unit: str, key: str) -> Change:
    return Change(name, f"{value:g}", unit, {key: (1.0 - CHANGE) * value})


def _range(values: Sequence[float]) -> str:
    low, high = min(values), max(values)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"
