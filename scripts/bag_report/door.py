"""The door's part of a report: its curves with the criteria's limits, and the verdict."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag, BagError
from ..figures.style import INK
from ..rerun_view import door_bag
from ..rerun_view.door import cold_temperature
from . import pictures
from .motion import Series, read
from .page import Section
from .reading import Reading

Array = NDArray[np.float64]
MINUTE, MILLIMETRES = 60.0, 1e3
LIMIT = (0.76, 0.27, 0.24)
DASHES = ("--", ":", "-.")
FIELDS = {
    door_bag.CRITERIA: ["criterion", "value", "limit", "failed", "time_of_failure", "verdict"],
    door_bag.THERMOCOUPLES: ["name", "temperature"],
    door_bag.TEMPERATURE: ["temperature"],
    door_bag.DEFLECTION: ["bow", "edge_name", "edge_gap"],
    door_bag.REACTIONS: ["material", "reaction", "degree"],
}


def has_door(bag: Bag) -> bool:
    """Say whether a bag holds a door."""
    return bool(topics(bag))


def topics(bag: Bag) -> dict[str, str]:
    """Return the door's topics by type."""
    return door_bag.topics(bag)


def fields(bag: Bag) -> dict[str, list[str]]:
    """Return what `door_part` needs of a bag: fields by topic."""
    return {topic: FIELDS[kind] for kind, topic in topics(bag).items() if kind in FIELDS}


def door_part(reading: Reading) -> tuple[list[Section], dict[str, Any]]:
    """Look at a bag's door; its sections, and figures for programs."""
    there = topics(reading.bag)
    figures: dict[str, Any] = {"verdict": None, "criteria": None, "thermocouples": None, "furnace": None,
                               "deflection": None, "reactions": None}  # fmt: skip

    def series(kind: str, section: Section, what: str) -> Series | None:
        if kind not in there:
            section.missing(f"{what}: the bag does not hold it.")
            return None
        try:
            return read(reading, there[kind], FIELDS[kind])
        except BagError as problem:
            section.missing(f"{what}: {problem}.")
            return None

    judged = Section("Verdict")
    criteria = series(door_bag.CRITERIA, judged, "Criteria and verdict (door/criteria)")
    curves = Section("Temperatures")
    wires = series(door_bag.THERMOCOUPLES, curves, "Thermocouples (door/thermocouples)")
    gas = series(door_bag.TEMPERATURE, curves, "Furnace (furnace/temperature)")
    bent = Section("Deformation")
    shape = series(door_bag.DEFLECTION, bent, "Deformation (door/deflection)")
    if criteria is not None:
        verdict(judged, figures, criteria)
    temperatures(curves, figures, wires, gas, criteria)
    if shape is not None:
        deformation(bent, figures, shape)
    sections = [judged, curves, bent]
    if door_bag.REACTIONS in there:  # of a door whose materials react
        sections.append(Section("Reactions"))
        gone = series(door_bag.REACTIONS, sections[-1], "Reactions (door/reactions)")
        if gone is not None:
            reactions(sections[-1], figures, gone)
    return sections, figures


def verdict(section: Section, figures: dict[str, Any], criteria: Series) -> None:
    """Say what the door is worth, and draw its criteria against their limits."""
    values = criteria.values
    names = list(values["criterion"][-1])
    value, limit, failed, when = (values[n][-1] for n in ("value", "limit", "failed", "time_of_failure"))
    figures["verdict"] = str(values["verdict"][-1])
    figures["duration"] = float(criteria.time[-1])
    figures["criteria"] = {
        name: {"value": float(value[k]), "limit": float(limit[k]), "failed": bool(failed[k]),
               "time_of_failure": float(when[k]) if failed[k] else None}
        for k, name in enumerate(names)
    }  # fmt: skip
    section.verdict(figures["verdict"])
    rows = []
    for k, name in enumerate(names):
        factor, unit = scale(name)
        told = f"{when[k] / MINUTE:.1f} min" if failed[k] else "holds"
        rows.append([name, f"{factor * value[k]:.1f} {unit}", f"{factor * limit[k]:g} {unit}", told])
    section.table(["criterion", "at the end", "limit", "failed"], rows)
    if np.asarray(values["value"]).ndim != 2:
        return

    def draw(axes: Any) -> None:
        share = values["value"] / np.where(values["limit"] != 0.0, values["limit"], np.nan)
        pictures.lines(axes, criteria.time / MINUTE, 100.0 * share, names)
        axes.axhline(100.0, color=LIMIT, linestyle="--", label="limit")
        axes.set(xlabel="time, min", ylabel="share of the limit, %", ylim=(0.0, None))

    section.picture(pictures.svg(draw, "Criteria against their limits"))


