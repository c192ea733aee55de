"""What a scene says that can be, but hardly is: a unit that slipped, as a rule. Said, not refused.

Bounds: of solids at 20 °C, lead has the least specific heat of what doors are made of, 129 J/(kg K), and
water the most, 4190; silver conducts best, 429 W/(m K); tungsten and gold are densest, 19300 kg/m3.
"""

from __future__ import annotations

from .parts import Property
from .reactions_part import ReactionPart
from .schema import Scene

LIMITS: dict[str, tuple[float, float, str, str]] = {
    "density": (5.0, 2e4, "kg/m3", "g/cm3"),
    "specific_heat": (100.0, 1e6, "J/(kg K)", "kJ/(kg K)"),
    "conductivity": (5e-3, 450.0, "W/(m K)", "mW/(m K) or W/(cm K)"),
    "youngs_modulus": (1e2, 2e12, "Pa", "MPa or GPa"),
    "yield_strength": (1e3, 5e9, "Pa", "MPa"),
}
LEAST_HEAT = {"latent_heat": 2e4, "heat_of_combustion": 1e6}
"""J/kg; lead melts with 2.3e4, and carbon monoxide burns with 1.0e7, which is little."""
MOST_ELONGATION = 1e-3
"""1/K; steel has 1.2e-5."""
MOST_FILM = 500.0
"""W/(m2 K); a hydrocarbon fire has 50."""


def doubts(scene: Scene) -> tuple[str, ...]:
    """What to look at again, one sentence each."""
    found = []
    used = {layer.material for layer in scene.leaf.layers}
    if scene.leaf.rim is not None:
        used.add(scene.leaf.rim.material)
    for name in sorted(used & set(scene.materials)):
        part = scene.materials[name]
        for key, (low, high, unit, slip) in LIMITS.items():
            given = getattr(part, key)
            # What is zero at some temperature has no lowest worth looking at.
            values = [v for v in _values(given) if v > 0.0]
            for v in (min(values, default=None), max(values, default=None)):
                if v is not None and not low <= v <= high:
                    found.append(
                        f"materials.{name}.{key} is {v:g} {unit}, and no solid has less than {low:g} or"
                        f" more than {high:g}; is it in {slip}?"
                    )
                    break
        found += [f"materials.{name}: {said}" for r in part.all_reactions() for said in _of(r, scene.start)]
        stretch = part.elongation
        if stretch is not None and stretch.constant is not None and abs(stretch.constant) > MOST_ELONGATION:
            found.append(
                f"materials.{name}.elongation is {stretch.constant:g} 1/K, and steel has 1.2e-5;"
                " is it in 1e-6/K?"
            )
    for surface in ("exposed", "unexposed", "lateral"):
        film = getattr(scene, surface).film_coefficient
        if film is not None and film > MOST_FILM:
            found.append(f"{surface}.film_coefficient is {film:g} W/(m2 K), ten times a hydrocarbon fire's")
    return tuple(found)


def _of(reaction: ReactionPart, start: float) -> list[str]:
    called = reaction.name
    found = []
    for key, least in LEAST_HEAT.items():
        given = getattr(reaction, key)
        if given is not None and given < least:
            found.append(
                f"{key} of {called} is {given:g} J/kg, and hardly any is below {least:g}; is it in kJ/kg?"
            )
    if reaction.temperature is not None and reaction.temperature[0] < start:
        found.append(
            f"{called} begins at {reaction.temperature[0]:g} °C and the leaf is at {start:g} °C, so it"
            " has gone, all or in part, before the fire"
        )
    return found


def _values(given: Property | float | None) -> tuple[float, ...]:
    if given is None:
        return ()
    if isinstance(given, float):
        return (given,)
    if given.constant is not None:
        return (given.constant,)
    return given.value or ()
