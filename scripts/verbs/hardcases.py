"""`flexsim hardcases`: scenes that break simulators, and whether they hold."""

from __future__ import annotations

import fnmatch
import time
from typing import Any

import click

from ..terminal.report import print_json, print_table


@click.command()
@click.argument("names", nargs=-1)
@click.option("--list", "listed", is_flag=True, help="Only say what there is, and why it is hard.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(names: tuple[str, ...], listed: bool, as_json: bool) -> None:
    """Run the hard cases, robots and doors, and say whether each holds.

    NAMES choose some of them; * stands for anything.

    \b
    Example:
      flexsim hardcases
      flexsim hardcases 'step_*' folded
      flexsim hardcases --list
    """
    from rich.progress import Progress

    from ..hard_cases import all_cases

    cases = all_cases()
    known = [case.name for case in cases]
    if names:
        for name in names:
            if not fnmatch.filter(known, name):
                raise click.UsageError(f"No case {name!r}. Cases: {', '.join(known)}.")
        cases = [c for c in cases if any(fnmatch.fnmatch(c.name, name) for name in names)]
    if listed:
        if as_json:
            print_json({case.name: {"why": case.why, "holds": case.holds} for case in cases})
        else:
            words = [(case.name, case.why, case.holds) for case in cases]
            print_table("hard cases", ["case", "why it is hard", "what must hold"], words)
        return
    results: dict[str, Any] = {}
    with Progress(transient=True) as progress:
        work = progress.add_task("", total=len(cases))
        for case in cases:
            progress.update(work, description=case.name)
            begun = time.monotonic()
            outcome = case.play()
            results[case.name] = {
                "held": bool(outcome.held),
                "ended": outcome.ended,
                "figures": outcome.figures,
                "seconds": time.monotonic() - begun,
                "why": case.why,
                "holds": case.holds,
            }
            progress.advance(work)
    failed = [name for name, result in results.items() if not result["held"]]
    if as_json:
        print_json({"cases": results, "failed": failed})
    else:
        rows = [
            (
                name,
                "holds" if result["held"] else "FAILS",
                result["holds"],
                ", ".join(f"{key} {value:.3g}" for key, value in result["figures"].items()),
                result["ended"],
            )
            for name, result in results.items()
        ]
        title = f"{len(results) - len(failed)} of {len(results)} hard cases hold"
        print_table(title, ["case", "", "what must hold", "measured", "ended"], rows)
    if failed:
        raise click.ClickException(f"{', '.join(failed)}: what must hold does not")
