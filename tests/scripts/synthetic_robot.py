"""A stand-in for flexsim_node: publishes a swinging, bending three-link arm, fast and exactly.

Run as its own process: `python synthetic_robot.py MESSAGES RATE [--nodes-per-link 3]`. Once
somebody listens it publishes one command, MESSAGES joint states and as many elastic states, and a
last diagnostic message; when all of it is acknowledged it prints "published" and stays until its
standard input ends.
"""

from __future__ import annotations

import argparse
import array
import sys
import time

import numpy as np

LENGTHS = (0.35, 0.5, 0.4)
JOINTS = ["joint_1", "joint_2", "joint_3"]


def shape(t: np.ndarray, nodes_per_link: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return joint angles (K, 3), rigid and deformed node positions (K, N, 3) at times t (K,)."""
    q = np.stack([0.9 * np.sin(1.1 * t), 0.7 + 0.5 * np.sin(1.7 * t), -0.9 + 0.6 * np.sin(2.3 * t)], axis=1)
    ring = np.exp(-0.3 * t) * np.sin(2 * np.pi * 6.0 * t)
    radial = np.stack([np.cos(q[:, 0]), np.sin(q[:, 0]), np.zeros_like(t)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    start = np.zeros((len(t), 3))
    bent = np.zeros((len(t), 3))
    rigid, deformed = [], []
    elevation = np.full(len(t), np.pi / 2)
    for link, length in enumerate(LENGTHS):
        if link:
            elevation = q[:, 1] if link == 1 else q[:, 1] + q[:, 2]
        along = np.cos(elevation)[:, None] * radial + np.sin(elevation)[:, None] * up
        across = -np.sin(elevation)[:, None] * radial + np.cos(elevation)[:, None] * up
        for s in np.linspace(0.0, 1.0, nodes_per_link):
            sag = 0.004 * (link + 1) * s**2 * (1.0 + ring)
            rigid.append(start + s * length * along)
            deformed.append(rigid[-1] + bent - sag[:, None] * across)
        bent = deformed[-1] - rigid[-1]
        start = start + length * along
    return q, np.stack(rigid, axis=1), np.stack(deformed, axis=1)


def main() -> None:
    """Publish."""
    parser = argparse.ArgumentParser()
    parser.add_argument("messages", type=int)
    parser.add_argument("rate", type=float)
    parser.add_argument("--nodes-per-link", type=int, default=3)
    parser.add_argument("--for-view", action="store_true", help="states are all that is listened to")
    arguments = parser.parse_args()
    messages, rate, nodes_per_link = arguments.messages, arguments.rate, arguments.nodes_per_link
    import rclpy
    from builtin_interfaces.msg import Time
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
    from flexsim_msgs.msg import ElasticLayout, ElasticState
    from rclpy.duration import Duration
    from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
    from rclpy.serialization import serialize_message
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Float64MultiArray

    t = (1 + np.arange(messages)) / rate
    q, rigid, deformed = shape(t, nodes_per_link)
    velocity = np.gradient(q, t, axis=0)
    nodes = rigid.shape[1]

    rclpy.init()
    node = rclpy.create_node("flexsim_node")
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    layouts = node.create_publisher(ElasticLayout, "~/elastic_layout", latched)
    joints = node.create_publisher(JointState, "joint_states", 10)
    states = node.create_publisher(ElasticState, "~/elastic_state", QoSProfile(depth=1000))
    commands = node.create_publisher(Float64MultiArray, "~/commands", qos_profile_sensor_data)
    diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", 10)

    layout = ElasticLayout(link_names=["link_1", "link_2", "link_3"])
    layout.header.frame_id = "base"
    layout.node_names = [f"link_{1 + i // nodes_per_link}/{i % nodes_per_link}" for i in range(nodes)]
    layout.node_link = [i // nodes_per_link for i in range(nodes)]
    first = [i for i in range(nodes) if (i + 1) % nodes_per_link]
    layout.segments = [n for i in first for n in (i, i + 1)]
    layout.segment_width = [0.03] * len(first)
    layout.segment_depth = [0.02] * len(first)
    layouts.publish(layout)

    def stamp(seconds: float) -> Time:
        nanoseconds = round(seconds * 1e9)
        return Time(sec=nanoseconds // 10**9, nanosec=nanoseconds % 10**9)

    prepared = []
    for k in range(messages):
        joint = JointState(name=JOINTS, position=q[k], velocity=velocity[k], effort=0.1 * q[k])
        joint.header.stamp = stamp(t[k])
        state = ElasticState(status="ok" if k < messages // 2 else "rotation beyond 0.1 rad")
        state.header.stamp, state.header.frame_id = joint.header.stamp, "base"
        state.displacement = array.array("d", np.zeros(6 * nodes).tobytes())
        state.position = array.array("d", deformed[k].tobytes())
        state.rigid_position = array.array("d", rigid[k].tobytes())
        prepared.append((serialize_message(joint), serialize_message(state)))

    # Whoever listens must be there first, or the counts would be a matter of luck.
    wanted = (joints, states) if arguments.for_view else (joints, states, commands, diagnostics)
    end = time.monotonic() + 20.0
    while any(p.get_subscription_count() == 0 for p in wanted) and time.monotonic() < end:
        time.sleep(0.02)
    commands.publish(Float64MultiArray(data=[1.0, 2.0, 3.0]))
    begun = time.monotonic()
    for k, (joint_bytes, state_bytes) in enumerate(prepared):
        wait = begun + (k + 1) / rate - time.monotonic()
        if wait > 0.0:
            time.sleep(wait)
        joints.publish(joint_bytes)
        states.publish(state_bytes)
    diagnostics.publish(DiagnosticArray(status=[DiagnosticStatus(name="robot: last", message="end")]))
    for publisher in (joints, states, diagnostics):
        publisher.wait_for_all_acked(Duration(seconds=10))
    print("published", flush=True)
    # A reader's queue outlives the writer only if the reader has matched: stay until told.
    sys.stdin.readline()
    node.destroy_node()
    rclpy.try_shutdown()


if __name__ == "__main__":
    main()
