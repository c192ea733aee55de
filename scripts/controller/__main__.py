"""flexsim_controller: holds a robot's joints on a move, over DDS.

Parameters: scene, rate, listeners, duration, start, goal, there, back, time, stiffness, damping,
all of them; config/demo.params.yaml is an example.  It reads `joint_states`, whose stamps are its
clock, and writes `flexsim_node/commands` and, for the record, `joint_references`.  When the duration
is over it says so, and holds on until SIGINT or SIGTERM, or until the robot has ended: who lets go of an arm
drops it.
"""

from __future__ import annotations

import array
import gc
import os
import sys
import time
from typing import Any

import numpy as np

from ..ros.simulator import SimulatorWatch
from ..terminal.stop import Stop, stopped_by_signals
from .joint_pd import JointPd, Move
from .joints import joint_order

NAME = "flexsim_controller"
NUMBERS = ("rate", "duration", "there", "back", "time", "listeners")
LISTS = ("start", "goal", "stiffness", "damping")
# A robot may be compiling its kernels before it speaks, but does not fall silent later.
FIRST_STATE, NEXT_STATE = 120.0, 2.0
LOOK = 0.1  # s from one look at how the robot does to the next


def read_parameters(node: Any) -> dict[str, Any]:
    """Return the node's parameters; raises ValueError for one that is missing or can't be."""
    given = {name: p.value for name, p in node.get_parameters_by_prefix("").items()}
    missing = [name for name in ("scene", *NUMBERS, *LISTS) if name not in given]
    if missing:
        raise ValueError(f"parameter {missing[0]} is missing; config/demo.params.yaml has all")
    try:
        found: dict[str, Any] = {name: float(given[name]) for name in NUMBERS}
        found |= {name: tuple(float(x) for x in given[name]) for name in LISTS}
    except (TypeError, ValueError) as problem:
        raise ValueError(f"a parameter is not a number: {problem}") from None
    if found["rate"] <= 0.0 or found["time"] <= 0.0:
        raise ValueError("rate and time are to be more than zero")
    return {**found, "scene": str(given["scene"])}


def control(node: Any, stopped: Stop) -> None:
    """Control until a signal comes, or the robot ends after the duration; raises RuntimeError before."""
    from rclpy.qos import QoSProfile
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Float64MultiArray

    from flexsim_node import load_scene
    from flexsim_node.service.pace import SECOND, Pace, go_first, sleep_finely

    given = read_parameters(node)
    scene = load_scene(given["scene"])
    move = Move(given["start"], given["goal"], given["there"], given["back"], given["time"])
    law = JointPd(scene, move, np.array(given["stiffness"]), np.array(given["damping"]))
    states = node.create_subscription(JointState, "joint_states", lambda _: None, QoSProfile(depth=1))
    commands = node.create_publisher(Float64MultiArray, "flexsim_node/commands", QoSProfile(depth=1))
    robot = SimulatorWatch(node, "flexsim_node")
    references = node.create_publisher(JointState, "joint_references", QoSProfile(depth=1))
    wanted = JointState(name=list(scene.joint_names))
    node.get_logger().info("ready; waiting for joint states")

    order: list[int] | None = None
    last: JointState | None = None
    begun, over = 0.0, False
    heard = time.monotonic() + FIRST_STATE - NEXT_STATE
    gc.collect()
    gc.freeze()
    sleep_finely()
    go_first()
    pace = Pace(round(SECOND / given["rate"]))
    told = False  # that another scene is simulated
    ticks, looks = 0, max(1, round(LOOK * given["rate"]))
    while not stopped.asked:
        pace.wait()
        ticks += 1
        if ticks % looks == 0:
            robot.poll()
            gone = robot.gone
            if over and gone:  # nothing is left to hold
                return
            if trouble := robot.trouble or gone:
                raise RuntimeError(trouble)
            if news := robot.news():
                node.get_logger().warning(news)
            if not told and (other := robot.other_scene(scene.name)):
                node.get_logger().warning(other)
                told = True
        with states.handle:
            taken = states.handle.take_message(JointState, False)
        if taken is not None:
            last, heard = taken[0], time.monotonic()
        elif time.monotonic() - heard > NEXT_STATE:
            waited = NEXT_STATE if last is not None else FIRST_STATE
            raise RuntimeError(f"no joint states for {waited:g} s; is flexsim_node running?")
        if last is None or (order is None and commands.get_subscription_count() < given["listeners"]):
            continue
        t = last.header.stamp.sec + 1e-9 * last.header.stamp.nanosec
        if order is None:
            order = joint_order("joint_states", last.name, scene.joint_names)
            begun = t
        begun = min(begun, t)  # a robot whose time begins anew begins the move anew
        if not over and t - begun >= given["duration"]:
            over = True
            node.get_logger().info("the move is over")
        torque = law.torque(
            t - begun, np.frombuffer(last.position)[order], np.frombuffer(last.velocity)[order]
        )
        commands.publish(Float64MultiArray(data=array.array("d", torque.tobytes())))
        # after the torque, which is waited for
        wanted.header.stamp = last.header.stamp
        wanted.position = array.array("d", move.position(t - begun).tobytes())
        wanted.velocity = array.array("d", move.velocity(t - begun).tobytes())
        references.publish(wanted)


def main() -> int:
    """Run the controller.  Returns 0 when a signal came, 1 where it failed."""
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    import rclpy
    from rclpy.signals import SignalHandlerOptions

    with stopped_by_signals() as stopped:
        rclpy.init(signal_handler_options=SignalHandlerOptions.NO)
        node = rclpy.create_node(NAME, automatically_declare_parameters_from_overrides=True)
        try:
            control(node, stopped)
        except (ValueError, LookupError, RuntimeError) as problem:
            print(f"{NAME}: {problem}", file=sys.stderr)
            return 1
        finally:
            node.destroy_node()
            rclpy.shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
