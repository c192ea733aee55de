"""flexsim_follower: one of the example laws as a node that follows a trajectory, over DDS.

`python -m flexsim.controller.follow LAW --ros-args -p scene:=PATH -p rate:=500.0`
with LAW one of joint_pd, shaped_pd, lqg.

It reads `joint_states`, whose stamps are its clock, `joint_trajectory` (latched; times count from its stamp)
and, where the law wants it, `flexsim_node/elastic_state`; it answers each state once, with
`flexsim_node/commands`.  So it works in lockstep and in real time alike.
"""

from __future__ import annotations

import array
import os
import sys
from typing import Any

import numpy as np

from ..ros.simulator import SimulatorWatch
from ..terminal.stop import Stop, stopped_by_signals
from .joints import joint_order
from .laws import LAWS, Law
from .trajectory import Trajectory

NAME = "flexsim_follower"
SPIN_PERIOD = 0.1


class Follower:
    """Connects a law to its topics."""

    def __init__(self, node: Any, law: str) -> None:
        from flexsim_msgs.msg import ElasticState
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from sensor_msgs.msg import JointState
        from std_msgs.msg import Float64MultiArray
        from trajectory_msgs.msg import JointTrajectory

        from flexsim_node import load_scene

        given = {name: p.value for name, p in node.get_parameters_by_prefix("").items()}
        if "scene" not in given or "rate" not in given:
            raise ValueError("parameters scene and rate are needed: --ros-args -p scene:=PATH -p rate:=500.0")
        override = {k.removeprefix("override."): v for k, v in given.items() if k.startswith("override.")}
        self.scene = load_scene(
            given["scene"], {k: list(v) if isinstance(v, array.array) else v for k, v in override.items()}
        )
        self.period = 1.0 / float(given["rate"])
        self.law_name, self.begin = law, 0.0
        self.law: Law | None = None
        self.trajectory: Trajectory | None = None
        self.kind = Float64MultiArray
        self.state: Any = None  # the last one that is not answered yet
        self.shapes: dict[int, np.ndarray] = {}  # deflections by stamp
        self.answered = -1
        self.wants_shape = LAWS[law].deflection
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.commands = node.create_publisher(Float64MultiArray, "flexsim_node/commands", 10)
        node.create_subscription(JointTrajectory, "joint_trajectory", self.on_trajectory, latched)
        node.create_subscription(JointState, "joint_states", self.on_state, 10)
        if self.wants_shape:
            node.create_subscription(ElasticState, "flexsim_node/elastic_state", self.on_shape, 10)

    def on_trajectory(self, message: Any) -> None:
        """Design the law for this way."""
        order = joint_order("joint_trajectory", message.joint_names, self.scene.joint_names)
        points = message.points
        trajectory = Trajectory(
            np.array([seconds(p.time_from_start) for p in points]),
            np.array([p.positions for p in points])[:, order],
            np.array([p.velocities for p in points])[:, order],
        )
        self.trajectory = trajectory
        self.law = LAWS[self.law_name](self.scene, trajectory, self.period)
        self.begin = seconds(message.header.stamp)
        self.answer()

    def on_state(self, message: Any) -> None:
        """Remember a state, and answer it if all it needs is there."""
        self.state = message
        self.answer()

    def on_shape(self, message: Any) -> None:
        """The same for the shape that belongs to it."""
        stamp = nanoseconds(message.header.stamp)
        self.shapes = {k: v for k, v in self.shapes.items() if stamp - 10**9 < k < stamp}
        self.shapes[stamp] = np.array(message.displacement[-6:])
        self.answer()

    def answer(self) -> None:
        """Send the torque for a state, once."""
        if self.law is None or self.state is None:
            return
        stamp = nanoseconds(self.state.header.stamp)
        if stamp == self.answered or (self.wants_shape and stamp not in self.shapes):
            return
        if stamp < self.answered and self.trajectory is not None:
            # The robot was reset: what the law remembers is of another motion.
            self.law = LAWS[self.law_name](self.scene, self.trajectory, self.period)
        self.answered = stamp
        order = joint_order("joint_states", self.state.name, self.scene.joint_names)
        torque = self.law.torque(
            1e-9 * stamp - self.begin,
            np.array(self.state.position)[order],
            np.array(self.state.velocity)[order],
            self.shapes.get(stamp, np.zeros(6)),
        )
        self.commands.publish(self.kind(data=array.array("d", torque.tobytes())))


def seconds(time: Any) -> float:
    """A time or duration, s."""
    return float(time.sec + 1e-9 * time.nanosec)


def nanoseconds(time: Any) -> int:
    """A time, ns."""
    return int(time.sec * 10**9 + time.nanosec)


def run(law: str, stopped: Stop) -> None:
    """Follow until a signal comes."""
    import rclpy
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.signals import SignalHandlerOptions

    rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
    node = rclpy.create_node(NAME, automatically_declare_parameters_from_overrides=True)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        follower = Follower(node, law)
        told = False  # that another scene is simulated
        robot = SimulatorWatch(node, "flexsim_node")
        node.get_logger().info(f"{law}: ready; waiting for a trajectory and joint states")
        while not stopped.asked:
            executor.spin_once(timeout_sec=SPIN_PERIOD)
            # One that has stopped may be reset; of one that is gone nothing can be expected.
            if news := robot.news():
                node.get_logger().warning(news)
            if not told and (other := robot.other_scene(follower.scene.name)):
                node.get_logger().warning(other)
                told = True
            if gone := robot.gone:
                raise RuntimeError(gone)
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.shutdown()


def main() -> int:
    """Run the node.  Returns 0 when a signal came, 1 where it failed, 2 for a law that does not exist."""
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    if len(sys.argv) < 2 or sys.argv[1] not in LAWS:
        print(f"{NAME}: give a law first: {', '.join(LAWS)}", file=sys.stderr)
        return 2
    with stopped_by_signals() as stopped:
        try:
            run(sys.argv[1], stopped)
        except (ValueError, ArithmeticError, LookupError, RuntimeError) as problem:
            print(f"{NAME}: {problem}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
