"""What flexsim's simulators share of ROS 2: the standard's services, a process that starts and ends well.

It stands beside the messages since it is what these are spoken with: nothing here knows of a robot or a door.
"""

from .entities import Entity
from .process import handle_signals, run_node, spin_through
from .simulation_services import SimulationServices, Simulator

__all__ = ["Entity", "SimulationServices", "Simulator", "handle_signals", "run_node", "spin_through"]
