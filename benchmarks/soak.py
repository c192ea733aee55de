"""A soak: `python benchmarks/soak.py [--fast 3600] [--realtime 3600] [--json]`, seconds of each.

flexsim_node runs without a pause, then in real time with a recorder.  The arm hangs, with friction, and is
rocked by torques that do not look at it: no controller keeps up with simulated time without a pause, nor on a
machine that is busy for an hour.  Where the solver stops, the soak does, with exit code 1.
Memory is that of the node's process a minute after it began and at the end; the clock's error is simulated
minus elapsed time, beyond what diagnostics call lost, and without a pause simulated time minus that of its
steps.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
from flexsim.bag import Bag
from flexsim.terminal.own_output import own_output
from flexsim.terminal.stop import Stop, stopped_by_signals
from flexsim.trial.processes import COMMAND, NODE, Process, Processes, own_domain, processes

sys.path.insert(0, str(Path(__file__).resolve().parent))
from realtime import last_diagnostics, machine, status

SCENE = Path(__file__).resolve().parent.parent / "config" / "anthropomorphic_geared.yaml"
STARTED, SETTLED = 240.0, 60.0
CONTROL_PERIOD = 0.01  # s
RATE = 1000.0  # ticks a second
HANGING = {
    "override.initial.position": "[0.0, -1.5, 0.0]",
    **{f"override.links.link_{k}.joint.viscous_friction": 1.0 for k in (1, 2, 3)},
}


class Arm:
    """Keeps the arm moving, and notes simulated against steady time."""

    def __init__(self, node: Any, mode: str) -> None:
        from rclpy.qos import QoSProfile
        from sensor_msgs.msg import JointState
        from std_msgs.msg import Float64MultiArray

        self.kind, self.command = JointState, Float64MultiArray
        self.commands = node.create_publisher(Float64MultiArray, "flexsim_node/commands", 10)
        self.states = node.create_subscription(
            JointState, "joint_states", lambda _: None, QoSProfile(depth=1)
        )
        self.paced = mode == "realtime"
        self.times: list[tuple[int, int]] = []
        self.finite = True

    def rock(self) -> None:
        """Look at the latest state, and send a torque."""
        with self.states.handle:
            taken = self.states.handle.take_message(self.kind, False)
        if taken is None:
            return
        message, about = taken
        time_now = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
        self.times.append((time_now, about["received_timestamp"]))
        if len(self.times) > 200_000:
            del self.times[1:-100_000]
        q, v = np.array(message.position), np.array(message.velocity)
        self.finite &= bool(np.isfinite([*q, *v]).all())
        torque = 2.0 * np.sin(np.array([0.7, 1.1, 0.9]) * time.monotonic())
        self.commands.publish(self.command(data=torque.tolist()))


def soak(mode: str, duration: float, stopped: Stop, *, record: bool) -> dict[str, Any]:
    """Run one node for so many seconds of elapsed time."""
    from flexsim.ros.context import tool_node

    environment = own_domain()
    os.environ.update(ROS_DOMAIN_ID=environment["ROS_DOMAIN_ID"])
    with tempfile.TemporaryDirectory() as folder, processes(Path(folder), environment, stopped) as trial:
        recorder: Process | None = None
        bag = Path(folder) / "bag"
        if record:
            recorder = trial.start("recorder", [*COMMAND, "record", "-o", str(bag), "--json"])
        given = {"scene": SCENE, "mode": mode, **HANGING}
        pairs = [word for name, value in given.items() for word in ("-p", f"{name}:={value}")]
        robot = trial.start("flexsim_node", [*NODE, "--ros-args", *pairs])
        trial.wait_until_said(robot, "kernels ready", timeout=STARTED)
        with tool_node("soak") as node:
            found = watch(Arm(node, mode), node, trial, robot, recorder, duration)
        trial.end(robot)
        if recorder is not None:
            trial.end(recorder)
            whole = Bag(bag)
            found["bag_messages"] = whole.count
            found["bag_bytes"] = sum(f.stat().st_size for f in bag.iterdir())
    return {"mode": mode, **found}


def watch(
    arm: Arm, node: Any, trial: Processes, robot: Process, recorder: Process | None, duration: float
) -> dict[str, Any]:
    """Rock the arm and look at the processes."""
    memory: list[tuple[float, int, int]] = []
    begun = time.monotonic()
    look = begun + min(SETTLED, 0.2 * duration)
    while (now := time.monotonic()) - begun < duration:
        trial.check()
        arm.rock()
        if now >= look:
            look += max(1.0, duration / 100.0)
            unstopped(last_diagnostics(node))
            other = status(recorder.pid)["VmRSS"] if recorder else 0
            memory.append((now - begun, status(robot.pid)["VmRSS"], other))
        time.sleep(CONTROL_PERIOD)
    said = unstopped(last_diagnostics(node))
    elapsed = time.monotonic() - begun
    times = np.array(arm.times)
    simulated = (times[-1, 0] - times[0, 0]) * 1e-9
    wall = (times[-1, 1] - times[0, 1]) * 1e-9
    lost = float(said["lost time, s"])
    return {
        "elapsed": elapsed,
        "simulated": float(said["simulated time, s"]),
        "ticks": int(said["ticks"]),
        "overruns": int(said["overruns"]),
        "longest_run_of_overruns": int(said["overruns in a row, worst"]),
        "lost_time": lost,
        "clock_error": float(
            simulated + lost - wall
            if arm.paced
            else float(said["simulated time, s"]) - int(said["ticks"]) / RATE
        ),
        "solver": said["status"],
        "all_finite": arm.finite,
        "memory_start": memory[0][1],
        "memory_end": memory[-1][1],
        **({"recorder_memory_start": memory[0][2], "recorder_memory_end": memory[-1][2]} if recorder else {}),
    }


def unstopped(said: dict[str, str]) -> dict[str, str]:
    """What diagnostics say, where the solver has not stopped."""
    if said["status"] != "ok":
        raise RuntimeError(f"the solver has stopped at {said['simulated time, s']} s: {said['status']}")
    return said


def main() -> None:
    """Run both and print."""
    own_output()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--fast", type=float, default=7200.0, help="s of elapsed time without a pause; 0: none"
    )
    parser.add_argument("--realtime", type=float, default=3600.0, help="s in real time with a bag; 0: none")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    arguments = parser.parse_args()
    found: dict[str, Any] = {"machine": machine()}
    with stopped_by_signals() as stopped:
        if arguments.fast:
            found["fast"] = soak("fast", arguments.fast, stopped, record=False)
        if arguments.realtime:
            found["realtime"] = soak("realtime", arguments.realtime, stopped, record=True)
    found["machine"]["load at the end"] = " ".join(f"{x:.1f}" for x in os.getloadavg())
    if arguments.json:
        print(json.dumps(found, indent=2))
        return
    for part, values in found.items():
        print(part)
        for name, value in values.items():
            print(
                f"  {name.replace('_', ' '):28} {value:.6g}"
                if isinstance(value, float)
                else f"  {name:28} {value}"
            )


if __name__ == "__main__":
    main()
