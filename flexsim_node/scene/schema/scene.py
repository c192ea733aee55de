"""What a robot scene may hold: every key with its type, its range and its default."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationError, model_validator

from .auto import Auto
from .effects import HELD_BY_FRAMES, Effects
from .fault import Fault
from .frames import at_ends, placed, start_of
from .link import Joint, Link, Reduction
from .loop import BASE, ClosingJoint
from .part import Misplaced, Name, NotNegative, Number, Part, Positive, Vector, between, each_once, unknown
from .sensor import Sensor
from .torque import Torque
from .validity import Validity


class Undecided(RuntimeError):
    """Something left to `auto` has reached what needs it decided: a mistake of the program."""


class ZeroedDof(Part):
    """A nodal dof of the elastic displacement that is zero, so that the ERLS is defined.

    `node` counts from 0 at the link's start.  The axes are those of the link's joint: z along the
    joint's axis, x along x_l; where dh alpha is zero these are the axes of the link's frame.
    """

    link: str
    node: Annotated[int, Field(ge=0, strict=True)]
    dof: Literal["x", "y", "z", "rx", "ry", "rz"]


class Erls(Part):
    """Which elastic dofs are zeroed.

    `root`: the rotation about the joint at each link's start, so that q is the motors' angles; `chord`: the
    deflection of each link's end in the plane that the joint turns it in; `auto`: chord where the joint is
    free, root where its motion is prescribed.  The motion is the same to the order of the squared elastic
    rotation; with `chord` the rigid links stay nearest the flexible ones, which is easiest to integrate.
    """

    zeroed: Literal["root", "chord", "auto"] | tuple[ZeroedDof, ...] = "auto"


class Damping(Part):
    """Rayleigh's coefficients: alpha (1/s) of the mass, beta (s) of the stiffness.

    alpha damps the elastic velocity, that of the links less that of the robot moved rigidly by its joints,
    and only takes energy. `alpha_form: thesis` is the thesis' (2.56), in which that force does work in
    rigid motion too: it may add energy, and the motion depends on which dofs are zeroed.
    """

    alpha: NotNegative = 0.0
    beta: NotNegative = 0.0
    alpha_form: Literal["elastic", "thesis"] = "elastic"

    @model_validator(mode="after")
    def _with_alpha(self) -> Damping:
        if self.alpha_form == "thesis" and self.alpha == 0.0:
            raise Misplaced(("alpha_form",), "is given without an alpha; give that too, or leave it out")
        return self


class Initial(Part):
    """Joints in order (all, or the actuated ones), or by name; what is not given is zero.

    Of robots with loops the passive joints' values are guesses.
    """

    position: tuple[Number, ...] | dict[Name, Number] | None = None
    velocity: tuple[Number, ...] | dict[Name, Number] | None = None
    shape: Literal["undeformed", "static"] = "undeformed"


class Solver(Part):
    method: Literal["rosenbrock_w", "generalized_alpha", "runge_kutta_4", "radau", "dop853"] = "rosenbrock_w"
    step: Annotated[Number, between(1e-7, 1.0, "s", "seconds", open_low=True)] = 1e-3
    spectral_radius: Annotated[Number, between(0.0, 1.0, "")] = 0.8
    relative_tolerance: Positive = 1e-8
    absolute_tolerance: Positive = 1e-10


class Scene(Part):
    """A robot scene, as design.md's section on scene files lays it down."""

    model: Literal["robot"]
    name: Name
    source: str = ""
    gravity: Vector = (0.0, 0.0, -9.81)
    damping: Damping = Damping()
    links: Annotated[tuple[Link, ...], Field(min_length=1)]
    loops: tuple[ClosingJoint, ...] = ()
    formulation: Literal["erls", "co_moving", "auto"] = "erls"  # auto: analysis/formulations.py
    reduction: Reduction | None = None
    erls: Erls = Erls()
    initial: Initial = Initial()
    effects: Effects = Effects()
    auto: Auto = Auto()
    validity: Validity = Validity()
    solver: Solver = Solver()
    sensors: tuple[Sensor, ...] = ()
    torque: tuple[Torque, ...] = ()
    duration: Annotated[Number, between(0.0, 1e6, "s", open_low=True)] = 1.0
    tolerance: Positive | None = None  # m, at the tips
    tip: Name | Annotated[tuple[Name, ...], Field(min_length=1)] | None = None
    faults: tuple[Fault, ...] = ()
    seed: Annotated[int, Field(ge=0, le=2**63 - 1, strict=True)] = 0  # of what is random in the faults

    @property
    def link_names(self) -> list[str]:
        """Their names, in the scene's order."""
        return [link.name for link in self.links]

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

    @property
    def tips(self) -> tuple[int, ...]:
        """The links whose ends are the robot's tips: those that `tip` names, else the free ends that move.

        A free end is that of a link on which nothing hangs and that no loop closes, of a link that joints or
        its own bending move; where loops close them all, the ends of all links that carry none.
        """
        if self.tip is not None:
            named = (self.tip,) if isinstance(self.tip, str) else self.tip
            return tuple(self.link_names.index(name) for name in named)
        parents = self.parents
        moves: list[bool] = []
        for n, link in enumerate(self.links):
            own = link.joint.type != "fixed" or (link.beam is not None and link.flexible)
            moves.append(own or (parents[n] >= 0 and moves[parents[n]]))
        ends = [n for n in range(len(self.links)) if moves[n] and n not in parents]
        closed = {name for loop in self.loops for name in loop.links}
        free = [n for n in ends if self.link_names[n] not in closed]
        return tuple(free or ends)

    @property
    def undecided(self) -> tuple[str, ...]:
        """What is left to `auto` and must be decided before anything is computed: formulation, effects."""
        return ("formulation",) * (self.formulation == "auto") + self.effects.undecided

    @property
    def co_moving(self) -> bool:
        """Whether frames follow the elastic links; the formulation must be decided."""
        if self.formulation == "auto":
            raise Undecided(f"{self.name}: the formulation is auto, and nothing has decided it")
        return self.formulation == "co_moving"

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
        self._check_names()
        if not placed(self.links):
            self._check_attached()
            return self._placed()
        self._check_initial()
        for n, loop in enumerate(self.loops):
            for i, name in enumerate(loop.links):
                self._check_link(("loops", n, "links", i), name, base=True)
        if self.formulation == "co_moving":
            self._check_co_moving()
        self._check_zeroed()
        self._check_sensors()
        for n, torque in enumerate(self.torque):
            if torque.joint not in self.joint_names:
                raise unknown(("torque", n, "joint"), torque.joint, self.joint_names)
        if self.formulation == "auto" and self.tolerance is None:
            raise Misplaced(
                ("formulation",),
                "is auto, but the scene has no tolerance to decide by; give tolerance: metres at the tip,"
                " such as 1.0e-4",
            )
        if self.effects.undecided and self.tolerance is None:
            raise Misplaced(
                ("effects",),
                f"leave {self.effects.undecided[0]} to auto, but the scene has no tolerance to decide by;"
                " give tolerance: metres at the tip, such as 1.0e-4",
            )
        self._check_tips()
        for n, fault in enumerate(self.faults):
            for i, joint in enumerate(fault.joints or ()):
                if joint not in self.joint_names:
                    raise unknown(("faults", n, "joints", i), joint, self.joint_names)
            if fault.link is not None:
                self._check_link(("faults", n, "link"), fault.link)
        return self

    def _check_attached(self) -> None:
        """Refuse points that the parent lacks, and what would hang on a beam but at its end."""
        points = {f"{link.name}/{point}": link.name for link in self.links for point in link.points}
        for n, (link, parent) in enumerate(zip(self.links, self.parents, strict=True)):
            if link.name in points:
                what = f"is {link.name!r}, as a point of {points[link.name]} is called; give another"
                raise Misplaced(("links", n, "name"), what)
            for point, place in link.points.items():
                self._check_arm(("links", n, "points", point), place, link)
            if not link.attach and link.frame is None:
                continue
            above = self.links[parent] if parent >= 0 else None
            known = ["end", *above.points] if above is not None and above.frame is not None else []
            if link.attach and link.attach not in known:
                right = f"give {' or '.join(known)}" if known else "leave it out"
                raise Misplaced(
                    ("links", n, "attach"), f"is {link.attach!r}, no point of the parent; {right}"
                )
            if above is not None and above.frame is not None and link.frame is not None:
                path = ("links", n, "attach" if link.attach else "frame")
                self._check_arm(path, start_of(link, above), above)

    def _check_arm(self, path: tuple[str | int, ...], place: tuple[float, ...], link: Link) -> None:
        """Refuse what would ride on a beam's end far from there; place (3,) in the link's frame, m."""
        if link.beam is not None and math.dist(place, link.end or (0.0, 0.0, 0.0)) > math.hypot(*place):
            raise Misplaced(
                path,
                f"is nearer to the start than to the end of the beam of {link.name}, and what hangs on a beam"
                " rides on its end; cut the beam in two there",
            )

    def _placed(self) -> Scene:
        """The scene with each link at the end of its parent (frames.py)."""
        several = at_ends(self.links, self.parents)
        last = self.links[-1].name  # a point that follows it is no link that anybody wrote
        update = {
            "links": tuple(link for _, link in several),
            "sensors": tuple(s if s.link else s.model_copy(update={"link": last}) for s in self.sensors),
        }
        try:
            return Scene.model_validate(self.__dict__ | update)
        except ValidationError as problem:
            error = problem.errors()[0]
            cause = error.get("ctx", {}).get("error")
            path = (*error["loc"], *(cause.path if isinstance(cause, Misplaced) else ()))
            if path[:1] == ("links",) and len(path) > 1:  # as the links are counted in the file
                path = ("links", several[int(path[1])][0], *path[2:])
            raise Misplaced(path, error["msg"].removeprefix("Value error, ")) from None

    def _check_link(self, path: tuple[str | int, ...], name: str, *, base: bool = False) -> None:
        known = [BASE, *self.link_names] if base else self.link_names
        if name not in known:
            raise unknown(path, name, known)

    def _check_tips(self) -> None:
        several = isinstance(self.tip, tuple)
        names = self.tip if isinstance(self.tip, tuple) else () if self.tip is None else (self.tip,)
        each_once(("tip",), names, "give each tip once")
        for n, name in enumerate(names):
            path = ("tip", n) if several else ("tip",)
            link, slash, point = name.partition("/")
            if slash and name not in self.link_names and link in self.link_names:
                points = [k for k in self.link_names if k.startswith(f"{link}/") and k != f"{link}/start"]
                lacks = "has it not" if points else "has no points"
                right = " or ".join([*points, f"{link}, whose end is meant"])
                raise Misplaced(path, f"names a point {point!r}, but {link} {lacks}: give {right}")
            self._check_link(path, name)

    def _check_names(self) -> None:
        names = self.link_names
        if BASE in names and (self.loops or any(link.parent for link in self.links)):
            raise Misplaced(
                ("links", names.index(BASE), "name"), f"is {BASE!r}, which is the ground; give another"
            )
        joints = [
            link.joint.name or f"{link.name}_joint" if link.joint.type != "fixed" else None
            for link in self.links
        ]
        each_once(("links",), names, "give each link its own name", ("name",))
        each_once(("links",), joints, "give each joint its own name", ("joint", "name"))
        for n, link in enumerate(self.links):
            if link.parent and link.parent not in (BASE, *names[:n]):
                earlier = ", ".join((BASE, *names[:n]))
                raise Misplaced(
                    ("links", n, "parent"), f"is {link.parent!r}; give {BASE} or an earlier link: {earlier}"
                )

    def _check_initial(self) -> None:
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

    def _check_co_moving(self) -> None:
        if self.erls.zeroed not in ("root", "auto"):
            given = self.erls.zeroed if isinstance(self.erls.zeroed, str) else "a list"
            raise Misplaced(
                ("erls", "zeroed"),
                f"is {given}, but co-moving frames start at their links' roots; give root or leave it out",
            )
        for name in HELD_BY_FRAMES:
            switch = getattr(self.effects, name)
            if switch is not True:
                raise Misplaced(
                    ("effects", name),
                    f"is {str(switch).lower()}, but co-moving frames hold it by their geometry;"
                    " leave it on, or give formulation: erls",
                )
        reduced = [("links", n, "reduction") for n, link in enumerate(self.links) if link.reduction]
        if self.reduction or reduced:
            path = ("reduction",) if self.reduction else reduced[0]
            raise Misplaced(path, "takes formulation: erls; give that one, or leave it out")

    def _check_zeroed(self) -> None:
        for n, zeroed in enumerate(self.erls.zeroed if isinstance(self.erls.zeroed, tuple) else ()):
            self._check_link(("erls", "zeroed", n, "link"), zeroed.link)
            k = self.link_names.index(zeroed.link)
            beam = self.links[k].beam
            if beam is not None and zeroed.node > beam.elements:
                raise Misplaced(
                    ("erls", "zeroed", n, "node"),
                    f"is {zeroed.node}; the end of {zeroed.link} is node {beam.elements}",
                )
            reduced = self.modes_of(self.links[k]) is not None
            if beam is not None and reduced and 0 < zeroed.node < beam.elements:
                raise Misplaced(
                    ("erls", "zeroed", n, "node"),
                    f"is {zeroed.node}, inside {zeroed.link}, which is reduced to its ends and modes;"
                    f" give 0 or {beam.elements}, or that link reduction: false",
                )

    def _check_sensors(self) -> None:
        each_once(("sensors",), (s.name for s in self.sensors), "give each its own name", ("name",))
        for n, sensor in enumerate(self.sensors):
            if sensor.link is not None:
                self._check_link(("sensors", n, "link"), sensor.link)
            link = self.links[self.link_names.index(sensor.link) if sensor.link else -1]
            complaint = sensor.complaint(link)
            if complaint is not None:
                raise Misplaced(("sensors", n, complaint[0]), complaint[1])
