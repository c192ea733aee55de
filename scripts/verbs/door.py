"""`flexsim door`: fire doors offline, burnt and fitted."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..door_fit.estimates import estimates, fit_facts, print_estimates, print_foreseen, same_make
from ..door_fit.priors import priors
from ..terminal.progress import Progress
from ..terminal.report import print_json, print_table
from ..terminal.setting import setting

if TYPE_CHECKING:
    from thermal_node import Run

MINUTE = 60.0
MILLIMETRES = 1e3
KILO = 1e3
PERCENT = 100.0
REPORTS = (".html", ".md")
FURNACE_TYPE = "sensor_msgs/msg/Temperature"
FURNACE_TOPICS = ("furnace/measured_temperature", "furnace/temperature")
# Stamps beyond this, s, are those of a clock on the wall, not of a fire.
WALL_CLOCK = 1e8
# s of a fire that may be missing at a log's beginning; its first value is held for them.
LATEST_START = 30.0


@click.group(subcommand_metavar="simulate|fit [ARGS]...")
def command() -> None:
    """Burn a fire door, or learn its materials from a test.

    \b
    Example:
      flexsim door simulate config/thesis_door.yaml --report door.html
      flexsim door fit config/thesis_door.yaml LOG.csv --json
    """


duration_option = click.option(
    "-d", "--duration", type=click.FloatRange(0.0, 1e6, min_open=True), default=3600.0,
    show_default=True, metavar="SECONDS", help="Of fire.",
)  # fmt: skip
set_option = click.option(
    "--set", "settings", multiple=True, metavar="KEY=VALUE",
    help="Change the scene, e.g. leaf.layers.1.thickness=0.08; may be repeated.",
)  # fmt: skip
json_option = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")


@command.command("simulate")
@click.argument("scene", type=click.Path())
@duration_option
@click.option("--sample-period", type=click.FloatRange(0.0, min_open=True), default=60.0,
              show_default=True, metavar="SECONDS", help="Between samples.")  # fmt: skip
@set_option
@click.option("--furnace", type=click.Path(), metavar="BAG|LOG.csv",
              help="Burn it in the furnace that was measured, instead of the scene's.")  # fmt: skip
@click.option("--report", type=click.Path(dir_okay=False), metavar="FILE.html",
              help="Write a report with curves, verdict and inputs; FILE.md also.")  # fmt: skip
@click.option("--save", type=click.Path(dir_okay=False), metavar="FILE.npz",
              help="Write the run's arrays for numpy.load.")  # fmt: skip
@json_option
def simulate_door(
    scene: str,
    duration: float,
    sample_period: float,
    settings: tuple[str, ...],
    furnace: str | None,
    report: str | None,
    save: str | None,
    as_json: bool,
) -> None:
    """Burn a door without ROS, as fast as it goes.

    SCENE is a YAML file, such as config/thesis_door.yaml. A measured furnace is the topic
    furnace/measured_temperature of a bag, or else furnace/temperature; or a laboratory's CSV file:
    time, s, and one or several columns furnace..., °C, unless their names say other units.

    \b
    Example:
      flexsim door simulate config/thesis_door.yaml --duration 3600 --report door.html
      flexsim door simulate config/thesis_door.yaml --set solver.model=column_rim --save run.npz
    """
    check_targets(report, save)
    overrides = dict(map(setting, settings))
    if furnace:
        overrides = {"furnace": measured_furnace(Path(furnace))} | overrides

    from thermal_node import load_scene, simulate

    loaded = load_scene(scene, overrides)
    progress = Progress()
    begun = time.monotonic()
    run = simulate(
        loaded,
        duration,
        sample_period,
        lambda t: progress.show(f"{t / MINUTE:.0f} of {duration / MINUTE:.0f} min burnt"),
    )
    elapsed = time.monotonic() - begun
    progress.clear()
    found = figures(run, elapsed) | {"scene": scene, "report": report, "saved": save}
    write(run, report, save)
    if as_json:
        print_json(found)
    else:
        print_figures(found)
    if not run.status.ok:
        raise click.ClickException(run.status.reason)


@command.command("fit")
@click.argument("scene", type=click.Path())
@click.argument("logs", metavar="LOG.csv...", type=click.Path(), nargs=-1, required=True)
@click.option("--material", metavar="NAME", help="What is fitted; else the thickest layer's.")
@click.option("--keep-density", is_flag=True, help="Take the density as the scene has it.")
@click.option("--keep-rim", is_flag=True, help="Take the rim's contact as the scene has it.")
@click.option("--prior", multiple=True, metavar="KEY=VALUE±DEVIATION",
              help="Known beforehand: density=120±6, rim_contact=0.8+-0.1, conductivity_600=0.17±0.03;"
                   " may be repeated.")  # fmt: skip
@click.option("--also", multiple=True, nargs=2, type=click.Path(), metavar="SCENE LOG.csv",
              help="A test of a door of another size and the same make, fitted with it; may be"
                   " repeated.")  # fmt: skip
@click.option("--leave-out", multiple=True, metavar="TC", help="A thermocouple not to use; may be repeated.")
@click.option("--check", is_flag=True, help="Say what the logs can tell of each parameter, and fit nothing.")
@click.option("--predict", type=click.Path(), metavar="LARGER_SCENE",
              help="Burn another door with the materials that were found.")  # fmt: skip
@duration_option
@set_option
@click.option("--report", type=click.Path(dir_okay=False), metavar="FILE.html",
              help="Report of the predicted door, or else of the fitted one.")  # fmt: skip
@json_option
def fit_door(
    scene: str,
    logs: tuple[str, ...],
    material: str | None,
    keep_density: bool,
    keep_rim: bool,
    prior: tuple[str, ...],
    also: tuple[tuple[str, str], ...],
    leave_out: tuple[str, ...],
    check: bool,
    predict: str | None,
    duration: float,
    settings: tuple[str, ...],
    report: str | None,
    as_json: bool,
) -> None:
    """Estimate a door's materials from the thermocouples of a fire test.

    LOG.csv has a column time, s unless its name says another unit (time_min), columns named after the
    scene's probes (tc_1 ... tc_12), and furnace if it was measured. Several logs are of several tests of
    that door, each in its own furnace. Estimated are the insulation's conductivity above 300 °C, its
    density and the rim's contact, each with its 95 % interval; all else is held as the scene has it, and
    how far that moves the readings is said. Before the fit it is said what the logs can't tell. SECONDS
    are those of the fire that is predicted.

    \b
    Example:
      flexsim door fit config/thesis_door.yaml LOG.csv
      flexsim door fit config/thesis_door.yaml LOG.csv --check
      flexsim door fit config/thesis_door.yaml A.csv B.csv --prior density=120±6 --leave-out tc_7
      flexsim door fit config/thesis_door.yaml LOG.csv --also larger.yaml LARGER_LOG.csv
      flexsim door fit config/thesis_door.yaml LOG.csv --predict larger.yaml --report larger.html
    """
    check_targets(report, None)
    overrides = dict(map(setting, settings))

    from thermal_node import load_scene
    from thermal_node.analysis.fit import fit, foresee_fit
    from thermal_node.furnace.thermocouple_log import read_thermocouple_log

    loaded = load_scene(scene, overrides)
    larger = load_scene(predict) if predict else None
    known = priors(prior)
    doors = [loaded] * len(logs) + [load_scene(other, overrides) for other, _ in also]
    logs += tuple(log for _, log in also)
    readings = [read_thermocouple_log(log) for log in logs]
    for log in readings:
        for note in log.notes:
            click.echo(f"{log.source}: {note}", err=True)
    progress = Progress()
    begun = time.monotonic()
    if check:
        if predict or report:
            raise click.UsageError("--check fits nothing; leave --predict and --report out")
        names, told = foresee_fit(
            doors, readings, material, not keep_rim, not keep_density, priors=known, leave=leave_out
        )
        print_foreseen(list(names), told, ", ".join(logs), as_json)
        return

    def say(note: str) -> None:
        click.echo(f"before the fit: {note}", err=True)

    result = fit(
        doors,
        readings,
        material,
        rim=not keep_rim,
        density=not keep_density,
        progress=lambda runs, rms: progress.show(f"run {runs} of the model: {rms:.2f} K off"),
        priors=known,
        leave=leave_out,
        say=say,
    )
    elapsed = time.monotonic() - begun
    found = estimates(result, elapsed) | {"scene": scene, "log": ", ".join(logs), "prediction": None}
    burnt = result.scene
    if larger is not None:
        burnt = same_make(larger, result)
    run = None
    if larger is not None or report:
        from thermal_node import simulate

        begun = time.monotonic()
        run = simulate(burnt, duration, MINUTE, lambda t: progress.show(
            f"{burnt.name}: {t / MINUTE:.0f} of {duration / MINUTE:.0f} min burnt"))  # fmt: skip
        write(run, report, None, fit_facts(result))
        if larger is not None:
            about = {"scene": predict, "report": report, "saved": None}
            found["prediction"] = figures(run, time.monotonic() - begun) | about
    progress.clear()
    if as_json:
        print_json(found)
    else:
        print_estimates(found)
        if found["prediction"]:
            print_figures(found["prediction"])
        elif report:
            click.echo(f"report: {report}")
    if run is not None and not run.status.ok:
        raise click.ClickException(run.status.reason)


def check_targets(report: str | None, save: str | None) -> None:
    """Refuse places that can't be written before the work, not after it."""
    if report and Path(report).suffix not in REPORTS:
        raise click.UsageError(f"--report {report}: give a name in {' or '.join(REPORTS)}")
    for target in (report, save):
        if target and not Path(target).absolute().parent.is_dir():
            raise click.ClickException(f"{Path(target).parent} does not exist; make it first")


