"""How a robot's tip swings: its deflection, the spectrum, and its modes from the free decays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import find_peaks, welch

from ..bag import BagError
from .motion import Layout, Series, read
from .reading import Reading
from .ringdown import RingDown, ring_downs

Array = NDArray[np.float64]
TIP = ["position[-3:]", "rigid_position[-3:]"]
LONGEST_WINDOW = 8.0  # s of a spectrum's piece
LEAST = 128  # samples for a spectrum
PROMINENT = 10.0  # times its surroundings, for a peak
MOST_PEAKS = 8


@dataclass(frozen=True)
class Vibration:
    """The tip's elastic displacement (K, 3), m, base frame, evenly in time (K,), s, and what it tells.

    frequency (F,), Hz; amplitude (F,), m, of a steady vibration with that line
    peaks : Hz, of the spectrum, highest first
    decays : the free decays that were found
    """

    series: Series
    time: Array
    deflection: Array
    frequency: Array
    amplitude: Array
    peaks: tuple[float, ...]
    decays: tuple[RingDown, ...]

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
        return Vibration(series, series.time, off, np.empty(0), np.empty(0), (), ())
    time, even = series.evenly(off)
    frequency, amplitude = spectrum(time, even)
    moved = None
    if moving is not None:
        at, moves = moving
        moved = np.interp(time, at, moves.astype(float)) > 0.0
    decays = ring_downs(time, even, moved)
    return Vibration(series, time, even, frequency, amplitude, peaks(frequency, amplitude), tuple(decays))


def spectrum(time: Array, motion: Array) -> tuple[Array, Array]:
    """Return frequencies, Hz, and amplitudes of a motion (K, d), in all directions, by Welch's method."""
    if len(time) < LEAST:
        return np.empty(0), np.empty(0)
    period = float((time[-1] - time[0]) / (len(time) - 1))
    piece = min(len(time), max(LEAST, round(LONGEST_WINDOW / period)))
    frequency, power = welch(
        motion, 1.0 / period, "hann", piece, detrend="linear", scaling="spectrum", axis=0
    )  # fmt: skip
    return frequency[1:], np.sqrt(2.0 * power.sum(axis=1))[1:]


def peaks(frequency: Array, amplitude: Array) -> tuple[float, ...]:
    """Return the frequencies of a spectrum's peaks, the highest first; each between its lines."""
    if len(frequency) < 5 or not (amplitude > 0.0).all():
        return ()
    level = np.log(amplitude)
    found, _ = find_peaks(level, prominence=np.log(PROMINENT))
    places = []
    for k in sorted(found.tolist(), key=lambda n: -amplitude[n])[:MOST_PEAKS]:
        below, here, above = level[k - 1 : k + 2]
        shift = 0.5 * (below - above) / (below - 2.0 * here + above)  # of a parabola through three lines
        places.append(float(frequency[k] + shift * (frequency[1] - frequency[0])))
    return tuple(places)
