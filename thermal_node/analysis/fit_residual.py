"""What a scene's model is off a test's log, thermocouple by thermocouple; of several logs in turn."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..burning.march import Heat
from ..furnace.thermocouple_log import ThermocoupleLog
from ..heat.conduction import Array
from ..model.door_model import door_model
from ..model.probes import probes_of
from ..scene.load import Scene, SceneError, changed

SPIKE, LEAST_SPIKE = 8.0, 5.0
"""Times the median deviation of a thermocouple's residual from its neighbours in time, and K at least, from
which on a reading is named."""


@dataclass(frozen=True)
class Residuals:
    """Of one thermocouple: model less reading.

    rms, mean : K; worst : K, and worst_time : s, where it is largest; readings : how many
    spikes : s of readings that jump away from those before and after them
    """

    name: str
    rms: float
    mean: float
    worst: float
    worst_time: float
    readings: int
    spikes: tuple[float, ...] = ()


Overrides = Callable[[Array], dict[str, Any]]
"""Keys of a scene from values of the parameters (p,)."""


class LogResidual:
    """Model less log, K, over all thermocouples and times of one log."""

    def __init__(
        self,
        scene: Scene,
        log: ThermocoupleLog,
        overrides: Overrides,
        title: str = "",
    ) -> None:
        self._scene, self._log, self._overrides = scene, log, overrides
        names = probes_of(door_model(scene)).name
        found = tuple(name for name in log.readings if name in names)
        if not found:
            raise SceneError(
                f"{log.source}: has columns {', '.join(log.readings)}, none of them a probe; give columns"
                f" named as the scene's probes, {', '.join(names[:6])}, ..."
            )
        self._columns = np.array([names.index(name) for name in found])
        self._measured = np.array([log.readings[name] for name in found])
        self._good = np.isfinite(self._measured) & (log.time >= 0.0)
        self.used = tuple(f"{title}{name}" for name in found)
        self.rows = [int(row.sum()) for row in self._good]

    def __call__(self, logarithms: Array, besides: Mapping[str, Any] | None = None) -> Array:
        """Residuals with the parameters' logarithms; besides : keys of the scene that are changed as well."""
        keys = self._overrides(np.exp(logarithms)) | dict(besides or {})
        model = door_model(changed(self._scene, keys))
        probes = probes_of(model)
        heat = Heat(model)
        found = np.full(self._measured.shape, model.initial)
        for k, time in enumerate(self._log.time):
            if time > 0.0:
                heat.advance(float(time))
            found[:, k] = probes.read(heat.temperature)[self._columns]
        difference = found - self._measured
        return np.concatenate([d[g] for d, g in zip(difference, self._good, strict=True)])

    def as_if(self, logarithms: Array, times: float, shift: float, factor: float) -> float:
        """Rms of the residual, K, if the log's times and readings were these many s and °C."""
        heat = Heat(door_model(changed(self._scene, self._overrides(np.exp(logarithms)))))
        probes = probes_of(heat.model)
        found = []
        for time in self._log.time:
            if time > 0.0 and not heat.advance(float(times * time)).ok:
                break
            found.append(probes.read(heat.temperature)[self._columns])
        measured = factor * (self._measured[:, : len(found)] + shift)
        good = self._good[:, : len(found)]
        if not good.any():
            return np.inf
        return float(np.sqrt(np.mean((np.array(found).T - measured)[good] ** 2)))

    def each(self, residual: Array) -> list[Residuals]:
        """Of each thermocouple that read anything."""
        found, start = [], 0
        for name, good, count in zip(self.used, self._good, self.rows, strict=True):
            r, time = residual[start : start + count], self._log.time[good]
            start += count
            if count == 0:
                continue
            worst = int(np.argmax(np.abs(r)))
            found.append(
                Residuals(
                    name,
                    float(np.sqrt(np.mean(r**2))),
                    float(np.mean(r)),
                    float(r[worst]),
                    float(time[worst]),
                    count,
                    tuple(float(t) for t in time[_spikes(r)]),
                )
            )
        return found


class JointResidual:
    """Of several logs, each of a door with a scene of its own."""

    def __init__(
        self,
        scenes: Sequence[Scene],
        logs: Sequence[ThermocoupleLog],
        overrides: Sequence[Overrides],
        progress: Callable[[int, float], None] | None,
    ) -> None:
        titles = [""] if len(logs) == 1 else _titles(logs)
        self.each_log = [
            LogResidual(scene, log, of, title)
            for scene, log, of, title in zip(scenes, logs, overrides, titles, strict=True)
        ]
        self._progress = progress
        self.runs = 0

    @property
    def used(self) -> tuple[str, ...]:
        """Names of the thermocouples."""
        return tuple(name for one in self.each_log for name in one.used)

    @property
    def rows(self) -> list[int]:
        """How many readings each thermocouple has."""
        return [count for one in self.each_log for count in one.rows]

    def __call__(self, logarithms: Array) -> Array:
        out = np.concatenate([one(logarithms) for one in self.each_log])
        self.runs += len(self.each_log)
        if self._progress is not None:
            self._progress(self.runs, float(np.sqrt(np.mean(out**2))))
        return out

    def moved(self, logarithms: Array, changes: Sequence[Sequence[Mapping[str, Any]]]) -> list[float | None]:
        """K, the most that any reading moves by each change: keys for each log's scene.

        None where a scene refuses the change.
        """
        base = [one(logarithms) for one in self.each_log]
        self.runs += len(self.each_log)
        found: list[float | None] = []
        for change in changes:
            pairs = zip(self.each_log, change, base, strict=True)
            try:
                off = [np.abs(one(logarithms, keys) - b) for one, keys, b in pairs if keys]
            except SceneError:
                found.append(None)
                continue
            self.runs += len(off)
            found.append(float(np.concatenate(off).max(initial=0.0)))
        return found

    def each(self, residual: Array) -> list[Residuals]:
        """Of each thermocouple of each log."""
        found, start = [], 0
        for one in self.each_log:
            count = sum(one.rows)
            found += one.each(residual[start : start + count])
            start += count
        return found


def _titles(logs: Sequence[ThermocoupleLog]) -> list[str]:
    stems = [Path(log.source).stem for log in logs]
    if len(set(stems)) < len(stems):
        stems = [f"log {n}" for n in range(1, len(logs) + 1)]
    return [f"{stem}: " for stem in stems]


def _spikes(residual: Array) -> NDArray[np.int64]:
    """Indices of values that jump away from the middle of their neighbours."""
    if len(residual) < 7:
        return np.zeros(0, dtype=int)
    off = residual.copy()
    off[1:-1] -= np.median(np.stack([residual[:-2], residual[1:-1], residual[2:]]), axis=0)
    off[0] -= residual[1]
    off[-1] -= residual[-2]
    usual = float(np.median(np.abs(residual[1:] - residual[:-1])))
    return np.flatnonzero(np.abs(off) > max(SPIKE * usual, LEAST_SPIKE))