def measured_furnace(path: Path) -> dict[str, Any]:
    """Return a scene's furnace from a CSV file or a bag.

    Raises
    ------
    BagError
        The bag holds no furnace, or misses the beginning of the fire.
    """
    if path.is_file() and path.suffix == ".csv":
        return {"curve": "measured", "file": str(path.absolute())}
    import numpy as np

    from ..bag import Bag, BagError

    bag = Bag(path)
    recorded = {t.name for t in bag.topics.values() if t.type == FURNACE_TYPE and t.count}
    topic = next((name for end in FURNACE_TOPICS for name in recorded if name.endswith(end)), None)
    if topic is None:
        raise BagError(f"{path} holds no {' or '.join(FURNACE_TOPICS)}; record one of them")
    time, temperature = bag.array(topic, "temperature", clock="stamp")
    if not (np.diff(time) > 0.0).any():  # a publisher that does not stamp
        time, temperature = bag.array(topic, "temperature")
    if time[0] > WALL_CLOCK:
        time = time - time[0]
    if time[0] > LATEST_START:
        raise BagError(f"{path}: {topic} begins at {time[0]:.0f} s of the fire; start recording before it")
    # A door that stands still says the same again and again.
    time, first = np.unique(time, return_index=True)
    return {"curve": "measured", "time": time, "temperature": temperature[first]}


