"""`flexsim demo`: the main job, from nothing to a bag and pictures."""

from __future__ import annotations

import itertools
import sys
import time
from pathlib import Path
from typing import Any

import click

from ..terminal.report import print_json, print_table
from ..terminal.stop import Stop, stopped_by_signals

CONFIG = Path(__file__).resolve().parents[2] / "config"
SCENE = CONFIG / "anthropomorphic.yaml"
PARAMETERS = CONFIG / "demo.params.yaml"
# The kernels may have to be compiled first, on a slow machine.
START_TIMEOUT = 900.0  # compiling, on a busy machine; a node that ends is noticed at once
SOON = 8.0
RECORDED = ("+ /joint_states", "+ /flexsim_node/elastic_state", "+ /diagnostics", "+ /clock")
LONG_ENOUGH = 10.0  # s: from here on the arm moves when the parameters say


@click.command()
@click.option("-o", "--output", type=click.Path(file_okay=False), metavar="FOLDER",
              help="Where to write; else ./demo, or ./demo_2 where that exists.")  # fmt: skip
@click.option("-d", "--duration", type=click.FloatRange(2.0), default=10.0, show_default=True,
              metavar="SECONDS", help="Of simulated time.")  # fmt: skip
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(output: str | None, duration: float, as_json: bool) -> None:
    """Run a flexible robot in real time with a controller, and record it.

    flexsim_node simulates a three-joint arm of steel at 1 kHz; a controller in a process of its
    own moves it over DDS, in such a hurry that it swings. Written are a bag, a rerun recording
    and a picture.

    \b
    Example:
      flexsim demo
      flexsim demo --output arm --duration 5
    """
    folder = own_folder(output)
    begun = time.monotonic()
    try:
        with stopped_by_signals() as stopped:
            moves = timing(duration)
            run(folder, moves, stopped)
            found = look(folder, moves, stopped)
    except (RuntimeError, TimeoutError) as problem:
        from ..trial.busy import too_busy

        if busy := too_busy(folder / "bag"):
            raise RuntimeError(f"{busy}. What it led to: {problem}") from None
        raise
    finally:
        if not any(folder.iterdir()):
            folder.rmdir()
    found["elapsed"] = round(time.monotonic() - begun, 2)
    if as_json:
        print_json(found)
    else:
        print_figures(found)


def own_folder(output: str | None) -> Path:
    """Make a new folder: the one asked for, or the next free of demo, demo_2, ..."""
    if output is not None:
        folder = Path(output)
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise click.ClickException(f"{folder} exists already; name another folder or remove it")
        folder.mkdir(parents=True, exist_ok=True)
        return folder
    for number in itertools.count(1):
        folder = Path("demo" if number == 1 else f"demo_{number}")
        try:
            folder.mkdir()
        except FileExistsError:
            continue
        return folder
    raise AssertionError("unreachable")


def say(sentence: str) -> None:
    """Tell a person who waits what is going on."""
    click.echo(sentence, err=True)


def timing(duration: float) -> dict[str, float]:
    """Return when the arm moves there and back: as in the parameters, earlier in a shorter run."""
    part = min(1.0, duration / LONG_ENOUGH)
    return {"duration": duration, "there": part * 1.0, "back": part * 5.5}


def run(folder: Path, moves: dict[str, float], stopped: Stop) -> None:
    """Run robot, controller and recorder until the controller's time is over."""
    from ..trial.processes import COMMAND, CONTROLLER, NODE, own_domain, processes

    environment = own_domain()
    parameters = ["--ros-args", "--params-file", str(PARAMETERS), "-p", f"scene:={SCENE}"]
    when = [word for name, value in moves.items() for word in ("-p", f"{name}:={value}")]
    say(f"starting {SCENE.name} at 1 kHz; ROS_DOMAIN_ID={environment['ROS_DOMAIN_ID']}")
    with processes(folder, environment, stopped) as trial:
        recorder = trial.start("recorder", [*COMMAND, "record", "-o", str(folder / "bag"), "--json"])
        robot = trial.start("flexsim_node", [*NODE, *parameters])
        try:
            trial.wait_until_said(robot, "kernels ready", timeout=SOON)
        except TimeoutError:
            say("compiling the equations, once")
            trial.wait_until_said(robot, "kernels ready", timeout=START_TIMEOUT)
        # The robot stands still until it is commanded: by then all of it is to be recorded.
        trial.wait_until_said(recorder, *RECORDED, timeout=START_TIMEOUT)
        controller = trial.start("controller", [*CONTROLLER, *parameters, *when])
        trial.wait_until_said(controller, "ready", timeout=START_TIMEOUT)
        say(f"the arm moves for {moves['duration']:g} s")
        trial.wait_until_said(controller, "the move is over", timeout=10.0 * moves["duration"])
        trial.end(robot)  # it closes with its last diagnostics, which are to be recorded
        trial.end(controller)
        trial.end(recorder)


