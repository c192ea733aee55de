"""Logs as laboratories write them: any usual encoding, separator, decimal mark, time and temperature unit.

    columns = read_columns("test.csv")
    columns.time        # s
    columns.readings    # {name: °C}
    columns.notes       # what was converted

A unit stands in the column's name (time_min, "Zeit [min]", "TC 1 (°F)", "Time / h", "furnace in K") or in a
row below the names.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..scene.load import SceneError

Array = NDArray[np.float64]

LARGEST_LOG = 2**28
"""bytes"""
TIME_UNITS = {
    "ms": 1e-3,
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1.0),
    **dict.fromkeys(("min", "mins", "minute", "minutes", "minuten"), 60.0),
    **dict.fromkeys(("h", "hr", "hrs", "hour", "hours", "std", "stunden"), 3600.0),
}
TEMPERATURE_UNITS = {
    **dict.fromkeys(("c", "degc", "celsius", "deg c", "°c", "ºc"), "C"),
    **dict.fromkeys(("f", "degf", "fahrenheit", "deg f", "°f", "ºf"), "F"),
    **dict.fromkeys(("k", "kelvin", "degk"), "K"),
}
TIME_NAMES = ("time", "t", "zeit", "tempo", "elapsed", "elapsed time", "test time", "timestamp", "date/time")


@dataclass(frozen=True)
class Columns:
    """time (K,) : s; readings {name: (K,)} : °C, NaN where missing; notes : what was converted or left out

    plain {name: name} : the columns' names without their units, in the file's own letters
    """

    time: Array
    readings: dict[str, Array]
    notes: tuple[str, ...] = ()
    plain: dict[str, str] = field(default_factory=dict)


def read_columns(path: str | Path) -> Columns:
    """Read a log's columns; raises SceneError with the file, the line and what would be right."""
    rows, notes = _rows(Path(path))
    head = next((i for i, (_, row) in enumerate(rows) if _time_column(row) is not None), None)
    if head is None:
        shown = ", ".join(rows[0][1]) if rows else "nothing"
        raise SceneError(f"{path}:1: has columns {shown}; give one called time, in s")
    line, names = rows[head]
    names = [name.strip() for name in names]
    body = rows[head + 1 :]
    bare, units = _units(names)
    if body and _are_units(body[0][1]):
        for i, cell in enumerate(body[0][1][: len(units)]):
            units[i] = units[i] or cell.strip().strip("[]()").lower()
        body = body[1:]
    if len(body) < 2:
        raise SceneError(f"{path}: has {len(body)} rows of readings; give two or more below its header")
    column = _time_column(names)
    assert column is not None
    first: dict[str, int] = {}
    for i, name in enumerate(bare):
        if i == column or not name:
            continue
        if name in first:
            raise SceneError(
                f"{path}:{line}: has two columns {name}, the {_ordinal(first[name])} and the {_ordinal(i)};"
                " give each a name of its own, besides its unit"
            )
        first[name] = i
    seconds = _times(
        path, [(n, row[column] if column < len(row) else "") for n, row in body], units[column], notes
    )
    readings: dict[str, Array] = {}
    unsaid = [] if units[column] or ":" in body[0][1][column] else [names[column]]
    for i, name in enumerate(names):
        if i == column or not name:
            continue
        values = np.array([_number(row[i]) if i < len(row) else np.nan for _, row in body])
        words = [(n, row[i].strip()) for n, row in body if i < len(row) and _is_word(row[i])]
        if words:
            notes.append(
                f"{name}: cells that are no number were left out, {len(words)} of them, the first in line"
                f" {words[0][0]}: {words[0][1]!r}"
            )
        if units[i] not in TEMPERATURE_UNITS:
            unsaid.append(name)
        kind = TEMPERATURE_UNITS.get(units[i], "C")
        if kind == "F":
            values = (values - 32.0) / 1.8
            notes.append(f"{name} was in °F")
        elif kind == "K":
            values = values - 273.15
            notes.append(f"{name} was in K")
        readings[name] = values
    if unsaid:
        notes.append(f"without a unit, so read as s or °C: {', '.join(unsaid)}")
    return Columns(seconds, readings, tuple(notes), dict(zip(names, bare, strict=True)))


