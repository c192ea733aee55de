"""`flexsim compare`: where two runs differ."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..terminal.output_file import OutputFile
from ..terminal.progress import Progress
from ..terminal.report import print_json
from ..terminal.robot_option import robot_option

if TYPE_CHECKING:
    from ..comparison.difference import Comparison


@click.command()
@click.argument("first", metavar="A", type=click.Path())
@click.argument("second", metavar="B", type=click.Path())
@click.option("--topic", "topics", multiple=True, metavar="TOPIC",
              help="Only this, or a pattern; may be repeated.")  # fmt: skip
@click.option("--without", multiple=True, metavar="TOPIC", help="All but this; may be repeated.")
@click.option("--align", type=click.Choice(["stamp", "elapsed", "receipt"]), default="stamp",
              show_default=True,
              help="Bring messages together by their own time, by how long after the run's beginning"
              " that is, or by when they were recorded.")  # fmt: skip
@click.option("--offset", type=float, default=0.0, metavar="SECONDS", help="Add this to the times of B.")
@click.option("--exact", is_flag=True,
              help="Fail where anything differs by a single bit, or could not be compared.")  # fmt: skip
@click.option("--tolerance", type=click.FloatRange(0.0), metavar="PART",
              help="Fail where a field differs by more than this part of its greatest value, or some could"
              " not be compared.")  # fmt: skip
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
    without: tuple[str, ...],
    align: str,
    offset: float,
    exact: bool,
    tolerance: float | None,
    plot: str | None,
    save: str | None,
    scale: float,
    robot: str,
    as_json: bool,
) -> None:
    """Compare two runs, message by message.

    A and B are bags, or files of `flexsim simulate --save`. Every field of every message of both is
    compared, to the bit, with the message of the other run that bears the same time; where topics
    bear no time, one after the other. What could not be compared is listed with the reason, and then
    the runs are never called the same.

    \b
    Example:
      flexsim compare run again
      flexsim compare run again --plot difference.png --save both.rrd
      flexsim compare run again --align elapsed --topic /joint_states
    """
    from ..bag import Bag, BagError
    from ..comparison.saved_run import compared, is_saved, read
    from ..comparison.scenes import scenes
    from ..comparison.table import as_mapping, print_differences

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
    found = compared(Path(first), Path(second), topics, without, align, offset, progress.show, robot)
    shown = Path(first), Path(second)
    progress.clear()
    result = as_mapping(first, second, found)
    if not (is_saved(Path(first)) or is_saved(Path(second))):
        result["scenes"] = scenes(Bag(first), Bag(second))
    if plot:
        from ..comparison.picture import draw

        draw(shown, Path(plot), (Path(first).name, Path(second).name), robot)
        result["plot"] = plot
    if save:
        from ..comparison.recording import record

        result["rows"] = record(shown, Path(save), (Path(first).name, Path(second).name), scale, robot)
        result["recording"] = save
    if as_json:
        print_json(result)
    else:
        print_differences(result)
    refuse(found, exact, tolerance)


def refuse(found: Comparison, exact: bool, tolerance: float | None) -> None:
    """Fail where the runs differ by more than they may, or something could not be compared."""
    if not exact and tolerance is None:
        return
    if not found.pairs:
        raise click.ClickException("nothing in common to compare" + because(found.gaps()))
    worst = max(found.differences, key=lambda d: d.relative)
    if exact and not found.alike:
        raise click.ClickException(f"the runs differ{since(found)}")
    if tolerance is not None and worst.relative > tolerance:
        what = worst.why or f"{worst.relative:.3g} of its greatest value, more than {tolerance:g}"
        if not worst.why and worst.relative == float("inf"):
            what = f"what has no distance{since(found)}"
        raise click.ClickException(f"{worst.name} differs by {what}")
    if not found.complete or (exact and not found.exact):
        raise click.ClickException("not all could be compared" + because(found.gaps()))


def since(found: Comparison) -> str:
    """Say since when runs differ."""
    from ..comparison.table import time_of

    return "" if found.since is None else f" since {time_of(found.since)} s"


def because(gaps: list[str]) -> str:
    """Give the first reasons."""
    more = f"; and {len(gaps) - 3} more" if len(gaps) > 3 else ""
    return (": " + "; ".join(gaps[:3]) + more) if gaps else ""
