"""How far closed loops are from a singular configuration, from the equations that a step has linearised."""

from __future__ import annotations

import numpy as np

from ..compiled.kernel import kernel
from .assembly import Assembly

SWEEPS = 12
SETTLED = 1e-12
NEAR = 0.1  # conditioning that is worth a warning


@kernel
def rotate_columns(a):
    """Turn the columns of a (r, c), c <= r, until they are normal to each other (one-sided Jacobi)."""
    rows, columns = a.shape
    for _ in range(SWEEPS):
        largest = 0.0
        for i in range(columns):
            for k in range(i + 1, columns):
                ii = ik = kk = 0.0
                for r in range(rows):
                    ii += a[r, i] * a[r, i]
                    ik += a[r, i] * a[r, k]
                    kk += a[r, k] * a[r, k]
                if ik * ik <= SETTLED * SETTLED * ii * kk:
                    continue
                largest = max(largest, ik * ik / (ii * kk))
                half = (kk - ii) / (2.0 * ik)
                t = 1.0 / (abs(half) + np.sqrt(1.0 + half * half))
                if half < 0.0:
                    t = -t
                c = 1.0 / np.sqrt(1.0 + t * t)
                s = c * t
                for r in range(rows):
                    x, y = a[r, i], a[r, k]
                    a[r, i] = c * x - s * y
                    a[r, k] = s * x + c * y
        if largest <= SETTLED:
            return


@kernel
def conditioning(work, row_scale, column, column_scale, rank, a):
    """How well the actuated joints guide the passive ones: at most 1, 0 at a singular configuration.

    The rank-th singular value of the equations' derivative by the passive joints, over the root mean square
    of the `rank` singular values of that by all joints; rows and columns scaled to one unit of length.  Where
    it is zero the passive joints can move with the actuated ones held (a singularity of the second kind,
    Gosselin & Angeles, IEEE Trans. Robot. Autom. 6 (1990) 281).

    column (m,) : the place of a passive joint among them, -1 for an actuated one; a : buffer, (R, p) or
    (p, R), whichever has fewer columns.
    """
    w, m, equations = work.closure, column.size, row_scale.size
    upright = a.shape[0] == equations
    total = 0.0
    for i in range(equations):
        for k in range(m):
            value = w[i, k] * row_scale[i] * column_scale[k]
            total += value * value
            p = column[k]
            if p >= 0:
                if upright:
                    a[i, p] = value
                else:
                    a[p, i] = value
    if total == 0.0:
        return 0.0
    rotate_columns(a)
    found = 0.0
    for i in range(a.shape[1]):
        own = 0.0
        for r in range(a.shape[0]):
            own += a[r, i] * a[r, i]
        before = 0
        for k in range(a.shape[1]):
            longer = 0.0
            for r in range(a.shape[0]):
                longer += a[r, k] * a[r, k]
            if longer > own or (longer == own and k < i):
                before += 1
        if before == rank - 1:
            found = own
    return np.sqrt(found * rank / total)


class Singularity:
    """The watch over a robot's loops.

    Attributes
    ----------
    now, worst : `conditioning` at the last look, and the least so far
    """

    def __init__(self, assembly: Assembly, x: np.ndarray) -> None:
        model = assembly.model
        passive = np.flatnonzero(~model.actuated)
        equations = len(model.chain.closing)
        self._rows, self._columns = assembly.row_scale, assembly.column_scale
        self._column = np.full(model.joints, -1, dtype=np.int64)
        self._column[passive] = np.arange(passive.size)
        self._rank = min(passive.size, assembly.rank(x))
        tall = equations >= passive.size
        self._buffer = np.zeros((equations, passive.size) if tall else (passive.size, equations))
        self._now = self.now = self.worst = 1.0
        self._now = self.look(assembly.work)

    def begin(self) -> None:
        """Return to the conditioning of the state that the watch began with."""
        self.now = self.worst = self._now

    @property
    def near(self) -> bool:
        """Whether a singular configuration is near, or was since `worst` was set back."""
        return self.worst < NEAR

    @property
    def warning(self) -> str:
        """What is the matter, in a sentence; empty where nothing is."""
        if not self.near:
            return ""
        return f"the loops come near a singular configuration: conditioning {self.worst:.3f}, at best 1"

    def look(self, work) -> float:
        """Take the conditioning from what the last step has linearised."""
        if self._rank > 0:
            self.now = conditioning(work, self._rows, self._column, self._columns, self._rank, self._buffer)
            self.worst = min(self.worst, self.now)
        return self.now
