"""A whole test, offline: as fast as it goes, sampled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from .conduction import Array
from .criteria import Criteria
from .criterion import Criterion
from .deformation.deflection import Deflection
from .furnace import Measured
from .heat import Heat, HeatBalance
from .model import DoorModel, door_model
from .probes import Radiometer, probes_of, unexposed_maximum, unexposed_mean
from .scene import Scene, SceneError
from .status import Status
from .steady import steady_state
from .tolerance import FurnaceTolerance

if TYPE_CHECKING:
    from .deformation.leaf import Deformation

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
    deflection (K, N, 3), bow (K,), gap (K,), or None : m, where the scene asks for a
        deformation; solved every `deformation.interval` s and straight between
    status : whether it ran to its end, and if not why
    criteria, verdict : how the door stands, in numbers and in words
    balance : heat stored, in and out; steps : time steps taken
    furnace_tolerance : how well the furnace kept to the curve of the foremost standard
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
    deflection: Array | None = None
    bow: Array | None = None
    gap: Array | None = None
    furnace_tolerance: FurnaceTolerance | None = None
    work: dict[str, int] = field(default_factory=dict)


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
    probes, radiometer = probes_of(model), Radiometer(model)
    criteria = Criteria(scene.criteria, probes, model.initial)
    times = np.array([duration]) if steady else sample_times(duration, sample_period)

    def look() -> None:
        criteria.watch(heat.time, probes.read(heat.temperature), radiometer.read(heat.temperature))
        criteria.watch_furnace(heat.time, heat.furnace)

    look()
    samples: list[tuple[Array, Array, float]] = []
    for time in times:
        if not (heat.status if steady else heat.advance(float(time), look)).ok:
            break
        samples.append(
            (heat.temperature.copy(), probes.read(heat.temperature), float(heat.furnace(float(time))))
        )
        if progress is not None:
            progress(float(time))
    kept = len(samples)
    shape = _deflections(model, times[:kept], samples, criteria)
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
        status=heat.status,
        criteria=criteria.each,
        verdict="",
        balance=heat.balance,
        steps=heat.steps,
        deflection=None if shape is None else shape[0],
        bow=None if shape is None else shape[1],
        gap=None if shape is None else shape[2],
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
    """Refuse a test that is longer than the measured furnace's log and what may be bridged."""
    furnace, gap = model.furnace, model.scene.furnace.longest_gap
    if isinstance(furnace, Measured) and duration > furnace.time[-1] + gap:
        raise SceneError(
            f"{model.scene.source}: furnace: its log ends at {furnace.time[-1]:g} s, the test lasts"
            f" {duration:g} s; give a longer log, or a test of at most {furnace.time[-1] + gap:g} s"
        )


def _deflections(
    model: DoorModel,
    times: Array,
    samples: list[tuple[Array, Array, float]],
    criteria: Criteria,
) -> tuple[Array, Array, Array] | None:
    """Displacement (K, N, 3), bow (K,) and gap (K,), m, where the scene asks for them."""
    part = model.scene.deformation
    if part.model == "none" or not samples:
        return None
    from .deformation.leaf import Deformation

    deformation = Deformation(model)
    solved = [0]
    for k in range(1, len(times)):
        last = k == len(times) - 1
        if last or times[k] - times[solved[-1]] > part.interval - 1e-6:
            solved.append(k)
    shapes = {float(times[k]): deformation.solve(samples[k][0]) for k in solved}
    if model.scene.solver.model != "steady":
        shapes |= _openings(model, deformation, times, shapes, criteria)
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
    return displacement, bow, gap


def _openings(
    model: DoorModel,
    deformation: Deformation,
    times: Array,
    shapes: dict[float, Deflection],
    criteria: Criteria,
) -> dict[float, Deflection]:
    """Shapes around the moments at which gaps and deflections pass their limits.

    Found by marching anew to times between the samples, so that they do not depend on where those lie.
    """
    found: dict[float, Deflection] = {}
    at = sorted(shapes)
    opened: set[int] = set()
    for begin, end in pairwise(at):
        low, high = criteria.excess(begin, shapes[begin]), criteria.excess(end, shapes[end])
        for k in np.flatnonzero((low <= 0.0) & (high > 0.0)):
            if int(k) in opened:
                continue
            opened.add(int(k))
            a, b, fa, fb = begin, end, float(low[k]), float(high[k])
            for n in range(REFINED):
                if b - a < CLOSE:
                    break
                # False position, and a bisection each other time: the gap opens ever more slowly.
                time = a + (b - a) * (-fa / (fb - fa) if n % 2 == 0 else 0.5)
                time = min(max(time, a + 0.02 * (b - a)), b - 0.02 * (b - a))
                if time not in found:
                    found[time] = deformation.solve(_temperature_at(model, times, time))
                f = float(criteria.excess(time, found[time])[k])
                a, fa, b, fb = (time, f, b, fb) if f <= 0.0 else (a, fa, time, f)
    return found


def _temperature_at(model: DoorModel, times: Array, time: float) -> Array:
    """Node temperatures (N,), °C, at a time between the samples, marched as the run was."""
    heat = Heat(model)
    for sample in times[times < time]:
        heat.advance(float(sample))
    heat.advance(time)
    return heat.temperature
