"""The bound on a reference's error holds for families of any order, and nothing is claimed of the others."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flexsim.study.estimate import SAFETY, settle
from flexsim.study.motion import Motion

STEPS = (1.0, 0.5, 0.25, 0.125)
T = np.linspace(0.0, 1.0, 40)[:, None]


def motion(error: float, ripple: float = 0.0) -> Motion:
    """A path that is off its limit by `error` along its way, and by `ripple` that no step explains."""
    tip = np.hstack([np.sin(3.0 * T), np.cos(2.0 * T), T])[:, None, :]
    off = error * np.hstack([T, T**2, np.sin(9.0 * T)])[:, None, :]
    return Motion(tip + off + ripple, np.sin(T) + error * T + ripple)


@pytest.mark.parametrize("order", [0.3, 0.5, 1.0, 1.5, 2.0, 2.2, 3.0, 4.0])
def test_the_bound_holds_whatever_the_order(order: float) -> None:
    """Errors C h^p: the true distance of the best from the limit is below the bound, for p of any method."""
    for scale in (1e-2, 1e-6):
        found = settle([motion(scale * h**order) for h in STEPS], 2.0)
        true = found.best.apart(motion(0.0))
        assert np.all(true <= SAFETY * found.error), (order, true, found.error)
        assert found.order[0] == pytest.approx(order, abs=0.05)


@pytest.mark.parametrize("seed", range(200))
def test_two_orders_at_once(seed: int) -> None:
    """A first-order part that hides behind one of second order is within the bound."""
    random = np.random.default_rng(seed)
    a, b, c = 10.0 ** random.uniform(-6, -2, 3) * random.choice([-1.0, 1.0], 3)
    found = settle([motion(a * h + b * h**2 + c * h**3) for h in STEPS], 2.0)
    true = found.best.apart(motion(0.0))
    assert np.all(true <= SAFETY * found.error), (a, b, c)


def test_what_does_not_settle_claims_nothing() -> None:
    """Differences that grow, as of vibrations that a step begins to follow, give no bound."""
    found = settle([motion(0.0), motion(1e-6), motion(1e-3), motion(1e-2)], 2.0)
    assert math.isinf(found.error[0])
    # and where nothing differs but by rounding there is nothing to settle
    still = settle([motion(0.0)] * 3, 2.0)
    assert np.all(still.error < 1e-10)


def test_extrapolation_takes_the_error_out() -> None:
    found = settle([motion(1e-3 * h * h) for h in STEPS], 2.0)
    assert found.best.apart(motion(0.0))[0] < 1e-12
    plain = settle([motion(1e-3 * h * h) for h in STEPS], 2.0, extrapolate=False)
    true = plain.best.apart(motion(0.0))[0]
    assert true <= plain.error[0] <= 20.0 * true  # by order one, as nothing better is believed
