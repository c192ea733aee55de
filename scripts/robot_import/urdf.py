"""A URDF's links and joints, as they stand there, and the tree that they make."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from flexsim_node.rotations.roll_pitch_yaw import rotation

from .left_out import left_out
from .xml_file import Element, ImportRefused

KINDS = ("revolute", "continuous", "prismatic", "fixed")
NOT_KNOWN = {
    "floating": "moves freely in space",
    "planar": "slides in a plane",
    "spherical": "is a ball",
}
MOST_LINKS = 1000
BOUNDLESS = ("inf", "infinity")
NOTHING = 1e-15  # kg m2: rounding, written as if it were an inertia


def about_axis(axis: np.ndarray, angle: float) -> np.ndarray:
    """(3, 3) rotation about a unit vector (3,)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)


@dataclass
class Origin:
    """Place (3,) m and roll, pitch, yaw (3,) rad."""

    xyz: np.ndarray
    rpy: np.ndarray

    @property
    def turn(self) -> np.ndarray:
        """(3, 3) axes."""
        return rotation(self.rpy)


@dataclass
class Body:
    """Mass (kg), centre (3,) m and inertia about it (3, 3), in the link's axes."""

    mass: float
    center: np.ndarray
    inertia: np.ndarray


@dataclass
class Picture:
    """A visual mesh: its path, place and scale; whether no such file is there."""

    mesh: str
    origin: Origin
    scale: np.ndarray
    missing: bool = False


@dataclass
class UrdfLink:
    """A link: its body, None where it has no inertial; its meshes; how many plain shapes are left out.

    turn : largest angle that is written in it, rad
    """

    name: str
    where: str
    body: Body | None
    pictures: list[Picture]
    shapes: int
    collisions: int
    turn: float


@dataclass
class UrdfJoint:
    """A joint, with the numbers that its URDF gives; None where it gives none."""

    name: str
    where: str
    kind: str
    parent: str
    child: str
    origin: Origin
    axis: np.ndarray
    axis_given: bool
    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
    velocity: float | None = None
    damping: float = 0.0
    friction: float = 0.0
    mimic: str = ""  # the joint that it follows: multiplier times its position, and offset
    multiplier: float = 1.0
    offset: float = 0.0
    extras: tuple[str, ...] = ()


@dataclass
class Urdf:
    """A robot: links by name, joints in the order of the file, the root; what is not read, and how often."""

    name: str
    links: dict[str, UrdfLink]
    joints: list[UrdfJoint]
    root: str
    left_out: Mapping[str, int] = field(default_factory=dict)

    def below(self, link: str) -> list[UrdfJoint]:
        """The joints whose parent is a link."""
        return [joint for joint in self.joints if joint.parent == link]

    def depth_first(self) -> Iterator[UrdfJoint]:
        """All joints, each after that of its parent."""
        children: dict[str, list[UrdfJoint]] = {}
        for joint in self.joints:
            children.setdefault(joint.parent, []).append(joint)
        waiting = children.get(self.root, [])[::-1]
        while waiting:
            joint = waiting.pop()
            yield joint
            waiting.extend(children.get(joint.child, [])[::-1])


def read_urdf(root: Element, folder: Path) -> Urdf:
    """The robot of a URDF's root element; meshes' relative paths count from `folder`.

    Raises
    ------
    ImportRefused
        where it is none, or its links and joints make no tree
    """
    if root.tag == "sdf" or root.tag == "mujoco":
        kind = "SDF" if root.tag == "sdf" else "MJCF"
        raise ImportRefused(f"{root.where}: is {kind}, which is not read; convert it to URDF")
    if root.tag != "robot":
        raise ImportRefused(f"{root.where}: <{root.tag}> is no robot; give a URDF, whose root is <robot>")
    left = next((key for key in walk(root) if key.tag.startswith("xacro:")), None)
    if left is not None:
        raise ImportRefused(
            f"{left.where}: <{left.tag}> is xacro, in a file that is called a URDF; name it .xacro, or"
            " convert it: xacro IN.xacro > OUT.urdf"
        )
    links: dict[str, UrdfLink] = {}
    for element in root.all("link"):
        name = element.text("name")
        if name in links:
            element.refuse(f"is there twice, first at {links[name].where}; give each link its own name")
        links[name] = read_link(element, name, folder)
    joints: list[UrdfJoint] = []
    named: set[str] = set()
    for element in root.all("joint"):
        joint = read_joint(element)
        if joint.name in named:
            element.refuse("is there twice; give each joint its own name")
        named.add(joint.name)
        joints.append(joint)
    if not links:
        root.refuse("has no links; give a robot")
    if len(links) > MOST_LINKS:
        root.refuse(f"has {len(links)} links; give a robot of at most {MOST_LINKS}")
    check_mimics(joints)
    name = root.attributes.get("name", "").strip() or "robot"
    return Urdf(name, links, joints, root_of(root, links, joints), left_out(root))


