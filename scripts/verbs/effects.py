"""`flexsim effects`: what each effect changes at the tip, what it costs, and whether a scene needs it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..terminal.report import print_json, print_table
from ..terminal.robot_option import robot_option
from ..terminal.setting import setting

if TYPE_CHECKING:
    import numpy as np

    from flexsim_node import Scene
    from flexsim_node.scene.schema import Link

TOLERANCE = 1e-4  # m, where neither the scene nor the words give one
MICRO, MILLI = 1e6, 1e3
TWIN, OTHER = "the scene once more", "the other formulation"


@click.command()
@click.argument("scene", type=click.Path())
@click.option("-d", "--duration", type=click.FloatRange(0.0, 1e4, min_open=True), metavar="SECONDS",
              help="Of the run that effects are judged by; the scene's duration if not given.")  # fmt: skip
@click.option("--tolerance", type=click.FloatRange(0.0, min_open=True), metavar="METRES",
              help=f"At the tip; the scene's, or {TOLERANCE:g}.")  # fmt: skip
@click.option("--bag", type=click.Path(), metavar="BAG",
              help="Take the torques from a recorded run instead of the scene's own.")  # fmt: skip
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE",
              help="Change the scene, e.g. solver.step=5e-4; may be repeated.")  # fmt: skip
@robot_option
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    scene: str,
    duration: float | None,
    tolerance: float | None,
    bag: str | None,
    settings: tuple[str, ...],
    robot: str,
    as_json: bool,
) -> None:
    """What each effect changes and costs in a robot's scene.

    SCENE is a YAML file, such as those in config/. It is run as it is, driven by its own torque profile (or
    by none), then once more for each effect, switched, and in the other formulation. Times are medians of
    steps taken in turns.

    \b
    Example:
      flexsim effects config/anthropomorphic.yaml --duration 0.5
      flexsim effects config/planar_double_pendulum.yaml --tolerance 1e-3 --set formulation=auto --json
    """
    overrides = dict(map(setting, settings))
    if not Path(scene).is_file():
        raise click.ClickException(f"{scene} does not exist; give a scene's YAML file")

    if robot and bag is None:
        raise click.UsageError("--robot chooses among the robots of --bag.")
    from flexsim_node import load_scene

    if tolerance is not None:
        overrides["tolerance"] = tolerance
    elif "tolerance" not in overrides:
        overrides = {**overrides, **default_tolerance(scene)}
    loaded = load_scene(scene, overrides)
    drive = None if bag is None else recorded(Path(bag), loaded, robot)
    if drive is not None and duration is None:
        duration = drive[1]
    found = study(loaded, drive[0] if drive else None, duration)
    found |= {"scene": scene, "bag": bag}
    if as_json:
        print_json(found)
    else:
        print_study(found)


def default_tolerance(scene: str) -> dict[str, float]:
    """An override for a scene without a tolerance of its own."""
    from ruamel.yaml import YAML

    try:
        document = YAML(typ="safe", pure=True).load(Path(scene).read_text(encoding="utf-8"))
    except Exception:  # load_scene says what is wrong with it
        return {}
    has = isinstance(document, dict) and document.get("tolerance") is not None
    return {} if has else {"tolerance": TOLERANCE}


def recorded(path: Path, scene: Scene, robot: str) -> tuple[Callable[[float], np.ndarray], float]:
    """Return the torques of a recorded run, held from state to state, and how long it lasts, s."""
    import numpy as np

    from ..bag import Bag, BagError
    from ..replay.drive import read_drive

    drive = read_drive(Bag(path, robot))
    missing = [name for name in scene.joint_names if name not in drive.joint_names]
    if missing or not len(drive.torque):
        what = f"names no joint {missing[0]}" if missing else "holds no torques"
        raise BagError(f"{path} {what}; give a bag of {scene.name}")
    order = [drive.joint_names.index(name) for name in scene.joint_names]
    table, period = np.ascontiguousarray(drive.torque[:, order]), drive.period * 1e-9
    last = len(table) - 1
    return lambda t: table[min(int(t / period + 1e-6), last)], drive.duration


def study(
    scene: Scene, drive: Callable[[float], np.ndarray] | None, duration: float | None
) -> dict[str, Any]:
    """Measure every effect, every link's flexibility, and three dofs a node against six."""
    from rich.console import Console
    from rich.progress import track

    from flexsim_node import resolve_effects
    from flexsim_node.analysis.effects import Trial
    from flexsim_node.analysis.formulations import formulations_apart
    from flexsim_node.analysis.step_cost import step_costs
    from flexsim_node.model.dofs import is_planar
    from flexsim_node.scene.variants import effect_names, in_formulation, with_effect

    limit = scene.tolerance
    assert limit is not None
    console = Console(stderr=True)
    decision = resolve_effects(scene, drive, duration) if scene.undecided else None
    chosen = None if decision is None else decision.chosen
    own = scene if chosen is None else chosen.scene
    trial = Trial(own, drive, duration)
    names = [*effect_names(), *(f"flexible: {k.name}" for k in scene.links if k.beam is not None)]
    changes = [
        trial.change(name) for name in track(names, "runs", console=console, disable=not console.is_terminal)
    ]
    # The scene's twin costs what it costs: what is seen of it is what can't be measured.
    variants: dict[str, Any] = {"scene": trial.scene, TWIN: trial.scene}
    variants |= {c.name: with_effect(trial.scene, c.name, not c.on) for c in changes if not c.trouble}
    flat = is_planar(trial.scene)
    if flat:
        variants["space"] = trial.scene, False
    apart = formulations_apart(own, drive, duration) if any(bends(k) for k in scene.links) else None
    if apart is not None and not apart.refused:
        variants[OTHER] = in_formulation(trial.scene, apart.other)
    costs = step_costs(variants, trial.drive)
    whole = costs["scene"].step
    unseen = abs(costs[TWIN].ratio - 1.0) + costs[TWIN].spread
    rows: list[dict[str, Any]] = []
    for change in changes:
        cost = costs.get(change.name)
        # what the effect itself costs: the scene with it less the scene without it
        share = None if cost is None else (1.0 - cost.ratio if change.on else 1.0 - 1.0 / cost.ratio)
        seconds = None if cost is None else whole * (1.0 - cost.ratio) * (1.0 if change.on else -1.0)
        spread = None if cost is None else max(cost.spread, unseen)
        measurable = cost is not None and spread is not None and abs(cost.ratio - 1.0) > spread
        needed = change.change > limit
        rows.append({
            "effect": change.name, "on": change.on, "change": change.change, "relative": change.relative,
            "cost": seconds if measurable else None, "share": share if measurable else None,
            "cost_spread": None if spread is None else whole * spread,
            "measurable": measurable, "needed": needed, "trouble": change.trouble,
            "verdict": verdict(change.on, needed), "open": change.name in scene.effects.undecided,
        })  # fmt: skip
    rows.sort(key=lambda row: -row["change"])
    other = costs.get(OTHER)
    return {
        "name": scene.name, "duration": trial.duration, "tolerance": limit, "reach": trial.reach,
        "step_time": whole, "planar": flat,
        "space_ratio": costs["space"].ratio if flat else None, "effects": rows,
        "formulation": None if apart is None else {
            "own": apart.own, "other": apart.other, "refused": apart.refused,
            "distance": None if apart.refused else apart.distance,
            "unsure": None if apart.refused else apart.unsure,
            "matters": not apart.refused and apart.distance - apart.unsure > limit,
            "cost_ratio": None if other is None else other.ratio,
            "cost_spread": None if other is None else max(other.spread, unseen),
        },
        "decision": None if decision is None else {
            "formulation": None if chosen is None else {
                "taken": chosen.scene.formulation, "sentence": chosen.sentence(),
                "distance": chosen.apart.distance if chosen.apart and not chosen.apart.refused else None,
                "unsure": chosen.apart.unsure if chosen.apart and not chosen.apart.refused else None,
            },
            "left_out": list(decision.left_out), "together": decision.together,
            "at_rest": decision.at_rest, "margin": scene.auto.margin, "beyond": scene.auto.beyond,
            "sentences": decision.sentences(),
            "effects": decision.effects_said() if decision.changes else None,
        },
    }  # fmt: skip


