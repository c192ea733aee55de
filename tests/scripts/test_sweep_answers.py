"""Indices, probabilities, fronts and searches against functions whose answers are known."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from flexsim.sweep.answer import answered
from flexsim.sweep.expression import ExpressionError
from flexsim.sweep.inputs import read_input
from flexsim.sweep.pareto import front
from flexsim.sweep.probability import chance, clopper_pearson, described, wilson
from flexsim.sweep.search import SearchError
from flexsim.sweep.sensitivity import morris_effects, morris_shares, saltelli_shares, sobol_indices
from flexsim.sweep.study_file import Study
from flexsim.sweep.table import Row
from flexsim.sweep.words import tables
from scipy import stats

PI = math.pi
Function = Callable[..., Any]


def ask(
    function: Function, vary: dict[str, Any], what: str, method: str = "sobol", count: int = 64,
    seed: int = 1, **options: Any,
) -> dict[str, Any]:  # fmt: skip
    """Ask a study of a function of x, y, ...; None is a failed row."""
    inputs = tuple(read_input(key, given) for key, given in vary.items())
    study = Study(
        "s", Path("s"), "robot", {}, 1.0, 1.0, inputs, {}, method, count, seed, {"f": "f"}, what, options
    )

    def rows(points: Sequence[dict[str, Any]]) -> list[Row | None]:
        made: list[Row | None] = []
        for n, point in enumerate(points):
            value = function(*point.values())
            made.append(
                Row(str(n), point, None if value is None else {"f": value}, "" if value else "no value")
            )
        return made

    return answered(study, rows).found


# Sobol

ANGLES = {name: {"uniform": [-PI, PI]} for name in "xyz"}
SHARE = {"x": 0.3139, "y": 0.4424, "z": 0.0}
TOTAL = {"x": 0.5576, "y": 0.4424, "z": 0.2437}


def ishigami(x: float, y: float, z: float) -> float:
    """a = 7, b = 0.1: Ishigami and Homma (1990)."""
    return math.sin(x) + 7.0 * math.sin(y) ** 2 + 0.1 * z**4 * math.sin(x)


def test_ishigami_s_exact_indices_are_within_the_intervals() -> None:
    """a = 7, b = 0.1: variance 1/2 + a^2/8 + b pi^4/5 + b^2 pi^8/18."""
    variance = 0.5 + 49.0 / 8.0 + 0.1 * PI**4 / 5.0 + 0.01 * PI**8 / 18.0
    first = {"x": 0.5 * (1.0 + 0.1 * PI**4 / 5.0) ** 2, "y": 49.0 / 8.0, "z": 0.0}
    crossed = 0.01 * PI**8 * (1.0 / 18.0 - 1.0 / 50.0)
    found = ask(ishigami, ANGLES, "sobol", count=2048, confidence=0.99)["indices"]["f"]
    assert found["left_out"] == 0
    for key, index in found["inputs"].items():
        total = first[key] + (crossed if key != "y" else 0.0)
        for exact, (value, lower, upper) in ((first[key], index["first"]), (total, index["total"])):
            assert lower <= exact / variance <= upper
            assert lower <= value <= upper
            assert upper - lower < 0.2
    assert first["x"] / variance == pytest.approx(SHARE["x"], abs=1e-4)


def test_the_intervals_hold_the_exact_indices_at_their_rate() -> None:
    """95 % intervals from 60 random designs: at least 50 of 60 for each index (binomial, 1 in 1000)."""
    held = np.zeros((3, 2), int)
    for seed in range(60):
        at = saltelli_shares("random", 256, 3, seed)
        x, y, z = np.moveaxis(PI * (2.0 * at - 1.0), 2, 0)
        values = np.sin(x) + 7.0 * np.sin(y) ** 2 + 0.1 * z**4 * np.sin(x)
        for i, index in enumerate(sobol_indices(values, 0.95, 200, seed)):
            key = "xyz"[i]
            held[i] += [
                index.first[1] <= SHARE[key] <= index.first[2],
                index.total[1] <= TOTAL[key] <= index.total[2],
            ]
    least = int(stats.binom(60, 0.95).ppf(1e-3))
    assert (held >= least).all(), held


def test_indices_are_those_of_scipy() -> None:
    """The same estimators, to rounding."""
    at = saltelli_shares("sobol", 256, 3, 2)
    values = np.apply_along_axis(lambda u: ishigami(*(PI * (2.0 * u - 1.0))), 2, at)
    theirs = stats.sobol_indices(
        func={"f_A": values[None, :, 0], "f_B": values[None, :, 1], "f_AB": values.T[2:, None, :]}, n=256
    )
    ours = sobol_indices(values, 0.95, 50, 1)
    np.testing.assert_allclose([i.first[0] for i in ours], theirs.first_order.ravel(), rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose([i.total[0] for i in ours], theirs.total_order.ravel(), rtol=1e-10, atol=1e-12)


def test_a_failed_row_costs_its_sample_and_is_said() -> None:
    found = ask(
        lambda x, y: None if x > 0.9 else x + 2.0 * y, {k: {"from": 0.0, "to": 1.0} for k in "xy"}, "sobol"
    )
    assert found["indices"]["f"]["left_out"] > 0
    found = ask(lambda x: 3.0, {"x": {"from": 0.0, "to": 1.0}}, "sobol")
    assert found["indices"]["f"] == {"problem": "does not change with any input"}


def test_words_have_no_indices() -> None:
    """They would seem to be failed rows."""
    for what in ("sobol", "morris"):
        found = ask(lambda x: "A-60", {"x": {"from": 0.0, "to": 1.0}}, what)
        (said,) = found["indices" if what == "sobol" else "effects"].values()
        assert "is a word, not a number" in said["problem"]


# Morris


def test_morris_effects_of_a_plane_are_its_slopes() -> None:
    """Exactly, without any unevenness; over the inputs' whole ranges."""
    vary = {"x": {"from": 0.0, "to": 2.0}, "y": {"from": -1.0, "to": 1.0}, "z": {"from": 0.0, "to": 1.0}}
    found = ask(lambda x, y, z: 3.0 * x - y + 0.0 * z, vary, "morris", trajectories=5)["effects"]["f"][
        "inputs"
    ]
    for key, slope in (("x", 6.0), ("y", -2.0), ("z", 0.0)):
        effect = found[key]
        assert effect["mu"] == pytest.approx(slope, abs=1e-12)
        assert effect["mu_star"] == pytest.approx(abs(slope), abs=1e-12)
        assert effect["sigma"] == pytest.approx(0.0, abs=1e-12)


