"""What the furnace does: standard curves, a constant, a measured log, or a lumped furnace.

A furnace is asked for its gas temperature at a time, t -> °C. Curves: EN 1991-1-2 clause 3.2.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..scene.load import Scene, SceneError
from ..scene.standards import STANDARDS
from .log_file import read_columns
from .parametric import ParametricFire
from .tabled import table_of

if TYPE_CHECKING:
    from ..scene.furnace_part import FurnacePart

Array = NDArray[np.float64]


class Furnace(Protocol):
    """Something that knows its gas temperature."""

    def __call__(self, time: float) -> float:
        """Gas temperature, °C, at `time`, s from the start of the test."""
        ...


def iso_834(time: ArrayLike) -> Array:
    """Standard curve, °C, EN 1991-1-2 (3.4); time in s."""
    t = np.maximum(np.asarray(time, dtype=float), 0.0)
    return np.asarray(20.0 + 345.0 * np.log10(8.0 * t / 60.0 + 1.0))


def hydrocarbon(time: ArrayLike) -> Array:
    """Hydrocarbon curve, °C, EN 1991-1-2 (3.6)."""
    t = np.maximum(np.asarray(time, dtype=float), 0.0) / 60.0
    return 1080.0 * (1.0 - 0.325 * np.exp(-0.167 * t) - 0.675 * np.exp(-2.5 * t)) + 20.0


def external(time: ArrayLike) -> Array:
    """External fire curve, °C, EN 1991-1-2 (3.5)."""
    t = np.maximum(np.asarray(time, dtype=float), 0.0) / 60.0
    return 660.0 * (1.0 - 0.687 * np.exp(-0.32 * t) - 0.313 * np.exp(-3.8 * t)) + 20.0


ASTM_E119_MINUTES = np.array(
    [0, *range(5, 61, 5), *range(65, 121, 5), *range(130, 241, 10), 300, 360, 420, 480], dtype=float
)
ASTM_E119_FAHRENHEIT = np.array(
    [
        *(68, 1000, 1300, 1399, 1462, 1510, 1550, 1584, 1613, 1638, 1661, 1681, 1700),
        *(1718, 1735, 1750, 1765, 1779, 1792, 1804, 1815, 1826, 1835, 1843, 1850),
        *(1862, 1875, 1888, 1900, 1912, 1925, 1938, 1950, 1962, 1975, 1988, 2000),
        *(2075, 2150, 2225, 2300),
    ],
    dtype=float,
)
"""ASTM E119 table X1.1, also of UL 263, UL 10B and UL 10C; straight between."""


def astm_e119(time: ArrayLike) -> Array:
    """Standard curve of ASTM E119 and UL 10B/10C, °C; beyond 8 h as at 8 h."""
    t = np.asarray(time, dtype=float) / 60.0
    return (np.interp(t, ASTM_E119_MINUTES, ASTM_E119_FAHRENHEIT) - 32.0) / 1.8


def ul_1709(time: ArrayLike) -> Array:
    """Rapid rise of UL 1709, °C: 1093 °C (2000 °F) within 5 min and held."""
    return np.interp(np.asarray(time, dtype=float), [0.0, 300.0], [20.0, 1093.0])


def modified_hydrocarbon(time: ArrayLike) -> Array:
    """HCM, the French increased hydrocarbon curve, °C: the hydrocarbon curve with 1280 for 1080."""
    return 20.0 + 1280.0 / 1080.0 * (hydrocarbon(time) - 20.0)


RWS_MINUTES = np.array([0.0, 3.0, 5.0, 10.0, 30.0, 60.0, 90.0, 120.0, 180.0])
RWS_CELSIUS = np.array([20.0, 890.0, 1140.0, 1200.0, 1300.0, 1350.0, 1300.0, 1200.0, 1200.0])


def rws(time: ArrayLike) -> Array:
    """Rijkswaterstaat's tunnel curve, °C (Efectis-R0695); straight between its points."""
    return np.interp(np.asarray(time, dtype=float) / 60.0, RWS_MINUTES, RWS_CELSIUS)


