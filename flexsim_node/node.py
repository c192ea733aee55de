"""flexsim_node: a flexible robot on ROS 2.  Topics, parameters and timing: docs/node.md."""

from __future__ import annotations

import gc
import sys
import time
from collections.abc import Callable, Hashable
from concurrent.futures import TimeoutError as NoAnswer
from dataclasses import replace
from typing import Any

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray
from flexsim_msgs.msg import ElasticLayout, ElasticState
from flexsim_ros import (
    OF_ROS,
    QUIT,
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
from flexsim_ros.published_scene import scene_text
from geometry_msgs.msg import WrenchStamped
from rcl_interfaces.msg import SetParametersResult
from rclpy.clock import Clock as RosClock
from rclpy.clock import ClockType
from rclpy.duration import Duration
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, PointCloud2
from simulation_interfaces.msg import EntityState
from std_msgs.msg import Float64MultiArray, String

from .analysis.decide import decide
from .integrators import METHODS
from .motion.link_motion import link_motion
from .motion.simulation import Simulation
from .scene.load import Scene, SceneError, faults_from_text, load_scene
from .service import conversions
from .service.commands import CommandRefused, Commands
from .service.pace import PRIORITY, SECOND, go_first, threads
from .service.realtime import Loop, Output
from .service.robot_description import robot_description
from .service.sensor_messages import SensorMessages
from .service.settings import (
    CHANGEABLE,
    OVERRIDE,
    SettingError,
    Settings,
    changed,
    meanings,
    schedule,
    settings,
)

NAME = "flexsim_node"
QUEUE = QoSProfile(depth=10)
# Who only listens does not hold up the robot, and yet no state may be lost to one who is late.
IN_LOCKSTEP = QoSProfile(depth=2000)
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# Jazzy's EventsExecutor does nothing when it waits without end.
SPIN_PERIOD = 0.1
# s for answers that came when the loop ended.
LAST_ANSWERS = 0.01
# s within which a thread that wants Python's lock gets it: the stepping thread has deadlines.
SWITCH_INTERVAL = 2e-4
# s in which the stepping thread comes to the end of a tick.
ANSWER_TIMEOUT = 5.0


class FlexsimNode(Node):
    """Connects a stepping loop to its topics and services; raises SettingError or SceneError."""

    def __init__(self) -> None:
        try:
            super().__init__(NAME, automatically_declare_parameters_from_overrides=True)
        except ValueError:  # rclpy knows no such value
            raise SettingError(
                "a parameter is nothing, or an empty list; give it a value,"
                " text in quotes of its own: -p \"faults:='[]'\""
            ) from None
        self.settings = self._read_parameters()
        self._plain_scene = load_steady(self.settings)
        self.scene = with_faults(self._plain_scene, self.settings.faults)
        self.timing = schedule(self.settings, self.scene.solver.step)
        decided, self.decision = decide(self.scene)
        robot = Simulation(decided, self.timing.step)
        links = [link.name for link in self.scene.links]
        self.commands = Commands(self.scene.joint_names, self.scene.passive_joints, links)
        self._messages = conversions.StateMessages(robot)
        # What never changes goes out first: whoever waits for it need not wait for the kernels.
        self._layouts = self.create_publisher(ElasticLayout, "~/elastic_layout", LATCHED)
        self._descriptions = self.create_publisher(String, "robot_description", LATCHED)
        self._scenes = self.create_publisher(String, "~/scene", LATCHED)
        self._layouts.publish(conversions.elastic_layout(robot.model))
        self._descriptions.publish(String(data=robot_description(self.scene)))
        self._publish_scene(robot)
        states = IN_LOCKSTEP if self.settings.mode == "lockstep" else QUEUE
        self._joints = self.create_publisher(JointState, "joint_states", states)
        self._elastic = self.create_publisher(ElasticState, "~/elastic_state", states)
        self._shape = self.create_publisher(PointCloud2, "~/deformed_shape", QUEUE)
        self._clocks = self.create_publisher(Clock, "/clock", QUEUE) if self.settings.publish_clock else None
        self._diagnostics = self.create_publisher(DiagnosticArray, "/diagnostics", QUEUE)
        self._status = StatusPublisher(self)
        self._refusal = ""  # what was wrong with the last command that was refused
        self._sensors = self._sensor_outputs(robot)
        begun = time.monotonic()
        robot.warm()
        self.loop = Loop(
            robot,
            self.timing.steps,
            self.settings.mode,
            self._outputs(),
            period=self.timing.state,
            command_timeout=self.settings.command_timeout,
            wait_for_command=self.settings.wait_for_command,
            audience=self._audience,
            scope=None if self.decision is None else self.decision.envelope,
        )
        self._listen()
        self.simulation = SimulationServices(
            self,
            self.loop,
            conversions.entities(self.scene),
            self._entity_states,
            f"a step is 1/rate, {1.0 / self.settings.rate:g} s; mode {self.settings.mode}",
            on_reset=self.commands.release,
        )
        steady = RosClock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0, self.publish_diagnostics, clock=steady)
        self._said_stopped = False
        self._commanders: list[str] = []
        self.troubles = 0  # inputs that came to nothing
        for line in self.decision.sentences() if self.decision else ():
            self.get_logger().info(f"auto: {line}")
        self.get_logger().info(
            f"{self.scene.name}: {robot.model.joints} joints, {robot.model.unknowns} unknowns, "
            f"step {self.timing.step:g} s, {self.settings.mode}; "
            f"kernels ready in {time.monotonic() - begun:.1f} s"
        )

    def _publish_scene(self, robot: Simulation, now: int = 0, ticks: int = 0) -> None:
        """Say what is simulated, whole: its file may be changed, or be another one elsewhere."""
        told = scene_text(
            NAME,
            robot.scene.model_dump(),
            {name: getattr(self.settings, name) for name in meanings()},
            overrides=self.settings.override,
            effects=self.decision.sentences() if self.decision else (),
            file=self.settings.scene,
            since=now / SECOND,
            ticks=ticks,
        )
        self._scenes.publish(String(data=told))

    def _sensor_outputs(self, robot: Simulation) -> list[Output]:
        """Publishers of the scene's sensors: before the joint states, for who waits for those."""
        sensors = SensorMessages(robot)
        if not sensors.topics:
            return []
        publishers = {
            name: self.create_publisher(kind, f"~/sensors/{name}", QUEUE)
            for name, kind in sensors.topics.items()
        }

        def publish(time: int) -> None:
            for name, message in sensors.serialized(time).items():
                publishers[name].publish(message)

        return [Output(self.timing.state, publish)]

    def _outputs(self) -> list[Output]:
        """What is published, in this order, by the schedule."""
        messages, timing = self._messages, self.timing
        outputs = [
            *self._sensors,
            output(timing.state, self._joints, messages.joint_state),
            output(timing.elastic, self._elastic, messages.elastic_state),
            output(timing.shape, self._shape, messages.deformed_shape),
        ]
        if self._clocks is not None and self.settings.publish_clock:
            # Last, so that who waits for this time finds the state that belongs to it.
            outputs.append(output(timing.clock, self._clocks, messages.clock))
        return outputs

    def _audience(self) -> Hashable:
        """Who hears states and who sends commands."""
        return (
            self._joints.get_subscription_count(),
            *(self.count_publishers(topic) for topic in self._command_topics),
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

    def _listen(self) -> None:
        # Best effort hears every publisher, and a late command is of no use; lockstep loses none.
        locked = self.settings.mode == "lockstep"
        reliability = ReliabilityPolicy.RELIABLE if locked else ReliabilityPolicy.BEST_EFFORT
        listening = QoSProfile(depth=1000 if locked else 10, reliability=reliability)
        heard = [
            self.create_subscription(Float64MultiArray, "~/commands", self._on_commands, listening),
            self.create_subscription(JointState, "robot_joint_commands", self._on_joints, listening),
        ]
        self.create_subscription(WrenchStamped, "~/wrench", self._on_wrench, listening)
        self._command_topics = [subscription.topic_name for subscription in heard]

    def _on_commands(self, message: Float64MultiArray) -> None:
        self._take("~/commands", self.commands.in_order, np.frombuffer(message.data))

    def _on_joints(self, message: JointState) -> None:
        names, effort = message.name, np.frombuffer(message.effort)
        self._take("robot_joint_commands", self.commands.by_name, names, effort)

    def _take(self, topic: str, check: Callable[..., np.ndarray], *words: Any) -> None:
        try:
            if not self.loop.put(check(*words)):
                raise self.commands.too_many()
        except CommandRefused as refused:
            self._refusal = str(refused)
            self.get_logger().warning(
                f"refused a command on {topic} ({self.commands.refused.total()} in all): {refused}",
                throttle_duration_sec=1.0,
            )

    def _on_wrench(self, message: WrenchStamped) -> None:
        link, force, moment = message.header.frame_id, message.wrench.force, message.wrench.torque
        values = (force.x, force.y, force.z, moment.x, moment.y, moment.z)
        try:
            load = self.commands.load(link, values)
        except CommandRefused as refused:
            self._refusal = str(refused)
            self.get_logger().warning(f"refused a load on ~/wrench: {refused}", throttle_duration_sec=1.0)
            return
        self.loop.ask(lambda: self.loop.robot.apply(link, load))

    def _entity_states(self) -> dict[str, EntityState]:
        robot, loop = self.loop.robot, self.loop
        x, v, torque, now = loop.ask(
            lambda: (robot.x.copy(), robot.v.copy(), robot.torque[0].copy(), loop.time)
        ).result(ANSWER_TIMEOUT)
        return conversions.entity_states(self.scene, link_motion(robot.model, x, v, torque), now)

    def _change(self, parameters: list[Parameter]) -> SetParametersResult:
        """Take what may change while the robot moves, all or nothing."""
        changes = {p.name: p.value for p in parameters if not p.name.startswith(OF_ROS)}
        fixed = [name for name in changes if name not in CHANGEABLE]
        try:
            if fixed:
                raise SettingError(
                    f"{fixed[0]} is read when the node starts; start it anew"
                    f" ({', '.join(CHANGEABLE)} may be set while it runs)"
                )
            given = replace(self.settings, **changed(changes))
            timing = schedule(given, self.timing.step, self.timing.steps)
            if given.faults != self.settings.faults:
                self._set_faults(with_faults(self._plain_scene, given.faults))
        except (ValueError, ArithmeticError, RuntimeError) as problem:
            return SetParametersResult(successful=False, reason=str(problem))
        self.settings, self.timing = given, timing
        if given.publish_clock and self._clocks is None:
            self._clocks = self.create_publisher(Clock, "/clock", QUEUE)
        self.loop.command_timeout = given.command_timeout
        self.loop.outputs = self._outputs()
        self._publish_scene(self.loop.robot, self.loop.time, self.loop.ticks)
        return SetParametersResult(successful=True)

    def _set_faults(self, scene: Scene) -> None:
        """Have a scene's faults taken; raises what the robot says of them."""
        done = self.loop.ask(lambda: self.loop.robot.set_faults(scene))
        try:
            done.result(ANSWER_TIMEOUT)
        except NoAnswer:
            if done.cancel():
                raise RuntimeError(f"the robot did not answer within {ANSWER_TIMEOUT:g} s") from None
            done.result()

    def say_status(self, phase: str = "") -> None:
        """Tell whoever waits for the robot whether its time goes on; `phase` where it is not the loop's."""
        loop, resets = self.loop, self.loop.resets  # first: a stop that is told is never of an earlier run
        phase, refused = phase or loop.phase, self.commands.refused.total()
        self._status.say(
            SimulatorStatus(
                phase, loop.trouble, loop.time / SECOND, resets, refused, self._refusal, self.scene.name
            )
        )

    def publish_diagnostics(self, *, last: bool = False) -> None:
        """Say how it goes; the last time wait a moment until it is heard."""
        report = self.loop.report
        commanders = others(self, self._command_topics)
        message = conversions.diagnostics(
            report, self.commands, self.scene.name, self.settings.mode, self.troubles, commanders
        )
        if commanders and commanders != self._commanders:
            self.get_logger().warning(
                f"several publish commands: {', '.join(commanders)}; the latest holds, whoever sent it"
            )
        self._commanders = commanders
        if self.decision is not None:
            message.status.append(conversions.effects_status(self.decision, self.scene.name))
        self._diagnostics.publish(named(message, self))
        if last:
            self._diagnostics.wait_for_all_acked(Duration(seconds=0.5))
        if report.phase == "stopped" and not self._said_stopped:
            self._said_stopped = True
            self.get_logger().error(
                f"{self.scene.name} stopped at {report.time:.6f} s: {report.status}; "
                "its last good state is published on"
            )


def load_steady(given: Settings) -> Scene:
    """Load the scene of these settings, whose steps must have a fixed cost; raises SceneError."""
    scene = load_scene(given.scene, overrides=given.override)
    if scene.solver.method not in METHODS:
        raise SceneError(
            f"{given.scene}: solver.method: is {scene.solver.method!r}, "
            f"whose steps have no fixed cost; give {', '.join(METHODS)}"
        )
    return scene


def with_faults(scene: Scene, text: str) -> Scene:
    """A scene with the faults that a parameter gives, or its own where it gives none; raises SceneError."""
    return load_scene(scene.model_dump(), {"faults": faults_from_text(text)}) if text else scene


def output(every: int, publisher: Any, serialized: Callable[[int], bytes]) -> Output:
    """Publish what `serialized` gives, every so many ticks."""
    return Output(every, lambda time: publisher.publish(serialized(time)))


def main() -> int:
    """Run the node until SIGINT or SIGTERM.  Returns 0; 1: a bad scene, 2: a bad parameter."""
    return run_node(NAME, FlexsimNode, run, {SceneError: 1, SettingError: 2})


def run(node: FlexsimNode, asked: list[int]) -> int:
    """Step and spin until a signal comes or a client asks to quit.  Returns the exit code."""
    executor = EventsExecutor()
    executor.add_node(node)
    sys.setswitchinterval(SWITCH_INTERVAL)
    # All that lives now lives to the end: the collector need not visit it, which would take tens of
    # milliseconds.
    gc.collect()
    gc.freeze()
    if node.settings.mode == "realtime":
        # This thread holds Python's lock now and then, the middleware's hold locks that publishing needs:
        # were one of them to wait for a processor behind ordinary programs, so would the stepping thread.
        for thread in threads():
            go_first(PRIORITY - 1, thread)
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
        print(f"{NAME}: the stepping thread failed: {node.loop.failure!r}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
