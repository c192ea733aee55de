"""The leaf's equations and what holds it: unknowns that are held, supports with play, one-sided stops.

Supports that are not simply held enter by their forces. Of the leaf on as few points as hold it (`pinned`)
the flexibility at the supports is solved, column by column as they come to hold; the leaf's motion as a
rigid plate is then what brings the forces into balance. Where plays leave that motion free, springs too
soft to bend anything pull the leaf to the middle of its plays.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu

from .unilateral import Contact, contacts

Array = NDArray[np.float64]

CENTRING = 1e-3
"""N/m of the spring that centres a support in its play; a leaf's corner takes 1e3 N/m and more."""


@dataclass(frozen=True)
class Hold:
    """One unknown that is held between two bounds.

    unknown : its number; low, high : m; compliance : m/N beyond a bound
    share : of the support that the modelled part has: half of one on the mirror
    at_low, at_high : numbers of the supports that hold it there
    """

    unknown: int
    low: float
    high: float
    at_low: int
    at_high: int
    compliance: float = 0.0
    share: float = 1.0


def joined(holds: list[Hold]) -> list[Hold]:
    """No two rigid holds on one unknown: of both the tighter bounds. The first one's where both are alike."""
    found: dict[int, Hold] = {}
    soft = []
    for hold in holds:
        other = found.get(hold.unknown)
        if hold.compliance > 0.0:
            soft.append(hold)
            continue
        if other is not None and hold.low > other.low:
            other = replace(other, low=hold.low, at_low=hold.at_low)
        if other is not None and hold.high < other.high:
            other = replace(other, high=hold.high, at_high=hold.at_high)
        found[hold.unknown] = other or hold
    return [*found.values(), *soft]


class Equilibrium:
    """Solves K u = f + reactions, with K factored once.

    matrix (n, n) : N/m; held : unknowns that are zero
    holds : supports beside them; pinned : unknowns that hold the leaf against the rigid motions
    rigid (n, k) : those motions, none of which moves what is held
    """

    def __init__(
        self,
        matrix: csc_matrix,
        held: NDArray[np.int64],
        holds: list[Hold] | None = None,
        pinned: NDArray[np.int64] | None = None,
        rigid: Array | None = None,
    ) -> None:
        self._count = matrix.shape[0]
        self.holds = holds or []
        fixed = held if not self.holds or pinned is None else np.concatenate([held, pinned])
        self._free = np.setdiff1d(np.arange(self._count), fixed)
        self._factor = splu(
            matrix[self._free][:, self._free],
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        if not self.holds:
            return
        assert rigid is not None
        self._rigid = rigid
        centred = [h for h in self.holds if -np.inf < h.low < h.high < np.inf]
        springs = [replace(h, low=0.0, high=0.0, compliance=1.0 / CENTRING) for h in centred]
        every = [*self.holds, *springs]
        self._at = np.array([h.unknown for h in every])
        self._low = np.array([h.low for h in every])
        self._high = np.array([h.high for h in every])
        self._compliance = np.array([h.compliance / h.share for h in every])
        self._moved = rigid[self._at]
        self._columns: dict[int, Array] = {}
        self._flexibility = np.zeros((len(every), len(every)))
        self._known = np.zeros(len(every), dtype=bool)
        self._before: Contact = np.zeros(len(every), dtype=np.int64)

    def solve(self, load: Array) -> tuple[Array, Array]:
        """Unknowns (n,), m, and the holds' forces on the leaf (m,), N, under a load (n,), N."""
        u = self._elastic(load)
        if not self.holds:
            return u, np.zeros(0)
        free = u[self._at]

        def reactions(contact: Contact) -> tuple[Array, Array]:
            force, motion = self._balance(contact, free)
            on = np.flatnonzero(contact)
            moved = free + self._moved @ motion + self._compliance * force
            return force, moved + self._flexibility[:, on] @ force[on]

        contact = contacts(reactions, self._low, self._high, self._before.copy())
        self._before = contact
        force, motion = self._balance(contact, free)
        u = u + self._rigid @ motion
        for k in np.flatnonzero(contact):
            u = u + self._column(k) * force[k]
        return u, force[: len(self.holds)]

    def _balance(self, contact: Contact, free: Array) -> tuple[Array, Array]:
        """Forces (m,) and rigid motion (k,) if just these supports hold."""
        on = np.flatnonzero(contact)
        bound = np.where(contact[on] < 0, self._low[on], self._high[on])
        rigid = self._moved[on]
        size = len(on)
        for k in on[~self._known[on]]:
            self._flexibility[:, k] = self._column(k)[self._at]
            self._known[k] = True
        system = np.zeros((size + rigid.shape[1],) * 2)
        system[:size, :size] = self._flexibility[np.ix_(on, on)]
        system[:size, :size] += np.diag(self._compliance[on])
        system[:size, size:] = rigid
        system[size:, :size] = rigid.T
        right = np.concatenate([bound - free[on], np.zeros(rigid.shape[1])])
        # Rows and columns scaled: metres a newton beside metres.
        scale = np.ones(len(system))
        scale[:size] = 1.0 / np.sqrt(np.maximum(np.diag(system)[:size], 1e-12))
        scale[size:] = 1.0 / np.maximum(np.abs(scale[:size, None] * rigid).max(axis=0, initial=1e-30), 1e-30)
        found = scale * np.linalg.solve(scale[:, None] * system * scale, scale * right)
        force = np.zeros(len(contact))
        force[on] = found[:size]
        return force, found[size:]

    def _column(self, k: int) -> Array:
        """What a newton at the hold moves (n,), m, with the leaf pinned."""
        unknown = int(self._at[k])
        if unknown not in self._columns:
            push = np.zeros(self._count)
            push[unknown] = 1.0
            self._columns[unknown] = self._elastic(push)
        return self._columns[unknown]

    def _elastic(self, load: Array) -> Array:
        u = np.zeros(self._count)
        u[self._free] = self._factor.solve(load[self._free])
        return u
