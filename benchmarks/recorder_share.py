"""What share of a core the recorder takes: `python benchmarks/recorder_share.py [--seconds 30] [--json]`.

One process publishes what a busy day has: 1 kHz joint states of seven joints, 1 kHz elastic states of 60
nodes, 10 Hz temperature fields of 20,000 values.  `flexsim record` beside it records all of it.  Its share
is the processor time that it took from the first message on, over elapsed time.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import random
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from bag_conversion import COMMAND, JOINTS, NODES, SECOND, Cdr, elastic_state, joint_state
from flexsim.terminal.own_output import own_output

RATE, FIELD_RATE, FIELD = 1000, 10, 20_000
READY = 30.0  # s
PATTERNS = 200  # different messages, over and over: the publisher is not what is measured


def publish(seconds: float) -> None:
    """Publish at the steady clock's pace, once somebody listens to all three topics."""
    import rclpy
    from flexsim_msgs.msg import ElasticState, TemperatureField
    from rclpy.qos import QoSProfile
    from sensor_msgs.msg import JointState

    noise = np.random.default_rng(0)
    joints, states = [], []
    for k in range(PATTERNS):
        q = np.sin(k / PATTERNS + np.arange(JOINTS)) + 1e-12 * noise.standard_normal(JOINTS)
        rigid = np.outer(np.linspace(0.0, 1.5, NODES), [np.cos(q[0]), np.sin(q[0]), 0.3])
        bent = 1e-3 * np.sin(k) * rigid + 1e-9 * noise.standard_normal(rigid.shape)
        stamp = 1 + k * SECOND // RATE
        joints.append(joint_state(stamp, q, 1.1 * q))
        states.append(elastic_state(stamp, np.hstack([bent, 0.5 * bent]), rigid + bent, rigid))
    warm = 20.0 + 900.0 * np.linspace(1.0, 0.0, FIELD) + 0.01 * noise.standard_normal(FIELD)
    field = bytes(Cdr().header(1, "leaf").array(warm).data)
    rclpy.init()
    node = rclpy.create_node("publisher")
    publishers = [
        node.create_publisher(JointState, "joint_states", QoSProfile(depth=1000)),
        node.create_publisher(ElasticState, "flexsim_node/elastic_state", QoSProfile(depth=1000)),
        node.create_publisher(TemperatureField, "door/temperature_field", QoSProfile(depth=50)),
    ]
    end = time.monotonic() + READY
    while any(p.get_subscription_count() == 0 for p in publishers) and time.monotonic() < end:
        time.sleep(0.02)
    print("begins", flush=True)
    begun = time.monotonic()
    for k in range(round(seconds * RATE)):
        wait = begun + k / RATE - time.monotonic()
        if wait > 0.0:
            time.sleep(wait)
        publishers[0].publish(joints[k % PATTERNS])
        publishers[1].publish(states[k % PATTERNS])
        if k % (RATE // FIELD_RATE) == 0:
            publishers[2].publish(field)
    print(f"published {time.monotonic() - begun:.3f}", flush=True)
    sys.stdin.readline()


def spent(pid: int) -> float:
    """Return the processor time of a process so far, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main() -> None:
    """Measure and print."""
    own_output()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--publish", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.publish:
        publish(given.seconds)
        return
    domain = str(random.SystemRandom().randint(1, 100))
    environment = os.environ | {"ROS_DOMAIN_ID": domain, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    with tempfile.TemporaryDirectory() as folder:
        words = [*COMMAND, "record", "-o", f"{folder}/bag", "--json"]
        recorder = subprocess.Popen(words, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        own = [sys.executable, __file__, "--publish", "--seconds", str(given.seconds)]
        publisher = subprocess.Popen(
            own, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        assert publisher.stdout is not None and publisher.stdin is not None
        publisher.stdout.readline()
        before, begun = spent(recorder.pid), time.monotonic()
        publisher.stdout.readline()
        used, elapsed = spent(recorder.pid) - before, time.monotonic() - begun
        time.sleep(0.5)
        recorder.send_signal(signal.SIGINT)
        said = json.loads(recorder.communicate(timeout=60)[0])
        publisher.stdin.close()
        publisher.wait(20)
    topics = said["topics"]
    messages = round(given.seconds * RATE)
    wanted = {
        "/joint_states": messages,
        "/flexsim_node/elastic_state": messages,
        "/door/temperature_field": -(-messages // (RATE // FIELD_RATE)),
    }
    found: dict[str, Any] = {
        "seconds": elapsed,
        "share_of_a_core": used / elapsed,
        "missing": {name: count - topics[name]["messages"] for name, count in wanted.items()},
        "bytes_a_second": sum(topics[name]["bytes"] for name in wanted) / elapsed,
        "cores": os.cpu_count(),
        "machine": platform.machine(),
    }
    if given.json:
        print(json.dumps(found, indent=2))
        return
    for key, value in found.items():
        print(f"{key:18} {value:.3f}" if isinstance(value, float) else f"{key:18} {value}")


if __name__ == "__main__":
    main()
