"""A run's report: curves against their limits, the verdict, what went in. HTML or Markdown.

HTML is one file with its pictures inside; Markdown has them beside it.
"""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from ruamel.yaml import YAML

from ..furnace.furnace import CURVES
from ..model.probes import InfraredView
from .simulate import Run


def write_report(run: Run, path: str | Path, about: Sequence[tuple[str, str]] = ()) -> Path:
    """Write the report of a run to `path`, which ends in .html or .md; the path.

    about : names and values that its table has besides the run's own, such as where its materials come from
    """
    target = Path(path)
    if target.suffix not in (".html", ".md"):
        raise ValueError(f"{target}: ends in {target.suffix!r}; give a name in .html or .md")
    target.parent.mkdir(parents=True, exist_ok=True)
    pictures = {name: _png(figure) for name, figure in _figures(run).items()}
    name = run.model.scene.name
    if target.suffix == ".md":
        for key, data in pictures.items():
            (target.parent / f"{target.stem}_{key}.png").write_bytes(data)
        target.write_text(_markdown(run, name, target.stem, list(pictures), about), encoding="utf-8")
        return target
    target.write_text(_html(run, name, pictures, about), encoding="utf-8")
    return target


def criteria_table(run: Run) -> list[tuple[str, str, str, str]]:
    """Rows: criterion, value at the end, limit, when it failed."""
    rows = []
    for c in run.criteria:
        factor, unit = (1e3, "mm") if c.unit == "m" else (1.0, c.unit)
        when = "holds" if c.watched else "not judged"
        if c.time_of_failure is not None:
            when = f"{c.time_of_failure / 60.0:.1f} min"
        rows.append((c.name, f"{factor * c.value:.1f} {unit}", f"{factor * c.limit:g} {unit}", when))
    return rows


def facts(run: Run) -> list[tuple[str, str]]:
    """What the run was, in pairs of a name and a value."""
    found = [
        ("duration", f"{run.time[-1] / 60.0:.0f} min" if len(run.time) else "0 min"),
        ("status", "ran to its end" if run.status.ok else run.status.reason),
        ("model", f"{run.model.scene.solver.model}, {len(run.nodes)} nodes, {run.steps} steps"),
        *_heat(run),
        *(
            (f"{name}, gone at the end", f"{100.0 * gone[-1]:.1f} %")
            for name, gone in run.reacted.items()
            if len(gone)
        ),
    ]
    tolerance = run.furnace_tolerance
    if tolerance is not None:
        said = tolerance.broken or f"kept; area off by {tolerance.deviation:.2f} %"
        found.append((f"furnace tolerance ({tolerance.rule.clause})", said))
    found += [("furnace's log", note) for note in getattr(run.model.furnace, "notes", ())]
    found += [(f"rule of {c.name}", c.clause) for c in run.criteria if c.clause]
    if run.bow is not None and run.gap is not None:
        found.append(("bow at the end", f"{1e3 * run.bow[-1]:.1f} mm towards the fire"))
        found.append(("largest gap at an edge", f"{1e3 * run.gap.max():.1f} mm"))
    return found + structure(run)


def _heat(run: Run) -> list[tuple[str, str]]:
    """Where the heat came from and went."""
    solver, b = run.model.scene.solver, run.balance
    if solver.model == "steady":
        return [("heat", "not summed: a steady state has none that comes or goes")]
    of = {"column": " for 1 m2 of the leaf", "column_rim": " for 1 m of its height"}.get(solver.dimension, "")
    found = [
        ("heat in through the exposed face", b.exposed),
        ("heat out through the unexposed face", -b.unexposed),
    ]
    if b.lateral:
        found.append(("heat in through the edge", b.lateral))
    if run.model.reactions is not None and len(run.model.reactions.kind):
        what = "given by what burns or" if b.released >= 0.0 else "taken by what evaporates or"
        found.append((f"heat {what} leaves", abs(b.released)))
    found.append(("heat stored", b.stored))
    said = [(name, f"{heat / 1e6:.3f} MJ{of}") for name, heat in found]
    return [*said, ("largest imbalance of a step", f"{b.worst:.1e} of the heat that crossed in it")]


def structure(run: Run) -> list[tuple[str, str]]:
    """What the supports bear and how near the leaf is to its yield strength: names and values."""
    if not run.shapes:
        return []
    last = max(run.shapes)
    found = []
    for r in run.shapes[last].support_forces:
        touching = "" if r.points is None else f", at {r.points} points of the mesh"
        found.append((f"{r.name} bears, at {last / 60.0:.0f} min", f"{r.force / 1e3:.2f} kN{touching}"))
    part = run.model.scene.deformation
    if part.opens is None:
        found.append(("frame's stop", "none: the scene does not say which way the leaf opens"))
    used, time = run.utilisation, run.utilisation_time
    if used is None or time is None:
        found.append(("use of the yield strength", "not computed: no material of the leaf has one"))
        return found
    elastic = part.yielding == "none" and used.share > 1.0
    word = "; it would yield, and the shape is that of a leaf that does not" if elastic else ""
    found.append(("largest use of the yield strength", f"at {time / 60.0:.0f} min {used}{word}"))
    return found


