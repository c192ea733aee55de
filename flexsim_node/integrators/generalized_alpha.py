"""Generalized-alpha method (Chung & Hulbert, J. Appl. Mech. 60 (1993) 371): implicit, second order.

Equilibrium is met at the point alpha_f between start and end of the step by modified Newton iterations on
the end's acceleration; `option` is the spectral radius at infinite frequency.  Coulomb friction is one force
a step, which obeys its law at the rates of the step's end (friction.py).

The accelerations that the method carries belong to a time alpha_f - alpha_m steps before the end (Arnold &
Bruels, Multibody Syst. Dyn. 18 (2007) 185); those of the end are extrapolated from the last two.
"""

from __future__ import annotations

from ..compiled.kernel import kernel
from ..equations.constraints.closure import keep_closed, linearise_loops
from ..equations.constraints.friction import close_resting, rub, rub_by_rate, stand_still, stay
from ..equations.dynamics.acceleration import (
    LOOP_OPEN,
    NOT_CONVERGED,
    NOT_FINITE,
    NOT_VALID,
    OK,
    SINGULAR,
    acceleration,
    drive_joints,
    finite,
)
from ..equations.dynamics.residual import imbalance
from ..equations.dynamics.watch import valid
from ..equations.forces.external import load_at
from ..equations.solve.factorization import factorize, set_scale
from ..equations.solve.substitution import solve
from ..model.chain import BETA

ORDER = 2
SMOOTHING = None  # its accelerations are means over a step: a held load's jumps leave nothing in them
NEWTON_STEPS = 10
SMALL = 1e-4  # m and rad: a correction of the unknowns this small needs no further Newton step


@kernel
def start(robot):
    """Set the method's memory, the acceleration, from a state.  Returns a status."""
    chain, work, x, v, a = robot.chain, robot.work, robot.x, robot.v, robot.work.memory
    drive_joints(chain, work, robot.motion[0], x, v, a)
    load_at(work, 0.0)
    status = acceleration(chain, work, x, v, robot.torque[0], a)
    for i in range(x.size):
        work.arrival[i] = a[i]
    return status


@kernel
def step(robot, h, option, begin):
    """Advance a robot by h; to begin, only set the memory.  Returns a status.

    x, v and the memory stay as they are where the status is not OK.
    """
    if begin:
        return start(robot)
    chain, work, x, v = robot.chain, robot.work, robot.x, robot.v
    torque, motion = robot.torque, robot.motion
    a = work.memory
    rhs, da, an = work.vector[0], work.vector[1], work.vector[2]
    xm, vm, am, xe, ve = work.vector[3:8]
    mean = work.drive[0]
    n = x.size
    m = (2.0 * option - 1.0) / (option + 1.0)
    f = option / (option + 1.0)
    gamma = 0.5 - m + f
    quarter = 0.25 * (1.0 - m + f) ** 2
    damped = chain.setting[BETA]
    through = (1.0 - f) / (1.0 - m)
    scale = through * (quarter * h * h + gamma * h * damped)
    if work.scale[0] != scale or work.scale[1] != through * gamma * h:
        set_scale(chain, work, scale, through * gamma * h, through * quarter * h * h)
    for i in range(n):
        an[i] = a[i]
    size = 0.0
    for k in range(NEWTON_STEPS):
        for i in range(n):
            xe[i] = x[i] + h * v[i] + h * h * ((0.5 - quarter) * a[i] + quarter * an[i])
            ve[i] = v[i] + h * ((1.0 - gamma) * a[i] + gamma * an[i])
        drive_joints(chain, work, motion[2], xe, ve, an)
        if k == 0:
            rub_by_rate(chain, work, ve)
        for i in range(n):
            xm[i] = (1.0 - f) * xe[i] + f * x[i]
            vm[i] = (1.0 - f) * ve[i] + f * v[i]
            am[i] = (1.0 - m) * an[i] + m * a[i]
        between(torque, f, mean)
        load_at(work, 1.0 - f)
        imbalance(chain, work, xm, vm, am, mean, rhs)
        if factorize(chain, work) != 0:
            return SINGULAR
        linearise_loops(chain.loops, chain, work, vm)
        solve(chain, work, rhs, da)
        keep_closed(chain.loops, chain, work, da, 1.0)
        if not rub(chain, work, ve, da, gamma * h / (1.0 - m), 1.0, ve, 0.0):
            return NOT_CONVERGED
        size = 0.0
        for i in range(n):
            da[i] /= 1.0 - m
            an[i] += da[i]
            size = max(size, abs(da[i]) * quarter * h * h)
        work.correction[0] = size
        if not size < 1e6:
            return NOT_FINITE
        if size < SMALL:
            break
    if size >= SMALL:
        return NOT_CONVERGED
    for i in range(n):
        xe[i] = x[i] + h * v[i] + h * h * ((0.5 - quarter) * a[i] + quarter * an[i])
        ve[i] = v[i] + h * ((1.0 - gamma) * a[i] + gamma * an[i])
    stay(chain, work, x, v, xe)
    drive_joints(chain, work, motion[2], xe, ve, an)
    if not finite(chain, xe, ve):
        return NOT_FINITE
    if not close_resting(chain.loops, chain, work, xe, ve, rhs):
        return LOOP_OPEN
    stand_still(chain, work, ve)
    if not valid(chain, work):
        return NOT_VALID
    for i in range(n):
        work.arrival[i] = an[i] + (f - m) * (an[i] - a[i])
        x[i], v[i], a[i] = xe[i], ve[i], an[i]
    drive_joints(chain, work, motion[2], xe, ve, work.arrival)
    return OK


@kernel
def between(torque, f, out):
    """Torque at the equilibrium point, into out."""
    for i in range(torque.shape[1]):
        out[i] = (1.0 - f) * torque[2, i] + f * torque[0, i]
