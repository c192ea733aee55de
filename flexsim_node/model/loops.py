"""A scene's closing joints as equations between points and directions on the links' ends (closure.py)."""

from __future__ import annotations

import numpy as np

from ..scene.schema import BASE, ClosingJoint, Scene
from .chain import DIRECTION, POINT

X, Y, Z = np.eye(3)
BASE_FRAME = -1
SECOND = 1  # of a joint's two links


def closing_equations(scene: Scene, axes: np.ndarray, planar: bool) -> tuple[np.ndarray, np.ndarray]:
    """Chain.closing (R, 5) and Chain.anchor (R, 9) of a scene; axes (L, 3, 3) are the links' beam axes."""
    names = [BASE, *(link.name for link in scene.links)]
    to_body = [np.eye(3), *(a.T for a in axes)]
    closing: list[tuple[int, ...]] = []
    anchor: list[np.ndarray] = []
    for number, loop in enumerate(scene.loops):
        ends = [names.index(name) for name in loop.links]
        one, two = (n - 1 for n in ends)
        turn = [to_body[n] for n in ends]
        points = [turn[i] @ loop.point(loop.links[i]) for i in (0, 1)]
        for direction, rides in common_point(loop, planar):
            closing.append((POINT, one, two, two if rides == SECOND else BASE_FRAME, number))
            body = turn[1] @ direction if rides == SECOND else direction
            anchor.append(np.concatenate([*points, body]))
        for a, b in normal_directions(loop, planar):
            closing.append((DIRECTION, one, two, BASE_FRAME, number))
            anchor.append(np.concatenate([turn[0] @ a, turn[1] @ b, np.zeros(3)]))
    return np.array(closing, dtype=np.int64).reshape(-1, 5), np.array(anchor).reshape(-1, 9)


def common_point(loop: ClosingJoint, planar: bool) -> list[tuple[np.ndarray, int]]:
    """Directions along which the joint's two points agree, and what each direction rides on."""
    if loop.joint != "slot":
        return [(direction, BASE_FRAME) for direction in ((X, Y) if planar else (X, Y, Z))]
    along = loop.direction(loop.links[1])
    if planar:
        return [(np.cross(Z, along), SECOND)]
    return [(direction, SECOND) for direction in normals(along)]


def normal_directions(loop: ClosingJoint, planar: bool) -> list[tuple[np.ndarray, np.ndarray]]:
    """Pairs of directions, in the frames of the two links' ends, that stay normal to each other."""
    if loop.joint == "fixed":
        return [(X, Y)] if planar else [(X, Y), (Y, Z), (Z, X)]
    if loop.joint == "revolute" and not planar:
        first, second = (loop.direction(name) for name in loop.links)
        return [(first, direction) for direction in normals(second)]
    if loop.joint == "universal" and not planar:
        first, second = (loop.direction(name) for name in loop.links)
        return [(first, second)]
    return []


def normals(axis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors normal to an axis and to each other."""
    one = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    one /= np.linalg.norm(one)
    return one, np.cross(axis, one)


def flat(loop: ClosingJoint) -> bool:
    """Whether a closing joint leaves a planar robot in its plane."""
    if any(loop.point(name)[2] != 0.0 for name in loop.links):
        return False
    if loop.joint == "slot":
        return bool(loop.direction(loop.links[1])[2] == 0.0)
    axes = [loop.direction(name) for name in loop.links]
    return loop.joint != "universal" and (loop.joint != "revolute" or all(a[0] == a[1] == 0.0 for a in axes))