def scale(criterion: str) -> tuple[float, str]:
    """Return the factor and the unit in which a criterion is shown: rises in K, lengths in mm."""
    if "radiation" in criterion:
        return (1.0, "kW/m²")
    return (1.0, "K") if "temperature" in criterion else (MILLIMETRES, "mm")


def temperatures(
    section: Section, figures: dict[str, Any], wires: Series | None, gas: Series | None,
    criteria: Series | None,
) -> None:  # fmt: skip
    """Draw the furnace and the thermocouples, with the temperatures at which criteria fail."""
    if gas is not None:
        heat = np.asarray(gas.values["temperature"], dtype=float)
        figures["furnace"] = {"largest": float(heat.max()), "last": float(heat[-1])}
        minutes = gas.time / MINUTE
        section.picture(
            pictures.curves(
                "Furnace", minutes, heat[:, None], ["furnace"], "time, min", "temperature, °C", color=INK
            )
        )
    if wires is None:
        return
    names = list(wires.values["name"][0])
    readings = np.asarray(wires.values["temperature"], dtype=float)
    if readings.ndim != 2 or readings.shape[1] != len(names):
        section.missing("Thermocouples: their number changes within the bag.")
        return
    figures["thermocouples"] = {
        name: {"largest": float(readings[:, k].max()), "last": float(readings[-1, k])}
        for k, name in enumerate(names)
    }
    lines = limit_lines(names, wires, readings, criteria)
    figures["limit_temperatures"] = dict(lines)
    # What is on the fire's side or within would hide the unexposed face.
    outside = [k for k, name in enumerate(names) if not name.startswith(("exposed", "interior"))]
    inside = [k for k in range(len(names)) if k not in outside]
    for chosen, title in ((outside, "Unexposed face"), (inside, "Exposed face and within")):
        if not chosen:
            continue

        def draw(axes: Any, chosen: list[int] = chosen, title: str = title) -> None:
            labels = [names[k].replace("_", " ") for k in chosen]
            pictures.lines(axes, wires.time / MINUTE, readings[:, chosen], labels)
            for n, (name, limit) in enumerate(lines if chosen is outside else []):
                axes.axhline(limit, color=LIMIT, linestyle=DASHES[n % len(DASHES)], label=f"{name}: limit")
            axes.set(xlabel="time, min", ylabel="temperature, °C", title=title)

        section.picture(pictures.svg(draw, title, (9.0, 3.4)))


def limit_lines(
    names: list[str], wires: Series, readings: Array, criteria: Series | None
) -> list[tuple[str, float]]:
    """Return the temperatures, °C, at which criteria of temperature rise fail."""
    if criteria is None:
        return []
    judged = list(criteria.values["criterion"][0])
    both, i, k = np.intersect1d(wires.time, criteria.time, return_indices=True)
    if not len(both):
        return []
    cold = cold_temperature(names, readings[i[0]], judged, criteria.values["value"][k[0]])
    if cold is None:
        return []
    limit = criteria.values["limit"][-1]
    return [(name, cold + float(limit[n])) for n, name in enumerate(judged) if "temperature" in name]


def deformation(section: Section, figures: dict[str, Any], shape: Series) -> None:
    """Draw the bow and the gaps at the edges."""
    bow = MILLIMETRES * np.asarray(shape.values["bow"], dtype=float)
    gaps = MILLIMETRES * np.asarray(shape.values["edge_gap"], dtype=float)
    names = list(shape.values["edge_name"][0])
    figures["deflection"] = {
        "largest_bow": float(np.abs(bow).max()) / MILLIMETRES,
        "largest_gap": float(gaps.max()) / MILLIMETRES if gaps.size else None,
    }

    def draw(axes: Any) -> None:
        pictures.plot(axes, shape.time / MINUTE, bow, color=INK, label="bow")
        if gaps.ndim == 2:
            pictures.lines(axes, shape.time / MINUTE, gaps, [f"gap, {name}" for name in names])
        axes.set(xlabel="time, min", ylabel="mm")

    section.picture(pictures.svg(draw, "Bow and gaps"))


def reactions(section: Section, figures: dict[str, Any], gone: Series) -> None:
    """Draw how far the materials have reacted."""
    names = door_bag.reaction_names(gone.values)
    degree = np.asarray(gone.values["degree"], dtype=float)
    if degree.ndim != 2:
        section.missing("Reactions: their number changes within the bag.")
        return
    figures["reactions"] = {name: float(degree[-1, k]) for k, name in enumerate(names)}
    section.table(
        ["reaction", "gone at the end"],
        [[name, f"{100.0 * degree[-1, k]:.1f} %"] for k, name in enumerate(names)],
    )

    def draw(axes: Any) -> None:
        pictures.lines(axes, gone.time / MINUTE, 100.0 * degree, names)
        axes.set(xlabel="time, min", ylabel="gone, %", ylim=(0.0, 102.0))

    section.picture(pictures.svg(draw, "Reactions"))
