"""`flexsim compare`: where two runs differ."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from .terminal.output_file import OutputFile
from .terminal.progress import Progress
from .terminal.report import print_json, print_table
from .terminal.robot_option import robot_option

if TYPE_CHECKING:
    from .comparison.difference import Difference


@click.command()
@click.argument("first", metavar="A", type=click.Path())
@click.argument("second", metavar="B", type=click.Path())
@click.option("--topic", "topics", multiple=True, metavar="TOPIC", help="Only this; may be repeated.")
@click.option("--exact", is_flag=True, help="Fail where anything differs by a single bit.")
@click.option("--tolerance", type=click.FloatRange(0.0), metavar="PART",
              help="Fail where a field differs by more than this part of its greatest value.")  # fmt: skip
@click.option("--plot", type=OutputFile(".png", ".svg", ".pdf"), metavar="FILE.png",
              help="Draw both runs and what is between them.")  # fmt: skip
@click.option("--save", type=OutputFile(".rrd"), metavar="FILE.rrd",
              help="Write a rerun recording with both robots.")  # fmt: skip
@click.option("--scale", type=click.FloatRange(0.0), default=20.0, show_default=True,
              help="Factor on displacements in the recording.")  # fmt: skip
@robot_option
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    first: str,
    second: str,
    topics: tuple[str, ...],
    exact: bool,
    tolerance: float | None,
    plot: str | None,
    save: str | None,
    scale: float,
    robot: str,
    as_json: bool,
) -> None:
    """Compare two runs, message by message of equal simulated time.

    A and B are bags, or files of `flexsim simulate --save`. Every field of every topic that both
    have is compared, to the bit.

    \b
    Example:
      flexsim compare run again
      flexsim compare run again --plot difference.png --save both.rrd
    """
    from .bag import Bag, BagError
    from .comparison.saved_run import compared, is_saved, read
    from .comparison.scenes import scenes

    if robot and not (plot or save or is_saved(Path(first)) or is_saved(Path(second))):
        raise click.UsageError(
            "--robot is for --plot, --save and saved runs; of two bags all topics are compared, or --topic's."
        )
    if plot or save:
        for path in (first, second):  # said at once, not after the comparison
            try:
                read(Path(path), 1, robot)
            except BagError as problem:
                raise BagError(f"{problem}; --plot and --save are for robots") from None
    progress = Progress()
    found, shown = compared(
        Path(first),
        Path(second),
        topics,
        lambda topic, at: progress.show(f"{topic}, {at:.0f} s compared"),
        robot,
    )
    progress.clear()
    result = as_mapping(first, second, found)
    if not (is_saved(Path(first)) or is_saved(Path(second))):
        result["scenes"] = scenes(Bag(first), Bag(second))
    if plot:
        from .comparison.picture import draw

        draw(shown, Path(plot), (Path(first).name, Path(second).name), robot)
        result["plot"] = plot
    if save:
        from .comparison.recording import record

        result["rows"] = record(shown, Path(save), (Path(first).name, Path(second).name), scale, robot)
        result["recording"] = save
    if as_json:
        print_json(result)
    else:
        print_differences(result)
    worst = max(found, key=lambda d: d.relative)
    if exact and not result["exact"]:
        raise click.ClickException(f"the runs differ since {result['since']:g} s")
    if tolerance is not None and worst.relative > tolerance:
        raise click.ClickException(
            f"{worst.name} differs by {worst.relative:.3g} of its greatest value, more than {tolerance:g}"
        )


def as_mapping(first: str, second: str, found: list[Difference]) -> dict[str, Any]:
    """Return the comparison, for the table and for --json."""
    since = [d.since for d in found if d.since == d.since]
    return {
        "first": first,
        "second": second,
        "exact": all(d.exact for d in found),
        "since": min(since, default=None),
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
            }
            for d in found
        },
    }


def cells(field: dict[str, Any]) -> list[str]:
    """Return what the table says of how a field differs."""
    if field["exact"]:
        return ["same", "", "", "", ""]
    if field["at"] != field["at"]:  # bytes or words, that have no distance
        return ["differs", "", "", "", f"{field['since']:.6g}"]
    return [
        f"{field['largest']:.3g}",
        f"{field['rms']:.3g}",
        f"{100.0 * field['relative']:.3g} %",
        f"{field['at']:.6g}",
        f"{field['since']:.6g}",
    ]


def print_differences(result: dict[str, Any]) -> None:
    """Print the table."""
    from .comparison.scenes import sentence

    fields = result["fields"]
    compared = max(f["compared"] for f in fields.values())
    if result["exact"]:
        title = f"{result['first']} and {result['second']} are the same to the bit, {compared} times compared"
    else:
        title = f"{result['first']} and {result['second']} differ since {result['since']:g} s"
    rows = [
        [name, f["compared"], f["only_first"] or "", f["only_second"] or "",
         *cells(f)]
        for name, f in fields.items()
    ]  # fmt: skip
    columns = ["field", "times", "only A", "only B", "largest difference", "rms", "of greatest", "at, s",
               "since, s"]  # fmt: skip
    print_table(title, columns, rows)
    for node, scene in result.get("scenes", {}).items():
        click.echo(sentence(node, scene))
    for key, word in (("plot", "picture"), ("recording", "both in 3-D: rerun")):
        if key in result:
            click.echo(f"{word} {result[key]}")
