"""What goes wrong on purpose."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from .link import Payload
from .part import Misplaced, Name, NotNegative, Number, Part, Positive, Vector, between

Signal = Literal["position", "velocity", "effort"]
Duration = Annotated[Number, between(0.0, 10.0, "s", "seconds")]
# kind of a fault: what it needs, and what else it may have
FAULTS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "delay": (("time",), ()),
    "jitter": (("time",), ()),
    "drop": (("probability",), ()),
    "repeat": (("probability", "time"), ()),
    "lag": (("time_constant",), ("joints",)),
    "saturate": (("limit",), ("joints",)),
    "quantize": (("signal", "resolution"), ("joints",)),
    "bias": (("signal", "value"), ("joints",)),
    "noise": (("signal", "deviation"), ("joints",)),
    "freeze": (("signal",), ("joints",)),
    "disturbance": (("value",), ("joints",)),
    "payload": (("link", "mass"), ("center_of_mass", "inertia")),
}


class Fault(Part):
    """Something that goes wrong on purpose, from `start` to before `end`, s since the robot's first state.

    Commands are delayed, jittered, dropped, repeated; actuators lag and saturate; sensors are quantized,
    biased, noisy, frozen; joints are pushed; a link's payload is another one.
    """

    kind: Literal[
        "delay", "jitter", "drop", "repeat", "lag", "saturate",
        "quantize", "bias", "noise", "freeze", "disturbance", "payload",
    ]  # fmt: skip
    start: NotNegative = 0.0
    end: Positive | None = None
    joints: Annotated[tuple[Name, ...], Field(min_length=1)] | None = None
    time: Duration | None = None
    probability: Annotated[Number, between(0.0, 1.0, "")] | None = None
    time_constant: Positive | None = None
    limit: NotNegative | None = None
    signal: Signal | None = None
    resolution: Positive | None = None
    value: Number | None = None
    deviation: NotNegative | None = None
    link: Name | None = None
    mass: NotNegative | None = None
    center_of_mass: Vector | None = None
    inertia: tuple[Vector, Vector, Vector] | None = None

    @model_validator(mode="after")
    def _of_its_kind(self) -> Fault:
        needed, possible = FAULTS[self.kind]
        for key in type(self).model_fields:
            given = getattr(self, key) is not None
            if key in needed and not given:
                raise ValueError(f"lacks {key}; {self.kind} needs {', '.join(needed)}")
            if given and key not in (*needed, *possible, "kind", "start", "end"):
                known = ", ".join((*needed, *possible, "start", "end"))
                raise Misplaced((key,), f"has no meaning for {self.kind}; give {known}")
        if self.end is not None and self.end <= self.start:
            raise Misplaced(("end",), f"is {self.end:g}, not after start {self.start:g}; give a later time")
        self.body()  # refuses an inertia that no body can have
        return self

    def body(self) -> Payload:
        """What a link carries while this payload lasts."""
        centre = self.center_of_mass or (0.0, 0.0, 0.0)
        return Payload(mass=self.mass or 0.0, center_of_mass=centre, inertia=self.inertia)
