"""A URDF's tree as the links of a scene: each moving link a link of `frame`, what is fixed to it lumped."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from flexsim_node.rotations.roll_pitch_yaw import roll_pitch_yaw

from .account import CHANGED, IN_DOUBT, NOT_TAKEN, TOOK, Account
from .bodies import ROUNDED, SLACK, doubts, excess, mended, moved, together
from .rest import outside, rest_of
from .urdf import Body, Origin, Picture, Urdf, UrdfJoint, UrdfLink, about_axis
from .xml_file import ImportRefused

BASE = "base"
FAR, FULL_TURN = 3.0, 6.3  # m between two joints, rad: beyond these a unit is in doubt


@dataclass
class Choices:
    """What the caller chose.

    keep_fixed : fixed links stay links of their own
    hold : joints that are held, and where, rad or m; hold_mimics : joints that follow others are held too
    mend : inertias that no body can have become the nearest that one can
    """

    keep_fixed: bool = False
    hold: Mapping[str, float] = field(default_factory=dict)
    hold_mimics: bool = False
    mend: bool = False


@dataclass
class Carrier:
    """A link of the scene, with all that rides on it; places in its frame."""

    name: str
    parent: str = BASE
    joint: UrdfJoint | None = None
    fixed: bool = False
    origin: Origin = field(default_factory=lambda: Origin(np.zeros(3), np.zeros(3)))
    bodies: list[Body] = field(default_factory=list)
    pictures: list[Picture] = field(default_factory=list)
    points: dict[str, np.ndarray] = field(default_factory=dict)
    lumped: list[str] = field(default_factory=list)
    impossible: list[UrdfLink] = field(default_factory=list)


class Tree:
    """The carriers of a robot, in an order in which parents come first."""

    def __init__(self, urdf: Urdf, choices: Choices, account: Account) -> None:
        self.urdf, self.choices, self.account = urdf, choices, account
        self.rest = rest_of(urdf, choices.hold, choices.hold_mimics)
        self.base = Carrier(BASE)
        self.carriers: dict[str, Carrier] = {}
        # of each URDF link: what carries it, its place and axes there
        self.riders: dict[str, tuple[Carrier, np.ndarray, np.ndarray]] = {
            urdf.root: (self.base, np.zeros(3), np.eye(3))
        }
        self.names: dict[str, str] = {}
        self._load(urdf.links[urdf.root])
        for joint in urdf.depth_first():
            self._add(joint)

    def _add(self, joint: UrdfJoint) -> None:
        carrier, place, turn = self.riders[joint.parent]
        own = joint.origin
        if joint.name in self.rest.held:
            own = self._hold(joint, self.rest.held[joint.name])
        at, axes = place + turn @ own.xyz, turn @ own.turn
        fixed = joint.kind == "fixed" or joint.name in self.rest.held
        if not fixed or self.choices.keep_fixed:
            name = self._name(joint.child)
            identity = not place.any() and np.array_equal(turn, np.eye(3))
            origin = own if identity else Origin(at, roll_pitch_yaw(axes))
            self.carriers[name] = Carrier(name, carrier.name, joint, fixed, origin)
            self.riders[joint.child] = self.carriers[name], np.zeros(3), np.eye(3)
        else:
            self.riders[joint.child] = carrier, at, axes
            carrier.lumped.append(joint.child)
            if not self.urdf.below(joint.child) and carrier is not self.base:
                carrier.points[self._name(joint.child)] = at
        self._load(self.urdf.links[joint.child])

    def _hold(self, joint: UrdfJoint, position: float) -> Origin:
        """The origin of a joint that stays where it is held; says so."""
        self.account.say(CHANGED, joint.name, f"held at {position:g}")
        if outside(joint, position):
            doubt = f"held at {position:g}, outside its limits; --hold {joint.name}=VALUE holds it elsewhere"
            self.account.say(IN_DOUBT, joint.name, doubt)
        if position == 0.0:
            return joint.origin
        axis, turn = joint.axis / np.linalg.norm(joint.axis), joint.origin.turn
        if joint.kind == "prismatic":
            return Origin(joint.origin.xyz + turn @ axis * position, joint.origin.rpy)
        return Origin(joint.origin.xyz, roll_pitch_yaw(turn @ about_axis(axis, position)))

    def _name(self, link: str) -> str:
        """The link's name in the scene."""
        name = link.replace("/", "_")
        name = f"{name}_link" if name in (BASE, "start", "end") else name
        while name in self.names.values():
            name += "_"
        if name != link:
            self.account.say(CHANGED, link, f"is called {name} in the scene")
        self.names[link] = name
        return name

    def _load(self, link: UrdfLink) -> None:
        """What a URDF link is made of, put on its carrier."""
        carrier, place, turn = self.riders[link.name]
        if link.body is not None:
            self._examine(link, link.body, carrier)
            carrier.bodies.append(moved(link.body, place, turn))
        for picture in link.pictures:
            origin = Origin(place + turn @ picture.origin.xyz, roll_pitch_yaw(turn @ picture.origin.turn))
            carrier.pictures.append(Picture(picture.mesh, origin, picture.scale, picture.missing))

    def _examine(self, link: UrdfLink, body: Body, carrier: Carrier) -> None:
        """Say what is seldom meant; remember what no body can be."""
        if carrier is self.base:
            return  # it never moves
        for doubt in doubts(body):
            self.account.say(IN_DOUBT, link.name, doubt)
        if excess(body.inertia) > SLACK:
            carrier.impossible.append(link)
            if carrier.name != self.names.get(link.name):
                self.account.say(IN_DOUBT, link.name, "has an inertia that no body can have")

    def put_together(self) -> None:
        """Make one body of each carrier's; refuses what no body can be, unless it is rounding or asked."""
        for carrier in self.carriers.values():
            body = together(carrier.bodies)
            if body is None and any(part.inertia.any() for part in carrier.bodies):
                assert carrier.joint is not None
                link = self.urdf.links[carrier.joint.child]
                raise ImportRefused(
                    f"{link.where}: link {link.name!r} has an inertia without a mass; give the mass"
                )
            if body is not None:
                body = self._possible(carrier, body)
            carrier.bodies = [] if body is None else [body]

    def _possible(self, carrier: Carrier, body: Body) -> Body:
        """The body, mended where its inertia is none and that is rounding or asked for."""
        share = excess(body.inertia)
        if share <= SLACK:
            return body
        moments = ", ".join(f"{x:.6g}" for x in np.linalg.eigvalsh(body.inertia))
        if share > ROUNDED and not self.choices.mend:
            assert carrier.joint is not None
            link = carrier.impossible[0] if carrier.impossible else self.urdf.links[carrier.joint.child]
            raise ImportRefused(
                f"{link.where}: link {link.name!r} has an inertia that no body can have (principal moments"
                f" {moments} kg m2; none may be negative or exceed the sum of the others); correct it, or let"
                " --mend-inertia take the nearest that can be"
            )
        found = mended(body.inertia)
        now = ", ".join(f"{x:.6g}" for x in np.linalg.eigvalsh(found))
        what = f"principal moments {moments} to {now} kg m2, as a body can have"
        self.account.say(CHANGED, carrier.name, what)
        return Body(body.mass, body.center, found)


