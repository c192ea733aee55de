"""The robots in Exudyn's floating frames: beams that are linear in a frame at their root, reduced to modes.

Exudyn's `ObjectFFRFreducedOrder` takes a body as points with masses, modes of their displacements, and a
stiffness of the modes. Here the points are Gauss stations along a chain of Hermite beams clamped at the root,
four in each cross-section where the sections' own inertia counts, and the modes are those of Craig and
Bampton: the tip's static ones, and the lowest with the tip held.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse

from .exudyn_robot import Attempt, solved
from .problem import YOUNG, Link, Problem

ELEMENTS = 8
"""Of the chain that the modes are taken from: it costs the run nothing."""
GAUSS = np.polynomial.legendre.leggauss(4)
IN_PLANE = (0, 1, 5)
"""Of a node's displacements (u, v, w, three rotations), those that a robot in the plane has."""


@dataclass(frozen=True)
class Body:
    """points (P, 3) and masses (P,); modes (3 P, M) and their stiffness (M, M); the tip's points."""

    points: np.ndarray
    masses: np.ndarray
    modes: np.ndarray
    stiffness: np.ndarray
    tip: list[int]


def attempt(problem: Problem, vibrations: int, step: float, planar: bool, repeats: int) -> Attempt:
    """Run with so many modes a link besides the tip's static ones, generalized-alpha."""
    seconds, tip = [], np.zeros((0, 3))
    for _ in range(repeats):
        seconds, tip = _run(problem, vibrations, step, planar, seconds)
    return Attempt(seconds, tip)


def _run(problem, vibrations, step, planar, seconds):
    import exudyn as exu
    import exudyn.itemInterface as item
    from exudyn.FEM import FEMinterface, ObjectFFRFreducedOrderInterface

    mbs = exu.SystemContainer().AddSystem()
    ground = mbs.AddObject(item.ObjectGround())
    e_z = np.array(problem.axes[-1], dtype=float)
    start, before, turned = np.zeros(3), None, np.eye(3)
    for number, link in enumerate(problem.links):
        e_x = np.array(link.direction, dtype=float)
        rotation = np.column_stack([e_x, np.cross(e_z, e_x), e_z])
        body = reduced_beam(problem, link, vibrations, planar)
        mesh = FEMinterface()
        mesh.nodes = {"Position": body.points}
        mesh.massMatrix = scipy.sparse.diags(np.repeat(body.masses, 3)).tocsr()
        mesh.stiffnessMatrix = scipy.sparse.csr_matrix(mesh.massMatrix.shape)
        mesh.modeBasis = {"matrix": body.modes, "type": "HCBmodes"}
        floating = ObjectFFRFreducedOrderInterface(mesh)
        floating.stiffnessMatrixReduced = body.stiffness
        made = floating.AddObjectFFRFreducedOrder(
            mbs, positionRef=list(start), rotationMatrixRef=rotation, gravity=list(problem.gravity)
        )
        root = mbs.AddMarker(item.MarkerNodeRigid(nodeNumber=made["nRigidBody"]))
        axis = np.array(problem.axes[number], dtype=float)
        side = np.eye(3)[int(np.argmin(np.abs(axis)))]
        frame = np.column_stack([np.cross(axis, side), np.cross(axis, np.cross(axis, side)), axis])
        if before is None:
            before = mbs.AddMarker(item.MarkerBodyRigid(bodyNumber=ground, localPosition=list(start)))
        mbs.AddObject(
            item.ObjectJointGeneric(
                markerNumbers=[before, root],
                constrainedAxes=[1, 1, 1, 1, 1, 0],
                rotationMarker0=turned.T @ frame,
                rotationMarker1=rotation.T @ frame,
            )
        )
        if number == 0 and problem.torque:
            load = mbs.AddLoad(item.LoadTorqueVector(markerNumber=root, loadVector=[0.0, 0.0, 0.0]))

            def drive(system, t, load=load):
                system.SetLoadParameter(
                    load, "loadVector", [0.0, 0.0, problem.torque * np.sin(2.0 * np.pi * t)]
                )
                return True

            mbs.SetPreStepUserFunction(drive)
        before = mbs.AddMarker(
            item.MarkerSuperElementRigid(
                bodyNumber=made["oFFRFreducedOrder"],
                meshNodeNumbers=body.tip[:4],
                weightingFactors=[0.25] * 4,
            )
        )
        start, turned = start + link.length * e_x, rotation
        sensor = item.SensorSuperElement(
            bodyNumber=made["oFFRFreducedOrder"],
            meshNodeNumber=body.tip[4],
            storeInternal=True,
            outputVariableType=exu.OutputVariableType.Position,
        )
    return solved(exu, mbs, problem, sensor, step, seconds)


