"""thermal_node: a fire door in its furnace on ROS 2.  Topics, parameters: docs/thermal_node.md."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from flexsim_msgs.msg import (
    FireCriteria,
    LeafDeflection,
    LeafMesh,
    Reactions,
    TemperatureField,
    Thermocouples,
)
from flexsim_ros import (
    OF_ROS,
    QUIT,
    Entity,
    SimulationServices,
    SimulatorStatus,
    StatusPublisher,
    declare_parameters,
    given_parameters,
    named,
    others,
    run_node,
    spin_through,
)
from flexsim_ros.entities import STATIC_OBJECT
from flexsim_ros.published_scene import scene_text
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Image, PointCloud2, Temperature
from simulation_interfaces.msg import EntityState
from std_msgs.msg import String

from .furnace.furnace import with_its_log
from .scene.load import Scene, SceneError, load_scene
from .service import conversions
from .service.background_deformation import BackgroundDeformation
from .service.fire_test import FireTest
from .service.realtime import SECOND, Loop, Output
from .service.settings import CHANGEABLE, OVERRIDE, SettingError, Settings, meanings, settings

NAME = "thermal_node"
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
QUEUE = QoSProfile(depth=10)
SPIN_PERIOD = 0.1
# s for answers that came when the loop ended.
LAST_ANSWERS = 0.01


class ThermalNode(Node):
    """Connects a marching loop to its topics; raises SettingError or SceneError."""

    def __init__(self) -> None:
        try:
            super().__init__(NAME, automatically_declare_parameters_from_overrides=True)
        except ValueError:  # rclpy knows no such value
            raise SettingError("a parameter is nothing, or an empty list; give it a value") from None
        given = self.settings = self._read_parameters()
        scene = load_burning(given)
        begun = time.monotonic()
        self.test = FireTest(scene)
        bends = given.deflection_period > 0.0 and scene.deformation.model != "none"
        deformation = BackgroundDeformation(self.test.model) if bends else None
        # What never changes goes out first: whoever waits for it need not wait for the kernels.
        self._mesh = self.create_publisher(LeafMesh, "door/mesh", LATCHED)
        self._mesh.publish(conversions.leaf_mesh(self.test))
        self._scenes = self.create_publisher(String, "~/scene", LATCHED)
        self._publish_scene()
        publisher, queue = self.create_publisher, QUEUE
        self._furnace = publisher(Temperature, "furnace/temperature", queue)
        self._thermocouples = publisher(Thermocouples, "door/thermocouples", queue)
        self._criteria = publisher(FireCriteria, "door/criteria", queue)
        reacts = bool(self.test.reacted.name)
        self._reactions = publisher(Reactions, "door/reactions", queue) if reacts else None
        self._field = publisher(TemperatureField, "door/temperature_field", queue)
        self._points = publisher(PointCloud2, "door/temperature_points", queue)
        self._infrared = publisher(Image, "door/unexposed/image", queue)
        self._clocks = publisher(Clock, "/clock", queue) if given.publish_clock else None
        deflections = self.create_publisher(LeafDeflection, "door/deflection", QUEUE)
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", QUEUE)
        self._status = StatusPublisher(self)
        self.test.warm()
        self.loop = Loop(
            self.test,
            given.rate,
            given.pace,
            self._outputs(),
            duration=given.duration,
            wait_for_furnace=given.wait_for_furnace,
            limits=given.limits,
            deformation=deformation,
            deflection_period=given.deflection_period,
            bent=lambda bent: deflections.publish(conversions.leaf_deflection(bent)),
        )
        hearing = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
        measured = self.create_subscription(
            Temperature, "furnace/measured_temperature", self._on_measured, hearing
        )
        self._measured_topic = measured.topic_name
        steady = RosClock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0, self.publish_diagnostics, clock=steady)
        self._said, self._resumed = "", 0
        self.troubles = 0  # inputs that came to nothing
        leaf = Entity(scene.name, STATIC_OBJECT, f"fire door, {scene.solver.model}", ("door",))
        self.simulation = SimulationServices(
            self, self.loop, [leaf], self._entity_states, f"a step is 1/rate, {1.0 / given.rate:g} s"
        )
        self.get_logger().info(
            f"{scene.name}: {scene.solver.model}, {len(self.test.model.nodes)} unknowns, "
            f"{given.pace_in_words}; "
            f"kernels ready in {time.monotonic() - begun:.1f} s"
        )

    def _read_parameters(self) -> Settings:
        given = given_parameters(self)
        found = settings(given)
        replaced = {name: value for name, value in given.items() if name.startswith(OVERRIDE)}
        values = {name: getattr(found, name) for name in meanings()} | replaced
        about = {name: meaning for name, (_, meaning) in meanings().items()}
        about |= dict.fromkeys(replaced, "replaces this key of the scene")
        declare_parameters(self, values, about, CHANGEABLE)
        self.add_on_set_parameters_callback(self._change)
        return found

    def _publish_scene(self, now: int = 0, ticks: int = 0) -> None:
        """Say what is simulated, whole: its file may be changed, or be another one elsewhere."""
        told = scene_text(
            NAME,
            self.test.scene.model_dump(exclude={"source"}),
            {name: getattr(self.settings, name) for name in meanings()},
            overrides=self.settings.override,
            file=self.settings.scene,
            since=now / SECOND,
            ticks=ticks,
        )
        self._scenes.publish(String(data=told))

    def _outputs(self) -> list[Output]:
        """What is published, in this order."""
        test, every = self.test, self.settings.field_every
        outputs = [
            output(test, 1, self._furnace, conversions.furnace_temperature),
            output(test, 1, self._thermocouples, conversions.thermocouples),
            output(test, 1, self._criteria, conversions.fire_criteria),
            output(test, every, self._field, conversions.temperature_field),
            output(test, every, self._points, conversions.temperature_points),
            output(test, every, self._infrared, conversions.unexposed_image),
        ]
        if self._reactions is not None:
            outputs.append(output(test, 1, self._reactions, conversions.reactions))
        if self._clocks is not None and self.settings.publish_clock:
            # Last, so that who waits for this time finds the state that belongs to it.
            outputs.append(output(test, 1, self._clocks, lambda _, time: conversions.clock(time)))
        return outputs

    def _entity_states(self) -> dict[str, EntityState]:
        state = EntityState()  # the leaf stands at the origin of its own frame and stays there
        state.header.stamp = conversions.stamp(self.loop.time)
        return {self.test.scene.name: state}

    def _change(self, parameters: list[Parameter]) -> SetParametersResult:
        """Take what may change while the door burns, all or nothing."""
        changes = {p.name: p.value for p in parameters if not p.name.startswith(OF_ROS)}
        fixed = [name for name in changes if name not in CHANGEABLE]
        now = {name: getattr(self.settings, name) for name in meanings()}
        now |= {f"{OVERRIDE}{key}": value for key, value in self.settings.override.items()}
        try:
            if fixed:
                raise SettingError(
                    f"{fixed[0]} is read when the node starts; start it anew"
                    f" ({', '.join(CHANGEABLE)} may be set while it runs)"
                )
            given = settings(now | changes)
        except SettingError as problem:
            return SetParametersResult(successful=False, reason=str(problem))
        self.settings = given
        if given.publish_clock and self._clocks is None:
            self._clocks = self.create_publisher(Clock, "/clock", QUEUE)
        outputs = self._outputs()
        self.loop.plausibility.limits = given.limits
        self.loop.ask(lambda: self.loop.change(given.pace, given.duration, outputs))
        self._publish_scene(self.loop.time, self.loop.ticks)
        return SetParametersResult(successful=True)

    def _on_measured(self, message: Temperature) -> None:
        refusal = self.loop.measure(message.temperature)
        if refusal is not None:
            count = self.loop.report.refused.total()
            self.get_logger().warning(
                f"refused a measured temperature, {message.temperature:g} °C: {refusal.sentence}"
                f" ({count} refused before)",
                throttle_duration_sec=1.0,
            )

    def say_status(self, phase: str = "") -> None:
        """Tell whoever waits for the door whether its time goes on; `phase` where it is not the loop's."""
        loop, resets = self.loop, self.loop.resets  # first: a stop that is told is never of an earlier run
        phase = phase or loop.phase
        self._status.say(
            SimulatorStatus(phase, loop.trouble, loop.time / SECOND, resets, scene=self.test.scene.name)
        )

    def publish_diagnostics(self, *, last: bool = False) -> None:
        """Say how it goes; the last time wait a moment until it is heard."""
        report = self.loop.report
        name, timeout = self.test.scene.name, self.settings.furnace_timeout
        pace = self.settings.pace_in_words
        furnaces = others(self, [self._measured_topic])
        said = conversions.diagnostics(report, name, pace, timeout, self.troubles, furnaces)
        self._diagnostics.publish(named(said, self))
        if last:
            self._diagnostics.wait_for_all_acked(Duration(seconds=0.5))
        if report.measured and report.stale > timeout and report.phase == "running":
            self.get_logger().warning(
                f"no measured furnace temperature for {report.stale:.0f} s; the last one,"
                f" {report.furnace:.1f} degrees Celsius, holds",
                throttle_duration_sec=10.0,
            )
        if report.resumed > self._resumed:
            self._resumed = report.resumed
            self.get_logger().warning(
                f"{name} goes on at {report.exposure:g} s with the furnace at {report.furnace:.1f} degrees"
                f" Celsius, after it had stopped ({report.resumed} times in all)"
            )
        if report.phase != self._said:
            self._said = report.phase
            if report.phase == "stopped":
                self.get_logger().error(f"{name} {report.status}; its last good state is published on")
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
    return with_its_log(scene)


def output(test: FireTest, every: int, publisher: Any, convert: Callable[[FireTest, int], Any]) -> Output:
    """Publish what `convert` makes of the test, every so many ticks."""
    return Output(every, lambda time: publisher.publish(convert(test, time)))


def main() -> int:
    """Run the node until SIGINT or SIGTERM.  Returns 0; 1: a bad scene, 2: a bad parameter."""
    return run_node(NAME, ThermalNode, run, {SceneError: 1, SettingError: 2})


def run(node: ThermalNode, asked: list[int]) -> int:
    """March and spin until a signal comes or a client asks to quit.  Returns the exit code."""
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    node.loop.start()
    try:
        while not (asked or node.simulation.quit_asked or node.loop.ended.is_set()):
            node.troubles += bool(spin_through(node, executor, SPIN_PERIOD))
            node.say_status()
    finally:
        node.loop.stop()
        spin_through(node, executor, LAST_ANSWERS)
        node.say_status(QUIT)
        node.publish_diagnostics(last=True)
        node.simulation.close()
        executor.shutdown()
    if node.loop.failure is not None:
        print(f"{NAME}: the marching thread failed: {node.loop.failure!r}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
