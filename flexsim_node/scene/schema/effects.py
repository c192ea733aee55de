"""What of the physics is simulated."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import model_validator

from .part import Part

HELD_BY_FRAMES = ("centrifugal", "coriolis")  # effects that co-moving frames hold by their geometry

Switch = bool | Literal["auto"]  # auto: decided by what leaving it out changes at the tip


class Effects(Part):
    """What is simulated; an effect that is off is not computed."""

    gravity: Switch = True
    axial: Switch = True
    torsion: Switch = True
    bending_y: Switch = True
    bending_z: Switch = True
    shear: Switch = False
    rotary_inertia: Switch = True
    coriolis: Switch = True
    centrifugal: Switch = True
    damping: Switch = True
    joint_friction: Switch = True
    rotor_inertia: Switch = True
    joint_elasticity: Switch = True

    @model_validator(mode="before")
    @classmethod
    def _all_open(cls, value: Any) -> Any:
        return dict.fromkeys(cls.model_fields, "auto") if value == "auto" else value

    @property
    def undecided(self) -> tuple[str, ...]:
        """Names of the effects that are `auto`."""
        return tuple(name for name in type(self).model_fields if getattr(self, name) == "auto")
