"""A node's process ends when a signal asks it to, also while the node is still being built."""

import subprocess
import sys

import pytest
from processes import ros_environment

pytestmark = pytest.mark.ros

SWALLOWS = """
import os, signal
from flexsim_ros import run_node

def build():
    try:
        os.kill(os.getpid(), signal.{signal})
        raise RuntimeError("the signal did not come")
    except KeyboardInterrupt:
        pass  # as compiled code may, in the middle of which it comes

def run(node, asked):
    print("it ran on")
    return 3

raise SystemExit(run_node("node", build, run, {{}}))
"""


@pytest.mark.parametrize("signal", ["SIGINT", "SIGTERM"])
def test_a_signal_that_building_swallows(signal: str) -> None:
    """It is remembered, and the node does not run."""
    done = subprocess.run(
        [sys.executable, "-c", SWALLOWS.format(signal=signal)],
        env=ros_environment(), capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