def write(run: Run, report: str | None, save: str | None, about: Sequence[tuple[str, str]] = ()) -> None:
    """Write the report, with `about` in its table, and the arrays where they are asked for."""
    if report:
        from thermal_node.analysis.report import write_report

        write_report(run, report, about)
    if save:
        import numpy as np

        arrays: dict[str, Any] = {
            "time": run.time,
            "nodes": run.nodes,
            "temperature": run.temperature,
            "furnace": run.furnace,
            **{f"probe_{name}": values for name, values in run.probes.items()},
            **{f"reacted_{name}": values for name, values in run.reacted.items()},
        }
        for name in ("deflection", "bow", "gap"):
            value = getattr(run, name)
            if value is not None:
                arrays[name] = value
        with Path(save).open("wb") as file:  # numpy would add .npz to a name without it
            np.savez_compressed(file, **arrays)


def figures(run: Run, elapsed: float) -> dict[str, Any]:
    """Return what a run came to, in SI units and °C."""
    last = len(run.time) - 1
    return {
        "name": run.model.scene.name,
        "status": "ok" if run.status.ok else run.status.reason,
        "verdict": run.verdict,
        "simulated_time": float(run.time[last]) if last >= 0 else 0.0,
        "elapsed": elapsed,
        "samples": len(run.time),
        "steps": run.steps,
        "nodes": len(run.nodes),
        "criteria": [
            {
                "name": c.name,
                "unit": c.unit,
                "value": float(c.value),
                "limit": float(c.limit),
                "judged": c.watched,
                "failed": c.failed,
                "time_of_failure": c.time_of_failure,
                "clause": c.clause,
            }
            for c in run.criteria
        ],
        "furnace": float(run.furnace[last]) if last >= 0 else None,
        "probes": {name: float(v[last]) for name, v in run.probes.items()} if last >= 0 else {},
        "reacted": {name: float(v[last]) for name, v in run.reacted.items()} if last >= 0 else {},
        "bow": None if run.bow is None or last < 0 else float(run.bow[last]),
        "gap": None if run.gap is None or last < 0 else float(run.gap.max()),
        "support_forces": [vars(r) for r in run.shapes[max(run.shapes)].support_forces] if run.shapes else [],
        "utilisation": utilisation(run),
        "largest_imbalance": run.balance.worst,
        "furnace_tolerance": run.furnace_tolerance.broken if run.furnace_tolerance else None,
        "furnace_notes": list(getattr(run.model.furnace, "notes", ())),
    }


