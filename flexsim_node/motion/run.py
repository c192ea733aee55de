"""A run of a scene: its torques, and arrays of what happened."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ..equations.dynamics.acceleration import OK
from ..integrators.adaptive import Adaptive
from ..scene.load import Scene
from ..scene.torque_profile import torque_profile
from ..scene.variants import nothing_left_out, opened
from .decision import Decision
from .jumps import SLACK, Jumps, Piece, torque_jumps
from .simulation import Simulation, joint_index
from .validity import LOOK_PERIOD

Torque = Callable[[float], np.ndarray] | np.ndarray | None
Wrench = Mapping[str, Callable[[float], np.ndarray]]
Motion = Mapping[str, Callable[[float], tuple[float, float, float]]]

TORQUE_NOT_FINITE = "a torque or a prescribed motion is not finite; look at its function"


@dataclass(frozen=True)
class Run:
    """What a simulation gave; K samples, m joints, L links, N nodes.

    Attributes
    ----------
    time : (K,) s
    joint_position, joint_velocity : (K, m) as the encoders show them, rad or m
    torque : (K, m) in force from each sample on, N m or N
    link_end : (K, L, 3) base frame, elastic displacement included, m
    node_position, rigid_position : (K, N, 3) base frame, with and without the elastic displacement, m
    node_displacement : (K, N, 6) from the rigid links, in link frames, m and rad
    energy : (K,) kinetic, elastic and gravitational together, J
    loop_gap : (K, loops) distance between the points that each closing joint holds together, m
    conditioning : (K,) how well the actuated joints guide the passive ones, the least since the sample
        before: at most 1, 0 at a singular configuration
    step_time : s of wall-clock for each step
    validity : the largest of each figure of the validity watch, by name
    warnings : what passed a limit of the scene's `validity` without ending the run, and when loops came near
        a singular configuration, a sentence each
    status : "ok", or the reason why the run ended before its time (its samples end there too)
    node_names : (N,) link/number
    sensors : name of each of the scene's sensors to its readings, (K,) strain, (K, 10) imu, (K, 7) pose,
        (K, 6) section_force; see instruments.py
    decision : the formulation and effects that were simulated, where the scene leaves any to `auto`
    """

    time: np.ndarray
    joint_position: np.ndarray
    joint_velocity: np.ndarray
    torque: np.ndarray
    link_end: np.ndarray
    node_position: np.ndarray
    rigid_position: np.ndarray
    node_displacement: np.ndarray
    energy: np.ndarray
    loop_gap: np.ndarray
    conditioning: np.ndarray
    step_time: np.ndarray
    validity: dict[str, float]
    warnings: tuple[str, ...]
    status: str
    node_names: tuple[str, ...]
    sensors: dict[str, np.ndarray] = field(default_factory=dict)
    decision: Decision | None = None


def run(
    scene: Scene,
    torque: Torque = None,
    duration: float = 1.0,
    sample_period: float | None = None,
    prescribed: Motion | None = None,
    wrench: Wrench | None = None,
    jumps: Iterable[float] = (),
    exact_faults: bool = False,
    decision: Decision | None = None,
) -> Run:
    """Simulate a scene for `duration` seconds; simulate.py describes the arguments.

    Parameters
    ----------
    decision : of what the scene leaves to `auto`: the run is held against what that was decided over

    Raises
    ------
    ValueError
        for a duration, period or torque that can't be
    Undecided
        where the scene leaves something open and there is no decision
    """
    step = scene.solver.step
    period = step if sample_period is None else float(sample_period)
    check_times(duration, sample_period=period)
    prescribed = dict(prescribed or {})
    substeps = max(1, int(np.ceil(period / step - 1e-9)))
    given, jumps = torque, tuple(jumps)
    cuts = Jumps([*jumps, *(torque_jumps(scene) if torque is None else ())])
    torque = torque_profile(scene) if torque is None else torque
    planar = False if _leave_the_plane(wrench, duration, period / substeps) else None
    closed = scene if decision is None else scene.model_copy(update=opened(decision.scene))
    robot = Simulation(closed, period / substeps, tuple(prescribed), planar, exact_faults)
    samples = int(np.floor(duration / period + 1e-9)) + 1
    m = robot.model.joints
    applied = torque_function(torque, m, period, robot)
    motion = _motion_function(scene, prescribed, robot)
    loads = [(name.removeprefix("base:"), name.startswith("base:"), f) for name, f in (wrench or {}).items()]

    def load(*times: float) -> None:
        """Put the loads of a time, or of a step's start, middle and end, on the links."""
        for name, base, given in loads:
            values = [given(t) for t in times]
            robot.apply(name, values[0] if len(times) == 1 else np.array(values), base)

    robot.motion[:] = motion(0.0)
    load(0.0)
    trouble = ""
    if prescribed:
        robot.follow_motion()
        if robot.assembly is not None:
            robot.assemble()
    adaptive = None
    if robot.advance is None:
        if robot.faults is not None:
            raise ValueError(f"{robot.method} has no fixed steps for faults to count; give another method")
        smooth = not isinstance(torque, np.ndarray)
        adaptive = Adaptive(robot.model, robot.work, robot.method, applied, motion, load, smooth)
        adaptive.begin(cuts.after(0.0))
        robot.torque[:] = applied(0.0)
        robot.prepare()
    elif robot.faults is not None:
        robot.command(applied(0.0))
        robot.prepare()
        robot.warm()
    else:
        robot.torque[:] = applied(0.0)
        robot.prepare()
        robot.warm()
    robot.watch.begin()
    next_look = 0.0
    view = robot.look()
    nodes, links = len(view.position), len(view.ends)
    times = period * np.arange(samples)
    position, velocity, torques = np.zeros((3, samples, m))
    link_end = np.zeros((samples, links, 3))
    node_position, rigid_position = np.zeros((2, samples, nodes, 3))
    displacement = np.zeros((samples, nodes, 6))
    energy = np.zeros(samples)
    readings = {name: np.zeros((samples, value.size)) for name, value in robot.sensors.values.items()}
    loop_gap, conditioning = np.zeros((samples, len(scene.loops))), np.ones(samples)
    step_time = np.zeros((samples - 1) * substeps)
    h = robot.step_size
    taken = kept = 0
    near: tuple[str, ...] = ()
    scope, left = (None if decision is None else decision.envelope), ""
    constant = torque is None or isinstance(torque, np.ndarray)
    for k in range(samples):
        view = robot.look()
        position[k], velocity[k] = robot.joint_position(), robot.joint_velocity()
        torques[k] = applied(times[k])
        link_end[k], node_position[k] = view.link_end, view.position
        rigid_position[k], displacement[k] = view.rigid_position, view.displacement
        if readings:
            for name, value in robot.sense().items():
                readings[name][k] = value
        energy[k] = robot.energy().sum()
        if robot.assembly is not None and robot.singularity is not None:
            loop_gap[k] = robot.assembly.gaps(robot.x)
            conditioning[k] = robot.singularity.worst
            if robot.singularity.near and not near:
                near = (f"at {times[k]:.4g} s {robot.singularity.warning}",)
            robot.singularity.worst = 1.0
        kept = k + 1
        if times[k] >= next_look or k == samples - 1:
            next_look = times[k] + LOOK_PERIOD
            if not robot.check():
                break
        if k == samples - 1:
            break
        for n in range(substeps):
            t = times[k] + n * h
            whole = robot.faults.step + 1 if robot.faults is not None else 0.0
            if robot.faults is not None:
                # a command a sample, as a controller of that period sends it
                if n == 0 and k > 0:
                    robot.command(applied(t))
                if n == 0:
                    torques[k] = robot.torque[0]
            waiting = cuts.pieces(t, h)
            while waiting:
                piece = waiting.pop(0)
                if robot.faults is not None and exact_faults:
                    piece, rest = _until_change(piece, robot, whole, h)
                    waiting[:0] = rest
                ends = piece.begin, piece.begin + 0.5 * piece.length, piece.end
                load(*ends)
                if robot.faults is None and constant:
                    robot.torque[:] = applied(t)
                elif robot.faults is None:
                    for row, instant in enumerate(ends):
                        robot.torque[row] = applied(instant)
                if prescribed:
                    for row, instant in enumerate(ends):
                        robot.motion[row] = motion(instant)
                if not (np.all(np.isfinite(robot.torque)) and np.all(np.isfinite(robot.motion))):
                    trouble = TORQUE_NOT_FINITE
                    break
                length = None if piece.length == h else piece.length
                begin = time.perf_counter()
                if adaptive is not None:
                    robot.note_step()
                    if piece.jumped:
                        adaptive.begin(cuts.after(piece.begin))
                    status = adaptive.step(robot.x, robot.v, piece.begin, piece.length)
                    if robot.singularity is not None:
                        robot.singularity.look(robot.work)
                else:
                    status = robot.step(length, piece.jumped)
                step_time[taken] += time.perf_counter() - begin
                if status != OK:
                    robot.status = status
                    break
            if trouble:
                break
            taken += 1
            if robot.status != OK:
                break
            if scope is not None and not left:
                effort = torques[k] if adaptive is not None else robot.torque[2]
                left = scope.beyond(t + h, robot.model.shown(robot.x), robot.model.shown(robot.v), effort)
                if left and scene.auto.beyond != "warn":
                    break
        if trouble or robot.status != OK or (left and scene.auto.beyond != "warn"):
            break
    if left and decision is not None and scene.auto.beyond == "switch_on":
        # From its start, so that no motion is made of two robots.
        on = nothing_left_out(scene)
        again = run(on, given, duration, sample_period, prescribed, wrench, jumps, exact_faults)
        said = f"{left}; beyond is switch_on: run again with them"
        return replace(again, warnings=(said, *again.warnings), decision=decision)
    if left and scene.auto.beyond == "stop":
        trouble = left
    elif left:
        near = (left, *near)
    if robot.status != OK:
        trouble = robot.reason
    reason = f"stopped at {robot.time:.6g} s: {trouble}" if trouble else "ok"
    return Run(
        times[:kept],
        position[:kept],
        velocity[:kept],
        torques[:kept],
        link_end[:kept],
        node_position[:kept],
        rigid_position[:kept],
        displacement[:kept],
        energy[:kept],
        loop_gap[:kept],
        conditioning[:kept],
        step_time[:taken],
        {finding.name: finding.value for finding in robot.watch.findings()},
        near + robot.watch.sentences("warn"),
        reason,
        robot.model.node_names,
        {name: (r[:kept, 0] if r.shape[1] == 1 else r[:kept]) for name, r in readings.items()},
        decision,
    )


