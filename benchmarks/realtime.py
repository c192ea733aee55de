"""How well flexsim_node keeps time: `python benchmarks/realtime.py [--duration 60] [--controller] [--json]`.

The node steps the anthropomorphic robot with geared motors at --rate, 1 kHz; with --controller a process of
its own answers every state.  Fifty times a second a command is sent to it, and fifty times a second one to a
bare rclpy node that answers at once: the latency of both is the time from before the call that sends to the
arrival of the answer, as the middleware notes it.

On a virtual machine the host takes the processors away at times, for milliseconds, and nobody keeps a
deadline then.  Linux counts some of that time.  So on each processor a bare loop runs besides, of higher
priority than anything of the node's, which wakes up a thousand times a second and does nothing: where it is
late, the processor was not there.  The overruns of the seconds in which neither happened are the node's own.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import signal
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from flexsim.terminal.own_output import own_output
from flexsim.terminal.stop import stopped_by_signals
from flexsim.trial.processes import NODE, Process, own_domain, processes
from numpy.typing import NDArray

from flexsim_node.service.pace import go_first, sleep_finely

SCENE = Path(__file__).resolve().parent.parent / "config" / "anthropomorphic_geared.yaml"
DIAGNOSED = 10.0  # s, within which diagnostics come, which are said once a second
PERIOD = 0.02  # s between commands
STARTED = 180.0
# ns: how often a bare loop wakes up, how late it notices, and before which of a node's threads it goes.
BARE_PERIOD, BARE_LATE, BARE_PRIORITY = 1_000_000, 500_000, 80
PACKAGES = ("numpy", "numba", "ros-jazzy-rclpy", "ros-jazzy-rmw-fastrtps-cpp")


def echo() -> None:
    """Answer each command with a joint state, and do nothing else."""
    import rclpy
    from rclpy.executors import ExternalShutdownException
    from rclpy.experimental import EventsExecutor
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Float64MultiArray

    rclpy.init()
    node = rclpy.create_node("echo")
    answers = node.create_publisher(JointState, "~/joint_states", 10)

    def answer(command: Float64MultiArray) -> None:
        answers.publish(JointState(position=command.data, velocity=command.data, effort=command.data))

    node.create_subscription(Float64MultiArray, "~/commands", answer, 10)
    executor = EventsExecutor()
    executor.add_node(node)
    print("ready", file=sys.stderr, flush=True)
    try:
        while rclpy.ok():
            executor.spin_once(timeout_sec=0.1)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass


def bare(processor: int) -> None:
    """Wake up on one processor a thousand times a second, and say when that was late, and by how much, ns."""
    os.sched_setaffinity(0, {processor})
    sleep_finely()
    go_first(BARE_PRIORITY)
    stop: list[int] = []
    signal.signal(signal.SIGINT, lambda *_: stop.append(1))
    print("ready", file=sys.stderr, flush=True)
    due = time.monotonic_ns()
    while not stop:
        due += BARE_PERIOD
        time.sleep(max(0, due - time.monotonic_ns()) * 1e-9)
        now = time.monotonic_ns()
        if now - due > BARE_LATE:
            print(now, now - due, flush=True)
            due = now


def lates(process: Process) -> NDArray[np.int64]:
    """Return what a bare loop said: (K, 2) when, and by how much, ns."""
    return np.array(process.output.read_text().split(), dtype=np.int64).reshape(-1, 2)


class Probe:
    """Sends commands to one node and looks for them in its answers."""

    def __init__(self, node: Any, name: str, states: str) -> None:
        from rclpy.qos import QoSProfile
        from sensor_msgs.msg import JointState
        from std_msgs.msg import Float64MultiArray

        self.kind, self.command = JointState, Float64MultiArray
        self.commands = node.create_publisher(Float64MultiArray, f"{name}/commands", 10)
        self.states = node.create_subscription(JointState, states, lambda _: None, QoSProfile(depth=2000))
        self.sent: dict[float, int] = {}
        self.latency: list[int] = []
        self.stamps: list[tuple[int, int]] = []

    def send(self, number: int) -> None:
        """Send a command that can be told from all others."""
        value = 1e-9 * (number + 1)
        self.sent[value] = time.time_ns()
        self.commands.publish(self.command(data=[value, 0.0, 0.0]))

    def take(self) -> None:
        """Look at what has come in."""
        with self.states.handle:
            while (taken := self.states.handle.take_message(self.kind, False)) is not None:
                message, about = taken
                stamp = message.header.stamp
                arrival = about["received_timestamp"]
                self.stamps.append((stamp.sec * 10**9 + stamp.nanosec, arrival))
                begun = self.sent.pop(message.effort[0], None)
                if begun is not None:
                    self.latency.append(arrival - begun)


class Seconds:
    """Ticks and overruns between a node's diagnostics, and what the host took away meanwhile."""

    def __init__(self, node: Any) -> None:
        from diagnostic_msgs.msg import DiagnosticArray

        self.kind = DiagnosticArray
        self.heard = node.create_subscription(DiagnosticArray, "/diagnostics", lambda _: None, 10)
        self.rows: list[tuple[int, int, int, int]] = []

    def take(self) -> None:
        """Look at what has come in."""
        with self.heard.handle:
            while (taken := self.heard.handle.take_message(self.kind, False)) is not None:
                said = {p.key: p.value for status in taken[0].status for p in status.values}
                counts = int(said["ticks"]), int(said["overruns"]), stolen()
                self.rows.append((time.monotonic_ns(), *counts))

    def found(self, late: NDArray[np.int64]) -> dict[str, Any]:
        """All of them, and those in which both processors were there; `late`: when a bare loop was."""
        rows = np.array(self.rows).reshape(-1, 4)[1:]  # past the start
        end, begin = rows[1:, 0], rows[:-1, 0]
        rows = np.diff(rows, axis=0)
        # What is missed in one second may be counted in the next, and so may the time that was stolen.
        missed = np.searchsorted(late[:, 0], end) > np.searchsorted(late[:, 0], begin)
        missed |= rows[:, 3] > 0
        quiet = ~missed & ~np.append(False, missed[:-1])
        rows = rows[:, 1:]
        return {
            "stolen": float(rows[:, 2].sum()) / os.sysconf("SC_CLK_TCK"),
            "bare_loop_late": len(late),
            "bare_loop_worst": float(late[:, 1].max(initial=0)) * 1e-9,
            "seconds": len(rows),
            "undisturbed_seconds": int(quiet.sum()),
            "undisturbed_ticks": int(rows[quiet, 0].sum()),
            "undisturbed_overruns": int(rows[quiet, 1].sum()),
        }


