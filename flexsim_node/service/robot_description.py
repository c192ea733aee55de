"""The rigid robot as URDF: geometry and inertia, for robot_state_publisher, RViz and planners.

A URDF link's frame sits at its joint, where Denavit-Hartenberg's sits at the link's far end.  So
frame l of the URDF is frame l-1 of the robot turned (or slid) by joint l, and a last link, `tip`,
is the last frame itself.  The frame of a named point, LINK/POINT, sits at the point.
"""

from __future__ import annotations

import xml.etree.ElementTree as xml
from collections.abc import Iterator

import numpy as np

from ..elements.section import section
from ..model.erls import beam_axes, joint_axis, mount, reach, to_joint
from ..rotations.roll_pitch_yaw import roll_pitch_yaw, rotation
from ..scene.schema import BASE, Beam, Link, Scene

TIP = "tip"
FAR = 1e3  # m; URDF insists on limits for a sliding joint, a scene has none
COLOURS = ("0.36 0.43 0.52 1", "0.85 0.52 0.22 1")


def robot_description(scene: Scene) -> str:
    """Return a scene's robot as the text of a URDF."""
    robot = xml.Element("robot", name=scene.name)
    for n, colour in enumerate(COLOURS):
        xml.SubElement(xml.SubElement(robot, "material", name=f"colour_{n}"), "color", rgba=colour)
    xml.SubElement(robot, "link", name=root_name(scene))
    names = iter(scene.joint_names)
    for n, (link, parent) in enumerate(zip(scene.links, scene.parents, strict=True)):
        name, place, turn = _end(scene, parent)
        angle = link.dh.theta
        c, s = np.cos(angle), np.sin(angle)
        turn = turn @ mount(link) @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        if is_point(link):
            place = place + turn @ reach(link)
        _joint(robot, link, names, name, place, turn)
        _link(robot, link, n)
    tip = TIP
    while tip in scene.link_names or f"{tip}_joint" in scene.joint_names:
        tip += "_"
    joint = xml.SubElement(robot, "joint", name=f"{tip}_joint", type="fixed")
    xml.SubElement(robot, "link", name=tip)
    name, place, turn = _end(scene, len(scene.links) - 1)
    _connect(joint, name, tip, place, turn)
    xml.indent(robot)
    return '<?xml version="1.0"?>\n' + xml.tostring(robot, encoding="unicode")


def root_name(scene: Scene) -> str:
    """Name of the URDF's root: the base, unless a link is called so."""
    return "world" if any(link.name == BASE for link in scene.links) else BASE


def is_point(link: Link) -> bool:
    """Whether a link is but a point of another (scene/schema/frames.py)."""
    held = link.frame is not None and link.joint.type == "fixed" and not any(link.frame.rpy)
    return held and "/" in link.name and link.beam is None and not link.bodies


def _end(scene: Scene, n: int) -> tuple[str, np.ndarray, np.ndarray]:
    """Name of link n, and place (3,) and rotation (3, 3) of its end in its URDF frame; -1: the base."""
    if n < 0:
        return root_name(scene), np.zeros(3), np.eye(3)
    link = scene.links[n]
    if is_point(link):
        return link.name, np.zeros(3), np.eye(3)
    return link.name, to_joint(link) @ reach(link), to_joint(link)


def _joint(
    robot: xml.Element,
    link: Link,
    names: Iterator[str],
    parent: str,
    place: np.ndarray,
    turn: np.ndarray,
) -> None:
    joint = link.joint
    kind = {"fixed": "fixed", "revolute": "continuous", "prismatic": "prismatic"}[joint.type]
    name = f"{link.name}_mount" if kind == "fixed" else next(names)
    element = xml.SubElement(robot, "joint", name=name, type=kind)
    _connect(element, parent, link.name, place, turn)
    if kind == "fixed":
        return
    xml.SubElement(element, "axis", xyz=_numbers(joint_axis(link)))
    limit = {"effort": _number(joint.effort_limit or FAR), "velocity": _number(FAR)}
    if kind == "prismatic":
        limit.update(lower=_number(-FAR), upper=_number(FAR))
    if kind == "prismatic" or joint.effort_limit is not None:
        xml.SubElement(element, "limit", limit)
    xml.SubElement(
        element,
        "dynamics",
        damping=_number(joint.viscous_friction),
        friction=_number(joint.coulomb_friction),
    )


