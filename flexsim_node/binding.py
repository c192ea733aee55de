"""One handle for everything a step works on, so that calling a step from Python costs a microsecond.

Passing a tuple of some thirty arrays to compiled code takes several microseconds, more than a planar step.
"""

from __future__ import annotations

from numba import types
from numba.experimental import structref

from .integrators import generalized_alpha, rosenbrock_w, runge_kutta_4
from .kernel import allocating_kernel


@structref.register
class BoundRobotType(types.StructRef):
    """Numba's type of a BoundRobot."""

    def preprocess_fields(self, fields):
        """Forget literal values of the fields' types."""
        return tuple((name, types.unliteral(kind)) for name, kind in fields)


class BoundRobot(structref.StructRefProxy):
    """Chain, workspace, state and drive of one robot."""


structref.define_proxy(
    BoundRobot, BoundRobotType, ["chain", "work", "x", "v", "torque", "motion"]
)


@allocating_kernel
def bind(chain, work, x, v, torque, motion):
    """Tie the arrays together."""
    return BoundRobot(chain, work, x, v, torque, motion)


@allocating_kernel
def rosenbrock_w_step(robot, h, option):
    """One step of rosenbrock_w; returns a status."""
    return rosenbrock_w.step(
        robot.chain, robot.work, robot.x, robot.v, robot.torque, robot.motion, h, option
    )


@allocating_kernel
def generalized_alpha_step(robot, h, option):
    """One step of generalized_alpha; returns a status."""
    return generalized_alpha.step(
        robot.chain, robot.work, robot.x, robot.v, robot.torque, robot.motion, h, option
    )


@allocating_kernel
def runge_kutta_4_step(robot, h, option):
    """One step of runge_kutta_4; returns a status."""
    return runge_kutta_4.step(
        robot.chain, robot.work, robot.x, robot.v, robot.torque, robot.motion, h, option
    )


STEPPERS = {
    "rosenbrock_w": rosenbrock_w_step,
    "generalized_alpha": generalized_alpha_step,
    "runge_kutta_4": runge_kutta_4_step,
}