def check_mimics(joints: list[UrdfJoint]) -> None:
    """Refuse joints that follow each other in a circle."""
    known = {joint.name: joint for joint in joints}
    for joint in joints:
        seen, ahead = [joint.name], joint
        while ahead.mimic in known:
            if ahead.mimic in seen:
                raise ImportRefused(
                    f"{ahead.where}: <joint {ahead.name!r}> follows {ahead.mimic!r}, which follows it in a"
                    " circle; let one of them move on its own"
                )
            ahead = known[ahead.mimic]
            seen.append(ahead.name)


def walk(element: Element) -> Iterator[Element]:
    """An element and all in it."""
    waiting = [element]
    while waiting:
        found = waiting.pop()
        yield found
        waiting.extend(found.children)


def root_of(robot: Element, links: dict[str, UrdfLink], joints: list[UrdfJoint]) -> str:
    """The link that hangs on none; refuses what is no tree."""
    above: dict[str, UrdfJoint] = {}
    for joint in joints:
        for end, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in links:
                raise ImportRefused(
                    f"{joint.where}: <joint {joint.name!r}> has the {end} {name!r}, which is no link; give"
                    " one of the file's links"
                )
        if joint.child in above:
            raise ImportRefused(
                f"{joint.where}: <joint {joint.name!r}> holds {joint.child!r}, which"
                f" {above[joint.child].name} holds already; a URDF is a tree: give a link"
                " one parent, and close the loop with --with"
            )
        above[joint.child] = joint
    roots = [name for name in links if name not in above]
    if len(roots) > 1:
        raise ImportRefused(
            f"{robot.where}: <robot> has {len(roots)} roots, {', '.join(roots[:5])}; join them to one link"
        )
    children: dict[str, list[str]] = {}
    for joint in joints:
        children.setdefault(joint.parent, []).append(joint.child)
    reached, waiting = set(roots), list(roots)
    while waiting:
        found = children.get(waiting.pop(), [])
        reached.update(found)
        waiting.extend(found)
    if len(reached) == len(links):
        return roots[0]
    circle = next(joint for joint in joints if joint.child not in reached)
    raise ImportRefused(
        f"{circle.where}: <joint {circle.name!r}> is in a circle of joints that reaches no root; a URDF is a"
        " tree: break the circle, and close the loop with --with"
    )


def read_origin(element: Element) -> Origin:
    """The origin in an element; identity where there is none."""
    origin = element.one("origin")
    zero = (0.0, 0.0, 0.0)
    if origin is None:
        return Origin(np.zeros(3), np.zeros(3))
    if "quat_xyzw" in origin.attributes:
        origin.refuse("has a quaternion, which URDF 1.0 has not; give rpy")
    return Origin(origin.numbers("xyz", 3, zero), origin.numbers("rpy", 3, zero))


def mesh_path(written: str, folder: Path) -> tuple[str, bool]:
    """A mesh's path, absolute where it was beside the URDF, and whether no such file is there.

    Those of packages are kept as they are: where packages lie is not known here.
    """
    if "://" in written and not written.startswith("file://"):
        return written, False
    path = folder / written.removeprefix("file://")
    return f"file://{path.resolve()}", not path.is_file()


