"""From a door under test to ROS messages."""

from __future__ import annotations

import array
from collections.abc import Sequence
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from flexsim_msgs.msg import (
    FireCriteria,
    LeafDeflection,
    LeafMesh,
    Reactions,
    TemperatureField,
    Thermocouples,
)
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image, PointCloud2, PointField, Temperature
from std_msgs.msg import Header

from .background_deformation import Bent
from .fire_test import FireTest
from .realtime import SECOND, Report

LEAF = "leaf"
"""Frame of the leaf: its centre on the exposed face, x across, y up, z to the unexposed face."""
FURNACE = "furnace"
POINT = ("x", "y", "z", "temperature")


def stamp(time: int) -> Time:
    """Simulated time, ns, as a message.

    Zero means "no time" to ROS, so the initial state bears 1 ns.
    """
    sec, nanosec = divmod(max(1, time), SECOND)
    return Time(sec=sec, nanosec=nanosec)


def header(time: int, frame: str = LEAF) -> Header:
    """Return a header."""
    return Header(stamp=stamp(time), frame_id=frame)


def doubles(values: Any) -> array.array[float]:
    """Return numbers as a message takes them fastest."""
    return array.array("d", np.ascontiguousarray(values, dtype=np.float64).tobytes())


def clock(time: int) -> Clock:
    """Return the simulated time."""
    return Clock(clock=stamp(time))


def furnace_temperature(test: FireTest, time: int) -> Temperature:
    """Return the furnace's gas, °C."""
    return Temperature(header=header(time, FURNACE), temperature=test.furnace)


def leaf_mesh(test: FireTest) -> LeafMesh:
    """Return what the numbers of the fields belong to."""
    whole = test.whole
    return LeafMesh(
        header=header(0),
        nodes=doubles(whole.nodes),
        hexahedra=array.array("I", whole.hexahedra.astype(np.uint32).tobytes()),
        layer=array.array("I", whole.layer.astype(np.uint32).tobytes()),
        layer_names=[layer.material for layer in test.scene.leaf.layers],
    )


def temperature_field(test: FireTest, time: int) -> TemperatureField:
    """Return the temperature of every node."""
    return TemperatureField(header=header(time), temperature=doubles(test.temperature))


def temperature_points(test: FireTest, time: int) -> PointCloud2:
    """Return the temperature of every node, with its place."""
    nodes = test.whole.nodes
    points = np.column_stack([nodes, test.temperature]).astype("<f4")
    size = points.strides[0]
    return PointCloud2(
        header=header(time),
        height=1,
        width=len(points),
        fields=[
            PointField(name=name, offset=4 * n, datatype=PointField.FLOAT32, count=1)
            for n, name in enumerate(POINT)
        ],
        point_step=size,
        row_step=size * len(points),
        is_dense=True,
        data=array.array("B", points.tobytes()),
    )


def thermocouples(test: FireTest, time: int) -> Thermocouples:
    """Return the readings of all probes."""
    x, y, z = test.probes.position.T
    return Thermocouples(
        header=header(time),
        name=list(test.probes.name),
        temperature=doubles(test.readings),
        x=doubles(x),
        y=doubles(y),
        z=doubles(z),
    )


def reactions(test: FireTest, time: int) -> Reactions:
    """Return how far the materials have reacted."""
    return Reactions(
        header=header(time),
        material=[material for material, _ in test.reacted.name],
        reaction=[reaction for _, reaction in test.reacted.name],
        degree=doubles(test.reactions),
    )


def unexposed_image(test: FireTest, time: int) -> Image:
    """Return the unexposed face as a camera before it sees it, °C: row 0 on top (+y), column 0 at -x."""
    pixels = test.infrared.image(test.heat.temperature)
    return Image(
        header=header(time),
        height=pixels.shape[0],
        width=pixels.shape[1],
        encoding="32FC1",
        step=4 * pixels.shape[1],
        data=array.array("B", pixels.astype("<f4").tobytes()),
    )


