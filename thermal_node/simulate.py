"""A whole test, offline: as fast as it goes, sampled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from .conduction import Array
from .criteria import Criteria, Criterion, FurnaceTolerance
from .furnace import CURVES, Measured
from .heat import Heat, HeatBalance
from .model import DoorModel, door_model
from .probes import probes_of, unexposed_maximum, unexposed_mean
from .scene import Scene, SceneError
from .status import Status
from .steady import steady_state


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
    furnace_tolerance : how well the furnace kept to its standard curve, where it has one
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
    model = door_model(scene)
    _log_lasts(model, duration)
    steady = scene.solver.model == "steady"
    heat = steady_state(model, duration) if steady else Heat(model)
    probes = probes_of(model)
    criteria = Criteria(scene.criteria, probes, model.initial)
    tolerance = FurnaceTolerance()
    standard = CURVES.get(scene.furnace.curve)
    count = 0 if steady else int(np.floor(duration / sample_period + 1e-9))
    times: Array = sample_period * np.arange(count + 1, dtype=np.float64)
    if not steady and duration - times[-1] > 1e-9 * duration:
        times = np.append(times, duration)
    if steady:
        times = np.array([duration])
    samples: list[tuple[Array, Array, float]] = []
    for time in times:
        if not (heat.status if steady else heat.advance(float(time))).ok:
            break
        readings = probes.read(heat.temperature)
        criteria.watch(float(time), readings)
        furnace = float(heat.furnace(float(time)))
        if standard is not None:
            each = getattr(heat.furnace, "thermocouples", lambda _t, f=furnace: np.array([f]))
            tolerance.watch(float(time), float(standard(time)), each(float(time)))
        samples.append((heat.temperature.copy(), readings, furnace))
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
        furnace_tolerance=tolerance if standard is not None else None,
        work={
            "steps": heat.steps,
            "rejected": heat.rejected,
            "evaluations": int(heat.count[0]),
            "linear_iterations": int(heat.count[1]),
        },
    )
    run.verdict = criteria.verdict("" if run.status.ok else run.status.reason)
    return run


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
    shapes = [deformation.solve(samples[k][0]) for k in solved]
    bow = np.interp(times, times[solved], [s.bow for s in shapes])
    gap = np.interp(times, times[solved], [s.gap for s in shapes])
    largest = np.interp(times, times[solved], [s.largest for s in shapes])
    displacement = np.empty((len(times), *shapes[0].displacement.shape))
    for k, time in enumerate(times):
        i = min(int(np.searchsorted(times[solved], time, side="right")) - 1, len(solved) - 1)
        j = min(i + 1, len(solved) - 1)
        span = times[solved[j]] - times[solved[i]]
        share = (time - times[solved[i]]) / span if span > 0.0 else 0.0
        displacement[k] = (1.0 - share) * shapes[i].displacement + share * shapes[j].displacement
        criteria.watch_deflection(float(time), float(gap[k]), float(largest[k]))
    return displacement, bow, gap
