"""What flexsim's simulators share of ROS 2: the standard's services, a process that starts and ends well.

It stands beside the messages since it is what these are spoken with: nothing here knows of a robot or a door.
What is named here is imported when it is asked for: `start` and `published_scene` need no ROS, and a process
is to answer signals before ROS is loaded.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .commanders import others
    from .diagnostics import named
    from .entities import Entity
    from .parameters import OF_ROS, declare_parameters, given_parameters
    from .process import run_node, spin_through
    from .simulation_services import SimulationServices, Simulator
    from .status import QUIT, SimulatorStatus, StatusPublisher

PLACES = {
    "OF_ROS": "parameters",
    "QUIT": "status",
    "Entity": "entities",
    "SimulationServices": "simulation_services",
    "Simulator": "simulation_services",
    "SimulatorStatus": "status",
    "StatusPublisher": "status",
    "declare_parameters": "parameters",
    "given_parameters": "parameters",
    "named": "diagnostics",
    "others": "commanders",
    "run_node": "process",
    "spin_through": "process",
}

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
    "named",
    "others",
    "run_node",
    "spin_through",
]


def __getattr__(name: str) -> Any:
    if name not in PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f".{PLACES[name]}", __name__), name)
