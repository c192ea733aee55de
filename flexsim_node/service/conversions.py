"""From a simulation to ROS messages.

Messages whose size never changes are serialized once, when the node starts; afterwards only their
numbers are written into the bytes.  That is several times cheaper than building and serializing a
message a thousand times a second, and the bytes are the same.
"""

from __future__ import annotations

import array
import struct
from collections.abc import Sequence
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from flexsim_msgs.msg import ElasticLayout, ElasticState
from flexsim_ros import Entity
from flexsim_ros.entities import ROBOT, quaternion
from geometry_msgs.msg import Point, Quaternion, Vector3
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, PointCloud2, PointField
from simulation_interfaces.msg import EntityState

from ..model.model import Model
from ..motion.decision import Chosen, Decision
from ..motion.link_motion import LinkMotion
from ..motion.simulation import Simulation
from ..scene.load import Scene
from ..scene.schema import BASE
from .commands import Commands
from .pace import SECOND
from .report import Report
from .robot_description import equivalent_rectangle

STAMP = 4  # behind the encapsulation header; every message here begins with its time
COORDINATES = ("x", "y", "z", "ux", "uy", "uz", "rx", "ry", "rz")
POINT = np.dtype([(name, "<f4") for name in COORDINATES] + [("link", "<u4")])


def stamp(time: int) -> Time:
    """Simulated time, ns, as a message.

    Zero means "no time" to ROS, so the initial state bears 1 ns.
    """
    sec, nanosec = divmod(max(1, time), SECOND)
    return Time(sec=sec, nanosec=nanosec)


class Template:
    """A serialized message whose time and arrays of fixed length are written in place.

    Parameters
    ----------
    message : a ROS message that begins with a Header or a Time
    arrays : field name to an array of the type and length that the field has on the wire
    """

    def __init__(self, message: Any, arrays: dict[str, np.ndarray]) -> None:
        random = np.random.default_rng(0)
        marks = {}
        for name, like in arrays.items():
            marks[name] = random.bytes(like.nbytes)  # found again below: where the field lies in the bytes
            code = "d" if like.dtype == np.float64 else "B"
            setattr(message, name, array.array(code, marks[name]))
        self._bytes = bytearray(serialize_message(message))
        self._views = {}
        for name, like in arrays.items():
            at = self._bytes.find(marks[name])
            view = np.frombuffer(self._bytes, like.dtype, like.size, at) if like.size else like.ravel()
            self._views[name] = view.reshape(like.shape)

    def write(self, time: int, **values: np.ndarray) -> bytes:
        """Return the message with these values, at simulated time `time`, ns."""
        sec, nanosec = divmod(max(1, time), SECOND)
        struct.pack_into("<iI", self._bytes, STAMP, sec, nanosec)
        for name, value in values.items():
            self._views[name][...] = value
        return bytes(self._bytes)


