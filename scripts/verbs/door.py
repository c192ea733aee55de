"""`flexsim door`: fire doors offline, burnt and fitted."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from ..terminal.progress import Progress
from ..terminal.report import print_json, print_table
from ..terminal.setting import setting

if TYPE_CHECKING:
    from thermal_node import Run, Scene
    from thermal_node.analysis.fitted import Fit
    from thermal_node.analysis.identifiability import Foreseen

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
@click.option("--prior", "priors", multiple=True, metavar="KEY=VALUE±DEVIATION",
              help="Known beforehand: density=120±6, rim_contact=0.8+-0.1, conductivity_600=0.17±0.03;"
                   " may be repeated.")  # fmt: skip
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
    priors: tuple[str, ...],
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
    density and the rim's contact, each with its 95 % interval; before the fit it is said what the logs
    can't tell. SECONDS are those of the fire that is predicted.

    \b
    Example:
      flexsim door fit config/thesis_door.yaml LOG.csv
      flexsim door fit config/thesis_door.yaml LOG.csv --check
      flexsim door fit config/thesis_door.yaml A.csv B.csv --prior density=120±6 --leave-out tc_7
      flexsim door fit config/thesis_door.yaml LOG.csv --predict larger.yaml --report larger.html
    """
    check_targets(report, None)
    overrides = dict(map(setting, settings))

    from thermal_node import load_scene
    from thermal_node.analysis.fit import fit, foresee_fit
    from thermal_node.furnace.thermocouple_log import read_thermocouple_log

    loaded = load_scene(scene, overrides)
    larger = load_scene(predict) if predict else None
    known = dict(map(prior, priors))
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
            loaded, readings, material, not keep_rim, not keep_density, priors=known, leave=leave_out
        )
        print_foreseen(list(names), told, ", ".join(logs), as_json)
        return

    def say(note: str) -> None:
        click.echo(f"before the fit: {note}", err=True)

    result = fit(
        loaded,
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
        write(run, report, None)
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


def prior(given: str) -> tuple[str, tuple[float, float]]:
    """Return a prior's key, value and standard deviation from KEY=VALUE±DEVIATION."""
    key, equals, rest = given.partition("=")
    value, _, deviation = rest.replace("+-", "±").replace("+/-", "±").partition("±")
    try:
        if not equals:
            raise ValueError
        return key.strip(), (float(value), float(deviation))
    except ValueError:
        raise click.UsageError(f"--prior {given}: give KEY=VALUE±DEVIATION, such as density=120±6") from None


def print_foreseen(names: list[str], told: Foreseen, logs: str, as_json: bool) -> None:
    """Print what logs can tell of each parameter."""
    if as_json:
        print_json(
            {
                "log": logs,
                "parameters": [
                    {"name": name, "standard_error": float(e), "moved": float(m)}
                    for name, e, m in zip(names, told.error, told.moved, strict=True)
                ],
                "rank": told.rank,
                "condition": told.condition,
                "directions": told.directions.T.tolist(),
                "spread": told.spread.tolist(),
                "notes": list(told.notes),
            }
        )
        return
    rows: list[list[Any]] = [
        [name, f"{m:.1f} K", "not at all" if e > 1.0 else f"{PERCENT * e:.0f} %"]
        for name, e, m in zip(names, told.error, told.moved, strict=True)
    ]
    title = f"{logs}: {told.rank} of {len(names)} combinations of parameters can be told"
    print_table(title, ["parameter", "10 % of it move a reading by", "standard error at best"], rows)
    for note in told.notes:
        click.echo(f"note: {note}")


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


def same_make(larger: Scene, result: Fit) -> Scene:
    """Return the larger door with the fitted materials and rim contact in it."""
    from thermal_node.scene.load import changed

    name, part = fitted_material(result)
    given: dict[str, Any] = {f"materials.{name}": part}
    fitted_rim = result.scene.leaf.rim
    if larger.leaf.rim is not None and fitted_rim is not None:
        given["leaf.rim.contact"] = fitted_rim.contact
    return changed(larger, given)


def fitted_material(result: Fit) -> tuple[str, dict[str, Any]]:
    """Return the name of the material that was fitted, and what the scene says of it now."""
    labels = [p.name for p in result.parameters]
    name = next(n for n in result.scene.materials if any(x.startswith(f"{n} ") for x in labels))
    return name, result.scene.materials[name].model_dump(exclude_none=True)


def write(run: Run, report: str | None, save: str | None) -> None:
    """Write the report and the arrays where they are asked for."""
    if report:
        from thermal_node.analysis.report import write_report

        write_report(run, report)
    if save:
        import numpy as np

        arrays: dict[str, Any] = {
            "time": run.time,
            "nodes": run.nodes,
            "temperature": run.temperature,
            "furnace": run.furnace,
            **{f"probe_{name}": values for name, values in run.probes.items()},
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
    for note in found["furnace_notes"]:
        click.echo(f"furnace's log: {note}")
    click.echo(f"verdict: {found['verdict']}")
    for what in ("report", "saved"):
        if found[what]:
            click.echo(f"{what}: {found[what]}")


def estimates(result: Fit, elapsed: float) -> dict[str, Any]:
    """Return what a fit came to."""
    name, part = fitted_material(result)
    return {
        "parameters": [
            {
                "name": p.name,
                "unit": p.unit,
                "before": p.before,
                "value": p.value,
                "standard_error": p.standard_error,
                "interval": list(p.interval),
                "determined": p.determined,
                "key": p.key,
                "prior": p.prior,
            }
            for p in result.parameters
        ],
        "residuals": [vars(r) for r in result.residuals],
        "rms": result.rms,
        "rms_before": result.rms_before,
        "used": list(result.used),
        "evaluations": result.evaluations,
        "elapsed": elapsed,
        "notes": list(result.notes),
        "correlation": result.correlation.tolist(),
        "material": {name: part},
    }


def print_estimates(found: dict[str, Any]) -> None:
    """Print the table of estimates, and what to know of them."""
    rows = [
        [
            p["name"],
            p["unit"],
            f"{p['before']:.4g}",
            f"{p['value']:.4g}",
            f"{p['interval'][0]:.4g} to {p['interval'][1]:.4g}",
        ]
        for p in found["parameters"]
    ]
    work = f"{found['evaluations']} runs, {found['elapsed']:.0f} s"
    title = (
        f"{found['log']}: {len(found['used'])} thermocouples, {found['rms_before']:.2f} K off"
        f" before, {found['rms']:.2f} K after; {work}"
    )
    print_table(title, ["parameter", "unit", "scene", "fitted", "95 % interval"], rows)
    print_table(
        "model less reading, K",
        ["thermocouple", "readings", "rms", "mean", "worst", "at"],
        [
            [
                r["name"],
                f"{r['readings']}",
                f"{r['rms']:.2f}",
                f"{r['mean']:+.2f}",
                f"{r['worst']:+.2f}",
                f"{r['worst_time'] / MINUTE:.1f} min",
            ]
            for r in found["residuals"]
        ],
    )
    for note in found["notes"]:
        click.echo(f"note: {note}")
