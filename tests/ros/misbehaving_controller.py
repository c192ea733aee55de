"""A controller that does one thing wrong: `python misbehaving_controller.py HOW`, with HOW one of

silent (hears, and never answers), nan, wrong_length, dies (exit code 3 after twenty answers), stands (stops
itself by SIGSTOP then), pushes (1e4 N m), deaf (knows neither ROS nor signals), holds (does nothing wrong).
"""

from __future__ import annotations

import os
import signal
import sys
import time

AFTER = 20


def answers(how: str, count: int) -> list[float] | None:
    """The torques for one joint, or None for no answer."""
    if how == "silent":
        return None
    if how == "dies" and count > AFTER:
        print("[ERROR] a cable is loose", file=sys.stderr, flush=True)
        os._exit(3)
    if how == "stands" and count > AFTER:
        os.kill(os.getpid(), signal.SIGSTOP)
    return {"nan": [float("nan")], "wrong_length": [0.0, 0.0], "pushes": [1e4]}.get(how, [0.0])


def main(how: str) -> None:
    """Answer each new state until a signal comes."""
    import rclpy
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Float64MultiArray

    rclpy.init()
    node = rclpy.create_node("misbehaving_controller")
    commands = node.create_publisher(Float64MultiArray, "flexsim_node/commands", 10)
    answered: list[tuple[int, int]] = []

    def answer(state: JointState) -> None:
        stamp = state.header.stamp.sec, state.header.stamp.nanosec
        if answered and answered[-1] == stamp:
            return
        answered.append(stamp)
        torque = answers(how, len(answered))
        if torque is not None:
            commands.publish(Float64MultiArray(data=torque))

    node.create_subscription(JointState, "joint_states", answer, 10)
    rclpy.spin(node)


if __name__ == "__main__":
    if sys.argv[1] == "deaf":
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)
        while True:
            time.sleep(1.0)
    main(sys.argv[1])
