"""The reference of config/slider_crank.yaml: its elastic rod as ANCF cables in Exudyn (PyPI: exudyn).

    python benchmarks/peers/exudyn_slider_crank.py tests/robot/data/slider_crank_steel.csv

The crank turns at 150 rad/s from its dead centre; the rod begins with the rigid mechanism's motion.
"""

from __future__ import annotations

import sys
from itertools import pairwise

import numpy as np

CRANK, ROD, SPEED = 0.15, 0.3, 150.0
AREA, SECOND_MOMENT, DENSITY, YOUNG, SLIDER = 2.82743e-5, 6.36173e-11, 7870.0, 2e11, 0.033375
PERIOD, DURATION = 2.5e-4, 0.05


def motion(elements: int, step: float) -> np.ndarray:
    """(K, 4) time, the rod's middle (x, y) and the slider's x."""
    import exudyn as exu
    import exudyn.itemInterface as item

    system = exu.SystemContainer()
    mbs = system.AddSystem()
    swing = -SPEED * CRANK / ROD
    nodes = [
        mbs.AddNode(
            item.Point2DS1(
                referenceCoordinates=[CRANK + s, 0.0, 1.0, 0.0],
                initialVelocities=[0.0, SPEED * CRANK + swing * s, 0.0, swing],
            )
        )
        for s in np.linspace(0.0, ROD, elements + 1)
    ]
    for pair in pairwise(nodes):
        mbs.AddObject(
            item.Cable2D(
                physicsLength=ROD / elements,
                physicsMassPerLength=DENSITY * AREA,
                physicsBendingStiffness=YOUNG * SECOND_MOMENT,
                physicsAxialStiffness=YOUNG * AREA,
                nodeNumbers=list(pair),
            )
        )
    base = mbs.AddNode(item.NodePointGround(referenceCoordinates=[0.0, 0.0, 0.0]))

    def coordinate(node: int, axis: int):
        return mbs.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=axis))

    ground = coordinate(base, 0)
    crank = (
        (lambda _m, t, _i, _l: CRANK * (np.cos(SPEED * t) - 1.0),
         lambda _m, t, _i, _l: -CRANK * SPEED * np.sin(SPEED * t)),
        (lambda _m, t, _i, _l: CRANK * np.sin(SPEED * t),
         lambda _m, t, _i, _l: CRANK * SPEED * np.cos(SPEED * t)),
    )  # fmt: skip
    for axis, (place, rate) in enumerate(crank):
        mbs.AddObject(
            item.CoordinateConstraint(
                markerNumbers=[ground, coordinate(nodes[0], axis)],
                offset=0.0,
                offsetUserFunction=place,
                offsetUserFunction_t=rate,
            )
        )
    slider = mbs.AddNode(item.NodePoint2D(referenceCoordinates=[CRANK + ROD, 0.0]))
    mbs.AddObject(item.MassPoint2D(physicsMass=SLIDER, nodeNumber=slider))
    for pair in (
        [ground, coordinate(nodes[-1], 1)],
        [coordinate(nodes[-1], 0), coordinate(slider, 0)],
        [ground, coordinate(slider, 1)],
    ):
        mbs.AddObject(item.CoordinateConstraint(markerNumbers=pair))
    place = exu.OutputVariableType.Position
    seen = [
        mbs.AddSensor(item.SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=place))
        for node in (nodes[elements // 2], nodes[-1])
    ]
    mbs.Assemble()
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = DURATION
    settings.timeIntegration.numberOfSteps = round(DURATION / step)
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    settings.solutionSettings.sensorsWritePeriod = PERIOD
    settings.solutionSettings.writeSolutionToFile = False
    mbs.SolveDynamic(settings)
    middle, end = (mbs.GetSensorStoredData(sensor) for sensor in seen)
    return np.column_stack([middle[:, :3], end[:, 1]])


if __name__ == "__main__":
    fine = motion(16, 5e-6)
    apart = np.max(np.abs(motion(8, 1e-5) - fine), axis=0)
    print(f"8 elements and twice the step: {apart[0]:.1e} s, {apart[1:].max():.1e} m apart")
    np.savetxt(sys.argv[1], fine, "%.9g", ",", header="t,middle_x,middle_y,slider_x", comments="")
