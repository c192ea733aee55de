"""`flexsim simulate`: a scene offline, as fast as it goes."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..terminal.report import print_json, print_table
from ..terminal.robot_option import robot_option
from ..terminal.setting import setting

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from flexsim_node import Run, Scene

    from ..replay.drive import Drive


@click.command()
@click.argument("scene", metavar="SCENE|BAG", type=click.Path())
@click.option("-d", "--duration", type=click.FloatRange(0.0, 1e6), metavar="SECONDS",
              help="Of simulated time; else 1, or that of the bag.")  # fmt: skip
@click.option("--sample-period", type=click.FloatRange(0.0, min_open=True), metavar="SECONDS",
              help="Between saved samples; else the scene's step, or the bag's period.")  # fmt: skip
@click.option("--torque", type=click.Path(), metavar="FILE.csv|BAG",
              help="Torques, N m: columns t, one a joint (passive ones may be left out), a row holds "
                   "until the next; or what drove a recorded robot.")  # fmt: skip
@click.option("--start", type=float, metavar="SECONDS",
              help="The time of FILE.csv at which the run begins; else 0, or the first of a file whose times"
                   " are of the wall's clock.")  # fmt: skip
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE",
              help="Change the scene, e.g. solver.step=5e-4; may be repeated.")  # fmt: skip
@click.option("--save", type=click.Path(dir_okay=False), metavar="FILE.npz",
              help="Write the run's arrays for numpy.load.")  # fmt: skip
@robot_option
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    scene: str,
    duration: float | None,
    sample_period: float | None,
    torque: str | None,
    start: float | None,
    settings: tuple[str, ...],
    save: str | None,
    robot: str,
    as_json: bool,
) -> None:
    """Simulate a robot without ROS.

    SCENE is a YAML file, such as those in config/. Without --torque the scene's own torques drive
    it, or none. A BAG stands for the scene and the torques of a recorded robot, which so goes
    through its run again.

    \b
    Example:
      flexsim simulate config/planar_double_pendulum.yaml --duration 2
      flexsim simulate config/anthropomorphic.yaml --set links.link_2.beam.elements=4 --save run.npz
      flexsim simulate run --set links.link_2.beam.elements=4 --save finer.npz
    """
    if save and not Path(save).absolute().parent.is_dir():
        raise click.ClickException(f"{Path(save).parent} does not exist; make it first")
    overrides = dict(map(setting, settings))
    if not Path(scene).is_file() and not is_bag(Path(scene)):
        raise click.ClickException(f"{scene} does not exist; give a scene's YAML file, or a bag")
    if is_bag(Path(scene)) and torque is None:
        torque = scene
    if robot and not any(is_bag(Path(source)) for source in (scene, torque) if source):
        raise click.UsageError("--robot chooses among the robots of a bag.")
    loaded = load(Path(scene), overrides, robot)
    drive = driven(Path(torque), loaded, robot) if torque is not None and is_bag(Path(torque)) else None
    if drive is not None:
        sample_period = 1.0 / drive.rate if sample_period is None else sample_period
        duration = drive.duration if duration is None else duration
    if start is not None and (torque is None or drive is not None):
        raise click.UsageError("--start is for a --torque FILE.csv.")
    run, elapsed = work(loaded, 1.0 if duration is None else duration, sample_period, torque, drive, start)
    if save:
        write(run, loaded, Path(save))
    found = figures(run, loaded, elapsed)
    found |= {"scene": scene, "saved": save}
    if as_json:
        print_json(found)
    else:
        print_figures(found, bool(loaded.loops))
    if run.status != "ok":
        raise click.ClickException(run.status)


def is_bag(path: Path) -> bool:
    """Say whether a path is that of a bag."""
    return path.is_dir() or path.suffix in (".mcap", ".db3", ".zstd") or path.name == "metadata.yaml"


def driven(path: Path, scene: Scene, robot: str) -> Drive:
    """Return what drove a recorded robot; `scene` where the bag does not hold its own."""
    from ..bag import Bag
    from ..replay.drive import read_drive
    from ..replay.ticks import tick_by_tick

    drive = read_drive(Bag(path, robot))
    return tick_by_tick(drive, Bag(path, robot), scene if drive.scene is None else load(path, {}, robot))


def load(path: Path, overrides: dict[str, Any], robot: str = "") -> Scene:
    """Load a scene's file, or the scene that a bag's node published."""
    from flexsim_node import load_scene

    if not is_bag(path):
        return load_scene(path, overrides)
    from ..bag import Bag
    from ..bag.robot import robot_in

    found = robot_in(Bag(path, robot))
    if found.scene is None:
        raise ValueError(f"{path}: {found.why_not}; give the scene's file, and --torque {path}")
    return load_scene(found.scene.scene, overrides)


def work(
    scene: Scene,
    duration: float,
    sample_period: float | None,
    torque: str | None,
    drive: Drive | None,
    start: float | None = None,
) -> tuple[Run, float]:
    """Simulate, with the compilation done before.  Returns the run and the s it took."""
    from flexsim_node import simulate

    from ..signals.torque import read_torque

    period = scene.solver.step if sample_period is None else sample_period
    stride = max(1, math.ceil(period / scene.solver.step - 1e-9))
    fine = period / stride  # torques may change at every step, however few samples are kept
    applied: NDArray[np.float64] | None = None
    if torque is not None:  # what is wrong with it is said before anything is compiled
        steps = round(duration / fine) + 1
        applied = (
            read_torque(Path(torque), scene.joint_names, scene.passive_joints, steps, fine, start)
            if drive is None
            else drive.held(torque, scene.joint_names, steps, fine)
        )
    simulate(scene, duration=0.0)
    begun = time.monotonic()
    if applied is None:
        run = simulate(scene, duration=duration, sample_period=sample_period)
        return run, time.monotonic() - begun
    run = simulate(scene, applied, duration=duration, sample_period=fine)
    return thinned(run, stride), time.monotonic() - begun


def thinned(run: Run, stride: int) -> Run:
    """Keep every so many samples."""
    from dataclasses import replace

    sampled = ("time", "joint_position", "joint_velocity", "torque", "link_end", "node_position",
               "rigid_position", "node_displacement", "energy", "loop_gap", "conditioning")  # fmt: skip
    readings = {name: values[::stride] for name, values in run.sensors.items()}
    return replace(run, sensors=readings, **{name: getattr(run, name)[::stride] for name in sampled})


def write(run: Run, scene: Scene, path: Path) -> None:
    """Save a run's arrays, and the names that go with them."""
    from dataclasses import fields

    import numpy as np

    arrays: dict[str, Any] = {
        f.name: np.asarray(getattr(run, f.name)) for f in fields(run) if f.name not in ("sensors", "decision")
    }
    arrays |= {f"sensors/{name}": readings for name, readings in run.sensors.items()}
    arrays["joint_names"] = np.array(scene.joint_names)
    with path.open("wb") as file:  # numpy would add .npz to a name without it
        np.savez_compressed(file, **arrays)


