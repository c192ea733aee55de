"""Where joints were to be is understood, whoever said it and on whatever clock."""

from __future__ import annotations

import array
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from flexsim.bag import Bag, BagWriter
from flexsim.bag.robot import JOINTS
from flexsim.bag_report import motion, tracking
from flexsim.bag_report.reading import Reading
from made_bags import Topics, at, joint_state, stamp
from numpy.typing import NDArray
from rclpy.serialization import serialize_message
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

pytestmark = pytest.mark.ros

NAMES = ["joint_1", "joint_2"]
LAG = np.array([0.02, -0.01])
RATE, DURATION = 500, 4.0
# Simulated time goes half as fast as the wall's clock, and began earlier.
PACE, EARLIER = 0.5, 7.0
CONTROLLER = """std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint reference
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: builtin_interfaces/Duration
int32 sec
uint32 nanosec
================================================================================
MSG: trajectory_msgs/JointTrajectoryPoint
float64[] positions
float64[] velocities
float64[] accelerations
float64[] effort
builtin_interfaces/Duration time_from_start
"""


def wanted(t: NDArray | float) -> NDArray:
    """Where the joints are to be at simulated time t: (2,) or (K, 2)."""
    return np.stack([np.sin(np.asarray(t)), 0.5 * np.cos(2.0 * np.asarray(t))], axis=-1)


def by_joint_states(into: Topics, t: float, log: float) -> None:
    """Positions as joint states, stamped, the joints in another order."""
    into.write("/reference", joint_state(t, NAMES[::-1], wanted(t)[::-1], [], []), log, 0, JOINTS)


def by_unstamped(into: Topics, t: float, log: float) -> None:
    """The same, with the stamp of the wall's clock."""
    message = joint_state(1.7e9 + log, NAMES, wanted(t), [], [])
    into.write("/reference", message, log, 0, JOINTS)


def by_numbers(into: Topics, t: float, log: float) -> None:
    """Positions as plain numbers."""
    data = serialize_message(Float64MultiArray(data=array.array("d", wanted(t))))
    into.write("/position_controller/commands", data, log, 0, tracking.SETPOINTS)


STORE = get_typestore(Stores.EMPTY)
STORE.register(get_types_from_msg(CONTROLLER, tracking.CONTROLLER))


def by_controller(into: Topics, t: float, log: float) -> None:
    """A joint trajectory controller's state, of a type that is not installed here."""
    types, none = STORE.types, np.empty(0)
    time = types["builtin_interfaces/msg/Time"](stamp(t).sec, stamp(t).nanosec)
    header = types["std_msgs/msg/Header"](time, "")
    zero = types["builtin_interfaces/msg/Duration"](0, 0)
    point = types["trajectory_msgs/msg/JointTrajectoryPoint"](wanted(t), none, none, none, zero)
    state = types[tracking.CONTROLLER](header, NAMES, point)
    data = bytes(STORE.serialize_cdr(state, tracking.CONTROLLER))
    if not hasattr(into, "controller"):
        into.controller = into.bag.add_topic(
            "/controller_state", tracking.CONTROLLER, schema=CONTROLLER, hash=""
        )
    into.bag.write(into.controller, data, at(log))


def by_trajectory(into: Topics, t: float, log: float) -> None:
    """One trajectory at the beginning, without a stamp: it counts from when it came."""
    if log > 0.0:
        return
    way = JointTrajectory(joint_names=NAMES)
    for s in np.linspace(0.0, PACE * DURATION, 41):
        point = JointTrajectoryPoint(positions=list(wanted(EARLIER + s)))
        point.velocities = [float(np.cos(EARLIER + s)), float(-np.sin(2.0 * (EARLIER + s)))]
        point.time_from_start.sec, point.time_from_start.nanosec = int(s), round(s % 1.0 * 1e9)
        way.points.append(point)
    into.write("/joint_trajectory", serialize_message(way), log, 0, tracking.TRAJECTORY)


@pytest.mark.parametrize(
    "say", [by_joint_states, by_unstamped, by_numbers, by_controller, by_trajectory], ids=lambda f: f.__name__
)
def test_who_says_what_is_wanted(tmp_path: Path, say: Callable[[Topics, float, float], None]) -> None:
    """Each way of saying it gives the same error, and only for as long as it is said."""
    with BagWriter(tmp_path / "run") as bag:
        into = Topics(bag)
        for k in range(round(DURATION * RATE)):
            log = k / RATE
            t = EARLIER + PACE * log
            say(into, t, log)
            into.write("/joint_states", joint_state(t, NAMES, wanted(t) - LAG, [0.0, 0.0], []), log)
    bag = Bag(tmp_path / "run")
    measured = motion.joints(Reading(bag), "/joint_states")
    assert measured.series.stamped
    found = tracking.wanted(Reading(bag), measured)
    assert found is not None
    for error, lag in zip(tracking.errors(found, measured), LAG, strict=True):
        assert error.rms == pytest.approx(abs(lag), abs=2e-5)
        assert error.largest == pytest.approx(abs(lag), abs=2e-3)
        assert error.last == pytest.approx(-lag, abs=2e-5)


def test_nobody_says_and_time_begins_anew(tmp_path: Path) -> None:
    """Nothing is claimed to be wanted; of two runs the longer is taken, and that is said."""
    with BagWriter(tmp_path / "run") as bag:
        into = Topics(bag)
        for k in range(900):
            t = (k if k < 300 else k - 300) / RATE
            into.write("/joint_states", joint_state(t, NAMES, wanted(t), [0.0, 0.0], []), k / RATE)
    bag = Bag(tmp_path / "run")
    measured = motion.joints(Reading(bag), "/joint_states")
    assert len(measured.series.time) == 600
    assert "set back 1 times" in measured.series.notes[0]
    np.testing.assert_allclose(measured.position, wanted(np.arange(600) / RATE), atol=1e-12)
    assert tracking.wanted(Reading(bag), measured) is None
