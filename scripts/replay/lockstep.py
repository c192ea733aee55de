"""Drives flexsim_node through a recorded run in lock-step: a torque, a state, a torque, ..."""

from __future__ import annotations

import array
import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..ros.simulator import SimulatorWatch
from ..terminal.child import ending, start_child
from ..terminal.stop import Stop
from .drive import FIRST, SECOND, Drive

if TYPE_CHECKING:
    from rclpy.node import Node

NODE = "flexsim_node"
STATES, COMMANDS = "/joint_states", f"/{NODE}/commands"
# The kernels may have to be compiled first.
START_TIMEOUT = 240.0
ANSWER_TIMEOUT = 30.0
END_TIMEOUT = 10.0
POLL_PERIOD = 0.02


class Stopped(RuntimeError):
    """The simulator stopped before the recorded run did."""


@contextmanager
def node_process(
    parameters: dict[str, Any], folder: Path, stopped: Stop
) -> Iterator[subprocess.Popen[bytes]]:
    """Run flexsim_node with these parameters, its log in `folder`, and end it afterwards."""
    file = folder / "parameters.yaml"
    # JSON is YAML; numbers keep all of their digits.
    file.write_text(json.dumps({NODE: {"ros__parameters": parameters}}), encoding="utf-8")
    log = folder / "flexsim_node.log"
    with log.open("wb") as errors:
        words = [sys.executable, "-m", f"{NODE}.node", "--ros-args", "--params-file", str(file)]
        child = start_child(words, errors, errors)
    try:
        end = time.monotonic() + START_TIMEOUT
        while b"kernels ready" not in log.read_bytes():
            if stopped.asked:
                raise KeyboardInterrupt
            if child.poll() is not None:
                said = log.read_text(errors="replace").strip().splitlines()
                raise RuntimeError(f"{NODE} {ending(child.returncode)}{': ' + said[-1] if said else ''}")
            if time.monotonic() > end:
                raise RuntimeError(f"{NODE} was not ready within {START_TIMEOUT:.0f} s")
            time.sleep(POLL_PERIOD)
        yield child
    finally:
        if child.poll() is None:
            child.send_signal(signal.SIGINT)
            child.send_signal(signal.SIGCONT)  # what a signal has stopped hears no other
            try:
                child.wait(END_TIMEOUT)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()


class Driver:
    """Sends torques and waits for the state that each of them leads to.

    Parameters
    ----------
    node : rclpy.node.Node
    drive : Drive
    meanwhile : callable
        Called between steps about a hundred times a second: records, shows how it goes.
    simulator : Popen
        The process of flexsim_node.
    """

    def __init__(
        self,
        node: Node,
        drive: Drive,
        meanwhile: Callable[[int], None],
        simulator: subprocess.Popen[bytes],
    ) -> None:
        from rclpy.qos import QoSProfile
        from sensor_msgs.msg import JointState
        from std_msgs.msg import Float64MultiArray

        self.drive = drive
        self.meanwhile = meanwhile
        self._state, self._command = JointState, Float64MultiArray
        self._states = node.create_subscription(JointState, STATES, lambda _: None, QoSProfile(depth=100))
        self._commands = node.create_publisher(Float64MultiArray, COMMANDS, QoSProfile(depth=10))
        self._next = 0.0
        self._watch = SimulatorWatch(node, NODE, simulator)
        self._resets = 0  # when the run began

    def connect(self, stopped: Stop, ready: Callable[[], bool]) -> None:
        """Wait for the robot to stand ready at its beginning, and for whoever else listens."""
        end = time.monotonic() + ANSWER_TIMEOUT
        seen: int | None = None
        while (
            seen is None
            or self._watch.status is None
            or self._commands.get_subscription_count() == 0
            or not ready()
        ):
            self._meanwhile(0)
            taken = self._take()
            seen = seen if taken is None else taken
            if seen is not None and seen > FIRST:
                raise RuntimeError(
                    f"a robot is running already, and is at {seen / SECOND:g} s; "
                    "end it, or choose another ROS_DOMAIN_ID"
                )
            if stopped.asked:
                raise KeyboardInterrupt
            if gone := self._watch.gone:
                raise RuntimeError(gone)
            if time.monotonic() > end:
                whole = "" if seen is None else "wholly "
                raise RuntimeError(f"{NODE} is not {whole}to be heard within {ANSWER_TIMEOUT:.0f} s")
            time.sleep(0.005)
        self._resets = self._watch.status.resets

    def run(self, stopped: Stop) -> int:
        """Go through the run; returns how many periods were driven."""
        step = self.drive.period
        slack = len(self.drive.torque)  # stamps are rounded to ns
        for k, torque in enumerate(self.drive.torque):
            self._commands.publish(self._command(data=array.array("d", torque.tobytes())))
            self._wait((k + 1) * step - slack, k, stopped)
        return len(self.drive.torque)

    def _wait(self, time_of_state: int, k: int, stopped: Stop) -> None:
        begun = time.monotonic()
        waited = 0
        while True:
            seen = self._take()
            if seen is not None and seen >= time_of_state:
                return
            waited += 1
            if waited > 20:
                time.sleep(2e-5)
            now = time.monotonic()
            if now >= self._next:
                self._meanwhile(k)
                if stopped.asked:
                    raise KeyboardInterrupt
                if trouble := self._trouble():
                    raise Stopped(trouble)
                if now - begun > ANSWER_TIMEOUT:
                    raise Stopped(f"no state came for {ANSWER_TIMEOUT:.0f} s")

    def _trouble(self) -> str:
        """Why no state is to be expected, or nothing."""
        status = self._watch.status
        if (trouble := self._watch.gone or self._watch.trouble) or status is None:
            return trouble
        if status.resets != self._resets:
            return f"somebody has reset {NODE}"
        if status.phase == "paused":
            return f"somebody has paused {NODE} at {status.time:.6g} s"
        return ""

    def _meanwhile(self, k: int) -> None:
        self._next = time.monotonic() + 0.01
        self._watch.poll()
        self.meanwhile(k)

    def _take(self) -> int | None:
        """Return the time, ns, of the newest state that came in, if one has."""
        with self._states.handle:
            newest = None
            while (taken := self._states.handle.take_message(self._state, False)) is not None:
                newest = taken[0]
        if newest is None:
            return None
        return int(newest.header.stamp.sec) * SECOND + int(newest.header.stamp.nanosec)
