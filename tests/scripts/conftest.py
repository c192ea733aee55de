"""A recorded run that the tests of bags and views share."""

from __future__ import annotations

import signal

import pytest
from processes import Background, Recorded, command, ros_environment, synthetic_robot

MESSAGES, RATE = 600, 500.0


@pytest.fixture(scope="session")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Recorded:
    """Record a synthetic robot from beginning to end, and stop with Ctrl-C."""
    folder = tmp_path_factory.mktemp("recorded")
    environment = ros_environment()
    bag = folder / "run"
    recorder = Background(command("record", "-o", bag, "--json"), environment, folder)
    robot = synthetic_robot(environment, folder, MESSAGES, RATE)
    robot.wait_for("published")
    # All is acknowledged, so it lies in the recorder's queues; the end of a recording drains them.
    assert recorder.end(signal.SIGINT) == 0, recorder.errors.read_text()
    robot.release()
    return Recorded(bag, recorder.output.read_text(), MESSAGES, RATE)
