"""What motors give over time."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import model_validator

from .part import Misplaced, NotNegative, Number, Part, Positive, between


class Torque(Part):
    """What a motor gives over time, between `start` and `end`; entries of one joint add up.

    constant: amplitude; sine: offset + amplitude sin(2 pi frequency (t - start) + phase); table: linear
    between its rows, held before the first and after the last.
    """

    joint: str
    type: Literal["constant", "sine", "table"]
    amplitude: Number = 0.0
    frequency: Annotated[Number, between(0.0, 1e5, "Hz")] = 0.0
    phase: Annotated[Number, between(-1e3, 1e3, "rad")] = 0.0
    offset: Number = 0.0
    start: NotNegative = 0.0
    end: Positive | None = None
    time: tuple[Number, ...] = ()
    value: tuple[Number, ...] = ()

    @model_validator(mode="after")
    def _complete(self) -> Torque:
        table = self.type == "table"
        if table and (len(self.time) < 1 or len(self.time) != len(self.value)):
            raise ValueError("is a table; give time and value, lists of the same length")
        if table and any(b <= a for a, b in zip(self.time, self.time[1:], strict=False)):
            raise ValueError("has a time that does not rise; give rising seconds")
        if not table and (self.time or self.value):
            raise ValueError(f"is of type {self.type}, which has no time and value; leave them out")
        for key in ("frequency", "phase", "offset"):
            if getattr(self, key) != 0.0 and self.type != "sine":
                raise Misplaced(
                    (key,), f"has no meaning for type {self.type}; leave it out, or give type: sine"
                )
        if table and self.amplitude != 0.0:
            raise Misplaced(
                ("amplitude",), "has no meaning for a table, whose value is the torque; leave it out"
            )
        if self.end is not None and self.end <= self.start:
            raise ValueError(f"ends at {self.end:g} s, not after its start; give a later end")
        return self
