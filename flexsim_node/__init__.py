"""The flexible robot: scene -> model -> equations -> integrators -> simulate."""

from .analysis.decide import resolve_effects
from .analysis.linearization import LinearModel, linearize
from .analysis.many_runs import Runs
from .analysis.modes import Modes, mode_shapes, natural_frequencies
from .analysis.simulate import simulate
from .analysis.simulate_many import simulate_many
from .analysis.statics import StaticEquilibrium, static_equilibrium
from .compiled import kept_kernels  # noqa: F401  before any kernel is loaded
from .motion.decision import Decision
from .motion.run import Run
from .scene.load import Scene, SceneError, load_scene

__all__ = [
    "Decision",
    "LinearModel",
    "Modes",
    "Run",
    "Runs",
    "Scene",
    "SceneError",
    "StaticEquilibrium",
    "linearize",
    "load_scene",
    "mode_shapes",
    "natural_frequencies",
    "resolve_effects",
    "simulate",
    "simulate_many",
    "static_equilibrium",
]
