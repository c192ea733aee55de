"""Adaptive references from scipy, Radau (stiff) and DOP853, behind the same step as our own methods."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import DOP853, Radau

from ..acceleration import (
    LOOP_OPEN,
    NOT_CONVERGED,
    NOT_FINITE,
    NOT_VALID,
    OK,
    acceleration,
    drive_joints,
    finite,
)
from ..chain import Workspace
from ..closure import close
from ..model import Model
from ..watch import valid

SOLVERS = {"radau": Radau, "dop853": DOP853}


class Adaptive:
    """A scipy solver that runs on across steps and is read at their ends by its dense output.

    It restarts where the drive is not smooth: at every step unless `smooth` (torques held between samples),
    and at every jump that it is told of.
    """

    def __init__(
        self,
        model: Model,
        work: Workspace,
        method: str,
        torque: Callable[[float], np.ndarray],
        motion: Callable[[float], np.ndarray],
        load: Callable[[float], None],
        smooth: bool,
    ) -> None:
        solver = model.scene.solver
        self.model, self.work, self.smooth = model, work, smooth
        self.torque, self.motion, self.load = torque, motion, load
        self.loops = len(model.chain.loops) > 0
        self.kind = SOLVERS[method]
        self.tolerances = {"rtol": solver.relative_tolerance, "atol": solver.absolute_tolerance}
        self.running: Radau | DOP853 | None = None
        self.dense = None
        self._jump = self._before = np.inf

    def begin(self, jump: float) -> None:
        """Begin anew after a jump; the next one comes at `jump`, s, and the drive is that before it."""
        self.running = None
        self._jump, self._before = jump, np.nextafter(jump, -np.inf) if np.isfinite(jump) else np.inf

    def slope(self, t: float, y: np.ndarray) -> np.ndarray:
        """dy/dt of y = (x, v)."""
        n, t = self.model.unknowns, min(t, self._before)
        x, v, a = y[:n].copy(), y[n:].copy(), np.zeros(n)
        drive_joints(self.model.chain, self.work, self.motion(t), x, v, a)
        self.load(t)
        if acceleration(self.model.chain, self.work, x, v, self.torque(t), a) != OK:
            a[:] = np.nan
        elif self.loops:
            # the motion of the closed state next to (x, v): errors off the loops' surface then do not grow
            if not close(self.model.chain.loops, self.model.chain, self.work, x, v, np.zeros(n)):
                a[:] = np.nan
            drive_joints(self.model.chain, self.work, self.motion(t), x, v, a)
            acceleration(self.model.chain, self.work, x, v, self.torque(t), a)
        return np.concatenate([v, a])

    def step(self, x: np.ndarray, v: np.ndarray, t: float, h: float) -> int:
        """Advance x, v (n,) from t by h in place.  Returns a status."""
        n = self.model.unknowns
        bound = self._jump if self.smooth else t + h
        if self.running is None or not self.smooth:
            y = np.concatenate([x, v])
            first = min(h, 1e-4)
            self.running = self.kind(
                self.slope, t, y, bound, first_step=first, vectorized=False, **self.tolerances
            )
        while self.running.t < t + h and self.running.status == "running":
            self.running.step()
        if self.running.status == "failed":
            return NOT_CONVERGED
        late = self.running.t > t + h
        y = self.running.dense_output()(t + h) if late else self.running.y
        if not np.all(np.isfinite(y)):
            return NOT_CONVERGED
        chain, work = self.model.chain, self.work
        end, rate = y[:n].copy(), y[n:].copy()
        drive_joints(chain, work, self.motion(t + h), end, rate, np.zeros(n))
        self.load(t + h)
        if acceleration(chain, work, end, rate, self.torque(t + h), np.zeros(n)) != OK:
            return NOT_CONVERGED
        if self.loops and not close(chain.loops, chain, work, end, rate, np.zeros(n)):
            return LOOP_OPEN
        if not finite(chain, end, rate):
            return NOT_FINITE
        if not valid(chain, work):
            return NOT_VALID
        x[:], v[:] = end, rate
        return OK
