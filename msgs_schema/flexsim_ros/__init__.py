"""What flexsim's simulators share of ROS 2: the standard's services, a process that starts and ends well.

It stands beside the messages since it is what these are spoken with: nothing here knows of a robot or a door.
"""

from .diagnostics import named
from .entities import Entity
from .parameters import OF_ROS, declare_parameters, given_parameters
from .process import handle_signals, run_node, spin_through
from .simulation_services import SimulationServices, Simulator
from .status import QUIT, SimulatorStatus, StatusPublisher

__all__ = [
    "OF_ROS",
    "QUIT",
    "Entity",
    "SimulationServices",
    "Simulator",
    "SimulatorStatus",
    "StatusPublisher",
    "declare_parameters",
    "given_parameters",
    "handle_signals",
    "named",
    "run_node",
    "spin_through",
]
