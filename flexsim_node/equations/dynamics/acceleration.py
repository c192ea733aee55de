"""Accelerations from forces, v' = M(x)^-1 f(x, v), for explicit and reference integrators."""

from __future__ import annotations

from ...compiled.kernel import kernel
from ...model.chain import COORDINATES, FIXED, KIND, MOTOR, Q
from ..constraints.closure import keep_closed, linearise_loops
from ..constraints.friction import rub_by_rate, rub_smoothly, stick
from ..solve.factorization import factorize, set_scale
from ..solve.substitution import solve
from .residual import imbalance

# what a step says happened
OK, NOT_FINITE, SINGULAR, NOT_CONVERGED, LOOP_OPEN, NOT_VALID, FRICTION_TOO_STIFF = range(7)
REASONS = {
    OK: "ok",
    NOT_FINITE: "the state grows beyond all bounds; give a smaller step or an implicit method",
    SINGULAR: "the mass matrix is singular; look at joints without inertia beyond them",
    NOT_CONVERGED: "the step's iteration did not converge; give a smaller step",
    LOOP_OPEN: "a loop can't be kept closed; look at the mechanism's singular configurations, at what"
    " prescribed joints ask of it, or give a smaller step",
    NOT_VALID: "the motion leaves the range of its equations",
    FRICTION_TOO_STIFF: "friction with this coulomb_speed changes faster than an explicit method can follow;"
    " leave coulomb_speed out, give a smaller step, or an implicit method",
}


@kernel
def encoder(link, n):
    """The unknown that a joint's motor turns: its own angle where a spring follows, else q."""
    return link[n, MOTOR] if link[n, MOTOR] >= 0 else link[n, Q]


@kernel
def drive_joints(chain, work, motion, x, v, a):
    """Impose the prescribed motion (3, m), position, velocity, acceleration, on the joints that are held."""
    link = chain.link
    for n in range(link.shape[0]):
        if work.held[n] and link[n, KIND] != FIXED:
            q, k = link[n, Q], encoder(link, n)
            x[k], v[k], a[k] = motion[0, q], motion[1, q], motion[2, q]


@kernel
def finite(chain, x, v):
    """Whether the state holds finite numbers only, and elastic displacements below a thousand m or rad."""
    bounded = True
    joints = chain.setting[COORDINATES]
    for i in range(x.size):
        bounded = bounded and abs(x[i]) < (1e3 if i >= joints else 1e12) and abs(v[i]) < 1e12
    return bounded


@kernel
def acceleration(chain, work, x, v, torque, out):
    """Write v' = M(x)^-1 f(x, v) into out (n,); held joints keep what out says of them.  Returns a status."""
    rub_by_rate(chain, work, v)
    return acceleration_sliding(chain, work, x, v, torque, out)


@kernel
def acceleration_sliding(chain, work, x, v, torque, out):
    """`acceleration` while joints rub the way, or stick, as `rub_by_rate` last found it."""
    link = chain.link
    a, rhs = work.vector[6], work.vector[7]
    a[:] = 0.0
    for n in range(link.shape[0]):
        if work.held[n] and link[n, KIND] != FIXED:
            a[encoder(link, n)] = out[encoder(link, n)]
    rub_smoothly(chain, work, v)
    imbalance(chain, work, x, v, a, torque, rhs)
    if work.scale[0] != 0.0 or work.scale[1] != 0.0:
        set_scale(chain, work, 0.0, 0.0, 0.0)
    if factorize(chain, work) != 0:
        return SINGULAR
    linearise_loops(chain.loops, chain, work, v)
    solve(chain, work, rhs, out)
    keep_closed(chain.loops, chain, work, out, 1.0)
    if not stick(chain, work, out):
        return NOT_CONVERGED
    for i in range(out.size):
        out[i] += a[i]
    return OK
