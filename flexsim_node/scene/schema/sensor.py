"""Virtual instruments."""

from __future__ import annotations

import re
from typing import Annotated, Literal

from pydantic import AfterValidator, model_validator

from .link import Link
from .part import Number, Part, between


def _of_a_topic(name: str) -> str:
    """A name that a ROS topic can have."""
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", name):
        raise ValueError(f"is {name!r}; give letters, digits and _, a letter first")
    return name


class Sensor(Part):
    """A virtual instrument on a link; `at` (m) or `fraction` of its length, from its start, or its end."""

    name: Annotated[str, AfterValidator(_of_a_topic)]
    type: Literal["strain_gauge", "imu", "pose", "section_force"]
    link: str | None = None
    at: Annotated[Number, between(0.0, 1e2, "m", "metres from the link's start")] | None = None
    fraction: Annotated[Number, between(0.0, 1.0, "")] | None = None
    side: Literal["+y", "-y", "+z", "-z"] | None = None
    point: tuple[Number, Number] | None = None

    @model_validator(mode="after")
    def _placed(self) -> Sensor:
        if self.at is not None and self.fraction is not None:
            raise ValueError("has both at and fraction; give one of the two")
        if self.name == "strain_gauges":
            raise ValueError("is named strain_gauges, as the topic of all gauges is; give another name")
        gauge = self.type == "strain_gauge"
        if gauge and (self.side is None) == (self.point is None):
            raise ValueError("is a strain gauge; give side (+y, -y, +z, -z), or point: [y, z] in m")
        if not gauge and (self.side is not None or self.point is not None):
            raise ValueError(f"is of type {self.type}, which has no side or point; leave them out")
        return self

    def place(self, link: Link) -> float:
        """Distance from the link's start, m."""
        if self.at is not None:
            return self.at
        return link.length * (1.0 if self.fraction is None else self.fraction)

    def point_on(self, link: Link) -> tuple[float, float]:
        """Where on the section, (y, z) in beam axes, m."""
        if self.point is not None:
            return self.point
        beam, side = link.beam, self.side or "+y"
        assert beam is not None and beam.width is not None and beam.depth is not None
        half = (0.5 if side[0] == "+" else -0.5) * (beam.width if side[1] == "y" else beam.depth)
        return (half, 0.0) if side[1] == "y" else (0.0, half)

    def complaint(self, link: Link) -> tuple[str, str] | None:
        """What is wrong with the sensor on this link: key and sentence, or None."""
        if self.place(link) > link.length * (1.0 + 1e-12):
            return "at", f"is {self.at:g}; {link.name} ends at {link.length:g} m"
        beam = link.beam
        if self.type == "strain_gauge":
            if beam is None or not link.flexible:
                return "link", f"is {link.name!r}, which is rigid and has no strain; give a flexible link"
            if self.side is not None and (beam.width is None or beam.depth is None):
                return "side", f"is {self.side!r}, but {link.name} has no width and depth; give point: [y, z]"
            if self.point is not None and beam.width is not None and beam.depth is not None:
                y, z = abs(self.point[0]), abs(self.point[1])
                if y > 0.5 * beam.width * (1 + 1e-9) or z > 0.5 * beam.depth * (1 + 1e-9):
                    return (
                        "point",
                        f"lies outside the section of {link.name}, {beam.width:g} x {beam.depth:g} m",
                    )
        if self.type == "section_force" and beam is None:
            return "link", f"is {link.name!r}, which has no beam; give a link with one"
        return None
