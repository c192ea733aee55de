"""Arrays that begin with a cache line: vectors of their rows then lie in one line and not across two."""

from __future__ import annotations

from typing import Any

import numpy as np

LINE = 64  # bytes


def zeros(shape: int | tuple[int, ...], dtype: Any = np.float64) -> np.ndarray:
    """Zeros of this shape."""
    size = int(np.prod(shape)) * np.dtype(dtype).itemsize
    room = np.zeros(size + LINE, dtype=np.uint8)
    begin = -room.ctypes.data % LINE
    return room[begin : begin + size].view(dtype).reshape(shape)


def aligned(array: np.ndarray) -> np.ndarray:
    """A copy of an array."""
    copy = zeros(array.shape, array.dtype)
    copy[...] = array
    return copy
