"""A link of a robot: its joint, its beam, what it carries."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, SerializerFunctionWrapHandler, model_serializer, model_validator

from .part import (
    Angle,
    Density,
    Length,
    Misplaced,
    Modulus,
    Name,
    NotNegative,
    Number,
    Part,
    Place,
    Positive,
    Side,
    Vector,
    between,
    without_defaults,
)


class DenavitHartenberg(Part):
    """Standard parameters, A = Rz(theta) Tz(d) Tx(a) Rx(alpha)."""

    a: Length = 0.0
    alpha: Angle = 0.0
    d: Length = 0.0
    theta: Angle = 0.0


class Frame(Part):
    """A joint's frame in that of the parent, as URDF has it: place, then Rz(yaw) Ry(pitch) Rx(roll)."""

    xyz: Place = (0.0, 0.0, 0.0)
    rpy: Annotated[tuple[Angle, ...], Field(min_length=3, max_length=3)] = (0.0, 0.0, 0.0)


class Mesh(Part):
    """A picture of a rigid link, kept by its path for robot_description; not simulated."""

    mesh: Name
    frame: Frame = Frame()
    scale: Vector = (1.0, 1.0, 1.0)


class Joint(Part):
    """The joint at a link's start; q adds to theta or to d, or turns and slides a link of `frame`.

    axis : direction in the link's frame, of links with `frame`; z where not given

    stiffness (N m/rad or N/m) and damping stand between motor and link; rotor_inertia, friction and torque
    act on the motor.  Coulomb friction holds a joint at rest; with a coulomb_speed (rad/s or m/s) it is
    smooth, coulomb_friction tanh(rate / coulomb_speed), and a loaded joint creeps.
    """

    name: str = ""
    type: Literal["fixed", "revolute", "prismatic"] = "revolute"
    axis: Vector | None = None
    actuated: bool = True
    effort_limit: Positive | None = None
    viscous_friction: NotNegative = 0.0
    coulomb_friction: NotNegative = 0.0
    coulomb_speed: NotNegative = 0.0
    rotor_inertia: NotNegative = 0.0
    gear_ratio: Positive = 1.0
    stiffness: Positive | None = None
    damping: NotNegative = 0.0

    @model_serializer(mode="wrap")
    def _dumped(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return without_defaults(self, ("axis",), handler(self))

    @model_validator(mode="after")
    def _meaningful(self) -> Joint:
        """Refuse what a joint of this type, or without a motor, can't have."""
        if self.axis is not None and math.hypot(*self.axis) < 1e-9:
            raise Misplaced(("axis",), "is zero; give a direction, such as [0, 0, 1]")
        if self.type == "fixed":
            for key, field in type(self).model_fields.items():
                if key not in ("name", "type") and getattr(self, key) != field.default:
                    raise Misplaced(
                        (key,),
                        "is given, but the joint is fixed and holds the link rigidly; leave it out,"
                        " or give type: revolute or prismatic",
                    )
        if self.effort_limit is not None and not self.actuated:
            raise Misplaced(
                ("effort_limit",),
                f"is {self.effort_limit:g}, but the joint is passive (actuated: false) and has no motor to"
                " limit; leave it out",
            )
        if self.gear_ratio != 1.0 and self.rotor_inertia == 0.0:
            raise Misplaced(
                ("gear_ratio",),
                f"is {self.gear_ratio:g} without a rotor_inertia, the only thing that it changes (by its"
                " square); give the rotor_inertia on the motor's side too, or leave it out",
            )
        if self.coulomb_speed > 0.0 and self.coulomb_friction == 0.0:
            raise Misplaced(
                ("coulomb_speed",),
                f"is {self.coulomb_speed:g} without a coulomb_friction to smooth; give that too, or leave it"
                " out",
            )
        return self

    @model_validator(mode="after")
    def _elastic(self) -> Joint:
        if self.stiffness is None and self.damping > 0.0:
            raise Misplaced(
                ("damping",),
                f"is {self.damping:g} without a stiffness; give the spring between motor and link too,"
                " or viscous_friction for the motor's losses",
            )
        if self.stiffness is not None and not self.actuated:
            raise Misplaced(
                ("stiffness",),
                f"is {self.stiffness:g}, but the joint is passive (actuated: false): the spring would stand"
                " between motor and link; leave it out",
            )
        if self.stiffness is not None and self.rotor_inertia == 0.0:
            raise Misplaced(
                ("stiffness",),
                f"is {self.stiffness:g}, but behind a spring the motor moves on its own; give its"
                " rotor_inertia",
            )
        return self


class Beam(Part):
    """A prismatic beam: a rectangle, width (beam y) by depth (beam z), or its section's constants."""

    width: Side | None = None
    depth: Side | None = None
    area: Positive | None = None
    iy: Positive | None = None
    iz: Positive | None = None
    j: Positive | None = None
    shear_area_y: Positive | None = None
    shear_area_z: Positive | None = None
    density: Density
    youngs_modulus: Modulus
    poissons_ratio: Annotated[Number, between(-0.99, 0.5, "")] = 0.3
    elements: Annotated[int, Field(ge=1, le=1000, strict=True)] = 2

    @model_validator(mode="after")
    def _section(self) -> Beam:
        rectangle = [self.width, self.depth]
        constants = [self.area, self.iy, self.iz, self.j]
        if any(v is not None for v in rectangle) and any(v is not None for v in constants):
            raise ValueError("has both width/depth and area/iy/iz/j; give one of the two")
        if all(v is None for v in rectangle + constants):
            raise ValueError("has no section; give width and depth, or area, iy, iz and j")
        for names, values in (
            (("width", "depth"), rectangle),
            (("area", "iy", "iz", "j"), constants),
        ):
            if any(v is not None for v in values) and any(v is None for v in values):
                missing = [n for n, v in zip(names, values, strict=True) if v is None]
                raise ValueError(f"lacks {', '.join(missing)}; give {', '.join(names)}")
        return self


class Payload(Part):
    """A rigid body on the link's end; inertia about its centre of mass, in the link's frame."""

    mass: NotNegative = 0.0
    center_of_mass: Vector = (0.0, 0.0, 0.0)
    inertia: tuple[Vector, Vector, Vector] | None = None

    @model_validator(mode="after")
    def _physical(self) -> Payload:
        if self.mass == 0.0 and (self.inertia is not None or any(self.center_of_mass)):
            key = "inertia" if self.inertia is not None else "center_of_mass"
            raise Misplaced((key,), "is given, but the body has no mass; give its mass, or leave it out")
        if self.inertia is None:
            return self
        m = self.inertia
        scale = max(abs(x) for row in m for x in row) or 1.0
        if any(abs(m[i][k] - m[k][i]) > 1e-9 * scale for i in range(3) for k in range(3)):
            raise ValueError("has an inertia that is not symmetric; give a symmetric 3 x 3 matrix")
        moments = np.linalg.eigvalsh(np.array(m))
        if moments[0] < -1e-9 * scale or moments[2] > moments[0] + moments[1] + 1e-9 * scale:
            raise ValueError(
                "has an inertia that no body can have; its principal moments must not be negative"
                " and none may exceed the sum of the other two"
            )
        return self


class Reduction(Part):
    """Craig-Bampton: a link's ends and the lowest modes of the link with its ends held."""

    modes: Annotated[int, Field(ge=0, strict=True)]


class Link(Part):
    """One link with the joint at its start; it hangs on the end of `parent`, by default the link before.

    Its place is given by `dh`, whose frame sits at the link's far end, or by `frame`, at its joint.  A link
    of `frame` has an `end` (m, in its frame; by default where the first link hangs on it) and `points`, each
    a rigid massless link of its own once the scene is read.  Its rigid body counts from the frame's origin;
    payloads and closing joints count from the end.  `attach` names the parent's point where `frame` begins.
    """

    name: Name
    parent: str = ""
    attach: str = ""
    dh: DenavitHartenberg = DenavitHartenberg()
    frame: Frame | None = None
    end: Place | None = None
    points: dict[Name, Place] = Field(default_factory=dict)
    visuals: tuple[Mesh, ...] = ()
    joint: Joint = Joint()
    beam: Beam | None = None
    flexible: bool = True
    reduction: Reduction | Literal[False] | None = None
    rigid: Payload | None = None
    payload: Payload = Payload()

    @model_serializer(mode="wrap")
    def _dumped(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return without_defaults(self, ("attach", "frame", "end", "points", "visuals"), handler(self))

    @property
    def length(self) -> float:
        """Distance from the link's start to its end, O_{l-1} to O_l at q = 0, m."""
        return math.hypot(self.dh.a, self.dh.d) if self.frame is None else math.hypot(*(self.end or (0.0,)))

    @property
    def bodies(self) -> tuple[tuple[Payload, np.ndarray], ...]:
        """Rigid bodies with a mass, and their centres of mass (3,) from the link's end, in its frame, m."""
        root = np.array(self.end or (0.0, 0.0, 0.0)) if self.frame is not None else np.zeros(3)
        both = ((self.rigid, root), (self.payload, np.zeros(3)))
        return tuple((b, np.array(b.center_of_mass) - at) for b, at in both if b is not None and b.mass > 0.0)

    def _check_place(self) -> None:
        if self.frame is not None and self.dh != DenavitHartenberg():
            raise Misplaced(("frame",), "is given beside dh; give one of the two")
        if self.frame is None:
            for key in ("end", "points"):
                if getattr(self, key):
                    raise Misplaced((key,), "goes with frame; a link of dh ends where a and d lead")
            if self.joint.axis is not None:
                raise Misplaced(("joint", "axis"), "goes with frame; a joint of dh has its z axis")
        for name in self.points:
            if name in ("start", "end") or "/" in name:
                raise Misplaced(("points", name), "can't be so called; give another name, without /")

    @model_validator(mode="after")
    def _consistent(self) -> Link:
        self._check_place()
        if self.beam is not None and self.length < 1e-9:
            missing = "dh a or d" if self.frame is None else "end: [x, y, z]"
            raise ValueError(f"has a beam but no length; give {missing}, or replace beam by rigid")
        if self.reduction and self.beam is None:
            raise Misplaced(
                ("reduction",),
                "is given, but the link has no beam to reduce; leave it out, or give the link a beam",
            )
        if self.beam is not None and self.rigid is not None:
            raise ValueError("has both beam and rigid; give one of the two (payload adds a body)")
        if self.beam is not None and self.flexible:
            b = self.beam
            shortest = self.length / b.elements
            if b.width is not None and b.depth is not None and shortest < 1e-6:
                raise ValueError("has elements shorter than 1e-6 m; give fewer elements")
        return self
