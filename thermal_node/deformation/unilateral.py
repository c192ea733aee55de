"""Supports that hold only from some movement on: a bounded linear complementarity problem.

    y = free + compliance r,  low <= y <= high,  r >= 0 where y = low, r <= 0 where y = high, else r = 0

with a symmetric positive definite compliance, so that there is one solution. Solved by block principal
pivoting (Judice and Pires 1994, Computers and Operations Research 21, 587): all that is infeasible changes
at once while that helps, else one by one in Murty's order, which terminates.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Contact = NDArray[np.int64]

GRACE = 10
"""Block changes in a row that may fail to lower the number of infeasible supports."""
MOST_PER_SUPPORT = 100
CLOSE, WEAK = 1e-8, 1e-8
"""Shares of the largest movement and force below which a support counts as feasible."""


class Unsettled(RuntimeError):
    """A shape that was not found; says why."""


def contacts(
    reactions: Callable[[Contact], tuple[Array, Array]], low: Array, high: Array, start: Contact
) -> Contact:
    """Which of m supports hold: -1 at its low bound, +1 at its high one, 0 neither.

    reactions(contact) : forces r (m,), N, and movements y (m,), m, if just those hold
    low, high (m,) : m, low <= high; a support with low == high always holds
    start (m,) : where to begin

    Raises
    ------
    Unsettled
    """
    always = low == high
    contact = np.where(always, -1, start)
    best, grace = len(low) + 1, GRACE
    for _ in range(MOST_PER_SUPPORT * (len(low) + 1)):
        force, place = reactions(contact)
        if not (np.isfinite(force).all() and np.isfinite(place).all()):
            raise Unsettled("the forces of its supports are not finite")
        near = CLOSE * max(float(np.abs(place).max(initial=0.0)), 1e-9)
        weak = WEAK * max(float(np.abs(force).max(initial=0.0)), 1e-9)
        change = contact.copy()
        change[(contact == 0) & (place < low - near)] = -1
        change[(contact == 0) & (place > high + near)] = 1
        change[(contact == -1) & (force < -weak) & ~always] = 0
        change[(contact == 1) & (force > weak)] = 0
        wrong = np.flatnonzero(change != contact)
        if len(wrong) == 0:
            return contact
        if len(wrong) < best:
            best, grace = len(wrong), GRACE
        elif grace > 0:
            grace -= 1
        else:
            wrong = wrong[-1:]
        contact[wrong] = change[wrong]
    raise Unsettled("which of its supports hold was not found")
