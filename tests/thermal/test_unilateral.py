"""Supports that hold from some movement on: the one solution is found, and the search ends."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from thermal_node.deformation.unilateral import Unsettled, contacts


def problem(seed):
    """A random compliance, movements without supports, and bounds; some closed, some one-sided."""
    random = np.random.default_rng(seed)
    m = int(random.integers(1, 30))
    root = random.normal(size=(m, m)) + 0.1 * np.eye(m)
    compliance = root @ root.T + 1e-3 * np.eye(m)
    free = 3.0 * random.normal(size=m)
    low, high = -random.uniform(0.0, 2.0, m), random.uniform(0.0, 2.0, m)
    low[random.random(m) < 0.3] = -np.inf
    high[random.random(m) < 0.3] = np.inf
    closed = random.random(m) < 0.2
    low[closed] = high[closed] = random.normal(size=closed.sum())
    return compliance, free, low, high


def solve(compliance, free, low, high, start):
    def reactions(contact):
        on = np.flatnonzero(contact)
        force = np.zeros(len(free))
        bound = np.where(contact < 0, low, high)
        force[on] = np.linalg.solve(compliance[np.ix_(on, on)], (bound - free)[on])
        return force, free + compliance @ force

    return reactions(contacts(reactions, low, high, start))


@pytest.mark.parametrize("seed", range(40))
def test_the_solution_is_that_of_the_least_energy(seed):
    """Held against another method: bounded least squares of the energy, min (y - free)' K (y - free)."""
    compliance, free, low, high = problem(seed)
    m = len(free)
    start = np.random.default_rng(seed).integers(-1, 2, m)
    start[(start < 0) & np.isinf(low)] = 0
    start[(start > 0) & np.isinf(high)] = 0
    force, place = solve(compliance, free, low, high, start)
    root = np.linalg.cholesky(np.linalg.inv(compliance)).T
    wide = np.where(high > low, high, low + 1e-12)
    expected = lsq_linear(root, root @ free, (low, wide), method="bvls", tol=1e-14).x
    np.testing.assert_allclose(place, expected, atol=1e-7)
    assert (place >= low - 1e-7).all() and (place <= high + 1e-7).all()
    inside = (place > low + 1e-6) & (place < high - 1e-6)
    assert np.abs(force[inside]).max(initial=0.0) < 1e-7


def test_what_is_not_finite_ends_with_a_word():
    with pytest.raises(Unsettled, match="not finite"):
        contacts(lambda _: (np.array([np.nan]), np.zeros(1)), -np.ones(1), np.ones(1), np.zeros(1, int))


def test_a_search_without_an_end_is_given_up():
    """Forces that contradict the movements, as no real leaf has: it says so instead of going on for ever."""
    with pytest.raises(Unsettled, match="was not found"):
        contacts(
            lambda c: (-1.0 * np.abs(c).astype(float), np.where(c == 0, -2.0, -1.0)),
            -np.ones(1), np.array([np.inf]), np.zeros(1, int),
        )  # fmt: skip
