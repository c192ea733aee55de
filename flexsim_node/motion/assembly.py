"""Assembly of closed loops: joint positions, rates and shapes at rest that close them, found numerically."""

from __future__ import annotations

import numpy as np
from scipy.linalg import null_space, qr
from scipy.optimize import least_squares

from ..equations.constraints.closure import DEFECT, defects, linearise
from ..equations.dynamics.residual import residual
from ..equations.dynamics.tangent import differences
from ..equations.kinematics.nodal_motion import accelerate, place
from ..model.chain import (
    CLOSING_LOOP,
    DIRECTION,
    EQUATION,
    KIND,
    LINK_A,
    LINK_B,
    REVOLUTE,
    Workspace,
    workspace,
)
from ..model.model import Model
from ..scene.load import SceneError

CLOSED = 1e-11  # m and rad
OTHER_STARTS = 40  # tried where the given position leads to no closed one
NEWTON_STEPS = 50
SLOW = 1e-9  # m/s and rad/s
INDEPENDENT = 1e-9  # of the largest singular value


class Assembly:
    """The closing joints of a model at given unknowns.

    Attributes
    ----------
    value : (R,) of the equations, m and rad
    gradient : (R, n) of the equations
    row_scale (R,), column_scale (m,) : to the unit of length in which links are one long on average
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.work: Workspace = workspace(model.chain)
        self._still = np.zeros(model.unknowns)
        self.value = np.zeros(len(model.chain.closing))
        self.gradient = np.zeros((self.value.size, model.unknowns))
        lengths = [link.length for link in model.scene.links if link.length > 0.0]
        self.size = float(np.mean(lengths)) if lengths else 1.0
        points = model.chain.closing[:, EQUATION] != DIRECTION
        self.row_scale = np.where(points, 1.0 / self.size, 1.0)
        turns = model.chain.link[model.joint_links, KIND] == REVOLUTE
        self._turns = turns
        self.column_scale = np.where(turns, 1.0, self.size)

    def look(self, x: np.ndarray) -> None:
        """Evaluate the equations at the unknowns x (n,)."""
        chain, work, n = self.model.chain, self.work, self.model.unknowns
        place(chain, work, x)
        accelerate(chain, work, self._still, self._still)
        linearise(chain, work, self._still)
        self.gradient[:] = work.closure[:, :n]
        defects(chain, work, False)
        self.value[:] = work.closure[:, 2 * n + self.value.size + DEFECT]

    def gaps(self, x: np.ndarray) -> np.ndarray:
        """(loops,) distance of the points that each closing joint holds together, m."""
        chain = self.model.chain
        self.look(x)
        squares = np.zeros(len(self.model.scene.loops))
        points = chain.closing[:, EQUATION] != DIRECTION
        np.add.at(squares, chain.closing[points, CLOSING_LOOP], self.value[points] ** 2)
        return np.sqrt(squares)

    def rank(self, x: np.ndarray) -> int:
        """How many of the equations are independent for rigid links at x (n,)."""
        self.look(x)
        scaled = self.row_scale[:, None] * self.gradient[:, : self.model.joints] * self.column_scale
        values = np.linalg.svd(scaled, compute_uv=False)
        return int(np.sum(values > INDEPENDENT * values[0]))

    def mobility(self, x: np.ndarray, held: np.ndarray) -> int:
        """How many ways the rigid mechanism can move at x with the held joints (m,) still."""
        free = np.flatnonzero(~held)
        self.look(x)
        scaled = self.row_scale[:, None] * self.gradient[:, free] * self.column_scale[free]
        return int(free.size - np.linalg.matrix_rank(scaled, tol=INDEPENDENT))

    def position(self, x: np.ndarray, fixed: np.ndarray) -> np.ndarray:
        """Unknowns x (n,) with the joints that are not fixed (m,) moved so that every loop is closed.

        Raises
        ------
        SceneError
            with the smallest gap that was found
        """
        free = np.flatnonzero(~fixed)
        guess = x[free].copy()
        best, least = x, np.inf
        random = np.random.default_rng(1)
        for attempt in range(OTHER_STARTS + 1):
            start = guess
            if attempt > 0:
                away = random.uniform(-1.0, 1.0, free.size)
                start = guess + away * np.where(self._turns[free], np.pi, self.size)
            found = self._closed_from(x, free, start, guess)
            size = float(np.max(np.abs(self.value)))
            if size <= CLOSED and self._upright():
                distance = float(np.linalg.norm(found[free] - guess))
                if attempt == 0 or distance < least:
                    best, least = found, distance
                if attempt == 0:
                    return best
            if free.size == 0:
                break
        if least < np.inf:
            return best
        raise self._refusal(x, free, guess)

    def _closed_from(
        self, x: np.ndarray, free: np.ndarray, start: np.ndarray, guess: np.ndarray
    ) -> np.ndarray:
        """Unknowns x with the free joints found from `start`, turned back to where the guess is."""
        y = x.copy()

        def value(p: np.ndarray) -> np.ndarray:
            y[free] = p
            self.look(y)
            return self.row_scale * self.value

        def slope(p: np.ndarray) -> np.ndarray:
            return self.row_scale[:, None] * self.gradient[:, free]

        if free.size:
            found = least_squares(value, start, slope, xtol=1e-15, ftol=1e-15, gtol=1e-15, max_nfev=200).x
            turns = np.round((found - guess) / (2.0 * np.pi)) * self._turns[free]
            y[free] = found - 2.0 * np.pi * turns
            for _ in range(3):  # least squares stop short of rounding
                value(y[free])
                size = np.max(np.abs(self.value))
                if not size < 1e-6:
                    break
                y[free] -= np.linalg.lstsq(slope(y[free]), self.row_scale * self.value, rcond=1e-12)[0]
        self.look(y)
        return y

    def _upright(self) -> bool:
        """Whether joints that are fixed hold frames together that point the same way, not turned over."""
        for number, loop in enumerate(self.model.scene.loops):
            if loop.joint != "fixed":
                continue
            row = self.model.chain.closing[self.model.chain.closing[:, CLOSING_LOOP] == number][0]
            one, two = (self._frame(row[k]) for k in (LINK_A, LINK_B))
            if np.min(np.diag(one.T @ two)) < 0.5:
                return False
        return True

    def _frame(self, n: int) -> np.ndarray:
        """(3, 3) rotation of link n's frame, as it was last looked at."""
        return self.work.pose[n, 3:12].reshape(3, 3) @ self.model.axes[n].T if n >= 0 else np.eye(3)

    def _refusal(self, x: np.ndarray, free: np.ndarray, guess: np.ndarray) -> SceneError:
        scene = self.model.scene
        gaps = self.gaps(self._closed_from(x, free, guess, guess))
        n = int(np.argmax(gaps))
        names = [scene.joint_names[k] for k in free]
        turned = f"whatever the passive {', '.join(names)}" if names else "and no joint is passive"
        return SceneError(
            f"{scene.name}: loops.{n}: {scene.loops[n].label} can't be closed with the joints where they are,"
            f" {turned}: a gap of {gaps[n]:.3g} m remains"
            f" ({np.max(np.abs(self.value)):.3g} m or rad at most);"
            " give another initial position, other lengths, or make joints passive (actuated: false)"
        )

    def velocity(self, x: np.ndarray, v: np.ndarray, fixed: np.ndarray) -> np.ndarray:
        """Rates v (n,) with those of the joints that are not fixed changed so that the loops stay closed.

        Raises
        ------
        SceneError
            where they can't
        """
        free = np.flatnonzero(~fixed)
        self.look(x)
        y = v.copy()
        for _ in range(2):
            opening = self.row_scale * (self.gradient @ y)
            slope = self.row_scale[:, None] * self.gradient[:, free]
            y[free] -= np.linalg.lstsq(slope, opening, rcond=1e-12)[0]
        left = float(np.max(np.abs(self.gradient @ y), initial=0.0))
        if left > SLOW * (1.0 + np.max(np.abs(v), initial=0.0)):
            scene = self.model.scene
            raise SceneError(
                f"{scene.name}: the initial velocities open a loop at {left:.3g} m/s or rad/s, whatever the"
                " passive joints do; give rates that the mechanism can have"
            )
        return y

    def rest(self, x: np.ndarray, fixed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Unknowns x (n,) in static equilibrium and the closing forces (R,) there.

        The fixed joints (m,) are held as their encoders show them in x.  Newton's method on the free joints,
        the elastic unknowns and the closing forces.

        Raises
        ------
        ArithmeticError
            where no stable equilibrium is found
        """
        along = self.directions(fixed)
        x = self.position(x, fixed)
        push = np.zeros(self.value.size)
        best = np.inf
        for _ in range(NEWTON_STEPS):
            tangent = along.T @ self.stiffness(x, push) @ along
            force = along.T @ self.force(x, push)
            self.look(x)
            rows = self.gradient @ along
            # unknowns in units in which their own stiffness is one, equations with rows of length one
            stiffness = np.abs(np.diag(tangent))
            unit = 1.0 / np.sqrt(np.where(stiffness > 0.0, stiffness, np.max(stiffness, initial=1.0)))
            rows = rows * unit
            length = np.linalg.norm(rows, axis=1)
            length[length == 0.0] = 1.0
            rows /= length[:, None]
            tangent *= np.outer(unit, unit)
            matrix = np.block([[tangent, rows.T], [rows, np.zeros((rows.shape[0],) * 2)]])
            right = np.concatenate([unit * force, -self.value / length])
            if not (np.all(np.isfinite(matrix)) and np.all(np.isfinite(right))):
                break
            answer = np.linalg.lstsq(matrix, right, rcond=1e-13)[0]
            step = unit * answer[: unit.size]
            x = x + along @ step
            push = push + answer[unit.size :] / length
            size = float(np.max(np.abs(step), initial=0.0))
            if size < 1e-14 or (size < 1e-10 and size >= best):
                free = null_space(rows)
                if np.min(np.linalg.eigvalsh(free.T @ tangent @ free), initial=0.0) > -1e-6:
                    return x, push
                break
            best = min(best, size)
        raise ArithmeticError(
            f"{self.model.scene.name}: no static equilibrium found with the actuated joints held; the links"
            " are too soft for their load or buckle, or a passive joint turns over"
        )

    def directions(self, fixed: np.ndarray) -> np.ndarray:
        """(n, k) how all unknowns move with the free ones: fixed motors keep what their encoders show."""
        model = self.model
        held = model.turned[fixed]
        along = np.delete(np.eye(model.unknowns), held, axis=1)
        own = np.flatnonzero(fixed & (model.turn >= 0) & (model.motor < 0))
        along[own] -= along[model.turn[own]]
        return along

    def motions(self, x: np.ndarray, fixed: np.ndarray) -> np.ndarray:
        """(n, k) directions in which a robot at x can move, fixed joints held and loops closed."""
        along = self.directions(fixed)
        self.look(x)
        return along @ null_space(self.gradient @ along, rcond=INDEPENDENT)

    def independent(self, x: np.ndarray, moving: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Which of the moving unknowns to keep as coordinates near x, and how all move with them (n, k).

        Passive joints follow first.
        """
        self.look(x)
        rows = self.row_scale[:, None] * self.gradient[:, moving]
        passive = np.flatnonzero(~self.model.actuated)
        order = qr(np.where(np.isin(moving, passive), 1e6, 1.0) * rows, pivoting=True)[2]
        rank = np.linalg.matrix_rank(rows, tol=INDEPENDENT)
        follow, keep = np.sort(order[:rank]), np.sort(order[rank:])
        ways = np.zeros((x.size, keep.size))
        ways[moving[keep], np.arange(keep.size)] = 1.0
        ways[moving[follow]] = -np.linalg.lstsq(rows[:, follow], rows[:, keep], rcond=None)[0]
        return moving[keep], ways

    def force(self, x: np.ndarray, push: np.ndarray) -> np.ndarray:
        """(n,) generalized forces on a robot at rest at x, the closing forces (R,) among them."""
        model = self.model
        out, still = np.zeros(model.unknowns), np.zeros(model.unknowns)
        residual(model.chain, self.work, x, still, still, np.zeros(model.joints), out)
        linearise(model.chain, self.work, still)
        return out - self.work.closure[:, : model.unknowns].T @ push

    def stiffness(self, x: np.ndarray, push: np.ndarray) -> np.ndarray:
        """(n, n) derivative of minus `force` by x."""
        found = differences(lambda at: -self.force(at, push), x, np.eye(x.size))
        return 0.5 * (found + found.T)
