"""Where the nodes of a line lie."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

Array = NDArray[np.float64]


def graded_from_end(length: float, elements: int, first: float, both: bool = False) -> Array:
    """Node positions (elements + 1,) from 0 to `length`, m, finer towards `length`.

    The element at `length` is `first` wide and widths grow from there geometrically; with
    `both`, from both ends towards the middle. Where even elements would be no wider than
    `first`, they are even.
    """
    if elements < 2 or length / elements <= first:
        return np.linspace(0.0, length, elements + 1, dtype=np.float64)
    place = np.arange(elements)[::-1].astype(float)
    if both:
        place = np.minimum(place, place[::-1])
    if place.max() == 0.0:
        return np.linspace(0.0, length, elements + 1, dtype=np.float64)

    def excess(growth: float) -> float:
        return float(first * np.sum(growth**place) / length - 1.0)

    high = 2.0
    while excess(high) < 0.0:
        high *= 2.0
    widths = first * brentq(excess, 1.0, high, xtol=1e-14) ** place
    x = np.concatenate([[0.0], np.cumsum(widths)])
    return np.asarray(x * (length / x[-1]))


def graded_both(length: float, elements: int, ratio: float) -> Array:
    """Node positions (elements + 1,) from 0 to `length`, finer towards both ends.

    The middle elements are `ratio` times as wide as those at the ends.
    """
    if elements < 3 or ratio == 1.0:
        return np.linspace(0.0, length, elements + 1, dtype=np.float64)
    place = np.arange(elements) - 0.5 * (elements - 1)
    widths = ratio ** (1.0 - np.abs(place) / np.abs(place).max())
    x = np.concatenate([[0.0], np.cumsum(widths)])
    return np.asarray(x * (length / x[-1]))
