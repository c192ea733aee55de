"""flexsim_node: a flexible robot on ROS 2.  Topics, parameters and timing: docs/node.md."""

from __future__ import annotations

import gc
import os
import signal
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from flexsim_msgs.msg import ElasticLayout, ElasticState
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.duration import Duration
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, PointCloud2
from std_msgs.msg import Float64MultiArray, String

from . import conversions
from .commands import CommandRefused, Commands
from .integrators import METHODS
from .realtime import Loop, Output
from .robot_description import robot_description
from .scene import Scene, SceneError, load_scene
from .sensor_messages import SensorMessages
from .settings import SettingError, Settings, meanings, schedule, settings
from .simulation import Simulation

NAME = "flexsim_node"
# rclpy's own, which every node takes.
OF_ROS = ("use_sim_time", "start_type_description_service", "qos_overrides.")
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# Jazzy's EventsExecutor does nothing when it waits without end.
SPIN_PERIOD = 0.1
# s within which a thread that wants Python's lock gets it: the stepping thread has deadlines.
SWITCH_INTERVAL = 2e-4


class FlexsimNode(Node):
    """Connects a stepping loop to its topics; raises SettingError or SceneError."""

    def __init__(self) -> None:
        super().__init__(NAME, automatically_declare_parameters_from_overrides=True)
        self.settings = self._read_parameters()
        self.scene = self._load_scene()
        timing = schedule(self.settings, self.scene.solver.step)
        robot = Simulation(self.scene, timing.step)
        self.commands = Commands(self.scene.joint_names, self.scene.passive_joints)
        messages = conversions.StateMessages(robot)
        # What never changes goes out first: whoever waits for it need not wait for the kernels.
        self._layouts = self.create_publisher(ElasticLayout, "~/elastic_layout", LATCHED)
        self._descriptions = self.create_publisher(String, "robot_description", LATCHED)
        self._layouts.publish(conversions.elastic_layout(robot.model))
        self._descriptions.publish(String(data=robot_description(self.scene)))
        joints = self.create_publisher(JointState, "joint_states", QoSProfile(depth=10))
        elastic = self.create_publisher(ElasticState, "~/elastic_state", QoSProfile(depth=10))
        shape = self.create_publisher(PointCloud2, "~/deformed_shape", QoSProfile(depth=10))
        outputs = [
            *self._sensor_outputs(robot, timing.state),
            output(timing.state, joints, messages.joint_state),
            output(timing.elastic, elastic, messages.elastic_state),
            output(timing.shape, shape, messages.deformed_shape),
        ]
        if self.settings.publish_clock:
            # Last, so that who waits for this time finds the state that belongs to it.
            clock = self.create_publisher(Clock, "/clock", QoSProfile(depth=10))
            outputs.append(output(timing.clock, clock, messages.clock))
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", 10)
        begun = time.monotonic()
        robot.warm()
        self.loop = Loop(
            robot,
            timing.steps,
            self.settings.mode,
            outputs,
            command_timeout=self.settings.command_timeout,
            wait_for_command=self.settings.wait_for_command,
        )
        self._listen()
        steady = RosClock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0, self.publish_diagnostics, clock=steady)
        self._said_stopped = False
        for line in robot.model.decision.sentences() if robot.model.decision else ():
            self.get_logger().info(f"effects: {line}")
        self.get_logger().info(
            f"{self.scene.name}: {robot.model.joints} joints, {robot.model.unknowns} unknowns, "
            f"step {timing.step:g} s, {self.settings.mode}; "
            f"kernels ready in {time.monotonic() - begun:.1f} s"
        )

    def _sensor_outputs(self, robot: Simulation, every: int) -> list[Output]:
        """Publishers of the scene's sensors: before the joint states, for who waits for those."""
        sensors = SensorMessages(robot)
        if not sensors.topics:
            return []
        publishers = {
            name: self.create_publisher(kind, f"~/sensors/{name}", QoSProfile(depth=10))
            for name, kind in sensors.topics.items()
        }

        def publish(time: int) -> None:
            for name, message in sensors.serialized(time).items():
                publishers[name].publish(message)

        return [Output(every, publish)]

    def _read_parameters(self) -> Settings:
        declared: dict[str, Any] = self.get_parameters_by_prefix("")
        given = {name: p.value for name, p in declared.items() if not name.startswith(OF_ROS)}
        found = settings(given)
        for name, (_, meaning) in meanings().items():
            about = ParameterDescriptor(description=meaning)
            if self.has_parameter(name):
                self.undeclare_parameter(name)  # declared as it was given, without its meaning
            self.declare_parameter(name, getattr(found, name), about, ignore_override=True)
        self.add_on_set_parameters_callback(refuse_change)
        return found

    def _load_scene(self) -> Scene:
        scene = load_scene(self.settings.scene, overrides=self.settings.override)
        if scene.solver.method not in METHODS:
            raise SceneError(
                f"{self.settings.scene}: solver.method: is {scene.solver.method!r}, "
                f"whose steps have no fixed cost; give {', '.join(METHODS)}"
            )
        return scene

    def _listen(self) -> None:
        # Best effort hears every publisher, and a late command is of no use; lockstep loses none.
        locked = self.settings.mode == "lockstep"
        reliability = ReliabilityPolicy.RELIABLE if locked else ReliabilityPolicy.BEST_EFFORT
        listening = QoSProfile(depth=1000 if locked else 10, reliability=reliability)
        self.create_subscription(Float64MultiArray, "~/commands", self._on_commands, listening)
        self.create_subscription(JointState, "robot_joint_commands", self._on_joints, listening)

    def _on_commands(self, message: Float64MultiArray) -> None:
        self._take("~/commands", self.commands.in_order, np.frombuffer(message.data))

    def _on_joints(self, message: JointState) -> None:
        names, effort = message.name, np.frombuffer(message.effort)
        self._take("robot_joint_commands", self.commands.by_name, names, effort)

    def _take(self, topic: str, check: Callable[..., np.ndarray], *words: Any) -> None:
        try:
            self.loop.put(check(*words))
        except CommandRefused as refused:
            self.get_logger().warning(
                f"refused a command on {topic} ({self.commands.refused.total()} in all): {refused}",
                throttle_duration_sec=1.0,
            )

    def publish_diagnostics(self, *, last: bool = False) -> None:
        """Say how it goes; the last time wait a moment until it is heard."""
        report = self.loop.report
        message = conversions.diagnostics(
            report, self.commands, self.scene.name, self.settings.mode
        )
        if self.loop.robot.model.decision is not None:
            decision = self.loop.robot.model.decision
            message.status.append(conversions.effects_status(decision, self.scene.name))
        self._diagnostics.publish(message)
        if last:
            self._diagnostics.wait_for_all_acked(Duration(seconds=0.5))
        if report.phase == "stopped" and not self._said_stopped:
            self._said_stopped = True
            self.get_logger().error(
                f"{self.scene.name} stopped at {report.time:.6f} s: {report.status}; "
                "its last good state is published on"
            )