def look(folder: Path, moves: dict[str, float], stopped: Stop) -> dict[str, Any]:
    """Turn the bag into numbers, a rerun recording and a picture."""
    import rerun as rr
    from ruamel.yaml import YAML

    from flexsim_node import load_scene

    from ..bag import Bag
    from ..controller import Move
    from ..rerun_view import viewer
    from ..rerun_view.bag import show
    from ..trial.busy import too_busy
    from ..trial.figures import figures
    from ..trial.picture import draw

    bag = folder / "bag"
    say("looking at the bag")
    found = figures(bag, moves["duration"])
    recording = rr.RecordingStream("flexsim")
    viewer.attach(recording, save=str(folder / "robot.rrd"), serve=False)
    show(Bag(bag), recording, scale=10.0, rate=60.0)
    recording.flush()
    if stopped.asked:
        raise KeyboardInterrupt
    given = YAML(typ="safe", pure=True).load(PARAMETERS.read_text())
    robot = given["flexsim_node"]["ros__parameters"]
    wanted = given["flexsim_controller"]["ros__parameters"] | moves
    move = Move(*(wanted[name] for name in ("start", "goal", "there", "back", "time")))
    draw(
        bag,
        load_scene(SCENE, flat(robot["override"])),
        move,
        moves["duration"],
        folder / "vibration.png",
    )
    found["too_busy"] = too_busy(bag)
    found["bag"] = str(bag)
    found["recording"] = str(folder / "robot.rrd")
    found["picture"] = str(folder / "vibration.png")
    return found


def flat(nested: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Return nested keys as dotted ones, as ROS does with parameters."""
    found: dict[str, Any] = {}
    for key, value in nested.items():
        if isinstance(value, dict):
            found |= flat(value, f"{prefix}{key}.")
        else:
            found[f"{prefix}{key}"] = value
    return found


def print_figures(found: dict[str, Any]) -> None:
    """Print the table."""
    microseconds = {k: 1e6 * v for k, v in found.items() if "step_time" in k or "latency" in k}
    rows = [
        ["real-time factor", f"{found['real_time_factor']:.4f}"],
        ["overruns", f"{found['overruns']} of {found['ticks']} ticks"],
        ["step time", "p50 {step_time_p50:.0f} µs, p99 {step_time_p99:.0f} µs, "
                      "worst {step_time_worst:.0f} µs".format(**microseconds)],
        ["command to state", "p50 {latency_p50:.0f} µs, "
                             "p99 {latency_p99:.0f} µs".format(**microseconds)],
        ["tip deflection", f"rms {1e3 * found['tip_deflection_rms']:.1f} mm, "
                           f"peak {1e3 * found['tip_deflection_peak']:.1f} mm"],
        ["bag", f"{found['bag_bytes'] / 1e6:.1f} MB, {found['bag_messages']} messages: "
                f"{found['bag']}"],
        ["3-D view", f"rerun {found['recording']}"],
        ["picture", found["picture"]],
    ]  # fmt: skip
    title = f"A flexible arm in real time, {found['duration']:.0f} s; {found['elapsed']:.0f} s in all"
    print_table(title, ["what", "figure"], rows)
    if found["too_busy"]:
        say(f"Warning: {found['too_busy']}")
    sys.stdout.flush()