def test_morris_sees_that_inputs_work_together() -> None:
    vary = {key: {"from": -1.0, "to": 1.0} for key in "xyz"}
    found = ask(lambda x, y, z: x * y + 0.1 * z, vary, "morris", trajectories=40)["effects"]["f"]["inputs"]
    assert found["x"]["sigma"] > 5.0 * found["z"]["mu_star"] * 0.5
    assert abs(found["x"]["mu"]) < found["x"]["mu_star"]
    assert found["z"]["sigma"] < 1e-12


def test_morris_changes_one_input_at_a_time() -> None:
    at = morris_shares(30, 4, 6, seed=2)
    steps = np.diff(at, axis=1)
    assert ((steps != 0.0).sum(axis=2) == 1).all()
    np.testing.assert_allclose(np.abs(steps).max(axis=2), 0.5)
    assert (steps != 0.0).any(axis=1).all()
    assert at.min() > 0.0 and at.max() < 1.0
    with pytest.raises(ValueError, match="fewer than two"):
        morris_effects(at, np.full((30, 5), np.nan))


# Monte Carlo


@pytest.mark.parametrize(
    ("interval", "truth"), [("clopper_pearson", 0.03), ("wilson", 0.3), ("clopper_pearson", 0.8)]
)
def test_a_monte_carlo_s_interval_covers_the_truth_at_its_rate(interval: str, truth: float) -> None:
    """200 studies of 60 rows each, at 90 %: as many as a binomial of 200 has at least, 1 in 1000."""
    covered = 0
    for seed in range(200):
        vary = {"x": {"uniform": [0.0, 1.0]}}
        found = ask(
            lambda x: x < truth, vary, "monte_carlo", "random", 60, seed, confidence=0.9, interval=interval
        )
        one = found["probabilities"]["f"]
        covered += one["lower"] <= truth <= one["upper"]
    assert covered >= stats.binom(200, 0.9).ppf(1e-3)
    if interval == "wilson":  # it is not wide of the rate either
        assert covered <= stats.binom(200, 0.9).ppf(1.0 - 1e-3)