class StateMessages:
    """The messages of a simulation's state; used by the stepping thread alone."""

    def __init__(self, robot: Simulation) -> None:
        self.robot = robot
        model = robot.model
        nodes = len(model.node_link)
        joints = JointState(name=list(robot.scene.joint_names))
        joints.header.frame_id = BASE
        m = np.zeros(model.joints)
        self._joints = Template(joints, {"position": m, "velocity": m, "effort": m})
        self._elastic_arrays = {
            "displacement": np.zeros((nodes, 6)),
            "position": np.zeros((nodes, 3)),
            "rigid_position": np.zeros((nodes, 3)),
        }
        self._status = ""
        self._elastic = self._elastic_template()
        cloud = PointCloud2(height=1, width=nodes, point_step=POINT.itemsize)
        cloud.header.frame_id = BASE
        cloud.row_step = nodes * POINT.itemsize
        cloud.is_dense = True
        cloud.fields = [
            PointField(name=name, offset=4 * n, datatype=PointField.FLOAT32, count=1)
            for n, name in enumerate(COORDINATES)
        ]
        link = 4 * len(COORDINATES)
        cloud.fields.append(PointField(name="link", offset=link, datatype=PointField.UINT32, count=1))
        self._points = np.zeros(nodes, POINT)
        self._points["link"] = model.node_link
        self._coordinates = self._points.view("<f4").reshape(nodes, -1)
        self._cloud = Template(cloud, {"data": self._points.view(np.uint8)})
        self._clock = Template(Clock(clock=Time()), {})

    def joint_state(self, time: int) -> bytes:
        """Return sensor_msgs/JointState; effort is the torque that led to this state."""
        return self._joints.write(
            time,
            position=self.robot.joint_position(),
            velocity=self.robot.joint_velocity(),
            effort=self.robot.joint_effort(),
        )

    def elastic_state(self, time: int) -> bytes:
        """Return flexsim_msgs/ElasticState."""
        if self.robot.reason != self._status:
            self._elastic = self._elastic_template()
        view = self.robot.look()
        return self._elastic.write(
            time,
            displacement=view.displacement,
            position=view.position,
            rigid_position=view.rigid_position,
        )

    def deformed_shape(self, time: int) -> bytes:
        """Return sensor_msgs/PointCloud2, a point a node."""
        view = self.robot.look()
        self._coordinates[:, :3] = view.position
        self._coordinates[:, 3:9] = view.displacement
        return self._cloud.write(time, data=self._points.view(np.uint8))

    def clock(self, time: int) -> bytes:
        """Return rosgraph_msgs/Clock."""
        return self._clock.write(time)

    def _elastic_template(self) -> Template:
        """Serialize an ElasticState anew: the status in words changes its length, seldom."""
        self._status = self.robot.reason
        message = ElasticState(status=self._status)
        message.header.frame_id = BASE
        return Template(message, self._elastic_arrays)


def elastic_layout(model: Model) -> ElasticLayout:
    """Return what the numbers of ElasticState belong to."""
    message = ElasticLayout()
    message.header.stamp = stamp(0)
    message.header.frame_id = BASE
    message.link_names = [link.name for link in model.scene.links]
    message.node_names = list(model.node_names)
    message.node_link = [int(n) for n in model.node_link]
    for n, link in enumerate(model.scene.links):
        first, last = int(model.first_node[n]), int(model.first_node[n + 1]) - 1
        width, depth = equivalent_rectangle(link.beam) if link.beam else (0.0, 0.0)
        for i in range(first, last):
            message.segments.extend((i, i + 1))
            message.segment_width.append(width)
            message.segment_depth.append(depth)
    return message


def entities(scene: Scene) -> list[Entity]:
    """Return the robot and its links."""
    robot = Entity(scene.name, ROBOT, f"flexible robot with {len(scene.joint_names)} joints", ("robot",))
    links = []
    for link in scene.links:
        kind = "flexible" if link.beam and link.flexible else "rigid"
        about = f"{kind} link; its state is that of its end"
        links.append(Entity(f"{scene.name}/{link.name}", ROBOT, about, ("link", kind)))
    return [robot, *links]


def entity_states(scene: Scene, motion: LinkMotion, time: int) -> dict[str, EntityState]:
    """Return where the base and the links' ends are in the world, which is the base's frame."""
    base = EntityState()
    base.header.stamp = stamp(time)
    found = {scene.name: base}
    for n, link in enumerate(scene.links):
        state = found[f"{scene.name}/{link.name}"] = EntityState()
        state.header.stamp = stamp(time)
        state.pose.position = Point(**_xyz(motion.position[n]))
        x, y, z, w = quaternion(motion.rotation[n].tolist())
        state.pose.orientation = Quaternion(x=x, y=y, z=z, w=w)
        state.twist.linear = Vector3(**_xyz(motion.velocity[n]))
        state.twist.angular = Vector3(**_xyz(motion.angular_velocity[n]))
        state.acceleration.linear = Vector3(**_xyz(motion.acceleration[n]))
        state.acceleration.angular = Vector3(**_xyz(motion.angular_acceleration[n]))
    return found


def _xyz(vector: np.ndarray) -> dict[str, float]:
    return dict(zip("xyz", vector.tolist(), strict=True))