def _until_change(piece: Piece, robot: Simulation, whole: float, h: float) -> tuple[Piece, list[Piece]]:
    """The part of a piece until a fault begins, ends or delivers, and what is left of it.

    whole : steps since the first state at the end of the step that the piece is of; h : s, of that step
    """
    assert robot.faults is not None
    change = robot.faults.next_change()
    until = (change - robot.faults.step) * h
    # what changed before this piece counts from its start: the method begins anew there
    piece = replace(piece, jumped=piece.jumped or robot.faults.changed)
    if change > whole - SLACK or until > piece.length - SLACK * h:
        return piece, []
    cut = piece.begin + until
    return replace(piece, end=cut, length=until), [Piece(cut, piece.end, piece.length - until, False)]


def _leave_the_plane(wrench: Wrench | None, duration: float, step: float) -> bool:
    """Whether loads on the links' ends leave, at any step's start, the plane of a planar robot."""
    times = np.arange(0.0, duration + 0.5 * step, step)
    return any(
        np.any(np.asarray(given(float(t)), dtype=float).reshape(-1)[2:5] != 0.0)
        for given in (wrench or {}).values()
        for t in times
    )


def torque_function(
    torque: Torque, m: int, period: float, robot: Simulation
) -> Callable[[float], np.ndarray]:
    """Torque (m,) as a function of time, within the effort limits and on actuated joints alone."""
    limit, passive = robot.limit, np.flatnonzero(~robot.model.actuated)

    def within(effort: np.ndarray) -> np.ndarray:
        pushed = passive[np.any(effort.reshape(-1, m)[:, passive] != 0.0, axis=0)]
        if pushed.size:
            name = robot.scene.joint_names[pushed[0]]
            raise ValueError(f"there is a torque on {name}, which is passive; give zero there")
        return np.clip(effort, -limit, limit)

    if torque is None:
        zero = np.zeros(m)
        return lambda t: zero
    if callable(torque):
        given = np.asarray(torque(0.0), dtype=float)
        if given.shape != (m,) or not np.all(np.isfinite(given)):
            raise ValueError(f"torque(0.0) is {given!r}; give {m} finite values")
        return lambda t: within(np.asarray(torque(t), dtype=float))
    table = np.asarray(torque, dtype=float)
    if table.ndim != 2 or table.shape[1] != m or len(table) == 0 or not np.all(np.isfinite(table)):
        raise ValueError(f"torque has shape {table.shape}; give finite values of shape (K, {m})")
    table = within(table)
    last = len(table) - 1
    return lambda t: table[min(int(t / period + 1e-6), last)]


def _motion_function(scene: Scene, prescribed: Motion, robot: Simulation) -> Callable[[float], np.ndarray]:
    """Prescribed position, velocity, acceleration (3, m) as a function of time."""
    driven = [(joint_index(scene, name), f) for name, f in prescribed.items()]
    still = np.zeros((3, robot.model.joints))
    still[:2] = robot.motion[0, :2]

    def motion(t: float) -> np.ndarray:
        now = still.copy()
        for k, f in driven:
            now[:, k] = f(t)
        return now

    return motion


def check_times(duration: float, **periods: float) -> None:
    """Raise ValueError for a duration or a period, s, that can't be."""
    if not (np.isfinite(duration) and duration >= 0.0):
        raise ValueError(f"duration {duration!r}; give seconds, zero or more")
    for name, value in periods.items():
        if not (np.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} {value!r}; give seconds, more than zero")
