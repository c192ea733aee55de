"""Materials from a fire test: what conductivity, density and rim does a door that was burnt have?

Least squares (Levenberg and Marquardt, logarithms of what must stay positive) between a test's
thermocouples and the model. Standard errors are those of the linearised problem, widened for
readings that are not independent: neighbours in a log err alike, so a log of n readings with a
lag-one correlation r tells as much as n (1 - r) / (1 + r) independent ones.

The fitted scene then predicts a door that no furnace holds, as IMO MSC.1/Circ.1319 recommends
for doors larger than the specimen.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from ..furnace.furnace import CURVES
from ..furnace.thermocouple_log import ThermocoupleLog
from ..heat.conduction import Array
from ..model.door_model import door_model
from ..scene.load import Scene, SceneError, changed
from .fit_checks import each_test_once, measured, one_make, priors_fit, units_fit
from .fit_residual import JointResidual, Overrides, Residuals
from .fitted import Fit, FittedParameter
from .held import Change, held_by
from .identifiability import Foreseen, Held, foresee

KNOWN_BELOW = 300.0
"""°C up to which the manufacturer's conductivity is taken as it is."""
CONTINUED_AT = (600.0, 1000.0)
"""°C of the points that are fitted where a scene's table ends at KNOWN_BELOW."""
IGNORANCE = 3.0
"""Standard deviation of a parameter's logarithm before anything is measured."""
WIDEST = 30.0
"""How many times as large or as small as in the scene a parameter may come out."""
OUTLIER = 3.0
"""Times the median of all thermocouples' residuals from which on one is named."""
LEAST_DENSITY = 1.0
"""kg/m3"""
AGAINST_PRIOR = 3.0
"""Standard deviations from its prior from which on a parameter is named."""
BETWEEN_ROWS = 2.0
"""s between the furnace temperatures that a log with longer rows is filled with."""
FITTING_MESH = {"in_plane": [12, 16], "symmetry": "quarter"}


def fit(
    scene: Scene | Sequence[Scene],
    log: ThermocoupleLog | Sequence[ThermocoupleLog],
    material: str | None = None,
    rim: bool = True,
    density: bool = True,
    mesh: dict[str, Any] | None = None,
    progress: Callable[[int, float], None] | None = None,
    priors: Mapping[str, tuple[float, float]] | None = None,
    leave: Sequence[str] = (),
    say: Callable[[str], None] | None = None,
) -> Fit:
    """Estimate the insulation's conductivity above 300 °C, its density and the rim's contact.

    Parameters
    ----------
    scene : a door with probes that the log's columns are named after; or one for each log: doors of one make,
        of several sizes
    log : of one test, or of several
    material : what is fitted; left out, the thickest layer's of the first door
    rim, density : whether those are fitted as well
    mesh : the mesh to begin on, coarser than the scene's; the last steps are on the scene's own,
        so that the mesh is not fitted along
    progress : told the number of runs and the residual, K, after each
    priors : what is known of parameters beforehand, {key: (value, standard deviation)}; keys are density,
        rim_contact and conductivity_600 for that at 600 °C
    leave : thermocouples that are not used
    say : told, before the fit, what the log can't tell

    Raises
    ------
    SceneError
        Where no column is a probe, nothing was measured, the log's units are others than s and °C, a log is
        there twice, a prior is of no parameter, doors differ in the material, or there is nothing to fit.
    """
    problem = _problem(scene, log, material, rim, density, mesh, progress, priors or {}, leave)
    foreseen = problem.foresee()
    if say is not None:
        for note in foreseen.notes:
            say(note)
    return problem.solve(foreseen)


def foresee_fit(
    scene: Scene | Sequence[Scene],
    log: ThermocoupleLog | Sequence[ThermocoupleLog],
    material: str | None = None,
    rim: bool = True,
    density: bool = True,
    mesh: dict[str, Any] | None = None,
    priors: Mapping[str, tuple[float, float]] | None = None,
    leave: Sequence[str] = (),
) -> tuple[tuple[str, ...], Foreseen]:
    """The parameters' names and what the log can tell of them, without a fit; arguments as fit()'s."""
    problem = _problem(scene, log, material, rim, density, mesh, None, priors or {}, leave)
    return tuple(name for _, name, _ in problem.labels), problem.foresee()


