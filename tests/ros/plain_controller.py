"""A controller as a user writes it: every state that comes in is answered at once; nothing else is known.

`python plain_controller.py SLOW`: SLOW seconds are thought over each tenth command.
"""

from __future__ import annotations

import sys
import time
from contextlib import suppress

import rclpy
from rclpy.executors import ExternalShutdownException
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray


def main(slow: float) -> None:
    """Answer until a signal comes."""
    rclpy.init()
    node = rclpy.create_node("plain_controller")
    commands = node.create_publisher(Float64MultiArray, "flexsim_node/commands", 10)
    count = 0

    def answer(state: JointState) -> None:
        nonlocal count
        if slow and count % 10 == 0:
            time.sleep(slow)
        count += 1
        t = state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec
        wanted = (0.3 + t, 0.8 - t, -0.6)
        commands.publish(Float64MultiArray(data=[
            50.0 * (w - q) - 2.0 * v for w, q, v in zip(wanted, state.position, state.velocity, strict=True)
        ]))  # fmt: skip

    node.create_subscription(JointState, "joint_states", answer, 10)
    with suppress(KeyboardInterrupt, ExternalShutdownException):
        rclpy.spin(node)


if __name__ == "__main__":
    main(float(sys.argv[1]))
