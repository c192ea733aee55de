"""The best values of some keys under a condition: bisection, every level, or differential evolution.

Bisection takes the condition to be monotonic in its one key; it says so with its answer. Distributions among
what varies are uncertain: every design is then run for the same sample of them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .aim import aim, number_of, seen
from .expression import Undefined
from .inputs import Input
from .probability import wilson
from .sampling import correlated, correlation_matrix, grid, points, shares
from .study_file import Study
from .table import Row

Point = dict[str, Any]
BROKEN = 1e100
"""Aim of a design that breaks the condition, and more the more it does; beyond any that holds."""
POPULATION = 10
"""Designs of a generation, a key that is chosen."""
USED_BY = {"tolerance": "bisection", "evaluations": "evolution", "seed": "evolution"}
STEPS = 200


class SearchError(RuntimeError):
    """A search that can't go on: why, and what to do."""


@dataclass(frozen=True)
class Design:
    """Values of what is chosen, and how good they are.

    aim : to be minimised; broken : by how much the condition is, 0 where it holds
    share : of the sample for which it holds, where something is uncertain; reason : why a run failed
    """

    point: Point
    aim: float
    broken: float
    share: float | None = None
    reason: str = ""

    @property
    def energy(self) -> float:
        """One number that ranks designs."""
        return self.aim if self.broken == 0.0 else BROKEN * (1.0 + min(self.broken, 1e50))


