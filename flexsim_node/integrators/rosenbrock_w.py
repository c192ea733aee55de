"""Two-stage Rosenbrock-W method (ROS2): two linear solves a step, no iteration, L-stable, second order.

For y' = F(y), with any approximation W of dF/dy (Verwer, Spee, Blom & Hundsdorfer, SIAM J. Sci. Comput. 20
(1999) 1456), gamma = 1 - 1/sqrt(2):

    (1 - gamma h W) k1 = F(y)
    (1 - gamma h W) k2 = F(y + h k1) - 2 k1
    y_new = y + h (3 k1 + k2) / 2

Here y = (x, v), v' = M(x)^-1 f(x, v), and W holds stiffness, Rayleigh damping and viscous friction.
Eliminating the x-part leaves (M + gamma h C + gamma^2 h^2 K) on the v-part, with

    f - gamma h K v                                       on the right of the first stage,
    f2 - 2 M2 k1 - gamma h K2 (h (1 - 2 gamma) k1 - v)    on the right of the second.

Each stage takes M, K and C where it stands: W then differs by O(h) between the stages, which costs nothing
in order.  Keeping the first stage's mass matrix in the second would save a factorisation, but pumps energy
into the modes of a turning robot (it blows up the falling two-link robot at 1 ms).
"""

from __future__ import annotations

from math import sqrt

from ..acceleration import NOT_FINITE, OK, SINGULAR, drive_joints, finite
from ..beam import kernel
from ..chain import ALPHA, BETA
from ..dynamics import residual
from ..factorization import factorize, set_scale, solve

GAMMA = 1.0 - 1.0 / sqrt(2.0)
ORDER = 2


@kernel
def step(chain, work, x, v, torque, motion, h, option):
    """Advance x, v (n,) by h; torque (3, m) and motion (3, 3, m) at start, middle, end.  Returns a status.

    x and v stay as they are where the status is not OK.
    """
    k1, k2, rhs, a, s = work.vector[0], work.vector[1], work.vector[2], work.vector[3], work.vector[6]
    x2, v2 = work.vector[4], work.vector[5]
    n, m = x.size, torque.shape[1]
    gh = GAMMA * h
    beta = chain.setting[BETA]
    # alpha M acts on the elastic rates: the same matrix with the elastic columns scaled
    damped = 1.0 / (1.0 + gh * chain.setting[ALPHA])
    scale = gh * (beta + gh) * damped
    if work.scale[0] != scale or work.scale[1] != gh:
        set_scale(chain, work, scale, gh)
    for i in range(n):
        x2[i], v2[i], a[i] = x[i], v[i], 0.0
    drive_joints(chain, work, motion[0], x2, v2, a)
    for i in range(n):
        s[i] = (beta + gh) * v2[i]
    residual(chain, work, x2, v2, a, s, torque[0], rhs)
    if factorize(chain, work) != 0:
        return SINGULAR
    solve(chain, work, rhs, k1)
    for i in range(m, n):
        k1[i] *= damped
    for i in range(n):
        x2[i] = x[i] + h * (v[i] + gh * k1[i])
        v2[i] = v[i] + h * k1[i]
        a[i] = 2.0 * k1[i]
    drive_joints(chain, work, motion[2], x2, v2, a)
    for i in range(n):
        s[i] = beta * v2[i] + gh * (h * (1.0 - 2.0 * GAMMA) * k1[i] - v[i])
    residual(chain, work, x2, v2, a, s, torque[2], rhs)
    if factorize(chain, work) != 0:
        return SINGULAR
    solve(chain, work, rhs, k2)
    for i in range(m, n):
        k2[i] *= damped
    for i in range(n):
        slope = v[i] + gh * k1[i]
        second = v[i] + h * k1[i] - 2.0 * slope + gh * k2[i]
        x2[i] = x[i] + h * (1.5 * slope + 0.5 * second)
        v2[i] = v[i] + h * (1.5 * k1[i] + 0.5 * k2[i])
    drive_joints(chain, work, motion[2], x2, v2, a)
    if not finite(x2, v2):
        return NOT_FINITE
    for i in range(n):
        x[i], v[i] = x2[i], v2[i]
    return OK
