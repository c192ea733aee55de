"""The torque that a scene gives its motors over time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .schema import Scene, Torque


def torque_profile(scene: Scene) -> Callable[[float], np.ndarray] | None:
    """Torque (m,) as a function of time, s; None where the scene gives none.  Entries of one joint add up."""
    if not scene.torque:
        return None
    names = scene.joint_names
    entries = [(names.index(entry.joint), entry) for entry in scene.torque]

    def torque(t: float) -> np.ndarray:
        total = np.zeros(len(names))
        for k, entry in entries:
            total[k] += value(entry, t)
        return total

    return torque


def value(entry: Torque, t: float) -> float:
    """Torque of one entry at time t, N m or N."""
    if t < entry.start or (entry.end is not None and t >= entry.end):
        return 0.0
    if entry.type == "sine":
        phase = 2.0 * np.pi * entry.frequency * (t - entry.start) + entry.phase
        return entry.offset + entry.amplitude * float(np.sin(phase))
    if entry.type == "table":
        return float(np.interp(t, entry.time, entry.value))
    return entry.amplitude
