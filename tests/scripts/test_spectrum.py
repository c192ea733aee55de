"""Amplitudes of a report's spectrum, and vibrations that come of others, against motions made for it."""

from __future__ import annotations

import numpy as np
import pytest
from flexsim.bag_report.harmonics import harmonics_of
from flexsim.bag_report.ringdown import ring_downs, search
from flexsim.bag_report.vibration import peaks, spectrum
from flexsim.rerun_view.spectrum import spectrum as live_spectrum

TIME = np.arange(20 * 500) / 500.0


def along(direction: list[float], values: np.ndarray) -> np.ndarray:
    """A motion along a direction."""
    return np.outer(values, np.array(direction) / np.linalg.norm(direction))


@pytest.mark.parametrize("frequency", [1.03, 7.25, 7.27, 7.29, 7.3125, 61.97])
def test_a_sine_anywhere_between_lines(frequency: float) -> None:
    """The highest line is within 1 % of a sine's amplitude, in any direction; the peak within 0.002 Hz."""
    motion = along([1.0, 2.0, -2.0], 1e-3 * np.sin(2.0 * np.pi * frequency * TIME + 0.4))
    lines, amplitude = spectrum(TIME, motion)
    assert amplitude.max() == pytest.approx(1e-3, rel=0.01)
    assert peaks(lines, amplitude) == pytest.approx([frequency], abs=2e-3)
    recent = TIME <= 4.0
    if frequency < 20.0:
        assert live_spectrum(TIME[recent], motion[recent])[1].max() == pytest.approx(1e-3, rel=0.01)


@pytest.mark.parametrize("small", [0.0, 0.3, 1.0])
def test_an_ellipse_has_its_larger_half_axis(small: float) -> None:
    phase = 2.0 * np.pi * 7.27 * TIME
    motion = along([1.0, 1.0, 0.0], np.cos(phase)) + small * along([1.0, -1.0, 1.0], np.sin(phase))
    assert spectrum(TIME, motion)[1].max() == pytest.approx(1.0, rel=0.01)


def test_two_sines_and_noise_have_their_own_amplitudes() -> None:
    motion = along([1.0, 0.0, 0.0], np.sin(2.0 * np.pi * 5.03 * TIME))
    motion += along([0.0, 1.0, 1.0], 0.2 * np.sin(2.0 * np.pi * 13.01 * TIME))
    motion += 0.01 * np.random.default_rng(1).normal(size=motion.shape)
    lines, amplitude = spectrum(TIME, motion)
    found = peaks(lines, amplitude)
    assert found[:2] == pytest.approx([5.03, 13.01], abs=5e-3)
    assert np.interp(found[:2], lines, amplitude) == pytest.approx([1.0, 0.2], rel=0.01)


def test_harmonics_are_recognised() -> None:
    """Twice a frequency, and a sum of two, come of larger ones; another mode does not, nor a large one."""
    seen = [(5.0, 1.0), (10.01, 0.1), (7.3, 0.6), (12.29, 0.02), (17.0, 0.3), (21.9, 0.5)]
    assert [(h.frequency, h.of) for h in harmonics_of(seen)] == [
        (10.01, "2 x 5 Hz"),
        (12.29, "7.3 + 5 Hz"),
    ]


def test_a_second_harmonic_of_a_decay_is_no_mode() -> None:
    """What goes with the square of a mode dies away twice as fast and has twice its frequency."""
    rate = 2.0 * np.pi * 4.0 * 0.01
    mode = np.exp(-rate * TIME) * np.cos(2.0 * np.pi * 4.0 * TIME)
    motion = along([0.0, 1.0, 0.2], mode) + along([1.0, 0.0, 0.0], 0.2 * mode**2)
    other = np.exp(-rate * TIME) * np.cos(2.0 * np.pi * 8.4 * TIME)
    found = ring_downs(TIME, motion + along([0.0, 0.0, 1.0], 0.3 * other))[0]
    assert [m.frequency for m in found.modes] == pytest.approx([4.0, 8.4], rel=1e-3)
    assert [(h.frequency, h.of) for h in found.harmonics] == [(pytest.approx(8.0, rel=1e-3), "2 x 4 Hz")]


@pytest.mark.parametrize("noise", [1e-3, 1e-2])
@pytest.mark.parametrize(
    ("frequency", "damping"),
    [(0.7, 0.02), (7.3, 0.02), (7.3, 0.1), (23.0, 0.1), (61.0, 0.02), (61.0, 0.005)],
)
def test_short_decays_in_long_runs(frequency: float, damping: float, noise: float) -> None:
    """A decay of a tenth of a second in a run of twenty is found, with its frequency and damping."""
    random = np.random.default_rng(5)
    free, omega = TIME >= 2.0, 2.0 * np.pi * frequency
    motion = 0.5 + noise * random.normal(size=(len(TIME), 3))
    since = TIME[free] - 2.0
    motion[free] += along([1.0, 0.5, -1.0], np.exp(-damping * omega * since) * np.cos(omega * since))
    found, why_not = search(TIME, motion)
    assert found, why_not
    assert found[0].modes[0].frequency == pytest.approx(frequency, rel=0.01)
    assert found[0].modes[0].damping == pytest.approx(damping, rel=0.25)


def test_reasons_are_given_where_there_is_no_decay() -> None:
    random = np.random.default_rng(3)
    for motion in (random.normal(size=(3000, 3)), np.zeros((3000, 3)), np.zeros((50, 3))):
        found, why_not = search(TIME[: len(motion)], motion)
        assert found == []
        assert why_not