def stolen() -> int:
    """Return the processor time that the host took away since the start, clock ticks of all cores."""
    return int(Path("/proc/stat").read_text().split(maxsplit=9)[8])


def measure(duration: float, rate: float, *, controlled: bool = False) -> dict[str, Any]:
    """Run node and echo side by side; `rate`, Hz, of the node's steps and states."""
    environment = own_domain()
    os.environ.update(ROS_DOMAIN_ID=environment["ROS_DOMAIN_ID"])
    from flexsim.ros.context import tool_node

    with (
        tempfile.TemporaryDirectory() as folder,
        stopped_by_signals() as stopped,
        processes(Path(folder), environment, stopped) as trial,
    ):
        parameters = ["--ros-args", "-p", f"scene:={SCENE}", "-p", f"rate:={rate}"]
        parameters += ["-p", "wait_for_command:=true"]
        robot = trial.start("flexsim_node", [*NODE, *parameters])
        other = trial.start("echo", [sys.executable, __file__, "--echo"])
        trial.wait_until_said(robot, "kernels ready", timeout=STARTED)
        if controlled:
            third = trial.start("controller", [sys.executable, __file__, "--controller-process"])
            trial.wait_until_said(third, "ready", timeout=STARTED)
        loops = [
            trial.start(f"bare_{k}", [sys.executable, __file__, "--bare", str(k)])
            for k in sorted(os.sched_getaffinity(0))
        ]
        trial.wait_until_said(other, "ready", timeout=STARTED)
        with tool_node("realtime_benchmark") as node:
            ours = Probe(node, "flexsim_node", "joint_states")
            bare = Probe(node, "echo", "echo/joint_states")
            seconds = Seconds(node)
            while not (ours.commands.get_subscription_count() and bare.commands.get_subscription_count()):
                trial.check()
                time.sleep(0.1)
            begun = time.monotonic()
            number, due, chance = 0, 0.0, np.random.default_rng(1)
            while time.monotonic() - begun < duration:
                trial.check()
                if time.monotonic() - begun > due:
                    (bare if number % 2 else ours).send(number)
                    number += 1
                    # At any time of a tick, since how long a command waits depends on that.
                    due = number * PERIOD / 2.0 + chance.uniform(0.0, 1.0 / rate)
                time.sleep(2e-4)
                ours.take()
                bare.take()
                seconds.take()
            memory = status(robot.pid)
            said = last_diagnostics(node)
        if said["status"] != "ok":
            raise RuntimeError(f"the solver has stopped: {said['status']}")
        if controlled:
            trial.dismiss(third)
        for process in (robot, other, *loops):
            trial.end(process)
        late = np.concatenate([lates(process) for process in loops])
        late = late[np.argsort(late[:, 0])]
    stamps = np.array([s for s in ours.stamps if s[0] > 1])
    second = int(np.searchsorted(stamps[:, 0], 10**9))  # past the start
    simulated, elapsed = stamps[-1] - stamps[second]
    return {
        "duration": duration,
        "rate": rate,
        "real_time_factor": float(simulated / elapsed),
        "ticks": int(said["ticks"]),
        "overruns": int(said["overruns"]),
        "overruns_part": int(said["overruns"]) / max(1, int(said["ticks"])),
        "overruns_in_a_row": int(said["overruns in a row, worst"]),
        **seconds.found(late),
        "commands": int(said["accepted"]),
        "lost_time": float(said["lost time, s"]),
        "real_time_priority": said["real-time priority"],
        **{f"{k} p99": 1e-6 * float(said[f"{k} p99, µs"])
           for k in ("step time", "tick time", "lateness")},
        "step time p50": 1e-6 * float(said["step time p50, µs"]),
        "step time worst": 1e-6 * float(said["step time worst, µs"]),
        "lateness worst": 1e-6 * float(said["lateness worst, µs"]),
        "latency": quantiles(ours.latency),
        "echo_latency": quantiles(bare.latency),
        "latency_over_echo": {
            k: quantiles(ours.latency)[k] / quantiles(bare.latency)[k] for k in ("p50", "p99")
        },
        "memory": memory["VmRSS"],
        "memory_peak": memory["VmHWM"],
        "machine": machine(),
    }  # fmt: skip


