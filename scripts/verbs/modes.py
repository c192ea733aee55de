"""`flexsim modes`: natural frequencies, mode shapes, and the linear state space of a robot at rest."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..terminal.report import print_json, print_table
from ..terminal.setting import setting

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from flexsim_node import LinearModel, Modes, Scene

OUTPUTS = ("joint_position", "joint_velocity", "tip_position")
MOST_PLACES = 100_000


@click.command()
@click.argument("scene", type=click.Path())
@click.option(
    "--position", metavar="Q1,Q2,...", help="Joint coordinates, rad or m; the scene's initial ones."
)
@click.option("--free", is_flag=True, help="Joints turn freely instead of being locked.")
@click.option(
    "--loaded", is_flag=True, help="About the equilibrium under gravity, with its loads' stiffness."
)
@click.option("--count", type=click.IntRange(1), default=8, show_default=True, help="Modes to show.")
@click.option("--grid", "grids", multiple=True, metavar="JOINT=FROM:TO:COUNT",
              help="Frequencies over the workspace; for two joints give it twice.")  # fmt: skip
@click.option("--output", "outputs", multiple=True, metavar="NAME",
              help=f"Of the linear model; by default {', '.join(OUTPUTS)}.")  # fmt: skip
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE",
              help="Change the scene, e.g. effects.shear=true; may be repeated.")  # fmt: skip
@click.option("--save", type=click.Path(dir_okay=False), metavar="FILE.npz",
              help="Write frequencies, shapes and A, B, C, D for numpy.load.")  # fmt: skip
@click.option("--plot", type=click.Path(dir_okay=False), metavar="FILE.png", help="Draw the shapes.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    scene: str,
    position: str | None,
    free: bool,
    loaded: bool,
    count: int,
    grids: tuple[str, ...],
    outputs: tuple[str, ...],
    settings: tuple[str, ...],
    save: str | None,
    plot: str | None,
    as_json: bool,
) -> None:
    """Natural frequencies, mode shapes and the linear model of a robot.

    SCENE is a YAML file, such as those in config/. --save keeps the linear model about the static
    equilibrium too; flexsim_node.LinearModel.load(FILE).to_control() makes it an object of
    python-control.

    \b
    Example:
      flexsim modes config/anthropomorphic.yaml --position 0,0.5,-0.8 --save modes.npz --plot modes.png
      flexsim modes config/anthropomorphic.yaml --grid joint_3=-2.5:2.5:21 --plot workspace.png
    """
    for file in (save, plot):
        if file and not Path(file).absolute().parent.is_dir():
            raise click.ClickException(f"{Path(file).parent} does not exist; make it first")
    overrides = dict(map(setting, settings))
    asked = [grid(words) for words in grids]
    if not Path(scene).is_file():
        raise click.ClickException(f"{scene} does not exist; give a scene's YAML file")

    import numpy as np

    from flexsim_node import linearize, load_scene, mode_shapes

    loaded_scene = load_scene(scene, overrides)
    place = np.array(at(position, loaded_scene))
    shapes = mode_shapes(loaded_scene, place, locked=not free, loaded=loaded)
    over = workspace(loaded_scene, place, asked, free, loaded) if asked else None
    model = linearize(loaded_scene, place, outputs or OUTPUTS) if save else None
    if save and model is not None:
        write(shapes, model, over, Path(save))
    if plot:
        from ..modes_view.picture import draw

        drawn = over and (over[0], over[1][:, [loaded_scene.joint_names.index(n) for n in over[0]]], over[2])
        draw(f"{loaded_scene.name}: modes, joints {'free' if free else 'locked'}", shapes, drawn, Path(plot))
    found = figures(loaded_scene, place, shapes, over, model, count)
    found |= {"scene": scene, "locked": not free, "loaded": loaded, "saved": save, "drawn": plot}
    if as_json:
        print_json(found)
    else:
        print_figures(found)


def grid(words: str) -> tuple[str, float, float, int]:
    """Read JOINT=FROM:TO:COUNT."""
    joint, equals, span = words.partition("=")
    try:
        low, high, many = span.split(":")
        found = joint, float(low), float(high), int(many)
    except ValueError:
        found = ("", 0.0, 0.0, 0)
    if not (joint and equals and 2 <= found[3] <= MOST_PLACES and abs(found[2] - found[1]) < float("inf")):
        raise click.UsageError(f"--grid {words}: give JOINT=FROM:TO:COUNT, such as joint_3=-2.5:2.5:21")
    return found


def at(words: str | None, scene: Scene) -> list[float]:
    """Joint coordinates from the words, or the scene's initial ones."""
    m = len(scene.joints)
    if words is None:
        return [float(q) for q in scene.start("position")]
    try:
        found = [float(word) for word in words.split(",")]
    except ValueError:
        found = []
    if len(found) != m or not all(abs(q) < float("inf") for q in found):
        raise click.UsageError(f"--position {words}: give {m} numbers: {','.join(scene.joint_names)}")
    return found


