"""The parts of a fire door's scene: every key, its unit, what is possible and what is refused.

Numbers are SI, temperatures °C.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from flexsim_core.quantities import Misplaced, Part, unknown
from pydantic import BeforeValidator, Field, model_validator

from .library import LIBRARY
from .quantities import (
    Count,
    Density,
    Number,
    Position,
    Positive,
    Thickness,
    between,
    number,
)
from .reactions_part import AnyMoisture, ReactionPart

Series = tuple[Number, ...]


def _property(value: Any) -> Any:
    if isinstance(value, bool) or value is None:
        raise ValueError(f"is {value!r}; give a number, a table or eurocode_3")
    if isinstance(value, (int, float)):
        return {"constant": value}
    if isinstance(value, str):
        if value != "eurocode_3":
            raise ValueError(
                f"is {value!r}; give a number (without its unit: SI), a table with temperature"
                " and value, or eurocode_3"
            )
        return {"rule": value}
    return value


class Property(Part):
    """A property over temperature: a number, a table, or Eurocode 3's rule for carbon steel.

    `beyond` says what holds above a table's last temperature: `refuse`, `hold` or `extend`.
    """

    constant: Number | None = None
    rule: Literal["eurocode_3"] | None = None
    temperature: Series | None = None
    value: Series | None = None
    beyond: Literal["refuse", "hold", "extend"] = "refuse"

    @model_validator(mode="after")
    def _whole(self) -> Property:
        if self.constant is not None or self.rule is not None:
            return self
        if self.temperature is None or self.value is None:
            raise ValueError("is not a property; give a number, or both temperature and value")
        if len(self.temperature) != len(self.value):
            raise Misplaced(
                ("value",),
                f"has {len(self.value)} entries for {len(self.temperature)} temperatures; give one for each",
            )
        if len(self.temperature) < 2:
            raise Misplaced(("temperature",), "has one entry; give two or more, or one number")
        for i, (a, b) in enumerate(zip(self.temperature, self.temperature[1:], strict=False)):
            if not b > a:
                raise Misplaced(("temperature", i + 1), f"is {b:g} after {a:g}; give increasing temperatures")
        return self

    def lowest(self) -> float:
        """The least value that the property takes."""
        values = (self.constant,) if self.constant is not None else self.value or (1.0,)
        return min(v for v in values if v is not None)


Diffusivity = Annotated[Number, between(0.0, 1e-3, "m2/s", "air has 2.05e-5", open_low=True)]
AnyProperty = Annotated[Property, BeforeValidator(_property)]


class MaterialPart(Part):
    """A material. What is left out of one called `steel`, or `standard: eurocode_3`, is
    carbon steel's by EN 1993-1-2.

    library : a material of library.py, whose values stand where nothing else is said
    density : kg/m3 as built, with what leaves in a fire; specific_heat : J/(kg K) of what stays
    moisture, reactions : what it gives or takes once
    oxygen_diffusivity : m2/s at 20 °C, of oxygen in its pores; left out, no air gets through
    """

    library: str | None = None
    standard: Literal["eurocode_3"] | None = None
    density: Density | None = None
    specific_heat: AnyProperty | None = None
    conductivity: AnyProperty | None = None
    youngs_modulus: AnyProperty | None = None
    poissons_ratio: Annotated[Number, between(-0.5, 0.49, "")] | None = None
    elongation: AnyProperty | None = None
    yield_strength: AnyProperty | None = None
    moisture: AnyMoisture = None
    reactions: tuple[ReactionPart, ...] = ()
    oxygen_diffusivity: Diffusivity | None = None

    @model_validator(mode="before")
    @classmethod
    def _from_library(cls, given: Any) -> Any:
        name = given.get("library") if isinstance(given, dict) else None
        if name is None:
            return given
        if not isinstance(name, str) or name not in LIBRARY:
            raise unknown(("library",), name, sorted(LIBRARY))
        taken = dict(LIBRARY[name].keys)
        for key, value in given.items():
            if isinstance(value, dict) and list(value) == ["beyond"] and isinstance(taken.get(key), dict):
                taken[key] = {**taken[key], **value}  # its table, with another end
            elif value is not None:
                taken[key] = value
        return taken

    @model_validator(mode="after")
    def _possible(self) -> MaterialPart:
        limits = {
            "specific_heat": (0.0, 1e5, "J/(kg K)"),
            "conductivity": (0.0, 1e5, "W/(m K)"),
        }
        for name, (low, high, unit) in limits.items():
            given: Property | None = getattr(self, name)
            if given is None or given.rule is not None:
                continue
            values = (given.constant,) if given.constant is not None else given.value or ()
            for i, value in enumerate(values):
                if value is None or low < value <= high:
                    continue
                path: tuple[str | int, ...] = (name,)
                if given.constant is None:
                    path = (name, "value", i)
                raise Misplaced(path, f"is {value:g}; give more than 0 and at most {high:g} {unit}")
        modulus = self.youngs_modulus
        if modulus is not None and modulus.rule is None and modulus.lowest() < 0.0:
            raise Misplaced(("youngs_modulus",), "is negative; give at least 0 Pa")
        if self.yield_strength is not None and self.yield_strength.lowest() < 0.0:
            raise Misplaced(("yield_strength",), "is negative; give at least 0 Pa")
        self._enough_mass()
        return self

    def _enough_mass(self) -> None:
        leaves = sum(r.share * (1.0 - r.residue) for r in self.all_reactions())
        if leaves > 0.95:
            key = "reactions" if self.reactions else "moisture"
            raise Misplaced((key,), f"let {leaves:g} of the mass leave; give at most 0.95 in all")
        for i, reaction in enumerate(self.reactions):
            if reaction.oxygen == "diffusion" and self.oxygen_diffusivity is None:
                raise Misplaced(
                    ("reactions", i, "oxygen"),
                    "is diffusion in a material without oxygen_diffusivity; give it, m2/s at 20 °C",
                )

    def all_reactions(self) -> tuple[ReactionPart, ...]:
        """Reactions, moisture first; one without a name is called after its place, reactions.0."""
        named = tuple(
            r if r.name else r.model_copy(update={"name": f"reactions.{n}"})
            for n, r in enumerate(self.reactions)
        )
        return (() if self.moisture is None else (self.moisture.reaction(),)) + named


class MeshPart(Part):
    """How fine the leaf is divided.

    in_plane : bricks across and up the modelled part, the rim's brick with them
    layers : bricks through each layer
    first_brick : m, width of the brick beside the rim; widths grow from there geometrically
    discretisation : finite volumes, or the trilinear finite elements of most other programs
    """

    in_plane: tuple[Count, Count] = (20, 40)
    layers: tuple[Count, ...] | None = None
    symmetry: Literal["quarter", "half", "none"] = "quarter"
    first_brick: Thickness = 2.5e-3
    discretisation: Literal["finite_volume", "finite_element"] = "finite_volume"


def _step(value: Any) -> Any:
    if value is None or value == "auto":
        return None
    step = number(value)
    if step <= 0.0:
        raise ValueError(f"is {value}; give more than 0 s, or auto")
    return step


class SolverPart(Part):
    """How the equations are solved.

    model : full, column, column_rim (a strip from the middle to one upright edge) or steady
    of : what `steady` is the steady state of
    step : s; auto (None): chosen so that a step's error stays below `tolerance`, K
    """

    model: Literal["full", "column", "column_rim", "steady"] = "full"
    of: Literal["full", "column", "column_rim"] = "full"
    step: Annotated[float | None, BeforeValidator(_step)] = None
    method: Literal["tr_bdf2", "sdirk2", "implicit_euler"] = "tr_bdf2"
    tolerance: Positive = 0.03

    @property
    def dimension(self) -> Literal["full", "column", "column_rim"]:
        """The model whose mesh is used."""
        return self.of if self.model == "steady" else self.model


class Point(Part):
    """A probe: x, y from the leaf's centre and z from the exposed face, m."""

    x: Position = 0.0
    y: Position = 0.0
    z: Annotated[Number, between(0.0, 2.0, "m", "metres, not millimetres")] | None = None


class ProbesPart(Part):
    """Where temperatures are read.

    sets : the standards' points and the interior's; points : one's own (z left out: on the
        unexposed face)
    """

    sets: tuple[Literal["thesis", "ftp", "en_1634", "interior"], ...] = (
        "thesis",
        "ftp",
        "en_1634",
        "interior",
    )
    points: dict[str, Point] = Field(default_factory=dict)