def scene_of(urdf: Urdf, choices: Choices, account: Account, source: str) -> dict[str, Any]:
    """The scene of a robot, as a document; its account gets what was taken, changed, left.

    Raises
    ------
    ImportRefused
        where a link or a joint can't be in a scene
    """
    tree = Tree(urdf, choices, account)
    carriers = list(tree.carriers.values())
    moving = [c for c in carriers if not c.fixed]
    if not moving:
        raise ImportRefused(f"{source}: has no joint that moves; a scene needs one")
    tree.put_together()
    links = [link_of(carrier) for carrier in carriers]
    scene: dict[str, Any] = {"model": "robot", "name": urdf.name, "source": source, "links": links}
    starts = {name: place for name, place in tree.rest.starts.items() if place != 0.0}
    if starts:
        scene["initial"] = {"position": starts}
    tell(urdf, tree, account)
    return scene


def link_of(carrier: Carrier) -> dict[str, Any]:
    """A carrier as a link of a scene."""
    joint = carrier.joint
    assert joint is not None
    frame = {"xyz": row(carrier.origin.xyz), "rpy": row(carrier.origin.rpy)}
    link: dict[str, Any] = {"name": carrier.name, "parent": carrier.parent, "frame": frame}
    if carrier.fixed:
        link["joint"] = {"type": "fixed"}
    else:
        kind = "prismatic" if joint.kind == "prismatic" else "revolute"
        link["joint"] = {"name": joint.name, "type": kind, "axis": row(joint.axis)}
        if joint.effort:
            link["joint"]["effort_limit"] = joint.effort
        if joint.damping:
            link["joint"]["viscous_friction"] = joint.damping
        if joint.friction:
            link["joint"]["coulomb_friction"] = joint.friction
    if carrier.points:
        link["points"] = {name: row(place) for name, place in carrier.points.items()}
    if carrier.bodies:
        link["rigid"] = rigid(carrier.bodies[0])
    if carrier.pictures:
        link["visuals"] = [
            {
                "mesh": p.mesh,
                "frame": {"xyz": row(p.origin.xyz), "rpy": row(p.origin.rpy)},
                "scale": row(p.scale),
            }
            for p in carrier.pictures
        ]
    return link


def rigid(body: Body) -> dict[str, Any]:
    """A body as a scene writes it."""
    found: dict[str, Any] = {"mass": float(body.mass), "center_of_mass": row(body.center)}
    if body.inertia.any():
        found["inertia"] = [row(line) for line in 0.5 * (body.inertia + body.inertia.T)]
    return found


def row(values: np.ndarray) -> list[float]:
    """Numbers of Python's own, without -0."""
    return [float(x) + 0.0 for x in values]


