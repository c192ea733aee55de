"""What a scene says of what a material gives or takes once: moisture, dehydration, burning.

Numbers are SI, temperatures °C. Shares are of the material's mass as built, which its density is of.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal

from flexsim_core.quantities import Misplaced, Part, between
from pydantic import BeforeValidator, model_validator

from .quantities import Fraction, Number, Temperature

MOISTURE = "moisture"
"""What a material's moisture is called among its reactions."""
WATER, STEAM = 4187.0, 2.257e6
"""Specific heat of water from 0 to 100 °C, J/(kg K), and its latent heat at 100 °C, J/kg (IAPWS-95)."""
OXYGEN = 13.1e6
"""J that organic matter gives for each kg of oxygen (Huggett 1980, Fire and Materials 4, 61-65)."""

Temperatures = tuple[Temperature, ...]
Share = Annotated[Number, between(0.0, 0.95, "", "of the mass, not per cent", open_low=True)]
Heat = Annotated[Number, between(1e3, 2e8, "J/kg", "joules, not kilojoules")]
SpecificHeat = Annotated[Number, between(0.0, 2e4, "J/(kg K)")]
Rate = Annotated[Number, between(0.0, 1e3, "1/s")]


def _increasing(temperature: Temperatures, values: tuple[float, ...], key: str) -> None:
    if len(temperature) < 2:
        raise Misplaced(("temperature",), "has fewer than two entries; give two or more")
    if len(values) != len(temperature):
        entries = f"{len(values)} entries for {len(temperature)} temperatures"
        raise Misplaced((key,), f"has {entries}; give one for each")
    for i, (a, b) in enumerate(pairwise(temperature)):
        if not b > a:
            raise Misplaced(("temperature", i + 1), f"is {b:g} after {a:g}; give increasing temperatures")


class KineticsPart(Part):
    """Rate of a reaction by Arrhenius, x' = A exp(-E / (R T)) (1 - x)^n.

    frequency_factor : A, 1/s; activation_energy : E, J/mol; order : n; above : °C, no rate below
    """

    frequency_factor: Annotated[Number, between(0.0, 1e30, "1/s", open_low=True)]
    activation_energy: Annotated[Number, between(1e3, 1e6, "J/mol", "joules, not kilojoules")]
    order: Annotated[Number, between(0.0, 5.0, "", open_low=True)] = 1.0
    above: Temperature = -273.15


class RatePart(Part):
    """Rate of a reaction by a table, x' = r(T) (1 - x).

    value : r, 1/s; temperature : °C; end values are held
    """

    temperature: Temperatures
    value: tuple[Rate, ...]

    @model_validator(mode="after")
    def _whole(self) -> RatePart:
        _increasing(self.temperature, self.value, "value")
        if max(self.value) == 0.0:
            raise Misplaced(("value",), "is zero throughout; give a rate, or leave the reaction out")
        return self


class ReactionPart(Part):
    """A reaction that a material goes through once.

    share : of the material's mass that takes part; residue : of that share what stays behind
    latent_heat (taken) or heat_of_combustion (given) : J/kg of what takes part
    specific_heat : J/(kg K) of what leaves; left out, the material's
    temperature : °C over which it goes from none to all, evenly, or as `degree` says; or
    kinetics, or rate : how fast it goes
    oxygen : unlimited, or diffusion: as fast as oxygen comes in from the unexposed face
    """

    name: str = ""
    share: Share
    residue: Fraction = 0.0
    latent_heat: Heat | None = None
    heat_of_combustion: Heat | None = None
    specific_heat: SpecificHeat | None = None
    temperature: Temperatures | None = None
    degree: tuple[Fraction, ...] | None = None
    kinetics: KineticsPart | None = None
    rate: RatePart | None = None
    oxygen: Literal["unlimited", "diffusion"] = "unlimited"

    @model_validator(mode="after")
    def _possible(self) -> ReactionPart:
        if (self.latent_heat is None) == (self.heat_of_combustion is None):
            raise ValueError("says nothing or too much of its heat; give latent_heat or heat_of_combustion")
        if sum(x is not None for x in (self.temperature, self.kinetics, self.rate)) != 1:
            raise ValueError("says nothing or too much of its course; give temperature, kinetics or rate")
        if self.degree is not None and self.temperature is None:
            raise Misplaced(("degree",), "stands without temperature; give both, or kinetics or rate alone")
        if self.temperature is not None:
            if self.heat_of_combustion is not None:
                raise Misplaced(
                    ("temperature",),
                    "is all that is said of what burns; what gives heat needs time: give kinetics or rate",
                )
            self._goes_from_none_to_all()
        if self.oxygen == "diffusion" and self.heat_of_combustion is None:
            raise Misplaced(("oxygen",), "stands beside latent_heat; only what burns needs oxygen")
        return self

    def _goes_from_none_to_all(self) -> None:
        temperature, degree = self.course()
        _increasing(temperature, degree, "degree")
        for i, (a, b) in enumerate(pairwise(degree)):
            if b < a:
                raise Misplaced(("degree", i + 1), f"is {b:g} after {a:g}; give degrees that don't fall")
        if degree[0] != 0.0 or degree[-1] != 1.0:
            ends = f"{degree[0]:g} to {degree[-1]:g}"
            raise Misplaced(("degree",), f"goes from {ends}; give 0 first and 1 last")

        leaves = (1.0 - self.residue) * (2000.0 if self.specific_heat is None else self.specific_heat)
        if self.latent_heat is not None and self.latent_heat < leaves * (temperature[-1] - temperature[0]):
            raise Misplaced(
                ("latent_heat",),
                f"is {self.latent_heat:g}, less than what leaves holds over its range of temperature; give"
                " more, or a narrower range",
            )

    def course(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Temperatures, °C, and degrees of a reaction that is given by `temperature`."""
        assert self.temperature is not None
        if self.degree is not None:
            return self.temperature, self.degree
        last = len(self.temperature) - 1
        if last != 1:
            raise Misplaced(("temperature",), f"has {last + 1} entries; give two, or a degree for each")
        return self.temperature, (0.0, 1.0)


class MoisturePart(Part):
    """Water that evaporates once: `share` of the mass, from the first to the second `temperature`, °C."""

    share: Share
    temperature: tuple[Temperature, Temperature] = (100.0, 120.0)
    latent_heat: Heat = STEAM
    specific_heat: SpecificHeat = WATER

    @model_validator(mode="after")
    def _possible(self) -> MoisturePart:
        _increasing(self.temperature, (0.0, 1.0), "temperature")
        return self

    def reaction(self) -> ReactionPart:
        """The same as a reaction."""
        return ReactionPart(
            name=MOISTURE,
            share=self.share,
            temperature=self.temperature,
            latent_heat=self.latent_heat,
            specific_heat=self.specific_heat,
        )


def moisture(value: Any) -> Any:
    """One number is the share."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return {"share": value}
    return value


AnyMoisture = Annotated[MoisturePart | None, BeforeValidator(moisture)]
