"""Two-stage Rosenbrock-W method (ROS2): one factorisation, two solves, L-stable, second order.

For y' = F(y), with any approximation W of dF/dy (Verwer, Spee, Blom & Hundsdorfer, SIAM J. Sci. Comput. 20
(1999) 1456), gamma = 1 - 1/sqrt(2):

    (1 - gamma h W) k1 = F(y)
    (1 - gamma h W) k2 = F(y + h k1) - 2 k1
    y_new = y + h (3 k1 + k2) / 2

Here y = (x, v), v' = M(x)^-1 f(x, v), and W holds stiffness, stiffness-proportional damping and viscous
friction: eliminating the x-part leaves M + gamma h C + gamma^2 h^2 K on the v-part.  In the second stage
M(x2)^-1 f2 is replaced by k1 + M(x)^-1 (f2 - M(x2) k1), which differs from it by O(h^2) and keeps the
order with the one factorisation.
"""

from __future__ import annotations

from math import sqrt

from ..acceleration import NOT_FINITE, OK, SINGULAR, drive_joints, finite
from ..beam import kernel
from ..chain import BETA, FIXED, KIND, PHI, VISCOUS, Q
from ..dynamics import residual, stiffness_times
from ..factorization import factorize, set_scale, solve

GAMMA = 1.0 - 1.0 / sqrt(2.0)
ORDER = 2


@kernel
def step(chain, work, x, v, torque, motion, h, option):
    """Advance x, v (n,) by h; torque (3, m) and motion (3, 3, m) at start, middle, end.  Returns a status.

    x and v stay as they are where the status is not OK.
    """
    k1, k2, rhs, other = work.vector[0], work.vector[1], work.vector[2], work.vector[3]
    x2, v2 = work.vector[4], work.vector[5]
    n = x.size
    gh = GAMMA * h
    beta = chain.setting[BETA]
    if work.scale[0] != gh * (beta + gh) or work.scale[1] != gh:
        set_scale(chain, work, gh * (beta + gh), gh)
    for i in range(n):
        x2[i], v2[i], other[i] = x[i], v[i], 0.0
    drive_joints(chain, work, motion[0], x2, v2, other)
    residual(chain, work, x2, v2, other, torque[0], gh, rhs)
    if factorize(chain, work) != 0:
        return SINGULAR
    solve(chain, work, rhs, k1)
    # gamma h (K (v + ((3 gamma - 1) h + beta) k1) + viscous k1) - first right-hand side
    for i in range(n):
        k2[i] = v2[i] + ((3.0 * GAMMA - 1.0) * h + beta) * k1[i]
    stiffness_times(chain, work, k2, gh, other)
    for i in range(n):
        rhs[i] = other[i] - rhs[i]
    for m in range(chain.link.shape[0]):
        if chain.link[m, KIND] != FIXED and chain.joint[m, VISCOUS] > 0.0:
            q, phi = chain.link[m, Q], chain.link[m, PHI]
            drag = gh * chain.joint[m, VISCOUS] * (k1[q] + (k1[phi] if phi >= 0 else 0.0))
            rhs[q] += drag
            if phi >= 0:
                rhs[phi] += drag
    for i in range(n):
        x2[i] = x[i] + h * (v[i] + gh * k1[i])
        v2[i] = v[i] + h * k1[i]
        k2[i] = k1[i]
    drive_joints(chain, work, motion[2], x2, v2, k2)
    residual(chain, work, x2, v2, k2, torque[2], 0.0, other)
    for i in range(n):
        rhs[i] += other[i]
    solve(chain, work, rhs, k2)
    for i in range(n):
        slope = v[i] + gh * k1[i]
        second = v[i] + h * k1[i] - 2.0 * slope + gh * k2[i]
        x2[i] = x[i] + h * (1.5 * slope + 0.5 * second)
        v2[i] = v[i] + h * (1.5 * k1[i] + 0.5 * k2[i])
    drive_joints(chain, work, motion[2], x2, v2, other)
    if not finite(x2, v2):
        return NOT_FINITE
    for i in range(n):
        x[i], v[i] = x2[i], v2[i]
    return OK
