"""The flexible robot: scene -> model -> equations -> integrators -> simulate."""

from importlib import import_module
from typing import TYPE_CHECKING

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

if TYPE_CHECKING:
    from .analysis.decide import resolve_effects
    from .analysis.linearization import LinearModel, linearize
    from .analysis.many_runs import Runs
    from .analysis.modes import Modes, mode_shapes, natural_frequencies
    from .analysis.simulate import simulate
    from .analysis.simulate_many import simulate_many
    from .analysis.statics import StaticEquilibrium, static_equilibrium
    from .motion.decision import Decision
    from .motion.run import Run
    from .scene.load import Scene, SceneError, load_scene
else:
    # Loaded when asked for: who only reads a scene need not wait for the compiler.
    _FILES = {
        "analysis.decide": ("resolve_effects",),
        "analysis.linearization": ("LinearModel", "linearize"),
        "analysis.many_runs": ("Runs",),
        "analysis.simulate_many": ("simulate_many",),
        "analysis.modes": ("Modes", "mode_shapes", "natural_frequencies"),
        "analysis.simulate": ("simulate",),
        "analysis.statics": ("StaticEquilibrium", "static_equilibrium"),
        "motion.decision": ("Decision",),
        "motion.run": ("Run",),
        "scene.load": ("Scene", "SceneError", "load_scene"),
    }
    _WHERE = {name: file for file, names in _FILES.items() for name in names}

    def __getattr__(name):
        if name not in _WHERE:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        globals()[name] = found = getattr(import_module(f"{__name__}.{_WHERE[name]}"), name)
        return found

    def __dir__():
        return sorted({*globals(), *__all__})
