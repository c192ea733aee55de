"""The node's parameters: their defaults, what they mean, and what is refused."""

from __future__ import annotations

import array
import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from ..furnace.plausibility import Limits

OVERRIDE = "override."
CHANGEABLE = (
    "time_scale",
    "duration",
    "furnace_timeout",
    "furnace_lowest",
    "furnace_highest",
    "furnace_rate",
    "furnace_jump",
    "furnace_confirmations",
    "field_rate",
    "publish_clock",
)
"""What may be set while the node runs."""
WHOLE = 1e-6
"""How far a period may be from a whole number of ticks."""
SLOWEST, FASTEST = 1e-6, 1e9
"""Simulated over real time."""
KINDS = {str: "text", float: "a number", bool: "true or false", int: "a whole number"}


class SettingError(ValueError):
    """A parameter that can't be: its name, what is wrong, and what would be right."""


def _setting(default: Any, meaning: str) -> Any:
    return field(default=default, metadata={"meaning": meaning})


@dataclass(frozen=True)
class Settings:
    """The parameters of thermal_node; rates and times are those of simulated time."""

    scene: str = _setting("", "path of the scene's YAML file")
    rate: float = _setting(1.0, "furnace, thermocouples and criteria a second, Hz")
    field_rate: float = _setting(0.1, "temperature fields and infrared images a second, Hz")
    deflection_period: float = _setting(30.0, "s between deflections; 0.0: none")
    time_scale: float = _setting(1.0, "simulated over real time; 0.0 or .inf: as fast as it goes")
    duration: float = _setting(0.0, "s after which the test ends and time stands; 0.0: never")
    publish_clock: bool = _setting(False, "whether to publish /clock")
    wait_for_furnace: bool = _setting(False, "whether time stands still until the first measured temperature")
    furnace_timeout: float = _setting(10.0, "s without a measured temperature after which it is called stale")
    furnace_lowest: float = _setting(-40.0, "°C; a measured temperature below it is refused")
    furnace_highest: float = _setting(1360.0, "°C; a measured temperature above it is refused")
    furnace_rate: float = _setting(50.0, "K/s that a measured temperature may change; 0.0: any")
    furnace_jump: float = _setting(60.0, "K that it may be off besides, however soon it comes")
    furnace_confirmations: int = _setting(
        5, "measured temperatures in a row that agree after which a change that is too fast is believed"
    )
    override: Mapping[str, Any] = field(default_factory=dict)

    @property
    def limits(self) -> Limits:
        """Which measured temperatures are believed."""
        return Limits(
            self.furnace_lowest,
            self.furnace_highest,
            self.furnace_rate,
            self.furnace_jump,
            self.furnace_confirmations,
        )

    @property
    def pace(self) -> float:
        """Simulated over real time; infinite: as fast as it goes."""
        return self.time_scale or math.inf

    @property
    def pace_in_words(self) -> str:
        """The same, for people."""
        return f"{self.time_scale:g} x real time" if math.isfinite(self.pace) else "as fast as it goes"

    @property
    def field_every(self) -> int:
        """Ticks from field to field."""
        return round(self.rate / self.field_rate)


def meanings() -> dict[str, tuple[Any, str]]:
    """Default and meaning of every parameter by name, without the overrides."""
    return {f.name: (f.default, f.metadata["meaning"]) for f in fields(Settings) if f.name != "override"}


def settings(given: Mapping[str, Any]) -> Settings:
    """Check parameters, by name.

    Raises
    ------
    SettingError
    """
    known = meanings()
    values: dict[str, Any] = {}
    override: dict[str, Any] = {}
    for name, value in given.items():
        if name.startswith(OVERRIDE):
            override[name[len(OVERRIDE) :]] = value.tolist() if isinstance(value, array.array) else value
        else:
            values[name] = _checked(name, value, known)
    found = Settings(**values, override=override)
    if not found.scene:
        raise SettingError("no scene is given; give one: --ros-args -p scene:=PATH.yaml")
    for name in ("deflection_period", "duration", "furnace_timeout"):
        amount = getattr(found, name)
        if not (math.isfinite(amount) and amount >= 0.0):
            raise SettingError(f"{name} is {amount:g}; give seconds, zero or more")
    for name, unit in (("furnace_rate", "K/s"), ("furnace_jump", "K")):
        amount = getattr(found, name)
        if not (math.isfinite(amount) and amount >= 0.0):
            raise SettingError(f"{name} is {amount:g}; give {unit}, zero or more")
    if not -274.0 < found.furnace_lowest < found.furnace_highest <= 3000.0:
        raise SettingError(
            f"furnace_lowest, furnace_highest are {found.furnace_lowest:g}, {found.furnace_highest:g};"
            " give degrees Celsius from -273 to 3000, the lowest first"
        )
    if found.furnace_confirmations < 1:
        raise SettingError(f"furnace_confirmations is {found.furnace_confirmations}; give 1 or more")
    if found.pace != math.inf and not SLOWEST <= found.time_scale <= FASTEST:
        raise SettingError(
            f"time_scale is {found.time_scale:g}; give {SLOWEST:g} to {FASTEST:g},"
            " or 0.0 for as fast as it goes"
        )
    if not 1e-4 <= found.rate <= 1e3:
        raise SettingError(f"rate is {found.rate:g}; give 0.0001 to 1000 Hz")
    if not 1e-6 <= found.field_rate <= found.rate:
        raise SettingError(f"field_rate is {found.field_rate:g}; give Hz, at most rate: {found.rate:g}")
    ticks = found.rate / found.field_rate
    if abs(ticks - found.field_every) > WHOLE * ticks:
        raise SettingError(
            f"field_rate is {found.field_rate:g} Hz, one in {ticks:.4g} of rate; give a whole"
            f" part of it: {found.rate / found.field_every:g} Hz"
        )
    return found


def _checked(name: str, value: Any, known: Mapping[str, tuple[Any, str]]) -> Any:
    if name not in known:
        near = difflib.get_close_matches(name, known, 1)
        right = f"did you mean {near[0]}?" if near else f"there are {', '.join(known)}, override.*"
        raise SettingError(f"unknown parameter {name}; {right}")
    default, meaning = known[name]
    if isinstance(default, float) and type(value) is int:
        value = float(value)
    if type(value) is not type(default):
        raise SettingError(f"{name} is {value!r}; give {KINDS[type(default)]}: {meaning}")
    return value
