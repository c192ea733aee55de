"""flexsim accuracy: what accuracy costs in time, for a robot or a fire door."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..terminal.report import print_json, print_table
from ..terminal.setting import number, setting

if TYPE_CHECKING:
    from ..study.choice import Choice, Cost, Truth
    from ..study.point import Measure, Outcome, Reference, Study
    from ..study.store import Store

ROBOT_DURATION, DOOR_DURATION = 0.5, 3600.0
LOAD = 0.2
"""Part of a control period that a simulation may take where no budget is given."""
CLEAR = 10.0
"""How many times the reference's own error an error must be to be told."""


@click.command()
@click.argument("scene", type=click.Path(dir_okay=False))
@click.option("-d", "--duration", type=click.FloatRange(0.0, 1e6, min_open=True), metavar="SECONDS",
              help="Of simulated time; 0.5 for a robot, 3600 for a door if not given.")  # fmt: skip
@click.option("--sine", "sines", multiple=True, metavar="JOINT=AMPLITUDE@HZ",
              help="Drive a joint with a sine torque; else gravity moves the robot. Repeatable.")  # fmt: skip
@click.option("--rate", type=click.FloatRange(0.0, min_open=True), default=1000.0, show_default=True,
              metavar="HZ", help="Control periods a second that a robot has to keep up with.")  # fmt: skip
@click.option("--budget", metavar="TIME", help="For a control period (a robot) or the test (a door), e.g."
              " 200us; 20 % of the period if not given.")  # fmt: skip
@click.option("--tolerance", metavar="ERROR", help="Of the tip (a robot) or the unexposed face (a door),"
              " e.g. 0.5mm or 1K.")  # fmt: skip
@click.option("--vary", multiple=True, metavar="KEY=V1,V2,...",
              help="A further axis: any key of the scene. Repeatable.")  # fmt: skip
@click.option("--set", "settings", multiple=True, metavar="KEY=VALUE",
              help="Change the scene, e.g. effects.shear=true; may be repeated.")  # fmt: skip
@click.option("-o", "--output", type=click.Path(file_okay=False), metavar="FOLDER",
              help="For points, diagrams and accuracy.json; accuracy_NAME if not given.")  # fmt: skip
@click.option("--quick", is_flag=True, help="A small grid, to see how it looks.")
@click.option("--finer", type=click.IntRange(0, 6), default=0, show_default=True, metavar="N",
              help="Halve the reference's steps and double its mesh N times.")  # fmt: skip
@click.option("--fresh", is_flag=True, help="Begin anew where FOLDER holds points already.")
@click.option("--across-versions", is_flag=True, help="Go on with what other versions have found.")
@click.option("--write", is_flag=True, help="Put the choice, and what --set changed, into the scene's file.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    scene: str,
    duration: float | None,
    sines: tuple[str, ...],
    rate: float,
    budget: str | None,
    tolerance: str | None,
    vary: tuple[str, ...],
    settings: tuple[str, ...],
    output: str | None,
    quick: bool,
    finer: int,
    fresh: bool,
    across_versions: bool,
    write: bool,
    as_json: bool,
) -> None:
    """Show what accuracy costs in time, and what to use.

    SCENE is a YAML file of a robot or a fire door. A reference is made, with a bound on its own error;
    then integrators, steps, meshes, effects and whatever else the scene offers are run against it.
    Stopped with Ctrl-C, the same command goes on where it was, with the scene as it was. Effects that
    the scene leaves to auto are on; a formulation left to auto is both, held against co_moving, and
    --write puts the one that was chosen in its place.

    \b
    Example:
      flexsim accuracy config/planar_double_pendulum.yaml --tolerance 0.5mm
      flexsim accuracy config/anthropomorphic.yaml --sine joint_1=5@1 --budget 200us --write
      flexsim accuracy config/thesis_door.yaml --tolerance 1K
    """
    if not Path(scene).is_file():
        raise click.ClickException(f"{scene} does not exist; give a scene's YAML file")
    from ..study.machine import versions
    from ..study.store import Store

    folder = Path(output or f"accuracy_{name_of(scene, dict(map(setting, settings)))}")
    allowed = asked("--budget", budget, ("us", "µs", "ms", "s"))
    robot = model_of(Path(scene)) != "fire_door"
    exact = asked("--tolerance", tolerance, ("um", "µm", "mm", "m") if robot else ("K",))
    for read, several in ((axis, vary), (sine, sines)):  # wrong words cost no study that is there
        for words in several:
            read(words)
    with Store(folder, Path(scene).read_bytes(), fresh) as store:
        # From here on the scene's file is not read again.
        study = study_of(str(store.scene), dict(map(setting, settings)), duration, sines, vary, quick, finer)
        package = Path(__file__).parents[2] / ("flexsim_node" if robot else "thermal_node")
        store.begin(
            study.fingerprint, versions(package, Path(__file__).parents[1] / "study"), across_versions
        )
        if store.dropped:
            click.echo(f"{store.dropped} damaged lines of {folder}/points.jsonl are run again.", err=True)
        found, outcomes, choice, cost = carried_out(study, scene, store, rate, allowed, exact)
        if write:
            found["written"] = put_into(Path(scene), study, store, choice)
    if as_json:
        print_json(found)
    else:
        print_study(found, study.measures, outcomes, cost)


