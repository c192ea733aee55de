"""A whole test, offline: as fast as it goes, sampled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from ..burning.march import Heat, HeatBalance, Saved
from ..burning.status import State, Status
from ..burning.steady import steady_state
from ..criteria.criteria import Criteria
from ..criteria.criterion import Criterion
from ..criteria.tolerance import FurnaceTolerance
from ..deformation.deflection import Deflection, Utilisation
from ..furnace.furnace import Measured
from ..furnace.tabled import Table
from ..heat.conduction import Array
from ..model.door_model import DoorModel, door_model
from ..model.probes import Radiometer, probes_of, unexposed_maximum, unexposed_mean
from ..model.reacted import Reacted
from ..scene.load import Scene, SceneError

if TYPE_CHECKING:
    from ..deformation.leaf import Deformation

MOST_SAMPLES = 1_000_000
REFINED, CLOSE = 6, 1.0
"""Shapes that are solved at most to find when a gap opened, and s to which it is found."""


@dataclass
class Run:
    """What a simulated test gave.

    Attributes
    ----------
    time (K,) : s
    nodes (N, 3) : m, x across the width, y up, both from the centre, z from the exposed face
    temperature (K, N), furnace (K,) : °C
    probes {name: (K,)} : °C; besides the scene's, `unexposed_mean` and `unexposed_maximum`
    reacted {`material: reaction`: (K,)} : share of each reaction that has gone, 0 to 1, the mean over its
        material's mass in the leaf
    deflection (K, N, 3), bow (K,), gap (K,), or None : m, where the scene asks for a
        deformation; solved every `deformation.interval` s and straight between
    status : whether it ran to its end, and if not why
    criteria, verdict : how the door stands, in numbers and in words
    balance : heat stored, in and out; steps : time steps taken
    furnace_tolerance : how well the furnace kept to the curve of the foremost standard
    shapes {s: Deflection} : every shape that was solved, with what its supports bear
    """

    model: DoorModel
    time: Array
    nodes: Array
    temperature: Array
    furnace: Array
    probes: dict[str, Array]
    status: Status
    criteria: list[Criterion]
    verdict: str
    balance: HeatBalance
    steps: int = 0
    reacted: dict[str, Array] = field(default_factory=dict)
    deflection: Array | None = None
    bow: Array | None = None
    gap: Array | None = None
    furnace_tolerance: FurnaceTolerance | None = None
    work: dict[str, int] = field(default_factory=dict)
    shapes: dict[float, Deflection] = field(default_factory=dict)

    @property
    def utilisation_time(self) -> float | None:
        """s at which the leaf used most of its yield strength."""
        used = {t: s.utilisation.share for t, s in self.shapes.items() if s.utilisation is not None}
        return max(used, key=lambda t: used[t]) if used else None

    @property
    def utilisation(self) -> Utilisation | None:
        """Where the leaf used most of its yield strength."""
        time = self.utilisation_time
        return None if time is None else self.shapes[time].utilisation


def simulate(
    scene: Scene,
    duration: float = 3600.0,
    sample_period: float = 60.0,
    progress: Callable[[float], None] | None = None,
) -> Run:
    """Burn a door for `duration` s and sample it every `sample_period` s.

    A steady scene gives one sample: the state in balance with the furnace at `duration`.
    A run that has to stop gives the samples until then, and says why in `status`.

    Raises
    ------
    SceneError
        Where the furnace's log can't be used, or ends before the test does.
    """
    _possible(duration, sample_period)
    model = door_model(scene)
    _log_lasts(model, duration)
    steady = scene.solver.model == "steady"
    heat = steady_state(model, duration) if steady else Heat(model)
    probes, radiometer, reacted = probes_of(model), Radiometer(model), Reacted(model)
    criteria = Criteria(scene.criteria, probes, model.initial)
    times = np.array([duration]) if steady else sample_times(duration, sample_period)

    def look() -> None:
        criteria.watch(heat.time, probes.read(heat.temperature), radiometer.read(heat.temperature))
        criteria.watch_furnace(heat.time, heat.furnace)

    look()
    samples: list[tuple[Array, Array, float]] = []
    gone: list[Array] = []
    bent = scene.deformation.model != "none" and not steady
    saved: dict[float, Saved] = {}
    for time in times:
        if not (heat.status if steady else heat.advance(float(time), look)).ok:
            break
        samples.append(
            (heat.temperature.copy(), probes.read(heat.temperature), float(heat.furnace(float(time))))
        )
        gone.append(reacted.read(heat.degree))
        if bent and (not saved or time - max(saved) > scene.deformation.interval - 1e-6):
            saved[float(time)] = heat.save()
        if progress is not None:
            progress(float(time))
    kept = len(samples)
    shape, unsettled = _deflections(model, times[:kept], samples, saved, criteria)
    if unsettled:
        kept = len(shape.bow) if shape is not None else 0
        samples = samples[:kept]
    temperature = np.array([s[0] for s in samples]).reshape(kept, len(heat.temperature))
    read = np.array([s[1] for s in samples]).reshape(kept, len(probes.name))
    named = {name: read[:, i] for i, name in enumerate(probes.name)}
    named["unexposed_mean"] = np.array([unexposed_mean(model, t) for t in temperature])
    named["unexposed_maximum"] = np.array([unexposed_maximum(model, t) for t in temperature])
    run = Run(
        model=model,
        time=times[:kept],
        nodes=model.nodes,
        temperature=temperature,
        furnace=np.array([s[2] for s in samples]),
        probes=named,
        status=Status(State.NOT_CONVERGED, unsettled) if unsettled else heat.status,
        criteria=criteria.each,
        verdict="",
        balance=heat.balance,
        steps=heat.steps,
        reacted={
            f"{material}: {reaction}": np.array([each[r] for each in gone[:kept]])
            for r, (material, reaction) in enumerate(reacted.name)
        },
        deflection=None if shape is None else shape.displacement,
        bow=None if shape is None else shape.bow,
        gap=None if shape is None else shape.gap,
        shapes={} if shape is None else shape.solved,
        furnace_tolerance=criteria.judgements[0].tolerance,
        work={
            "steps": heat.steps,
            "rejected": heat.rejected,
            "evaluations": int(heat.count[0]),
            "linear_iterations": int(heat.count[1]),
        },
    )
    run.verdict = criteria.verdict("" if run.status.ok else run.status.reason)
    if steady:
        run.verdict = steady_words(criteria, run)
    if unsettled:
        run.verdict = f"no class: {unsettled}"
    return run


def sample_times(duration: float, sample_period: float) -> Array:
    """Times of a run's samples, s: every period, and the end."""
    times: Array = sample_period * np.arange(int(np.floor(duration / sample_period + 1e-9)) + 1, dtype=float)
    if duration - times[-1] > 1e-9 * duration:
        times = np.append(times, duration)
    return times