def slow_heating(time: ArrayLike) -> Array:
    """Slow heating of EN 1363-2 clause 6, °C: 154 t^0.25 + 20 to 21 min, then ISO 834 as from 20 min on."""
    t = np.maximum(np.asarray(time, dtype=float), 0.0)
    return np.where(t <= 21.0 * 60.0, 154.0 * (t / 60.0) ** 0.25 + 20.0, iso_834(t - 20.0 * 60.0))


CURVES: dict[str, Callable[[ArrayLike], Array]] = {
    "iso_834": iso_834,
    "hydrocarbon": hydrocarbon,
    "external": external,
    "astm_e119": astm_e119,
    "ul_1709": ul_1709,
    "modified_hydrocarbon": modified_hydrocarbon,
    "rws": rws,
    "slow_heating": slow_heating,
}
FILM_COEFFICIENT = {
    "iso_834": 25.0,
    "hydrocarbon": 50.0,
    "external": 25.0,
    "ul_1709": 50.0,
    "modified_hydrocarbon": 50.0,
    "rws": 50.0,
    "parametric": 35.0,
}
"""W/(m2 K) on the exposed side, EN 1991-1-2 clauses 3.2.1 to 3.2.3 and, parametric, 3.3.1.1 (3); UL 1709,
the modified hydrocarbon curve and RWS as the hydrocarbon's."""


@dataclass
class Curve:
    """One of the standards' curves, or any function of time."""

    function: Callable[[ArrayLike], Array]

    def __call__(self, time: float) -> float:
        return float(self.function(time))


@dataclass
class Constant:
    """A gas that stays as it is."""

    temperature: float

    def __call__(self, time: float) -> float:
        return self.temperature


class Measured:
    """A logged temperature: straight between values, the first and last held outside.

    Values may be added while a test runs. `stale` is the time since the last value when the log
    is asked beyond its end; a live run watches it.

    each (K, m) : the furnace's thermocouples, °C, whose mean is `temperature`, where there were several
    names, notes : their columns, and what was converted when they were read
    """

    def __init__(
        self,
        time: ArrayLike = (),
        temperature: ArrayLike = (),
        each: ArrayLike | None = None,
        names: tuple[str, ...] = (),
        notes: tuple[str, ...] = (),
    ) -> None:
        self.time = [float(v) for v in np.asarray(time, dtype=float)]
        self.temperature = [float(v) for v in np.asarray(temperature, dtype=float)]
        self.each = None if each is None else np.asarray(each, dtype=float)
        self.names, self.notes = names, notes
        self.stale = 0.0

    def add(self, time: float, temperature: float) -> bool:
        """Add a value; False where it is not finite or not later than the last."""
        finite = np.isfinite(time) and np.isfinite(temperature)
        if not finite or (self.time and time <= self.time[-1]):
            return False
        self.time.append(time)
        self.temperature.append(temperature)
        self.each = None
        return True

    def thermocouples(self, time: float) -> Array:
        """Each thermocouple that reads (m,), °C, at a time, s."""
        if self.each is None:
            return np.array([self(time)])
        found = np.array([np.interp(time, self.time, one) for one in self.each.T])
        read = found[np.isfinite(found)]
        return read if len(read) else np.array([self(time)])

    def __call__(self, time: float) -> float:
        if not self.time:
            return 20.0
        self.stale = max(0.0, time - self.time[-1])
        return float(np.interp(time, self.time, self.temperature))


ROUNDING = 1e-6
"""Share of a gap that is rounding: a minute kept in hours."""


