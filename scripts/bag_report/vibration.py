"""How a robot's tip swings: its deflection, the spectrum, and its modes from the free decays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import csd, find_peaks

from ..bag import BagError
from .harmonics import Harmonic, harmonics_of
from .motion import Layout, Series, read
from .reading import Reading
from .ringdown import RingDown, search

Array = NDArray[np.float64]
TIP = ["position[-3:]", "rigid_position[-3:]"]
LONGEST_WINDOW = 8.0  # s of a spectrum's piece
LEAST = 128  # samples for a spectrum
PROMINENT = 10.0  # times its surroundings, for a peak
MOST_PEAKS = 8
TOO_SHORT = "the run holds fewer than three elastic states"
# Lines of a spectrum for each that the window tells apart: the highest is then within 0.3 % of a sine's
# amplitude wherever this lies; those of the window alone are up to 15 % below it.
PADDED = 8


@dataclass(frozen=True)
class Vibration:
    """The tip's elastic displacement (K, 3), m, base frame, evenly in time (K,), s, and what it tells.

    frequency (F,), Hz; amplitude (F,), m, of a steady vibration of that frequency, along the direction in
        which it is largest
    peaks : Hz, of the spectrum, highest first
    harmonics : those of the peaks that are multiples of a larger one
    decays : the free decays that were found
    why_not : reasons, a sentence each, why stretches that die away are none of them
    """

    series: Series
    time: Array
    deflection: Array
    frequency: Array
    amplitude: Array
    peaks: tuple[float, ...]
    harmonics: tuple[Harmonic, ...]
    decays: tuple[RingDown, ...]
    why_not: tuple[str, ...]

    @property
    def size(self) -> Array:
        """(K,) m, the deflection's length."""
        return np.asarray(np.linalg.norm(self.deflection, axis=1))


def vibration(
    reading: Reading, topic: str, layout: Layout | None, moving: tuple[Array, NDArray[np.bool_]] | None
) -> Vibration:
    """Read a tip's deflection and find its modes.

    moving : times (J,) and whether the joints were to move then, where that is known
    """
    series = read(reading, topic, TIP)
    off = np.asarray(series.values[TIP[0]] - series.values[TIP[1]], dtype=float)
    if off.ndim != 2 or off.shape[1] != 3 or not np.isfinite(off).all():
        raise BagError(f"{topic} holds no finite position of a tip")
    if len(series.time) < 3:
        return Vibration(series, series.time, off, np.empty(0), np.empty(0), (), (), (), (TOO_SHORT,))
    time, even = series.evenly(off)
    frequency, amplitude = spectrum(time, even)
    moved = None
    if moving is not None:
        at, moves = moving
        moved = np.interp(time, at, moves.astype(float)) > 0.0
    decays, why_not = search(time, even, moved)
    found = peaks(frequency, amplitude)
    known = harmonics_of([(f, float(np.interp(f, frequency, amplitude))) for f in found])
    return Vibration(
        series, time, even, frequency, amplitude, found, known, tuple(decays), tuple(why_not)
    )  # fmt: skip


def spectrum(time: Array, motion: Array) -> tuple[Array, Array]:
    """Return frequencies, Hz, and amplitudes of a motion (K, d), by Welch's method.

    A line's amplitude is that of a steady sine there.  In several directions the sines make an ellipse; the
    amplitude is its larger half axis, of the real part of the cross spectra, so that a circle has its radius.
    """
    if len(time) < LEAST:
        return np.empty(0), np.empty(0)
    period = float((time[-1] - time[0]) / (len(time) - 1))
    piece = min(len(time), max(LEAST, round(LONGEST_WINDOW / period)))
    directions = motion.shape[1]
    across = np.zeros((PADDED * piece // 2 + 1, directions, directions))
    frequency = np.empty(0)
    for i in range(directions):
        for k in range(i, directions):
            frequency, power = csd(
                motion[:, i], motion[:, k], 1.0 / period, "hann", piece, nfft=PADDED * piece,
                detrend="linear", scaling="spectrum",
            )  # fmt: skip
            across[:, i, k] = across[:, k, i] = power.real
    largest = np.linalg.eigvalsh(across)[:, -1]
    return frequency[1:], np.sqrt(2.0 * np.maximum(largest, 0.0))[1:]


def peaks(frequency: Array, amplitude: Array) -> tuple[float, ...]:
    """Return the frequencies of a spectrum's peaks, the highest first; each between its lines."""
    lines = amplitude[PADDED - 1 :: PADDED]  # those between show the window's own side lobes
    if len(lines) < 5 or not (lines > 0.0).all():
        return ()
    found, _ = find_peaks(np.log(lines), prominence=np.log(PROMINENT))
    places = []
    for k in sorted(found.tolist(), key=lambda n: -lines[n])[:MOST_PEAKS]:
        centre = PADDED * (k + 1) - 1
        near = np.arange(max(1, centre - PADDED), min(len(amplitude) - 1, centre + PADDED + 1))
        top = int(near[np.argmax(amplitude[near])])
        below, here, above = np.log(amplitude[top - 1 : top + 2])
        bend = below - 2.0 * here + above
        shift = 0.5 * (below - above) / bend if bend < 0.0 else 0.0  # of a parabola through three lines
        places.append(float(frequency[top] + shift * (frequency[1] - frequency[0])))
    return tuple(places)
