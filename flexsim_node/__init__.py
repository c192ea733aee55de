"""The flexible robot: scene -> model -> equations -> integrators -> simulate."""

from . import kept_kernels  # noqa: F401  before any kernel is loaded
from .decision import Decision, resolve_effects
from .linearization import LinearModel, linearize
from .modes import Modes, mode_shapes, natural_frequencies
from .scene import Scene, SceneError, load_scene
from .simulate import Run, simulate
from .statics import StaticEquilibrium, static_equilibrium

__all__ = [
    "Decision",
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
    "resolve_effects",
    "simulate",
    "static_equilibrium",
]
