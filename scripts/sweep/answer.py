"""What a study asks, answered from its rows."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from .aim import aim, number_of, seen
from .expression import Undefined
from .pareto import front
from .probability import chance, described
from .sampling import correlated, correlation_matrix, grid, points, shares
from .search import Search
from .sensitivity import morris_effects, morris_shares, saltelli_shares, sobol_indices
from .study_file import Study, listed
from .table import Row

Point = dict[str, Any]
Rows = Callable[[Sequence[Point]], list[Row | None]]
CONFIDENCE, INTERVAL = 0.95, "clopper_pearson"


@dataclass
class Answer:
    """A study's points, their rows (None: another part's), and what they say.

    found : for programs; numbers of rows that an answer left out are in it
    """

    points: list[Point]
    rows: list[Row | None]
    found: dict[str, Any] = field(default_factory=dict)

    @property
    def whole(self) -> bool:
        """Whether every row is there."""
        return None not in self.rows


def refuse(study: Study) -> None:
    """Refuse a search that can't be made, before there is a table.

    Raises
    ------
    SearchError
    """
    if study.ask == "search":
        Search(study, lambda _: [])


def answered(study: Study, rows: Rows) -> Answer:
    """Run what a study asks, and answer it where every row is there."""
    if study.ask == "search":
        return _search(study, rows)
    planned, at = planned_points(study)
    answer = Answer(planned, rows(planned))
    if answer.whole:
        given = [row for row in answer.rows if row is not None]
        answer.found = ANSWERS[study.ask](study, planned, given, at)
    return answer


def planned_points(study: Study) -> tuple[list[Point], np.ndarray | None]:
    """Every point that a study runs, and Morris' shares."""
    dimension = len(study.vary)
    if study.ask == "morris":
        options = study.options
        at = morris_shares(
            options.get("trajectories", 20),
            dimension,
            options.get("levels", 4),
            study.seed,
        )
        return points(study.vary, at.reshape(-1, dimension)), at
    if study.ask == "sobol":
        at = saltelli_shares(study.method, study.count, dimension, study.seed)
        return points(study.vary, at.reshape(-1, dimension)), at
    if study.method == "grid":
        return grid(study.vary), None
    drawn = shares(study.method, study.count, dimension, study.seed)
    if study.correlation:
        drawn = correlated(drawn, correlation_matrix(study.vary, study.correlation))
    return points(study.vary, drawn), None


def _of(study: Study) -> list[str]:
    of = study.options.get("of")
    return list(study.observe) if of is None else listed(of)


def _numbers(rows: Sequence[Row], name: str, shape: tuple[int, ...]) -> np.ndarray:
    """The same in a shape; ValueError where they are words."""
    if any(isinstance(row.observed[name], str) for row in rows if row.observed is not None):
        raise ValueError("is a word, not a number; observe a condition such as verdict == '...'")
    return column(rows, name).reshape(shape)


def column(rows: Sequence[Row], name: str) -> np.ndarray:
    """What was observed, as numbers (K,): conditions 0 and 1; NaN where a row failed or gave a word."""
    values = [None if row.observed is None else row.observed[name] for row in rows]
    return np.array([math.nan if v is None or isinstance(v, str) else float(v) for v in values])


def _table(study: Study, _: list[Point], rows: list[Row], __: Any) -> dict[str, Any]:
    """Each observed quantity: from, middle, to; how often each word or condition."""
    found: dict[str, Any] = {}
    for name in study.observe:
        values = [row.observed[name] for row in rows if row.observed is not None]
        if not values:
            continue
        if any(isinstance(v, (str, bool)) for v in values):
            found[name] = {"count": dict(sorted(Counter(str(v) for v in values).items()))}
        else:
            low, middle, high = np.quantile(np.array(values), [0.0, 0.5, 1.0], method="inverted_cdf")
            found[name] = {"least": float(low), "median": float(middle), "most": float(high)}
    return {"observed": found}


