"""Input shapers and trajectories against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from flexsim.controller.shaping import for_modes, shaper
from flexsim.controller.trajectory import Trajectory


@pytest.mark.parametrize(("frequency", "damping"), [(4.0, 0.0), (4.0, 0.1), (20.0, 0.02)])
def test_shapers_leave_no_vibration_of_their_mode(frequency: float, damping: float) -> None:
    """None of the mode itself; of a mode 5 % beside it ZVD leaves less than ZV, and less than 2 %."""
    zv, zvd = shaper("zv", frequency, damping), shaper("zvd", frequency, damping)
    for each in (zv, zvd):
        assert each.amplitudes.sum() == pytest.approx(1.0)
        assert each.residual(frequency, damping) < 1e-12
    beside = [each.residual(1.05 * frequency, damping) for each in (zv, zvd)]
    assert beside[1] < beside[0] < 0.1
    assert beside[1] < 0.02
    both = for_modes("zv", [(frequency, damping), (3.3 * frequency, damping)])
    assert both.residual(frequency, damping) < 1e-12
    assert both.residual(3.3 * frequency, damping) < 1e-12


def test_a_shaped_step_moves_an_oscillator_to_rest() -> None:
    """Twenty periods of x'' + w^2 x = w^2 u, exactly, under the shaped step."""
    frequency = 3.0
    w = 2.0 * np.pi * frequency
    impulses = shaper("zv", frequency)
    t = np.linspace(impulses.times[-1], impulses.times[-1] + 1.0, 200)
    response = sum(
        a * (1.0 - np.cos(w * (t - late)))
        for a, late in zip(impulses.amplitudes, impulses.times, strict=True)
    )
    np.testing.assert_allclose(response, 1.0, atol=1e-12)


def test_trajectory_is_a_cubic_between_points() -> None:
    """A cubic is met exactly, position and velocity; before and after it stands still."""
    time = np.array([0.1, 0.4, 1.0])

    def cubic(t: np.ndarray) -> np.ndarray:
        return np.stack([t**3 - t, 2.0 * t**2], axis=-1)

    def rate(t: np.ndarray) -> np.ndarray:
        return np.stack([3.0 * t**2 - 1.0, 4.0 * t], axis=-1)

    found = Trajectory(time, cubic(time), rate(time))
    for t in (0.1, 0.25, 0.4, 0.77, 1.0):
        position, velocity = found.at(t)
        np.testing.assert_allclose(position, cubic(np.array(t)), atol=1e-12)
        np.testing.assert_allclose(velocity, rate(np.array(t)), atol=1e-12)
    for t, end in ((0.0, 0), (2.0, -1)):
        position, velocity = found.at(t)
        np.testing.assert_allclose(position, cubic(time)[end], atol=1e-12)
        assert not velocity.any()
