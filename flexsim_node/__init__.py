"""The flexible robot: scene -> model -> equations -> integrators -> simulate."""

from .modes import natural_frequencies
from .scene import Scene, SceneError, load_scene
from .simulate import Run, simulate
from .statics import StaticEquilibrium, static_equilibrium

__all__ = [
    "Run",
    "Scene",
    "SceneError",
    "StaticEquilibrium",
    "load_scene",
    "natural_frequencies",
    "simulate",
    "static_equilibrium",
]
