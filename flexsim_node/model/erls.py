"""The equivalent rigid-link system: its frames in the links, and the elastic dofs that are zeroed so that its
joint coordinates are defined (thesis 2.16)."""

from __future__ import annotations

import numpy as np

from ..rotations.roll_pitch_yaw import rotation
from ..scene.load import Scene, SceneError
from ..scene.schema import Link
from .chain import FIXED, PRISMATIC, REVOLUTE, Chain


def rotation_x(angle: float) -> np.ndarray:
    """(3, 3) rotation about x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def mount(link: Link) -> np.ndarray:
    """(3, 3) axes of the joint in the parent's frame, without the joint's own rotation and theta."""
    return np.eye(3) if link.frame is None else rotation(link.frame.rpy)


def joint_axis(link: Link) -> np.ndarray:
    """(3,) unit vector of the joint's axis in the joint's axes."""
    axis = np.array(link.joint.axis or (0.0, 0.0, 1.0))
    return axis / np.linalg.norm(axis)


def to_joint(link: Link) -> np.ndarray:
    """(3, 3) axes of the link's frame in those that the joint turns: a link of `frame` has the same."""
    return rotation_x(link.dh.alpha) if link.frame is None else np.eye(3)


def reach(link: Link) -> np.ndarray:
    """(3,) from the link's start to its end, in the link's frame, m."""
    if link.frame is not None:
        return np.array(link.end or (0.0, 0.0, 0.0))
    a, d, alpha = link.dh.a, link.dh.d, link.dh.alpha
    return np.array([a, d * np.sin(alpha), d * np.cos(alpha)])


def about_axis(link: Link, axes: np.ndarray) -> np.ndarray:
    """(3, 3) rows in beam axes: z along the joint's axis, x the part of x_l normal to it (or of y_l)."""
    inside = to_joint(link) @ axes
    axis = joint_axis(link)
    if axis[2] == 1.0:
        return inside
    x = np.eye(3)[0] - axis[0] * axis
    if np.linalg.norm(x) < 1e-6:
        x = np.eye(3)[1] - axis[1] * axis
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(axis, x), axis]) @ inside


def beam_axes(link: Link) -> tuple[np.ndarray, float]:
    """Columns x, y, z of the beam axes in the link's frame, and the link's length."""
    along = reach(link)
    length = float(np.linalg.norm(along))
    if length < 1e-9:
        return np.eye(3), 0.0
    x = along / length
    z = np.array([0.0, 0.0, 1.0]) - x[2] * x
    if np.linalg.norm(z) < 1e-9:
        z = np.array([1.0, 0.0, 0.0]) - x[0] * x
    z /= np.linalg.norm(z)
    return np.column_stack([x, np.cross(z, x), z]), length


def zeroed_directions(scene: Scene, driven: tuple[str, ...]) -> list[dict[tuple[int, int], np.ndarray]]:
    """For each link the zeroed dofs: (node, dof about the joint's frame) to a direction (6,) in beam axes."""
    found: list[dict[tuple[int, int], np.ndarray]] = [{} for _ in scene.links]
    zeroed = scene.erls.zeroed
    names = dict(
        zip((n for n, k in enumerate(scene.links) if k.joint.type != "fixed"), scene.joint_names, strict=True)
    )
    if isinstance(zeroed, tuple):
        listed_directions(scene, found)
        for n, name in names.items():
            if name in driven and scene.links[n].joint.type == "revolute" and (0, 5) not in found[n]:
                raise SceneError(
                    f"{scene.name}: erls.zeroed: the motion of {name} is prescribed, but its motor's angle is"
                    f" not a coordinate; zero rz of node 0 of {scene.links[n].name}, or give zeroed: auto"
                )
        return found
    for n, link in enumerate(scene.links):
        if link.joint.type != "revolute":
            continue
        beam = link.beam
        axes, _ = beam_axes(link)
        if zeroed != "root" and names[n] not in driven and beam is not None and link.flexible:
            axis = about_axis(link, axes)[2]
            across = np.cross(axis, [1.0, 0.0, 0.0])
            direction = np.zeros(6)
            effects = scene.effects
            if np.linalg.norm(across) > 1e-6:
                if (effects.bending_z or not across[1]) and (effects.bending_y or not across[2]):
                    direction[:3] = across / np.linalg.norm(across)
                    found[n][end_node(scene, link), 1] = direction
                    continue
            elif effects.torsion:
                direction[3] = 1.0
                found[n][end_node(scene, link), 3] = direction
                continue
        found[n][0, 5] = np.zeros(6)
    return found


def end_node(scene: Scene, link: Link) -> int:
    """Number of a beam's last node as the equations count: a reduced link is one element."""
    return 1 if scene.modes_of(link) is not None or link.beam is None else link.beam.elements


