"""Points at which a study runs: shares in the unit cube, and the values that belong to them."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .inputs import Input, InputError

METHODS = ("grid", "random", "latin_hypercube", "sobol")
MOST_ROWS = 10_000_000
Point = dict[str, Any]


def shares(method: str, count: int, dimension: int, seed: int) -> np.ndarray:
    """Points (count, dimension) in the unit cube, the same for the same seed.

    A Sobol sequence and random points go on where fewer of them ended; a Latin hypercube does not.
    """
    from scipy.stats import qmc

    if method == "random":
        return np.random.default_rng(seed).random((count, dimension))
    if method == "latin_hypercube":
        return qmc.LatinHypercube(dimension, rng=np.random.default_rng(seed)).random(count)
    assert method == "sobol", method
    sampler = qmc.Sobol(dimension, rng=np.random.default_rng(seed))
    power = 1 << max(0, count - 1).bit_length()
    return sampler.random(power)[:count]


def points(inputs: Sequence[Input], at: np.ndarray) -> list[Point]:
    """Values of the inputs at shares (count, inputs)."""
    return [{one.key: one.at(float(u)) for one, u in zip(inputs, row, strict=True)} for row in at]


def grid(inputs: Sequence[Input]) -> list[Point]:
    """Every combination of the inputs' levels, the last input's changing first.

    Raises
    ------
    InputError
        Where an input has no levels, or they are too many.
    """
    each = []
    for one in inputs:
        if one.levels is None:
            raise InputError(
                f"{one.key}: has no levels for a grid; give a list or a count, or another sample: method"
            )
        each.append(one.levels)
    rows = int(np.prod([float(len(levels)) for levels in each]))
    if rows > MOST_ROWS:
        raise InputError(f"the grid has {rows} rows; give fewer levels, at most {MOST_ROWS} rows")
    return [dict(zip([one.key for one in inputs], row, strict=True)) for row in itertools.product(*each)]


def correlated(at: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Shares (count, inputs) whose normal scores have a correlation: a Gaussian copula.

    Each input keeps its own distribution. matrix (inputs, inputs) : of the normal scores, positive definite
    """
    from scipy.special import ndtr, ndtri

    tiny = np.finfo(float).eps
    return ndtr(ndtri(np.clip(at, tiny, 1.0 - tiny)) @ np.linalg.cholesky(matrix).T)


def correlation_matrix(inputs: Sequence[Input], pairs: Mapping[tuple[str, str], float]) -> np.ndarray:
    """The matrix of correlations between inputs.

    Raises
    ------
    InputError
        Where no numbers can be correlated like that.
    """
    names = [one.key for one in inputs]
    matrix = np.eye(len(names))
    for (a, b), value in pairs.items():
        i, j = names.index(a), names.index(b)
        matrix[i, j] = matrix[j, i] = value
    if np.linalg.eigvalsh(matrix)[0] < 1e-9:
        raise InputError("correlation: no numbers can have all these correlations at once; give smaller ones")
    return matrix