def _monte_carlo(study: Study, _: list[Point], rows: list[Row], __: Any) -> dict[str, Any]:
    confidence = study.options.get("confidence", CONFIDENCE)
    interval = study.options.get("interval", INTERVAL)
    failed = sum(row.observed is None for row in rows)
    chances: dict[str, Any] = {}
    numbers: dict[str, Any] = {}
    for name in _of(study):
        values = [row.observed[name] for row in rows if row.observed is not None]
        if not values:
            numbers[name] = {"rows": 0}
        elif isinstance(values[0], (bool, str)):
            for word in [True] if isinstance(values[0], bool) else sorted(set(map(str, values))):
                made = chance(sum(v == word for v in values), len(values), failed, confidence, interval)
                label = name if word is True else f"{name} is {word}"
                chances[label] = {"share": made.share, **asdict(made)}
        else:
            numbers[name] = described(np.array(values, float), confidence)
    return {"confidence": confidence, "interval": interval, "probabilities": chances, "numbers": numbers,
            "failed": failed}  # fmt: skip


def _morris(study: Study, _: list[Point], rows: list[Row], at: np.ndarray) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name in _of(study):
        try:
            values = _numbers(rows, name, at.shape[:2])
            effects = morris_effects(at, values)
        except ValueError as problem:
            found[name] = {"problem": str(problem)}
            continue
        found[name] = {
            "left_out": int((~np.isfinite(values).all(axis=1)).sum()),
            "inputs": {one.key: asdict(e) for one, e in zip(study.vary, effects, strict=True)},
        }
    return {"effects": found, "trajectories": len(at)}


def _sobol(study: Study, _: list[Point], rows: list[Row], at: np.ndarray) -> dict[str, Any]:
    confidence = study.options.get("confidence", CONFIDENCE)
    found: dict[str, Any] = {}
    for name in _of(study):
        try:
            values = _numbers(rows, name, at.shape[:2])
            indices = sobol_indices(values, confidence, study.options.get("resamples", 1000), study.seed)
        except ValueError as problem:
            found[name] = {"problem": str(problem)}
            continue
        found[name] = {
            "left_out": int((~np.isfinite(values).all(axis=1)).sum()),
            "inputs": {one.key: asdict(i) for one, i in zip(study.vary, indices, strict=True)},
        }
    return {"indices": found, "confidence": confidence, "samples": len(at)}


def _pareto(study: Study, planned: list[Point], rows: list[Row], _: Any) -> dict[str, Any]:
    options, observed = study.options, frozenset(study.observe)
    texts = [(1.0, t) for t in listed(options.get("minimise"))]
    texts += [(-1.0, t) for t in listed(options.get("maximise"))]
    aims = [(sign, aim(text, observed, study.vary)) for sign, text in texts]
    condition = None if "so_that" not in options else aim(options["so_that"], observed, study.vary)
    values = np.full((len(rows), len(aims)), math.nan)
    broken = 0
    for n, (point, row) in enumerate(zip(planned, rows, strict=True)):
        if row.observed is None:
            continue
        names = seen(point, row.observed)
        try:
            if condition is not None and condition.excess(names) > 0.0:
                broken += 1
                continue
            values[n] = [sign * number_of(one, names) for sign, one in aims]
        except Undefined:
            continue
    kept = front(values)
    signs = np.array([sign for sign, _ in aims])
    return {
        "aims": [f"{'minimise' if sign > 0 else 'maximise'} {text}" for sign, text in texts],
        "front": [
            {"inputs": planned[n], "aims": [float(v) for v in signs * values[n]]}
            for n in kept[np.argsort(values[kept, 0], kind="stable")]
        ],
        "broken": broken,
        "left_out": int(np.isnan(values).any(axis=1).sum()) - broken,
    }


def _search(study: Study, rows: Rows) -> Answer:
    asked: list[Point] = []
    came: list[Row | None] = []

    def kept(some: Sequence[Point]) -> list[Row | None]:
        found = rows(some)
        asked.extend(some)
        came.extend(found)
        return found

    search = Search(study, kept)
    found = search.found()
    history = [
        {
            "inputs": d.point,
            "aim": search.sign * d.aim,
            "holds": d.broken == 0.0,
            "share": d.share,
            "reason": d.reason,
        }
        for d in search.designs
    ]
    return Answer(asked, came, {**found, "history": history})


ANSWERS: dict[str, Callable[..., dict[str, Any]]] = {
    "table": _table,
    "monte_carlo": _monte_carlo,
    "morris": _morris,
    "sobol": _sobol,
    "pareto": _pareto,
}