def read_link(element: Element, name: str, folder: Path) -> UrdfLink:
    """A link with its body, turned into the link's axes."""
    inertial, body = element.one("inertial"), None
    angles = [0.0]
    if inertial is not None:
        origin, mass, inertia = read_origin(inertial), inertial.one("mass"), inertial.one("inertia")
        if mass is None:
            inertial.refuse(f"of link {name!r} has no <mass>; give one, or leave out the inertial")
        assert mass is not None
        kg = mass.number("value")
        own: np.ndarray = np.zeros((3, 3))
        if kg < 0.0:
            mass.refuse(f"of link {name!r} is {kg:g}; give kg")
        if inertia is not None:
            keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
            xx, xy, xz, yy, yz, zz = (inertia.number(key, None if key[1] == key[2] else 0.0) for key in keys)
            own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        if np.max(np.abs(own)) < NOTHING:
            own = np.zeros((3, 3))
        turn = origin.turn
        angles.extend(np.abs(origin.rpy))
        body = Body(kg, origin.xyz, turn @ own @ turn.T) if kg > 0.0 or own.any() else None
    pictures, shapes = [], 0
    for visual in element.all("visual"):
        geometry = visual.one("geometry")
        mesh = geometry.one("mesh") if geometry is not None else None
        if mesh is None:
            shapes += 1
            continue
        scale = mesh.numbers("scale", 3, (1.0, 1.0, 1.0))
        place = mesh_path(mesh.text("filename"), folder)
        pictures.append(Picture(place[0], read_origin(visual), scale, place[1]))
        angles.extend(np.abs(pictures[-1].origin.rpy))
    collisions = len(element.all("collision"))
    return UrdfLink(name, element.where, body, pictures, shapes, collisions, float(max(angles)))


def read_joint(element: Element) -> UrdfJoint:
    """A joint; refuses kinds that a scene has not."""
    name, kind = element.text("name"), element.text("type")
    if kind not in KINDS:
        why = f", which {NOT_KNOWN[kind]}," if kind in NOT_KNOWN else ""
        element.refuse(f"is of type {kind!r}{why} and can't be taken; give {', '.join(KINDS)}")
    ends = []
    for tag in ("parent", "child"):
        end = element.one(tag)
        if end is None:
            element.refuse(f'has no <{tag}>; give <{tag} link="..."/>')
        assert end is not None
        ends.append(end.text("link"))
    axis, given = np.array([1.0, 0.0, 0.0]), False
    written = element.one("axis")
    if kind != "fixed" and written is not None:
        axis, given = written.numbers("xyz", 3), True
        if np.linalg.norm(axis) < 1e-9:
            element.refuse("has the axis 0 0 0; give a direction, such as 0 0 1")
    joint = UrdfJoint(name, element.where, kind, ends[0], ends[1], read_origin(element), axis, given)
    limit, dynamics, mimic = (element.one(tag) for tag in ("limit", "dynamics", "mimic"))
    if limit is not None and kind != "fixed":
        for key in ("lower", "upper", "effort", "velocity"):
            if (
                key in limit.attributes
                and limit.attributes[key].strip().lstrip("+-").lower() not in BOUNDLESS
            ):
                setattr(joint, key, limit.number(key))
        if kind in ("revolute", "prismatic") and (joint.lower or 0.0) > (joint.upper or 0.0):
            limit.refuse(f"of joint {name!r} is from {joint.lower} to {joint.upper}; give lower below upper")
        for key in ("effort", "velocity"):
            if (getattr(joint, key) or 0.0) < 0.0:
                limit.refuse(f"of joint {name!r} has {key} {getattr(joint, key):g}; give at least 0")
    if dynamics is not None and kind != "fixed":
        joint.damping, joint.friction = dynamics.number("damping", 0.0), dynamics.number("friction", 0.0)
        if joint.damping < 0.0 or joint.friction < 0.0:
            dynamics.refuse(f"of joint {name!r} is below 0 and would drive the joint; give at least 0")
    if mimic is not None and kind != "fixed":
        joint.mimic = mimic.text("joint")
        joint.multiplier, joint.offset = mimic.number("multiplier", 1.0), mimic.number("offset", 0.0)
    joint.extras = tuple(t for t in ("calibration", "safety_controller") if element.all(t))
    return joint
