"""Where joints were to be, as far as a bag says: trajectories, setpoints, controllers' own states."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag, BagError
from ..bag.robot import joint_topics
from .motion import SECOND, Joints, read
from .reading import STAMP, Reading

Array = NDArray[np.float64]
TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
CONTROLLER = "control_msgs/msg/JointTrajectoryControllerState"
SETPOINTS = "std_msgs/msg/Float64MultiArray"
# Setpoints that come as quickly are points of a curve; slower ones hold until the next, s.
DENSE = 0.05


@dataclass(frozen=True)
class Wanted:
    """Where joints were to be: (K, m) rad or m at the measured joint states' times; NaN where not known."""

    topic: str
    kind: str
    position: Array


@dataclass(frozen=True)
class Error:
    """How far a joint was from where it was to be, rad or m."""

    joint: str
    rms: float
    largest: float
    at: float
    last: float


def fields(bag: Bag, measured: str) -> dict[str, list[str]]:
    """Return what `wanted` needs of a bag: fields by topic; measured: the joint states' topic."""
    kinds = {t.type for t in bag.topics.values() if t.count}
    if CONTROLLER in kinds:
        topic = next(t.name for t in bag.topics.values() if t.type == CONTROLLER and t.count)
        name = reference(bag, topic)
        return {topic: ["joint_names", name]} if name else {}
    if TRAJECTORY in kinds:  # they are few, and read one by one
        return {}
    found = {name: ["name", "position"] for name in wishes(bag, measured)}
    for t in bag.topics.values():
        if t.type == SETPOINTS and t.count and "position" in t.name:
            found[t.name] = ["data"]
    return found


def wishes(bag: Bag, measured: str) -> list[str]:
    """Return the topics of joint states that may say where the joints were to be."""
    # One that is named joint_states is what another robot did.
    there = joint_topics(bag)
    return [n for n in there if n != measured and n.rpartition("/")[2] != "joint_states"]


def reference(bag: Bag, topic: str) -> str | None:
    """Return the field in which a controller's state says where the joints were to be."""
    there = bag.fields(topic)
    return next((n for n in ("reference.positions", "desired.positions") if n in there), None)


def wanted(reading: Reading, measured: Joints) -> Wanted | None:
    """Return where the joints were to be; None where the bag does not say.

    Raises
    ------
    BagError
        What it says can't be understood.
    """
    if measured.position is None:
        return None
    bag = reading.bag
    for topic in bag.topics.values():
        if topic.type == CONTROLLER and topic.count:
            return by_controller(reading, topic.name, measured)
    for topic in bag.topics.values():
        if topic.type == TRAJECTORY and topic.count:
            return by_trajectory(bag, topic.name, measured)
    for name in wishes(bag, measured.series.topic):
        found = by_joint_states(reading, name, measured)
        if found is not None:
            return found
    for topic in bag.topics.values():
        if topic.type == SETPOINTS and topic.count and "position" in topic.name:
            return by_setpoints(reading, topic.name, measured)
    return None


def errors(found: Wanted, measured: Joints) -> list[Error]:
    """Return each joint's error, where it is known."""
    assert measured.position is not None
    result = []
    for k, name in enumerate(measured.names):
        off = measured.position[:, k] - found.position[:, k]
        known = np.flatnonzero(np.isfinite(off))
        if len(known):
            some = off[known]
            at = int(np.argmax(np.abs(some)))
            result.append(
                Error(
                    name,
                    float(np.sqrt(np.mean(some**2))),
                    float(abs(some[at])),
                    float(measured.series.time[known[at]]),
                    float(some[-1]),
                )
            )
    return result


def ordered(names: list[str], measured: Joints, topic: str) -> list[tuple[int, int]]:
    """Return pairs of places of a joint: in the measured ones and among `names`."""
    found = [(k, names.index(n)) for k, n in enumerate(measured.names) if n in names]
    if not found:
        raise BagError(f"{topic} names {', '.join(names)}; the robot has {', '.join(measured.names)}")
    return found


def placed(
    time: Array, values: Array, places: list[tuple[int, int]], measured: Joints, until: float = np.inf
) -> Array:
    """Return values (J, n) of times (J,) at the measured joints' times: (K, m), NaN outside."""
    at = measured.series.time
    result = np.full((len(at), len(measured.names)), np.nan)
    inside = (at >= time[0]) & (at <= until)
    dense = len(time) > 1 and float(np.median(np.diff(time))) <= DENSE
    before = np.clip(np.searchsorted(time, at, side="right") - 1, 0, None)
    for k, n in places:
        column = np.interp(at, time, values[:, n]) if dense else values[before, n]
        result[inside, k] = column[inside]
    return result