def _ordinal(index: int) -> str:
    """1st of 0."""
    number = index + 1
    ends = {1: "st", 2: "nd", 3: "rd"}
    return f"{number}{'th' if number % 100 in (11, 12, 13) else ends.get(number % 10, 'th')}"


BRACKETED = re.compile(r"^(.*?)\s*[\[(<]\s*([^\])>]*?)\s*[\])>]\s*$")
TRAILING = re.compile(r"^(.*?)(\s*/\s*|\s*,\s*|\s+in\s+|[_\s]+)((?:deg[ _]?|[°º]\s?)?[A-Za-z]+)\s*$")


def _split(name: str) -> tuple[str, str]:
    """A column's name without its unit, and the unit: `tc_1` and `°f` of `tc_1 [°F]`."""
    found = BRACKETED.match(name)
    if found:
        return found.group(1).strip(), found.group(2).lower()
    found = TRAILING.match(name)
    if found:
        unit = found.group(3).lower().replace("_", " ").replace("° ", "°")
        if unit in TIME_UNITS or unit in TEMPERATURE_UNITS:
            return found.group(1).strip(), unit
    return name.strip(), ""


def _units(names: list[str]) -> tuple[list[str], list[str]]:
    """Names without their units, and the units, "" where there is none.

    Letters that only number a series (tc_a, tc_b, tc_c) are no units.
    """
    pairs = [_split(name) for name in names]
    for i, (_, unit) in enumerate(pairs):
        if len(unit) > 1 or BRACKETED.match(names[i]):
            continue
        series = {n[-1].lower() for n in names if n[:-1].lower() == names[i][:-1].lower()}
        if unit and len(series) > 1:
            pairs[i] = (names[i], "")
    known = [u if u in TIME_UNITS or u in TEMPERATURE_UNITS or ":" in u else "" for _, u in pairs]
    bare = [one for one, _ in pairs]
    # In "furnace (left)" and "furnace (right)" the brackets tell which, not the unit.
    telling = {b for b, unit in zip(bare, known, strict=True) if not unit and bare.count(b) > 1}
    return [name if b in telling else b for name, b in zip(names, bare, strict=True)], known


def _text(path: Path) -> tuple[str, list[str]]:
    try:
        if not path.is_file():
            raise SceneError(f"{path}: can't be read (no such file); give a CSV file")
        if path.stat().st_size > LARGEST_LOG:
            raise SceneError(f"{path}: has more than {LARGEST_LOG // 2**20} MiB; give a log of a test")
        data = path.read_bytes()
    except OSError as problem:
        raise SceneError(f"{path}: can't be read ({problem.strerror}); give a CSV file") from None
    for mark, encoding in ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16")):
        if data.startswith(mark):
            try:
                return data.decode(encoding), []
            except UnicodeDecodeError as problem:
                raise SceneError(
                    f"{path}: begins like {encoding} and is not ({problem.reason}); save it as UTF-8"
                ) from None
    try:
        text, notes = data.decode("utf-8"), []
    except UnicodeDecodeError:
        text, notes = data.decode("latin-1"), ["it was read as Latin-1, not UTF-8"]
    if "\0" in text:
        raise SceneError(f"{path}: is no text (it holds zero bytes); give a CSV file")
    return text, notes