@dataclass
class _Problem:
    """A fit before it is solved.

    labels : key, name and unit of each parameter; start (p,) : the scene's values
    lower, upper (p,) : logarithms of the least and the most they may be
    scenes, overrides : of each log's door, and what of it the parameters are
    coarse : the doors in their furnaces on the mesh to begin on
    quick, residual : model less logs on that mesh, and on the scenes' own
    """

    scenes: list[Scene]
    coarse: list[Scene]
    logs: list[ThermocoupleLog]
    labels: list[tuple[str, str, str]]
    start: Array
    lower: Array
    upper: Array
    priors: Mapping[str, tuple[float, float]]
    overrides: list[Overrides]
    quick: JointResidual
    residual: JointResidual

    @property
    def names(self) -> list[str]:
        return [name for _, name, _ in self.labels]

    def _prior_rows(self, logarithms: Array) -> Array:
        """How many standard deviations each parameter with a prior is off it."""
        off = []
        for (key, _, _), x in zip(self.labels, logarithms, strict=True):
            if key in self.priors:
                value, deviation = self.priors[key]
                off.append((np.exp(x) - value) / deviation)
        return np.array(off)

    def _prior_information(self, values: Array) -> Array:
        """Of the priors on the logarithms, (p,)."""
        found = np.zeros(len(values))
        for k, (key, _, _) in enumerate(self.labels):
            if key in self.priors:
                found[k] = (values[k] / self.priors[key][1]) ** 2
        return found

    def foresee(self) -> Foreseen:
        """What the logs can tell."""
        start = np.minimum(np.log(self.start), self.upper)
        information = self._prior_information(self.start)
        told = foresee(self.quick, start, self.upper, self.names, information)
        held = self._held(start)
        return replace(told, held=held, notes=(*told.notes, *_seen(held)))

    def _held(self, start: Array) -> tuple[Held, ...]:
        """What is not fitted, and how far it moves the readings on the mesh to begin on."""
        values = np.exp(start)
        each: list[dict[str, Change]] = []
        for scene, of in zip(self.coarse, self.overrides, strict=True):
            found = held_by(scene, door_model(scene), of(values), KNOWN_BELOW)
            each.append({change.name: change for change in found})
        names = list(dict.fromkeys(name for one in each for name in one))
        varied = [name for name in names if any(name in one and one[name].overrides for one in each)]
        changes = [[one[name].overrides if name in one else {} for one in each] for name in varied]
        moved = dict(zip(varied, self.quick.moved(start, changes), strict=True))
        held = []
        for name in names:
            of_name = [one[name] for one in each if name in one]
            value = " / ".join(dict.fromkeys(change.value for change in of_name))
            held.append(Held(name, value, of_name[0].unit, moved.get(name)))
        return tuple(sorted(held, key=lambda h: -1.0 if h.moved is None else h.moved, reverse=True))

    def solve(self, foreseen: Foreseen) -> Fit:
        """The fit."""
        p0 = np.log(self.start)
        before = self.residual(p0)
        settings: dict[str, Any] = {
            "bounds": (self.lower, self.upper + 1e-9),
            "diff_step": 1e-3,
            "xtol": 1e-4,
            "ftol": 1e-5,
        }
        count = len(before)
        noise = 1.0

        def with_priors(of: JointResidual) -> Callable[[Array], Array]:
            # A prior's rows weigh as much as readings whose error is what the residual says it is.
            return lambda x: np.concatenate([of(x), noise * self._prior_rows(x)])

        first = least_squares(with_priors(self.quick), np.minimum(p0, self.upper - 1e-3), **settings)
        rows = self.residual.rows
        if self.priors:
            noise = float(np.sqrt(_widened(first.fun[:count], len(p0), rows)))
        solved = least_squares(with_priors(self.residual), first.x, **settings)
        values = np.exp(solved.x)
        information = self._prior_information(values)
        covariance = _covariance(solved.jac[:count], solved.fun[:count], rows, information)
        scale = np.sqrt(np.diag(covariance))
        parameters = tuple(
            FittedParameter(name, unit, float(s), float(v), float(v * e), key, self.priors.get(key))
            for (key, name, unit), s, v, e in zip(self.labels, self.start, values, scale, strict=True)
        )
        residual = solved.fun[:count]
        residuals = tuple(self.residual.each(residual))
        told = np.sqrt(np.diag(_covariance(solved.jac[:count], residual, rows, 0.0 * information)))
        return Fit(
            scene=changed(self.scenes[0], self.overrides[0](values)),
            scenes=tuple(changed(s, of(values)) for s, of in zip(self.scenes, self.overrides, strict=True)),
            parameters=parameters,
            correlation=covariance / np.outer(scale, scale),
            rms=float(np.sqrt(np.mean(residual**2))),
            rms_before=float(np.sqrt(np.mean(before**2))),
            used=self.residual.used,
            evaluations=self.quick.runs + self.residual.runs,
            notes=(
                *foreseen.notes,
                *self._notes(parameters, values, told),
                *_odd(residuals),
                *self._of_logs(),
            ),
            each={r.name: r.rms for r in residuals},
            residuals=residuals,
            foreseen=foreseen,
        )

    def _notes(self, parameters: tuple[FittedParameter, ...], values: Array, told: Array) -> list[str]:
        notes = [
            f"{p.name} is not determined by this log ({p.standard_error / p.value:.0%} standard"
            " error): the wool was hardly that hot, or another parameter does the same"
            for p in parameters
            if not p.determined
        ]
        ends = zip(parameters, np.exp(self.lower), np.exp(self.upper), told, strict=True)
        for p, low, high, alone in ends:
            if not 1.001 * low < p.value < 0.999 * high and p.key != "rim_contact":
                notes.append(
                    f"{p.name} ran to the end of what it may be, {p.value:.3g} {p.unit}: not an estimate"
                )
            if p.prior is None:
                continue
            value, deviation = p.prior
            if abs(p.value - value) > AGAINST_PRIOR * deviation:
                notes.append(
                    f"{p.name} came out {abs(p.value - value) / deviation:.1f} standard deviations from its"
                    f" prior, {value:g} {p.unit}: the two do not agree"
                )
            if alone > 2.0 * deviation / value:
                notes.append(f"{p.name} is known by its prior; the log says hardly more of it")
        if any(p.key == "rim_contact" and p.value > 0.999 for p in parameters):
            notes.append("rim contact is at its end, 1: a full channel")
        return notes

    def _of_logs(self) -> list[str]:
        return [
            note if len(self.logs) == 1 else f"{log.source}: {note}"
            for log in self.logs
            for note in log.notes
        ]


