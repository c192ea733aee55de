"""A study's file: YAML in, a checked `Study` out; refusals say file, line, what is wrong, what is right."""

from __future__ import annotations

import difflib
import json
import keyword
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from flexsim_core.scene_files import SceneError, line_of, plain, read_scene

from .aim import NAMES, aim
from .expression import Expression, ExpressionError
from .inputs import Input, InputError, read_input
from .sampling import METHODS, MOST_ROWS, correlation_matrix

KEYS = ("scene", "set", "duration", "sample_period", "vary", "correlation", "sample", "observe", "ask")
ASKS: dict[str, tuple[str, ...]] = {
    "table": (),
    "monte_carlo": ("of", "confidence", "interval"),
    "morris": ("of", "trajectories", "levels"),
    "sobol": ("of", "confidence", "resamples"),
    "pareto": ("minimise", "maximise", "so_that"),
    "search": (
        "minimise", "maximise", "so_that", "probability", "tolerance", "evaluations", "seed", "method",
    ),
}  # fmt: skip
COLUMNS = ("failure", "warnings")
"""Columns of a table of rows beside what varies and what is observed."""
POINTLESS = re.compile(r"[-+]?[0-9]+[eE][-+]?[0-9]+")
DURATIONS: dict[str, tuple[float, float | None]] = {"robot": (1.0, None), "fire_door": (3600.0, 60.0)}
"""s that are simulated, and between samples (None: a step), where the study does not say."""


class StudyFileError(ValueError):
    """A study that can't be run: FILE:LINE: key: what is wrong; what would be right."""


@dataclass(frozen=True)
class Study:
    """What is run and asked.

    scene : path; kind : robot or fire_door; settings : what is set in every run
    vary : the inputs; correlation : of pairs of keys; method, count, seed : the sample
    observe : name to expression; ask : what; options : its own; text : the file's
    """

    source: str
    scene: Path
    kind: str
    settings: dict[str, Any]
    duration: float
    sample_period: float | None
    vary: tuple[Input, ...]
    correlation: dict[tuple[str, str], float]
    method: str
    count: int
    seed: int
    observe: dict[str, str]
    ask: str
    options: dict[str, Any] = field(default_factory=dict)
    text: str = ""


class _Reader:
    """A study's document, and complaints about it."""

    def __init__(self, path: Path) -> None:
        try:
            self.document = read_scene(path, "scene, vary, observe, ask")
            self.text = path.read_text(encoding="utf-8")
        except SceneError as problem:
            raise StudyFileError(str(problem).replace("not a scene", "not a study")) from None
        self.path, self.given = path, _numbered(plain(self.document))
        for key, value in self.given.items():
            try:
                json.dumps(value)
            except TypeError:
                raise self.wrong((key,), "holds a date or the like; give numbers, words and lists") from None

    def wrong(self, key: tuple[Any, ...], what: str) -> StudyFileError:
        line = line_of(self.document, key)
        name = ".".join(map(str, key))
        return StudyFileError(
            f"{self.path}:{line}: {name}: {what}" if line else f"{self.path}: {name}: {what}"
        )

    def only(self, at: tuple[Any, ...], given: Mapping[str, Any], known: tuple[str, ...]) -> None:
        for key in given:
            if key not in known:
                near = difflib.get_close_matches(str(key), known, 1)
                right = f"did you mean {near[0]!r}?" if near else f"known here: {', '.join(known) or 'none'}"
                raise self.wrong((*at, key), f"unknown key; {right}")

    def mapping(self, key: str) -> dict[str, Any]:
        found = self.given.get(key)
        if found is None:
            return {}
        if not isinstance(found, dict):
            raise self.wrong((key,), f"is {found!r}; give keys with values")
        return found

    def number(self, at: tuple[Any, ...], value: Any, least: float, most: float, whole: bool = False) -> Any:
        good = isinstance(value, (int, float)) and not isinstance(value, bool) and least <= value <= most
        if not good or (whole and type(value) is not int):
            kind = "a whole number" if whole else "a number"
            raise self.wrong(at, f"is {value!r}; give {kind} from {least:g} to {most:g}")
        return value


def _numbered(value: Any) -> Any:
    """The same with numbers such as 1e-5, which YAML takes for words as they have no point."""
    if isinstance(value, dict):
        return {key: _numbered(one) for key, one in value.items()}
    if isinstance(value, list):
        return [_numbered(one) for one in value]
    return float(value) if isinstance(value, str) and POINTLESS.fullmatch(value) else value


