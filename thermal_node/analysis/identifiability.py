"""What a log can tell, before anything is fitted: how its readings move with the parameters.

A direction in which all parameters may change together without moving the readings is one that no fit finds.
The directions are those of the information matrix J'J / sigma^2 of the logarithms, with the priors' own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from ..heat.conduction import Array

READING_ERROR = 2.5
"""K, standard deviation of a reading: type K of class 2 by EN 60584-1 is within 2.5 K to 333 °C."""
ALIKE = 0.9
"""Correlation of a thermocouple's neighbouring readings: what is off at one moment is off at the next."""
STEP = 0.02
"""Change of a parameter's logarithm by which the readings' sensitivity is taken."""
UNCERTAIN = 0.5
"""Relative standard error from which on a parameter, or some of them together, is called undetermined."""
SMALL = 0.2
"""Share of the largest change below which a parameter is left out of a direction's words."""


@dataclass(frozen=True)
class Held:
    """Something that is taken as the scene has it.

    name, value, unit : in words
    moved : K, the most that any reading moves with 10 % of it; None where it is no number that can be changed
    """

    name: str
    value: str
    unit: str
    moved: float | None = None

    @property
    def seen(self) -> bool:
        """Whether 10 % of it move a reading by more than a thermocouple's error."""
        return self.moved is not None and self.moved > READING_ERROR


@dataclass(frozen=True)
class Foreseen:
    """What a log can tell of p parameters.

    error (p,) : relative standard error at best, infinite where nothing moves
    spread (p,) : of the independent directions, relative, the best known first
    directions (p, p) : each column how the logarithms change along one
    rank : directions that the log determines; condition : of the sensitivities
    moved (p,) : K, the most that any reading moves with 10 % of each parameter
    notes : what can't be told, in words
    held : what is not fitted but taken as the scene has it, the most seen first
    """

    error: Array
    spread: Array
    directions: Array
    rank: int
    condition: float
    moved: Array
    notes: tuple[str, ...]
    held: tuple[Held, ...] = ()


def foresee(
    residual: Callable[[Array], Array], start: Array, highest: Array, names: Sequence[str], prior: Array
) -> Foreseen:
    """What the readings tell of the parameters around `start`.

    residual : model less readings, K, of the parameters' logarithms
    start, highest (p,) : logarithms of the scene's values, and the most they may be
    prior (p,) : information of the priors on the logarithms, 1 / (relative standard deviation)^2
    """
    base = residual(start)
    columns = []
    for k in range(len(start)):
        moved = start.copy()
        moved[k] += STEP if start[k] + STEP <= highest[k] else -STEP
        columns.append((residual(moved) - base) / (moved[k] - start[k]))
    sensitivity = np.array(columns).T
    noise = READING_ERROR**2 * (1.0 + ALIKE) / (1.0 - ALIKE)
    information = sensitivity.T @ sensitivity / noise + np.diag(prior)
    value, vector = np.linalg.eigh(information)
    value, vector = np.maximum(value[::-1], 1e-30), vector[:, ::-1]
    spread = 1.0 / np.sqrt(value)
    error = np.sqrt((vector**2 / value).sum(axis=1))
    loose = np.flatnonzero(spread > UNCERTAIN)
    return Foreseen(
        error=error,
        spread=spread,
        directions=vector,
        rank=len(start) - len(loose),
        condition=float(np.sqrt(value[0] / value[-1])),
        moved=0.1 * np.abs(sensitivity).max(axis=0, initial=0.0),
        notes=tuple(_words(sensitivity, vector[:, k], names) for k in loose),
    )


def _words(sensitivity: Array, direction: Array, names: Sequence[str]) -> str:
    """Which change of the parameters no reading tells, in words."""
    share = direction / direction[np.argmax(np.abs(direction))]
    share = np.where(np.abs(share) < SMALL, 0.0, share)
    most = float(np.abs(sensitivity @ (0.1 * share)).max(initial=0.0))
    order = np.argsort(-np.abs(share))
    parts = [f"{names[k]} by {10.0 * share[k]:+.0f} %" for k in order if share[k] != 0.0]
    if len(parts) == 1:
        return f"the log can't tell {names[order[0]]}: 10 % of it move no reading by more than {most:.2g} K"
    return (
        f"the log can't tell {' from '.join(names[k] for k in order if share[k] != 0.0)}: to change"
        f" {' and '.join(parts)} moves no reading by more than {most:.2g} K; give one of them a prior, or"
        " keep it"
    )
