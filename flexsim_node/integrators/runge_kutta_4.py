"""Classical Runge-Kutta method of order four; explicit: stable only below 2.8 / highest frequency.

A joint's Coulomb friction keeps its direction over a step.  A joint that turns round in it stops at its end,
if friction can hold it.  Smooth friction (`coulomb_speed`) that is too steep for the step ends the run.
"""

from __future__ import annotations

from ..compiled.kernel import kernel
from ..equations.constraints.friction import close_resting, rub_by_rate, stand_still, stop
from ..equations.dynamics.acceleration import (
    FRICTION_TOO_STIFF,
    LOOP_OPEN,
    NOT_CONVERGED,
    NOT_FINITE,
    NOT_VALID,
    OK,
    acceleration_sliding,
    drive_joints,
    finite,
)
from ..equations.dynamics.watch import valid
from ..equations.forces.external import load_at

ORDER = 4
SMOOTHING = 0.0  # it follows every mode that it can step


@kernel
def step(robot, h, option, begin):
    """Advance a robot by h; nothing has to be set to begin.  Returns a status.

    x and v stay as they are where the status is not OK.
    """
    if begin:
        return OK
    chain, work, x, v = robot.chain, robot.work, robot.x, robot.v
    torque, motion = robot.torque, robot.motion
    x2, v2, k = work.vector[0], work.vector[1], work.vector[2]
    dx, dv = work.vector[3], work.vector[4]
    n = x.size
    for i in range(n):
        x2[i], v2[i], dx[i], dv[i] = x[i], v[i], 0.0, 0.0
    rub_by_rate(chain, work, v)
    for stage in range(4):
        at = 0 if stage == 0 else (2 if stage == 3 else 1)
        drive_joints(chain, work, motion[at], x2, v2, k)
        load_at(work, 0.5 * at)
        status = acceleration_sliding(chain, work, x2, v2, torque[at], k)
        if status != OK:
            return status
        weight = h / 6.0 if at != 1 else h / 3.0
        reach = h if stage == 2 else 0.5 * h
        for i in range(n):
            dx[i] += weight * v2[i]
            dv[i] += weight * k[i]
            x2[i], v2[i] = x[i] + reach * v2[i], v[i] + reach * k[i]
    for i in range(n):
        x2[i], v2[i] = x[i] + dx[i], v[i] + dv[i]
    found, resolved = stop(chain, work, x2, v2, h)
    if not resolved:
        return FRICTION_TOO_STIFF
    if not found:
        return NOT_CONVERGED
    drive_joints(chain, work, motion[2], x2, v2, k)
    if not finite(chain, x2, v2):
        return NOT_FINITE
    if not close_resting(chain.loops, chain, work, x2, v2, work.vector[7]):
        return LOOP_OPEN
    stand_still(chain, work, v2)
    if not valid(chain, work):
        return NOT_VALID
    for i in range(n):
        x[i], v[i] = x2[i], v2[i]
    return OK