def test_intervals_are_those_of_scipy() -> None:
    for held, rows in ((0, 10), (3, 10), (10, 10), (57, 1000)):
        for name, bounds in (("exact", clopper_pearson), ("wilson", wilson)):
            theirs = stats.binomtest(held, rows).proportion_ci(0.95, name)
            assert bounds(held, rows, 0.95) == pytest.approx((theirs.low, theirs.high), abs=1e-12)
    assert wilson(0, 0, 0.95) == clopper_pearson(0, 0, 0.95) == (0.0, 1.0)


def test_failed_rows_widen_the_interval() -> None:
    """They might have been either; leaving them out would be surer than is known."""
    made = chance(8, 10, 5, 0.95, "clopper_pearson")
    assert made.share == 0.8
    assert made.lower == clopper_pearson(8, 15, 0.95)[0]
    assert made.upper == clopper_pearson(13, 15, 0.95)[1]


def test_a_mean_s_interval_covers_at_its_rate() -> None:
    rng = np.random.default_rng(1)
    each = [described(rng.normal(3.0, 2.0, 12), 0.9) for _ in range(200)]
    covered = sum(d["mean_lower"] <= 3.0 <= d["mean_upper"] for d in each)
    assert stats.binom(200, 0.9).ppf(1e-3) <= covered <= stats.binom(200, 0.9).ppf(1.0 - 1e-3)


def test_times_that_never_come_have_no_mean() -> None:
    found = described(np.array([1.0, math.inf, 3.0, math.inf]), 0.95)
    assert "mean" not in found and found["infinite"] == 2 and found["p5"] == 1.0 and found["p95"] == math.inf


def test_what_is_asked_is_answered_where_nothing_ran() -> None:
    """Or one row alone did: a name that is left out would seem not to have been asked."""
    vary = {"x": {"uniform": [0.0, 1.0]}}
    found = ask(lambda x: None, vary, "monte_carlo", "random", 5)
    assert found["numbers"] == {"f": {"rows": 0}} and found["failed"] == 5
    one = ask(lambda x: 1.0 + x, vary, "monte_carlo", "random", 1)["numbers"]["f"]
    assert one["rows"] == 1 and one["p5"] == one["p95"] and "mean" not in one
    for said in (found, ask(lambda x: 1.0 + x, vary, "monte_carlo", "random", 1)):
        ((title, _, rows),) = tables(SimpleNamespace(ask="monte_carlo", method="random"), said)  # type: ignore[arg-type]
        assert rows[0][0] == "f" and rows[0][2] in ("every row failed", "one row")
        assert ("5 failed rows" in title) is (said is found)


# Fronts


def test_a_front_is_what_no_row_beats() -> None:
    """Against the definition, row by row; ties and NaN among them."""
    rng = np.random.default_rng(3)
    aims = rng.integers(0, 6, (80, 3)).astype(float)
    aims[5, 1] = math.nan
    beaten = [
        math.isnan(a.sum()) or any((b <= a).all() and (b < a).any() for b in aims if not math.isnan(b.sum()))
        for a in aims
    ]
    assert front(aims).tolist() == [n for n, is_beaten in enumerate(beaten) if not is_beaten]
    assert front(np.empty((0, 2))).tolist() == []


def test_a_study_s_front() -> None:
    vary = {"x": {"from": -1.0, "to": 2.0, "count": 31}}
    found = ask(
        lambda x: (x - 1.0) ** 2, vary, "pareto", "grid", minimise=["f", "x"], so_that="input('x') >= 0"
    )
    assert [one["inputs"]["x"] for one in found["front"]] == pytest.approx(
        np.arange(10, -1, -1) / 10.0, abs=1e-12
    )
    assert found["broken"] == 10


def test_a_front_s_condition_is_one() -> None:
    """A number would be broken by every row."""
    vary = {"x": {"from": -1.0, "to": 2.0, "count": 5}}
    with pytest.raises(ExpressionError, match="join conditions"):
        ask(lambda x: 1.0 + x, vary, "pareto", "grid", minimise=["f", "x"], so_that="f")


# Searches


def test_bisection_finds_the_edge() -> None:
    found = ask(lambda x: x**3, {"x": {"from": 0.0, "to": 4.0}}, "search", minimise="x", so_that="f >= 2",
                tolerance=1e-9)  # fmt: skip
    assert 2.0 ** (1 / 3) <= found["found"]["x"] <= 2.0 ** (1 / 3) + 1e-9
    assert found["method"] == "bisection"
    mirrored = ask(lambda x: x**3, {"x": {"from": 0.0, "to": 4.0}}, "search", maximise="input('x') * 2",
                   so_that="f <= 2", tolerance=1e-9)  # fmt: skip
    assert mirrored["aim"] == pytest.approx(2.0 * 2.0 ** (1 / 3), abs=2e-9)
    assert mirrored["found"]["x"] ** 3 <= 2.0


