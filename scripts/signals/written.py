"""Writes the signals of a bag for other tools: CSV row by row, NumPy and Parquet topic by topic.

Times stand in a column `t`: the messages' own where they are stamped, else those of receipt since the bag's
beginning; and in `received`, s since 1970. Numbers are written so that they are read back to the bit.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag, BagError
from ..bag.joints import QUANTITIES
from ..bag.joints import TYPE as JOINTS
from ..bag.layout import LIST
from ..bag.messages import Messages

SECOND = 1_000_000_000
STAMPS = (("header.stamp.sec", "header.stamp.nanosec"), ("clock.sec", "clock.nanosec"))
Progress = Callable[[str], None]


class Signals:
    """The fields of a topic as columns, as many as its longest lists have elements.

    Parameters
    ----------
    bag : Bag
    topic : str

    Raises
    ------
    BagError
        Its messages can't be decoded.
    """

    def __init__(self, bag: Bag, topic: str) -> None:
        self.bag, self.topic = bag, topic
        why = bag.why_not(topic)
        if why:
            raise BagError(why)
        self.decoder = bag.decoder(topic)
        self.width: dict[str, int | None] = {}  # None is a scalar
        self.stamp: tuple[str, str] | None = None
        names: dict[str, None] = {}
        for messages in bag.read([topic]):
            groups = self.decoder.groups(messages[topic])
            for _, layout, some in sorted(groups, key=lambda g: 0 if g[0] is None else int(g[0][0])):
                for name, f in layout.fields.items():
                    before = self.width.get(name)
                    self.width[name] = max(before or 0, f.values) if f.several else None
                if layout.kind == JOINTS and "name" in layout.fields:
                    names |= dict.fromkeys(n for told in layout.cut("name", some) for n in told)
        self.joints = [*names]
        self.stamp = next((s for s in STAMPS if set(s) <= self.width.keys()), None)
        self.fields = [n for n in self.width if n not in (self.stamp or ())]
        if self.joints:
            self.fields.remove("name")

    @property
    def columns(self) -> list[str]:
        """Names of all columns."""
        found = ["t", "received"]
        for name in self.fields:
            width = self.width[name]
            if self.joints and name in QUANTITIES:
                found += [f"{joint}/{name}" for joint in self.joints]
            elif width is None:
                found.append(name)
            else:
                stem = name.replace(LIST, "")
                found += [f"{stem}[{k}]" for k in range(width)]
        return found

    def rows(self) -> Iterator[list[Any]]:
        """Give the cells of each message; None where it has none."""
        for messages in self.bag.read([self.topic]):
            yield from self._rows(messages[self.topic])

    def _rows(self, messages: Messages) -> Iterator[list[Any]]:
        found: list[list[Any]] = [[] for _ in range(len(messages))]
        for index, layout, some in self.decoder.groups(messages):
            which = range(len(messages)) if index is None else index.tolist()
            blocks = [self._cells(name, layout, some) for name in self.fields]
            stamp = self._times(layout, some)
            for row, (k, log) in enumerate(zip(which, some.log_time.tolist(), strict=True)):
                found[k] = [seconds(int(stamp[row])), seconds(log)]
                for block in blocks:
                    found[k] += block[row]
        yield from found

    def _times(self, layout: Any, some: Messages) -> NDArray[np.int64]:
        if self.stamp is None or not set(self.stamp) <= layout.fields.keys():
            return np.asarray(some.log_time - self.bag.start, np.int64)
        sec, nanosec = (layout.cut(name, some).astype(np.int64) for name in self.stamp)
        return np.asarray(sec * SECOND + nanosec, np.int64)

    def _cells(self, name: str, layout: Any, some: Messages) -> list[list[Any]]:
        """Return a field's cells, message by message."""
        width = self.width[name]
        joints = self.joints and name in QUANTITIES
        count = len(self.joints) if joints else 1 if width is None else width
        if name not in layout.fields:
            return [[None] * count] * len(some)
        values = layout.cut(name, some)
        if values.dtype == object:
            cells = [[v] if width is None else list(v) for v in values]
        else:
            cells = [[v] for v in values] if values.ndim == 1 else [list(v) for v in values]
        if joints:
            order = layout.cut("name", some)
            return [self._by_joint(told, of) for told, of in zip(cells, order, strict=True)]
        return [row + [None] * (count - len(row)) for row in cells]

    def _by_joint(self, cells: list[Any], names: list[str]) -> list[Any]:
        told = dict(zip(names, cells, strict=False)) if len(cells) == len(names) else {}
        return [told.get(joint) for joint in self.joints]


def seconds(time: int) -> str:
    """Write a time, ns, as seconds, exactly."""
    sign = "-" if time < 0 else ""
    whole, part = divmod(abs(time), SECOND)
    return f"{sign}{whole}.{part:09d}"


def cell(value: Any) -> str:
    """Write a cell so that it is read back to the bit."""
    return "" if value is None else str(value)


def write_csv(signals: Signals, file: IO[str]) -> int:
    """Write a topic; returns its rows."""
    writer = csv.writer(file)
    writer.writerow(signals.columns)
    count = 0
    for row in signals.rows():
        writer.writerow([cell(value) for value in row])
        count += 1
    return count


def arrays(signals: Signals) -> dict[str, NDArray[Any]]:
    """Return the columns of a topic as arrays (K,): numbers, nan where a message has none, or text."""
    names = signals.columns
    columns: list[list[Any]] = [[] for _ in names]
    for row in signals.rows():
        for column, value in zip(columns, row, strict=True):
            column.append(value)
    found = {}
    for name, column in zip(names, columns, strict=True):
        if name in ("t", "received"):
            found[name] = np.array([float(v) for v in column])
        elif any(isinstance(v, str) for v in column):
            found[name] = np.array([v or "" for v in column])
        elif any(v is None for v in column):
            found[name] = np.array([np.nan if v is None else v for v in column], dtype=np.float64)
        else:
            found[name] = np.array(column)
    return found


def write_parquet(signals: Signals, path: Path) -> int:
    """Write a topic; returns its rows."""
    import pyarrow
    from pyarrow import parquet

    found = arrays(signals)
    parquet.write_table(pyarrow.table({name: pyarrow.array(v) for name, v in found.items()}), path)
    return len(found["t"])


def write_numpy(all_of_them: dict[str, Signals], path: Path) -> dict[str, int]:
    """Write topics into one file, each column as TOPIC/COLUMN; returns the rows of each."""
    found: dict[str, NDArray[Any]] = {}
    rows = {}
    for topic, signals in all_of_them.items():
        columns = arrays(signals)
        rows[topic] = len(columns["t"])
        found |= {f"{topic.strip('/')}/{name}": values for name, values in columns.items()}
    with path.open("wb") as file:
        np.savez_compressed(file, **found)  # type: ignore[arg-type]
    return rows
