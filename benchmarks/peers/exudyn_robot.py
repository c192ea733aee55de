"""The robots in Exudyn (PyPI: exudyn): planar ANCF cables, and geometrically exact beams in space."""

from __future__ import annotations

import time
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .problem import YOUNG, Problem

SHEAR = 5.0 / 6.0


@dataclass(frozen=True)
class Attempt:
    """What one way came to: s for a simulated second, and the tip (K, 3)."""

    seconds: list[float]
    tip: np.ndarray


def planar_ancf(problem: Problem, elements: int, step: float, repeats: int) -> Attempt:
    """ANCF cables in the plane, generalized-alpha with a modified Newton iteration."""
    import exudyn as exu
    import exudyn.itemInterface as item
    from exudyn.beams import GenerateStraightLineANCFCable2D

    seconds, tip = [], np.zeros((0, 3))
    for _ in range(repeats):
        system = exu.SystemContainer()
        mbs = system.AddSystem()
        start, last = np.zeros(3), None
        for link in problem.links:
            end = start + link.length * np.array(link.direction, dtype=float)
            cable = item.ObjectANCFCable2D(
                physicsMassPerLength=problem.density * link.area,
                physicsBendingStiffness=YOUNG * link.bending[2],
                physicsAxialStiffness=YOUNG * link.area,
            )
            nodes = GenerateStraightLineANCFCable2D(
                mbs, list(start), list(end), elements, cable,
                massProportionalLoad=list(problem.gravity),
                fixedConstraintsNode0=[1, 1, 0, 0] if last is None else [0, 0, 0, 0],
                fixedConstraintsNode1=[0, 0, 0, 0],
            )[0]  # fmt: skip
            if last is not None:
                a = mbs.AddMarker(item.MarkerNodePosition(nodeNumber=last))
                b = mbs.AddMarker(item.MarkerNodePosition(nodeNumber=nodes[0]))
                mbs.AddObject(item.ObjectJointRevolute2D(markerNumbers=[a, b]))
            start, last = end, nodes[-1]
        seconds, tip = solved(exu, mbs, problem, _position(exu, item, last), step, seconds)
    return Attempt(seconds, tip)


def spatial_exact(problem: Problem, elements: int, step: float, repeats: int) -> Attempt:
    """Geometrically exact beams with two nodes an element, revolute joints, generalized-alpha."""
    import exudyn as exu
    import exudyn.itemInterface as item

    seconds, tip = [], np.zeros((0, 3))
    shear_modulus = YOUNG / (2.0 * (1.0 + problem.poisson))
    e_z = np.array(problem.axes[-1], dtype=float)
    for _ in range(repeats):
        system = exu.SystemContainer()
        mbs = system.AddSystem()
        ground = mbs.AddObject(item.ObjectGround())
        start, last = np.zeros(3), None
        for number, link in enumerate(problem.links):
            e_x = np.array(link.direction, dtype=float)
            rotation = np.column_stack([e_x, np.cross(e_z, e_x), e_z])
            torsion, second_y, second_z = link.bending
            section = exu.BeamSection()
            section.stiffnessMatrix = np.diag(
                [
                    YOUNG * link.area,
                    SHEAR * shear_modulus * link.area,
                    SHEAR * shear_modulus * link.area,
                    shear_modulus * torsion,
                    YOUNG * second_y,
                    YOUNG * second_z,
                ]
            )
            section.inertia = problem.density * np.diag([second_y + second_z, second_y, second_z])
            section.massPerLength = problem.density * link.area
            length = link.length / elements
            nodes = [
                mbs.AddNode(
                    item.NodeRigidBodyEP(
                        referenceCoordinates=[
                            *(start + k * length * e_x),
                            *_euler_parameters(rotation),
                        ]
                    )
                )
                for k in range(elements + 1)
            ]
            for a, b in pairwise(nodes):
                beam = mbs.AddObject(
                    item.ObjectBeamGeometricallyExact(
                        nodeNumbers=[a, b], physicsLength=length, sectionData=section
                    )
                )
                marker = mbs.AddMarker(item.MarkerBodyMass(bodyNumber=beam))
                mbs.AddLoad(item.LoadMassProportional(markerNumber=marker, loadVector=list(problem.gravity)))
            axis = np.array(problem.axes[number], dtype=float)
            side = np.eye(3)[int(np.argmin(np.abs(axis)))]
            frame = np.column_stack([np.cross(axis, side), np.cross(axis, np.cross(axis, side)), axis])
            here = mbs.AddMarker(item.MarkerNodeRigid(nodeNumber=nodes[0]))
            if last is None:
                before = mbs.AddMarker(item.MarkerBodyRigid(bodyNumber=ground, localPosition=list(start)))
                turned = np.eye(3)
            else:
                before = mbs.AddMarker(item.MarkerNodeRigid(nodeNumber=last[0]))
                turned = last[1]
            mbs.AddObject(
                item.ObjectJointGeneric(
                    markerNumbers=[before, here],
                    constrainedAxes=[1, 1, 1, 1, 1, 0],
                    rotationMarker0=turned.T @ frame,
                    rotationMarker1=rotation.T @ frame,
                )
            )
            if number == 0 and problem.torque:
                load = mbs.AddLoad(item.LoadTorqueVector(markerNumber=here, loadVector=[0.0, 0.0, 0.0]))

                def drive(system, t, load=load):
                    value = problem.torque * np.sin(2.0 * np.pi * t)
                    system.SetLoadParameter(load, "loadVector", [0.0, 0.0, value])
                    return True

                mbs.SetPreStepUserFunction(drive)
            start, last = start + link.length * e_x, (nodes[-1], rotation)
        seconds, tip = solved(exu, mbs, problem, _position(exu, item, last[0]), step, seconds)
    return Attempt(seconds, tip)


def _position(exu, item, node):
    """A sensor of a node's position."""
    return item.SensorNode(
        nodeNumber=node, storeInternal=True, outputVariableType=exu.OutputVariableType.Position
    )


def solved(exu, mbs, problem, tip_sensor, step, seconds):
    """Run it with a modified Newton iteration, Exudyn's faster one; a run that fails has no tip."""
    sensor = mbs.AddSensor(tip_sensor)
    mbs.Assemble()
    settings = exu.SimulationSettings()
    integration = settings.timeIntegration
    integration.numberOfSteps = round(problem.duration / step)
    integration.endTime = problem.duration
    integration.generalizedAlpha.spectralRadius = 0.8
    integration.newton.useModifiedNewton = True
    integration.verboseMode = 0
    settings.solutionSettings.writeSolutionToFile = False
    settings.solutionSettings.sensorsWritePeriod = problem.period
    settings.displayComputationTime = False
    begun = time.process_time()
    try:
        done = mbs.SolveDynamic(settings, showHints=False)
    except exu.SolverError:
        done = False
    took = time.process_time() - begun
    data = mbs.GetSensorStoredData(sensor)
    count = len(problem.reference)
    if done is False or len(data) < count:
        return seconds, np.full((count, 3), np.nan)
    rows = [int(np.argmin(np.abs(data[:, 0] - t))) for t in problem.reference[:, 0]]
    return [*seconds, took / problem.duration], data[rows, 1:4]


def _euler_parameters(rotation: np.ndarray) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return np.array([w, x, y, z])
