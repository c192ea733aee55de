"""Accelerations at a step's end, as sensors read them: under loads without their jumps.

A load that is held over steps, a node's command or an array, jumps from step to step.  Each mode answers a
jump; before the jump of a regular sequence its acceleration lags by half a jump over its mass, in all modes
alike, so that a force's own point reads sums of modes that grow with finer elements.  Under the mean of the
loads before and after the jump nothing is left of that:

    a = a0 + (M + g C + g^2 K)^-1 (f(x, v, mean load) - M a0)

a0 is the acceleration that the method has.  g is zero for a method that follows every mode; for one that
damps what it does not resolve, half a jump shows in a0 as this with the g of the method
(rosenbrock_w.SMOOTHING), and modes slower than g get the accelerations of the equations.

For rosenbrock_w, with L the matrix of (x, v)' = L (x, v), h the step, R its stability function and
r = R / (1 - R) the answer to jumps d that repeat:

    r(mu) = (1 + (1 - 2 gamma) mu) / (mu (gamma^2 mu - 1)),  L r(h L) (L^-1 d) = -1/2 (1 - gamma^2 h L)^-1 d

so that g = gamma^2 h; 1/2 comes of (1 - gamma)^2.

Loads without jumps leave another error.  A mode that the step hardly resolves has a small error e in its
displacement.  In the equations of motion that is an error k e / m of its acceleration, which can be larger
than the acceleration itself.  The difference of the rates of three states has no such error.  With it for a0
and the step h for g,

    a = a0 + (M + h C + h^2 K)^-1 (f(x, v) - M a0)

takes the acceleration of the equations for modes that the step resolves, and the difference for the others.
"""

from __future__ import annotations

import numpy as np

from ...compiled.kernel import kernel
from ...model.chain import ALPHA, BETA, COORDINATES, Workspace
from ...model.model import Model
from ..constraints.closure import keep_closed, linearise_loops
from ..constraints.friction import stick
from ..solve.factorization import factorize, set_scale
from ..solve.substitution import solve
from .acceleration import NOT_CONVERGED, OK, SINGULAR
from .residual import residual

ROUNDING = 1e-9
"""A jump is none below this part of its load: the times at which loads are asked for are rounded."""


@kernel
def end_acceleration(chain, work, x, v, torque, g, a):
    """Correct accelerations a (n,) as above, with the loads in work.external.  Returns a status.

    Held joints keep theirs.  a stays as it is where the status is not OK.
    """
    rhs, da = work.vector[1], work.vector[2]
    damped = 1.0 / (1.0 + g * chain.setting[ALPHA])
    m = int(chain.setting[COORDINATES])
    scale = g * (chain.setting[BETA] + g) * damped
    if work.scale[0] != scale or work.scale[1] != g:
        set_scale(chain, work, scale, g, g * g)
    residual(chain, work, x, v, a, torque, rhs)
    if factorize(chain, work) != 0:
        return SINGULAR
    linearise_loops(chain.loops, chain, work, v)
    solve(chain, work, rhs, da)
    keep_closed(chain.loops, chain, work, da, damped)
    for i in range(a.size):
        da[i] = a[i] + (da[i] if i < m else damped * da[i])
    if not stick(chain, work, da):
        return NOT_CONVERGED
    for i in range(a.size):
        a[i] = da[i]
    return OK


