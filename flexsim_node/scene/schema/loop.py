"""Joints that close loops."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from .part import Misplaced, Name, Part, Vector

BASE = "base"  # the ground, as a link's parent


class ClosingJoint(Part):
    """A joint that closes a loop: where the ends of two links meet, or a link's end and the base.

    `at` are points, in the frames of the links' ends or in the base frame, where they are not these frames'
    origins; `axis` directions there: of a revolute joint (z where not given), of a universal joint's two
    pins, or along which the first link's point slides in a slot of the second.
    """

    name: str = ""
    links: Annotated[tuple[Name, ...], Field(min_length=2, max_length=2)]
    joint: Literal["revolute", "universal", "spherical", "fixed", "slot"] = "revolute"
    at: dict[Name, Vector] = Field(default_factory=dict)
    axis: dict[Name, Vector] = Field(default_factory=dict)

    @property
    def label(self) -> str:
        """Its name, or what it joins."""
        return self.name or " and ".join(self.links)

    def point(self, link: str) -> tuple[float, ...]:
        """(3,) where it sits, m, in the frame of the link's end."""
        return self.at.get(link, (0.0, 0.0, 0.0))

    def direction(self, link: str) -> np.ndarray:
        """(3,) unit vector of its axis in the frame of the link's end."""
        axis = np.array(self.axis.get(link, (0.0, 0.0, 1.0)))
        return axis / np.linalg.norm(axis)

    @model_validator(mode="after")
    def _consistent(self) -> ClosingJoint:
        if self.links[0] == self.links[1]:
            raise Misplaced(("links", 1), f"is {self.links[1]!r} again; give two different links")
        for key in ("at", "axis"):
            for name, vector in getattr(self, key).items():
                if name not in self.links:
                    raise Misplaced((key, name), f"is no link of this joint; give {' or '.join(self.links)}")
                if key == "axis" and not any(vector):
                    raise Misplaced((key, name), "is zero; give a direction")
        if self.joint in ("spherical", "fixed") and self.axis:
            raise Misplaced(("axis",), f"is given, but a {self.joint} joint has none; leave it out")
        if self.joint == "universal" and len(self.axis) < 2:
            raise Misplaced(
                ("axis",) if self.axis else ("joint",),
                f"needs the directions of its two pins; give axis: {{{self.links[0]}: [0, 0, 1],"
                f" {self.links[1]}: [1, 0, 0]}}",
            )
        if self.joint == "slot" and tuple(self.axis) != self.links[1:]:
            raise Misplaced(
                ("axis",) if self.axis else ("joint",),
                f"needs the slot's direction in the second link; give axis: {{{self.links[1]}: [1, 0, 0]}}",
            )
        return self