def test_bisection_says_where_there_is_no_edge() -> None:
    vary = {"x": {"from": 0.0, "to": 4.0}}
    found = ask(lambda x: x, vary, "search", minimise="x", so_that="f >= 5")
    assert found["found"] is None and "holds at neither end of 0 to 4" in found["how"]
    found = ask(lambda x: x, vary, "search", minimise="x", so_that="f >= -1")
    assert found["found"] == {"x": 0.0} and "already" in found["how"]
    with pytest.raises(SearchError, match="failed, and bisection needs it: no value"):
        ask(lambda x: None if 1.0 < x < 3.0 else x, vary, "search", minimise="x", so_that="f >= 3.5")
    with pytest.raises(SearchError, match="aim is not between"):
        ask(lambda x: x, vary, "search", minimise="(input('x') - 2.1) ** 2", so_that="f >= 3.5")


def test_evolution_finds_a_constrained_minimum_whatever_fails() -> None:
    """x^2 + y^2 where x + y >= 1, near x = 0.9 no runs: 0.5 at (0.5, 0.5)."""
    vary = {"x": {"from": -2.0, "to": 2.0}, "y": {"from": -2.0, "to": 2.0}}
    found = ask(
        lambda x, y: None if abs(x - 0.9) < 0.1 else x**2 + y**2, vary, "search", minimise="f",
        so_that="input('x') + input('y') >= 1", evaluations=2000,
    )  # fmt: skip
    assert found["aim"] == pytest.approx(0.5, abs=0.01)
    assert found["found"]["x"] + found["found"]["y"] >= 1.0
    assert found["designs"] <= 2000


def test_evolution_goes_to_what_never_ends() -> None:
    """Of times before a failure none is better than that of what does not fail."""
    vary = {"x": {"from": 0.0, "to": 1.0}}
    found = ask(lambda x: math.inf if x > 0.8 else 1.0 - x, vary, "search", maximise="f", evaluations=200)
    assert found["aim"] == math.inf
    assert "until they agreed" in found["how"]


def test_a_search_uses_what_it_is_told() -> None:
    """What would be ignored is refused."""
    vary = {"x": {"from": 0.0, "to": 4.0}}
    with pytest.raises(SearchError, match="tolerance is for bisection, and this search is evolution"):
        ask(lambda x: 1.0 + x, vary, "search", minimise="f", tolerance=0.1)
    with pytest.raises(SearchError, match="evaluations is for evolution, and this search is bisection"):
        ask(lambda x: 1.0 + x, vary, "search", minimise="x", so_that="f > 2", evaluations=100)
    with pytest.raises(SearchError, match="give 20 or more"):
        ask(lambda x: 1.0 + x, vary, "search", minimise="f", evaluations=10)


def test_a_search_says_that_its_rows_failed() -> None:
    """Not that a condition breaks, where there is none."""
    found = ask(lambda x: None, {"x": [1, 2]}, "search", "grid", minimise="f")
    assert found["found"] is None
    assert found["how"] == "no design ran to its end of 2 designs; 2 with rows that failed, such as: no value"


def test_every_level_is_tried_where_there_are_levels() -> None:
    vary = {"x": [3, 1, 2], "y": {"from": 0.0, "to": 1.0, "count": 2}}
    found = ask(lambda x, y: x + y, vary, "search", "grid", minimise="f", so_that="f > 1.5")
    assert (found["method"], found["designs"], found["found"]) == ("all", 6, {"x": 1, "y": 1.0})


def test_a_probability_is_met_over_one_sample() -> None:
    """x at which x + u > 1 with 90 %, u uniform on 0..1: 0.9 of the sample, stratified in 200."""
    vary = {"x": {"from": 0.0, "to": 2.0}, "u": {"uniform": [0.0, 1.0]}}
    found = ask(lambda x, u: x + u, vary, "search", "latin_hypercube", 200, minimise="x", so_that="f > 1",
                probability=0.9, tolerance=1e-6)  # fmt: skip
    assert found["found"]["x"] == pytest.approx(0.9, abs=1.0 / 200.0)
    assert found["probability"]["share"] >= 0.9 > found["probability"]["lower"]
    assert found["probability"]["rows"] == 200