def leaf_deflection(bent: Bent) -> LeafDeflection:
    """Return how the leaf is bent."""
    shape = bent.deflection
    return LeafDeflection(
        header=header(bent.stamp),
        displacement=doubles(bent.whole),
        bow=shape.bow,
        edge_name=list(shape.edge_gap),
        edge_gap=doubles(list(shape.edge_gap.values())),
    )


def fire_criteria(test: FireTest, time: int) -> FireCriteria:
    """Return how the door stands."""
    each = test.criteria.each
    return FireCriteria(
        header=header(time),
        criterion=[c.name for c in each],
        value=doubles([c.value for c in each]),
        limit=doubles([c.limit for c in each]),
        failed=[c.failed for c in each],
        time_of_failure=doubles([-1.0 if c.time_of_failure is None else c.time_of_failure for c in each]),
        verdict=test.criteria.verdict("" if test.status.ok else test.status.reason),
    )


def diagnostics(
    report: Report,
    scene: str,
    time_scale: str,
    timeout: float,
    troubles: int = 0,
    furnaces: Sequence[str] = (),
) -> DiagnosticArray:
    """Return how the node does: its pace, its furnace, its solver, its deformation.

    furnaces : who publishes measured temperatures, where it is more than one
    """
    ok, warn, error = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
    refused = report.refused.total()
    stale = report.measured and report.stale > timeout and report.phase == "running"
    if stale:
        furnace_says = f"no measured temperature for {report.stale:.0f} s; the last one holds"
    elif furnaces:
        furnace_says = f"{len(furnaces)} measure the furnace: {', '.join(furnaces)}"
    elif report.tolerance:
        furnace_says = report.tolerance
    elif refused:
        furnace_says = f"{refused} measured temperatures refused"
    else:
        furnace_says = "measured" if report.measured else "the scene's"
    status = [
        _status(
            "pace",
            warn if report.lost > 0.0 else ok,
            f"{report.lost:.1f} s behind" if report.lost > 0.0 else report.phase,
            scene,
            {
                "phase": report.phase,
                "simulated time, s": f"{report.time:.6f}",
                "exposure, s": f"{report.exposure:.6f}",
                "time scale": time_scale,
                "simulated over elapsed time": f"{report.factor:.3f}",
                "ticks": report.ticks,
                "overruns": report.overruns,
                "lost time, s": f"{report.lost:.3f}",
                "longest tick, ms": f"{1e3 * report.tick_worst:.1f}",
            },
        ),
        _status(
            "furnace",
            warn if stale or report.tolerance or refused or troubles or furnaces else ok,
            furnace_says,
            scene,
            {
                "source": "measured" if report.measured else "scene",
                "temperature, °C": f"{report.furnace:.3f}",
                "since the last measured, s": f"{report.stale:.3f}",
                "accepted": report.accepted,
                "refused": refused,
                **{f"refused, {reason}": n for reason, n in report.refused.items()},
                "not a message": troubles,
            },
        ),
        _status(
            "solver",
            error if report.phase == "stopped" else ok,
            report.status,
            scene,
            {
                "status": report.status,
                "verdict": report.verdict,
                "steps": report.steps,
                "rejected steps": report.rejected_steps,
                "went on after a stop": report.resumed,
                "largest imbalance of a step": f"{report.imbalance:.2e}",
            },
        ),
        _status(
            "deformation",
            error if report.deformation_failure else ok,
            report.deformation_failure or f"{report.deflections} solved",
            scene,
            {"solved": report.deflections, "skipped": report.deflections_skipped},
        ),
    ]
    return DiagnosticArray(header=Header(stamp=stamp(round(report.time * SECOND))), status=status)


def _status(task: str, level: bytes, message: str, hardware: str, values: dict[str, Any]) -> DiagnosticStatus:
    return DiagnosticStatus(
        level=level,
        name=task,
        message=message,
        hardware_id=hardware,
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
    )
