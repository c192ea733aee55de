"""Which input matters: Morris' elementary effects, Sobol's indices with bootstrap intervals.

Morris (1991), Campolongo et al. (2007) for mu*; Saltelli et al. (2010) table 2 (b) for first-order
indices and Jansen's (f) for total ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .sampling import shares

Array = np.ndarray


@dataclass(frozen=True)
class Effect:
    """Morris' figures of one input: what changes when it goes through all its values.

    mu_star : mean size; mu : mean; sigma : deviation of the effects; error : standard error of mu_star
    """

    mu_star: float
    mu: float
    sigma: float
    error: float


@dataclass(frozen=True)
class Index:
    """Sobol's indices of one input, each (value, lower, upper)."""

    first: tuple[float, float, float]
    total: tuple[float, float, float]


def morris_shares(trajectories: int, dimension: int, levels: int, seed: int) -> Array:
    """Points (trajectories, dimension + 1, dimension): each trajectory changes one input after the other.

    Levels are the middles of equal shares, so that no distribution is asked for its endless ends.
    """
    rng = np.random.default_rng(seed)
    jump = levels // 2
    made = np.empty((trajectories, dimension + 1, dimension))
    for one in made:
        low = rng.integers(0, jump, dimension)
        up = rng.random(dimension) < 0.5
        place = np.where(up, low, low + jump)
        one[0] = place
        for n, i in enumerate(rng.permutation(dimension)):
            place = place.copy()
            place[i] += jump if up[i] else -jump
            one[n + 1] = place
    return (made + 0.5) / levels


def morris_effects(at: Array, values: Array) -> list[Effect]:
    """Effects from points (T, d + 1, d) and values (T, d + 1); trajectories with a NaN are left out.

    Raises
    ------
    ValueError
        Where fewer than two trajectories are whole.
    """
    whole = np.isfinite(values).all(axis=1)
    if whole.sum() < 2:
        raise ValueError(
            "fewer than two trajectories have no failed or infinite row; ask for more trajectories"
        )
    at, values = at[whole], values[whole]
    steps, changes = np.diff(at, axis=1), np.diff(values, axis=1)
    moved = np.abs(steps).argmax(axis=2)
    slopes = changes / np.take_along_axis(steps, moved[..., None], axis=2)[..., 0]
    found = []
    for i in range(at.shape[2]):
        effects = slopes[moved == i]
        count = len(effects)
        found.append(
            Effect(
                float(np.abs(effects).mean()),
                float(effects.mean()),
                float(effects.std(ddof=1)),
                float(np.abs(effects).std(ddof=1) / np.sqrt(count)),
            )
        )
    return found


def saltelli_shares(method: str, count: int, dimension: int, seed: int) -> Array:
    """Points (count, dimension + 2, dimension): A, B, and A with column i of B."""
    both = shares(method, count, 2 * dimension, seed)
    a, b = both[:, :dimension], both[:, dimension:]
    made = np.repeat(a[:, None, :], dimension + 2, axis=1)
    made[:, 1] = b
    for i in range(dimension):
        made[:, 2 + i, i] = b[:, i]
    return made


def sobol_indices(values: Array, confidence: float, resamples: int, seed: int) -> list[Index]:
    """Indices from values (count, dimension + 2); a row with a NaN is left out.

    The intervals are percentiles of bootstrap resamples of the rows.

    Raises
    ------
    ValueError
        Where too few rows are whole, or the values do not differ.
    """
    values = values[np.isfinite(values).all(axis=1)]
    if len(values) < 8:
        raise ValueError(f"only {len(values)} samples have no failed or infinite row; give a greater count")
    if np.ptp(values) == 0.0:
        raise ValueError("does not change with any input")
    # In units of its own size, so that neither squares nor differences lose digits.
    values = (values - values[:, :2].mean()) / np.ptp(values)
    first, total = _indices(values)
    rng = np.random.default_rng(seed)
    drawn = np.array([_indices(values[rng.integers(0, len(values), len(values))]) for _ in range(resamples)])
    tail = 0.5 * (1.0 - confidence)
    low, high = np.nanquantile(drawn, [tail, 1.0 - tail], axis=0)
    return [
        Index(
            (float(first[i]), float(low[0, i]), float(high[0, i])),
            (float(total[i]), float(low[1, i]), float(high[1, i])),
        )
        for i in range(values.shape[1] - 2)
    ]


def _indices(values: Array) -> tuple[Array, Array]:
    a, b, mixed = values[:, 0], values[:, 1], values[:, 2:]
    variance = values[:, :2].var()
    if variance == 0.0:
        return np.full(mixed.shape[1], np.nan), np.full(mixed.shape[1], np.nan)
    first = (b[:, None] * (mixed - a[:, None])).mean(axis=0) / variance
    total = 0.5 * ((a[:, None] - mixed) ** 2).mean(axis=0) / variance
    return first, total
