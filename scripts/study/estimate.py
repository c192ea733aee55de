"""How far a converging family is from its limit: the order measured, the bound on the safe side.

Three members with a refinement of two give two differences; their ratio is the order that the family shows,
whatever its method promises.  Where that is the method's own order the family is extrapolated (Richardson)
and judged by what the extrapolation itself still changes; elsewhere its finest member counts, and what is
left of a geometric series with the shown ratio.  A family whose differences don't fall claims nothing.
Roache, Verification and Validation in Computational Science and Engineering (1998), chapter 5.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from .point import Array

SAFETY = 3.0
"""Times which a bound is larger than the largest sign of an error."""
NEAR = 0.35
"""So near to the method's order a shown order is that order."""
LEAST_ORDER = 0.25
"""A family of a lower shown order has not settled."""
ROUNDING = 1e-11
"""Part of what is measured below which differences are rounding and show no order."""


class Refined(Protocol):
    """A member of a family: its distance from another in each measure, and the extrapolation of both."""

    @property
    def size(self) -> Array: ...

    def apart(self, other: Any) -> Array: ...

    def beyond(self, coarser: Any, order: float) -> Any: ...


M = TypeVar("M", bound=Refined)


@dataclass(frozen=True)
class Settled(Generic[M]):
    """The best of a family, what it may be off in each measure (no safety in it), and the order it shows."""

    best: M
    error: Array
    order: Array


def shown_order(coarse: float, fine: float, rounding: float, nominal: float) -> float:
    """Order that two successive differences show; the method's own where both are rounding."""
    if max(coarse, fine) <= rounding:
        return nominal
    if fine <= 0.0:
        return math.inf
    return math.log2(coarse / fine) if coarse > 0.0 else -math.inf


def remainder(coarse: float, fine: float, order: float, nominal: float) -> float:
    """What is left after the finest member; infinite where the family has not settled."""
    if math.isinf(order) and order > 0.0:
        return fine
    if order < LEAST_ORDER:
        return math.inf
    return max(fine, coarse * 2.0 ** -min(order, nominal)) / (2.0 ** min(order, nominal) - 1.0)


def settle(family: Sequence[M], nominal: float, extrapolate: bool = True) -> Settled[M]:
    """Judge three members, each refined twice as far as the one before.

    nominal : the order that the method has where it is met; extrapolate : whether the best may lie beyond
    """
    coarse, middle, fine = family
    first, second = coarse.apart(middle), middle.apart(fine)
    noise = ROUNDING * fine.size
    order = np.array([shown_order(a, b, r, nominal) for a, b, r in zip(first, second, noise, strict=True)])
    settled = np.abs(order - nominal) <= NEAR
    if extrapolate and bool(np.all(settled)):
        earlier, best = middle.beyond(coarse, nominal), fine.beyond(middle, nominal)
        return Settled(best, best.apart(earlier) + noise, order)
    rest = [remainder(a, b, p, nominal) for a, b, p in zip(first, second, order, strict=True)]
    return Settled(fine, np.array(rest) + noise, order)
