"""A comparison as a table, and as the mapping that --json prints."""

from __future__ import annotations

from typing import Any

from ..terminal.report import print_table, say
from .difference import Comparison
from .scenes import sentence


def time_of(seconds: float) -> str:
    """Write a time so that milliseconds can be told, of the clock on the wall too."""
    return f"{seconds:.6g}" if abs(seconds) < 1e4 else f"{seconds:.6f}"


def as_mapping(first: str, second: str, found: Comparison) -> dict[str, Any]:
    """Return the comparison, for the table and for --json."""
    return {
        "first": first,
        "second": second,
        "exact": found.exact,
        "alike": found.alike,
        "since": found.since,
        "messages": found.pairs,
        "not_compared": found.not_compared,
        "left_out": found.left_out,
        "gaps": found.gaps(),
        "topics": {
            t.topic: {
                "paired_by": t.by,
                "compared": t.pairs,
                "only_first": t.only_first,
                "only_second": t.only_second,
                "in_another_order": t.moved + t.crossed,
            }
            for t in found.topics.values()
        },
        "fields": {
            d.name: {
                "compared": d.compared,
                "only_first": d.only_first,
                "only_second": d.only_second,
                "exact": d.exact,
                "largest": d.largest,
                "at": d.at,
                "component": d.component,
                "rms": d.rms,
                "relative": d.relative,
                "since": d.since,
                "why": d.why,
            }
            for d in found.differences
        },
    }


def cells(field: dict[str, Any]) -> list[str]:
    """Return what the table says of how a field differs."""
    if field["exact"]:
        return ["same", "", "", "", ""]
    if field["at"] != field["at"]:  # bytes or words, that have no distance
        return [field["why"] or "differs", "", "", "", time_of(field["since"])]
    return [
        f"{field['largest']:.3g}" + (f", {field['why']}" if field["why"] else ""),
        f"{field['rms']:.3g}",
        f"{100.0 * field['relative']:.3g} %",
        time_of(field["at"]),
        time_of(field["since"]),
    ]


def title_of(result: dict[str, Any]) -> str:
    """Say in one sentence what came of it."""
    runs = f"{result['first']} and {result['second']}"
    if not result["messages"]:
        return f"{runs} have nothing in common to compare"
    if result["exact"]:
        return f"{runs} are the same to the bit, {result['messages']} messages compared"
    if result["alike"]:
        what = "no difference in what could be compared, but not all could be"
        return f"{runs}: {what}; {result['messages']} messages compared"
    return f"{runs} differ since {time_of(result['since'])} s"


def print_differences(result: dict[str, Any]) -> None:
    """Print the table."""
    rows = [
        [name, f["compared"], f["only_first"] or "", f["only_second"] or "",
         *cells(f)]
        for name, f in result["fields"].items()
    ]  # fmt: skip
    columns = ["field", "messages", "only A", "only B", "largest difference", "rms", "of greatest", "at, s",
               "since, s"]  # fmt: skip
    print_table(title_of(result), columns, rows)
    for gap in result["gaps"]:
        say(gap)
    for topic, why in result["left_out"].items():
        say(f"{topic}: left out {why}")
    for node, scene in result.get("scenes", {}).items():
        say(sentence(node, scene))
    for key, word in (("plot", "picture"), ("recording", "both in 3-D: rerun")):
        if key in result:
            say(f"{word} {result[key]}")
