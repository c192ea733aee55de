"""A fire test's log: time, thermocouples by name, and the furnace's temperature if it is there."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .conduction import Array
from .scene import SceneError

TIME = ("time", "time_s", "t", "t_s")
FURNACE = ("furnace", "furnace_c", "gas", "furnace_mean")


@dataclass(frozen=True)
class ThermocoupleLog:
    """time (K,) : s; readings {name: (K,)} : °C, NaN where missing; furnace (K,) or None."""

    time: Array
    readings: dict[str, Array]
    furnace: Array | None = None


def read_thermocouple_log(path: str | Path) -> ThermocoupleLog:
    """Read a CSV file with a header: `time` in s, then one column a thermocouple, °C.

    A column `furnace` is the furnace's gas. Cells that are empty or no number count as missing.
    Raises SceneError with the file and the line.
    """
    file_path = Path(path)
    try:
        with file_path.open(encoding="utf-8", newline="") as file:
            rows = [row for row in csv.reader(file) if row]
    except OSError as problem:
        raise SceneError(f"{path}: can't be read ({problem.strerror}); give a CSV file") from None
    if len(rows) < 3:
        raise SceneError(f"{path}: has {len(rows)} lines; give a header and two or more readings")
    header = [cell.strip() for cell in rows[0]]
    columns = {name: np.array([_number(row, i) for row in rows[1:]]) for i, name in enumerate(header)}
    time_name = next((name for name in header if name.lower() in TIME), None)
    if time_name is None:
        raise SceneError(f"{path}:1: has columns {', '.join(header)}; give one called time, in s")
    time = columns.pop(time_name)
    wrong = np.flatnonzero(~np.isfinite(time) | (np.diff(time, prepend=-np.inf) <= 0.0))
    if len(wrong):
        raise SceneError(f"{path}:{wrong[0] + 2}: time is {time[wrong[0]]:g}; give times that increase")
    furnace_name = next((name for name in columns if name.lower() in FURNACE), None)
    furnace = columns.pop(furnace_name) if furnace_name else None
    return ThermocoupleLog(time, columns, furnace)


def _number(row: list[str], column: int) -> float:
    try:
        return float(row[column])
    except (ValueError, IndexError):
        return np.nan
