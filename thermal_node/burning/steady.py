"""The steady state that a door would reach in a furnace that stays as it is."""

from __future__ import annotations

import numpy as np

from ..furnace.furnace import Constant
from ..heat.method import IMPLICIT_EULER
from ..heat.stage import CONVERGED
from ..model.door_model import DoorModel
from .march import Heat
from .status import State, Status

FIRST_STEP, LONGEST_STEP = 1e2, 1e10
SETTLED = 1e-6


def steady_state(model: DoorModel, time: float) -> Heat:
    """A march that has come to rest with the furnace's gas as it is at `time`, s.

    Implicit Euler with steps that grow without limit: each is a damped Newton step towards the
    balance, and a long enough one is the balance. What burns has burnt. The march's status says if none was
    found.
    """
    heat = Heat(model, Constant(model.furnace(time)), IMPLICIT_EULER)
    heat.frozen = time
    heat.burn_out()
    step = FIRST_STEP
    before = heat.temperature.copy()
    for _ in range(200):
        before[:] = heat.temperature
        outcome, _ = heat.attempt(step)
        if outcome != CONVERGED:
            step *= 0.1
            if step < 1e-3:
                break
            continue
        heat.accept(step)
        heat.stand_still()
        settled = np.abs(heat.temperature - before).max() < SETTLED
        if not heat.status.ok or (step >= LONGEST_STEP and settled):
            heat.time = time
            return heat
        step = min(5.0 * step, LONGEST_STEP)
    heat.status = Status(State.NOT_CONVERGED, "stopped: no steady state was found")
    return heat
