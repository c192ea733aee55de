"""The spectrum of a vibration that goes on: of the last seconds, again and again."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

WINDOW = 4.0  # s
HIGHEST = 100.0  # Hz
SAMPLES = 2048  # of a window: enough for HIGHEST
PADDED = 8  # lines that are looked at for each that is shown
LEAST = 64  # samples that a window must hold


def spectrum(time: NDArray[np.float64], motion: NDArray[np.float64]) -> tuple[NDArray, NDArray]:
    """Return frequencies, Hz, and amplitudes of a motion (K, n), along the direction in which it is largest.

    A line shows the largest amplitude about it, so that a sine of amplitude a has a peak of height a wherever
    it lies between lines, and a circle one of its radius. Times need not be evenly spaced;
    between them lines are drawn, which takes 5 % of a sine at an eighth of their rate.
    """
    span = time[-1] - time[0]
    if len(time) < LEAST or not span > 0.0:
        return np.zeros(0), np.zeros(0)
    even = time[0] + span * np.arange(SAMPLES) / SAMPLES
    moved = np.stack([np.interp(even, time, column) for column in motion.T], axis=1)
    # What drifts is the arm on its way, not its vibration.
    basis = np.vander((even - even.mean()) / span, 4)
    moved -= basis @ np.linalg.lstsq(basis, moved, rcond=None)[0]
    window = np.hanning(SAMPLES)
    lines = np.fft.rfft(moved * window[:, None], PADDED * SAMPLES, axis=0) * 2.0 / window.sum()
    across = (lines[:, :, None] * lines[:, None, :].conj()).real
    fine = np.sqrt(np.maximum(np.linalg.eigvalsh(across)[:, -1], 0.0))
    around = np.lib.stride_tricks.sliding_window_view(np.pad(fine, PADDED // 2), PADDED + 1)[::PADDED]
    frequency = np.fft.rfftfreq(SAMPLES, span / SAMPLES)
    # Beyond half of the rate at which it was sampled there is nothing to know.
    known = frequency <= min(HIGHEST, 0.5 * (len(time) - 1) / span)
    return frequency[known], around.max(axis=1)[known]


class Running:
    """Collects a motion and gives its spectrum every so often.

    Parameters
    ----------
    every : float, s
    """

    def __init__(self, every: float) -> None:
        self.every = every
        self._time: NDArray[np.float64] = np.empty(0)
        self._motion: NDArray[np.float64] = np.empty((0, 3))
        self._next = WINDOW / 2

    def add(self, time: NDArray[np.float64], motion: NDArray) -> list[tuple[float, NDArray, NDArray]]:
        """Take up K samples (K,), (K, 3); returns times, frequencies and amplitudes that are due."""
        self._time = np.concatenate([self._time, time])
        self._motion = np.concatenate([self._motion, motion])
        found = []
        while len(self._time) and self._time[-1] >= self._next:
            a, b = np.searchsorted(self._time, [self._next - WINDOW, self._next])
            if b - a >= LEAST:
                found.append((self._next, *spectrum(self._time[a:b], self._motion[a:b])))
            self._next += self.every
        keep = np.searchsorted(self._time, self._next - WINDOW)
        self._time, self._motion = self._time[keep:], self._motion[keep:]
        return found