def _figures(run: Run) -> dict[str, Any]:
    from matplotlib.figure import Figure

    minutes = run.time / 60.0
    scene = run.model.scene
    figures: dict[str, Any] = {}

    figure = Figure(figsize=(8, 4), layout="constrained")
    axes = figure.add_subplot()
    axes.plot(minutes, run.furnace, color="black", label="furnace")
    if scene.furnace.curve in CURVES:
        standard = CURVES[scene.furnace.curve](run.time)
        axes.plot(minutes, standard, "--", color="grey", label=scene.furnace.curve)
    for name in ("exposed_centre", "interior_third", "interior_half", "interior_two_thirds"):
        if name in run.probes:
            axes.plot(minutes, run.probes[name], label=name.replace("_", " "))
    axes.set(xlabel="time, min", ylabel="temperature, °C", title="Furnace and leaf")
    axes.legend(fontsize=8)
    figures["furnace"] = figure

    figure = Figure(figsize=(8, 4), layout="constrained")
    axes = figure.add_subplot()
    for name, values in run.probes.items():
        if name.startswith(("tc_", "unexposed")) or name in scene.probes.points:
            wide = 2.5 if name.startswith("unexposed") else 1.0
            axes.plot(minutes, values, linewidth=wide, label=name.replace("_", " "))
    rises = [c for c in run.criteria if "temperature" in c.name]
    for c, style in zip(rises[:2], ("--", ":"), strict=False):
        axes.axhline(run.model.initial + c.limit, color="firebrick", linestyle=style, label=c.name)
    axes.set(xlabel="time, min", ylabel="temperature, °C", title="Unexposed face")
    axes.legend(fontsize=7, ncols=2)
    figures["unexposed"] = figure

    if len(run.temperature):
        figure = Figure(figsize=(3.6, 5), layout="constrained")
        axes = figure.add_subplot()
        image = InfraredView(run.model, 120).image(run.temperature[-1])
        shown = axes.imshow(
            image,
            cmap="inferno",
            extent=(
                scene.leaf.width / 2,
                -scene.leaf.width / 2,
                -scene.leaf.height / 2,
                scene.leaf.height / 2,
            ),
        )
        axes.set(xlabel="across, m", ylabel="up, m", title=f"Infrared, {minutes[-1]:.0f} min")
        figure.colorbar(shown, label="°C")
        figures["infrared"] = figure

    if run.reacted and len(minutes):
        figure = Figure(figsize=(8, 3), layout="constrained")
        axes = figure.add_subplot()
        for name, gone in run.reacted.items():
            axes.plot(minutes, 100.0 * gone, label=name)
        axes.set(xlabel="time, min", ylabel="gone, %", title="Reactions", ylim=(0.0, 102.0))
        axes.legend(fontsize=8)
        figures["reactions"] = figure

    if run.bow is not None and run.gap is not None:
        figure = Figure(figsize=(8, 3), layout="constrained")
        axes = figure.add_subplot()
        axes.plot(minutes, 1e3 * run.bow, label="bow towards the fire")
        axes.plot(minutes, 1e3 * run.gap, label="largest gap at an edge")
        axes.set(xlabel="time, min", ylabel="mm", title="Deformation")
        axes.legend(fontsize=8)
        figures["deformation"] = figure
    return figures


def _png(figure: Any) -> bytes:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    return buffer.getvalue()


def scene_text(run: Run) -> str:
    """The scene that was burnt, as YAML, with what was left out filled in."""
    out = io.StringIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = None
    yaml.width = 110
    plain = _plain(run.model.scene.model_dump(exclude_none=True, exclude={"source"}))
    yaml.dump(plain, out)
    return out.getvalue()


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _plain(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        if len(value) > 40:  # a log of its own
            return f"{len(value)} values from {value[0]} to {value[-1]}"
        return [_plain(v) for v in value]
    return float(value) if isinstance(value, np.floating) else value


def _markdown(run: Run, name: str, stem: str, pictures: list[str], about: Sequence[tuple[str, str]]) -> str:
    lines = [
        f"# {name}",
        "",
        f"**{run.verdict}**",
        "",
        "| criterion | at the end | limit | failed |",
    ]
    lines += ["|---|---|---|---|"]
    lines += [f"| {' | '.join(row)} |" for row in criteria_table(run)]
    lines += ["", "| | |", "|---|---|"] + [f"| {a} | {b} |" for a, b in (*facts(run), *about)] + [""]
    lines += [f"![{picture}]({stem}_{picture}.png)\n" for picture in pictures]
    lines += ["## Scene", "", "```yaml", scene_text(run).rstrip(), "```", ""]
    return "\n".join(lines)


def _html(run: Run, name: str, pictures: dict[str, bytes], about: Sequence[tuple[str, str]]) -> str:
    def table(rows: list[Any], head: tuple[str, ...] = ()) -> str:
        top = "".join(f"<th>{html.escape(h)}</th>" for h in head)
        body = "".join(
            "<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows
        )
        return f"<table><tr>{top}</tr>{body}</table>" if top else f"<table>{body}</table>"

    images = "".join(
        f'<img alt="{key}" src="data:image/png;base64,{base64.b64encode(data).decode()}">'
        for key, data in pictures.items()
    )
    title = html.escape(name)
    criteria = table(criteria_table(run), ("criterion", "at the end", "limit", "failed"))
    return f"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>{title}</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
body {{ font: 16px/1.5 sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }}
.verdict {{ font-size: 1.3rem; border-left: .4rem solid firebrick; padding: .5rem 1rem; }}
table {{ border-collapse: collapse; margin: 1rem 0; }}
td, th {{ border: 1px solid #ccc; padding: .2rem .6rem; text-align: left; }}
img {{ max-width: 100%; }} pre {{ background: #f4f4f4; padding: 1rem; overflow: auto; }}
</style></head><body>
<h1>{title}</h1><p class="verdict">{html.escape(run.verdict)}</p>
{criteria}{table([*facts(run), *about])}{images}
<h2>Scene</h2><pre>{html.escape(scene_text(run))}</pre>
</body></html>
"""
