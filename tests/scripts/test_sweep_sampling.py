"""Samples of what varies are what they claim to be."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flexsim.sweep.inputs import Input, InputError, read_input
from flexsim.sweep.sampling import correlated, correlation_matrix, grid, points, shares
from scipy import stats


@pytest.mark.parametrize("count", [1, 7, 64])
def test_a_latin_hypercube_has_one_point_in_each_stratum(count: int) -> None:
    at = shares("latin_hypercube", count, 5, seed=3)
    for column in at.T:
        assert sorted((column * count).astype(int)) == list(range(count))


def test_a_sobol_sequence_fills_every_box() -> None:
    """64 points in two dimensions: one in each of 8 x 8, of 4 x 16 and of 64 x 1 boxes."""
    at = shares("sobol", 64, 2, seed=5)
    for across in (1, 2, 4, 8, 16, 32, 64):
        boxes = {(int(x * across), int(y * (64 // across))) for x, y in at}
        assert len(boxes) == 64


@pytest.mark.parametrize("method", ["random", "latin_hypercube", "sobol"])
def test_the_same_seed_gives_the_same_points(method: str) -> None:
    one = shares(method, 20, 3, seed=1)
    np.testing.assert_array_equal(one, shares(method, 20, 3, seed=1))
    assert not np.array_equal(one, shares(method, 20, 3, seed=2))
    assert one.shape == (20, 3) and (one >= 0.0).all() and (one < 1.0).all()


@pytest.mark.parametrize("method", ["random", "sobol"])
def test_a_greater_count_goes_on(method: str) -> None:
    """What was run of fewer points is not run again."""
    np.testing.assert_array_equal(shares(method, 50, 3, seed=1)[:20], shares(method, 20, 3, seed=1))


@pytest.mark.parametrize(
    ("given", "exact"),
    [
        ({"normal": [3.0, 0.5]}, stats.norm(3.0, 0.5)),
        ({"normal": [3.0, 0.5], "within": [2.0, 3.2]}, stats.truncnorm(-2.0, 0.4, 3.0, 0.5)),
        ({"normal": [0.0, 1.0], "within": [4.0, 5.0]}, stats.truncnorm(4.0, 5.0)),
        ({"lognormal": [2.0, 1.5]}, stats.lognorm(math.log(1.5), scale=2.0)),
        ({"uniform": [-1.0, 3.0]}, stats.uniform(-1.0, 4.0)),
    ],
)
def test_distributions_have_their_quantiles(given: dict, exact: object) -> None:
    made = read_input("key", given)
    for share in (0.001, 0.3, 0.5, 0.9, 0.999):
        assert made.at(share) == pytest.approx(exact.ppf(share), rel=1e-9)  # type: ignore[attr-defined]


def test_a_truncated_lognormal_stays_within() -> None:
    made = read_input("key", {"lognormal": [2.0, 1.5], "within": [1.5, 2.5]})
    values = np.array([made.at(u) for u in np.linspace(1e-12, 1 - 1e-12, 101)])
    assert values.min() >= 1.5 and values.max() <= 2.5
    exact = stats.lognorm(math.log(1.5), scale=2.0)
    assert made.at(0.5) == pytest.approx(exact.ppf(0.5 * (exact.cdf(1.5) + exact.cdf(2.5))))


@pytest.mark.parametrize("given", [{"normal": [3.0, 0.5]}, {"lognormal": [2.0, 1.5]}])
def test_a_sample_s_ends_are_numbers(given: dict) -> None:
    """A sequence may begin at 0, where a normal value is infinite."""
    made = read_input("key", given)
    assert math.isfinite(made.at(0.0)) and math.isfinite(made.at(1.0))


def test_levels_meet_both_ends() -> None:
    made = read_input("key", {"from": 0.1, "to": 0.7, "count": 3})
    assert made.levels == (0.1, 0.4, 0.7)
    made = read_input("key", {"from": 0.1, "to": 1000.0, "count": 5, "spacing": "log"})
    assert made.levels is not None and (made.levels[0], made.levels[-1]) == (0.1, 1000.0)
    np.testing.assert_allclose(made.levels, [0.1, 1.0, 10.0, 100.0, 1000.0])


def test_a_grid_has_every_combination() -> None:
    found = grid([read_input("a", [1, 2]), read_input("b", ["x", "y", "z"])])
    assert [tuple(point.values()) for point in found] == [(a, b) for a in (1, 2) for b in "xyz"]


def test_a_list_is_sampled_evenly() -> None:
    made = read_input("a", ["x", "y", "z"])
    values = [point["a"] for point in points([made], shares("latin_hypercube", 30, 1, seed=1))]
    assert {v: values.count(v) for v in "xyz"} == {"x": 10, "y": 10, "z": 10}


def test_correlated_inputs_keep_their_distributions() -> None:
    inputs = [read_input("a", {"normal": [5.0, 2.0]}), read_input("b", {"uniform": [0.0, 1.0]})]
    matrix = correlation_matrix(inputs, {("a", "b"): -0.7})
    at = correlated(shares("random", 20_000, 2, seed=1), matrix)
    scores = stats.norm.ppf(at)
    assert np.corrcoef(scores.T)[0, 1] == pytest.approx(-0.7, abs=0.015)
    for column in at.T:  # Kolmogorov and Smirnov at 1 in 1000
        assert stats.kstest(column, "uniform").pvalue > 1e-3


def test_impossible_correlations_are_refused() -> None:
    inputs = [Input(key, "normal") for key in "abc"]
    with pytest.raises(InputError, match="no numbers can have all these"):
        correlation_matrix(inputs, {("a", "b"): 0.9, ("b", "c"): 0.9, ("a", "c"): -0.9})


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ([], "is an empty list"),
        (3.0, "is 3.0; give a list"),
        ({}, "give a list"),
        ({"from": 1.0}, "only one of from and to"),
        ({"from": 2.0, "to": 1.0}, "2 is not below 1"),
        ({"from": 0.0, "to": 1.0, "spacing": "log"}, "a from above 0"),
        ({"from": 0.0, "to": 1.0, "spacing": "cubic"}, "give linear or log"),
        ({"from": 0.0, "to": 1.0, "count": 0}, "count is 0"),
        ({"from": 0.0, "to": 1.0, "count": 2.5}, "count is 2.5"),
        ({"from": 0.0, "to": float("inf")}, "give two numbers"),
        ({"normal": [1.0, 0.0]}, "deviation is 0"),
        ({"normal": 1.0}, "normal is 1.0; give two numbers"),
        ({"normal": [1.0, 0.1], "uniform": [0.0, 1.0]}, "a distribution"),
        ({"normal": [1.0, 0.1], "form": 1.0}, "'form' is not known beside normal"),
        ({"normal": [0.0, 1.0], "within": [40.0, 41.0]}, "next to none of the distribution"),
        ({"lognormal": [1.0, 0.9]}, "a factor above 1"),
        ({"uniform": [0.0, 1.0], "within": [0.0, 1.0]}, "leave out within"),
        ({"scale": [1.0, "x"]}, "scale takes numbers"),
        ({"scale": [1.0], "from": 1.0}, "alone"),
    ],
)
def test_what_cant_vary_like_that(given: object, sentence: str) -> None:
    with pytest.raises(InputError, match=r"^[^\n]*$") as refused:
        read_input("key", given)
    assert sentence in str(refused.value)