def _seen(held: tuple[Held, ...]) -> list[str]:
    """What is held although the readings tell of it."""
    seen = [f"{h.name} ({h.moved:.3g} K)" for h in held if h.seen]
    if not seen:
        return []
    return [
        f"held as the scene has it, and seen by the readings (10 % of it move one by): {', '.join(seen)};"
        " what is off there goes into the parameters, and their intervals do not cover it"
    ]


def _odd(residuals: tuple[Residuals, ...]) -> list[str]:
    """Thermocouples that are further off than the others, and readings off their neighbours."""
    usual = float(np.median([r.rms for r in residuals]))
    notes = [
        f"{r.name} is {r.rms:.1f} K off, the others {usual:.1f} K: look at how it sits, or leave it out"
        for r in residuals
        if len(residuals) > 2 and r.rms > OUTLIER * max(usual, 0.5)
    ]
    for r in residuals:
        if r.spikes:
            shown = ", ".join(f"{t:g}" for t in r.spikes[:3]) + (", ..." if len(r.spikes) > 3 else "")
            notes.append(f"{r.name} jumps away from its neighbours in time at {shown} s ({len(r.spikes)})")
    return notes


def _problem(
    scene: Scene | Sequence[Scene],
    log: ThermocoupleLog | Sequence[ThermocoupleLog],
    material: str | None,
    rim: bool,
    density: bool,
    mesh: dict[str, Any] | None,
    progress: Callable[[int, float], None] | None,
    priors: Mapping[str, tuple[float, float]],
    leave: Sequence[str],
) -> _Problem:
    given = [log] if isinstance(log, ThermocoupleLog) else list(log)
    if not given:
        raise SceneError("log: there is none; give one or more")
    scenes = [scene] * len(given) if isinstance(scene, Scene) else list(scene)
    if len(scenes) != len(given):
        raise SceneError(f"scenes: there are {len(scenes)} for {len(given)} logs; give one for each log")
    columns = {name for one in given for name in one.readings}
    for name in leave:
        if name not in columns:
            raise SceneError(f"log: has no column {name} to leave out; it has {', '.join(sorted(columns))}")
    logs = [replace(one, readings={n: v for n, v in one.readings.items() if n not in leave}) for one in given]
    for one in logs:
        measured(one)
    each_test_once(logs)
    first = scenes[0]
    solid = [layer for layer in first.leaf.layers if not layer.is_cavity]
    name = material or max(solid, key=lambda layer: layer.thickness).material
    part = first.materials.get(name)
    if part is None or part.conductivity is None or part.density is None:
        raise SceneError(f"{first.source}: materials.{name}: is not in the scene; give its table")
    one_make(scenes, name)
    temperature, value, free = _conductivity(first, name)
    labels = [
        (f"conductivity_{temperature[i]:g}", f"{name} conductivity at {temperature[i]:g} °C", "W/(m K)")
        for i in free
    ]
    start = [value[i] for i in free]
    if density:
        labels.append(("density", f"{name} density", "kg/m3"))
        start.append(part.density)
    rims = [s.leaf.rim if rim and s.solver.dimension != "column" else None for s in scenes]
    contact = next((r.contact for r in rims if r is not None), None)
    if contact is not None:
        labels.append(("rim_contact", "rim contact", "-"))
        start.append(min(max(contact, 1e-2), 1.0))
    if not labels:
        raise SceneError(f"{first.source}: nothing is free to be fitted; fit the density or the rim as well")

    def overrides(values: Array, with_rim: bool) -> dict[str, Any]:
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

    of: list[Overrides] = [partial(overrides, with_rim=r is not None) for r in rims]
    bases = [_in_its_furnace(s, one) for s, one in zip(scenes, logs, strict=True)]
    coarse = [changed(base, {f"mesh.{k}": v for k, v in (mesh or FITTING_MESH).items()}) for base in bases]
    p0 = np.log(np.array(start))
    keys = [key for key, _, _ in labels]
    lower = p0 - np.log(WIDEST)
    upper = np.where([key == "rim_contact" for key in keys], 0.0, p0 + np.log(WIDEST))
    dense = [key == "density" for key in keys]
    lower[dense] = np.maximum(lower[dense], np.log(LEAST_DENSITY))
    priors_fit(priors, labels, np.exp(lower), np.exp(upper))
    problem = _Problem(
        scenes=scenes,
        coarse=coarse,
        logs=logs,
        labels=labels,
        start=np.array(start),
        lower=lower,
        upper=upper,
        priors=priors,
        overrides=of,
        quick=JointResidual(coarse, logs, of, progress),
        residual=JointResidual(bases, logs, of, progress),
    )
    for one, quick in zip(logs, problem.quick.each_log, strict=True):
        units_fit(quick, one, p0)
    return problem


