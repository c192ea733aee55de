"""`flexsim recover`: mends a bag."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..terminal.progress import Progress
from ..terminal.report import print_json, print_table

if TYPE_CHECKING:
    from ..bag.mend import Mended


@click.command()
@click.argument("bag", type=click.Path())
@click.option("-o", "--output", type=click.Path(), metavar="BAG",
              help="Write a whole copy instead, and leave the bag as it is.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(bag: str, output: str | None, as_json: bool) -> None:
    """Mend a bag whose end is missing or that is damaged, and say what was lost.

    BAG is a bag's folder, or one .mcap file. Each chunk is checked; what can be read goes into
    whole files, and metadata.yaml is made anew. A file with damage within is kept beside the
    mended one, as .mcap.damaged.

    \b
    Example:
      flexsim recover run
    """
    from ..bag.mend import mend

    progress = Progress()
    results = mend(
        Path(bag),
        Path(output) if output else None,
        lambda done, size: progress.show(f"{1e-6 * done:.0f} of {1e-6 * size:.0f} MB checked"),
    )
    progress.clear()
    found = as_mapping(output or bag, results)
    if as_json:
        print_json(found)
    else:
        print_mended(found)


def as_mapping(bag: str, results: list[Mended]) -> dict[str, Any]:
    """Return what was done, for the table and for --json."""
    return {
        "bag": bag,
        "messages": sum(r.count for r in results),
        "whole": not any(r.lost for r in results),
        "files": {
            r.file.name: {
                "messages": r.count,
                "lost": max(0, r.expected - r.count) if r.expected is not None else None,
                "written_anew": r.written_anew,
                "kept": None if r.kept is None else str(r.kept),
                "damages": [
                    {"offset": d.offset, "what": d.what, "from": d.first or None, "to": d.last or None}
                    for d in r.lost
                ],
            }
            for r in results
        },
    }


def print_mended(found: dict[str, Any]) -> None:
    """Print the table."""
    state = "was whole" if found["whole"] else "is mended"
    rows = []
    for name, file in found["files"].items():
        lost = file["lost"]
        said = "; ".join(f"byte {d['offset']}: {d['what']}" for d in file["damages"])
        rows.append(
            [name, file["messages"], "nothing" if not said else "unknown" if lost is None else lost, said]
        )
    print_table(
        f"{found['bag']} {state}: {found['messages']} messages",
        ["file", "messages", "lost", "what was wrong"],
        rows,
    )
    for file in found["files"].values():
        if file["kept"]:
            click.echo(f"as it was: {file['kept']}")