def reduced_beam(problem: Problem, link: Link, vibrations: int, planar: bool) -> Body:
    """A link as points and modes: those of the tip, and the `vibrations` lowest with the tip held."""
    torsion, second_y, second_z = link.bending
    shear_modulus = YOUNG / (2.0 * (1.0 + problem.poisson))
    h = link.length / ELEMENTS
    kept = np.array(IN_PLANE if planar else range(6))
    size = 6 * (ELEMENTS + 1)
    stiffness = np.zeros((size, size))
    element = hermite_stiffness(
        YOUNG * link.area, shear_modulus * torsion, YOUNG * second_y, YOUNG * second_z, h
    )
    for k in range(ELEMENTS):
        stiffness[6 * k : 6 * k + 12, 6 * k : 6 * k + 12] += element
    offsets = np.zeros((1, 2))
    if problem.section_inertia:
        # Four points with the section's own second moments.
        y, z = 0.5 * link.side_y / np.sqrt(3.0), 0.5 * link.side_z / np.sqrt(3.0)
        offsets = np.array([(y, z), (-y, z), (-y, -z), (y, -z)])
    points, masses, rows = [], [], []
    for k in range(ELEMENTS):
        for place, weight in zip(*GAUSS, strict=True):
            s = 0.5 * (1.0 + place)
            for y, z in offsets:
                points.append((h * (k + s), y, z))
                masses.append(0.5 * weight * h * problem.density * link.area / len(offsets))
                rows.append(displacement(s, h, y, z, k, size))
    # The tip's section, without mass: a marker takes its attitude from four points, the last is the tip.
    tip = list(range(len(points), len(points) + 5))
    for y, z in ((0.01, 0.01), (-0.01, 0.01), (-0.01, -0.01), (0.01, -0.01), (0.0, 0.0)):
        points.append((link.length, y, z))
        masses.append(0.0)
        rows.append(displacement(1.0, h, y, z, ELEMENTS - 1, size))
    spread = np.vstack(rows)
    mass = spread.T @ (np.repeat(masses, 3)[:, None] * spread)
    inner = (6 * np.arange(1, ELEMENTS)[:, None] + kept).ravel()
    outer = 6 * ELEMENTS + kept
    shapes = np.zeros((size, len(outer) + vibrations))
    shapes[outer, : len(outer)] = np.eye(len(outer))
    within = stiffness[np.ix_(inner, inner)]
    shapes[inner, : len(outer)] = -np.linalg.solve(within, stiffness[np.ix_(inner, outer)])
    if vibrations:
        lowest = (0, vibrations - 1)
        shapes[inner, len(outer) :] = scipy.linalg.eigh(
            within, mass[np.ix_(inner, inner)], subset_by_index=lowest
        )[1]
    return Body(np.array(points), np.array(masses), spread @ shapes, shapes.T @ stiffness @ shapes, tip)


def displacement(s: float, h: float, y: float, z: float, element: int, size: int) -> np.ndarray:
    """The displacement (3, size) of the section point (y, z) at the part `s` of an element, in the nodes'."""
    v = np.array([1 - 3 * s**2 + 2 * s**3, h * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, h * (s**3 - s**2)])
    slope = (
        np.array([6 * s**2 - 6 * s, h * (1 - 4 * s + 3 * s**2), 6 * s - 6 * s**2, h * (3 * s**2 - 2 * s)]) / h
    )
    centre, turn = np.zeros((3, 12)), np.zeros((3, 12))
    centre[0, [0, 6]] = turn[0, [3, 9]] = 1 - s, s
    centre[1, [1, 5, 7, 11]], turn[2, [1, 5, 7, 11]] = v, slope
    signs = np.array([1, -1, 1, -1])
    centre[2, [2, 4, 8, 10]], turn[1, [2, 4, 8, 10]] = signs * v, -signs * slope
    moved = np.zeros((3, size))
    arm = np.array([[0.0, z, -y], [-z, 0.0, 0.0], [y, 0.0, 0.0]])
    moved[:, 6 * element : 6 * element + 12] = centre + arm @ turn
    return moved


def hermite_stiffness(axial: float, torsion: float, about_y: float, about_z: float, h: float) -> np.ndarray:
    """The stiffness (12, 12) of a slender straight beam; displacements and rotations of two nodes."""
    stiffness = np.zeros((12, 12))
    rod = np.array([[1.0, -1.0], [-1.0, 1.0]]) / h
    stiffness[np.ix_([0, 6], [0, 6])] = axial * rod
    stiffness[np.ix_([3, 9], [3, 9])] = torsion * rod
    beam = np.array(
        [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2],
         [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]]
    ) / h**3  # fmt: skip
    signs = np.array([1, -1, 1, -1])
    stiffness[np.ix_([1, 5, 7, 11], [1, 5, 7, 11])] = about_z * beam
    stiffness[np.ix_([2, 4, 8, 10], [2, 4, 8, 10])] = about_y * np.outer(signs, signs) * beam
    return stiffness