def workspace(
    scene: Scene,
    place: NDArray[np.float64],
    grids: list[tuple[str, float, float, int]],
    free: bool,
    loaded: bool,
) -> tuple[tuple[str, ...], NDArray[np.float64], NDArray[np.float64]]:
    """Return the joints that vary (d,), all positions (K, m), and the frequencies (K, n) there."""
    import numpy as np
    from rich.console import Console
    from rich.progress import track

    from flexsim_node.analysis.modes import frequencies_at, spatial_model

    names = scene.joint_names
    for joint, *_ in grids:
        if joint not in names:
            raise click.UsageError(f"--grid {joint}: no such joint; give one of {', '.join(names)}")
    if len({joint for joint, *_ in grids}) != len(grids) or len(grids) > 2:
        raise click.UsageError("--grid: give it for one joint, or for two different ones")
    if np.prod([many for *_, many in grids]) > MOST_PLACES:
        raise click.UsageError(f"--grid: more than {MOST_PLACES} configurations; give fewer")
    axes = [np.linspace(low, high, many) for _, low, high, many in grids]
    mesh = [part.ravel() for part in np.meshgrid(*axes, indexing="ij")]
    places = np.tile(place, (len(mesh[0]), 1))
    for (joint, *_), values in zip(grids, mesh, strict=True):
        places[:, names.index(joint)] = values
    robot = spatial_model(scene)
    console = Console(stderr=True)
    found = [
        frequencies_at(robot, q, not free, loaded)
        for q in track(places, "configurations", console=console, disable=not console.is_terminal)
    ]
    return tuple(joint for joint, *_ in grids), places, np.array(found)


def write(
    shapes: Modes,
    model: LinearModel,
    over: tuple[tuple[str, ...], NDArray[np.float64], NDArray[np.float64]] | None,
    path: Path,
) -> None:
    """Save modes, linear model and grid; LinearModel.load reads its part."""
    import numpy as np

    arrays: dict[str, Any] = {f.name: np.asarray(getattr(part, f.name)) for part in (shapes, model)
                              for f in fields(part)}  # fmt: skip
    if over is not None:
        arrays |= {"grid_position": over[1], "grid_frequency": over[2]}
    with path.open("wb") as file:  # numpy would add .npz to a name without it
        np.savez_compressed(file, **arrays)


def figures(
    scene: Scene,
    place: NDArray[np.float64],
    shapes: Modes,
    over: tuple[tuple[str, ...], NDArray[np.float64], NDArray[np.float64]] | None,
    model: LinearModel | None,
    count: int,
) -> dict[str, Any]:
    """Return what there is to say of the modes, SI units and Hz."""
    from flexsim_node.analysis.modes import KINDS

    shown = min(count, len(shapes.frequency))
    modes = [
        {
            "frequency": float(shapes.frequency[k]),
            "name": shapes.name(k),
            "share": {
                link: {kind: float(v) for kind, v in zip(KINDS, row, strict=True)}
                for link, row in zip(shapes.link_names, shapes.share[k], strict=True)
            },
        }
        for k in range(shown)
    ]
    found: dict[str, Any] = {
        "name": scene.name,
        "joint_names": list(scene.joint_names),
        "position": place.tolist(),
        "modes": modes,
        "grid": None,
        "linear": None,
    }
    if over is not None:
        joints, places, frequency = over
        low, high = frequency.min(axis=0)[:shown], frequency.max(axis=0)[:shown]
        found["grid"] = {
            "joints": list(joints),
            "configurations": len(places),
            "lowest": low.tolist(),
            "highest": high.tolist(),
            "change": [float(b / a - 1.0) if a > 0.0 else 0.0 for a, b in zip(low, high, strict=True)],
        }
    if model is not None:
        found["linear"] = {
            "states": list(model.state_names),
            "inputs": list(model.input_names),
            "outputs": list(model.output_names),
            "torque": model.torque.tolist(),
        }
    return found


def print_figures(found: dict[str, Any]) -> None:
    """Print the tables."""
    place = ", ".join(f"{n} {q:g}" for n, q in zip(found["joint_names"], found["position"], strict=True))
    over = found["grid"]
    columns = ["mode", "Hz", "where its energy lies"]
    rows: list[list[Any]] = [
        [k + 1, f"{mode['frequency']:.4f}", mode["name"]] for k, mode in enumerate(found["modes"])
    ]
    if over is not None:
        columns[2:2] = ["lowest Hz", "highest Hz", "change %"]
        for row, low, high, change in zip(rows, over["lowest"], over["highest"], over["change"], strict=True):
            row[2:2] = [f"{low:.4f}", f"{high:.4f}", f"{100 * change:.1f}"]
    state = "joints locked" if found["locked"] else "joints free"
    loads = ", about the equilibrium under gravity" if found["loaded"] else ""
    print_table(f"{found['name']} at {place}: {state}{loads}", columns, rows)
    if over is not None:
        click.echo(
            f"\nlowest and highest of {over['configurations']} configurations of {', '.join(over['joints'])}"
        )
    if found["linear"] is not None:
        linear = found["linear"]
        click.echo(
            f"\nlinear model: {len(linear['states'])} states, {len(linear['inputs'])} inputs,"
            f" {len(linear['outputs'])} outputs; in {found['saved']}"
        )
    if found["drawn"]:
        click.echo(f"drawn: {found['drawn']}")
