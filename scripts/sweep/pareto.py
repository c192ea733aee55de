"""The rows that no other row beats in every aim."""

from __future__ import annotations

import numpy as np


def front(aims: np.ndarray) -> np.ndarray:
    """Return numbers of the rows (K, aims), all to be minimised, that none is at least as good as and better.

    Rows with a NaN are never among them; equal rows are all kept.
    """
    good = np.flatnonzero(~np.isnan(aims).any(axis=1))
    kept: list[int] = []
    # In lexical order nothing that comes later beats what came before.
    order = good[np.lexsort(aims[good].T[::-1])]
    for n in order:
        beaten = any(bool((aims[k] <= aims[n]).all() and (aims[k] < aims[n]).any()) for k in kept)
        if not beaten:
            kept.append(int(n))
    return np.array(sorted(kept), dtype=int)