def checked_log(
    time: ArrayLike, temperature: ArrayLike, longest_gap: float, where: str, curve: str | None = None
) -> Measured:
    """A measured furnace, refused where it can't be trusted.

    A gap of at most `longest_gap` s, or values that are not finite within one, are bridged
    straight, a beginning that is missing by its first value; anything longer is refused with its place.

    temperature : (K,) °C, or (K, m) of several thermocouples; one that fails is left out from there on
        where others go on
    curve : the standard's that it was to follow, by which slipped units are found

    Raises
    ------
    SceneError
    """
    t = np.asarray(time, dtype=float)
    every = np.asarray(temperature, dtype=float)
    v = every if every.ndim == 1 else _mean(every)
    if t.ndim != 1 or t.shape != v.shape or len(t) < 2:
        raise SceneError(f"{where}: has {t.size} times and {v.size} temperatures; give two or more of each")
    if not np.isfinite(t).all():
        row = int(np.flatnonzero(~np.isfinite(t))[0])
        raise SceneError(f"{where}: time {row + 1} is {t[row]}; give a finite time in s")
    back = np.flatnonzero(np.diff(t) <= 0.0)
    if len(back):
        row = int(back[0]) + 1
        raise SceneError(
            f"{where}: time goes from {t[row - 1]:g} to {t[row]:g} s at value {row + 1};"
            " give increasing times"
        )
    good = np.isfinite(v)
    if not good.any():
        raise SceneError(f"{where}: holds no finite temperature; give degrees Celsius")
    if not good[0] or not good[-1]:
        row = 0 if not good[0] else len(v) - 1
        raise SceneError(f"{where}: temperature {row + 1} is {v[row]}; the first and the last must be finite")
    kept, values = t[good], v[good]
    if values.min() < -273.15 or values.max() > 3000.0:
        raise SceneError(f"{where}: goes from {values.min():g} to {values.max():g}; give degrees Celsius")
    if curve is not None:
        _units_fit(kept, values, curve, where)
    longest = longest_gap * (1.0 + ROUNDING)
    wide = np.flatnonzero(np.diff(kept) > longest)
    if len(wide):
        a, b = kept[wide[0]], kept[wide[0] + 1]
        raise SceneError(
            f"{where}: no measurement from {a:g} to {b:g} s, more than longest_gap"
            f" {longest_gap:g} s; give values there or a longer longest_gap to bridge it straight"
        )
    if kept[0] > longest:
        raise SceneError(
            f"{where}: begins at {kept[0]:g} s, more than longest_gap {longest_gap:g} s after the fire did;"
            " give values from the fire's beginning, in s since then"
        )
    return Measured(kept, values, None if every.ndim == 1 else every[good])


def _mean(every: Array) -> Array:
    """Mean (K,) of the thermocouples that read; not a number where none does."""
    good = np.isfinite(every)
    total = np.where(good, every, 0.0).sum(axis=1)
    return np.where(good.any(axis=1), total / np.maximum(good.sum(axis=1), 1), np.nan)


def _units_fit(time: Array, values: Array, curve: str, where: str) -> None:
    """Refuse a log that follows its standard's curve in other units only."""
    readings = {
        "°C and s": (time, values),
        "°F": (time, (values - 32.0) / 1.8),
        "K": (time, values - 273.15),
        "minutes": (60.0 * time, values),
        "hours": (3600.0 * time, values),
        "minutes and °F": (60.0 * time, (values - 32.0) / 1.8),
        "milliseconds": (1e-3 * time, values),
    }
    off = {
        name: float(np.sqrt(np.mean((v - CURVES[curve](t)) ** 2)))
        for name, (t, v) in readings.items()
        if t[-1] >= 120.0  # nothing can be told of less
    }
    plain = off.pop("°C and s", None)
    if plain is None:
        plain = float(np.sqrt(np.mean((values - CURVES[curve](time)) ** 2)))
    if not off:
        return
    best = min(off, key=lambda name: off[name])
    if plain > SLIPPED and off[best] < 0.35 * plain and off[best] < SLIPPED:
        raise SceneError(
            f"{where}: follows {curve} within {off[best]:.0f} °C if read as {best}, and is {plain:.0f} °C off"
            " as °C and s; give °C and s, or the unit in the column's name (time_min, furnace_f)"
        )


SLIPPED = 60.0
"""°C, root of the mean square, by which a furnace of the right units is not off its curve."""
FURNACE_WORDS = ("furnace", "oven", "ofen", "forno", "gas", "plate", "brandraum")
NOT_FURNACE = (
    "ambient", "room", "raum", "umgebung", "lab", "hall", "outside", "cold", "junction", "unexposed", "set",
    "target", "soll", "standard", "iso", "pressure", "druck", "o2", "mean", "average", "avg", "mittel",
)  # fmt: skip
MEANS = ("mean", "average", "avg", "mittel")


