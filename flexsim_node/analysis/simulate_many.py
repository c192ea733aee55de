"""Many runs at once, on all cores, each bit for bit as `simulate` makes it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from ..motion.law import CompiledLaw
from ..motion.run import Torque
from ..scene.load import Scene, SceneError, load_scene
from ..scene.variants import starting
from .many_runs import OUTPUTS, Feedback, Plan, Runs, Work


def simulate_many(
    scene: Scene | Sequence[Scene],
    overrides: Sequence[Mapping[str, Any]] | None = None,
    *,
    position: np.ndarray | None = None,
    velocity: np.ndarray | None = None,
    torque: Torque = None,
    law: Callable[..., None] | CompiledLaw | None = None,
    given: np.ndarray | None = None,
    memory: int = 0,
    duration: float = 1.0,
    sample_period: float | None = None,
    control_period: float | None = None,
    jumps: Iterable[float] = (),
    outputs: Sequence[str] = ("joint_position", "joint_velocity", "link_end"),
    threads: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Runs:
    """Simulate many robots for `duration` seconds each, on all cores; each run is that of `simulate`.

    How many robots there are follows from what is given a robot: scenes, overrides, starts, torques, `given`.

    Parameters
    ----------
    scene : one for all, or one a robot
    overrides : of the scene, dotted keys and values a robot, as of load_scene
    position, velocity : (R, m) where the joints start, rad or m and rad/s or m/s; the scene's where None.
        A robot that only starts elsewhere is not built anew, which takes as long as hundreds of steps
    torque : as of simulate; an array (R, K, m) is a robot's own
    law : a feedback law, law(time, position, velocity, given, memory, torque): from the joints' positions and
        velocities (m,), as the encoders show them, it writes the motors' torques (m,).  It is compiled by
        numba, once a call; give a CompiledLaw to call again.  `memory` (l,) is its own, zero at each start
    given : (R, g) numbers that the law gets, a row a robot, or (g,) the same for all
    memory : l, how many numbers the law remembers
    sample_period : s between samples; the scene's step where None
    control_period : s between the law's answers, each held to the next; the sample period where None, of
        which it is a whole part
    jumps : as of simulate
    outputs : what is kept: of joint_position, joint_velocity, torque, link_end, node_position,
        rigid_position, node_displacement, energy, sensors
    threads : of the machine's processors as many as it has where None
    progress : called with how many runs are done, and of how many

    Runs of scenes with faults, loops or adaptive steps, and those whose sensors are asked for, take their
    steps one by one from Python, as `simulate` does, and a core for all of them.

    Raises
    ------
    ValueError, SceneError
        for what can't be, before any run; of a robot with its number
    """
    scenes = robots(scene, overrides, position, velocity, torque, given)
    unknown = [name for name in outputs if name not in OUTPUTS]
    if unknown:
        raise ValueError(f"outputs: no {unknown[0]!r}; give some of {', '.join(OUTPUTS)}")
    if threads is not None and threads < 1:
        raise ValueError(f"threads {threads}; give at least 1")
    plan = Plan(scenes[0], duration, sample_period, control_period)
    if law is None:
        if control_period is not None or given is not None or memory:
            raise ValueError("control_period, given and memory are a law's; give a law, or leave them out")
        work = Work(plan, scenes, torque, tuple(jumps), tuple(outputs))
    else:
        if torque is not None:
            raise ValueError("torque and law are both given; give one of them")
        compiled = law if isinstance(law, CompiledLaw) else CompiledLaw(law)
        if memory < 0:
            raise ValueError(f"memory {memory}; give how many numbers the law remembers, 0 or more")
        feedback = Feedback(compiled, rows(given, len(scenes)), memory)
        work = Work(plan, scenes, None, tuple(jumps), tuple(outputs), feedback)
    return work.run(threads or len(os.sched_getaffinity(0)), progress)


def robots(
    scene: Scene | Sequence[Scene],
    overrides: Sequence[Mapping[str, Any]] | None,
    position: np.ndarray | None,
    velocity: np.ndarray | None,
    torque: Torque,
    given: np.ndarray | None,
) -> list[Scene]:
    """The scene of every robot; those that are the same robot, wherever it starts, share their links."""
    counts: dict[str, int] = {}
    if not isinstance(scene, Scene):
        counts["scene"] = len(scene)
    if overrides is not None:
        counts["overrides"] = len(overrides)
    for name, values, axes in (
        ("position", position, 2), ("velocity", velocity, 2), ("torque", torque, 3), ("given", given, 2),
    ):  # fmt: skip
        if values is not None and not callable(values) and np.ndim(values) == axes:
            counts[name] = len(np.asarray(values))
    if len(set(counts.values())) > 1:
        said = ", ".join(f"{name} is for {n}" for name, n in counts.items())
        raise ValueError(f"{said} robots; give each for as many")
    count = next(iter(counts.values()), 1)
    if count == 0:
        raise ValueError(f"{next(iter(counts))} is for no robot; give at least one")
    scenes = [scene] * count if isinstance(scene, Scene) else list(scene)
    if overrides is not None:
        scenes = [
            overridden(k, base, change)
            for k, (base, change) in enumerate(zip(scenes, overrides, strict=True))
        ]
    for key, values in (("position", position), ("velocity", velocity)):
        if values is None:
            continue
        table = np.asarray(values, dtype=float)
        m = len(scenes[0].joint_names)
        if table.shape != (count, m) or not np.all(np.isfinite(table)):
            raise ValueError(f"{key} has shape {table.shape}; give finite values of shape ({count}, {m})")
        scenes = [starting(s, key, row) for s, row in zip(scenes, table, strict=True)]
    return scenes


def overridden(k: int, scene: Scene, change: Mapping[str, Any]) -> Scene:
    """Robot k's scene with its overrides."""
    try:
        return load_scene(scene.model_dump(), change)
    except SceneError as problem:
        raise SceneError(f"robot {k}: {problem}") from None


def rows(given: np.ndarray | None, count: int) -> np.ndarray:
    """(R, g) what the law gets."""
    table = np.zeros((count, 0)) if given is None else np.asarray(given, dtype=float)
    if table.ndim == 1:
        table = np.tile(table, (count, 1))
    if table.ndim != 2:
        raise ValueError(f"given has shape {table.shape}; give (R, g), or (g,) for all")
    return table
