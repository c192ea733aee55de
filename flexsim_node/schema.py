"""What a robot scene may hold: every key with its type, its range and its default."""

from __future__ import annotations

import difflib
import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator


class Misplaced(ValueError):
    """A complaint about a key below the part that is being checked."""

    def __init__(self, path: tuple[str | int, ...], message: str) -> None:
        super().__init__(message)
        self.path = path


def _number(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        hint = " (without its unit; SI units are understood)" if isinstance(value, str) else ""
        raise ValueError(f"is {value!r}; give a number{hint}")
    if not math.isfinite(value):
        raise ValueError(f"is {value!r}; give a finite number")
    return float(value)


def _between(low: float, high: float, unit: str, advice: str = "", open_low: bool = False) -> Any:
    def check(value: float) -> float:
        if value > high or value < low or (open_low and value <= low):
            bracket = "more than" if open_low else "at least"
            most = f" and at most {high:g}" if math.isfinite(high) else ""
            raise ValueError(
                f"is {value:g}; give {bracket} {low:g}{most} {unit}".rstrip()
                + (f" ({advice})" if advice else "")
            )
        return value

    return AfterValidator(check)


Number = Annotated[float, BeforeValidator(_number)]
Length = Annotated[Number, _between(-1e2, 1e2, "m", "metres, not millimetres")]
Angle = Annotated[Number, _between(-4 * math.pi, 4 * math.pi, "rad", "radians, not degrees")]
Side = Annotated[Number, _between(0.0, 10.0, "m", "metres, not millimetres", open_low=True)]
Density = Annotated[
    Number, _between(10.0, 1e5, "kg/m3", "steel has 7800 kg/m3, not 7.8 g/cm3", open_low=True)
]
Modulus = Annotated[Number, _between(1e4, 1e15, "Pa", "steel has 2e11 Pa, not 200 GPa", open_low=True)]
Positive = Annotated[Number, _between(0.0, math.inf, "", open_low=True)]
NotNegative = Annotated[Number, _between(0.0, math.inf, "")]
Vector = Annotated[tuple[Number, ...], Field(min_length=3, max_length=3)]
Name = Annotated[str, Field(min_length=1)]

BASE = "base"  # the ground, as a link's parent

HELD_BY_FRAMES = ("centrifugal", "coriolis")  # effects that co-moving frames hold by their geometry

Switch = bool | Literal["auto"]  # auto: decided by what leaving it out changes at the tip (effects.py)


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=False)


class DenavitHartenberg(_Part):
    """Standard parameters, A = Rz(theta) Tz(d) Tx(a) Rx(alpha)."""

    a: Length = 0.0
    alpha: Angle = 0.0
    d: Length = 0.0
    theta: Angle = 0.0


class Joint(_Part):
    """The joint at a link's start; q adds to theta or to d.

    stiffness (N m/rad or N/m) and damping stand between motor and link; rotor_inertia, friction and torque
    act on the motor.
    """

    name: str = ""
    type: Literal["fixed", "revolute", "prismatic"] = "revolute"
    actuated: bool = True
    effort_limit: Positive | None = None
    viscous_friction: NotNegative = 0.0
    coulomb_friction: NotNegative = 0.0
    coulomb_speed: Positive = 1e-2
    rotor_inertia: NotNegative = 0.0
    gear_ratio: Positive = 1.0
    stiffness: Positive | None = None
    damping: NotNegative = 0.0

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


class Beam(_Part):
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
    poissons_ratio: Annotated[Number, _between(-0.99, 0.5, "")] = 0.3
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


class Payload(_Part):
    """A rigid body on the link's end; inertia about its centre of mass, in the link's frame."""

    mass: NotNegative = 0.0
    center_of_mass: Vector = (0.0, 0.0, 0.0)
    inertia: tuple[Vector, Vector, Vector] | None = None

    @model_validator(mode="after")
    def _physical(self) -> Payload:
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


