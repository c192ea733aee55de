"""Where a motion dies away: stretches that may be free decays.

A decay may last a minute or a tenth of a second, so the vibrations that stand out are looked for in pieces of
several lengths, and each one's envelope within its own band.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_PERIODS = 3.0
LEAST_SIZE = 0.05  # part of the largest vibration of a frequency that a decay begins with
MOST_CANDIDATES = 4  # of one frequency
MOST_FREQUENCIES = 5
PIECES = (1, 4, 16, 64, 256)  # of a motion, in which vibrations are looked for
LEAST_PIECE = 64  # samples
BAND = (0.6, 1.6)  # of a frequency, that its envelope takes in


@dataclass(frozen=True)
class Window:
    """Samples from begin to end in which a vibration, Hz, of this size dies away."""

    begin: int
    end: int
    frequency: float
    size: float


def envelope(signal: Array, width: int) -> Array:
    """Return the root mean square (K,) of what swings within `width` samples around each."""
    width = max(3, min(width, len(signal)))
    power = np.zeros(len(signal))
    for column in signal.T:
        centred = column - column.mean()
        power += smooth(centred**2, width) - smooth(centred, width) ** 2
    return np.asarray(np.sqrt(np.maximum(power, 0.0)))


def smooth(values: Array, width: int) -> Array:
    """Return the mean (K,) of `width` samples around each; at the ends, of those that are there."""
    box = np.ones(min(width, len(values)))
    weight = np.convolve(np.ones(len(values)), box, mode="same")
    return np.asarray(np.convolve(values, box, mode="same")) / weight


def level(signal: Array) -> Array:
    """Return a signal (K, d) without its drift, a cubic."""
    basis = np.vander(np.linspace(-1.0, 1.0, len(signal)), 4)
    return np.asarray(signal - basis @ np.linalg.lstsq(basis, signal, rcond=None)[0])


def frequencies(signal: Array, period: float) -> list[float]:
    """Return the frequencies, Hz, that stand out of a signal (K, d) or of a piece of it; each once."""
    found: list[tuple[float, float]] = []
    for count in PIECES:
        size = len(signal) * 2 // (count + 1)
        if size < LEAST_PIECE:
            break
        best = (0.0, 0.0)
        window = np.hanning(size)[:, None]
        for begin in range(0, len(signal) - size + 1, max(1, size // 2)):
            lines = np.linalg.norm(np.fft.rfft(level(signal[begin : begin + size]) * window, axis=0), axis=1)
            lines[:3] = 0.0
            k = int(np.argmax(lines))
            best = max(best, (float(lines[k]) / size, k / (size * period)))
        if best[0] > 0.0 and not any(0.8 < best[1] / f < 1.25 for _, f in found):
            found.append(best)
    return [f for _, f in sorted(found, reverse=True)[:MOST_FREQUENCIES]]


def band(signal: Array, period: float, frequency: float) -> Array:
    """Return what of a signal (K, d) lies about a frequency; its ends are mirrored on."""
    width = min(len(signal), max(8, round(4.0 / (frequency * period))))
    flat = level(signal)
    long = np.concatenate([flat[width - 1 :: -1], flat, flat[: -width - 1 : -1]])
    lines = np.fft.rfft(long, axis=0)
    f = np.fft.rfftfreq(len(long), period)
    lines[(f < BAND[0] * frequency) | (f > BAND[1] * frequency)] = 0.0
    return np.asarray(np.fft.irfft(lines, len(long), axis=0)[width : width + len(signal)])


def candidates(signal: Array, period: float, moved: NDArray[np.bool_] | None) -> list[Window]:
    """Return where a signal (K, d) dies away, the most promising first.

    moved : ndarray (K,) or None
        Where the robot is known to be driven along its way; a decay does not go through it.
    """
    # Of the fluctuation within a second, so that a slow motion does not hide the vibration.
    second = max(8, round(1.0 / period))
    swing = signal - np.stack([smooth(column, second) for column in signal.T], axis=1)
    if moved is not None:
        swing[moved] = 0.0
    found: list[Window] = []
    for frequency in frequencies(swing, period):
        found += dying(signal, period, frequency, moved)
    return sorted(found, key=lambda w: -w.size)


def dying(signal: Array, period: float, frequency: float, moved: NDArray[np.bool_] | None) -> list[Window]:
    """Return the stretches in which a vibration of one frequency dies away, the largest first."""
    width = max(4, round(2.0 / (frequency * period)))
    size = envelope(band(signal, period, frequency), width)
    if moved is not None:
        size = np.where(moved, 0.0, size)
    found = []
    free = np.ones(len(signal), bool)
    floor = float(np.quantile(size[size > 0.0], 0.05)) if (size > 0.0).any() else 0.0
    for _ in range(MOST_CANDIDATES):
        left = np.where(free, size, 0.0)
        begin = int(np.argmax(left))
        if left[begin] <= LEAST_SIZE * size.max() or left[begin] <= 0.0:
            break
        end, least = begin, left[begin]
        # Where there is nothing but noise there is nothing to learn.
        last = max(0.003 * left[begin], 2.0 * floor if left[begin] > 5.0 * floor else 0.0)
        while end < len(signal) and free[end] and (moved is None or not moved[end]):
            # Two near modes beat: what rises again somewhat is still the same decay.
            if size[end] > 2.0 * least and size[end] > 0.1 * left[begin]:
                break
            least = min(least, size[end])
            if size[end] < last:
                break
            end += 1
        before = max(0, begin - width)
        free[before : max(end, begin + width)] = False
        if (end - begin) * period * frequency >= LEAST_PERIODS:
            found.append(Window(begin, end, frequency, float(left[begin])))
    return found