def _connect(joint: xml.Element, parent: str, child: str, place: np.ndarray, turn: np.ndarray) -> None:
    _origin(joint, place, turn)
    xml.SubElement(joint, "parent", link=parent)
    xml.SubElement(joint, "child", link=child)


def _link(robot: xml.Element, link: Link, n: int) -> None:
    element = xml.SubElement(robot, "link", name=link.name)
    axes, length = beam_axes(link)
    axes = to_joint(link) @ axes  # in the URDF's frame of the link
    end = to_joint(link) @ reach(link)
    mass, centre, inertia = rigid_inertia(link)
    if mass > 0.0:
        inertial = xml.SubElement(element, "inertial")
        _origin(inertial, centre, np.eye(3))
        xml.SubElement(inertial, "mass", value=_number(mass))
        names = {
            "ixx": (0, 0),
            "ixy": (0, 1),
            "ixz": (0, 2),
            "iyy": (1, 1),
            "iyz": (1, 2),
            "izz": (2, 2),
        }
        xml.SubElement(inertial, "inertia", {k: _number(inertia[ij]) for k, ij in names.items()})
    for picture in link.visuals:
        shape = xml.SubElement(element, "visual")
        _origin(shape, np.array(picture.frame.xyz), rotation(picture.frame.rpy))
        geometry = xml.SubElement(shape, "geometry")
        xml.SubElement(geometry, "mesh", filename=picture.mesh, scale=_numbers(np.array(picture.scale)))
    if link.beam is None or length == 0.0 or link.visuals:
        return
    width, depth = equivalent_rectangle(link.beam)
    for purpose in ("visual", "collision"):
        shape = xml.SubElement(element, purpose)
        _origin(shape, 0.5 * end, axes)
        box = xml.SubElement(shape, "geometry")
        xml.SubElement(box, "box", size=_numbers(np.array([length, width, depth])))
        if purpose == "visual":
            xml.SubElement(shape, "material", name=f"colour_{n % len(COLOURS)}")


def rigid_inertia(link: Link) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, centre of mass (3,) and inertia about it (3, 3) of a link with all it carries.

    In the link's URDF frame.
    """
    axes, length = beam_axes(link)
    to_link = to_joint(link)  # the scene's axes
    end = to_link @ reach(link)
    parts = []
    if link.beam is not None and length > 0.0:
        s = section(link.beam)
        mass = link.beam.density * s.area * length
        line = link.beam.density * length
        across = mass * length**2 / 12.0
        own = np.diag([line * (s.iy + s.iz), across + line * s.iy, across + line * s.iz])
        turn = to_link @ axes
        parts.append((mass, 0.5 * end, turn @ own @ turn.T))
    for body, center in link.bodies:
        own = np.array(body.inertia) if body.inertia else np.zeros((3, 3))
        parts.append((body.mass, end + to_link @ center, to_link @ own @ to_link.T))
    if not parts:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    mass = sum(m for m, _, _ in parts)
    centre = np.sum([m * c for m, c, _ in parts], axis=0) / mass
    inertia = np.zeros((3, 3))
    for m, c, own in parts:
        r = c - centre
        inertia += own + m * (r @ r * np.eye(3) - np.outer(r, r))
    return mass, centre, inertia


def equivalent_rectangle(beam: Beam) -> tuple[float, float]:
    """Width and depth, m, of the rectangle with a section's second moments over its area."""
    s = section(beam)
    return float(np.sqrt(12.0 * s.iz / s.area)), float(np.sqrt(12.0 * s.iy / s.area))


def _origin(element: xml.Element, place: np.ndarray, turn: np.ndarray) -> None:
    xml.SubElement(element, "origin", xyz=_numbers(place), rpy=_numbers(roll_pitch_yaw(turn)))


def _number(value: float) -> str:
    return f"{value:.12g}"


def _numbers(values: np.ndarray) -> str:
    return " ".join(_number(0.0 if abs(v) < 1e-15 else v) for v in values)