class Reduction(_Part):
    """Craig-Bampton: a link's ends and the lowest modes of the link with its ends held."""

    modes: Annotated[int, Field(ge=0, strict=True)]


class Link(_Part):
    """One link with the joint at its start; it hangs on the end of `parent`, by default the link before."""

    name: Name
    parent: str = ""
    dh: DenavitHartenberg = DenavitHartenberg()
    joint: Joint = Joint()
    beam: Beam | None = None
    flexible: bool = True
    reduction: Reduction | Literal[False] | None = None
    rigid: Payload | None = None
    payload: Payload = Payload()

    @property
    def length(self) -> float:
        """Distance from O_{l-1} to O_l at q = 0, m."""
        return math.hypot(self.dh.a, self.dh.d)

    @model_validator(mode="after")
    def _consistent(self) -> Link:
        if self.beam is not None and self.length < 1e-9:
            raise ValueError("has a beam but no length; give dh a or d, or replace beam by rigid")
        if self.beam is not None and self.rigid is not None:
            raise ValueError("has both beam and rigid; give one of the two (payload adds a body)")
        if self.beam is not None and self.flexible:
            b = self.beam
            shortest = self.length / b.elements
            if b.width is not None and b.depth is not None and shortest < 1e-6:
                raise ValueError("has elements shorter than 1e-6 m; give fewer elements")
        return self


class ClosingJoint(_Part):
    """A joint that closes a loop: where the ends of two links meet, or a link's end and the base.

    `at` are points, in the frames of the links' ends or in the base frame, where they are not these frames'
    origins; `axis` directions there: of a revolute joint (z where not given), of a universal joint's two
    pins, or along which the first link's point slides in a slot of the second.
    """

    name: str = ""
    links: Annotated[tuple[Name, ...], Field(min_length=2, max_length=2)]
    joint: Literal["revolute", "universal", "spherical", "fixed", "slot"] = "revolute"
    at: dict[Name, Vector] = {}
    axis: dict[Name, Vector] = {}

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


class ZeroedDof(_Part):
    """A nodal dof of the elastic displacement that is zero, so that the ERLS is defined.

    `node` counts from 0 at the link's start.  The axes are those of the link's joint: z along the
    joint's axis, x along x_l; where dh alpha is zero these are the axes of the link's frame.
    """

    link: str
    node: Annotated[int, Field(ge=0, strict=True)]
    dof: Literal["x", "y", "z", "rx", "ry", "rz"]


class Erls(_Part):
    """Which elastic dofs are zeroed.

    `root`: the rotation about the joint at each link's start, so that q is the motors' angles; `chord`: the
    deflection of each link's end in the plane that the joint turns it in; `auto`: chord where the joint is
    free, root where its motion is prescribed.  The motion is the same to the order of the squared elastic
    rotation; with `chord` the rigid links stay nearest the flexible ones, which is easiest to integrate.
    """

    zeroed: Literal["root", "chord", "auto"] | tuple[ZeroedDof, ...] = "auto"


class Damping(_Part):
    """Rayleigh's coefficients."""

    alpha: NotNegative = 0.0
    beta: NotNegative = 0.0


class Initial(_Part):
    """Joints in order (all, or the actuated ones), or by name; what is not given is zero.

    Of robots with loops the passive joints' values are guesses.
    """

    position: tuple[Number, ...] | dict[Name, Number] | None = None
    velocity: tuple[Number, ...] | dict[Name, Number] | None = None
    shape: Literal["undeformed", "static"] = "undeformed"