def bends(link: Link) -> bool:
    """Say whether a link is flexible."""
    return link.beam is not None and link.flexible


def verdict(on: bool, needed: bool) -> str:
    """Return what a scene should do with an effect."""
    if on:
        return "keep" if needed else "can go"
    return "is missing" if needed else "not needed"


def print_study(found: dict[str, Any]) -> None:
    """Print the table."""
    rows = []
    for row in found["effects"]:
        change = f"{MILLI * row['change']:.4g}" if row["change"] < float("inf") else "no run"
        relative = f"{100 * row['relative']:.3g}" if row["change"] < float("inf") else ""
        spread = "" if row["cost_spread"] is None else f"{MICRO * row['cost_spread']:.2f}"
        cost = f"{MICRO * row['cost']:.2f} ± {spread}" if row["measurable"] else ""
        if spread and not row["measurable"]:
            cost = f"not measurable (below {spread})"
        share = "" if row["share"] is None else f"{100 * row['share']:.0f}"
        state = "auto" if row["open"] else "on" if row["on"] else "off"
        rows.append([row["effect"], state, change, relative, cost, share, row["verdict"]])
    title = (
        f"{found['name']}: {found['duration']:g} s, tolerance {MILLI * found['tolerance']:g} mm at the tip, "
        f"a step takes {MICRO * found['step_time']:.1f} µs"
    )
    columns = ["effect", "is", "tip moves by, mm", "of its way, %", "costs, µs a step", "share, %", "verdict"]
    print_table(title, columns, rows)
    for row in found["effects"]:
        if row["trouble"]:
            click.echo(f"{row['effect']}: switched, the run {row['trouble']}")
    if found["space_ratio"] is not None:
        click.echo(f"\nplanar, three dofs a node; six would cost {found['space_ratio']:.2f} times as much")
    formulation = found["formulation"]
    if formulation is not None and formulation["refused"]:
        click.echo(f"\nhow far {formulation['own']} itself is off isn't known: {formulation['refused']}")
    elif formulation is not None:
        more = "; that is more than the tolerance" if formulation["matters"] else ""
        click.echo(
            f"\nformulation: {formulation['other']} is {MILLI * formulation['distance']:.3g} mm"
            f" ± {MILLI * formulation['unsure']:.3g} from {formulation['own']} at the tip{more}"
            f" (co_moving holds where links turn elastically); a step costs {formulation['cost_ratio']:.2f}"
            f" ± {formulation['cost_spread']:.2f} times as much"
        )
    if found["decision"] is not None:
        decision = found["decision"]
        taken = decision["formulation"]
        click.echo("")
        for line in (taken and taken["sentence"], decision["effects"]):
            if line:
                click.echo(f"auto: {line}")
        if decision["left_out"] or (taken and taken["distance"] is not None):
            click.echo(
                f"decided over {decision['margin']:g} times the scene's torques, speeds, poses and duration;"
                f" beyond: {decision['beyond']}"
            )
