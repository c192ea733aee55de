"""In lockstep the motion depends on the commands alone: not on when they come, nor on who starts first."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from listening import PATIENCE
from processes import Background, ros_environment
from robot_process import Robot, words

pytestmark = pytest.mark.ros
CONTROLLER = Path(__file__).with_name("plain_controller.py")
PERIODS = 150
PARAMETERS = {
    "mode": "lockstep",
    "rate": 500.0,
    "elastic_rate": 500.0,
    "shape_rate": 500.0,
    "clock_rate": 500.0,
    "override.initial.position": "[0.3, 0.8, -0.6]",
    **{f"override.links.link_{k}.joint.rotor_inertia": 0.5 for k in (1, 2, 3)},
    "faults": "'[{kind: delay, time: 0.004}, {kind: noise, signal: position, deviation: 1.0e-5}]'",
}


def controller(environment: dict[str, str], folder: Path, slow: float = 0.0) -> Background:
    """Start the controller."""
    return Background([sys.executable, str(CONTROLLER), str(slow)], environment, folder)


@contextmanager
def motion(folder: Path, slow: float = 0.0, first: str = "robot") -> Iterator[tuple[Robot, Background]]:
    """Run a robot and its controller, one after the other."""
    environment = ros_environment()
    started = [controller(environment, folder, slow)] if first == "controller" else []
    if started:
        time.sleep(3.0)
    node = Background(words(**PARAMETERS), environment, folder)
    arm = Robot(node, int(environment["ROS_DOMAIN_ID"]))
    try:
        if not started:
            # Who listens is to hear the very first state too: the controller comes once it was shown.
            arm.until(arm.states, PATIENCE)
            started.append(controller(environment, folder, slow))
        yield arm, started[0]
    finally:
        for process in (*started, node):
            if process.process.poll() is None:
                process.process.send_signal(signal.SIGCONT)
            process.end(signal.SIGTERM)
        arm.close()


def trajectory(arm: Robot) -> np.ndarray:
    """The first periods' stamps, positions, velocities and torques, each state once."""
    arm.until(lambda: arm.states() and arm.time() >= PERIODS * 2e-3, 120.0)
    rows = {}
    for m in arm.states():
        stamp = m.header.stamp.sec * 10**9 + m.header.stamp.nanosec
        row = np.array([stamp, *m.position, *m.velocity, *m.effort])
        np.testing.assert_array_equal(rows.setdefault(stamp, row), row)
    return np.array([rows[s] for s in sorted(rows) if s <= PERIODS * 2_000_000])


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory) -> np.ndarray:
    """The motion with a controller that is quick."""
    with motion(tmp_path_factory.mktemp("undisturbed")) as (arm, _):
        found = trajectory(arm)
        assert len(found) == PERIODS + 1
        ticks = [m.clock.sec * 10**9 + m.clock.nanosec for m in arm.heard["/clock"]]
        assert ticks == sorted(ticks)
        assert ticks[0] > 0
    return found


def test_slowed(undisturbed: np.ndarray, tmp_path: Path) -> None:
    """A controller that thinks for 0.3 s, also over its very first command."""
    with motion(tmp_path, slow=0.3) as (arm, _):
        np.testing.assert_array_equal(trajectory(arm), undisturbed)


def test_stopped_on_a_loaded_machine_and_started_first(undisturbed: np.ndarray, tmp_path: Path) -> None:
    """SIGSTOP for a second for either of the two, while others take the processors."""
    load = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(os.cpu_count() or 1)]
    try:
        with motion(tmp_path, first="controller") as (arm, other):
            for process in (other.process, arm.process.process):
                arm.until(lambda: arm.states() and arm.time() > 2e-3)
                process.send_signal(signal.SIGSTOP)
                time.sleep(1.0)
                process.send_signal(signal.SIGCONT)
            # The controller may have been heard before who listens here: what he missed is at the beginning.
            found = trajectory(arm)
            assert len(found) > PERIODS // 2
            np.testing.assert_array_equal(found, undisturbed[-len(found) :])
    finally:
        for process in load:
            process.kill()
            process.wait()