def carried_out(
    study: Any, scene: str, store: Store, rate: float, allowed: float | None, exact: float | None
) -> tuple[dict[str, Any], list[Outcome], Choice, Cost]:
    """Run the study, choose, and find out what the choice depends on."""
    from ..study.choice import Cost, choose, truth_of

    robot = study.kind == "robot"
    cost = Cost(rate if robot else None)
    shown = allowed if allowed is not None else LOAD / rate if robot else None
    if allowed is None and exact is None:
        allowed = shown
    reference, outcomes = carry_out(study, store)
    measure = study.measures[0]
    floor = CLEAR * reference.error[measure.name]
    own = study.scene.formulation if robot else study.scene.solver.model
    truth = truth_of(own, reference, "co_moving" if robot else "full", not robot)
    choice = choose(outcomes, measure, cost, allowed, exact, floor, truth)
    conditions: dict[str, Any] = {}
    if choice.outcome is not None:
        key = f"{choice.outcome.point}; {exact}"
        if key not in store.conditions:
            store.keep_conditions(key, study.conditions(choice.outcome, reference, exact))
        conditions = store.conditions[key]
    found = report(study, scene, store.folder, reference, outcomes, choice, cost, shown, conditions, truth)
    return found, outcomes, choice, cost


def put_into(scene: Path, study: Any, store: Store, choice: Choice) -> str:
    """Put what the study changed into the scene's file, and return its path."""
    from ..study.writing import put, written

    if choice.outcome is None:
        raise click.ClickException(f"nothing written: {choice.sentence}")
    if study.kind == "robot":
        from flexsim_node import load_scene
    else:
        from thermal_node import load_scene  # type: ignore[assignment]
    changes = {**study.changes, **choice.outcome.overrides}
    text = written(store.text, changes, load_scene)
    if scene.read_bytes() not in (store.text, text) and not store.knows(scene.read_bytes()):
        raise click.ClickException(f"nothing written: {scene} has changed while it was studied")
    store.will_write(text)
    put(scene, text)
    return str(scene)


def name_of(scene: str, overrides: dict[str, Any]) -> str:
    """Return what a scene is called."""
    if model_of(Path(scene)) == "fire_door":
        from thermal_node import load_scene as load_door

        return load_door(scene, overrides).name
    from flexsim_node import load_scene

    return load_scene(scene, overrides).name


def study_of(
    scene: str,
    overrides: dict[str, Any],
    duration: float | None,
    sines: tuple[str, ...],
    vary: tuple[str, ...],
    quick: bool,
    finer: int = 0,
) -> Any:
    """Return the study that fits the scene's model."""
    axes = dict(map(axis, vary))
    if model_of(Path(scene)) == "fire_door":
        from ..study.door import DoorStudy

        if sines:
            raise click.UsageError("--sine: a door has no joints; leave it out")
        return DoorStudy(scene, overrides, duration or DOOR_DURATION, axes, quick, finer)
    from ..study.robot import RobotStudy

    return RobotStudy(
        scene, overrides, duration or ROBOT_DURATION, dict(map(sine, sines)), axes, quick, finer
    )