def read_study(path: Path, known: Mapping[str, frozenset[str]]) -> Study:
    """Read and check a study.

    known : kind of scene to the names that expressions over its runs may use

    Raises
    ------
    StudyFileError
    """
    r = _Reader(path)
    r.only((), r.given, KEYS)
    scene, kind = _scene(r)
    duration, period = DURATIONS[kind]
    duration = r.number(("duration",), r.given.get("duration", duration), 1e-9, 1e7)
    if "sample_period" in r.given:
        period = float(r.number(("sample_period",), r.given["sample_period"], 1e-9, 1e7))
    vary = []
    for key, given in r.mapping("vary").items():
        try:
            vary.append(read_input(str(key), given))
        except InputError as problem:
            raise r.wrong(("vary", key), str(problem)) from None
    if not vary:
        raise StudyFileError(f"{path}: vary: is missing; give keys of the scene and how each varies")
    settings = r.mapping("set")
    for one in vary:
        if one.key in settings:
            raise r.wrong(("vary", one.key), "is in set also; leave it out of one of them")
    ask, options = _ask(r)
    observe = {str(k): str(v) for k, v in r.mapping("observe").items()}
    _expressions(r, observe, known[kind], [one.key for one in vary])
    _aims(r, observe, ask, options, tuple(vary))
    method, count, seed = _sample(r, vary, ask)
    correlation = _correlation(r, vary)
    if correlation and (ask in ("morris", "sobol") or method == "grid"):
        what = "a grid has" if method == "grid" and ask not in ("morris", "sobol") else f"{ask} indices have"
        raise r.wrong(
            ("correlation",), f"{what} no meaning for inputs that depend on each other; leave it out"
        )
    return Study(
        str(path), scene, kind, settings, float(duration), period, tuple(vary), correlation, method,
        count, seed, observe, ask, options, r.text,
    )  # fmt: skip


def _scene(r: _Reader) -> tuple[Path, str]:
    given = r.given.get("scene")
    if not isinstance(given, str):
        raise StudyFileError(f"{r.path}: scene: is {given!r}; give the path of a robot's or a door's scene")
    scene = r.path.parent / given  # beside the study, unless it is absolute
    try:
        kind = read_scene(scene, "model, name, links or leaf").get("model")
    except SceneError as problem:
        raise r.wrong(("scene",), str(problem)) from None
    if kind not in DURATIONS:
        raise r.wrong(("scene",), f"{scene} has model {kind!r}; give a scene of a robot or a fire_door")
    return scene, str(kind)


def _sample(r: _Reader, vary: list[Input], ask: str) -> tuple[str, int, int]:
    sample = r.mapping("sample")
    r.only(("sample",), sample, ("method", "count", "seed"))
    gridded = all(one.levels is not None for one in vary)
    method = sample.get("method", "sobol" if ask == "sobol" else "grid" if gridded else "latin_hypercube")
    if ask == "monte_carlo" and "method" not in sample:
        method = "random"
    if ask == "search" and sample:
        if not any(one.random for one in vary):
            raise r.wrong(
                ("sample",), "a search takes one of inputs with distributions, and none has; leave it out"
            )
        if method == "grid" and "method" in sample:
            raise r.wrong(
                ("sample", "method"), "is grid; give random, latin_hypercube or sobol for what is uncertain"
            )
    if ask == "morris" and {"method", "count"} & set(sample):
        raise r.wrong(
            ("sample",), "morris takes a sample of its own; give trajectories there, and a seed here"
        )
    if method not in METHODS:
        raise r.wrong(("sample", "method"), f"is {method!r}; give {', '.join(METHODS)}")
    if ask in ("monte_carlo", "sobol") and method == "grid":
        what = "probabilities" if ask == "monte_carlo" else "indices"
        raise r.wrong(("sample", "method"), f"a grid has no {what}; give random, latin_hypercube or sobol")
    count = r.number(("sample", "count"), sample.get("count", 100), 1, MOST_ROWS, whole=True)
    seed = r.number(("sample", "seed"), sample.get("seed", 1), 0, 2**63 - 1, whole=True)
    for key in ("count", "seed"):
        if method == "grid" and key in sample and ask not in ("morris", "search"):
            raise r.wrong(("sample", key), "is for sampling; a grid has as many rows as its levels make")
    uncounted = [one.key for one in vary if method == "grid" and one.levels is None]
    if uncounted and ask in ("table", "pareto"):
        raise r.wrong(("vary", uncounted[0]), "has no count, which a grid needs; give one, or another method")
    if (method != "grid" or ask == "morris") and ask != "search":
        for one in vary:
            if one.count is not None:
                other = "morris" if ask == "morris" else method
                raise r.wrong(
                    ("vary", one.key), f"has a count, which is for a grid, not {other}; leave it out"
                )
    return method, count, seed


def _correlation(r: _Reader, vary: list[Input]) -> dict[tuple[str, str], float]:
    given = r.given.get("correlation")
    found: dict[tuple[str, str], float] = {}
    if given is None:
        return found
    numeric = [one.key for one in vary if one.random]
    right = "give entries [key, key, number] of inputs that have distributions"
    if not isinstance(given, list):
        raise r.wrong(("correlation",), f"is {given!r}; {right}")
    for n, entry in enumerate(given):
        at = ("correlation", n)
        if not (isinstance(entry, list) and len(entry) == 3):
            raise r.wrong(at, f"is {entry!r}; {right}")
        a, b, value = entry
        if a not in numeric or b not in numeric or a == b:
            raise r.wrong(at, f"is between {a} and {b}; {right}")
        if (a, b) in found or (b, a) in found:
            raise r.wrong(at, f"{a} and {b} have one already; give each pair once")
        found[a, b] = float(r.number(at, value, -0.999, 0.999))
    try:
        correlation_matrix(vary, found)
    except InputError as problem:
        raise r.wrong(("correlation",), str(problem).removeprefix("correlation: ")) from None
    return found


