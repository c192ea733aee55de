"""How far a converging family is from its limit: the order measured, the bound on the safe side.

Members with a refinement of two give differences; the ratio of two is the order that the family shows,
whatever its method promises.  Where every ratio shows the method's own order the family is extrapolated
(Richardson) and judged by what the extrapolation itself still changes.  Elsewhere its finest member counts,
and what is left of a geometric series of order one, or of the least order shown.  Four members make two
ratios: a part of lower order that happens to oppose another can feign one, hardly both.  A family whose
differences don't fall claims nothing.
Roache, Verification and Validation in Computational Science and Engineering (1998), chapter 5.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
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


def remainder(differences: Sequence[float], order: float) -> float:
    """What is left after the finest member, by all differences, the coarsest first; infinite if not settled.

    Where the method's own order is not shown no more than the first is believed: a higher one is as likely
    two parts that oppose each other, and then a coarser difference tells more than the last.
    """
    if order < LEAST_ORDER:
        return math.inf
    ratio = 2.0 ** min(order, 1.0)
    last = len(differences) - 1
    return max(d * ratio ** (k - last) for k, d in enumerate(differences)) / (ratio - 1.0)


def settle(family: Sequence[M], nominal: float, extrapolate: bool = True) -> Settled[M]:
    """Judge three members or more, each refined twice as far as the one before.

    nominal : the order that the method has where it is met; extrapolate : whether the best may lie beyond
    """
    fine = family[-1]
    noise = ROUNDING * fine.size
    differences = np.array([a.apart(b) for a, b in pairwise(family)])
    shown = np.array([
        [shown_order(a, b, r, nominal) for a, b, r in zip(first, second, noise, strict=True)]
        for first, second in pairwise(differences)
    ])  # fmt: skip
    order = shown[-1]
    if extrapolate and bool(np.all(np.abs(shown - nominal) <= NEAR)):
        # The extrapolated family must fall too: else what feigned the order is still there.
        beyond = [b.beyond(a, nominal) for a, b in pairwise(family)]
        changes = np.array([a.apart(b) for a, b in pairwise(beyond)])
        if bool(np.all(changes[1:] <= np.maximum(changes[:-1], noise))):
            halves = 0.5 ** np.arange(len(changes))[::-1, None]
            return Settled(beyond[-1], np.max(halves * changes, axis=0) + noise, order)
    least = shown.min(axis=0)
    rest = [remainder(list(d), p) for d, p in zip(differences.T, least, strict=True)]
    return Settled(fine, np.array(rest) + noise, order)
