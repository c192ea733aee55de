"""What a fit found, and what logs can tell before it, as tables and for programs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from ..terminal.report import print_json, print_table

if TYPE_CHECKING:
    from thermal_node import Scene
    from thermal_node.analysis.fitted import Fit
    from thermal_node.analysis.identifiability import Foreseen, Held

MINUTE, PERCENT = 60.0, 100.0


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
                "held": held(told.held),
            }
        )
        return
    rows: list[list[Any]] = [
        [name, f"{m:.1f} K", "not at all" if e > 1.0 else f"{PERCENT * e:.0f} %"]
        for name, e, m in zip(names, told.error, told.moved, strict=True)
    ]
    title = f"{logs}: {told.rank} of {len(names)} combinations of parameters can be told"
    print_table(title, ["parameter", "10 % of it move a reading by", "standard error at best"], rows)
    print_held(held(told.held))
    for note in told.notes:
        click.echo(f"note: {note}")


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
        "held": held(result.held),
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
    print_held(found["held"])
    for note in found["notes"]:
        click.echo(f"note: {note}")


def held(each: Sequence[Held]) -> list[dict[str, Any]]:
    """Return what a fit takes as the scene has it."""
    return [vars(one) | {"seen": one.seen} for one in each]


def print_held(each: list[dict[str, Any]]) -> None:
    """Print what a fit takes as the scene has it, and how far it moves the readings."""
    rows = [
        [
            one["name"],
            one["unit"],
            one["value"],
            "not varied" if one["moved"] is None else f"{one['moved']:.1f} K",
            "yes" if one["seen"] else "" if one["moved"] is None else "no",
        ]
        for one in each
    ]
    columns = ["held as the scene has it", "unit", "scene", "10 % of it move a reading by", "seen"]
    print_table("not fitted", columns, rows)


def fit_facts(result: Fit) -> list[tuple[str, str]]:
    """Return rows of a report's table: what was fitted and what was held."""
    fitted = [
        (f"fitted: {p.name}", f"{p.value:.4g} {p.unit} ({p.interval[0]:.4g} to {p.interval[1]:.4g})")
        for p in result.parameters
    ]
    taken = [
        (
            f"held: {one.name}",
            f"{one.value} {one.unit}"
            + ("" if one.moved is None else f"; 10 % of it move a reading by {one.moved:.1f} K"),
        )
        for one in result.held
    ]
    return fitted + taken


def fitted_material(result: Fit) -> tuple[str, dict[str, Any]]:
    """Return the name of the material that was fitted, and what the scene says of it now."""
    labels = [p.name for p in result.parameters]
    name = next(n for n in result.scene.materials if any(x.startswith(f"{n} ") for x in labels))
    return name, result.scene.materials[name].model_dump(exclude_none=True)


def same_make(larger: Scene, result: Fit) -> Scene:
    """Return the larger door with the fitted materials and rim contact in it."""
    from thermal_node.scene.load import changed

    name, part = fitted_material(result)
    given: dict[str, Any] = {f"materials.{name}": part}
    fitted_rim = result.scene.leaf.rim
    if larger.leaf.rim is not None and fitted_rim is not None:
        given["leaf.rim.contact"] = fitted_rim.contact
    return changed(larger, given)