def end_accelerations(
    model: Model,
    work: Workspace,
    x: np.ndarray,
    v: np.ndarray,
    torques: Jumps,
    loads: Jumps,
    rates: Rates,
    g: float | None,
    fresh: bool,
    a: np.ndarray,
    felt: np.ndarray,
) -> None:
    """Accelerations (n,) at a step's end from those that a method has in a, with buffers of their own.

    a gets those that go with the links' strains, under the loads of the step; `felt` those under the mean of
    loads before and after the coming jump, or by the differences of rates.  With g None the method's own are
    both.

    fresh : a is of a first stage, none of a step
    """
    work.loaded[:] = np.any(loads.end.reshape(2, -1), axis=1) | np.any(loads.seen[0].reshape(2, -1), axis=1)
    now = work.external.reshape(-1)
    now[:] = loads.end
    if g is not None and (fresh or g == 0.0):
        end_acceleration(model.chain, work, x, v, torques.end, g, a)
    felt[:] = a
    if g is None:
        return
    if np.any(torques.coming()) or np.any(loads.coming()):
        now[:] = loads.mean()
        end_acceleration(model.chain, work, x, v, torques.mean(), g, felt)
        now[:] = loads.end
    elif g > 0.0 and rates.known() and not (np.any(torques.seen) or np.any(loads.seen)):
        rates.accelerations(felt)
        end_acceleration(model.chain, work, x, v, torques.end, rates.step_size, felt)


class Rates:
    """Rates (n,) of the last three states, one step (s) apart, the latest first.

    free : (n,) whether an unknown's motion follows from the equations; the others' is given
    """

    def __init__(self, size: int, step_size: float) -> None:
        self.step_size, self.free = step_size, np.ones(size, dtype=bool)
        self.seen, self.count = np.zeros((3, size)), 0

    def begin(self, v: np.ndarray) -> None:
        """Forget what was."""
        self.seen[0], self.count = v, 1

    def step(self, v: np.ndarray) -> None:
        """Take note of a step's end."""
        self.seen[1:] = self.seen[:-1]
        self.seen[0] = v
        self.count += 1

    def known(self) -> bool:
        """Whether there are three."""
        return self.count >= len(self.seen)

    def accelerations(self, a: np.ndarray) -> None:
        """Write the difference of second order at the last state into a (n,), for the free unknowns."""
        now, before, earlier = self.seen
        found = (1.5 * now - 2.0 * before + 0.5 * earlier) / self.step_size
        a[self.free] = found[self.free]


class Jumps:
    """Jumps of loads (k,) from step to step, and the mean of a load before and after the coming one.

    A load whose last jumps change evenly, or go in the same direction, is taken for held samples of one.
    The coming jump is then the last one and half of its change: what rosenbrock_w lacks, beside half a jump,
    is of its change T^2 / 2 + (2 gamma - 3/4) T with T = 1 / (1 + g^2 k / m), a third for slow modes and a
    fifth in the mean over a beam's modes.  A single jump is a step of the load, and nothing is foreseen.
    """

    def __init__(self, size: int) -> None:
        self.end = np.zeros(size)
        self.seen = np.zeros((3, size))  # the last jumps, the latest first

    def begin(self, load: np.ndarray) -> None:
        """Forget what was, and begin under a load."""
        self.end[:] = load
        self.seen[:] = 0.0

    def step(self, start: np.ndarray, end: np.ndarray) -> None:
        """Take note of a step's load at its start and at its end."""
        self.seen[1:] = self.seen[:-1]
        jump = start - self.end
        self.seen[0] = np.where(np.abs(jump) > ROUNDING * np.abs(start), jump, 0.0)
        self.end[:] = end

    def coming(self) -> np.ndarray:
        """(k,) the jump that is foreseen."""
        last, before, earlier = self.seen
        change, change_before = last - before, before - earlier
        largest = np.maximum(np.abs(change), np.abs(change_before))
        even = (change * change_before > 0.0) & (np.abs(change - change_before) <= 0.5 * largest)
        size, size_before = np.abs(last), np.abs(before)
        limited = np.clip(1.5 * size - 0.5 * size_before, 0.0, 1.5 * np.minimum(size, size_before))
        limited = np.where(last * before > 0.0, np.sign(last) * limited, 0.0)
        return np.asarray(np.where(even, last + 0.5 * change, limited))

    def mean(self) -> np.ndarray:
        """(k,) of the load now and the one foreseen for the coming step."""
        return np.asarray(self.end + 0.5 * self.coming())