def model_of(path: Path) -> str:
    """Return what a scene's file says it is."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        document = YAML(typ="safe").load(path.read_text(encoding="utf-8"))
    except (YAMLError, UnicodeDecodeError):
        return "robot"  # whose reader says where the file is wrong
    return str(document.get("model", "robot")) if isinstance(document, dict) else "robot"


def sine(words: str) -> tuple[str, tuple[float, float]]:
    """Read JOINT=AMPLITUDE@HZ."""
    joint, _, rest = words.partition("=")
    amplitude, _, frequency = rest.partition("@")
    a, f = number(amplitude), number(frequency)
    if not joint or a is None or f is None or f <= 0.0:
        raise click.UsageError(f"--sine {words}: give JOINT=AMPLITUDE@HZ, such as joint_1=5@1")
    return joint, (float(a), float(f))


def axis(words: str) -> tuple[str, list[Any]]:
    """Read KEY=V1,V2,..."""
    key, equals, values = words.partition("=")
    if not (key and equals and values):
        raise click.UsageError(f"--vary {words}: give KEY=V1,V2,..., such as damping.beta=0,1e-4")
    return key, [setting(f"{key}={value}")[1] for value in values.split(",")]


def asked(option: str, text: str | None, units: tuple[str, ...]) -> float | None:
    """Read a quantity that an option asks for."""
    from ..study.choice import quantity

    try:
        return None if text is None else quantity(text, units)
    except ValueError as problem:
        raise click.UsageError(f"{option} {problem}") from None


def carry_out(study: Study, store: Store) -> tuple[Reference, list[Outcome]]:
    """Make the reference and run the points that are not there yet."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from ..terminal.stop import stopped_by_signals

    points = study.points()
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with (
        Progress(*columns, console=Console(stderr=True), transient=True) as bar,
        stopped_by_signals() as stop,
    ):
        task = bar.add_task("reference", total=len(points))

        def say(words: str) -> None:
            bar.update(task, description=words)
            if stop.asked:
                raise click.ClickException("stopped while the reference was made; it begins anew")

        reference = store.reference()
        if reference is None:
            reference = study.reference(say)
            store.keep_reference(reference)
        for point in points:
            bar.update(task, description=point.name)
            if stop.asked:
                done = len(store.outcomes)
                raise click.ClickException(
                    f"stopped after {done} of {len(points)} points; the same command goes on from there"
                )
            if point.name not in store.outcomes:
                store.keep(study.measure(point, reference))
            store.outcomes[point.name].effect = point.effect
            bar.advance(task)
    return reference, [store.outcomes[p.name] for p in points]


