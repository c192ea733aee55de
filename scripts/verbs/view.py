"""`flexsim view`: looks at a bag, or at a running robot or door, in rerun."""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

import click

from ..terminal.output_file import OutputFile
from ..terminal.progress import Progress
from ..terminal.report import print_json, print_table
from ..terminal.robot_option import robot_option
from ..terminal.stop import stopped_by_signals

APPLICATION = "flexsim"


@click.command()
@click.argument("source", metavar="BAG|SCENE", type=click.Path())
@click.option("--save", type=OutputFile(".rrd"), metavar="FILE.rrd",
              help="Write a rerun recording instead of opening a viewer.")  # fmt: skip
@click.option("--serve", is_flag=True, help="Serve a viewer elsewhere on this host instead.")
@click.option("--web", is_flag=True, help="Serve a web page on this host that shows it in a browser.")
@click.option("--scale", type=click.FloatRange(0.0),
              help="Factor on displacements; else 20 for a robot, 5 for a door.")  # fmt: skip
@click.option("--rate", type=click.FloatRange(1.0, 1000.0), default=60.0, show_default=True,
              metavar="HZ", help="Frames a second of the 3-D view.")  # fmt: skip
@click.option("-d", "--duration", type=click.FloatRange(0.0, min_open=True), metavar="SECONDS",
              help="Live: stop so long after the first message; served: then. Else at Ctrl-C.")  # fmt: skip
@robot_option
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    source: str,
    save: str | None,
    serve: bool,
    web: bool,
    scale: float | None,
    rate: float,
    duration: float | None,
    robot: str,
    as_json: bool,
) -> None:
    """Show a bag, or a running robot or fire door, in rerun.

    A bag is shown as recorded. A scene's file is shown live: flexsim_node, or thermal_node for a
    door, is started on it unless one is running.

    \b
    Example:
      flexsim view run --save run.rrd --scale 20
      flexsim view run --web
      flexsim view config/anthropomorphic.yaml
    """
    if bool(save) + serve + web > 1:
        raise click.UsageError("Give one of --save, --serve and --web.")
    path = Path(source)
    if not path.exists():
        raise click.ClickException(f"{source} does not exist")
    live = path.is_file() and path.suffix in (".yaml", ".yml")
    if live and robot:
        raise click.UsageError("--robot chooses among the robots of a bag.")
    if not (save or serve or web or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise click.ClickException(
            "there is no display to show a viewer on; --save FILE.rrd writes a recording, "
            "--web serves a page for a browser, --serve serves a viewer elsewhere on this host"
        )
    # What goes wrong is said once, by this program.
    os.environ.setdefault("RUST_LOG", "off")
    if live:
        view_live(path, save, serve, web, scale, rate, duration, as_json)
    else:
        view_bag(path, robot, save, serve, web, scale, rate, duration, as_json)


def view_bag(
    path: Path,
    robot: str,
    save: str | None,
    serve: bool,
    web: bool,
    scale: float | None,
    rate: float,
    duration: float | None,
    as_json: bool,
) -> None:
    """Convert a bag and show it."""
    from ..bag import Bag

    begun = time.monotonic()
    bag = Bag(path, robot)

    import rerun as rr

    from ..rerun_view import viewer
    from ..rerun_view.bag import show

    recording = rr.RecordingStream(APPLICATION)
    target = viewer.attach(recording, save=save, serve=serve, web=web)
    progress = Progress()
    try:
        shown = show(bag, recording, scale=scale, rate=rate, progress=lambda at: progress.show(
            f"{at:.0f} of {bag.duration:.0f} s read"))  # fmt: skip
        recording.flush()
        progress.clear()
    except BaseException as problem:
        target.discard()
        target.close()
        if save and isinstance(problem, RuntimeError) and "File-writer" in str(problem):
            raise OSError(f"{save} can't be written to its end: {viewer.why_not_written(save)}") from None
        raise
    if not bag.complete:
        click.echo(f"{path} is damaged or has no end; shown is what could be read", err=True)
    elapsed = time.monotonic() - begun
    result = {
        "bag": str(path),
        "recording": save,
        "serving": target.address,
        "page": target.page,
        "bytes": Path(save).stat().st_size if save else None,
        "duration": bag.duration,
        "conversion_time": round(elapsed, 3),
        "scale": shown.scale,
        "rows": shown.rows,
        "thinned": shown.thinned,
        "without_view": shown.without_view,
    }
    if as_json:
        print_json(result)
    else:
        title = f"{path}: {bag.duration:.1f} s shown in {elapsed:.1f} s"
        if save:
            title += f"; look at it with: rerun {save}"
        rows = [[name, count, shown.thinned.get(name)] for name, count in shown.rows.items()]
        if shown.thinned:
            print_table(title, ["entity", "rows", "of so many in the bag"], rows)
        else:
            print_table(title, ["entity", "rows"], [row[:2] for row in rows])
        if shown.without_view:
            click.echo(f"without a view: {', '.join(shown.without_view)}")
    if web or serve:
        how = f"in a browser: {target.page}" if web else f"with: rerun {target.address}"
        try:
            with stopped_by_signals() as stopped:
                click.echo(f"look at it {how}; Ctrl-C ends", err=True)
                sys.stdout.flush()
                viewer.wait(duration, stopped)
        finally:
            target.close()


def view_live(
    path: Path,
    save: str | None,
    serve: bool,
    web: bool,
    scale: float | None,
    rate: float,
    duration: float | None,
    as_json: bool,
) -> None:
    """Show a running robot or door until Ctrl-C."""
    from ..ros.context import tool_node

    with tool_node("flexsim_view") as node, stopped_by_signals() as stopped:
        import rerun as rr

        from ..rerun_view import live, viewer

        kind = live.kind_of(path)
        with live.simulator(node, path, stopped, kind) as simulator:
            recording = rr.RecordingStream(APPLICATION)
            target = viewer.attach(recording, save=save, serve=serve, web=web)
            try:
                if target.address:
                    click.echo(f"showing on {target.page or target.address}; Ctrl-C ends", err=True)
                shown = live.shown_live(kind, node, recording, scale=scale, rate=rate)
                shown.run(stopped, duration, simulator)
                recording.flush()
                gone = simulator.gone
                stopped_at = simulator.trouble
            finally:
                target.close()
    if not shown.rows:
        target.discard()
        if stopped.asked:
            raise KeyboardInterrupt
        raise RuntimeError(f"the {kind.what} published nothing to show")
    if as_json:
        about = {"scene": str(path), "recording": save, "scale": shown.scale, "rows": shown.rows}
        print_json(about | {"stopped": stopped_at, "gone": gone})
    else:
        print_table(f"{path}: shown live", ["entity", "rows"], list(shown.rows.items()))
    if gone:
        raise click.ClickException(gone)
