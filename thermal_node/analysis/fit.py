"""Materials from a fire test: what conductivity, density and rim does a door that was burnt have?

Least squares (Levenberg and Marquardt, logarithms of what must stay positive) between a test's
thermocouples and the model. Standard errors are those of the linearised problem, widened for
readings that are not independent: neighbours in a log err alike, so a log of n readings with a
lag-one correlation r tells as much as n (1 - r) / (1 + r) independent ones.

The fitted scene then predicts a door that no furnace holds, as IMO MSC.1/Circ.1319 recommends
for doors larger than the specimen.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from ..burning.march import Heat
from ..furnace.furnace import CURVES
from ..furnace.thermocouple_log import ThermocoupleLog
from ..heat.conduction import Array
from ..model.door_model import door_model
from ..model.probes import probes_of
from ..scene.load import Scene, SceneError, changed
from .simulate import Run, simulate

KNOWN_BELOW = 300.0
"""°C up to which the manufacturer's conductivity is taken as it is."""
CONTINUED_AT = (600.0, 1000.0)
"""°C of the points that are fitted where a scene's table ends at KNOWN_BELOW."""
UNCERTAIN = 0.5
"""Relative standard error from which on a parameter is called undetermined."""
IGNORANCE = 3.0
"""Standard deviation of a parameter's logarithm before anything is measured."""
WIDEST = 30.0
"""How many times as large or as small as in the scene a parameter may come out."""
OUTLIER = 3.0
"""Times the median of all thermocouples' residuals from which on one is named."""
LONGEST_LOG = 8 * 3600.0
"""s; a log read in other units is not believed to be longer."""
BETWEEN_ROWS = 2.0
"""s between the furnace temperatures that a log with longer rows is filled with."""
FITTING_MESH = {"in_plane": [12, 16], "symmetry": "quarter"}


