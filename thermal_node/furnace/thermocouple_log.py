"""A fire test's log: time, thermocouples by name, and the furnace's temperature if it is there."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .log_file import Array, read_columns

COLDEST, HOTTEST = -100.0, 1400.0
"""°C of a reading that a thermocouple in a fire test can have; type K ends at 1372."""
FURNACE = ("furnace", "gas", "oven", "ofen")


@dataclass(frozen=True)
class ThermocoupleLog:
    """time (K,) : s; readings {name: (K,)} : °C, NaN where missing; furnace (K,) or None.

    notes : what was converted or left out when it was read; source : its file
    """

    time: Array
    readings: dict[str, Array]
    furnace: Array | None = None
    notes: tuple[str, ...] = ()
    source: str = "log"


def read_thermocouple_log(path: str | Path) -> ThermocoupleLog:
    """Read a laboratory's CSV file: a time, then one column a thermocouple; see log_file.

    Columns whose names begin with furnace, gas or oven are the furnace's: their mean is it. Cells that are
    empty or no number count as missing. Raises SceneError with the file and the line, as read_columns does.
    """
    columns = read_columns(path)
    readings: dict[str, Array] = {}
    notes = list(columns.notes)
    for name, values in columns.readings.items():
        bare = columns.plain[name]
        with np.errstate(invalid="ignore"):
            beyond = np.isfinite(values) & ((values < COLDEST) | (values > HOTTEST))
        if beyond.any():
            first = int(np.flatnonzero(beyond)[0])
            notes.append(
                f"{bare}: {int(beyond.sum())} readings beyond {COLDEST:g} to {HOTTEST:g} °C were left out,"
                f" the first {values[first]:g} °C at {columns.time[first]:g} s"
            )
        readings[bare] = np.where(beyond, np.nan, values)
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
        columns.time, {n: v for n, v in readings.items() if n not in hot}, furnace, tuple(notes), str(path)
    )