def controller() -> None:
    """Answer each state with a torque on the other topic.

    By name, and not on the joint whose torque marks the commands of the benchmark.
    """
    import rclpy
    from rclpy.executors import ExternalShutdownException
    from rclpy.experimental import EventsExecutor
    from sensor_msgs.msg import JointState

    rclpy.init()
    node = rclpy.create_node("controller")
    commands = node.create_publisher(JointState, "robot_joint_commands", 10)

    def answer(state: JointState) -> None:
        effort = [-2.0 * v - 5.0 * q for q, v in zip(state.position[1:], state.velocity[1:], strict=True)]
        commands.publish(JointState(name=state.name[1:], effort=effort))

    node.create_subscription(JointState, "joint_states", answer, 1)
    executor = EventsExecutor()
    executor.add_node(node)
    print("ready", file=sys.stderr, flush=True)
    try:
        while rclpy.ok():
            executor.spin_once(timeout_sec=0.1)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass


def quantiles(latency: list[int]) -> dict[str, float]:
    """Return p50 and p99, s."""
    p50, p99 = np.quantile(np.array(latency) * 1e-9, [0.5, 0.99])
    return {"samples": len(latency), "p50": float(p50), "p99": float(p99)}


def last_diagnostics(node: Any) -> dict[str, str]:
    """Wait for the next diagnostics and return their values; raises TimeoutError where none come."""
    from diagnostic_msgs.msg import DiagnosticArray

    heard = node.create_subscription(DiagnosticArray, "/diagnostics", lambda _: None, 10)
    end = time.monotonic() + DIAGNOSED
    while time.monotonic() < end:
        with heard.handle:
            taken = heard.handle.take_message(DiagnosticArray, False)
        if taken is not None:
            return {p.key: p.value for status in taken[0].status for p in status.values}
        time.sleep(0.05)
    raise TimeoutError(f"no diagnostics came within {DIAGNOSED:g} s")


def status(pid: int) -> dict[str, int]:
    """Return a process's memory, bytes."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    words = [line.replace(":", " ").split() for line in lines]
    return {w[0]: 1024 * int(w[1]) for w in words if w[0] in ("VmRSS", "VmHWM")}


def machine() -> dict[str, str]:
    """Return what the figures were measured on."""
    info = Path("/proc/cpuinfo").read_text().splitlines()
    names = [line.partition(":")[2].strip() for line in info if line.startswith("model name")]
    return {
        "processor": f"{names[0] if names else platform.machine()}, {os.cpu_count()} cores",
        "load": " ".join(f"{x:.1f}" for x in os.getloadavg()),
        "system": f"{platform.system()} {platform.release()}, Python {platform.python_version()}",
        **{name: version(name) for name in PACKAGES},
    }


def main() -> None:
    """Measure and print."""
    own_output()
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--duration", type=float, default=60.0, help="s")
    parser.add_argument("--rate", type=float, default=1000.0, help="Hz, of steps and states")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument("--controller", action="store_true", help="with a controller that answers each state")
    parser.add_argument("--controller-process", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--echo", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--bare", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.echo:
        return echo()
    if arguments.bare is not None:
        return bare(arguments.bare)
    if arguments.controller_process:
        return controller()
    found = measure(arguments.duration, arguments.rate, controlled=arguments.controller)
    if arguments.json:
        print(json.dumps(found, indent=2))
        return
    for name, value in found.pop("machine").items():
        print(f"{name:28} {value}")
    for name, value in found.items():
        if name == "latency_over_echo":
            value = f"p50 {value['p50']:.2f}, p99 {value['p99']:.2f}"
        elif isinstance(value, dict):
            value = f"p50 {1e6 * value['p50']:.0f} µs, p99 {1e6 * value['p99']:.0f} µs"
        elif "time p" in name or "time worst" in name or "lateness" in name or name == "bare_loop_worst":
            value = f"{1e6 * value:.1f} µs"
        elif name == "stolen":
            value = f"{value:.2f} s of processor time, by the host"
        elif "memory" in name:
            value = f"{value / 1e6:.0f} MB"
        print(f"{name.replace('_', ' '):28} {value}")


if __name__ == "__main__":
    main()
