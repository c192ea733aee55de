"""How the formulation and effects left to `auto` are decided, and what happens where that no longer holds."""

from __future__ import annotations

from typing import Annotated, Literal

from .part import Number, Part, between


class Auto(Part):
    """The envelope that formulation and effects are decided over, and who leaves it.

    margin : times the scene's torques, speeds, poses and duration that the decision is to hold for
    beyond : `warn`; `switch_on`, everything is simulated, in co-moving frames where the formulation is open;
        `stop`, the run ends with the last good state
    """

    margin: Annotated[Number, between(1.0, 10.0, "")] = 2.0
    beyond: Literal["warn", "switch_on", "stop"] = "warn"
