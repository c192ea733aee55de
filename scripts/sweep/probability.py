"""Probabilities from counts, with their intervals; what a sample says of a number."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Chance:
    """How often a condition held: of `rows` that ran; `failed` ones said neither.

    lower, upper : the interval, widened to what it would be if each failed row had said one or the other
    """

    held: int
    rows: int
    failed: int
    lower: float
    upper: float

    @property
    def share(self) -> float:
        """The estimate, of the rows that ran."""
        return self.held / self.rows if self.rows else math.nan


def chance(held: int, rows: int, failed: int, confidence: float, interval: str) -> Chance:
    """Estimate a probability; rows : that ran, without the failed ones."""
    bounds = wilson if interval == "wilson" else clopper_pearson
    total = rows + failed
    return Chance(
        held, rows, failed, bounds(held, total, confidence)[0], bounds(held + failed, total, confidence)[1]
    )


def wilson(held: int, rows: int, confidence: float) -> tuple[float, float]:
    """Wilson's score interval (1927): covers at the rate asked for on the average over probabilities."""
    from scipy.special import ndtri

    if rows == 0:
        return 0.0, 1.0
    z = float(ndtri(0.5 + 0.5 * confidence))
    p, spread = held / rows, 1.0 + z * z / rows
    middle = (p + 0.5 * z * z / rows) / spread
    half = z / spread * math.sqrt(p * (1.0 - p) / rows + 0.25 * (z / rows) ** 2)
    return (
        0.0 if held == 0 else max(0.0, middle - half),
        1.0 if held == rows else min(1.0, middle + half),
    )


def clopper_pearson(held: int, rows: int, confidence: float) -> tuple[float, float]:
    """Clopper and Pearson's exact interval (1934): covers at least at the rate asked for."""
    from scipy.special import betaincinv

    tail = 0.5 * (1.0 - confidence)
    low = 0.0 if held == 0 else float(betaincinv(held, rows - held + 1, tail))
    high = 1.0 if held == rows else float(betaincinv(held + 1, rows - held, 1.0 - tail))
    return low, high


def described(values: np.ndarray, confidence: float) -> dict[str, float]:
    """Quantiles of values (K,), K at least 1; of finite ones, from two on, the mean with its interval by
    Student's t, and the deviation.
    """
    from scipy.special import stdtrit

    finite = values[np.isfinite(values)]
    found: dict[str, float] = {"rows": len(values), "infinite": len(values) - len(finite)}
    # Where some are infinite, as the time of what never failed, only order has a meaning.
    found |= {f"p{q}": float(v) for q, v in zip((5, 50, 95), _quantiles(values), strict=True)}
    if len(finite) == len(values) and len(values) > 1:
        mean, sd = float(values.mean()), float(values.std(ddof=1))
        half = float(stdtrit(len(values) - 1, 0.5 + 0.5 * confidence)) * sd / math.sqrt(len(values))
        found |= {"mean": mean, "mean_lower": mean - half, "mean_upper": mean + half, "deviation": sd}
    return found


def _quantiles(values: np.ndarray) -> np.ndarray:
    return np.quantile(values, [0.05, 0.5, 0.95], method="inverted_cdf")
