"""A sweep's report: what was asked, the answer in tables and plots, what failed. One HTML file."""

from __future__ import annotations

import base64
import html
import io
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..figures.style import BLUE, INK, LINES, ORANGE, styled
from .answer import Answer, column
from .study_file import Study
from .words import tables

MOST_PLOTS = 6
PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
body {{ font: 16px/1.5 sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }}
table {{ border-collapse: collapse; margin: 1rem 0; }}
td, th {{ border: 1px solid #ccc; padding: .2rem .6rem; text-align: left; }}
img {{ max-width: 100%; }} pre {{ background: #f4f4f4; padding: 1rem; overflow: auto; }}
</style></head><body>
{body}
</body></html>
"""


def write_report(study: Study, answer: Answer, found: dict[str, Any], path: Path) -> None:
    """Write the report of an answered study, at once or not at all."""
    name = Path(study.source).name
    body = [f"<h1>{html.escape(name)}</h1>"]
    facts = [
        ("scene", str(study.scene)),
        ("asked", study.ask),
        ("simulated", f"{study.duration:g} s"),
        ("sample", "" if study.ask in ("morris", "search") else _sample(study)),
        ("points, failed", f"{found['points']}, {found['failed']}"),
        *[(f"observed: {key}", text) for key, text in study.observe.items()],
    ]
    body.append(_html_table([], [list(pair) for pair in facts if pair[1]]))
    for title, columns, rows in tables(study, answer.found):
        body.append(f"<h2>{html.escape(title)}</h2>" + _html_table(columns, rows))
    body += [
        f'<img alt="{html.escape(alt)}" src="data:image/png;base64,{base64.b64encode(data).decode()}">'
        for alt, data in _pictures(study, answer)
    ]
    if found["reasons"]:
        rows = [[str(one["rows"]), one["reason"]] for one in found["reasons"]]
        body.append("<h2>Failed rows</h2>" + _html_table(["rows", "reason"], rows))
    body.append(f"<h2>Study</h2><pre>{html.escape(study.text)}</pre>")
    part = path.with_name(path.name + ".part")
    part.write_text(PAGE.format(title=html.escape(name), body="\n".join(body)), encoding="utf-8")
    part.replace(path)


def _sample(study: Study) -> str:
    return study.method if study.method == "grid" else f"{study.method}, {study.count}, seed {study.seed}"


def _html_table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    head = "".join(f"<th>{html.escape(c)}</th>" for c in columns)
    body = "".join("<tr>" + "".join(f"<td>{html.escape(str(v))}</td>" for v in row) + "</tr>" for row in rows)
    return f"<table>{f'<tr>{head}</tr>' if head else ''}{body}</table>"


def _pictures(study: Study, answer: Answer) -> list[tuple[str, bytes]]:
    made = []
    with styled() as pyplot:
        for alt, figure in PICTURES[study.ask](study, answer, pyplot):
            buffer = io.BytesIO()
            figure.savefig(buffer, format="png", dpi=110)
            pyplot.close(figure)
            made.append((alt, buffer.getvalue()))
    return made


Pictures = list[tuple[str, Any]]


def _numbers(study: Study, answer: Answer) -> dict[str, np.ndarray]:
    """Observed quantities that are numbers for some row."""
    rows = [row for row in answer.rows if row is not None]
    each = {name: column(rows, name) for name in study.observe}
    return {name: values for name, values in each.items() if np.isfinite(values).any()}


def _scatter(study: Study, answer: Answer, pyplot: Any) -> Pictures:
    """Each number against each input."""
    made: Pictures = []
    inputs = study.vary[:MOST_PLOTS]
    for name, values in list(_numbers(study, answer).items())[:MOST_PLOTS]:
        figure, all_axes = pyplot.subplots(
            1,
            len(inputs),
            figsize=(3.2 * len(inputs) + 1.0, 3.2),
            sharey=True,
            squeeze=False,
            layout="constrained",
        )
        for axes, one in zip(all_axes[0], inputs, strict=True):
            given = [point[one.key] for point in answer.points]
            numeric = all(isinstance(v, (int, float)) and not isinstance(v, bool) for v in given)
            # Words and lists stand side by side.
            across = given if numeric else [str(v) for v in given]
            axes.plot(across, values, ".", color=BLUE)
            axes.set_xlabel(one.key, fontsize=8)
        all_axes[0][0].set_title(name)
        made.append((f"{name} against what varies", figure))
    return made


def _histograms(study: Study, answer: Answer, pyplot: Any) -> Pictures:
    made: Pictures = []
    for name in list(answer.found["numbers"])[:MOST_PLOTS]:
        values = _numbers(study, answer).get(name)
        if values is None:
            continue
        figure, axes = pyplot.subplots(figsize=(7, 3), layout="constrained")
        axes.hist(values[np.isfinite(values)], bins="auto", color=BLUE)
        axes.set(title=name, ylabel="rows")
        made.append((f"how {name} is spread", figure))
    return made


def _effects(study: Study, answer: Answer, pyplot: Any) -> Pictures:
    made: Pictures = []
    for name, said in answer.found["effects"].items():
        if "problem" in said:
            continue
        figure, axes = pyplot.subplots(figsize=(7, 4), layout="constrained")
        for (key, e), colour in zip(
            said["inputs"].items(), LINES * math.ceil(len(study.vary) / 6), strict=False
        ):
            axes.errorbar(e["mu_star"], e["sigma"], xerr=e["error"], fmt="o", color=colour, label=key)
        axes.set(title=f"{name}: elementary effects", xlabel="mu*: how much", ylabel="sigma: how unevenly")
        axes.legend(fontsize=8)
        made.append((f"elementary effects on {name}", figure))
    return made


def _indices(_: Study, answer: Answer, pyplot: Any) -> Pictures:
    made: Pictures = []
    for name, said in answer.found["indices"].items():
        if "problem" in said:
            continue
        keys = sorted(said["inputs"], key=lambda key: said["inputs"][key]["total"][0])
        figure, axes = pyplot.subplots(figsize=(7, 1.2 + 0.5 * len(keys)), layout="constrained")
        for n, (kind, colour, label) in enumerate(
            (("total", ORANGE, "total"), ("first", BLUE, "first order"))
        ):
            each = np.array([said["inputs"][key][kind] for key in keys])
            at = np.arange(len(keys)) + 0.36 * n - 0.18
            spread = np.abs(each[:, 1:] - each[:, :1]).T
            axes.barh(at, each[:, 0], 0.34, xerr=spread, color=colour, ecolor=INK, label=label)
        axes.set_yticks(range(len(keys)), keys, fontsize=8)
        axes.set(title=f"{name}: shares of its variance")
        axes.legend(fontsize=8)
        made.append((f"Sobol indices of {name}", figure))
    return made


def _front(_: Study, answer: Answer, pyplot: Any) -> Pictures:
    kept = np.array([one["aims"] for one in answer.found["front"]])
    if not len(kept):
        return []
    figure, axes = pyplot.subplots(figsize=(6, 4), layout="constrained")
    axes.plot(kept[:, 0], kept[:, 1], "o-", color=ORANGE)
    axes.set(title="Pareto front", xlabel=answer.found["aims"][0], ylabel=answer.found["aims"][1])
    return [("Pareto front", figure)]


def _history(_: Study, answer: Answer, pyplot: Any) -> Pictures:
    designs = answer.found["history"]
    figure, axes = pyplot.subplots(figsize=(7, 3), layout="constrained")
    for holds, colour, label in ((False, ORANGE, "so_that breaks"), (True, BLUE, "holds")):
        these = [
            (n, d["aim"]) for n, d in enumerate(designs) if d["holds"] is holds and math.isfinite(d["aim"])
        ]
        if these:
            axes.plot(*zip(*these, strict=True), "o", color=colour, label=label)
    axes.set(title="The search", xlabel="design", ylabel="aim")
    axes.legend(fontsize=8)
    return [("designs that were tried", figure)]


PICTURES = {
    "table": _scatter,
    "monte_carlo": _histograms,
    "morris": _effects,
    "sobol": _indices,
    "pareto": _front,
    "search": _history,
}
