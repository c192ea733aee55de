"""An answer as tables for people, in the terminal and in the report."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from .study_file import Study

Shown = tuple[str, list[str], list[list[str]]]
"""Title, columns, rows."""


def tables(study: Study, answer: dict[str, Any]) -> list[Shown]:
    """Return what an answer says."""
    return WORDS[study.ask](study, answer)


def number(value: Any) -> str:
    """A value, short."""
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return str(value)
    return f"{value:.6g}"


def _table(_: Study, answer: dict[str, Any]) -> list[Shown]:
    rows = []
    for name, said in answer["observed"].items():
        if "count" in said:
            rows.append([name, *[""] * 3, ", ".join(f"{k}: {n}" for k, n in said["count"].items())])
        else:
            rows.append([name, number(said["least"]), number(said["median"]), number(said["most"]), ""])
    return [("observed", ["what", "least", "median", "most", "rows of each"], rows)]


def _monte_carlo(study: Study, answer: dict[str, Any]) -> list[Shown]:
    percent = f"{100 * answer['confidence']:g} %"
    made: list[Shown] = []
    chances = [
        [
            name,
            number(c["share"]),
            f"{number(c['lower'])} to {number(c['upper'])}",
            str(c["held"]),
            str(c["rows"]),
        ]
        for name, c in answer["probabilities"].items()
    ]
    drawn = "" if study.method == "random" else f"; made for random rows, mostly too wide for {study.method}"
    if chances:
        note = (f" (widened by {answer['failed']} failed rows)" if answer["failed"] else "") + drawn
        title = f"probabilities, {answer['interval'].replace('_', '-')} intervals{note}"
        made.append((title, ["what", "probability", percent, "held", "rows"], chances))
    rows = []
    for name, d in answer["numbers"].items():
        if not d["rows"]:
            rows.append([name, "", "every row failed", "", "", "", ""])
            continue
        mean = (
            f"{number(d['mean_lower'])} to {number(d['mean_upper'])}"
            if "mean" in d
            else f"{d['infinite']} of {d['rows']} are infinite"
            if d["infinite"]
            else "one row"
        )
        rows.append([name, number(d.get("mean", "")), mean, number(d.get("deviation", "")),
                     number(d["p5"]), number(d["p50"]), number(d["p95"])])  # fmt: skip
    if rows:
        left = f", without {answer['failed']} failed rows" if answer["failed"] else ""
        made.append(
            (
                f"numbers{left}{drawn}",
                ["what", "mean", f"{percent} of the mean", "deviation", "5 %", "50 %", "95 %"],
                rows,
            )
        )
    return made


def _left_out(said: dict[str, Any], what: str) -> str:
    return f"; {said['left_out']} {what} with failed or infinite rows left out" if said["left_out"] else ""


def _morris(_: Study, answer: dict[str, Any]) -> list[Shown]:
    made: list[Shown] = []
    for name, said in answer["effects"].items():
        if "problem" in said:
            made.append((f"{name}: {said['problem']}", ["input"], []))
            continue
        rows = [
            [key, number(e["mu_star"]), number(e["error"]), number(e["mu"]), number(e["sigma"])]
            for key, e in sorted(said["inputs"].items(), key=lambda item: -item[1]["mu_star"])
        ]
        title = f"{name}: elementary effects over an input's whole range{_left_out(said, 'trajectories')}"
        made.append((title, ["input", "mu*", "its standard error", "mu", "sigma"], rows))
    return made


def _sobol(_: Study, answer: dict[str, Any]) -> list[Shown]:
    percent = f"{100 * answer['confidence']:g} %"
    made: list[Shown] = []
    for name, said in answer["indices"].items():
        if "problem" in said:
            made.append((f"{name}: {said['problem']}", ["input"], []))
            continue
        rows = []
        for key, index in sorted(said["inputs"].items(), key=lambda item: -item[1]["total"][0]):
            first, total = index["first"], index["total"]
            rows.append([key, f"{first[0]:.3f}", f"{first[1]:.3f} to {first[2]:.3f}",
                         f"{total[0]:.3f}", f"{total[1]:.3f} to {total[2]:.3f}"])  # fmt: skip
        title = f"{name}: shares of its variance{_left_out(said, 'samples')}"
        made.append((title, ["input", "first order", percent, "total", percent], rows))
    return made


def _pareto(study: Study, answer: dict[str, Any]) -> list[Shown]:
    keys = [one.key for one in study.vary]
    rows = [
        [*[number(v) for v in one["aims"]], *[number(one["inputs"][k]) for k in keys]]
        for one in answer["front"]
    ]
    notes = f"; {answer['broken']} rows break so_that" if answer["broken"] else ""
    notes += f"; {answer['left_out']} failed" if answer["left_out"] else ""
    return [(f"Pareto front of the rows{notes}", [*answer["aims"], *keys], rows)]


def _search(_: Study, answer: dict[str, Any]) -> list[Shown]:
    rows = [[key, number(value)] for key, value in (answer["found"] or {}).items()]
    if answer["found"] is not None:
        rows.append(["aim", number(answer["aim"])])
    if "probability" in answer:
        p = answer["probability"]
        said = f"{number(p['share'])} of {p['rows']} rows, 95 %: {number(p['lower'])} to {number(p['upper'])}"
        said += "; of the rows that the search was made with, so rather too good"
        rows.append(["so_that holds in", said])
    rows.append(["how", answer["how"]])
    return [(f"{answer['method']}, {answer['designs']} designs", ["what", "found"], rows)]


WORDS: dict[str, Callable[[Study, dict[str, Any]], list[Shown]]] = {
    "table": _table,
    "monte_carlo": _monte_carlo,
    "morris": _morris,
    "sobol": _sobol,
    "pareto": _pareto,
    "search": _search,
}
