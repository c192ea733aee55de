"""The order of accuracy that a curve's points show."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable
from itertools import pairwise

from .point import Outcome


def observed_orders(outcomes: Iterable[Outcome], measure: str, floor: float) -> dict[str, list[float]]:
    """Order from each step to the next smaller one, by curve, while the error is above `floor`."""
    curves: dict[str, list[Outcome]] = defaultdict(list)
    for o in outcomes:
        if o.ok and o.step is not None and math.isfinite(o.error(measure)):
            curves[o.curve].append(o)
    found: dict[str, list[float]] = {}
    for name, points in curves.items():
        points.sort(key=lambda o: -o.size)
        orders = [
            math.log(a.error(measure) / b.error(measure)) / math.log(a.size / b.size)
            for a, b in pairwise(points)
            if b.error(measure) > floor > 0.0
        ]
        if orders:
            found[name] = [round(x, 2) for x in orders]
    return found
