"""What a robot scene may hold: every key with its type, its range and its default."""

from __future__ import annotations

import difflib
import math
from typing import Annotated, Any, Literal

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

Switch = bool


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=False)


class DenavitHartenberg(_Part):
    """Standard parameters, A = Rz(theta) Tz(d) Tx(a) Rx(alpha)."""

    a: Length = 0.0
    alpha: Angle = 0.0
    d: Length = 0.0
    theta: Angle = 0.0


class Joint(_Part):
    """The joint at a link's start; q adds to theta or to d."""

    name: str = ""
    type: Literal["fixed", "revolute", "prismatic"] = "revolute"
    effort_limit: Positive | None = None
    viscous_friction: NotNegative = 0.0
    coulomb_friction: NotNegative = 0.0
    coulomb_speed: Positive = 1e-2
    rotor_inertia: NotNegative = 0.0
    gear_ratio: Positive = 1.0
    stiffness: Positive | None = None
    damping: NotNegative = 0.0

    @model_validator(mode="after")
    def _simulated(self) -> Joint:
        for key, value in (("stiffness", self.stiffness), ("damping", self.damping or None)):
            if value is not None:
                raise Misplaced(
                    (key,),
                    f"is {value:g}, but a joint's elasticity is not simulated yet; leave it out"
                    " (viscous_friction is simulated)",
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
        import numpy as np

        moments = np.linalg.eigvalsh(np.array(m))
        if moments[0] < -1e-9 * scale or moments[2] > moments[0] + moments[1] + 1e-9 * scale:
            raise ValueError(
                "has an inertia that no body can have; its principal moments must not be negative"
                " and none may exceed the sum of the other two"
            )
        return self


class Link(_Part):
    """One link of the chain with the joint at its start."""

    name: Name
    dh: DenavitHartenberg = DenavitHartenberg()
    joint: Joint = Joint()
    beam: Beam | None = None
    flexible: bool = True
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
    position: tuple[Number, ...] | None = None
    velocity: tuple[Number, ...] | None = None
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
    centrifugal: Switch = True
    damping: Switch = True
    joint_friction: Switch = True
    rotor_inertia: Switch = True


class Solver(_Part):
    method: Literal["rosenbrock_w", "generalized_alpha", "runge_kutta_4", "radau", "dop853"] = "rosenbrock_w"
    step: Annotated[Number, _between(1e-7, 1.0, "s", "seconds", open_low=True)] = 1e-3
    spectral_radius: Annotated[Number, _between(0.0, 1.0, "")] = 0.8
    relative_tolerance: Positive = 1e-8
    absolute_tolerance: Positive = 1e-10


class Scene(_Part):
    """A robot scene, as design.md's section on scene files lays it down."""

    model: Literal["robot"]
    name: Name
    source: str = ""
    gravity: Vector = (0.0, 0.0, -9.81)
    damping: Damping = Damping()
    links: Annotated[tuple[Link, ...], Field(min_length=1)]
    erls: Erls = Erls()
    initial: Initial = Initial()
    effects: Effects = Effects()
    solver: Solver = Solver()
    sensors: tuple[Sensor, ...] = ()

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

    @model_validator(mode="after")
    def _consistent(self) -> Scene:
        names = [link.name for link in self.links]
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
        m = len(self.joints)
        if m == 0:
            raise Misplaced(("links",), "have no joint that moves; make one revolute or prismatic")
        for key in ("position", "velocity"):
            given = getattr(self.initial, key)
            if given is not None and len(given) != m:
                raise Misplaced(("initial", key), f"has {len(given)} values for {m} moving joints; give {m}")
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
        self._check_sensors(names)
        return self

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
