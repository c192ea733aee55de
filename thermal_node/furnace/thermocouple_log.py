"""A fire test's log: time, thermocouples by name, and the furnace's temperature if it is there."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .log_file import Array, plain_name, read_columns

FURNACE = ("furnace", "gas", "oven", "ofen")


@dataclass(frozen=True)
class ThermocoupleLog:
    """time (K,) : s; readings {name: (K,)} : °C, NaN where missing; furnace (K,) or None.

    notes : what was converted when it was read
    """

    time: Array
    readings: dict[str, Array]
    furnace: Array | None = None
    notes: tuple[str, ...] = ()


def read_thermocouple_log(path: str | Path) -> ThermocoupleLog:
    """Read a laboratory's CSV file: a time, then one column a thermocouple; see log_file.

    Columns whose names begin with furnace, gas or oven are the furnace's: their mean is it. Cells that are
    empty or no number count as missing. Raises SceneError with the file and the line.
    """
    columns = read_columns(path)
    readings = {_bare(name): values for name, values in columns.readings.items()}
    hot = [name for name in readings if name.lower().startswith(FURNACE)]
    single = [name for name in hot if not any(w in name.lower() for w in ("mean", "average", "avg"))] or hot[
        :1
    ]
    furnace = None
    if single:
        every = np.column_stack([readings[name] for name in single])
        good = np.isfinite(every)
        total = np.where(good, every, 0.0).sum(axis=1)
        furnace = np.where(good.any(axis=1), total / np.maximum(good.sum(axis=1), 1), np.nan)
    return ThermocoupleLog(
        columns.time, {n: v for n, v in readings.items() if n not in hot}, furnace, columns.notes
    )


def _bare(name: str) -> str:
    """The name without its unit, in the file's own letters."""
    return name[: len(plain_name(name))].strip() if plain_name(name) != name.strip().lower() else name
