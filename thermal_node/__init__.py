"""Fire doors in their furnace: heat, deformation, criteria. No file here but node.py knows ROS.

from thermal_node import load_scene, simulate
run = simulate(load_scene("config/thesis_door.yaml"), duration=3600.0, sample_period=60.0)
print(run.verdict)
"""

from . import compiled  # noqa: F401  before any kernel is loaded
from .criteria import Criteria
from .furnace import Measured
from .heat import Heat, HeatBalance, Saved
from .model import DoorModel, door_model
from .probes import InfraredView, Probes, probes_of
from .scene import Scene, SceneError, load_scene
from .simulate import Run, simulate
from .status import State, Status
from .tolerance import FurnaceTolerance

__all__ = [
    "Criteria",
    "DoorModel",
    "FurnaceTolerance",
    "Heat",
    "HeatBalance",
    "InfraredView",
    "Measured",
    "Probes",
    "Run",
    "Saved",
    "Scene",
    "SceneError",
    "State",
    "Status",
    "door_model",
    "load_scene",
    "probes_of",
    "simulate",
]
