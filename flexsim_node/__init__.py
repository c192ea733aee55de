"""The flexible robot: scene -> model -> equations -> integrators -> simulate."""

from .linearization import LinearModel, linearize
from .modes import Modes, mode_shapes, natural_frequencies
from .scene import Scene, SceneError, load_scene
from .simulate import Run, simulate
from .statics import StaticEquilibrium, static_equilibrium

__all__ = [
    "LinearModel",
    "Modes",
    "Run",
    "Scene",
    "SceneError",
    "StaticEquilibrium",
    "linearize",
    "load_scene",
    "mode_shapes",
    "natural_frequencies",
    "simulate",
    "static_equilibrium",
]
