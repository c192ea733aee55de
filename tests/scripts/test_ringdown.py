"""Damping ratios from ring-downs of which they are known."""

from __future__ import annotations

import numpy as np
import pytest
from flexsim.bag_report.ringdown import identify, ring_downs
from numpy.typing import NDArray

PERIOD, BEGIN, END = 0.002, 2.0, 8.0
# A damping ratio is found to 1 % of itself with noise of a thousandth of the amplitude, to 6 % with a
# hundredth; a frequency always to a thousandth.
BOUND = {0.0: 1e-3, 1e-3: 0.01, 1e-2: 0.06}


def decay(time: NDArray, frequency: float, zeta: float, amplitude: float) -> NDArray:
    """A damped sine that begins at time 0, of the natural frequency in Hz."""
    omega = 2.0 * np.pi * frequency
    swing = np.cos(omega * np.sqrt(1.0 - zeta**2) * time + 0.3)
    return amplitude * np.exp(-zeta * omega * time) * swing


def run(modes: list[tuple[float, float, float]], noise: float) -> tuple[NDArray, NDArray]:
    """A driven motion, and from BEGIN on the free decay of some modes, each in a direction of its own."""
    random = np.random.default_rng(7)
    time = np.arange(0.0, END, PERIOD)
    signal = np.zeros((len(time), 3))
    free = time >= BEGIN
    for mode in modes:
        direction = random.normal(size=3)
        signal[free] += decay(time[free] - BEGIN, *mode)[:, None] * direction / np.linalg.norm(direction)
    signal[~free] += 0.3 * np.sin(2.0 * np.pi * 0.7 * time[~free])[:, None]
    return time, 0.5 + signal + noise * random.normal(size=signal.shape)


@pytest.mark.parametrize("noise", BOUND)
@pytest.mark.parametrize(
    "modes",
    [
        [(6.0, 0.0005, 1.0)],
        [(6.0, 0.01, 1.0)],
        [(6.0, 0.05, 1.0)],
        [(1.2, 0.02, 1.0)],
        [(40.0, 0.01, 1.0)],
        [(5.0, 0.01, 1.0), (5.3, 0.015, 0.8)],  # a beat: a decrement of peaks would be wrong
        [(4.8, 0.01, 1.0), (8.2, 0.02, 0.6), (17.1, 0.03, 0.3)],
    ],
)
def test_known_damping(modes: list[tuple[float, float, float]], noise: float) -> None:
    """Every mode's damping ratio within the bound; the decay is found within the run, and no more modes."""
    found = ring_downs(*run(modes, noise))[0]
    assert BEGIN - 0.3 <= found.begin < found.end <= END
    assert found.explained > 0.98
    assert len(found.modes) == len(modes)
    for frequency, zeta, _ in modes:
        near = min(found.modes, key=lambda m: abs(m.frequency - frequency))
        assert near.frequency == pytest.approx(frequency, rel=1e-3)
        assert near.damping == pytest.approx(zeta, rel=BOUND[noise])


def test_strong_damping_where_the_motion_is_known() -> None:
    """A decay of few periods beside a large driven motion is found where that motion is known."""
    modes = [(6.0, 0.15, 1.0)]
    time, signal = run(modes, 1e-3)
    found = ring_downs(time, signal, moved=time < BEGIN)[0]
    assert found.modes[0].damping == pytest.approx(0.15, rel=0.02)


def test_what_does_not_ring_has_no_damping() -> None:
    """Noise, a steady vibration that is driven and modulated, rest, and too little: nothing is claimed."""
    random = np.random.default_rng(3)
    time = np.arange(0.0, 6.0, PERIOD)
    assert ring_downs(time, random.normal(size=(len(time), 3))) == []
    chirp = np.sin(2.0 * np.pi * (2.0 + time) * time) * np.exp(-0.2 * time)
    assert ring_downs(time, np.repeat(chirp[:, None], 3, axis=1)) == []
    assert ring_downs(time, np.ones((len(time), 3))) == []
    assert ring_downs(time[:50], np.ones((50, 3))) == []
    assert identify(np.full((200, 3), np.nan), PERIOD) == ((), 0.0)


def test_an_undamped_vibration_has_none() -> None:
    """A steady sine has a damping ratio of nothing, not of the window's length."""
    time = np.arange(0.0, 6.0, PERIOD)
    modes, explained = identify(np.sin(2.0 * np.pi * 5.0 * time)[:, None], PERIOD)
    assert explained > 0.999
    assert abs(modes[0].damping) < 1e-5
