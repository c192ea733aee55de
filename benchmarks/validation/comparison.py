"""A comparison: its rows, where the reference comes from, and what limits the agreement."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

DATA = Path(__file__).parent / "data"
FORMULATIONS = ("erls", "co_moving")


@dataclass
class Row:
    """One quantity: the reference's value, and what each formulation gives (None: none; `without` says why).

    absolute : whether the difference is shown in the quantity's unit, not relative to the reference
    """

    quantity: str
    unit: str
    reference: float
    found: dict[str, float | None]
    absolute: bool = False
    without: str = "none"

    def difference(self, formulation: str) -> float | None:
        """Relative to the reference, or in the row's unit."""
        value = self.found.get(formulation)
        if value is None:
            return None
        return value - self.reference if self.absolute else value / self.reference - 1.0


@dataclass
class Comparison:
    """Rows with their source, and the curves of its picture.

    kind : measured, closed form or program
    said : what is compared; limits : what keeps the two apart
    """

    title: str
    kind: str
    source: str
    said: str
    limits: str
    rows: list[Row]
    curves: dict[str, Any] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """For the file of figures."""
        return asdict(self)

    @staticmethod
    def from_json(found: dict[str, Any]) -> Comparison:
        """Back from the file of figures."""
        return Comparison(**{**found, "rows": [Row(**row) for row in found["rows"]]})

    def error(self, formulation: str) -> tuple[float, float]:
        """Mean and largest size of the relative differences."""
        sizes = [abs(d) for d in (row.difference(formulation) for row in self.rows) if d is not None]
        return (float(np.mean(sizes)), max(sizes)) if sizes else (float("nan"), float("nan"))


def attempted(of: Callable[[], float]) -> float | None:
    """What `of` gives, or None where flexsim finds no stable equilibrium."""
    try:
        return float(of())
    except ArithmeticError:
        return None


def both(of: Callable[[str], float]) -> dict[str, float | None]:
    """What each formulation gives."""
    return {name: attempted(lambda name=name: of(name)) for name in FORMULATIONS}