def report(
    study: Any,
    scene: str,
    folder: Path,
    reference: Reference,
    outcomes: list[Outcome],
    choice: Choice,
    cost: Cost,
    budget: float | None,
    conditions: dict[str, Any],
    truth: Truth,
) -> dict[str, Any]:
    """Draw the diagrams, write accuracy.json, and return what it says."""
    import json
    import math

    from ..study.choice import conditions_said, frontier
    from ..study.diagram import draw
    from ..study.machine import machine
    from ..study.order import observed_orders
    from ..terminal.report import finite

    diagrams = {}
    for measure in study.measures:
        if not any(o.ok and o.errors.get(measure.name) is not None for o in outcomes):
            continue
        floor = CLEAR * reference.error.get(measure.name, 0.0)
        floor = max(floor, 1e-12) if math.isfinite(floor) else 1e-12
        path = folder / f"{measure.name}.png"
        best = frontier(outcomes, measure.name, floor)
        title = f"{study.scene.name}: {measure.label}"
        draw(path, title, outcomes, best, measure, floor, cost, budget)
        diagrams[measure.name] = str(path)
    main = study.measures[0].name
    order = "time" if study.kind == "robot" else main
    found = {
        "scene": scene,
        "name": study.scene.name,
        "kind": study.kind,
        "duration": study.duration,
        "drive": {k: list(v) for k, v in getattr(study, "sines", {}).items()},
        "rate": cost.rate,
        "made": time.strftime("%Y-%m-%d"),
        "machine": machine(),
        "reference": {
            "how": reference.how,
            "error": reference.error,
            "orders": reference.orders,
            "finer": reference.finer,
        },
        "formulation": getattr(study.scene, "formulation", None) or study.scene.solver.model,
        "formulations": reference.formulations,
        "formulation_said": getattr(study, "taken", ""),
        "measures": {m.name: {"label": m.label, "unit": m.unit, "scale": m.scale} for m in study.measures},
        "points": [
            o.record() | ({"median": o.median, "spread": o.spread} if o.seconds else {}) for o in outcomes
        ],
        "effects": [o.point for o in outcomes if o.effect],
        "frontier": [o.point for o in frontier(outcomes, main, CLEAR * reference.error[main])],
        "orders": observed_orders(outcomes, order, 3.0 * reference.error[order]),
        "sentence": choice.sentence,
        "promise": choice.promise,
        "told": choice.told,
        "conditions": conditions,
        "conditions_said": conditions_said(conditions, study.measures[0], cost),
        "opened": list(getattr(study, "opened", ())),
        "choice": None if choice.outcome is None else choice.outcome.point,
        "diagrams": diagrams,
    }
    text = json.dumps(finite(found), indent=1, ensure_ascii=False) + "\n"
    part = folder / "accuracy.json.part"
    part.write_text(text, encoding="utf-8")
    part.replace(folder / "accuracy.json")
    return found


def print_study(
    found: dict[str, Any], measures: tuple[Measure, ...], outcomes: list[Outcome], cost: Cost
) -> None:
    """Print the frontier, what did not run, and the sentence."""
    from ..study.choice import duration_said, formulations_said

    by_name = {o.point: o for o in outcomes}
    best = [by_name[name] for name in found["frontier"]]
    shown = [m for m in measures if any(o.errors.get(m.name) is not None for o in best)]
    rows = [
        [o.curve, duration_said(o.step) if o.step else f"tolerance {o.size:g}",
         duration_said(cost.of(o)), f"±{o.spread:.0%}", *(m.show(o.errors.get(m.name)) for m in shown)]
        for o in best
    ]  # fmt: skip
    own = ", ".join(
        f"{m.label} {m.show(found['reference']['error'][m.name]) or 'not known'}"
        for m in measures
        if m.name in found["reference"]["error"]
    )
    click.echo(f"Reference: {found['reference']['how']}. Its own error is at most: {own}.")
    if found["opened"]:
        click.echo(f"Left to auto by the scene, and on here: {', '.join(found['opened'])}.")
    if found["formulation_said"]:
        click.echo(found["formulation_said"])
    for sentence in formulations_said(found["formulation"], found["formulations"], measures[0]):
        click.echo(sentence)
    unit = "time a period" if cost.rate else "time"
    title = f"{found['name']}: {len(outcomes)} points; those that nothing beats in both time and error:"
    print_table(title, ["method", "step", unit, "spread", *(m.label for m in shown)], rows)
    effects = [
        [o.curve, *(m.show(o.errors.get(m.name)) for m in shown)] for o in outcomes if o.effect and o.ok
    ]
    if effects:
        print_table("What each effect changes:", ["effect", *(m.label for m in shown)], effects)
    failed = [[o.point, o.status] for o in outcomes if not o.ok]
    if failed:
        print_table("Without a result:", ["point", "why"], failed)
    click.echo(found["sentence"])
    for sentence in found["conditions_said"]:
        click.echo(sentence)
    if found.get("written"):
        click.echo(f"Written into {found['written']}.")
    click.echo("Diagrams: " + ", ".join(found["diagrams"].values()))