def _rows(path: Path) -> tuple[list[tuple[int, list[str]]], list[str]]:
    """Rows with their line numbers, decimal commas made points; what was read how."""
    text, notes = _text(path)
    lines = [line for line in text.splitlines() if line.strip()]
    if not lines:
        raise SceneError(f"{path}: is empty; give columns time and temperature")
    sample = lines[: min(len(lines), 50)]
    counts = {mark: min(line.count(mark) for line in sample[-max(1, len(sample) // 2) :]) for mark in ";\t,"}
    mark = next((m for m in ";\t" if counts[m] > 0), ",")
    numbered = enumerate(csv.reader(text.splitlines(), delimiter=mark), start=1)
    rows = [(n, row) for n, row in numbered if any(cell.strip() for cell in row)]
    # A comma within a cell is a decimal one, also where commas part the cells and this one stood in quotes.
    decimal = re.compile(r"\s*[-+]?\d+,\d+([eE][-+]?\d+)?\s*$")
    if any(decimal.match(cell) for _, row in rows for cell in row):
        rows = [(n, [c.replace(",", ".") if decimal.match(c) else c for c in row]) for n, row in rows]
        notes.append("its decimal commas were read as points")
    return rows, notes


def _time_column(names: list[str]) -> int | None:
    for i, name in enumerate(names):
        if name.strip().lower() in TIME_NAMES or _split(name)[0].lower() in TIME_NAMES:
            return i
    return None


def _are_units(row: list[str]) -> bool:
    cells = [cell.strip().strip("[]()").lower() for cell in row if cell.strip()]
    return bool(cells) and all(c in TIME_UNITS or c in TEMPERATURE_UNITS for c in cells)


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return np.nan


def _is_word(cell: str) -> bool:
    """Whether a cell holds something that is no number and not a way to write that there is none."""
    return bool(cell.strip()) and cell.strip().lower() not in MISSING and not np.isfinite(_number(cell))


MISSING = ("nan", "na", "n/a", "null", "none", "-", "--")


def _times(path: str | Path, cells: list[tuple[int, str]], unit: str, notes: list[str]) -> Array:
    """Seconds, from numbers in the header's unit, from hours, minutes and seconds, or from dates."""
    first = cells[0][1].strip()
    if ":" in first:
        return _clock(path, cells, unit, notes)
    factor = TIME_UNITS.get(unit, 1.0)
    if factor != 1.0:
        notes.append(f"its times were in {unit}")
    seconds = np.array([_number(cell) for _, cell in cells]) * factor
    if factor > 1.0:
        seconds = _unrounded(seconds, [cell for _, cell in cells], factor, notes)
    bad = np.flatnonzero(~np.isfinite(seconds))
    if len(bad):
        n, cell = cells[bad[0]]
        raise SceneError(f"{path}:{n}: time is {cell.strip() or 'missing'}; give a finite number of s")
    back = np.flatnonzero(np.diff(seconds) <= 0.0)
    if len(back):
        n, cell = cells[back[0] + 1]
        raise SceneError(f"{path}:{n}: time is {cell.strip()}; give times that increase")
    return seconds


def _unrounded(seconds: Array, cells: list[str], factor: float, notes: list[str]) -> Array:
    """Times as they were before a logger rounded them to a few digits of minutes or hours.

    One row a minute in hours to four digits is 0.0167 h, 60.12 s: all are put on the coarsest grid of whole
    seconds that every one of them is a rounding of.
    """
    digits = max(len(cell.strip().partition(".")[2]) for cell in cells)
    half = 0.5 * factor * 10.0**-digits
    for grid in (60.0, 30.0, 20.0, 15.0, 10.0, 5.0, 2.0, 1.0):
        whole = grid * np.round(seconds / grid)
        if grid > 4.0 * half and np.all(np.abs(whole - seconds) <= 1.001 * half):
            if np.abs(whole - seconds).max() > 1e-6:
                notes.append(f"its times were rounded; they were put back on whole {grid:g} s")
            return np.asarray(whole)
    return seconds


def _clock(path: str | Path, cells: list[tuple[int, str]], unit: str, notes: list[str]) -> Array:
    seconds = []
    dated = False
    for n, raw in cells:
        cell = raw.strip()
        parts = cell.split(":")
        try:
            if re.search(r"\d[-/.]\d+[-/.]\d", cell):
                dated = True
                seconds.append(datetime.fromisoformat(cell.replace("/", "-")).timestamp())
            elif len(parts) == 3:
                seconds.append(3600.0 * float(parts[0]) + 60.0 * float(parts[1]) + float(parts[2]))
            elif len(parts) == 2 and unit in TIME_UNITS and TIME_UNITS[unit] >= 60.0:
                factor = TIME_UNITS[unit]
                seconds.append(factor * float(parts[0]) + factor / 60.0 * float(parts[1]))
            else:
                raise ValueError
        except ValueError:
            raise SceneError(
                f"{path}:{n}: time is {cell or 'missing'}; give seconds, or hours:minutes:seconds, since the"
                " fire began"
            ) from None
    found = np.array(seconds)
    if dated:
        found -= found[0]
        notes.append("its dates were counted from the first row, as if the fire began there")
    back = np.flatnonzero(np.diff(found) <= 0.0)
    if len(back):
        n, cell = cells[back[0] + 1]
        raise SceneError(f"{path}:{n}: time is {cell.strip()}; give times that increase")
    return found
