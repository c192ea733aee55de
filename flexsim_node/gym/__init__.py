"""Environments for learning: any scene as a Gymnasium environment, one robot or many."""

try:
    import gymnasium  # noqa: F401
except ImportError as problem:
    raise ImportError(f"flexsim_node.gym needs gymnasium ({problem}): pip install 'gymnasium>=1.1'") from None

from .arm import FlexibleArm
from .arms import FlexibleArms
from .episodes import Servo
from .tasks import Reach, Settle, Task, Track

__all__ = ["FlexibleArm", "FlexibleArms", "Reach", "Servo", "Settle", "Task", "Track"]