def diagnostics(
    report: Report,
    commands: Commands,
    scene_name: str,
    mode: str,
    troubles: int = 0,
    commanders: Sequence[str] = (),
) -> DiagnosticArray:
    """Return how the node does: its real time, its commands, its solver.

    commanders : who publishes commands, where it is more than one
    """
    message = DiagnosticArray()
    message.header.stamp = stamp(round(report.time * SECOND))
    late = report.recent_overruns > 0
    refused = commands.refused.total()
    stopped = report.phase == "stopped"
    ok, warn, error = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
    worst = max((f.passed for f in report.validity), key=("", "warn", "stop").index, default="")
    message.status = [
        _status(
            "real time",
            warn if late else ok,
            f"{report.recent_overruns} overruns in the last second" if late else f"{mode}, {report.phase}",
            scene_name,
            {
                "mode": mode,
                "phase": report.phase,
                "simulated time, s": f"{report.time:.6f}",
                "real-time factor": f"{report.real_time_factor:.6f}",
                "real-time factor, last second": f"{report.recent_factor:.6f}",
                "ticks": report.ticks,
                "overruns": report.overruns,
                "overruns in a row, worst": report.longest_run,
                "lost time, s": f"{report.lost:.6f}",
                "real-time priority": "yes" if report.real_time_priority else "no",
                **_microseconds("step time", report.step_p50, report.step_p99, report.step_worst),
                **_microseconds("tick time", None, report.tick_p99, report.tick_worst),
                **_microseconds("lateness", None, report.late_p99, report.late_worst),
            },
        ),
        _status(
            "commands",
            warn if refused or report.timeouts or troubles or commanders else ok,
            f"several publish commands: {', '.join(commanders)}"
            if commanders
            else f"{refused} refused of {commands.accepted + refused}",
            scene_name,
            {
                "accepted": commands.accepted,
                "refused": refused,
                **{f"refused, {reason}": count for reason, count in commands.refused.items()},
                "timeouts": report.timeouts,
                "not a message": troubles,
            },
        ),
        _status(
            "solver",
            error if stopped else warn if report.warning else ok,
            f"stopped at {report.time:.6f} s: {report.status}"
            if stopped
            else report.warning or report.status,
            scene_name,
            {
                "status": report.status,
                **({} if report.conditioning is None else {"conditioning": f"{report.conditioning:.6f}"}),
                "kinetic energy, J": f"{report.energy[0]:.9g}",
                "elastic energy, J": f"{report.energy[1]:.9g}",
                "gravitational energy, J": f"{report.energy[2]:.9g}",
            },
        ),
        _status(
            "validity",
            {"stop": error, "warn": warn, "": ok}[worst],
            " ".join(f.sentence() for f in report.validity if f.passed) or "within its limits",
            scene_name,
            {
                **{f.name: f"{f.value:.6g}" for f in report.validity},
                **{f"{f.name}, limits": f"{f.warn:g}, {f.stop:g}" for f in report.validity},
            },
        ),
    ]
    return message


def effects_status(decision: Decision, scene_name: str) -> DiagnosticStatus:
    """Return what the scene left open: the formulation taken, what each effect changes, which are off."""
    values = {c.name: f"{'off' if c.name in decision.left_out else 'on'}, {c.change:.3g} m without it"
              for c in decision.changes}  # fmt: skip
    values["tolerance, m"] = f"{decision.tolerance:g}"
    values["left out together, m"] = f"{decision.together:.3g}"
    if decision.chosen is not None:
        values["formulation"] = decision.scene.formulation
        values["erls from co_moving, m"] = erls_said(decision.chosen)
    return _status("effects", DiagnosticStatus.OK, decision.summary(), scene_name, values)


def erls_said(chosen: Chosen) -> str:
    """Return how far the ERLS is from co-moving frames at most, over the envelope, m."""
    apart = chosen.apart
    if apart is None or apart.refused:
        return "not measured" if apart is None else f"not known: {apart.refused}"
    return f"{apart.distance:.3g} +- {apart.unsure:.3g}"


def _microseconds(name: str, p50: float | None, p99: float, worst: float) -> dict[str, str]:
    numbers = {"p50": p50, "p99": p99, "worst": worst}
    return {f"{name} {k}, µs": f"{1e6 * v:.1f}" for k, v in numbers.items() if v is not None}


def _status(task: str, level: bytes, message: str, hardware: str, values: dict[str, Any]) -> DiagnosticStatus:
    return DiagnosticStatus(
        level=level,
        name=task,
        message=message,
        hardware_id=hardware,
        values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
    )