def output(every: int, publisher: Any, serialized: Callable[[int], bytes]) -> Output:
    """Publish what `serialized` gives, every so many ticks."""
    return Output(every, lambda time: publisher.publish(serialized(time)))


def refuse_change(parameters: list[Parameter]) -> SetParametersResult:
    """Say that parameters are read when the node starts."""
    ours = [p.name for p in parameters if not p.name.startswith(OF_ROS)]
    if not ours:
        return SetParametersResult(successful=True)
    return SetParametersResult(
        successful=False, reason=f"{ours[0]} is read when the node starts; start it anew"
    )


def main() -> int:
    """Run the node until SIGINT or SIGTERM.  Returns 0; 1: a bad scene, 2: a bad parameter."""
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    # Until the robot moves, compiling for half a minute perhaps, a signal ends it on the spot.
    handle_signals(signal.default_int_handler)
    node = None
    try:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        node = FlexsimNode()
        return run(node)
    except KeyboardInterrupt:
        return 0
    except (SceneError, SettingError) as problem:
        print(f"{NAME}: {problem}", file=sys.stderr)
        return 1 if isinstance(problem, SceneError) else 2
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()


def handle_signals(handler: Callable[[int, Any], Any]) -> None:
    """Give SIGINT and SIGTERM to `handler`."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, handler)


def run(node: FlexsimNode) -> int:
    """Step and spin until a signal comes.  Returns the exit code."""
    asked: list[int] = []
    handle_signals(lambda number, _: asked.append(number))
    executor = EventsExecutor()
    executor.add_node(node)
    sys.setswitchinterval(SWITCH_INTERVAL)
    # All that lives now lives to the end: the collector need not visit it, which would take tens of
    # milliseconds.
    gc.collect()
    gc.freeze()
    node.loop.start()
    try:
        while not asked and not node.loop.ended.is_set():
            executor.spin_once(timeout_sec=SPIN_PERIOD)
    finally:
        node.loop.stop()
        node.publish_diagnostics(last=True)
        executor.shutdown()
    if node.loop.failure is not None:
        print(f"{NAME}: the stepping thread failed: {node.loop.failure!r}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
