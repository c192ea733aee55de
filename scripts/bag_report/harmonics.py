"""Vibrations that belong to another one: multiples of its frequency, sums and differences of two.

A motion that is not quite linear in its modes (a tip that goes along an arc moves along the arm by the square
of its deflection) holds them.  They are no modes of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

ORDERS = (2, 3, 4)
NEAR = 0.004  # of a frequency: so near to the multiple
SMALLER = 0.3  # of the vibration that it comes from, at most
PAIR = 0.1  # of the smaller of two


@dataclass(frozen=True)
class Harmonic:
    """A vibration, Hz, of this amplitude that comes from others: what it is, and the frequency expected.

    parts : places of its origins among the vibrations that were asked about, and how often each counts
    """

    frequency: float
    amplitude: float
    of: str
    expected: float
    parts: tuple[tuple[int, int], ...] = ()


def origins(frequency: float, amplitude: float, others: Sequence[tuple[float, float]]) -> list[Harmonic]:
    """Return what a vibration may come from; others are larger ones, (Hz, amplitude)."""
    found = []
    for k, (first, size) in enumerate(others):
        for n in ORDERS:
            if amplitude <= SMALLER * size and abs(frequency - n * first) <= NEAR * frequency:
                found.append(Harmonic(frequency, amplitude, f"{n} x {first:.3g} Hz", n * first, ((k, n),)))
    for k, (first, size) in enumerate(others):
        for j, (second, other) in enumerate(others[:k]):
            for sign, value in (("+", first + second), ("-", abs(first - second))):
                if amplitude <= PAIR * min(size, other) and abs(frequency - value) <= NEAR * frequency:
                    words = f"{max(first, second):.3g} {sign} {min(first, second):.3g} Hz"
                    found.append(Harmonic(frequency, amplitude, words, value, ((k, 1), (j, 1))))
    return found


def harmonics_of(vibrations: Sequence[tuple[float, float]]) -> tuple[Harmonic, ...]:
    """Return which of some vibrations, (Hz, amplitude), come from larger ones."""
    found: list[Harmonic] = []
    own: list[tuple[float, float]] = []
    for frequency, amplitude in sorted(vibrations, key=lambda v: -v[1]):
        known = origins(frequency, amplitude, own)
        if known:
            found.append(min(known, key=lambda h: abs(h.expected - frequency)))
        else:
            own.append((frequency, amplitude))
    return tuple(found)