def utilisation(run: Run) -> dict[str, Any] | None:
    """Return where and when the leaf used most of its yield strength."""
    used = run.utilisation
    if used is None:
        return None
    from thermal_node.analysis.report import structure

    said = dict(structure(run))["largest use of the yield strength"]
    return vars(used) | {"time": run.utilisation_time, "said": said}


def print_figures(found: dict[str, Any]) -> None:
    """Print the table of criteria and the verdict."""
    rows: list[list[Any]] = []
    for c in found["criteria"]:
        factor, unit = (MILLIMETRES, "mm") if c["unit"] == "m" else (1.0, c["unit"])
        when = "holds" if c["judged"] else "not judged"
        if c["failed"]:
            when = f"{c['time_of_failure'] / MINUTE:.1f} min"
        value, limit = f"{factor * c['value']:.1f} {unit}", f"{factor * c['limit']:g} {unit}"
        rows.append([c["name"], value, limit, when])
    title = (
        f"{found['name']}: {found['simulated_time'] / MINUTE:g} min of fire in"
        f" {found['elapsed']:.1f} s, {found['nodes']} nodes, {found['steps']} steps"
    )
    print_table(title, ["criterion", "at the end", "limit", "failed"], rows)
    if found["bow"] is not None:
        bow, gap = MILLIMETRES * found["bow"], MILLIMETRES * found["gap"]
        click.echo(f"bow {bow:.1f} mm towards the fire, largest gap at an edge {gap:.1f} mm")
        borne = ", ".join(f"{r['name']} {r['force'] / KILO:.2f} kN" for r in found["support_forces"])
        click.echo(f"forces of the supports at the end, positive away from the fire: {borne}")
        if found["utilisation"]:
            click.echo(f"largest use of the yield strength: {found['utilisation']['said']}")
    for name, gone in found["reacted"].items():
        click.echo(f"{name}: {PERCENT * gone:.1f} % gone")
    for note in found["furnace_notes"]:
        click.echo(f"furnace's log: {note}")
    click.echo(f"verdict: {found['verdict']}")
    for what in ("report", "saved"):
        if found[what]:
            click.echo(f"{what}: {found[what]}")