@dataclass(frozen=True)
class FittedParameter:
    """One parameter: what it was, what it came out as, and its standard error."""

    name: str
    unit: str
    before: float
    value: float
    standard_error: float

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval; of a positive quantity, so symmetric in its logarithm."""
        spread = np.exp(1.96 * self.standard_error / self.value)
        return self.value / spread, self.value * spread

    @property
    def determined(self) -> bool:
        """Whether the log says anything about it."""
        return bool(self.standard_error < UNCERTAIN * self.value)


@dataclass(frozen=True)
class Fit:
    """A fitted scene.

    parameters; correlation (p, p) of their estimates; scene : the given one with them in it
    rms, rms_before : K, of the residual with the fitted and the given parameters
    each {name: K} : rms of each thermocouple's residual
    used : the thermocouples; evaluations : runs of the model; notes : what to know
    """

    scene: Scene
    parameters: tuple[FittedParameter, ...]
    correlation: Array
    rms: float
    rms_before: float
    used: tuple[str, ...]
    evaluations: int
    notes: tuple[str, ...]
    each: dict[str, float] = field(default_factory=dict)

    def predict(
        self, overrides: dict[str, Any], duration: float = 3600.0, sample_period: float = 60.0
    ) -> Run:
        """Burn another door of the same make, e.g. {"leaf.width": 2.0, "leaf.height": 3.0}.

        Its mesh keeps the size of the bricks rather than their number.
        """
        larger = changed(self.scene, overrides)
        if "mesh.in_plane" not in overrides:
            was, leaf = self.scene.leaf, larger.leaf
            nx, ny = self.scene.mesh.in_plane
            counts = [
                max(4, round(nx * leaf.width / was.width)),
                max(4, round(ny * leaf.height / was.height)),
            ]
            larger = changed(larger, {"mesh.in_plane": counts})
        return simulate(larger, duration, sample_period)


def fit(
    scene: Scene,
    log: ThermocoupleLog,
    material: str | None = None,
    rim: bool = True,
    density: bool = True,
    mesh: dict[str, Any] | None = None,
    progress: Callable[[int, float], None] | None = None,
) -> Fit:
    """Estimate the insulation's conductivity above 300 °C, its density and the rim's contact.

    scene : a door with probes that the log's columns are named after
    material : what is fitted; left out, the thickest layer's
    rim, density : whether those are fitted as well
    mesh : the mesh to begin on, coarser than the scene's; the last steps are on the scene's own,
        so that the mesh is not fitted along
    progress : told the number of runs and the residual, K, after each

    Raises
    ------
    SceneError
        Where no column is a probe, nothing was measured, the log's units are others than s and °C, or there
        is nothing to fit.
    """
    _measured(log)
    solid = [layer for layer in scene.leaf.layers if not layer.is_cavity]
    name = material or max(solid, key=lambda layer: layer.thickness).material
    part = scene.materials.get(name)
    if part is None or part.conductivity is None or part.density is None:
        raise SceneError(f"{scene.source}: materials.{name}: is not in the scene; give its table")
    temperature, value, free = _conductivity(scene, name)
    labels = [(f"{name} conductivity at {temperature[i]:g} °C", "W/(m K)") for i in free]
    start = [value[i] for i in free]
    if density:
        labels.append((f"{name} density", "kg/m3"))
        start.append(part.density)
    with_rim = rim and scene.leaf.rim is not None and scene.solver.dimension != "column"
    if with_rim:
        assert scene.leaf.rim is not None
        labels.append(("rim contact", "-"))
        start.append(min(max(scene.leaf.rim.contact, 1e-2), 1.0))

    base = scene
    if log.furnace is not None:
        furnace_time, furnace = _furnace(scene, log.time, log.furnace)
        base = changed(
            base,
            {
                "furnace": {
                    "curve": "measured",
                    "time": furnace_time,
                    "temperature": furnace,
                    "longest_gap": scene.furnace.longest_gap,
                }
            },
        )

    def overrides(values: Array) -> dict[str, Any]:
        conductivity = list(value)
        for i, v in zip(free, values, strict=False):
            conductivity[i] = float(v)
        made: dict[str, Any] = {
            f"materials.{name}.conductivity": {
                "temperature": temperature,
                "value": conductivity,
                "beyond": "hold",
            }
        }
        if density:
            made[f"materials.{name}.density"] = float(values[len(free)])
        if with_rim:
            made["leaf.rim.contact"] = float(min(values[-1], 1.0))
        return made

    coarse = changed(base, {f"mesh.{k}": v for k, v in (mesh or FITTING_MESH).items()})
    residual = _Residual(base, log, overrides, progress)
    quick = _Residual(coarse, log, overrides, progress)
    p0 = np.log(np.array(start))
    rim_only = np.array([label == "rim contact" for label, _ in labels])
    upper = np.exp(np.where(rim_only, 0.0, p0 + np.log(WIDEST)))
    lower = p0 - np.log(WIDEST)
    density_row = [label == f"{name} density" for label, _ in labels]
    lower[density_row] = np.maximum(lower[density_row], np.log(LEAST_DENSITY))
    _units_fit(quick, log, p0)
    before = residual(p0)
    settings: dict[str, Any] = {
        "bounds": (lower, np.log(upper) + 1e-9),
        "diff_step": 1e-3,
        "xtol": 1e-4,
        "ftol": 1e-5,
    }
    solved = least_squares(quick, np.minimum(p0, np.log(upper) - 1e-3), **settings)
    solved = least_squares(residual, solved.x, **settings)
    values = np.exp(solved.x)
    covariance = _covariance(solved.jac, solved.fun, residual.rows)
    error = values * np.sqrt(np.diag(covariance))
    scale = np.sqrt(np.diag(covariance))
    parameters = tuple(
        FittedParameter(label, unit, float(s), float(v), float(e))
        for (label, unit), s, v, e in zip(labels, start, values, error, strict=True)
    )
    notes = [
        f"{p.name} is not determined by this log ({p.standard_error / p.value:.0%} standard"
        " error): the wool was hardly that hot, or another parameter does the same"
        for p in parameters
        if not p.determined
    ]
    for p, low, high in zip(parameters, np.exp(lower), upper, strict=True):
        if not 1.001 * low < p.value < 0.999 * high and p.name != "rim contact":
            notes.append(
                f"{p.name} ran to the end of what it may be, {p.value:.3g} {p.unit}: not an estimate"
            )
    each = residual.each(solved.fun)
    usual = float(np.median(list(each.values())))
    notes += [
        f"{tc} is {rms:.1f} K off, the others {usual:.1f} K: look at how it sits"
        for tc, rms in each.items()
        if len(each) > 2 and rms > OUTLIER * max(usual, 0.5)
    ]
    notes += log.notes
    if with_rim and values[-1] > 0.999:
        notes.append("rim contact is at its end, 1: a full channel")
    return Fit(
        scene=changed(scene, overrides(values)),
        parameters=parameters,
        correlation=covariance / np.outer(scale, scale),
        rms=float(np.sqrt(np.mean(solved.fun**2))),
        rms_before=float(np.sqrt(np.mean(before**2))),
        used=residual.used,
        evaluations=quick.runs + residual.runs,
        notes=tuple(notes),
        each=each,
    )


LEAST_DENSITY = 1.0
"""kg/m3"""


def _measured(log: ThermocoupleLog) -> None:
    """Refuse a log in which nothing was measured."""
    if len(log.time) < 2:
        raise SceneError(f"log: has {len(log.time)} rows; give two or more")
    empty = [name for name, values in log.readings.items() if not np.isfinite(values).any()]
    if len(empty) == len(log.readings):
        raise SceneError(
            f"log: {', '.join(empty) or 'no column'} holds no finite reading: nothing was measured; give"
            " degrees Celsius"
        )


def _units_fit(residual: _Residual, log: ThermocoupleLog, p0: Array) -> None:
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
            f"log: the scene explains it within {off[best]:.0f} K if it is read as {best}, and is"
            f" {plain:.0f} K off as °C and s; give °C and s, or the unit in the column's name (time_min)"
        )


def _furnace(scene: Scene, time: Array, measured: Array) -> tuple[Array, Array]:
    """The furnace between the rows of a log: s, °C.

    A furnace that was to follow a standard curve is between two rows that curve and what it was off
    at the rows, straight; a straight line through ISO 834's first minute would be 90 K too low.
    """
    good = np.isfinite(measured)
    time, measured = time[good], measured[good]
    standard = CURVES.get(scene.furnace.curve)
    if standard is None or len(time) == 0:
        return time, measured
    off = measured - standard(time)
    if 0.0 < time[0] <= scene.furnace.longest_gap:
        time, off = np.append(0.0, time), np.append(0.0, off)
    bridged = np.flatnonzero(np.diff(time) <= scene.furnace.longest_gap)
    between = [np.arange(time[i], time[i + 1], BETWEEN_ROWS) for i in bridged]
    fine = np.union1d(time, np.concatenate(between)) if between else time
    return fine, standard(fine) + np.interp(fine, time, off)


def _conductivity(scene: Scene, name: str) -> tuple[list[float], list[float], list[int]]:
    """The table, continued where it ends early, and which of its values are free."""
    given = scene.materials[name].conductivity
    assert given is not None
    if given.temperature is None or given.value is None:
        if given.constant is None:
            raise SceneError(f"{scene.source}: materials.{name}: is Eurocode's; nothing to fit")
        return [KNOWN_BELOW, *CONTINUED_AT], [given.constant] * 3, [0, 1, 2]
    temperature, value = list(given.temperature), list(given.value)
    if temperature[-1] <= KNOWN_BELOW:
        slope = (value[-1] - value[-2]) / (temperature[-1] - temperature[-2])
        for t in CONTINUED_AT:
            value.append(max(value[-1] + slope * (t - temperature[-1]), 0.2 * value[-1]))
            temperature.append(t)
    return temperature, value, [i for i, t in enumerate(temperature) if t > KNOWN_BELOW]


class _Residual:
    """Model less log, K, over all thermocouples and times; infinite never."""

    def __init__(
        self,
        scene: Scene,
        log: ThermocoupleLog,
        overrides: Callable[[Array], dict[str, Any]],
        progress: Callable[[int, float], None] | None,
    ) -> None:
        self._scene, self._log, self._overrides = scene, log, overrides
        self._progress = progress
        self.runs = 0
        names = probes_of(door_model(scene)).name
        self.used = tuple(name for name in log.readings if name in names)
        if not self.used:
            raise SceneError(
                f"log: has columns {', '.join(log.readings)}, none of them a probe; give columns"
                f" named as the scene's probes, {', '.join(names[:6])}, ..."
            )
        self._columns = np.array([names.index(name) for name in self.used])
        self._measured = np.array([log.readings[name] for name in self.used])
        self._good = np.isfinite(self._measured) & (log.time >= 0.0)
        self.rows = [int(row.sum()) for row in self._good]

    def each(self, residual: Array) -> dict[str, float]:
        """Rms of each thermocouple's residual, K."""
        found, start = {}, 0
        for name, count in zip(self.used, self.rows, strict=True):
            if count:
                found[name] = float(np.sqrt(np.mean(residual[start : start + count] ** 2)))
            start += count
        return found

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

    def __call__(self, logarithms: Array) -> Array:
        scene = changed(self._scene, self._overrides(np.exp(logarithms)))
        model = door_model(scene)
        probes = probes_of(model)
        heat = Heat(model)
        found = np.full(self._measured.shape, model.initial)
        for k, time in enumerate(self._log.time):
            if time > 0.0:
                heat.advance(float(time))
            found[:, k] = probes.read(heat.temperature)[self._columns]
        self.runs += 1
        difference = found - self._measured
        out = np.concatenate([d[g] for d, g in zip(difference, self._good, strict=True)])
        if self._progress is not None:
            self._progress(self.runs, float(np.sqrt(np.mean(out**2))))
        return out


def _covariance(jacobian: Array, residual: Array, rows: list[int]) -> Array:
    """Covariance (p, p) of the parameters' logarithms, widened for correlated readings.

    What the log says nothing of keeps the spread of IGNORANCE instead of an infinite one.
    """
    freedom = max(len(residual) - jacobian.shape[1], 1)
    variance = float(residual @ residual) / freedom
    products, squares, start = 0.0, 1e-30, 0
    for count in rows:
        r = residual[start : start + count]
        products += float(r[1:] @ r[:-1])
        squares += float(r @ r)
        start += count
    correlation = min(max(products / squares, 0.0), 0.99)
    widened = max(variance * (1.0 + correlation) / (1.0 - correlation), 1e-12)
    information = jacobian.T @ jacobian / widened
    return np.asarray(np.linalg.inv(information + np.eye(len(information)) / IGNORANCE**2))
