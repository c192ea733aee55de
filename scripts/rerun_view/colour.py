"""Colours of the views: one look for all."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .palette import SERIES

# Turbo-like would shout; this runs from calm blue over sand to red, and is even in lightness.
SCALE = np.array(
    [[76, 120, 168], [122, 165, 196], [222, 206, 170], [242, 160, 88], [214, 69, 60]], dtype=float
)
GHOST = (190, 196, 206, 110)
NODE = (245, 245, 245)
TRACE = (242, 160, 88, 200)


def along_scale(fraction: NDArray[np.floating]) -> NDArray[np.uint32]:
    """Return packed RGBA for values from 0 (calm) to 1 (most)."""
    at = np.clip(fraction, 0.0, 1.0) * (len(SCALE) - 1)
    stops = np.arange(len(SCALE))
    packed = np.full(at.shape, 255, dtype=np.uint32)
    for channel, shift in enumerate((24, 16, 8)):
        packed |= np.interp(at, stops, SCALE[:, channel]).astype(np.uint32) << np.uint32(shift)
    return packed


def series(count: int) -> list[tuple[int, int, int]]:
    """Return a colour for each of `count` series of a plot."""
    return [SERIES[i % len(SERIES)] for i in range(count)]
