"""Reference motions of soft robots by geometrically exact beams of Exudyn (https://github.com/jgerstmayr/EXUDYN).

    python benchmarks/soft_references.py CASE [--modulus 5e9] [--elements 16] [--step 1e-4] [--out FILE.csv]

CASE is `falling` (planar ANCF cables, without rotary inertia), `falling_shear` (planar geometrically exact
beams with shear and rotary inertia) or `driven` (geometrically exact beams in space).  Needs the extra
`peers`: pip install flexsim[peers].  With the modulus of steel the output is the reference data of steel.
"""

from __future__ import annotations

import argparse
import sys
import time
from itertools import pairwise
from pathlib import Path

import exudyn as exu
import numpy as np
from exudyn import beams
from exudyn import itemInterface as items
from exudyn.rigidBodyUtilities import RotationMatrix2EulerParameters

RECTANGLE_SHEAR = 5.0 / 6.0


def torsion_constant(width: float, depth: float) -> float:
    """St Venant's torsion constant of a rectangle, by its series."""
    a, b = max(width, depth), min(width, depth)
    odd = np.arange(1, 60, 2)
    series = np.sum(np.tanh(odd * np.pi * a / (2 * b)) / odd**5)
    return float(a * b**3 * (1 / 3 - 64 / np.pi**5 * b / a * series))


def solve(system, watched: list[int], duration: float, step: float) -> np.ndarray:
    """(K, 1 + 3 L) time and positions of the watched nodes, every 10 ms."""
    sensors = [
        system.AddSensor(
            items.SensorNode(
                nodeNumber=n, storeInternal=True, outputVariableType=exu.OutputVariableType.Position
            )
        )
        for n in watched
    ]
    system.Assemble()
    settings = exu.SimulationSettings()
    integration = settings.timeIntegration
    integration.numberOfSteps = round(duration / step)
    integration.endTime = duration
    integration.verboseMode = 0
    integration.newton.relativeTolerance = 1e-7
    integration.newton.absoluteTolerance = 1e-8
    integration.generalizedAlpha.spectralRadius = 0.9
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = 0.01
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
    system.SolveDynamic(settings)
    tables = [np.array(system.GetSensorStoredData(s)) for s in sensors]
    return np.hstack([tables[0][:, :1], *(t[:, 1:4] for t in tables)])


def falling(modulus: float, elements: int, step: float, shear: bool) -> np.ndarray:
    """Thesis table 2.3: two links of 0.5 m, released at rest from horizontal; 1 s."""
    system = exu.SystemContainer().AddSystem()
    ground = system.AddObject(items.ObjectGround())
    before = system.AddMarker(items.MarkerBodyPosition(bodyNumber=ground, localPosition=[0, 0, 0]))
    density, poisson, ends = 7840.0, 0.3, []
    for n, (width, depth) in enumerate(((0.03, 0.01), (0.01, 0.03))):
        area, second = width * depth, depth * width**3 / 12
        common = {
            "massPerLength": density * area,
            "bendingStiffness": modulus * second,
            "axialStiffness": modulus * area,
        }
        line = [0.5 * n, 0, 0], [0.5 * (n + 1), 0, 0]
        if shear:
            template = items.ObjectBeamGeometricallyExact2D(
                crossSectionInertia=density * second,
                shearStiffness=RECTANGLE_SHEAR * modulus / (2 * (1 + poisson)) * area,
                nodeNumbers=[-1, -1, -1],
                **common,
            )
            made = beams.GenerateStraightBeam(system, *line, elements, template, gravity=[0, -9.81, 0])
        else:
            made = beams.GenerateStraightLineANCFCable2D(
                system,
                *line,
                elements,
                items.ObjectANCFCable2D(**common),
                massProportionalLoad=[0, -9.81, 0],
            )
        first, last = made[0][0], made[0][-1]
        here = system.AddMarker(items.MarkerNodePosition(nodeNumber=first))
        system.AddObject(items.ObjectJointSpherical(markerNumbers=[before, here], constrainedAxes=[1, 1, 0]))
        before = system.AddMarker(items.MarkerNodePosition(nodeNumber=last))
        ends.append(last)
    return np.delete(solve(system, ends, 1.0, step), [3, 6], axis=1)


