"""The flexible robot: scene -> model -> equations -> integrators -> simulate."""

from . import kept_kernels  # noqa: F401  before any kernel is loaded
from .decide import resolve_effects
from .decision import Decision
from .linearization import LinearModel, linearize
from .modes import Modes, mode_shapes, natural_frequencies
from .run import Run
from .scene import Scene, SceneError, load_scene
from .simulate import simulate
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
