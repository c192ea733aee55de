"""Input shaping: a motion split into a few, so late after each other that their vibrations cancel.

Zero vibration (ZV) and zero vibration and derivative (ZVD) shapers: Singer and Seering, Preshaping command
inputs to reduce system vibration, ASME J. Dynamic Systems, Measurement, and Control 112 (1990).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import reduce

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Shaper:
    """Impulses at some times, s, whose amplitudes add to one."""

    times: NDArray[np.float64]
    amplitudes: NDArray[np.float64]

    def __mul__(self, other: Shaper) -> Shaper:
        """Take out what both take out."""
        times = np.asarray(np.add.outer(self.times, other.times)).ravel()
        amplitudes = np.outer(self.amplitudes, other.amplitudes).ravel()
        order = np.argsort(times, kind="stable")
        return Shaper(np.asarray(times[order]), np.asarray(amplitudes[order], dtype=np.float64))

    def residual(self, frequency: float, damping: float) -> float:
        """Vibration that is left of one mode (Hz, ratio), as part of that without a shaper."""
        w = 2.0 * np.pi * frequency
        decay = self.amplitudes * np.exp(-damping * w * (self.times[-1] - self.times))
        phase = np.exp(1j * w * np.sqrt(1.0 - damping**2) * self.times)
        return float(abs(np.sum(decay * phase)))


def shaper(kind: str, frequency: float, damping: float = 0.0) -> Shaper:
    """A `zv` or `zvd` shaper for one mode: natural frequency, Hz, and damping ratio below one."""
    if kind not in ("zv", "zvd"):
        raise ValueError(f"shaper is {kind!r}; give zv or zvd")
    if not (frequency > 0.0 and 0.0 <= damping < 1.0):
        raise ValueError(f"a mode of {frequency:g} Hz and damping {damping:g}; give > 0 Hz and 0 to below 1")
    root = np.sqrt(1.0 - damping**2)
    k = np.exp(-damping * np.pi / root)
    half = 0.5 / (frequency * root)
    single = Shaper(np.array([0.0, half]), np.array([1.0, k]) / (1.0 + k))
    if kind == "zv":
        return single
    return Shaper(half * np.arange(3), np.array([1.0, 2.0 * k, k * k]) / (1.0 + k) ** 2)


def for_modes(kind: str, modes: Iterable[tuple[float, float]]) -> Shaper:
    """One shaper for several modes (Hz, ratio)."""
    none = Shaper(np.zeros(1), np.ones(1))
    return reduce(lambda found, mode: found * shaper(kind, *mode), modes, none)