def tell(urdf: Urdf, tree: Tree, account: Account) -> None:
    """The account of what was taken and what was not."""
    carriers = list(tree.carriers.values())
    lost = [p.mesh for c in carriers for p in c.pictures if p.missing]
    account.of_several(IN_DOUBT, lost, "no such file; the path is kept")
    moving = [c.joint for c in carriers if c.joint is not None and not c.fixed]
    mass = sum(body.mass for c in carriers for body in c.bodies)
    kinds = [f"{sum(j.kind == k for j in moving)} {k}" for k in ("revolute", "continuous", "prismatic")]
    account.say(TOOK, "links", f"{len(carriers)} of {len(urdf.links)}, {mass:.6g} kg that moves")
    account.say(TOOK, "joints", ", ".join(k for k in kinds if not k.startswith("0 ")))
    efforts = sum(bool(j.effort) for j in moving)
    losses = sum(bool(j.damping or j.friction) for j in moving)
    meshes = sum(len(c.pictures) for c in carriers)
    for count, what in (
        (efforts, "effort limits"), (losses, "joints' damping and friction"),
        (meshes, "meshes, by their paths; no file was opened"),
    ):  # fmt: skip
        if count:
            account.say(TOOK, what.partition(",")[0], f"{count}{what[len(what.partition(',')[0]) :]}")
    for carrier in carriers:
        weighty = [name for name in carrier.lumped if urdf.links[name].body is not None]
        account.of_several(CHANGED, weighty, f"fixed to {carrier.name}, whose body has theirs now")
        account.of_several(CHANGED, list(carrier.points),
                           f"points of {carrier.name}, and so tips unless `tip` names others; their rotation"
                           " is left out")  # fmt: skip
        between = [name for name in carrier.lumped if urdf.links[name].body is None and urdf.below(name)]
        account.of_several(NOT_TAKEN, between, "frames without mass between links: --keep-fixed keeps them")
    ground = sum(body.mass for body in tree.base.bodies)
    rests = [urdf.root, *tree.base.lumped]
    account.of_several(CHANGED, rests, f"stand on the ground ({ground:.6g} kg) and are the scene's base")
    account.of_several(NOT_TAKEN, [j.name for j in moving if (j.lower or j.upper) and j.kind != "continuous"],
                       "position limits: a scene has none, the joints turn on")  # fmt: skip
    account.of_several(
        NOT_TAKEN, [j.name for j in moving if j.velocity is not None], "velocity limits: a scene has none"
    )
    account.of_several(
        NOT_TAKEN, [j.name for j in moving if j.effort == 0.0], "effort limit 0, taken for none given"
    )
    starts = tree.rest.starts
    account.of_several(CHANGED, [j.name for j in moving if not j.mimic and starts[j.name] != 0.0],
                       "start in the middle of their limits, which leave out 0")  # fmt: skip
    for j in moving:
        if j.mimic:
            begins = f", from {starts[j.name]:g}" if starts[j.name] else ""
            account.say(NOT_TAKEN, j.name, f"follows {j.mimic} in the URDF; here it moves on its own{begins}:"
                                           " --hold-mimics holds it")  # fmt: skip
    account.of_several(IN_DOUBT, [j.name for j in moving if outside(j, starts[j.name])],
                       "start outside their limits, where they would follow")  # fmt: skip
    known = {joint.name for joint in urdf.joints}
    lost = [j.name for j in urdf.joints if j.mimic and j.mimic not in known]
    account.of_several(IN_DOUBT, lost, "follow a joint that is not in the file, taken to stay at 0")
    account.of_several(CHANGED, [j.name for j in moving if not j.axis_given],
                       "have no <axis>: it is 1 0 0, as URDF has it")  # fmt: skip
    skew = [j.name for j in moving if abs(np.linalg.norm(j.axis) - 1.0) > 1e-3]
    account.of_several(CHANGED, skew, "have an axis that is not of length 1: its direction counts")
    account.of_several(
        NOT_TAKEN, [j.name for j in urdf.joints if j.extras], "calibration or safety_controller"
    )
    shapes = sum(link.shapes for link in urdf.links.values())
    collisions = sum(link.collisions for link in urdf.links.values())
    for count, what in ((shapes, "visuals without a mesh"), (collisions, "collision shapes")):
        if count:
            account.say(NOT_TAKEN, what, f"{count}: not part of the motion")
    for what, count in urdf.left_out.items():
        account.say(NOT_TAKEN, what, f"{count}")
    account.of_several(
        NOT_TAKEN, [p.mesh for p in tree.base.pictures], "meshes of the base: a scene has none there"
    )
    turns = [(link.name, link.turn) for link in urdf.links.values()]
    turns += [(joint.name, float(np.max(np.abs(joint.origin.rpy)))) for joint in urdf.joints]
    account.of_several(IN_DOUBT, [name for name, turn in turns if turn > FULL_TURN],
                       "turned by more than a full turn; is it in degrees?")  # fmt: skip
    for joint in urdf.joints:
        if np.linalg.norm(joint.origin.xyz) > FAR:
            far = float(np.linalg.norm(joint.origin.xyz))
            account.say(IN_DOUBT, joint.name, f"lies {far:.4g} m from its parent; is it in mm?")
