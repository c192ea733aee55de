"""Fire doors in their furnace: heat, deformation, criteria. No file here but node.py knows ROS.

from thermal_node import load_scene, simulate
run = simulate(load_scene("config/thesis_door.yaml"), duration=3600.0, sample_period=60.0)
print(run.verdict)
"""

from .analysis.simulate import Run, simulate
from .burning.march import Heat, HeatBalance, Saved
from .burning.status import State, Status
from .compiled import kept_kernels as compiled  # noqa: F401  before any kernel is loaded
from .criteria.criteria import Criteria
from .criteria.tolerance import FurnaceTolerance
from .furnace.furnace import Measured
from .model.door_model import DoorModel, door_model
from .model.probes import InfraredView, Probes, probes_of
from .scene.load import Scene, SceneError, load_scene

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