def listed_directions(scene: Scene, found: list[dict[tuple[int, int], np.ndarray]]) -> None:
    """Directions of an explicit list of zeroed dofs."""
    zeroed = scene.erls.zeroed
    assert isinstance(zeroed, tuple)
    names = [link.name for link in scene.links]
    letters = ("x", "y", "z", "rx", "ry", "rz")
    moving = sum(link.joint.type == "revolute" for link in scene.links)
    if len(zeroed) != moving:
        raise SceneError(
            f"{scene.name}: erls.zeroed: lists {len(zeroed)} dofs for {moving} revolute joints;"
            " give one a joint"
        )
    for number, entry in enumerate(zeroed):
        where = f"{scene.name}: erls.zeroed.{number}"
        n = names.index(entry.link)
        link = scene.links[n]
        dof = letters.index(entry.dof)
        if entry.node == 0:
            if dof != 5:
                raise SceneError(
                    f"{where}: dof {entry.dof} of node 0 is shared with the link before;"
                    " only rz is the joint's own"
                )
            if link.joint.type != "revolute":
                raise SceneError(f"{where}: {link.name} has no revolute joint; leave it out")
            if (0, 5) in found[n]:
                raise SceneError(f"{where}: is listed twice; give one dof a joint")
            found[n][0, 5] = np.zeros(6)
            continue
        if link.beam is None or not link.flexible:
            raise SceneError(f"{where}: {link.name} is rigid; give node: 0, dof: rz")
        if entry.node > link.beam.elements:
            raise SceneError(
                f"{where}: {link.name} has no node {entry.node}; its end is node {link.beam.elements}"
            )
        axes, _ = beam_axes(link)
        inside = about_axis(link, axes)
        direction = np.zeros(6)
        half = slice(0, 3) if dof < 3 else slice(3, 6)
        direction[half] = np.where(np.abs(inside[dof % 3]) < 1e-12, 0.0, inside[dof % 3])
        effects = scene.effects
        on = [effects.axial, effects.bending_z, effects.bending_y]
        on += [effects.torsion, effects.bending_y, effects.bending_z]
        if any(direction[k] != 0.0 and not on[k] for k in range(6)):
            raise SceneError(f"{where}: dof {entry.dof} belongs to an effect that is off; give another")
        if (entry.node, dof) in found[n]:
            raise SceneError(f"{where}: is listed twice; give one dof a joint")
        found[n][min(entry.node, end_node(scene, link)), dof] = direction


def erls_condition(chain: Chain, zeroed: list[dict[tuple[int, int], np.ndarray]], q: np.ndarray) -> float:
    """Condition of J_0 (thesis 2.16): how the zeroed dofs of the rigid links move with the joints."""
    twists = rigid_twists(chain, q)
    rows = []
    revolute = [int(row[1]) for row in chain.link if row[0] == REVOLUTE]
    if not revolute:
        return 1.0
    for n, directions in enumerate(zeroed):
        first, count = chain.link[n, 3], chain.link[n, 4]
        for (node, _), direction in directions.items():
            if node == 0:
                # relative to the link before: q itself
                row = np.zeros(q.size)
                row[chain.link[n, 1]] = 1.0
                rows.append(row)
                continue
            x = chain.place[first + node]
            length = chain.place[first + count]
            point = twists[n, :3] + np.cross(twists[n, 3:], [x, 0.0, 0.0], axis=0)
            rows.append((direction[:3] @ point) / length + direction[3:] @ twists[n, 3:])
    return float(np.linalg.cond(np.array(rows)[:, revolute]))


def rigid_twists(chain: Chain, q: np.ndarray) -> np.ndarray:
    """(L, 6, m) velocity (linear at the start, angular) of body frames for unit joint rates, body axes."""
    links = len(chain.link)
    twists = np.zeros((links, 6, q.size))
    for n in range(links):
        kind, k, parent = chain.link[n, 0], chain.link[n, 1], chain.link[n, 6]
        value = q[k] if kind != FIXED else 0.0
        angle = chain.joint[n, 7] + (value if kind == REVOLUTE else 0.0)
        constant, cosine, sine = chain.rotation[n]
        turn = constant + np.cos(angle) * cosine + np.sin(angle) * sine
        lever = value * chain.joint[n, 4:7] if kind == PRISMATIC else np.zeros(3)
        linear: np.ndarray = np.zeros((3, q.size))
        angular: np.ndarray = linear
        if parent >= 0:
            lever = lever + chain.joint[parent, 0] * np.eye(3)[0]
            angular = twists[parent, 3:]
            linear = twists[parent, :3] + np.cross(angular, lever, axis=0)
        twists[n, :3] = turn.T @ linear
        twists[n, 3:] = turn.T @ angular
        if kind == REVOLUTE:
            twists[n, 3:, k] += chain.joint[n, 1:4]
        elif kind == PRISMATIC:
            twists[n, :3, k] += chain.joint[n, 1:4]
    return twists
