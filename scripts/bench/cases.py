"""What a controller is put through."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexsim_node import Scene

from ..controller.trajectory import Trajectory

BEGIN = 0.1  # s at rest before the move
POINTS = 101
REVOLUTE, PRISMATIC = 0.5, 0.1  # rad and m that a joint moves where nothing else is said


@dataclass(frozen=True)
class Case:
    """One run: its name, what it is for, and the faults in it (as in a scene)."""

    name: str
    about: str
    faults: tuple[dict[str, Any], ...] = ()


def move(scene: Scene, goal: list[float] | None, duration: float) -> Trajectory:
    """From the scene's first position to the goal at constant acceleration and deceleration.

    The jumps of acceleration are what excites vibration.
    """
    m = len(scene.joint_names)
    start = np.array(scene.initial.position or np.zeros(m))
    if goal is None:
        steps = [PRISMATIC if joint.type == "prismatic" else REVOLUTE for joint in scene.joints]
        goal = list(start + steps)
    if len(goal) != m:
        raise ValueError(f"the goal has {len(goal)} values for {m} joints; give one a joint")
    s = np.linspace(0.0, 1.0, POINTS, dtype=np.float64)
    part = np.where(s < 0.5, 2.0 * s**2, 1.0 - 2.0 * (1.0 - s) ** 2)
    rate = np.where(s < 0.5, 4.0 * s, 4.0 * (1.0 - s)) / duration
    way = np.array(goal) - start
    return Trajectory(np.asarray(BEGIN + duration * s), start + part[:, None] * way, rate[:, None] * way)


def cases(scene: Scene, effort: NDArray[np.float64], moved: float, period: float) -> list[Case]:
    """The runs after the nominal one, whose largest torques (m,) are `effort`; `moved`: s, the move's end."""
    strongest = int(np.argmax(effort))
    joint = scene.joint_names[strongest]
    push = 0.3 * float(effort[strongest])
    mass = sum(
        beam.density * (beam.area or (beam.width or 0.0) * (beam.depth or 0.0)) * link.length
        for link in scene.links
        if (beam := link.beam) is not None
    )
    resolution = 2.0 * np.pi / 4096.0
    tip = scene.link_names[scene.tips[0]]
    return [
        Case("push", f"{push:.3g} N m on {joint} for 50 ms when the move has ended",
             ({"kind": "disturbance", "value": push, "joints": [joint],
               "start": moved, "end": moved + 0.05},)),
        Case("payload", f"{0.1 * mass:.3g} kg taken up at the end of {tip} in mid-move",
             ({"kind": "payload", "link": tip, "mass": 0.1 * mass,
               "start": BEGIN + 0.5 * (moved - BEGIN)},)),
        Case("wire", "a period late, up to one more at random, one command in twenty lost",
             ({"kind": "delay", "time": period}, {"kind": "jitter", "time": period},
              {"kind": "drop", "probability": 0.05})),
        Case("sensors", "encoders of 4096 lines, velocities with noise",
             ({"kind": "quantize", "signal": "position", "resolution": resolution},
              {"kind": "noise", "signal": "velocity", "deviation": 10.0 * resolution})),
        Case("motors", f"a lag of 5 ms, and no more than {0.8 * effort[strongest]:.3g} N m from {joint}",
             ({"kind": "lag", "time_constant": 0.005},
              {"kind": "saturate", "limit": 0.8 * float(effort[strongest]), "joints": [joint]})),
    ]  # fmt: skip


def latency(delay: float) -> Case:
    """Every command late by so many seconds."""
    return Case(f"late {1e3 * delay:g} ms", "every command late", ({"kind": "delay", "time": delay},))