def steady_words(criteria: Criteria, run: Run) -> str:
    """What a steady state is worth: no test has it, so no class."""
    if not run.status.ok:
        return f"no class: {run.status.reason}"
    values = ", ".join(f"{c.name} {c.value:.0f} {c.unit}" for c in criteria.each if c.watched)
    return f"no class: a steady state is no fire test; {values}"


def _possible(duration: float, sample_period: float) -> None:
    for name, value, least in (
        ("duration", duration, "at least 0"),
        ("sample_period", sample_period, "more than 0"),
    ):
        bad = not np.isfinite(value) or value < 0.0 or (value == 0.0 and name == "sample_period")
        if bad:
            raise ValueError(f"{name} is {value!r}; give {least} s")
    if duration / sample_period > MOST_SAMPLES:
        raise ValueError(
            f"sample_period is {sample_period:g} s for a duration of {duration:g} s:"
            f" {duration / sample_period:.3g} samples, each of every node; give at least"
            f" {duration / MOST_SAMPLES:.3g} s"
        )


def _log_lasts(model: DoorModel, duration: float) -> None:
    """Refuse a test that outlasts a table, or the furnace's log and what may be bridged of it."""
    faces = ("exposed", "unexposed", "lateral")
    tables: dict[str, object] = {"furnace": model.furnace}
    tables["furnace: radiation"] = model.radiation.table if model.radiation is not None else None
    tables.update({f"{face}: flux": flux for face, flux in zip(faces, model.flux, strict=True)})
    for where, one in tables.items():
        if isinstance(one, Table) and duration > one.end * (1.0 + 1e-9):
            raise SceneError(
                f"{model.scene.source}: {where}: its table ends at {one.end:g} s, the test lasts"
                f" {duration:g} s; give values to {duration:g} s, or a shorter test"
            )
    furnace, gap = model.furnace, model.scene.furnace.longest_gap
    if isinstance(furnace, Measured) and duration > furnace.time[-1] + gap:
        raise SceneError(
            f"{model.scene.source}: furnace: its log ends at {furnace.time[-1]:g} s, the test lasts"
            f" {duration:g} s; give a longer log, or a test of at most {furnace.time[-1] + gap:g} s"
        )


