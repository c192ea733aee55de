"""How far a motion may go."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BeforeValidator, model_validator

from .part import Misplaced, Part, Positive


class Limits(Part):
    """Beyond `warn` a run says so; beyond `stop` it ends with the last good state."""

    warn: Positive | None = None
    stop: Positive | None = None

    @model_validator(mode="after")
    def _rising(self) -> Limits:
        if self.warn is not None and self.stop is not None and self.warn > self.stop:
            raise Misplaced(("warn",), f"is {self.warn:g}, above stop = {self.stop:g}; give a smaller one")
        return self


def _filled(warn: float | None, stop: float | None) -> Any:
    """Complete limits of which a scene gives one."""

    def filled(given: Any) -> Any:
        if not isinstance(given, dict):
            return given
        least = given.get("stop")
        # a stop below the usual warning is meant to stand alone
        alone = isinstance(least, (int, float)) and warn is not None and least < warn
        return {"warn": None if alone else warn, "stop": stop, **given}

    return BeforeValidator(filled)


class Validity(Part):
    """How far a motion may go from what its equations hold for.

    elastic_rotation (rad) from the rigid links; correction (m or rad) that a step's last iteration made;
    erls_condition and mass_condition.  spin_ratio (spin over the first bending frequency of a link with what
    it carries) stops a run where `centrifugal` is off; axial_load (over the buckling load) warns, and stops
    where `centrifugal` is off.  load_stiffness is the share of the stiffness that loads take (1: it buckles);
    where `centrifugal` is off it is what the motion leaves out, and warns from a tenth on.
    """

    elastic_rotation: Annotated[Limits, _filled(0.1, 0.5)] = Limits(warn=0.1, stop=0.5)
    spin_ratio: Annotated[Limits, _filled(0.3, 1.0)] = Limits(warn=0.3, stop=1.0)
    axial_load: Annotated[Limits, _filled(0.5, 1.0)] = Limits(warn=0.5, stop=1.0)
    correction: Annotated[Limits, _filled(None, None)] = Limits(warn=None, stop=None)
    erls_condition: Annotated[Limits, _filled(1e3, 1e8)] = Limits(warn=1e3, stop=1e8)
    mass_condition: Annotated[Limits, _filled(1e8, 1e14)] = Limits(warn=1e8, stop=1e14)
    load_stiffness: Annotated[Limits, _filled(0.5, None)] = Limits(warn=0.5, stop=None)
