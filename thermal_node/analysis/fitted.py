"""What a fit found: the parameters with their errors, the residuals, and what to know of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..heat.conduction import Array
from ..scene.load import Scene, changed
from .fit_residual import Residuals
from .identifiability import UNCERTAIN, Foreseen, Held
from .simulate import Run, simulate


@dataclass(frozen=True)
class FittedParameter:
    """One parameter: what it was, what it came out as, and its standard error.

    key : its short name, by which a prior is given; prior : value and standard deviation, if it had one
    """

    name: str
    unit: str
    before: float
    value: float
    standard_error: float
    key: str = ""
    prior: tuple[float, float] | None = None

    @property
    def interval(self) -> tuple[float, float]:
        """95 % interval; of a positive quantity, so symmetric in its logarithm."""
        spread = np.exp(1.96 * self.standard_error / self.value)
        return self.value / spread, self.value * spread

    @property
    def determined(self) -> bool:
        """Whether the log says anything about it."""
        return bool(self.standard_error < UNCERTAIN * self.value)


@dataclass(frozen=True)
class Fit:
    """A fitted scene.

    parameters; correlation (p, p) of their estimates; scene : the given one, the first, with them in it
    scenes : those of each log
    rms, rms_before : K, of the residual with the fitted and the given parameters
    each {name: K} : rms of each thermocouple's residual; residuals : more of them
    used : the thermocouples; evaluations : runs of the model; notes : what to know
    foreseen : what the logs could tell, before the fit; in it `held`, what was taken as the scene has it
    """

    scene: Scene
    parameters: tuple[FittedParameter, ...]
    correlation: Array
    rms: float
    rms_before: float
    used: tuple[str, ...]
    evaluations: int
    notes: tuple[str, ...]
    each: dict[str, float] = field(default_factory=dict)
    residuals: tuple[Residuals, ...] = ()
    foreseen: Foreseen | None = None
    scenes: tuple[Scene, ...] = ()

    @property
    def held(self) -> tuple[Held, ...]:
        """What was not fitted but taken as the scene has it, the most seen by the logs first."""
        return () if self.foreseen is None else self.foreseen.held

    def predict(
        self, overrides: dict[str, Any], duration: float = 3600.0, sample_period: float = 60.0
    ) -> Run:
        """Burn another door of the same make, e.g. {"leaf.width": 2.0, "leaf.height": 3.0}.

        Its mesh keeps the size of the bricks rather than their number.
        """
        larger = changed(self.scene, overrides)
        if "mesh.in_plane" not in overrides:
            was, leaf = self.scene.leaf, larger.leaf
            nx, ny = self.scene.mesh.in_plane
            counts = [
                max(4, round(nx * leaf.width / was.width)),
                max(4, round(ny * leaf.height / was.height)),
            ]
            larger = changed(larger, {"mesh.in_plane": counts})
        return simulate(larger, duration, sample_period)
