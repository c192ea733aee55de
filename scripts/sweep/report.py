"""A sweep's report: what was asked, the answer in tables and plots, what failed. One HTML file."""

from __future__ import annotations

import html
import math
from pathlib import Path
from typing import Any

import numpy as np

from ..bag_report.page import Section, page
from ..bag_report.pictures import svg
from ..figures.style import BLUE, INK, LINES, ORANGE
from .answer import Answer, column
from .study_file import Study
from .words import tables

MOST_PLOTS = 6
MOST_MARKS = 2000
"""Points of a picture beyond which they are pixels, so that the page stays small."""


def write_report(study: Study, answer: Answer, found: dict[str, Any], path: Path) -> None:
    """Write the report of an answered study, at once or not at all."""
    name = Path(study.source).name
    asked = Section("Study")
    facts = [
        ("scene", str(study.scene)),
        ("asked", study.ask),
        ("simulated", f"{study.duration:g} s"),
        ("sample", "" if study.ask in ("morris", "search") else _sample(study)),
        ("points", str(found["points"])),
        ("failed rows", str(found["failed"])),
        ("rows that warn", str(found["warned"])),
        *[(f"observed: {key}", text) for key, text in study.observe.items()],
    ]
    asked.table(["what", ""], [pair for pair in facts if pair[1]])
    sections = [asked]
    for title, columns, rows in tables(study, answer.found):
        sections.append(Section(title))
        sections[-1].table(columns, rows)
    for title, picture in PICTURES[study.ask](study, answer):
        sections.append(Section(title))
        sections[-1].picture(picture)
    for key, word, title in (("reasons", "reason", "Failed rows"), ("warnings", "warning", "Warnings")):
        if found[key]:
            sections.append(Section(title))
            sections[-1].table(["rows", word], [[one["rows"], one[word]] for one in found[key]])
    sections.append(Section("The study's file", [f"<pre>{html.escape(study.text)}</pre>"]))
    part = path.with_name(path.name + ".part")
    part.write_text(page(name, f"flexsim sweep {study.source}", sections), encoding="utf-8")
    part.replace(path)


def _sample(study: Study) -> str:
    return study.method if study.method == "grid" else f"{study.method}, {study.count}, seed {study.seed}"


Pictures = list[tuple[str, str]]
"""Title and <svg>."""


def _numbers(study: Study, answer: Answer) -> dict[str, np.ndarray]:
    """Observed quantities that are numbers for some row."""
    rows = [row for row in answer.rows if row is not None]
    each = {name: column(rows, name) for name in study.observe}
    return {name: values for name, values in each.items() if np.isfinite(values).any()}


def _scatter(study: Study, answer: Answer) -> Pictures:
    """Each number against each input."""
    made: Pictures = []
    inputs = study.vary[:MOST_PLOTS]

    def against(name: str, values: np.ndarray) -> str:
        def draw(axes: Any) -> None:
            for one, on in zip(inputs, np.atleast_1d(axes), strict=True):
                given = [point[one.key] for point in answer.points]
                numeric = all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in given)
                # Words and lists stand side by side.
                across = given if numeric else [str(v) for v in given]
                on.plot(across, values, ".", color=BLUE, rasterized=len(values) > MOST_MARKS)
                on.set_xlabel(one.key, fontsize=8)

        return svg(draw, name, (3.0 * len(inputs) + 1.0, 3.2), len(inputs))

    for name, values in list(_numbers(study, answer).items())[:MOST_PLOTS]:
        made.append((f"{name} against what varies", against(name, values)))
    return made


def _histograms(study: Study, answer: Answer) -> Pictures:
    def spread(name: str, values: np.ndarray) -> str:
        def draw(axes: Any) -> None:
            axes.hist(values[np.isfinite(values)], bins="auto", color=BLUE)
            axes.set(xlabel=name, ylabel="rows")

        return svg(draw, name)

    known = _numbers(study, answer)
    names = [name for name in answer.found["numbers"] if name in known][:MOST_PLOTS]
    return [(f"How {name} is spread", spread(name, known[name])) for name in names]


def _effects(study: Study, answer: Answer) -> Pictures:
    def effects(name: str, said: dict[str, Any]) -> str:
        def draw(axes: Any) -> None:
            colours = LINES * math.ceil(len(study.vary) / len(LINES))
            for (key, e), colour in zip(said.items(), colours, strict=False):
                axes.errorbar(e["mu_star"], e["sigma"], xerr=e["error"], fmt="o", color=colour, label=key)
            axes.set(xlabel="mu*: how much", ylabel="sigma: how unevenly")

        return svg(draw, name, (9.0, 4.0))

    return [
        (f"Elementary effects on {name}", effects(name, said["inputs"]))
        for name, said in answer.found["effects"].items()
        if "problem" not in said
    ]


def _indices(_: Study, answer: Answer) -> Pictures:
    def indices(name: str, said: dict[str, Any]) -> str:
        keys = sorted(said, key=lambda key: said[key]["total"][0])

        def draw(axes: Any) -> None:
            for n, (kind, colour) in enumerate((("total", ORANGE), ("first", BLUE))):
                each = np.array([said[key][kind] for key in keys])
                at = np.arange(len(keys)) + 0.36 * n - 0.18
                # A percentile of resamples may lie on the estimate's other side.
                spread = np.maximum(0.0, np.array([each[:, 0] - each[:, 1], each[:, 2] - each[:, 0]]))
                label = {"total": "total", "first": "first order"}[kind]
                axes.barh(at, each[:, 0], 0.34, xerr=spread, color=colour, ecolor=INK, label=label)
            axes.set_yticks(range(len(keys)), keys, fontsize=8)
            axes.set_xlabel("share of the variance")

        return svg(draw, name, (9.0, 1.2 + 0.5 * len(keys)))

    return [
        (f"Sobol indices of {name}", indices(name, said["inputs"]))
        for name, said in answer.found["indices"].items()
        if "problem" not in said
    ]


def _front(_: Study, answer: Answer) -> Pictures:
    kept = np.array([one["aims"] for one in answer.found["front"]])
    if not len(kept):
        return []

    def draw(axes: Any) -> None:
        axes.plot(kept[:, 0], kept[:, 1], "o", color=ORANGE)
        axes.set(xlabel=answer.found["aims"][0], ylabel=answer.found["aims"][1])

    of = ", by its first two aims" if kept.shape[1] > 2 else ""
    return [(f"Pareto front{of}", svg(draw, "Pareto front"))]


def _history(_: Study, answer: Answer) -> Pictures:
    designs = answer.found["history"]

    def draw(axes: Any) -> None:
        for holds, colour, label in ((False, ORANGE, "so_that breaks"), (True, BLUE, "holds")):
            these = [
                (n, d["aim"])
                for n, d in enumerate(designs)
                if d["holds"] is holds and math.isfinite(d["aim"])
            ]
            if these:
                axes.plot(*zip(*these, strict=True), "o", color=colour, label=label)
        axes.set(xlabel="design", ylabel="aim")

    return [("Designs that were tried", svg(draw, "search"))]


PICTURES = {
    "table": _scatter,
    "monte_carlo": _histograms,
    "morris": _effects,
    "sobol": _indices,
    "pareto": _front,
    "search": _history,
}
