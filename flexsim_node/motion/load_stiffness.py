"""What the loads take from a robot's stiffness, cheap enough to be looked at while it runs.

K is the links' elastic stiffness, K_g what weight, inertia forces and stresses change of it, joints held.
The figure is the smallest eigenvalue of K_g y = lambda K y: the lowest squared frequency is about 1 + lambda
of the unloaded one, and at lambda = -1 the robot buckles.  A look takes one step of the power iteration from
the last one's vector: one factorisation and a few residuals, in parts.
"""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from ..compiled.aligned import aligned
from ..compiled.by_reference import by_reference
from ..compiled.kernel import entry
from ..elements.element import stiffening
from ..equations.constraints.closure import keep_closed, linearise_loops, project
from ..equations.dynamics.residual import residual, stiffness_times
from ..equations.kinematics.nodal_motion import place
from ..equations.solve.factorization import factorize, set_scale
from ..equations.solve.substitution import solve
from ..model.chain import FIXED, KIND, ROTOR, Chain, workspace
from ..model.model import Model
from ..model.tables import Tables

SOFT = 1e6  # s^2: M + SOFT K is K, but for rounding
HEAVY = 1e12  # kg m^2 or kg, of motors that stand still
DIFFERENCE = 1e-6  # m and rad
FIRST_STEPS = 6  # of the iteration, where there is no vector yet
SMOOTHING = 2  # times that a first vector is bent by itself as a load


class LoadStiffness:
    """The iteration's vector for one model; a robot without elastic unknowns has no such figure.

    Where the effect `centrifugal` is off, the figure is that of the same robot with it: of what is left out.
    It needs `axial`; without that there is no figure.

    loads : buffers of the loads on the links' ends, `external` and `loaded` of a Workspace
    """

    def __init__(self, model: Model, **loads: np.ndarray) -> None:
        chain, self.left_out = model.chain, not (model.chain.co_moving or stiffening(model.scene))
        if self.left_out and model.scene.effects.axial:
            chain = with_its_effect(model)
        joint = chain.joint.copy()
        joint[chain.link[:, KIND] != FIXED, ROTOR] = HEAVY
        self.model, self.chain = model, chain
        self.held = with_joints(chain, joint)
        self.work, self.steady = workspace(chain, **loads), workspace(self.held)
        bends = any(link.flexible and link.beam is not None for link in model.scene.links)
        self.elastic = bends and (model.scene.effects.axial or bool(chain.co_moving))
        if self.elastic:
            self._compile()
        self.begin()

    def _compile(self) -> None:
        """Take the kernels as compiled for this robot's types: a look calls each a few times."""
        zero, torque = np.zeros(self.model.unknowns), np.zeros(self.model.joints)
        self._place = entry(place, self.held, self.steady, zero)
        self._set_scale = entry(set_scale, self.held, self.steady, SOFT, 0.0, SOFT)
        self._factorize = entry(factorize, self.held, self.steady)
        self._solve = entry(solve, self.held, self.steady, zero, zero)
        self._residual = entry(residual, self.chain, self.work, zero, zero, zero, torque, zero)
        self._stiffness_times = entry(stiffness_times, self.chain, self.work, zero, 1.0, zero)

    def begin(self) -> None:
        """Start anew, from the same vector in every run."""
        self.vector = np.sin(1.0 + np.arange(self.model.unknowns, dtype=float))
        self.fresh = True

    def glances(self, x: np.ndarray, v: np.ndarray, a: np.ndarray) -> Generator[None, None, float]:
        """Minus lambda, or 0 where loads stiffen, at unknowns x, rates v, accelerations a (n,)."""
        if not self.elastic:
            return 0.0
        found = 0.0
        steps = FIRST_STEPS if self.fresh else 1
        for _ in range(steps):
            found = yield from self.improve(x, v, a)
            self.fresh = False
        return max(0.0, found)

    def improve(self, x: np.ndarray, v: np.ndarray, a: np.ndarray) -> Generator[None, None, float]:
        """One step of the iteration, in parts; returns minus Rayleigh's quotient of its vector."""
        chain, n = self.chain, self.model.unknowns
        torque, ahead, behind, stiff = np.zeros(self.model.joints), np.zeros(n), np.zeros(n), np.zeros(n)
        self._place(self.held, self.steady, x)
        self._set_scale(self.held, self.steady, SOFT, 0.0, SOFT)
        if self._factorize(self.held, self.steady) != 0:
            return 0.0
        if self.model.scene.loops:
            self._residual(self.held, self.steady, x, np.zeros(n), np.zeros(n), torque, behind)
            linearise_loops(self.held.loops, self.held, self.steady, np.zeros(n))
            keep_closed(self.held.loops, self.held, self.steady, behind, 1.0)
        if self.fresh:
            for _ in range(SMOOTHING):
                self.take(self.vector)
        yield
        y = self.vector
        size = DIFFERENCE / (np.max(np.abs(y)) or 1.0)
        self._residual(chain, self.work, x + size * y, v, a, torque, ahead)
        self._residual(chain, self.work, x - size * y, v, a, torque, behind)
        whole = (behind - ahead) / (2.0 * size)
        yield
        self._place(chain, self.work, x)
        self._stiffness_times(chain, self.work, y, 1.0, stiff)
        energy, lost = float(y @ stiff), stiff - whole
        quotient = float(y @ lost) / energy if energy > 0.0 else 0.0
        # shifted where the loads stiffen, so that what they soften comes forward
        self.take(lost + max(0.0, -quotient) * stiff)
        return quotient

    def take(self, load: np.ndarray) -> None:
        """Let the vector be what this load (n,) does to the elastic robot, scaled."""
        answer = np.zeros(self.model.unknowns)
        self._solve(self.held, self.steady, load, answer)
        if self.model.scene.loops:
            project(self.held.loops, self.held, self.steady, answer)
        scale = float(np.max(np.abs(answer)))
        if np.isfinite(scale) and scale > 0.0:
            self.vector = answer / scale


def with_joints(chain: Chain, joint: np.ndarray) -> Chain:
    """The chain with another table of joints (L, .)."""
    fields = {name: getattr(chain, name) for name in Chain._fields}
    own = aligned(joint)
    own.flags.writeable = False  # like the chain's: another type would be compiled for anew
    return by_reference(Chain(**{**fields, "joint": own}))


def with_its_effect(model: Model) -> Chain:
    """The chain of the model's scene with the effect `centrifugal`; its unknowns are the same."""
    effects = model.scene.effects.model_copy(update={"centrifugal": True})
    return Tables(model.scene.model_copy(update={"effects": effects}), model.planar, model.driven).chain()