class Search:
    """A search of a study; rows : runs points."""

    def __init__(self, study: Study, rows: Callable[[Sequence[Point]], list[Row | None]]) -> None:
        self._study, self._rows, options = study, rows, study.options
        self.chosen = tuple(one for one in study.vary if not one.random)
        self.uncertain = tuple(one for one in study.vary if one.random)
        observed = frozenset(study.observe)
        self.sign = 1.0 if "minimise" in options else -1.0
        self._aim = aim(options.get("minimise", options.get("maximise")), observed, study.vary)
        condition = options.get("so_that")
        self._condition = None if condition is None else aim(condition, observed, study.vary)
        self._probability = options.get("probability")
        self.designs: list[Design] = []
        if not self.chosen:
            raise SearchError("nothing that varies can be chosen; give a key with from and to, or a list")
        if self.uncertain and self._probability is None and condition is not None:
            raise SearchError(
                f"{self.uncertain[0].key} has a distribution: give probability, for which so_that must hold"
            )
        if not self.uncertain and self._probability is not None:
            raise SearchError("probability needs something uncertain; give a key with a distribution")
        self.method = options.get("method") or self._method()
        for key, method in USED_BY.items():
            if key in options and self.method != method:
                raise SearchError(f"{key} is for {method}, and this search is {self.method}; leave it out")
        self._evaluations = options.get("evaluations", 300 * len(self.chosen))
        least = 2 * POPULATION * len(self.chosen)
        if self._evaluations < least:
            raise SearchError(
                f"evaluations is {self._evaluations}, too few for two generations; give {least} or more"
            )
        self._sample: list[Point] = [{}]
        if self.uncertain:
            method = "latin_hypercube" if study.method == "grid" else study.method
            at = shares(method, study.count, len(self.uncertain), study.seed)
            if study.correlation:
                at = correlated(at, correlation_matrix(self.uncertain, study.correlation))
            self._sample = points(self.uncertain, at)

    def found(self) -> dict[str, Any]:
        """Search, and return what was found.

        Raises
        ------
        SearchError
        """
        ways = {"bisection": self._bisect, "all": self._all, "evolution": self._evolve}
        best, words = ways[self.method]()
        found: dict[str, Any] = {"method": self.method, "designs": len(self.designs), "how": words,
                                 "found": None}  # fmt: skip
        if best is None or best.broken:
            return found
        found["found"] = best.point
        found["aim"] = self.sign * best.aim
        if best.share is not None:
            held = round(best.share * len(self._sample))
            lower, upper = wilson(held, len(self._sample), 0.95)
            found["probability"] = {"share": best.share, "lower": lower, "upper": upper,
                                    "rows": len(self._sample)}  # fmt: skip
        return found

    def _method(self) -> str:
        if all(one.levels is not None for one in self.chosen):
            return "all"
        one_key = len(self.chosen) == 1 and self.chosen[0].continuous
        return "bisection" if one_key and self._condition is not None else "evolution"

    def _judged(self, chosen: Sequence[Point]) -> list[Design]:
        every = [{**point, **other} for point in chosen for other in self._sample]
        rows = self._rows(every)
        size = len(self._sample)
        made = [
            self._design(point, every[n * size : (n + 1) * size], rows[n * size : (n + 1) * size])
            for n, point in enumerate(chosen)
        ]
        self.designs += made
        return made

    def _design(self, point: Point, every: list[Point], rows: list[Row | None]) -> Design:
        aims, broken, reason = [], [], ""
        for at, row in zip(every, rows, strict=True):
            assert row is not None, "a search has no parts"
            if row.observed is None:
                broken.append(math.inf)
                reason = reason or row.reason
                continue
            names = seen(at, row.observed)
            try:
                aims.append(self.sign * number_of(self._aim, names))
                broken.append(0.0 if self._condition is None else self._condition.excess(names))
            except Undefined as problem:
                broken.append(math.inf)
                reason = reason or str(problem)
        mean = float(np.mean(aims)) if aims else math.inf
        if math.isnan(mean):  # of endless times of both signs
            return Design(point, math.inf, math.inf, None, reason or f"{self._aim.text!r} has no mean")
        if self._probability is None:
            return Design(point, mean, max(broken), None, reason)
        share = sum(b == 0.0 for b in broken) / len(broken)
        return Design(point, mean, max(0.0, self._probability - share), share, reason)

    # Ways to search

    def _bisect(self) -> tuple[Design | None, str]:
        if len(self.chosen) != 1 or not self.chosen[0].continuous or self._condition is None:
            raise SearchError("bisection takes one key with from and to, and so_that; give another method")
        one = self.chosen[0]
        first, last = self._judged([{one.key: one.of[0]}, {one.key: one.of[1]}])
        for end in (first, last):
            self._ran(end)
        better, worse = (first, last) if first.aim <= last.aim else (last, first)
        if better.broken == 0.0:
            self._middle(one, better, worse)
            return better, f"so_that holds at {better.point[one.key]:g} already, the better end of the range"
        if worse.broken:
            return None, f"so_that holds at neither end of {one.of[0]:g} to {one.of[1]:g}; give a wider range"
        tolerance = self._study.options.get("tolerance", 1e-3 * (one.of[1] - one.of[0]))
        for _ in range(STEPS):
            a, b = better.point[one.key], worse.point[one.key]
            if abs(a - b) <= tolerance or _middle(one, a, b) in (a, b):
                break
            design = self._middle(one, better, worse)
            better, worse = (better, design) if design.broken == 0.0 else (design, worse)
        return worse, (
            f"so_that breaks at {better.point[one.key]:.6g} and holds at {worse.point[one.key]:.6g}; taken to"
            " change once between the ends"
        )

    def _middle(self, one: Input, better: Design, worse: Design) -> Design:
        """Try the middle of two designs; an aim that does not lie between theirs is no case for bisection."""
        a, b = better.point[one.key], worse.point[one.key]
        (design,) = self._judged([{one.key: _middle(one, a, b)}])
        self._ran(design)
        if not better.aim <= design.aim <= worse.aim:
            raise SearchError(
                f"at {design.point[one.key]:g} the aim is not between those at {a:g} and {b:g}: bisection"
                " can't find the best; give method: evolution"
            )
        return design

    def _ran(self, design: Design) -> None:
        # Uncertain rows may fail, and count as not holding.
        if design.reason and self._probability is None:
            raise SearchError(f"the run at {design.point} failed, and bisection needs it: {design.reason}")

    def _none(self) -> str:
        failed = sum(bool(d.reason) for d in self.designs)
        why = f"; {failed} with rows that failed, such as: {self._failure()}" if failed else ""
        what = "no design ran to its end" if self._condition is None else "so_that holds for none"
        return f"{what} of {len(self.designs)} designs{why}"

    def _failure(self) -> str:
        return next(d.reason for d in self.designs if d.reason)

    def _all(self) -> tuple[Design | None, str]:
        try:
            designs = self._judged(grid(self.chosen))
        except ValueError as problem:
            raise SearchError(str(problem)) from None
        good = [d for d in designs if d.broken == 0.0]
        if not good:
            return None, self._none()
        return min(good, key=lambda d: d.aim), f"the best of {len(good)} that hold, of all {len(designs)}"

    def _evolve(self) -> tuple[Design | None, str]:
        from scipy.optimize import differential_evolution

        count = len(self.chosen)
        generations = self._evaluations // (POPULATION * count) - 1
        cache: dict[tuple[float, ...], float] = {}

        def energies(at: np.ndarray) -> np.ndarray:
            columns = [tuple(map(float, column)) for column in np.atleast_2d(at.T)]
            new = list(dict.fromkeys(c for c in columns if c not in cache))
            for column, design in zip(new, self._judged(points(self.chosen, np.array(new))), strict=True):
                cache[column] = min(max(design.energy, -BROKEN), BROKEN * 1e100)
            return np.array([cache[c] for c in columns])

        done = differential_evolution(
            energies, [(0.0, 1.0)] * count, maxiter=generations, popsize=POPULATION, tol=1e-6, polish=False,
            updating="deferred", vectorized=True, init="latinhypercube",
            rng=np.random.default_rng(self._study.options.get("seed", 1)),
        )  # fmt: skip
        best = min(self.designs, key=lambda d: d.energy)
        if best.broken:
            return None, self._none()
        ended = "until they agreed" if done.success else "until the evaluations allowed were used up"
        return best, f"differential evolution, {done.nit} generations, {ended}; not proved to be the best"


def _middle(one: Input, a: float, b: float) -> float:
    return math.sqrt(a * b) if one.kind == "log" else 0.5 * (a + b)