def driven(modulus: float, elements: int, step: float) -> np.ndarray:
    """Thesis table 2.2: link 1 up, links 2 and 3 along +x, 5 sin(2 pi t) N m on joint 1; 0.5 s.

    The section's local y, z are flexsim's beam axes (width along y, depth along z).
    """
    system = exu.SystemContainer().AddSystem()
    ground = system.AddObject(items.ObjectGround())
    before = system.AddMarker(items.MarkerBodyRigid(bodyNumber=ground, localPosition=[0, 0, 0]))
    density, poisson, width, depth = 7800.0, 0.33, 0.01, 0.03
    area, iz, iy = width * depth, depth * width**3 / 12, width * depth**3 / 12
    shear = modulus / (2 * (1 + poisson))
    section = exu.BeamSection()
    section.massPerLength = density * area
    section.inertia = np.diag([density * (iy + iz), density * iy, density * iz])
    section.stiffnessMatrix = np.diag(
        [
            modulus * area,
            RECTANGLE_SHEAR * shear * area,
            RECTANGLE_SHEAR * shear * area,
            shear * torsion_constant(width, depth),
            modulus * iy,
            modulus * iz,
        ]
    )
    up = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])  # columns: beam axes of link 1
    along = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    corner, elbow = np.array([0.0, 0.0, 0.5]), np.array([0.5, 0.0, 0.0])
    lines = (
        (np.zeros(3), corner, up),
        (corner, corner + elbow, along),
        (corner + elbow, corner + 2 * elbow, along),
    )
    ends = []
    for n, (start, end, axes) in enumerate(lines):
        nodes = []
        for k in range(elements + 1):
            place = start + (end - start) * k / elements
            nodes.append(
                system.AddNode(
                    items.NodeRigidBodyEP(
                        referenceCoordinates=[*place, *RotationMatrix2EulerParameters(axes)],
                        addConstraintEquation=True,
                    )
                )
            )
        for a, b in pairwise(nodes):
            body = system.AddObject(
                items.ObjectBeamGeometricallyExact(
                    nodeNumbers=[a, b], length=0.5 / elements, sectionData=section
                )
            )
            weight = system.AddMarker(items.MarkerBodyMass(bodyNumber=body))
            system.AddLoad(items.LoadMassProportional(markerNumber=weight, loadVector=[0, 0, -9.81]))
        here = system.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[0]))
        # the joint's axis: base z for the first, base y for the others, as z of the joint's frames
        turn = np.eye(3) if n == 0 else np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]])
        first_axes = np.eye(3) if n == 0 else lines[n - 1][2]
        system.AddObject(
            items.ObjectJointGeneric(
                markerNumbers=[before, here],
                constrainedAxes=[1, 1, 1, 1, 1, 0],
                rotationMarker0=first_axes.T @ turn,
                rotationMarker1=axes.T @ turn,
            )
        )
        if n == 0:

            def torque(mbs, t, load):
                return [0.0, 0.0, 5.0 * np.sin(2 * np.pi * t)]

            system.AddLoad(
                items.Torque(markerNumber=here, loadVector=[0, 0, 0], loadVectorUserFunction=torque)
            )
        before = system.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[-1]))
        ends.append(nodes[-1])
    return solve(system, ends, 0.5, step)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("case", choices=["falling", "falling_shear", "driven"])
    parser.add_argument("--modulus", type=float, default=2e11, help="Pa")
    parser.add_argument("--elements", type=int, default=16, help="of each link")
    parser.add_argument("--step", type=float, default=1e-4, help="s")
    parser.add_argument("--out", type=Path)
    given = parser.parse_args()
    begin = time.perf_counter()
    if given.case == "driven":
        table = driven(given.modulus, given.elements, given.step)
    else:
        table = falling(given.modulus, given.elements, given.step, given.case == "falling_shear")
    print(f"{time.perf_counter() - begin:.1f} s", table[-1], file=sys.stderr)
    if given.out:
        np.savetxt(given.out, table, delimiter=",", fmt="%.8g")


if __name__ == "__main__":
    main()
