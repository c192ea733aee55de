"""What a scene says of how its leaf bends: where it is held, how loosely, and what it does at its yield.

Numbers are SI.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from flexsim_core.quantities import Misplaced, Part
from pydantic import BeforeValidator, Field, model_validator

from .quantities import Count, Number, Position, Positive, between

Play = Annotated[Number, between(0.0, 0.1, "m", "metres, not millimetres")]
Stiffness = Annotated[Number, between(1e3, 1e13, "N/m", "newtons per metre, not per millimetre")]
Inset = Annotated[Number, between(0.0, 0.2, "m", "metres, not millimetres")]


def _point(value: Any) -> Any:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return {"height": value}
    if not isinstance(value, (dict, Part)):
        raise ValueError(f"is {value!r}; give a height in m, or keys such as {{height: 0.8, play: 0.001}}")
    return value


class Hinge(Part):
    """A hinge: a height alone, or with its own play and stiffness.

    height : m from the leaf's centre
    play : m that it lets the leaf move either way before it holds
    stiffness : N/m against moving through the leaf's plane; left out, rigid
    """

    height: Position
    play: Play | None = None
    stiffness: Stiffness | None = None


class Lock(Hinge):
    """A point that a bolt holds: a height on the latch edge, or `across` as well, m from the centre."""

    across: Position | None = None


AnyHinge = Annotated[Hinge, BeforeValidator(_point)]
AnyLock = Annotated[Lock, BeforeValidator(_point)]


def _several(value: Any) -> Any:
    if value is None:
        return ()
    return value if isinstance(value, (list, tuple)) else (value,)


Edge = Literal["hinge", "latch", "top", "bottom"]


class StopPart(Part):
    """The frame's stop, which the leaf shuts against: it holds one way.

    edges : where it is; clearance : m between it and the leaf before the fire
    """

    edges: Annotated[tuple[Edge, ...], Field(min_length=1)] = ("hinge", "latch", "top")
    clearance: Play = 0.0


class DeformationPart(Part):
    """Thermo-elastic deformation of the leaf.

    hinges : in any order, on `hinge_side`: heights, m from the leaf's centre, or one set of keys each
    hinge_line : m from the leaf's edge to the line of the hinges
    hinge_play, hinge_stiffness, lock_play, lock_stiffness : of all that do not say
    lock : height of the lock on the other side, one or several; null for none
    opens : which way; the frame's `stop` is on the other side. Left out, there is no stop
    yielding : layered: sheets yield at their yield strength, in every layer of the shell
    in_plane, layers : elements across and up the whole leaf, and through each layer
    interval : s between solutions
    """

    model: Literal["none", "solid", "shell"] = "none"
    hinge_side: Literal["left", "right"] = "left"
    hinges: Annotated[tuple[AnyHinge, ...], Field(min_length=1)] | None = None
    hinge_line: Inset = 0.0
    hinge_play: Play = 0.0
    hinge_stiffness: Stiffness | None = None
    lock: Annotated[tuple[AnyLock, ...], BeforeValidator(_several)] = (Lock(height=0.0),)
    lock_play: Play = 0.0
    lock_stiffness: Stiffness | None = None
    opens: Literal["towards_fire", "away_from_fire"] | None = None
    stop: StopPart | None = None
    yielding: Literal["none", "layered"] = "none"
    in_plane: tuple[Count, Count] = (32, 64)
    layers: tuple[Count, ...] | None = None
    interval: Positive = 300.0

    @model_validator(mode="after")
    def _agrees(self) -> DeformationPart:
        if self.opens is None and self.stop is not None:
            raise Misplaced(
                ("stop",),
                "is on no side; give opens: towards_fire, or away_from_fire, and it is on the other side",
            )
        if self.yielding == "layered" and self.model == "solid":
            raise Misplaced(
                ("yielding",),
                "is layered, which the bricks of model: solid do not do; give model: shell, or yielding: none"
                " and look at the utilisation",
            )
        return self