def _ask(r: _Reader) -> tuple[str, dict[str, Any]]:
    given = r.given.get("ask", "table")
    if isinstance(given, str):
        given = {given: {}}
    right = f"give one of {', '.join(ASKS)}"
    if not (isinstance(given, dict) and len(given) == 1):
        raise r.wrong(("ask",), f"is {given!r}; {right}")
    ask, options = next(iter(given.items()))
    if ask not in ASKS:
        near = difflib.get_close_matches(str(ask), ASKS, 1)
        raise r.wrong(("ask", ask), f"unknown; {f'did you mean {near[0]!r}?' if near else right}")
    options = {} if options is None else options
    at = ("ask", ask)
    if not isinstance(options, dict):
        raise r.wrong(at, f"is {options!r}; give its keys: {', '.join(ASKS[ask]) or 'none'}")
    r.only(at, options, ASKS[ask])
    for key, (least, most, whole) in {
        "confidence": (0.5, 0.9999, False), "probability": (0.01, 0.9999, False),
        "trajectories": (2, 100_000, True), "levels": (4, 1000, True), "resamples": (50, 100_000, True),
        "tolerance": (0.0, math.inf, False), "evaluations": (3, MOST_ROWS, True),
        "seed": (0, 2**63 - 1, True),
    }.items():  # fmt: skip
        if key in options:
            r.number((*at, key), options[key], least, most, whole)
    if options.get("levels", 4) % 2:
        raise r.wrong((*at, "levels"), f"is {options['levels']}; give an even number")
    if options.get("interval", "wilson") not in ("wilson", "clopper_pearson"):
        raise r.wrong((*at, "interval"), f"is {options['interval']!r}; give wilson or clopper_pearson")
    if options.get("method", "all") not in ("bisection", "evolution", "all"):
        raise r.wrong((*at, "method"), f"is {options['method']!r}; give bisection, evolution or all")
    if ask == "search" and ("minimise" in options) == ("maximise" in options):
        raise r.wrong(at, "give minimise or maximise, one of them")
    if ask == "search" and "probability" in options and "so_that" not in options:
        raise r.wrong((*at, "probability"), "is that of so_that, which is missing; give it")
    if ask == "pareto" and len(listed(options.get("minimise")) + listed(options.get("maximise"))) < 2:
        raise r.wrong(at, "has fewer than two aims; give at least two to minimise or maximise")
    return ask, options


def listed(value: Any) -> list[Any]:
    """One or several, or none, as a list."""
    return [] if value is None else list(value) if isinstance(value, list) else [value]


def _expressions(r: _Reader, observe: dict[str, str], known: frozenset[str], keys: list[str]) -> None:
    """Refuse expressions that can't be read, and names that can't be theirs."""
    for name, text in observe.items():
        if not name.isidentifier() or keyword.iskeyword(name) or name in NAMES:
            raise r.wrong(("observe", name), "is no name; give letters, digits and _, no word of the grammar")
        if name in keys or name in COLUMNS:
            raise r.wrong(
                ("observe", name), "is the name of something that varies, or of a column; give another"
            )
        try:
            Expression(text, known)
        except ExpressionError as problem:
            raise r.wrong(("observe", name), str(problem)) from None
    if not observe:
        raise StudyFileError(
            f"{r.path}: observe: is missing; give names and expressions over a run's outputs"
        )


def _aims(
    r: _Reader, observe: dict[str, str], ask: str, options: dict[str, Any], vary: tuple[Input, ...]
) -> None:
    """Refuse what is asked of quantities that are not observed."""
    at = ("ask", ask)
    if options.get("of") == []:
        raise r.wrong((*at, "of"), "is an empty list; give names that are observed, or leave it out")
    for name in listed(options.get("of")):
        if name not in observe:
            near = difflib.get_close_matches(str(name), observe, 1)
            right = f"did you mean {near[0]!r}?" if near else f"give some of {', '.join(observe)}"
            raise r.wrong((*at, "of"), f"{name!r} is not observed; {right}")
    for key in ("minimise", "maximise", "so_that"):
        texts = listed(options.get(key))
        if len(texts) > 1 and (ask == "search" or key == "so_that"):
            raise r.wrong((*at, key), "is a list; give one expression")
        for text in texts:
            try:
                aim(text, frozenset(observe), vary)
            except ExpressionError as problem:
                raise r.wrong((*at, key), str(problem)) from None