def figures(run: Run, scene: Scene, elapsed: float) -> dict[str, Any]:
    """Return what a run came to, in SI units."""
    import numpy as np

    ends = tip_nodes(run.node_names, scene.link_names, scene.tips)
    off = np.linalg.norm(run.node_position[:, ends] - run.rigid_position[:, ends], axis=2)
    tip = off[:, np.argmax(off.max(axis=0))]  # that which bends most
    steps = len(run.step_time)
    p50, p99 = np.quantile(run.step_time, [0.5, 0.99]) if steps else (0.0, 0.0)
    return {
        "name": scene.name,
        "status": run.status,
        "simulated_time": float(run.time[-1]),
        "elapsed": elapsed,
        "samples": len(run.time),
        "steps": steps,
        "step_time_p50": float(p50),
        "step_time_p99": float(p99),
        "joint_names": list(scene.joint_names),
        "joint_position": run.joint_position[-1].tolist(),
        "joint_velocity": run.joint_velocity[-1].tolist(),
        "link_end": run.link_end[-1].tolist(),
        "tips": {scene.link_names[n]: run.link_end[-1, n].tolist() for n in scene.tips},
        "tip_deflection_rms": float(np.sqrt(np.mean(tip**2))),
        "tip_deflection_peak": float(tip.max()),
        "effects": None if run.decision is None else run.decision.sentences(),
        "energy_start": float(run.energy[0]),
        "energy_end": float(run.energy[-1]),
        "loop_gap": float(run.loop_gap.max(initial=0.0)),
        "conditioning": float(run.conditioning.min()),
    }


def tip_nodes(names: Sequence[str], links: Sequence[str], tips: Sequence[int]) -> list[int]:
    """Return the last node of each tip's link; names as LINK/NUMBER."""
    owners = [name.rpartition("/")[0] for name in names]
    return [len(owners) - 1 - owners[::-1].index(links[n]) for n in tips]


def print_figures(found: dict[str, Any], loops: bool) -> None:
    """Print the table."""
    rows: list[list[Any]] = [
        [name, f"{q:.6f} rad or m, {v:.6f} a second"]
        for name, q, v in zip(found["joint_names"], found["joint_position"],
                              found["joint_velocity"], strict=True)
    ]  # fmt: skip
    several = len(found["tips"]) > 1
    rows += [
        [f"tip, {name}" if several else "tip", ", ".join(f"{x:.6f}" for x in place) + " m"]
        for name, place in found["tips"].items()
    ]
    rows += [
        ["tip deflection", f"rms {1e3 * found['tip_deflection_rms']:.3f} mm, "
                           f"peak {1e3 * found['tip_deflection_peak']:.3f} mm"],
        ["energy", f"{found['energy_start']:.6f} J at the start, "
                   f"{found['energy_end']:.6f} J at the end"],
        ["step time", f"p50 {1e6 * found['step_time_p50']:.1f} µs, "
                      f"p99 {1e6 * found['step_time_p99']:.1f} µs"],
    ]  # fmt: skip
    if loops:
        rows.append(["loops", f"gaps of at most {found['loop_gap']:.1e} m, "
                              f"conditioning {found['conditioning']:.3f} at its least"])  # fmt: skip
    rows += [["auto", line] for line in found["effects"] or ()]
    if found["saved"]:
        rows.append(["saved", f"{found['saved']}, {found['samples']} samples"])
    title = (
        f"{found['name']}: {found['simulated_time']:g} s in {found['elapsed']:.2f} s, "
        f"{found['steps']} steps; at the end:"
    )
    print_table(title, ["what", "figure"], rows)
