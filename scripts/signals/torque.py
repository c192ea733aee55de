"""Torques from a table that another tool wrote: which column drives which joint, and when."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .csv_table import CsvTable, read_table

PARTS = re.compile(r"[/.\[\]:| ]+")
TORQUES = {"effort", "efforts", "torque", "torques", "tau", "data", "command", "commands", "nm", "n", "m"}
OTHERS = {"position", "velocity", "acceleration", "name", "header", "stamp", "pos", "vel"}


def read_torque(
    path: Path,
    joint_names: Sequence[str],
    passive: Sequence[str],
    steps: int,
    step: float,
    start: float | None = None,
) -> NDArray[np.float64]:
    """Return the torque (steps, m) in force at each step, N m or N; before the first row none.

    Parameters
    ----------
    joint_names, passive : of the scene; those without a motor need no column
    start : s
        The time of the file at which the run begins; if not given 0, or the first row of a file whose times
        are those of the wall's clock.

    Raises
    ------
    ValueError
        The file is no table of times and a column a joint; says the file, the place and what is wanted.
    """
    table = read_table(path)
    motors = [name for name in joint_names if name not in passive]
    time_at, column_of = columns(table, list(joint_names), motors)
    told, wall = table.times(time_at)
    back = np.flatnonzero(np.diff(told) <= 0)
    if len(back):
        raise ValueError(f"{path}, line {table.lines[int(back[0]) + 1]}: t does not rise from row to row")
    if wall and start is None:
        begin = int(told[0])
        said = f"{path}: its times are of the wall's clock; the run begins at its first, {begin / 1e9:.9f} s."
        warnings.warn(f"{said} --start SECONDS says another", UserWarning, stacklevel=2)
    else:
        begin = round((start or 0.0) * 1e9)
    time = (told - begin) / 1e9
    if time[0] > step * steps:
        raise ValueError(
            f"{path} begins {time[0]:g} s after the run's beginning, when the run is over: it drives nothing;"
            " --start SECONDS says at which of its times the run begins"
        )
    efforts = np.zeros((len(time) + 1, len(joint_names)))
    for name, column in column_of.items():
        values = table.column(column)
        if np.isinf(values).any():
            row = int(np.argmax(np.isinf(values)))
            raise ValueError(f"{path}, line {table.lines[row]}: the torque of {name} is not finite")
        if np.isnan(values).all():
            raise ValueError(
                f"{path}: the column of {name} is empty; give rows of {1 + len(column_of)} finite numbers"
            )
        efforts[1:, list(joint_names).index(name)] = held(values)
    # A time that is a step but for rounding belongs to that step.
    at = np.searchsorted(time, step * np.arange(steps) + 1e-6 * step, side="right")
    return efforts[at]


def columns(table: CsvTable, joints: list[str], motors: list[str]) -> tuple[int, dict[str, int]]:
    """Return which column holds times, and which the torque of each joint; raises ValueError."""
    path = table.path
    wanted = ", ".join(["t", *motors])
    if not table.names:
        width = len(table.cells[0])
        if width not in (len(joints) + 1, len(motors) + 1):
            raise ValueError(
                f"{path}: {width} columns without names; give a first row, {wanted}, or rows of"
                f" {len(motors) + 1} finite numbers"
            )
        return 0, dict(zip(joints if width == len(joints) + 1 else motors, range(1, width), strict=True))
    time = table.time_column()
    if time is None:
        raise ValueError(f"{path}: columns are {', '.join(table.names)}; none is t or time; give {wanted}")
    found: dict[str, int] = {}
    unused = []
    for k, name in enumerate(table.names):
        if k == time:
            continue
        joint = joint_of(name, joints, motors)
        if joint is None:
            unused.append(name)
        elif joint in found:
            both = f"'{table.names[found[joint]]}' and '{name}'"
            raise ValueError(f"{path}: columns {both} are both of {joint}; leave one")
        else:
            found[joint] = k
    lacking = [name for name in motors if name not in found]
    if lacking:
        raise ValueError(
            f"{path}: no column is of {', '.join(lacking)}; columns are {', '.join(table.names)};"
            f" give {wanted}"
        )
    if unused:
        warnings.warn(f"{path}: not used: {', '.join(unused)}", UserWarning, stacklevel=3)
    return time, found


def joint_of(name: str, joints: list[str], motors: list[str]) -> str | None:
    """Return the joint whose torque a column bears: by its name, or by the path that it has in a bag."""
    if name in joints:
        return name
    parts = [part for part in PARTS.split(name.strip("/ ").replace("(", " ").replace(")", " ")) if part]
    if {part.lower() for part in parts} & OTHERS:
        return None
    named = [joint for joint in joints if joint in parts or f"/{joint}/" in f"/{name.strip('/')}/"]
    if named:
        return max(named, key=len)
    # /flexsim_node/commands/data[0], as PlotJuggler and pandas write a list of numbers.
    if len(parts) >= 2 and parts[-1].isdigit() and parts[-2].lower() in TORQUES:
        k = int(parts[-1])
        return motors[k] if k < len(motors) else None
    return None


def held(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a column in which empty cells hold what stood last; before the first there is no torque."""
    known = np.isfinite(values)
    last = np.maximum.accumulate(np.where(known, np.arange(len(values)), -1))
    return np.where(last >= 0, values[np.maximum(last, 0)], 0.0)