def read_log(path: Path, longest_gap: float, curve: str | None = None) -> Measured:
    """A measured furnace from a laboratory's CSV file; see log_file.

    The furnace's columns are named after it (furnace_1, gas, plate thermometer 3), or there is one
    `temp...`; a column of the ambient, of a set point or of a pressure is never taken. Of several
    thermocouples the mean heats the door and each is judged.
    """
    columns = read_columns(path)
    named = {name: columns.plain[name].lower() for name in columns.readings}
    chosen = _furnace_columns(named)
    if not chosen:
        raise SceneError(
            f"{path}:1: has columns {', '.join(named)}; give one that begins with 'temp' or 'furnace'"
        )
    every = np.column_stack([columns.readings[name] for name in chosen])
    notes = columns.notes
    left = [name for name in named if name not in chosen]
    if left:
        notes = (
            *notes,
            f"of its columns {', '.join(chosen)} were taken for the furnace, not {', '.join(left)}",
        )
    made = checked_log(
        columns.time, every[:, 0] if len(chosen) == 1 else every, longest_gap, str(path), curve
    )
    made.names, made.notes = tuple(chosen), notes
    return made


def _furnace_columns(named: dict[str, str]) -> list[str]:
    def other(plain: str) -> bool:
        words = re.split(r"[^a-z0-9]+", plain)
        return any(word.startswith(NOT_FURNACE) for word in words if word)

    is_furnace = {name: any(w in plain for w in FURNACE_WORDS) for name, plain in named.items()}
    of_furnace = [n for n, plain in named.items() if is_furnace[n] and not other(plain)]
    if of_furnace:
        return of_furnace
    means = [n for n, plain in named.items() if is_furnace[n] and any(m in plain for m in MEANS)]
    if means:
        return means[:1]
    return [n for n, plain in named.items() if plain.startswith("temp") and not other(plain)]


def log_path(part: FurnacePart, source: str) -> Path:
    """Where a scene's log lies: beside the scene, unless its path is absolute."""
    path = Path(part.file or "")
    return Path(source).parent / path if source and not path.is_absolute() else path


def with_its_log(scene: Scene) -> Scene:
    """The scene with the log of its furnace in it, and no longer beside it; raises SceneError."""
    part = scene.furnace
    if part.file is None:
        return scene
    curve = STANDARDS[scene.criteria.standards[0]].curve
    log = read_log(log_path(part, scene.source), part.longest_gap, curve)
    held: dict[str, Any] = {"file": None, "time": tuple(log.time)}
    if log.each is None:
        held["temperature"] = tuple(log.temperature)
    else:
        held["thermocouples"] = tuple(
            tuple(float(v) if np.isfinite(v) else None for v in one) for one in log.each.T
        )
    return scene.model_copy(update={"furnace": part.model_copy(update=held)})


def furnace_of(part: FurnacePart, source: str, curve: str | None = None) -> Furnace:
    """The furnace that a scene asks for; raises SceneError where a log can't be used.

    curve : the foremost standard's, by which a log's units are checked
    """
    made: Furnace
    if part.curve == "constant":
        assert isinstance(part.temperature, float)
        made = Constant(part.temperature)
    elif part.curve == "measured":
        if part.file is not None:
            made = read_log(log_path(part, source), part.longest_gap, curve)
        else:
            made = checked_log(
                part.time or (),
                _temperatures(part),
                part.longest_gap,
                f"{source}: furnace",
                curve,
            )
    elif part.curve == "table":
        assert isinstance(part.temperature, tuple)
        made = table_of(part.time, part.temperature)
    elif part.curve == "parametric":
        assert part.parametric is not None
        p = part.parametric
        made = ParametricFire(p.opening_factor, p.absorptivity, p.fire_load, p.growth)
    else:
        made = Curve(CURVES[part.curve])
    if part.burners is not None:
        from .burners import LumpedFurnace

        made = LumpedFurnace(made, part.burners)
    return made


def _temperatures(part: FurnacePart) -> Array:
    """What a scene holds of a log: (K,), or (K, m) of several thermocouples, NaN where one did not read."""
    if part.thermocouples is not None:
        return np.array(part.thermocouples, dtype=float).T
    return np.array(part.temperature if isinstance(part.temperature, tuple) else ())