class Sensor(_Part):
    """A virtual instrument on a link; `at` (m) or `fraction` of its length, from its start, or its end."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]*$")]
    type: Literal["strain_gauge", "imu", "pose", "section_force"]
    link: str | None = None
    at: Annotated[Number, _between(0.0, 1e2, "m", "metres from the link's start")] | None = None
    fraction: Annotated[Number, _between(0.0, 1.0, "")] | None = None
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


class Effects(_Part):
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


class Limits(_Part):
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


class Validity(_Part):
    """How far a motion may go from what its equations hold for.

    elastic_rotation (rad) from the rigid links; correction (m or rad) that a step's last iteration made;
    erls_condition and mass_condition.  spin_ratio (spin over the first bending frequency of a link with what
    it carries) stops a run where `centrifugal` is off; axial_load (over the buckling load) warns, and stops
    where `centrifugal` is off.
    """

    elastic_rotation: Annotated[Limits, _filled(0.1, 0.5)] = Limits(warn=0.1, stop=0.5)
    spin_ratio: Annotated[Limits, _filled(0.3, 1.0)] = Limits(warn=0.3, stop=1.0)
    axial_load: Annotated[Limits, _filled(0.5, 1.0)] = Limits(warn=0.5, stop=1.0)
    correction: Annotated[Limits, _filled(None, None)] = Limits(warn=None, stop=None)
    erls_condition: Annotated[Limits, _filled(1e3, 1e8)] = Limits(warn=1e3, stop=1e8)
    mass_condition: Annotated[Limits, _filled(1e8, 1e14)] = Limits(warn=1e8, stop=1e14)


class Torque(_Part):
    """What a motor gives over time, between `start` and `end`; entries of one joint add up.

    constant: amplitude; sine: offset + amplitude sin(2 pi frequency (t - start) + phase); table: linear
    between its rows, held before the first and after the last.
    """

    joint: str
    type: Literal["constant", "sine", "table"]
    amplitude: Number = 0.0
    frequency: Annotated[Number, _between(0.0, 1e5, "Hz")] = 0.0
    phase: Annotated[Number, _between(-1e3, 1e3, "rad")] = 0.0
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
        if self.end is not None and self.end <= self.start:
            raise ValueError(f"ends at {self.end:g} s, not after its start; give a later end")
        return self


class Solver(_Part):
    method: Literal["rosenbrock_w", "generalized_alpha", "runge_kutta_4", "radau", "dop853"] = "rosenbrock_w"
    step: Annotated[Number, _between(1e-7, 1.0, "s", "seconds", open_low=True)] = 1e-3
    spectral_radius: Annotated[Number, _between(0.0, 1.0, "")] = 0.8
    relative_tolerance: Positive = 1e-8
    absolute_tolerance: Positive = 1e-10


Signal = Literal["position", "velocity", "effort"]
Duration = Annotated[Number, _between(0.0, 10.0, "s", "seconds")]
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


class Fault(_Part):
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
    probability: Annotated[Number, _between(0.0, 1.0, "")] | None = None
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


class Scene(_Part):
    """A robot scene, as design.md's section on scene files lays it down."""

    model: Literal["robot"]
    name: Name
    source: str = ""
    gravity: Vector = (0.0, 0.0, -9.81)
    damping: Damping = Damping()
    links: Annotated[tuple[Link, ...], Field(min_length=1)]
    loops: tuple[ClosingJoint, ...] = ()
    formulation: Literal["erls", "co_moving"] = "erls"
    reduction: Reduction | None = None
    erls: Erls = Erls()
    initial: Initial = Initial()
    effects: Effects = Effects()
    validity: Validity = Validity()
    solver: Solver = Solver()
    sensors: tuple[Sensor, ...] = ()
    torque: tuple[Torque, ...] = ()
    duration: Annotated[Number, _between(0.0, 1e6, "s", open_low=True)] = 1.0
    tolerance: Positive | None = None
    faults: tuple[Fault, ...] = ()
    seed: Annotated[int, Field(ge=0, le=2**63 - 1, strict=True)] = 0  # of what is random in the faults

    @property
    def joints(self) -> tuple[Joint, ...]:
        """The joints that move, in the order of q."""
        return tuple(link.joint for link in self.links if link.joint.type != "fixed")

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Their names; a joint without one is called after its link."""
        return tuple(
            link.joint.name or f"{link.name}_joint" for link in self.links if link.joint.type != "fixed"
        )

    @property
    def passive_joints(self) -> tuple[str, ...]:
        """Names of the joints without a motor."""
        return tuple(n for n, j in zip(self.joint_names, self.joints, strict=True) if not j.actuated)

    def start(self, key: Literal["position", "velocity"]) -> np.ndarray:
        """(m,) initial position or velocity of the joints; of loops, as far as it is given."""
        given = getattr(self.initial, key)
        values = np.zeros(len(self.joints))
        if isinstance(given, dict):
            for name, value in given.items():
                values[self.joint_names.index(name)] = value
        elif given is not None:
            actuated = [k for k, joint in enumerate(self.joints) if joint.actuated]
            values[actuated if len(given) < len(values) else slice(None)] = given
        return values

    @property
    def parents(self) -> tuple[int, ...]:
        """(L,) the link on whose end each link hangs, -1 for the base."""
        names = [BASE, *(link.name for link in self.links)]
        return tuple(names.index(k.parent) - 1 if k.parent else n - 1 for n, k in enumerate(self.links))

    def modes_of(self, link: Link) -> int | None:
        """Number of modes to which a link is reduced, or None: a link without its own follows the scene."""
        own = self.reduction if link.reduction is None else link.reduction
        return own.modes if own and link.beam is not None and link.flexible else None

    @model_validator(mode="before")
    @classmethod
    def _all_that_can_be_open(cls, value: Any) -> Any:
        if (
            isinstance(value, dict)
            and value.get("effects") == "auto"
            and value.get("formulation") == "co_moving"
        ):
            return {**value, "effects": {n: n in HELD_BY_FRAMES or "auto" for n in Effects.model_fields}}
        return value

    @model_validator(mode="after")
    def _consistent(self) -> Scene:
        names = [link.name for link in self.links]
        if BASE in names and (self.loops or any(link.parent for link in self.links)):
            raise Misplaced(
                ("links", names.index(BASE), "name"), f"is {BASE!r}, which is the ground; give another"
            )
        joints = [
            link.joint.name or f"{link.name}_joint" if link.joint.type != "fixed" else None
            for link in self.links
        ]
        for kind, several in (("link", names), ("joint", joints)):
            for n, name in enumerate(several):
                if name is not None and name in several[:n]:
                    below = ("joint", "name") if kind == "joint" else ("name",)
                    raise Misplaced(
                        ("links", n, *below),
                        f"is {name!r} like links.{several.index(name)}; give each {kind} its own name",
                    )
        for n, link in enumerate(self.links):
            if link.parent and link.parent not in (BASE, *names[:n]):
                earlier = ", ".join((BASE, *names[:n]))
                raise Misplaced(
                    ("links", n, "parent"), f"is {link.parent!r}; give {BASE} or an earlier link: {earlier}"
                )
        m, motors = len(self.joints), sum(joint.actuated for joint in self.joints)
        if m == 0:
            raise Misplaced(("links",), "have no joint that moves; make one revolute or prismatic")
        for key in ("position", "velocity"):
            given = getattr(self.initial, key)
            for name in given if isinstance(given, dict) else ():
                if name not in self.joint_names:
                    raise Misplaced(
                        ("initial", key, name), f"is no joint; give one of {', '.join(self.joint_names)}"
                    )
            if isinstance(given, tuple) and len(given) not in (m, motors):
                those = f" ({motors} actuated)" if motors < m else ""
                some = f"{m}, or {motors}" if motors < m else str(m)
                raise Misplaced(
                    ("initial", key), f"has {len(given)} values for {m} moving joints{those}; give {some}"
                )
        for n, loop in enumerate(self.loops):
            for i, name in enumerate(loop.links):
                if name not in (BASE, *names):
                    near = difflib.get_close_matches(name, names, 1)
                    raise Misplaced(
                        ("loops", n, "links", i),
                        f"is {name!r}, which does not exist; "
                        f"give {near[0] if near else 'one of ' + ', '.join((BASE, *names))}",
                    )
        if self.formulation == "co_moving":
            if self.erls.zeroed not in ("root", "auto"):
                given = self.erls.zeroed if isinstance(self.erls.zeroed, str) else "a list"
                raise Misplaced(
                    ("erls", "zeroed"),
                    f"is {given}, but co-moving frames start at their links' roots;"
                    " give root or leave it out",
                )
            for name in HELD_BY_FRAMES:
                switch = getattr(self.effects, name)
                if switch is not True:
                    raise Misplaced(
                        ("effects", name),
                        f"is {str(switch).lower()}, but co-moving frames hold it by their geometry;"
                        " leave it on, or give formulation: erls",
                    )
            given = [("links", n, "reduction") for n, link in enumerate(self.links) if link.reduction]
            given = [("reduction",)] if self.reduction else given
            if given:
                raise Misplaced(given[0], "takes formulation: erls; give that one, or leave it out")
        for n, zeroed in enumerate(self.erls.zeroed if isinstance(self.erls.zeroed, tuple) else ()):
            if zeroed.link not in names:
                near = difflib.get_close_matches(zeroed.link, names, 1)
                raise Misplaced(
                    ("erls", "zeroed", n, "link"),
                    f"is {zeroed.link!r}, which does not exist; "
                    f"give {near[0] if near else 'one of ' + ', '.join(names)}",
                )
            beam = self.links[names.index(zeroed.link)].beam
            if beam is not None and zeroed.node > beam.elements:
                raise Misplaced(
                    ("erls", "zeroed", n, "node"),
                    f"is {zeroed.node}; the end of {zeroed.link} is node {beam.elements}",
                )
            reduced = self.modes_of(self.links[names.index(zeroed.link)]) is not None
            if beam is not None and reduced and 0 < zeroed.node < beam.elements:
                raise Misplaced(
                    ("erls", "zeroed", n, "node"),
                    f"is {zeroed.node}, inside {zeroed.link}, which is reduced to its ends and modes;"
                    f" give 0 or {beam.elements}, or links.{names.index(zeroed.link)}.reduction: false",
                )
        self._check_sensors(names)
        self._check_torque()
        if self.effects.undecided and self.tolerance is None:
            raise Misplaced(
                ("effects",),
                f"leave {self.effects.undecided[0]} to auto, but the scene has no tolerance to decide by;"
                " give tolerance: metres at the tip, such as 1.0e-4",
            )
        for n, fault in enumerate(self.faults):
            for kind, given, known in (
                ("joints", fault.joints or (), self.joint_names),
                ("link", (fault.link,) if fault.link else (), tuple(names)),
            ):
                wrong = [name for name in given if name not in known]
                if wrong:
                    raise Misplaced(
                        ("faults", n, kind),
                        f"has {wrong[0]!r}, which does not exist; give {', '.join(known)}",
                    )
        return self

    def _check_torque(self) -> None:
        known = self.joint_names
        for n, entry in enumerate(self.torque):
            if entry.joint not in known:
                near = difflib.get_close_matches(entry.joint, known, 1)
                raise Misplaced(
                    ("torque", n, "joint"),
                    f"is {entry.joint!r}, which does not exist; "
                    f"give {near[0] if near else 'one of ' + ', '.join(known)}",
                )

    def _check_sensors(self, links: list[str]) -> None:
        for n, sensor in enumerate(self.sensors):
            if sensor.link is not None and sensor.link not in links:
                near = difflib.get_close_matches(sensor.link, links, 1)
                raise Misplaced(
                    ("sensors", n, "link"),
                    f"is {sensor.link!r}, which does not exist; "
                    f"give {near[0] if near else 'one of ' + ', '.join(links)}",
                )
            before = [other.name for other in self.sensors[:n]]
            if sensor.name in before:
                raise Misplaced(
                    ("sensors", n, "name"),
                    f"is {sensor.name!r} like sensors.{before.index(sensor.name)}; give each its own name",
                )
            link = self.links[links.index(sensor.link) if sensor.link else -1]
            complaint = sensor.complaint(link)
            if complaint is not None:
                raise Misplaced(("sensors", n, complaint[0]), complaint[1])
