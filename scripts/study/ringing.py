"""The strongest vibration in a ringing signal: its frequency and its decay, by the matrix pencil.

Hua and Sarkar 1990, IEEE Trans. Acoust. Speech Signal Process. 38, 814-824.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

POLES = 8


def ringing(signal: NDArray[np.float64], period: float, near: float | None = None) -> tuple[float, float]:
    """Frequency (Hz) and decay rate (1/s) of the strongest vibration, or of that nearest to `near` Hz.

    signal (K, d) : samples `period` s apart of a free vibration; d directions ring together

    Raises
    ------
    ValueError
        where nothing rings
    """
    centred = signal - signal.mean(axis=0)
    _u, _s, right = np.linalg.svd(centred, full_matrices=False)
    line = centred @ right[0]
    rows = len(line) // 3
    hankel = np.lib.stride_tricks.sliding_window_view(line, rows).T
    u, s, _v = np.linalg.svd(hankel, full_matrices=False)
    poles = min(POLES, int(np.sum(s > 1e-9 * s[0])))
    u = u[:, :poles]
    roots = np.linalg.eigvals(np.linalg.lstsq(u[:-1], u[1:], rcond=None)[0])
    roots = roots[np.abs(roots) > 1e-12].astype(complex)
    exponents = np.log(roots) / period
    frequency = np.abs(exponents.imag) / (2.0 * np.pi)
    parts = roots[None, :] ** np.arange(len(line))[:, None]
    amplitude = np.abs(np.linalg.lstsq(parts, line.astype(complex), rcond=None)[0])
    rings = frequency > 1.0 / (period * len(line))
    if not rings.any():
        raise ValueError("nothing rings")
    # Poles of next to no amplitude lie anywhere, also beside the one that is meant.
    far = 0.0 if near is None else (frequency - near) / (0.05 * near)
    score = amplitude / (1.0 + far * far)
    best = int(np.argmax(np.where(rings, score, -np.inf)))
    return float(frequency[best]), float(-exponents[best].real)
