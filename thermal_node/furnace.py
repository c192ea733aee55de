"""What the furnace does: standard curves, a constant, a measured log, or a lumped furnace.

A furnace is asked for its gas temperature at a time, t -> °C. Curves: EN 1991-1-2 clause 3.2.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .scene import Scene, SceneError

if TYPE_CHECKING:
    from .schema import FurnacePart

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


CURVES: dict[str, Callable[[ArrayLike], Array]] = {
    "iso_834": iso_834,
    "hydrocarbon": hydrocarbon,
    "external": external,
}
FILM_COEFFICIENT = {"iso_834": 25.0, "hydrocarbon": 50.0, "external": 25.0}
"""W/(m2 K) on the exposed side, EN 1991-1-2 clauses 3.2.1 to 3.2.3."""


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
    """

    def __init__(self, time: ArrayLike = (), temperature: ArrayLike = ()) -> None:
        self.time = [float(v) for v in np.asarray(time, dtype=float)]
        self.temperature = [float(v) for v in np.asarray(temperature, dtype=float)]
        self.stale = 0.0

    def add(self, time: float, temperature: float) -> bool:
        """Add a value; False where it is not finite or not later than the last."""
        finite = np.isfinite(time) and np.isfinite(temperature)
        if not finite or (self.time and time <= self.time[-1]):
            return False
        self.time.append(time)
        self.temperature.append(temperature)
        return True

    def __call__(self, time: float) -> float:
        if not self.time:
            return 20.0
        self.stale = max(0.0, time - self.time[-1])
        return float(np.interp(time, self.time, self.temperature))


def checked_log(time: ArrayLike, temperature: ArrayLike, longest_gap: float, where: str) -> Measured:
    """A measured furnace, refused where it can't be trusted.

    A gap of at most `longest_gap` s, or values that are not finite within one, are bridged
    straight; anything longer is refused with its place.

    Raises
    ------
    SceneError
    """
    t = np.asarray(time, dtype=float)
    v = np.asarray(temperature, dtype=float)
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
    if not good[0] or not good[-1]:
        row = 0 if not good[0] else len(v) - 1
        raise SceneError(f"{where}: temperature {row + 1} is {v[row]}; the first and the last must be finite")
    kept, values = t[good], v[good]
    wide = np.flatnonzero(np.diff(kept) > longest_gap)
    if len(wide):
        a, b = kept[wide[0]], kept[wide[0] + 1]
        raise SceneError(
            f"{where}: no measurement from {a:g} to {b:g} s, more than longest_gap"
            f" {longest_gap:g} s; give values there or a longer longest_gap to bridge it straight"
        )
    if values.min() < -273.15 or values.max() > 3000.0:
        raise SceneError(f"{where}: goes from {values.min():g} to {values.max():g}; give degrees Celsius")
    return Measured(kept, values)


def read_log(path: Path, longest_gap: float) -> Measured:
    """A measured furnace from a CSV file with a header and columns time (s), temperature (°C).

    Columns are found by their names' beginnings, `t` or `time...` and `temp...` or `furnace...`;
    an empty or unreadable cell counts as a value that is missing.
    """
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))
    except OSError as problem:
        raise SceneError(f"{path}: can't be read ({problem.strerror}); give a CSV file") from None
    if not rows:
        raise SceneError(f"{path}: is empty; give columns time and temperature")
    header = [cell.strip().lower() for cell in rows[0]]
    time_column = _column(header, ("time", "t"), path)
    temperature_column = _column(header, ("temp", "furnace", "gas"), path)

    def cell(row: list[str], column: int) -> float:
        try:
            return float(row[column])
        except (ValueError, IndexError):
            return np.nan

    body = [row for row in rows[1:] if row]
    return checked_log(
        [cell(row, time_column) for row in body],
        [cell(row, temperature_column) for row in body],
        longest_gap,
        str(path),
    )


def _column(header: list[str], beginnings: tuple[str, ...], path: Path) -> int:
    for beginning in beginnings:
        for i, name in enumerate(header):
            if name == beginning or (len(beginning) > 1 and name.startswith(beginning)):
                return i
            if len(beginning) == 1 and name.split("_")[0] == beginning:
                return i
    raise SceneError(
        f"{path}:1: has columns {', '.join(header)}; give one that begins with {beginnings[0]!r}"
    )


def log_path(part: FurnacePart, source: str) -> Path:
    """Where a scene's log lies: beside the scene, unless its path is absolute."""
    path = Path(part.file or "")
    return Path(source).parent / path if source and not path.is_absolute() else path


def with_its_log(scene: Scene) -> Scene:
    """The scene with the log of its furnace in it, and no longer beside it; raises SceneError."""
    part = scene.furnace
    if part.file is None:
        return scene
    log = read_log(log_path(part, scene.source), part.longest_gap)
    held = {"file": None, "time": tuple(log.time), "temperature": tuple(log.temperature)}
    return scene.model_copy(update={"furnace": part.model_copy(update=held)})


def furnace_of(part: FurnacePart, source: str) -> Furnace:
    """The furnace that a scene asks for; raises SceneError where a log can't be used."""
    made: Furnace
    if part.curve == "constant":
        assert isinstance(part.temperature, float)
        made = Constant(part.temperature)
    elif part.curve == "measured":
        if part.file is not None:
            made = read_log(log_path(part, source), part.longest_gap)
        else:
            made = checked_log(
                part.time or (),
                part.temperature if isinstance(part.temperature, tuple) else (),
                part.longest_gap,
                f"{source}: furnace",
            )
    else:
        made = Curve(CURVES[part.curve])
    if part.burners is not None:
        from .burners import LumpedFurnace

        made = LumpedFurnace(made, part.burners)
    return made
