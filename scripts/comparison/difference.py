"""How much two runs differ, field by field."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag, BagError
from .aligned import SECOND, STAMPS, Columns, aligned

# What says how the machine did, not what the robot did.
OF_THE_MACHINE = {"diagnostic_msgs/msg/DiagnosticArray", "rcl_interfaces/msg/Log"}


@dataclass
class Difference:
    """How much a field differs.

    Attributes
    ----------
    compared, only_first, only_second : times that both, or one of the runs, have
    exact : whether every bit is the same
    largest : the greatest difference, in the field's unit
    at : s, its time
    component : which number of the field it is
    rms : root of the mean square of all differences
    size : the greatest absolute value of the first run
    since : s, the first time that differs; nan: none does
    """

    name: str
    compared: int = 0
    only_first: int = 0
    only_second: int = 0
    exact: bool = True
    largest: float = 0.0
    at: float = np.nan
    component: int = 0
    size: float = 0.0
    since: float = np.nan
    squares: float = 0.0
    numbers: int = 0  # that were compared and are measures

    @property
    def rms(self) -> float:
        """Root of the mean square of all differences."""
        return float(np.sqrt(self.squares / self.numbers)) if self.numbers else 0.0

    @property
    def relative(self) -> float:
        """The greatest difference as a part of the greatest value."""
        return self.largest / self.size if self.size else (0.0 if self.exact else np.inf)

    def add(self, time: NDArray[np.int64], first: NDArray[Any], second: NDArray[Any]) -> None:
        """Take up some values (K, ...) of both runs."""
        self.compared += len(time)
        if not len(time):
            return
        if first.dtype == object:
            self._note(time, same_words(first.tolist(), second.tolist()))
            return
        a, b = (v if v.ndim == 2 else v.reshape(len(time), -1) for v in (first, second))
        if a.shape != b.shape:
            self.exact = False
            self.largest = np.inf
            self.since = min(self.since, time[0] / SECOND) if self.since == self.since else time[0] / SECOND
            return
        alike = bits(a) == bits(b)
        same = alike.all(axis=1)
        self._note(time, same)
        if a.dtype.kind != "f":  # counts, flags and bytes are the same or not
            return
        self.numbers += a.size
        if a.size:
            self.size = max(self.size, float(a.max()), -float(a.min()))
        if same.all():
            return
        off = np.abs(b.astype(np.float64) - a.astype(np.float64))
        # What is not a number differs without end, unless its bits are the same.
        off = np.where(alike, 0.0, off)
        off = np.where(np.isnan(off), np.inf, off)
        self.squares += float((off**2).sum())
        worst = int(off.argmax())
        if off.flat[worst] > self.largest:
            self.largest = float(off.flat[worst])
            row, self.component = divmod(worst, a.shape[1])
            self.at = time[row] / SECOND

    def _note(self, time: NDArray[np.int64], same: NDArray[np.bool_]) -> None:
        if not same.all():
            self.exact = False
            if self.since != self.since:
                self.since = time[int(np.argmin(same))] / SECOND


def bits(values: NDArray[Any]) -> NDArray[Any]:
    """Return numbers as whole numbers of their bits, of the same shape."""
    return values.view(f"u{values.dtype.itemsize}")


def same_words(first: list[Any], second: list[Any]) -> NDArray[np.bool_]:
    """Say which words, or lists of words, are the same."""
    # Most messages share their words, which are then one object.
    if first.count(first[0]) == len(first) and second.count(second[0]) == len(second):
        return np.full(len(first), first[0] == second[0])
    return np.array([a == b for a, b in zip(first, second, strict=True)])


def differences(
    first: Bag,
    second: Bag,
    topics: tuple[str, ...] = (),
    progress: Callable[[str, float], None] = lambda *_: None,
) -> list[Difference]:
    """Compare two bags: each field of each topic that both have, message by message of equal stamp.

    progress : callable
        Called with the topic and the time, s, up to which it was compared.

    Raises
    ------
    BagError
        They have nothing in common that bears a stamp.
    """
    both = [
        t.name
        for t in first.topics.values()
        if t.count
        and t.name in second.topics
        and second.topics[t.name].count
        and second.topics[t.name].type == t.type
        and t.type not in OF_THE_MACHINE
        and (not topics or t.name in topics)
    ]
    for name in topics:
        first.topic(name), second.topic(name)
    compared: dict[str, tuple[list[str], list[str]]] = {}
    for name in sorted(both):
        fields = first.fields(name)
        stamp = next((s for s in STAMPS if set(s) <= set(fields)), None)
        if stamp is not None:
            compared[name] = [f for f in fields if f not in stamp], stamp
    if not compared:
        raise BagError(f"{first.path} and {second.path} have no topic in common that bears stamps")
    found = {name: of_fields(name, fields) for name, (fields, _) in compared.items()}
    for name, piece in aligned(first, second, compared):
        if piece is None:
            found[name] = of_fields(name, compared[name][0])
            continue
        if len(piece.time):
            progress(name, piece.time[-1] / SECOND)
        for field, difference in found[name].items():
            difference.only_first += piece.only_first
            difference.only_second += piece.only_second
            if field and len(piece.time):
                difference.add(piece.time, piece.first[field], piece.second[field])
            else:
                difference.compared += len(piece.time)
    return [difference for name in compared for difference in told(found[name])]


def of_fields(topic: str, fields: list[str]) -> dict[str, Difference]:
    """Return what gathers the differences of each field of a topic."""
    return {f: Difference(f"{topic} {f}") for f in fields} or {"": Difference(topic)}


def told(found: dict[str, Difference]) -> list[Difference]:
    """Return what is worth telling of a topic."""
    # What is no measure and the same in both says nothing, if there is more to say.
    measures = [d for d in found.values() if d.numbers or not d.exact]
    return measures or [*found.values()][:1]


def arrays_of(path: Path) -> Columns:
    """Return the arrays of a run that `flexsim simulate --save` wrote."""
    with np.load(path, allow_pickle=False) as saved:
        return {name: saved[name] for name in saved.files}
