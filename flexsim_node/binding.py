"""One handle for everything a step works on, so that calling a step from Python costs a microsecond.

Passing a tuple of some thirty arrays to compiled code takes several microseconds, more than a planar step.
"""

from __future__ import annotations

from numba import types
from numba.experimental import structref

from .integrators import METHODS
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


def _stepper(method):
    step = method.step

    @allocating_kernel
    def advance(robot, h, option):
        return step(
            robot.chain, robot.work, robot.x, robot.v, robot.torque, robot.motion, h, option
        )

    return advance


STEPPERS = {name: _stepper(method) for name, method in METHODS.items()}
