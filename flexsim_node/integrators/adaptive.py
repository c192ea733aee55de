"""Adaptive references from scipy, Radau (stiff) and DOP853, behind the same step as our own methods.

Where Coulomb's law itself holds a joint or turns its friction round, the equations are not smooth: such an
event is found on the dense output, and the solver starts again from there.

"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.integrate import DOP853, DenseOutput, Radau
from scipy.optimize import brentq

from ..equations.constraints.closure import close
from ..equations.constraints.friction import COLUMNS, FORCE, STUCK, close_resting, rub_by_rate, stand_still
from ..equations.dynamics.acceleration import (
    LOOP_OPEN,
    NOT_CONVERGED,
    NOT_FINITE,
    NOT_VALID,
    OK,
    acceleration,
    acceleration_sliding,
    drive_joints,
    finite,
)
from ..equations.dynamics.watch import valid
from ..model.chain import COULOMB, COULOMB_SPEED, Workspace
from ..model.model import Model

SOLVERS = {"radau": Radau, "dop853": DOP853}
MOVING = 1e-9  # rad/s or m/s: a joint that was at rest and is as fast as this slides


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
        chain = model.chain
        joint = chain.joint[model.joint_links]
        # joints with Coulomb's law itself, and the rows of their friction
        self.rubs = np.flatnonzero((joint[:, COULOMB] > 0.0) & (joint[:, COULOMB_SPEED] == 0.0))
        self.dense: DenseOutput | None = None  # of the step before the last start
        self.rows = np.searchsorted(chain.rubbing, model.joint_links[self.rubs])
        tail = work.rubbing.shape[1] - COLUMNS
        self.told = [tail + FORCE, tail + STUCK] if chain.rubbing.size else []
        self.contact = work.rubbing[:, self.told]
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
        self.rub()
        if acceleration_sliding(self.model.chain, self.work, x, v, self.torque(t), a) != OK:
            a[:] = np.nan
        elif self.loops:
            # the motion of the closed state next to (x, v): errors off the loops' surface then do not grow
            if not close(self.model.chain.loops, self.model.chain, self.work, x, v, np.zeros(n)):
                a[:] = np.nan
            drive_joints(self.model.chain, self.work, self.motion(t), x, v, a)
            self.rub()
            acceleration_sliding(self.model.chain, self.work, x, v, self.torque(t), a)
        return np.concatenate([v, a])

    def rub(self) -> None:
        """Let joints rub, or stick, as they did when the solver started."""
        self.work.rubbing[:, self.told] = self.contact

    def start(self, t: float, y: np.ndarray, bound: float, first: float) -> None:
        """Start the solver at t from y = (x, v); how joints rub follows from the rates."""
        if self.rubs.size:
            rub_by_rate(self.model.chain, self.work, y[self.model.unknowns :])
            self.contact = self.work.rubbing[:, self.told]
        self.running = self.kind(
            self.slope, t, y, bound, first_step=first, vectorized=False, **self.tolerances
        )

    def stop_and_go(self, first: float) -> None:
        """Start anew where, within the solver's last step, a joint has come to rest or has left it."""
        running, n = self.running, self.model.unknowns
        assert running is not None
        dense = running.dense_output()
        sign, stuck = np.sign(self.contact[self.rows, 0]), self.contact[self.rows, 1] > 0.0

        def rates(t: float) -> np.ndarray:
            return self.model.shown(np.asarray(dense(t))[n:])[self.rubs]

        now = rates(running.t)
        held = self.work.held[self.model.joint_links[self.rubs]]
        turned = np.flatnonzero(~held & ~stuck & (now * sign < 0.0))
        left = ~held & stuck & (np.abs(now) > MOVING)
        if not turned.size and not np.any(left):
            return
        when, y = running.t, running.y
        if turned.size:
            begun = rates(running.t_old)
            times = [
                brentq(lambda t, k=k: rates(t)[k], running.t_old, running.t) if begun[k] * sign[k] > 0.0
                else running.t_old
                for k in turned
            ]  # fmt: skip
            when = min(times)
            y = np.array(dense(when))
            k = self.rubs[turned[int(np.argmin(times))]]
            rate, turn = y[n:], self.model.turn[k]
            if self.model.motor[k] < 0 and turn >= 0:
                rate[turn] = -rate[k]
            else:
                rate[self.model.turned[k]] = 0.0
        self.dense = dense
        self.start(when, y, running.t_bound, first)

    def step(self, x: np.ndarray, v: np.ndarray, t: float, h: float) -> int:
        """Advance x, v (n,) from t by h in place.  Returns a status."""
        n = self.model.unknowns
        bound = self._jump if self.smooth else t + h
        if self.running is None or not self.smooth:
            y = np.concatenate([x, v])
            self.start(t, y, bound, min(h, 1e-4))
        assert self.running is not None
        while self.running.t < t + h and self.running.status == "running":
            self.running.step()
            if self.rubs.size and self.running.status != "failed":
                self.stop_and_go(min(h, 1e-4, max(t + h - self.running.t, 1e-12)))
        if self.running.status == "failed":
            return NOT_CONVERGED
        y = self.running.y
        if self.running.t > t + h:
            begun = self.running.t_old is not None and self.running.t_old <= t + h
            dense = self.running.dense_output() if begun else self.dense
            assert dense is not None
            y = dense(t + h)
        if not np.all(np.isfinite(y)):
            return NOT_CONVERGED
        chain, work = self.model.chain, self.work
        end, rate = y[:n].copy(), y[n:].copy()
        drive_joints(chain, work, self.motion(t + h), end, rate, np.zeros(n))
        self.load(t + h)
        if acceleration(chain, work, end, rate, self.torque(t + h), np.zeros(n)) != OK:
            return NOT_CONVERGED
        if self.loops and not close_resting(chain.loops, chain, work, end, rate, np.zeros(n)):
            return LOOP_OPEN
        stand_still(chain, work, rate)
        if not finite(chain, end, rate):
            return NOT_FINITE
        if not valid(chain, work):
            return NOT_VALID
        x[:], v[:] = end, rate
        return OK
