"""Two-stage W-method: two linear solves a step, L-stable, second order.

The tableau is the stiffly accurate SDIRK method with gamma = 1 - 1/sqrt(2) (Alexander, SIAM J. Numer.
Anal. 14 (1977) 1006), whose stability function is that of the Rosenbrock method ROS2.  For
v' = M(x)^-1 f(x, v):

    V1 = v + gamma h A1                            X1 = x + gamma h V1
    V2 = v + (1 - gamma) h A1 + gamma h A2         X2 = x + (1 - gamma) h V1 + gamma h V2
    M(Xi) Ai = f(Xi, Vi)

Each stage takes one Newton step from the last stage's acceleration, with M + gamma h C + gamma^2 h^2 K at the
predicted Xi in place of the exact Jacobian.  The predictor is O(h) off and the matrix O(h) from exact, so the
stage is O(h^2) off and the order stays two for any C and K: a W-method in the sense of Steihaug & Wolfbrandt
(Math. Comp. 33 (1979) 521).

Where q follows the links' chords the second stage's factorisation serves the next step's first stage as well
(0.29 h away); elsewhere q swings with the elastic modes and that is not accurate enough.

Coulomb friction obeys its law at the rates of the step's end (friction.py), which are the second stage's; the
first stage takes v + h A1 for them, so that a joint stops without turning round. Smooth friction obeys at
either stage's.


Loops: each stage's acceleration keeps them closed in its second derivative, and the end of the step is
closed in position and velocity, corrections of third order in h that leave the method's order as it is.

Why not ROS2 itself: linearised about the start of the step, its stage forces in stiff directions (axial, and
bending of short elements) are out of balance once the links turn.  It stays of second order, but its error is
some eighty times larger on the driven anthropomorphic robot at 1 ms, and with one factorisation it blows up.
"""

from __future__ import annotations

from math import sqrt

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
    drive_joints,
    finite,
)
from ..equations.dynamics.residual import imbalance
from ..equations.dynamics.watch import valid
from ..equations.forces.external import load_at
from ..equations.solve.factorization import factorize, set_scale
from ..equations.solve.substitution import RESIDUAL, solve_within
from ..model.chain import ALPHA, BETA, COORDINATES, KEEP

GAMMA = 1.0 - 1.0 / sqrt(2.0)
ORDER = 2
# of a mode's response to a held load that jumps by the same in every step, what is missing in the stage's
# acceleration is half the jump over m (1 + g c + g^2 k), with this times h for g (end_acceleration.py)
SMOOTHING = GAMMA * GAMMA
NEWTON_STEPS = 10
SMALL = 1e-4  # m and rad: a correction of the unknowns this small needs no further Newton step
# Of the energy of a correction, what Rayleigh's alpha may leave: a ten-thousandth of the correction, and less
# than what the forces' curvature leaves. Closing joints would take what is left for theirs.
STAGE_RESIDUAL = 1e-8


@kernel
def choose_matrix(chain, work, h):
    """Set the stages' matrix, M + gamma h C + gamma^2 h^2 K, for a step h; tells whether it is a new one."""
    gh = GAMMA * h
    scale = gh * (chain.setting[BETA] + gh) / (1.0 + gh * chain.setting[ALPHA])
    if work.scale[0] != scale or work.scale[1] != gh:
        set_scale(chain, work, scale, gh, gh * gh)
        return True
    return False


@kernel
def stage(chain, work, x, v, torque, motion, gh, a, fresh, before, lag):
    """Correct a stage's acceleration a by Newton steps; x, v (predicted with a) are corrected with it.

    One step does for motion that the predictor follows; where a torque jumps, more are taken.  Unless `fresh`
    the first of them keeps the last factorisation.  `before` and `lag` as in `rub`.
    """
    rhs, da = work.vector[1], work.vector[2]
    damped = 1.0 / (1.0 + gh * chain.setting[ALPHA])
    m = int(chain.setting[COORDINATES])
    drive_joints(chain, work, motion, x, v, a)
    rub_by_rate(chain, work, v)
    for k in range(NEWTON_STEPS):
        imbalance(chain, work, x, v, a, torque, rhs)
        if (fresh or k > 0) and factorize(chain, work) != 0:
            return SINGULAR
        linearise_loops(chain.loops, chain, work, v)
        solve_within(chain, work, rhs, da, RESIDUAL if len(chain.loops) > 0 else STAGE_RESIDUAL)
        keep_closed(chain.loops, chain, work, da, damped)
        if not rub(chain, work, v, da, gh, damped, before, lag):
            return NOT_CONVERGED
        size = 0.0
        for i in range(x.size):
            # alpha M acts on the elastic rates alone: the same matrix with the elastic columns scaled
            correction = da[i] if i < m else damped * da[i]
            a[i] += correction
            v[i] += gh * correction
            x[i] += gh * gh * correction
            size = max(size, abs(gh * gh * correction))
        work.correction[0] = size
        if size < SMALL:
            return OK
        if not size < 1e6:
            return NOT_FINITE
    return NOT_CONVERGED