def by_controller(reading: Reading, topic: str, measured: Joints) -> Wanted:
    """Take what a joint trajectory controller of ros2_control said it wanted."""
    name = reference(reading.bag, topic)
    if name is None:
        raise BagError(f"{topic} has neither reference.positions nor desired.positions")
    series = read(reading, topic, ["joint_names", name])
    places = ordered(list(series.values["joint_names"][0]), measured, topic)
    time = series.time if series.stamped else measured.simulated(series.log)
    return Wanted(topic, "controller state", placed(time, series.values[name], places, measured, time[-1]))


def by_joint_states(reading: Reading, topic: str, measured: Joints) -> Wanted | None:
    """Take positions that were sent as joint states; None where they carry none."""
    series = read(reading, topic, ["name", "position"])
    names, values = list(series.values["name"][0]), np.asarray(series.values["position"], dtype=float)
    if values.ndim != 2 or values.shape[1] != len(names) or not names:
        return None
    time = times(series.time, series.log, series.stamped, measured)
    places = ordered(names, measured, topic)
    return Wanted(topic, "joint positions", placed(time, values, places, measured))


def by_setpoints(reading: Reading, topic: str, measured: Joints) -> Wanted | None:
    """Take positions that were sent as plain numbers, in the joints' order."""
    series = read(reading, topic, ["data"])
    values = np.asarray(series.values["data"], dtype=float)
    if values.ndim != 2 or values.shape[1] != len(measured.names):
        return None
    places = [(k, k) for k in range(len(measured.names))]
    return Wanted(topic, "setpoints", placed(measured.simulated(series.log), values, places, measured))


def times(time: Array, log: Array, stamped: bool, measured: Joints) -> Array:
    """Return a topic's times on the measured joints' clock."""
    own = measured.series.time
    # A stamp of another clock, such as the wall's beside simulated time, says nothing.
    same = stamped and time[0] <= own[-1] + 1.0 and time[-1] >= own[0] - 1.0
    return time if same or not measured.series.stamped else measured.simulated(log)


def by_trajectory(bag: Bag, topic: str, measured: Joints) -> Wanted:
    """Take trajectories: each holds from its stamp, or its receipt, until the next."""
    own = measured.series.time
    result = np.full((len(own), len(measured.names)), np.nan)
    for log, names, start, points in trajectories(bag, topic):
        receipt = float(measured.simulated(np.array([log]))[0])
        begin = start if start > 0.0 else receipt
        if begin > own[-1] + 1.0:  # stamped by another clock
            begin = receipt
        time = begin + np.array([t for t, _, _ in points])
        position = np.array([p for _, p, _ in points])
        if position.ndim != 2 or position.shape[1] != len(names):
            raise BagError(f"{topic}: a trajectory's points do not bear a position for each of its joints")
        velocity = np.array([v for _, _, v in points]) if all(len(v) for _, _, v in points) else None
        if (np.diff(time) <= 0.0).any():
            raise BagError(f"{topic}: a trajectory's times do not rise")
        inside = own >= begin
        for k, n in ordered(names, measured, topic):
            slope = None if velocity is None else velocity[:, n]
            result[inside, k] = curve(own[inside], time, position[:, n], slope)
    return Wanted(topic, "trajectory", result)


def curve(at: Array, time: Array, position: Array, velocity: Array | None) -> Array:
    """Return a trajectory at some times: cubics where it gives velocities, else straight lines."""
    if velocity is None or len(time) < 2:
        return np.interp(at, time, position)
    from scipy.interpolate import CubicHermiteSpline

    held = np.clip(at, time[0], time[-1])
    return np.asarray(CubicHermiteSpline(time, position, velocity)(held))


def trajectories(
    bag: Bag, topic: str
) -> Iterator[tuple[float, list[str], float, list[tuple[float, Array, Array]]]]:
    """Give receive time, joint names, stamp and points (time, positions, velocities) of each message."""
    decoder = bag.decoder(topic)
    for log, data in bag.messages(topic):
        count = int(decoder.layout(data).counts["points[]"][0].sum())
        if not count:
            continue
        parts = ("positions", "velocities", "time_from_start.sec", "time_from_start.nanosec")
        fields = [f"points[{k}].{part}" for k in range(count) for part in parts]
        columns: dict[str, NDArray[Any]] = decoder.columns([data], [*fields, "joint_names", *STAMP])
        points = []
        for k in range(count):
            position, velocity, sec, nanosec = (columns[f"points[{k}].{part}"][0] for part in parts)
            points.append((float(sec) + float(nanosec) / SECOND, position, velocity))
        stamp = float(columns[STAMP[0]][0]) + float(columns[STAMP[1]][0]) / SECOND
        seconds = float(bag.seconds(np.array([log]))[0])
        yield seconds, list(columns["joint_names"][0]), stamp, points
