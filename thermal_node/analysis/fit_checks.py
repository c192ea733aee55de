"""Logs, doors and priors that can't be fitted: each is refused with what would be right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..furnace.thermocouple_log import ThermocoupleLog
from ..heat.conduction import Array
from ..scene.load import Scene, SceneError
from ..scene.parts import MaterialPart
from .fit_residual import LogResidual

LONGEST_LOG = 8 * 3600.0
"""s; a log read in other units is not believed to be longer."""


def one_make(scenes: Sequence[Scene], material: str) -> None:
    """Refuse doors whose material that is fitted is not the same to begin with."""
    first = scenes[0].materials.get(material)
    for other in scenes[1:]:
        part = other.materials.get(material)
        if part is None:
            raise SceneError(
                f"{other.source}: materials.{material}: is missing, and is fitted to {scenes[0].source};"
                " doors that are fitted together have it all"
            )
        off = [key for key in MaterialPart.model_fields if getattr(part, key) != getattr(first, key)]
        if off:
            raise SceneError(
                f"{other.source}: materials.{material}.{off[0]}: differs from that of {scenes[0].source};"
                " doors that are fitted together are of one material: give both the same"
            )


def each_test_once(logs: Sequence[ThermocoupleLog]) -> None:
    """Refuse a log that is there twice: its readings would count for two tests."""
    for n, log in enumerate(logs):
        for other in logs[:n]:
            if _alike(log, other):
                raise SceneError(
                    f"{log.source}: holds the readings of {other.source}; give each test once, or its"
                    " parameters seem better known than they are"
                )


def _alike(one: ThermocoupleLog, other: ThermocoupleLog) -> bool:
    return (
        np.array_equal(one.time, other.time)
        and one.readings.keys() == other.readings.keys()
        and all(np.array_equal(v, other.readings[n], equal_nan=True) for n, v in one.readings.items())
    )


def priors_fit(
    priors: Mapping[str, tuple[float, float]], labels: list[tuple[str, str, str]], low: Array, high: Array
) -> None:
    """Refuse priors of nothing that is fitted, or that can't be."""
    known = {key: (name, unit, a, b) for (key, name, unit), a, b in zip(labels, low, high, strict=True)}
    for key, (value, deviation) in priors.items():
        if key not in known:
            raise SceneError(f"prior: {key} is not fitted; give one of {', '.join(known)}")
        name, unit, a, b = known[key]
        if not (np.isfinite(value) and a <= value <= b):
            raise SceneError(f"prior: {key} is {value:g}; give {name} from {a:.3g} to {b:.3g} {unit}")
        if not (np.isfinite(deviation) and deviation > 0.0):
            raise SceneError(
                f"prior: {key} has a standard deviation of {deviation:g}; give more than 0 {unit}"
            )


def measured(log: ThermocoupleLog) -> None:
    """Refuse a log in which nothing was measured."""
    if len(log.time) < 2:
        raise SceneError(f"{log.source}: has {len(log.time)} rows; give two or more")
    empty = [name for name, values in log.readings.items() if not np.isfinite(values).any()]
    if len(empty) == len(log.readings):
        raise SceneError(
            f"{log.source}: {', '.join(empty) or 'no column'} holds no finite reading: nothing was measured;"
            " give degrees Celsius"
        )


def units_fit(residual: LogResidual, log: ThermocoupleLog, p0: Array) -> None:
    """Refuse a log that the scene explains in other units only."""
    plain = residual.as_if(p0, 1.0, 0.0, 1.0)
    readings = {
        "°F": (1.0, -32.0, 1.0 / 1.8),
        "K": (1.0, -273.15, 1.0),
        "minutes": (60.0, 0.0, 1.0),
        "hours": (3600.0, 0.0, 1.0),
        "minutes and °F": (60.0, -32.0, 1.0 / 1.8),
    }
    off = {
        name: residual.as_if(p0, *how)
        for name, how in readings.items()
        if how[0] * log.time[-1] <= LONGEST_LOG and (how[0] == 1.0 or log.time[-1] <= 600.0)
    }
    best = min(off, key=lambda name: off[name])
    if plain > 15.0 and off[best] < 0.4 * plain:
        raise SceneError(
            f"{log.source}: the scene explains it within {off[best]:.0f} K if it is read as {best}, and is"
            f" {plain:.0f} K off as °C and s; give °C and s, or the unit in the column's name (time_min)"
        )