@kernel
def start(robot, h):
    """Set what the method keeps from step to step, the acceleration.  Returns a status.

    It is that of a first stage: the true one swings with the highest frequencies after a jump of torque.
    """
    chain, work, x, v = robot.chain, robot.work, robot.x, robot.v
    x1, v1, a = work.vector[3], work.vector[4], work.memory
    gh = GAMMA * h
    choose_matrix(chain, work, h)
    for i in range(x.size):
        a[i] = 0.0
        v1[i] = v[i]
        x1[i] = x[i] + gh * v[i]
    load_at(work, 0.0)
    status = stage(chain, work, x1, v1, robot.torque[0], robot.motion[0], gh, a, True, v, 0.0)
    for i in range(x.size):
        work.arrival[i] = a[i]
    return status


@kernel
def step(robot, h, option, begin):
    """Advance a robot by h; to begin, only set the memory.  Returns a status.

    x, v and the memory stay as they are where the status is not OK.
    """
    if begin:
        return start(robot, h)
    chain, work, x, v = robot.chain, robot.work, robot.x, robot.v
    torque, motion = robot.torque, robot.motion
    x1, v1, x2, v2, a = work.vector[3], work.vector[4], work.vector[5], work.vector[6], work.vector[7]
    n = x.size
    gh, rest = GAMMA * h, (1.0 - GAMMA) * h
    fresh = choose_matrix(chain, work, h) or chain.setting[KEEP] == 0.0
    between(torque, motion, GAMMA, work)
    for i in range(n):
        a[i] = work.memory[i]
    for i in range(n):
        v1[i] = v[i] + gh * a[i]
        x1[i] = x[i] + gh * v1[i]
    load_at(work, GAMMA)
    status = stage(chain, work, x1, v1, work.drive[0], work.drive[1:], gh, a, fresh, v, 1.0 - GAMMA)
    if status != OK:
        return status
    for i in range(n):
        v2[i] = v[i] + rest * a[i]
        x2[i] = x[i] + rest * v1[i]
        v2[i] += gh * a[i]
        x2[i] += gh * v2[i]
    load_at(work, 1.0)
    status = stage(chain, work, x2, v2, torque[2], motion[2], gh, a, True, v, 0.0)
    if status != OK:
        return status
    stay(chain, work, x, v, x2)
    drive_joints(chain, work, motion[2], x2, v2, a)
    if not finite(chain, x2, v2):
        return NOT_FINITE
    if not close_resting(chain.loops, chain, work, x2, v2, work.vector[1]):
        return LOOP_OPEN
    stand_still(chain, work, v2)
    if not valid(chain, work):
        return NOT_VALID
    for i in range(n):
        x[i], v[i], work.memory[i], work.arrival[i] = x2[i], v2[i], a[i], a[i]
    return OK


@kernel
def between(torque, motion, at, work):
    """Torque and motion at a fraction of the step, by the parabola through start, middle and end."""
    p = 2.0 * (at - 0.5) * (at - 1.0)
    q = 4.0 * at * (1.0 - at)
    r = 2.0 * at * (at - 0.5)
    drive = work.drive
    for k in range(torque.shape[1]):
        drive[0, k] = p * torque[0, k] + q * torque[1, k] + r * torque[2, k]
        for i in range(3):
            drive[1 + i, k] = p * motion[0, i, k] + q * motion[1, i, k] + r * motion[2, i, k]
