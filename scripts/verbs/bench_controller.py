"""`flexsim bench-controller`: a controller through moves, disturbances and faults, scored."""

from __future__ import annotations

import shutil
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..terminal.report import print_json, print_table
from ..terminal.stop import stopped_by_signals

if TYPE_CHECKING:
    from flexsim_node import Scene

    from ..bench.score import Score
    from ..bench.session import Delay, Session
    from ..controller.trajectory import Trajectory


@click.command()
@click.argument("node")
@click.argument("scene", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--against", metavar="NODE", help="A second controller, side by side.")
@click.option(
    "--rate",
    type=click.FloatRange(10.0, 10_000.0),
    default=500.0,
    show_default=True,
    help="Commands a second, Hz.",
)
@click.option("--goal", metavar="Q,Q,...", help="Where the joints move to; else 0.5 rad or 0.1 m on.")
@click.option(
    "--move-time", type=click.FloatRange(0.01, 60.0), default=0.5, show_default=True, metavar="SECONDS"
)
@click.option(
    "--settle",
    type=click.FloatRange(0.2, 60.0),
    default=1.5,
    show_default=True,
    metavar="SECONDS",
    help="How long it is watched after the move.",
)
@click.option(
    "--only",
    multiple=True,
    type=click.Choice(["nominal", "push", "payload", "wire", "sensors", "motors"]),
    help="Only this case, beside the nominal one; may be given again.",
)
@click.option(
    "--latency/--no-latency",
    default=True,
    show_default=True,
    help="Whether to find the delay at which it fails.",
)
@click.option(
    "--set", "settings", multiple=True, metavar="KEY=VALUE", help="Another value for a key of the scene."
)
@click.option(
    "-o",
    "--output",
    type=click.Path(dir_okay=False, path_type=Path),
    metavar="PNG",
    help="Draw all runs into a picture.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    node: str, scene: Path, against: str | None, rate: float, goal: str | None, move_time: float,
    settle: float, only: tuple[str, ...], latency: bool, settings: tuple[str, ...], output: Path | None,
    as_json: bool,
) -> None:  # fmt: skip
    """Run a controller NODE on the robot of SCENE, in lockstep, and score it.

    NODE is joint_pd, shaped_pd or lqg, or the command line of your own, in quotes. It gets a process of its
    own for each run and the parameters scene, rate and override.* of the robot; it hears `joint_trajectory`
    (latched) and `joint_states`, answers each state once with `flexsim_node/commands`, and ends on Ctrl-C.

    \b
    Example:
      flexsim bench-controller joint_pd config/anthropomorphic_geared.yaml
      flexsim bench-controller joint_pd config/anthropomorphic_geared.yaml --against lqg -o side_by_side.png
      flexsim bench-controller "python my_controller.py" robot.yaml --goal 0.5,1.0 --rate 1000
    """
    from flexsim_node import SceneError, load_scene

    from ..bench.cases import move
    from ..bench.rig import command as words_of
    from ..terminal.setting import setting

    overrides = dict(setting(words) for words in settings)
    try:
        robot = load_scene(scene, overrides)
        wanted = move(robot, [float(x) for x in goal.split(",")] if goal else None, move_time)
    except (SceneError, ValueError) as problem:
        raise click.UsageError(str(problem)) from None
    controllers = [node, *([against] if against else [])]
    if node == against:
        raise click.UsageError("NODE and --against are the same; give another, for example a copy.")
    for words in controllers:
        program = words_of(words)[0] if words.strip() else ""
        if shutil.which(program) is None:
            raise click.UsageError(
                f"there is no program {program!r}; give joint_pd, shaped_pd, lqg or a command line."
            )
    try:
        session = judged(controllers, scene, overrides, robot, wanted, rate, settle, only, latency)
    except KeyboardInterrupt:
        click.echo("stopped: not all runs are done, so nothing is scored", err=True)
        raise
    whole = not any(found["nominal"].lost for found in session.scores.values())
    if output is not None and not whole:
        click.echo(f"{output} is not drawn: a nominal run is lost", err=True)
    elif output is not None:
        from ..bench.picture import draw

        draw(session.recordings, wanted, f"{robot.name}: {' and '.join(controllers)}", output)
    if as_json:
        print_json(as_object(session.scores, session.delays, session.about, output if whole else None))
    else:
        show(robot.name, session.scores, session.delays, session.about)
    if not whole:
        raise SystemExit(1)


def judged(
    controllers: list[str], scene: Path, overrides: dict[str, Any], robot: Scene, wanted: Trajectory,
    rate: float, settle: float, only: tuple[str, ...], latency: bool,
) -> Session:  # fmt: skip
    """Put each controller through its runs."""
    from ..bench.rig import rig
    from ..bench.session import Session

    with (
        stopped_by_signals() as stopped,
        tempfile.TemporaryDirectory() as folder,
        rig(Path(folder), scene.resolve(), overrides, rate, stopped) as bench,
    ):
        session = Session(bench, robot, wanted, settle, say=lambda words: click.echo(words, err=True))
        for controller in controllers:
            session.judge(controller, only, find_latency=latency)
    return session


def as_object(
    scores: dict[str, dict[str, Score]],
    delays: dict[str, Delay],
    about: dict[str, str],
    output: Path | None,
) -> dict[str, Any]:
    """For programs."""
    return {
        "cases": about,
        "controllers": {
            name: {
                "scores": {case: s.as_dict() for case, s in found.items()},
                **({f"delay_{k}": v for k, v in asdict(delays[name]).items()} if name in delays else {}),
            }
            for name, found in scores.items()
        },
        "picture": str(output) if output else None,
    }


def show(
    robot: str,
    scores: dict[str, dict[str, Score]],
    delays: dict[str, Delay],
    about: dict[str, str],
) -> None:
    """For people: a row a case and controller."""
    rows = []
    for case, sentence in about.items():
        for name, found in scores.items():
            if case not in found:
                continue
            s = found[case]
            rows.append([
                case, name, "lost" if s.lost else "ok",
                f"{1e3 * s.tracking_rms:.2f}", f"{1e3 * s.final_error:.2f}", f"{1e3 * s.vibration:.2f}",
                f"{s.settling:.2f}",
                f"{s.effort_rms:.2f}", f"{s.effort_max:.1f}", f"{s.energy:.1f}",
                sentence if name == next(iter(scores)) else "",
            ])  # fmt: skip
    print_table(
        f"Controllers of {robot}",
        ["case", "controller", "", "tracking rms, mrad", "at the end, mrad", "vibration, mm",
         "settled after, s", "torque rms, N m", "torque max, N m", "energy, J", "what"],
        rows,
    )  # fmt: skip
    for name, found in scores.items():
        for case, s in found.items():
            if s.lost:
                click.echo(f"{name}: {case}: lost: {s.reason}")
    for name, delay in delays.items():
        lost = "never lost"
        if delay.lost is not None:
            lost = f"lost at {1e3 * delay.lost:g} ms: {delay.reason}"
        click.echo(f"{name}: bears commands that are {1e3 * delay.borne:g} ms late, {lost}")
