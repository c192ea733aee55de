"""thermal_node: a fire door in its furnace on ROS 2.  Topics, parameters: docs/thermal_node.md."""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from flexsim_msgs.msg import (
    FireCriteria,
    LeafDeflection,
    LeafMesh,
    TemperatureField,
    Thermocouples,
)
from rcl_interfaces.msg import ParameterDescriptor, SetParametersResult
from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.signals import SignalHandlerOptions
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image, PointCloud2, Temperature

from . import conversions
from .background_deformation import BackgroundDeformation
from .fire_test import FireTest
from .realtime import Loop, Output
from .scene import Scene, SceneError, load_scene
from .settings import SettingError, Settings, meanings, settings

NAME = "thermal_node"
# rclpy's own, which every node takes.
OF_ROS = ("use_sim_time", "start_type_description_service", "qos_overrides.")
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
QUEUE = QoSProfile(depth=10)
SPIN_PERIOD = 0.1


class ThermalNode(Node):
    """Connects a marching loop to its topics; raises SettingError or SceneError."""

    def __init__(self) -> None:
        super().__init__(NAME, automatically_declare_parameters_from_overrides=True)
        given = self.settings = self._read_parameters()
        scene = load_burning(given)
        begun = time.monotonic()
        self.test = FireTest(scene)
        bends = given.deflection_period > 0.0 and scene.deformation.model != "none"
        deformation = BackgroundDeformation(self.test.model) if bends else None
        # What never changes goes out first: whoever waits for it need not wait for the kernels.
        self._mesh = self.create_publisher(LeafMesh, "door/mesh", LATCHED)
        self._mesh.publish(conversions.leaf_mesh(self.test))
        outputs = [
            self._output(Temperature, "furnace/temperature", conversions.furnace_temperature),
            self._output(Thermocouples, "door/thermocouples", conversions.thermocouples),
            self._output(FireCriteria, "door/criteria", conversions.fire_criteria),
            *(
                self._output(kind, topic, convert, given.field_every)
                for kind, topic, convert in (
                    (TemperatureField, "door/temperature_field", conversions.temperature_field),
                    (PointCloud2, "door/temperature_points", conversions.temperature_points),
                    (Image, "door/unexposed/image", conversions.unexposed_image),
                )
            ),
        ]
        if given.publish_clock:
            # Last, so that who waits for this time finds the state that belongs to it.
            outputs.append(self._output(Clock, "/clock", lambda _, time: conversions.clock(time)))
        deflections = self.create_publisher(LeafDeflection, "door/deflection", QUEUE)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", QUEUE)
        self.test.warm()
        self.loop = Loop(
            self.test,
            given.rate,
            given.pace,
            outputs,
            duration=given.duration,
            wait_for_furnace=given.wait_for_furnace,
            deformation=deformation,
            deflection_period=given.deflection_period,
            bent=lambda bent: deflections.publish(conversions.leaf_deflection(bent)),
        )
        hearing = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
        self.create_subscription(
            Temperature, "furnace/measured_temperature", self._on_measured, hearing
        )
        steady = RosClock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0, self.publish_diagnostics, clock=steady)
        self._said = ""
        pace = "as fast as it goes" if given.pace == float("inf") else f"{given.pace:g} x real time"
        self._pace = pace
        self.get_logger().info(
            f"{scene.name}: {scene.solver.model}, {len(self.test.model.nodes)} unknowns, {pace}; "
            f"kernels ready in {time.monotonic() - begun:.1f} s"
        )

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

    def _output(
        self,
        kind: type,
        topic: str,
        convert: Callable[[FireTest, int], Any],
        every: int = 1,
    ) -> Output:
        publisher = self.create_publisher(kind, topic, QUEUE)
        return Output(every, lambda time: publisher.publish(convert(self.test, time)))

    def _on_measured(self, message: Temperature) -> None:
        reason = self.loop.measure(message.temperature)
        if reason:
            count = self.loop.report.refused.total()
            self.get_logger().warning(
                f"refused a measured temperature, {message.temperature:g}: {reason}; give degrees"
                f" Celsius ({count} refused before)",
                throttle_duration_sec=1.0,
            )

    def publish_diagnostics(self, *, last: bool = False) -> None:
        """Say how it goes; the last time wait a moment until it is heard."""
        report = self.loop.report
        name, timeout = self.test.scene.name, self.settings.furnace_timeout
        self._diagnostics.publish(conversions.diagnostics(report, name, self._pace, timeout))
        if last:
            self._diagnostics.wait_for_all_acked(Duration(seconds=0.5))
        if report.measured and report.stale > timeout and report.phase == "running":
            self.get_logger().warning(
                f"no measured furnace temperature for {report.stale:.0f} s; the last one,"
                f" {report.furnace:.1f} degrees Celsius, holds",
                throttle_duration_sec=10.0,
            )
        if report.phase != self._said:
            self._said = report.phase
            if report.phase == "stopped":
                self.get_logger().error(
                    f"{name} {report.status}; its last good state is published on"
                )
            elif report.phase == "ended":
                self.get_logger().info(f"{name} ended at {report.exposure:g} s: {report.verdict}")


def load_burning(given: Settings) -> Scene:
    """Load a scene that goes through time; raises SceneError."""
    scene = load_scene(given.scene, overrides=given.override)
    if scene.solver.model == "steady":
        raise SceneError(
            f"{given.scene}: solver.model: is 'steady', which has no time to go through;"
            " give full, column_rim or column"
        )
    return scene


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
    # Until the fire begins, compiling for half a minute perhaps, a signal ends it on the spot.
    handle_signals(signal.default_int_handler)
    node = None
    try:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        node = ThermalNode()
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


def run(node: ThermalNode) -> int:
    """March and spin until a signal comes.  Returns the exit code."""
    asked: list[int] = []
    handle_signals(lambda number, _: asked.append(number))
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    node.loop.start()
    try:
        while not asked and not node.loop.ended.is_set():
            executor.spin_once(timeout_sec=SPIN_PERIOD)
    finally:
        node.loop.stop()
        node.publish_diagnostics(last=True)
        executor.shutdown()
    if node.loop.failure is not None:
        print(f"{NAME}: the marching thread failed: {node.loop.failure!r}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