def _in_its_furnace(scene: Scene, log: ThermocoupleLog) -> Scene:
    """The scene with the furnace that a log measured, if it did."""
    if log.furnace is None:
        return scene
    time, temperature = _furnace(scene, log.time, log.furnace)
    gap = scene.furnace.longest_gap
    made = {"curve": "measured", "time": time, "temperature": temperature, "longest_gap": gap}
    return changed(scene, {"furnace": made})


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


def _widened(residual: Array, parameters: int, rows: list[int]) -> float:
    """Variance of a reading, K2, as if readings were independent: widened where neighbours err alike."""
    freedom = max(len(residual) - parameters, 1)
    variance = float(residual @ residual) / freedom
    products, squares, start = 0.0, 1e-30, 0
    for count in rows:
        r = residual[start : start + count]
        products += float(r[1:] @ r[:-1])
        squares += float(r @ r)
        start += count
    correlation = min(max(products / squares, 0.0), 0.99)
    return max(variance * (1.0 + correlation) / (1.0 - correlation), 1e-12)


def _covariance(jacobian: Array, residual: Array, rows: list[int], prior: Array) -> Array:
    """Covariance (p, p) of the parameters' logarithms, widened for correlated readings.

    prior (p,) : information that priors add. What nothing is known of keeps the spread of IGNORANCE instead
    of an infinite one.
    """
    information = jacobian.T @ jacobian / _widened(residual, jacobian.shape[1], rows)
    return np.asarray(np.linalg.inv(information + np.diag(prior + 1.0 / IGNORANCE**2)))
