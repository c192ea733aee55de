"""What a scene says of the furnace, of what it radiates, and of how surfaces meet it.

Numbers are SI, temperatures °C.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any, Literal

from flexsim_core.quantities import Misplaced, Part, between
from pydantic import BeforeValidator, Field, model_validator

from .quantities import Emissivity, FilmCoefficient, NotNegative, Number, Positive, Temperature, number

Series = tuple[Number, ...]
Temperatures = tuple[Temperature, ...]
Readings = tuple[Annotated[float | None, BeforeValidator(lambda v: None if v is None else number(v))], ...]
Incident = Annotated[Number, between(0.0, 1e6, "W/m2", "watts, not kilowatts")]
Flux = Annotated[Number, between(-1e6, 1e6, "W/m2")]


def over_time(time: tuple[float, ...] | None, value: Any, key: str) -> None:
    """Refuse times and values that make no table over time."""
    if not isinstance(value, tuple):
        if time is not None:
            raise Misplaced(("time",), f"stands beside one {key}; give one {key} for each time, or no time")
        return
    if time is None:
        raise Misplaced((key,), "is a list without time; give time, s, as well, or one number")
    if len(time) != len(value):
        raise Misplaced((key,), f"has {len(value)} entries for {len(time)} times; give one for each")
    if len(time) < 2:
        raise Misplaced(("time",), "has fewer than two entries; give two or more")
    if time[0] != 0.0:
        raise Misplaced(("time", 0), f"is {time[0]:g}; give 0 s, the beginning of the fire, first")
    for i, (a, b) in enumerate(pairwise(time)):
        if not b > a:
            raise Misplaced(("time", i + 1), f"is {b:g} after {a:g}; give increasing times")


class ParametricPart(Part):
    """A natural fire by EN 1991-1-2 Annex A; the ranges are those in which it holds.

    opening_factor : O, m^0.5; absorptivity : b of the enclosure, J/(m2 s^0.5 K)
    fire_load : q_td, MJ/m2 of the whole enclosing surface; growth : sets t_lim
    """

    opening_factor: Annotated[
        Number, between(0.02, 0.2, "m^0.5", "area of the openings x root of their height / enclosing surface")
    ]
    absorptivity: Annotated[Number, between(100.0, 2200.0, "J/(m2 s^0.5 K)")]
    fire_load: Annotated[Number, between(50.0, 1000.0, "MJ/m2", "of the enclosing surface, not of the floor")]
    growth: Literal["slow", "medium", "fast"] = "medium"


class RadiationPart(Part):
    """What the furnace radiates, where that is not its gas' temperature.

    temperature : °C; incident_flux : W/m2; either one number, or one for each `time`, s
    """

    temperature: Temperature | Temperatures | None = None
    incident_flux: Incident | tuple[Incident, ...] | None = None
    time: Series | None = None

    @model_validator(mode="after")
    def _whole(self) -> RadiationPart:
        if (self.temperature is None) == (self.incident_flux is None):
            raise ValueError("says nothing or too much; give temperature or incident_flux")
        if self.temperature is not None:
            over_time(self.time, self.temperature, "temperature")
        else:
            over_time(self.time, self.incident_flux, "incident_flux")
        return self


def _flux(value: Any) -> Any:
    return value if isinstance(value, dict) or value is None else {"value": value}


class FluxPart(Part):
    """Heat that enters a surface besides what its gas gives: `value`, W/m2, one or one for each `time`, s."""

    value: Flux | tuple[Flux, ...]
    time: Series | None = None

    @model_validator(mode="after")
    def _whole(self) -> FluxPart:
        over_time(self.time, self.value, "value")
        return self


class Burners(Part):
    """A lumped furnace: gas heated by burners under a controller, losing heat to its walls.

    power : W of one burner at most; volume : m3; wall_area : m2; wall_effusivity : J/(m2 K s^0.5)
    gain : 1/K, share of full power asked for per kelvin below the curve
    integral_time : s; lag : s, a burner's
    """

    count: Annotated[int, Field(ge=1, le=100, strict=True)] = 4
    power: Positive = 5.0e5
    volume: Positive = 18.0
    wall_area: Positive = 45.0
    wall_effusivity: Positive = 300.0
    gain: Positive = 0.02
    integral_time: Positive = 60.0
    lag: NotNegative = 4.0


class FurnacePart(Part):
    """What heats the exposed face.

    curve : a standard's curve, `constant`, `table` (`time` in s from 0 on, `temperature` in °C, straight
        between), `parametric`, or `measured` (a CSV `file` with columns time and temperature, or here
        `time` and `temperature`, or `thermocouples`)
    parametric : a natural fire; radiation : what is not radiated at the gas' temperature
    thermocouples : °C, one row each, null where it did not read; their mean heats the door, each is judged
    longest_gap : s between two measured values that is bridged straight; longer is refused
    burners : a lumped furnace that follows the curve, instead of the curve itself
    """

    curve: Literal[
        "iso_834",
        "hydrocarbon",
        "external",
        "astm_e119",
        "ul_1709",
        "modified_hydrocarbon",
        "rws",
        "slow_heating",
        "parametric",
        "table",
        "constant",
        "measured",
    ] = "iso_834"
    temperature: Temperature | Series | None = None
    time: Series | None = None
    thermocouples: Annotated[tuple[Readings, ...], Field(min_length=1)] | None = None
    file: str | None = None
    longest_gap: Positive = 60.0
    burners: Burners | None = None
    parametric: ParametricPart | None = None
    radiation: RadiationPart | None = None

    @model_validator(mode="after")
    def _whole(self) -> FurnacePart:
        if (self.curve == "parametric") != (self.parametric is not None):
            raise Misplaced(
                ("parametric",),
                "is missing; give opening_factor, absorptivity and fire_load"
                if self.parametric is None
                else f"stands beside the curve {self.curve}; give curve: parametric",
            )
        if self.curve == "table":
            if self.file is not None or self.thermocouples is not None:
                raise ValueError("has a table and a log; give curve: measured for the log")
            if not isinstance(self.temperature, tuple):
                raise Misplaced(("temperature",), "is no list; a table needs time and temperature")
            over_time(self.time, self.temperature, "temperature")
            for i, value in enumerate(self.temperature):
                if not -273.15 <= value <= 3000.0:
                    raise Misplaced(("temperature", i), f"is {value:g}; give -273.15 to 3000 °C")
        elif self.curve == "constant":
            if not isinstance(self.temperature, float):
                raise Misplaced(("temperature",), "is missing; a constant furnace needs one, in °C")
        elif self.curve == "measured":
            if (self.file is None) == (self.time is None):
                raise ValueError("has no measurement; give file, or time and temperature")
            if self.thermocouples is not None:
                self._rows(self.thermocouples)
        elif any(v is not None for v in (self.temperature, self.time, self.file, self.thermocouples)):
            raise ValueError(
                f"has a {self.curve} curve and a temperature; give curve: constant, table or measured"
            )
        return self

    def _rows(self, thermocouples: tuple[Readings, ...]) -> None:
        if self.time is None or self.temperature is not None:
            raise Misplaced(("thermocouples",), "stand beside time, in place of temperature and of file")
        for n, row in enumerate(thermocouples):
            if len(row) != len(self.time):
                raise Misplaced(
                    ("thermocouples", n),
                    f"has {len(row)} readings for {len(self.time)} times; give one a time, or null",
                )


class SurfacePart(Part):
    """How a surface meets its gas: convection, radiation, or held at the gas' temperature.

    film_coefficient : W/(m2 K); emissivity : -, resulting; flux : W/m2 that enters besides
    """

    film_coefficient: FilmCoefficient | None = None
    emissivity: Emissivity | None = None
    gas: Literal["furnace", "ambient"] | None = None
    held: bool | None = None
    flux: Annotated[FluxPart | None, BeforeValidator(_flux)] = None

    @model_validator(mode="after")
    def _possible(self) -> SurfacePart:
        if self.flux is not None and self.held:
            raise Misplaced(("flux",), "enters a surface whose temperature is held; give one of the two")
        return self


class LateralPart(SurfacePart):
    """The leaf's outer edge.

    depth : m from the exposed face, to where a rebate or the frame covers it; covered, it is adiabatic.
        Left out, all of it is free
    """

    depth: Annotated[Number, between(0.0, 2.0, "m", "metres, not millimetres", open_low=True)] | None = None