@dataclass(frozen=True)
class _Shapes:
    """displacement (K, N, 3), bow (K,), gap (K,), m, at the samples; the shapes that were solved, by s."""

    displacement: Array
    bow: Array
    gap: Array
    solved: dict[float, Deflection]


def _deflections(
    model: DoorModel,
    times: Array,
    samples: list[tuple[Array, Array, float]],
    saved: dict[float, Saved],
    criteria: Criteria,
) -> tuple[_Shapes | None, str]:
    """Shapes at the samples, where the scene asks for them; and why they end before, if they do."""
    part = model.scene.deformation
    if part.model == "none" or not samples:
        return None, ""
    from ..deformation.leaf import Deformation
    from ..deformation.unilateral import Unsettled

    deformation = Deformation(model)
    last = len(times) - 1
    shapes: dict[float, Deflection] = {}
    unsettled = ""
    for k in (k for k, time in enumerate(times) if k == last or float(time) in saved):
        try:
            shapes[float(times[k])] = deformation.solve(samples[k][0], _earlier(shapes, float(times[k])))
        except Unsettled as problem:
            unsettled = f"no shape at {times[k]:g} s: {problem}"
            break
    if not shapes:
        return None, unsettled
    times = times[times <= max(shapes)]
    if saved and not unsettled:
        shapes = _openings(model, deformation, saved, shapes, criteria)
    at = np.array(sorted(shapes))
    each = [shapes[t] for t in at]
    for t, shape in zip(at, each, strict=True):
        criteria.watch_deflection(float(t), shape)
    bow = np.interp(times, at, [s.bow for s in each])
    gap = np.interp(times, at, [s.gap for s in each])
    displacement = np.empty((len(times), *each[0].displacement.shape))
    for k, time in enumerate(times):
        i = min(int(np.searchsorted(at, time, side="right")) - 1, len(at) - 1)
        j = min(i + 1, len(at) - 1)
        span = at[j] - at[i]
        share = (time - at[i]) / span if span > 0.0 else 0.0
        displacement[k] = (1.0 - share) * each[i].displacement + share * each[j].displacement
    return _Shapes(displacement, bow, gap, dict(zip(at.tolist(), each, strict=True))), unsettled


def _earlier(shapes: dict[float, Deflection], time: float) -> Deflection | None:
    """The last shape before a time, s, from which a leaf that yields goes on."""
    before = [t for t in shapes if t < time]
    return shapes[max(before)] if before else None


def _openings(
    model: DoorModel,
    deformation: Deformation,
    saved: dict[float, Saved],
    shapes: dict[float, Deflection],
    criteria: Criteria,
) -> dict[float, Deflection]:
    """Shapes around the moments at which gaps and deflections pass their limits.

    Found by marching on from the states that were saved, so that they do not depend on where samples lie.
    """
    heat = Heat(model)
    found, states = dict(shapes), dict(saved)

    def excess(time: float) -> Array:
        if time not in found:
            heat.restore(states[max(t for t in states if t < time)])
            heat.advance(time)
            states[time] = heat.save()
            found[time] = deformation.solve(heat.temperature, _earlier(found, time))
        return criteria.excess(time, found[time])

    for k in range(len(criteria.excess(min(shapes), shapes[min(shapes)]))):
        at = sorted(found)
        over = [float(excess(t)[k]) > 0.0 for t in at]
        first = next((i for i in range(1, len(at)) if over[i] and not over[i - 1]), None)
        if first is not None and at[first] - at[first - 1] > CLOSE:
            brentq(
                lambda time, k=k: float(excess(float(time))[k]),
                at[first - 1], at[first], xtol=CLOSE, maxiter=REFINED, disp=False,
            )  # fmt: skip
    return found
