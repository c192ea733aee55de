"""Reads a table as other tools write it: Excel, PlotJuggler, pandas, MATLAB, a scope.

Byte order marks and UTF-16, commas, semicolons or tabs, decimal commas, comments, times of the wall's
clock, and empty cells are all met in the wild.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from decimal import Decimal
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

MARKS = ((b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"), (b"\xef\xbb\xbf", "utf-8-sig"))
DELIMITERS = ";\t,|"
COMMENTS = ("#", "%", "//")
LARGEST = 1 << 30
TIME = re.compile(
    r"(?:__)?(?:t|time|times|timestamp|stamp|zeit|seconds|secs?)"
    r"(?:[ _]*[\[(]?(?P<unit>s|sec|seconds|ms|us|µs|ns|min)[\])]?)?\Z",
    re.IGNORECASE,
)
# ns
UNITS = {
    "s": 10**9,
    "sec": 10**9,
    "seconds": 10**9,
    "ms": 10**6,
    "us": 10**3,
    "µs": 10**3,
    "ns": 1,
    "min": 60 * 10**9,
}
# Greater than these, a time without a unit is one of the wall's clock, in ns, µs or ms since 1970.
EPOCHS = ((10**17, 1), (10**14, 10**3), (10**11, 10**6))
WALL = 10**17  # ns, three years after 1970


@dataclass(frozen=True)
class CsvTable:
    """A table.

    Attributes
    ----------
    names : of its columns, or () where the first row holds numbers
    cells : rows of words
    line : of the first row in the file
    decimal_comma : whether numbers are written with one
    """

    path: Path
    names: tuple[str, ...]
    cells: list[list[str]]
    lines: list[int]
    decimal_comma: bool

    def number(self, row: int, column: int) -> float:
        """Return a cell as a number, nan where it is empty; raises ValueError with its place."""
        word = self.cells[row][column].strip() if column < len(self.cells[row]) else ""
        if word == "" or word.lower() in ("nan", "na", "null", "none", "-"):
            return float("nan")
        try:
            return float(word.replace(",", ".") if self.decimal_comma else word)
        except ValueError:
            raise ValueError(
                f"{self.path}, line {self.lines[row]}: {word!r} is no number; give numbers"
            ) from None

    def column(self, column: int) -> NDArray[np.float64]:
        """Return a column: (K,)."""
        return np.array([self.number(row, column) for row in range(len(self.cells))])

    def time_column(self) -> int | None:
        """Return which column holds times; None where none is named so."""
        found = [k for k, name in enumerate(self.names) if TIME.match(name)]
        if not found and self.names and self.names[0] == "":  # as pandas writes its index
            return 0
        return found[0] if found else None

    def times(self, column: int) -> tuple[NDArray[np.int64], bool]:
        """Return the times of a column, ns, and whether they are those of the wall's clock.

        Raises
        ------
        ValueError
            One is neither a number nor a date.
        """
        named = TIME.match(self.names[column]) if self.names else None
        scale = UNITS[named["unit"].lower()] if named and named["unit"] else 0
        found: list[int] = []
        # Whole nanoseconds: a double has a quarter of a microsecond of those since 1970.
        for row, line in enumerate(self.lines):
            word = self.cells[row][column].strip() if column < len(self.cells[row]) else ""
            plain = word.replace(",", ".") if self.decimal_comma else word
            try:
                value = Decimal(plain)
                if not scale:
                    scale = next((factor for least, factor in EPOCHS if abs(value) > least), 10**9)
                found.append(int(value * scale))
            except (ArithmeticError, ValueError):
                found.append(nanoseconds(word, f"{self.path}, line {line}"))
        times = np.array(found, dtype=np.int64)
        return times, bool(len(times) and abs(int(times[0])) > WALL)


def nanoseconds(word: str, where: str) -> int:
    """Return a date as ns since 1970; raises ValueError where it is none."""
    try:
        when = datetime.fromisoformat(word.replace("Z", "+00:00"))
    except ValueError:
        what = f"{word!r} is neither a number nor a date" if word else "there is no time"
        raise ValueError(f"{where}: {what}; give numbers") from None
    when = when if when.tzinfo else when.replace(tzinfo=timezone.utc)
    return round((when - datetime(1970, 1, 1, tzinfo=timezone.utc)) / timedelta(microseconds=1)) * 1000


def read_table(path: Path) -> CsvTable:
    """Read a table.

    Raises
    ------
    ValueError
        The file is missing, empty, or no text.
    """
    if not path.is_file():
        raise ValueError(f"{path} does not exist; give a CSV file")
    if path.stat().st_size > LARGEST:
        raise ValueError(f"{path} is larger than a gigabyte; give a table of fewer rows")
    text = decoded(path)
    numbered = [
        (k, line)
        for k, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith(COMMENTS)
    ]
    delimiter = ""
    if numbered and numbered[0][1].lower().startswith("sep=") and len(numbered[0][1].rstrip()) == 5:
        delimiter = numbered.pop(0)[1].rstrip()[-1]  # as Excel says it
    if not numbered:
        raise ValueError(f"{path} holds no rows; give a column of times, t, and one for each joint")
    delimiter = delimiter or best_delimiter([line for _, line in numbered[:20]])
    lines = [k for k, _ in numbered]
    if delimiter == " ":
        rows = [line.split() for _, line in numbered]
    else:
        rows = [next(csv.reader([line], delimiter=delimiter)) for _, line in numbered]
    names: tuple[str, ...] = ()
    comma = delimiter != ","
    if not is_data(rows[0], comma):
        names = tuple(word.strip().strip('"') for word in rows[0])
        rows, lines = rows[1:], lines[1:]
        if not rows:
            raise ValueError(f"{path} holds a header, {', '.join(names)}, and no rows")
    width = len(names) or len(rows[0])
    for row, line in zip(rows, lines, strict=True):
        if len(row) != width and any(word.strip() for word in row[width:]):
            raise ValueError(f"{path}, line {line}: {len(row)} cells where {width} columns are")
    return CsvTable(path, names, rows, lines, comma)


def decoded(path: Path) -> str:
    """Return a file's text, whatever it is written in; raises ValueError where it is no text."""
    data = path.read_bytes()
    encoding = next((name for mark, name in MARKS if data.startswith(mark)), "")
    if not encoding and data[:200].count(0) > len(data[:200]) // 4:
        encoding = "utf-16-le" if data[1:2] == b"\0" else "utf-16-be"
    try:
        text = data.decode(encoding or "utf-8")
    except UnicodeDecodeError:
        text = data.decode("cp1252", "replace")  # as Excel saves without being asked
    if "\0" in text:
        raise ValueError(f"{path} is not a text; give a CSV file")
    return text


def best_delimiter(lines: list[str]) -> str:
    """Return what separates the cells: what is in every line, the same number of times."""
    for mark in DELIMITERS:
        counts = {line.count(mark) for line in lines}
        if min(counts) > 0 and (len(counts) == 1 or mark != ","):
            return mark
    if min(line.count(",") for line in lines) > 0:
        return ","
    return " "


def is_data(row: list[str], comma: bool) -> bool:
    """Say whether a row holds numbers, not names."""
    for word in row:
        plain = word.strip().replace(",", ".") if comma else word.strip()
        try:
            float(plain)
        except ValueError:
            if plain == row[0].strip():
                return is_date(plain)
            continue
        return True
    return False


def is_date(word: str) -> bool:
    """Say whether a word is a date."""
    try:
        datetime.fromisoformat(word.replace("Z", "+00:00"))
    except ValueError:
        return False
    return True
