"""Turns a bag into a rerun recording: whatever kinds of model it holds."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from ..bag import Bag, BagError
from ..bag.cdr import Decoder
from . import door_bag, robot
from .joints import QUANTITIES, JointPlots
from .tube import LAYOUT_FIELDS, Skeleton

STATE = "flexsim_msgs/msg/ElasticState"
LAYOUT = "flexsim_msgs/msg/ElasticLayout"
JOINTS = "sensor_msgs/msg/JointState"
SHAPE = ["position", "rigid_position"]
# What makes the usual motion of each easy to see.
ROBOT_SCALE, DOOR_SCALE = 20.0, 5.0
# More rows than a screen has pixels only cost time: long bags are thinned to these.
MOST_FRAMES = 18_000
MOST_PLOTTED = 500_000


@dataclass
class Shown:
    """How many rows of each entity were logged, the topics without a view, and the scale."""

    rows: dict[str, int]
    without_view: list[str]
    scale: float = 1.0


def of_type(bag: Bag, type_name: str) -> str | None:
    """Return the first topic of a type that has messages, or None."""
    return next((t.name for t in bag.topics.values() if t.type == type_name and t.count), None)


def thinning(bag: Bag, topic: str, most: int, rate: float = np.inf) -> float:
    """Return the period in s that keeps a topic under `most` messages and under `rate`."""
    count = bag.topic(topic).count
    needed = bag.duration / most if count > most else 0.0
    wanted = 1.0 / rate if count > rate * bag.duration else 0.0
    return max(needed, wanted)


def skeleton(bag: Bag, topic: str) -> Skeleton:
    """Read the robot's layout: the last, should a second robot have been started."""
    found = bag.topic(topic)
    last = [data for _, data in bag.messages(topic)][-1:]
    return Skeleton.from_layout(Decoder(found.type, found.schema).columns(last, LAYOUT_FIELDS))


def show(bag: Bag, recording: rr.RecordingStream, *, scale: float | None, rate: float) -> Shown:
    """Log all of a bag that has a view: a door's where it holds one, else a robot's.

    Parameters
    ----------
    bag : Bag
    recording : rerun.RecordingStream
    scale : float or None
        Factor on displacements; None: what suits a robot or a door.
    rate : float, Hz
        Frames a second of a robot's 3-D view.

    Raises
    ------
    BagError
        The bag holds nothing that has a view.
    """
    found = door_bag.topics(bag)
    if found:
        return show_door(bag, recording, found, DOOR_SCALE if scale is None else scale)
    scale = ROBOT_SCALE if scale is None else scale
    state, layout, joint_topic = (of_type(bag, t) for t in (STATE, LAYOUT, JOINTS))
    used = {state, layout, joint_topic}
    shown = Shown({}, others(bag, used), scale)
    if state is None and joint_topic is None:
        raise BagError(f"{bag.path} holds neither elastic states nor joint states, nor a door, to show")
    if state is not None and layout is None:
        raise BagError(f"{bag.path} has {state} without its layout; record elastic_layout too")
    recording.send_recording_name(bag.path.name)
    reach = np.array([[-0.5, -0.5, 0.0], [0.5, 0.5, 0.5]])
    strongest = None
    if state is not None and layout is not None:
        reach, strongest = show_robot(bag, recording, state, layout, scale, rate, shown)
    if joint_topic is not None:
        show_joints(bag, recording, joint_topic, shown)
    recording.send_blueprint(robot.blueprint(reach, scale, strongest))
    return shown


def others(bag: Bag, used: Collection[str | None]) -> list[str]:
    """Return the topics with messages that are not used."""
    return sorted(t.name for t in bag.topics.values() if t.count and t.name not in used)


def show_door(bag: Bag, recording: rr.RecordingStream, found: dict[str, str], scale: float) -> Shown:
    """Log a door."""
    recording.send_recording_name(bag.path.name)
    blueprint, rows = door_bag.show(bag, recording, found, scale)
    recording.send_blueprint(blueprint)
    return Shown(rows, others(bag, found.values()), scale)


def show_robot(
    bag: Bag,
    recording: rr.RecordingStream,
    state: str,
    layout: str,
    scale: float,
    rate: float,
    shown: Shown,
) -> tuple[NDArray[np.float64], float]:
    """Log the elastic states; returns the least and greatest coordinates, (2, 3), and the
    displacement that has the strongest colour, m."""
    found = skeleton(bag, layout)
    period = thinning(bag, state, MOST_FRAMES, rate)
    log_time, frames = bag.columns(state, SHAPE, period=period)
    nodes = frames["rigid_position"].reshape(-1, 3)
    elastic = frames["position"].reshape(-1, 3) - nodes
    largest = np.linalg.norm(elastic, axis=1).reshape(len(log_time), -1).max(axis=1)
    # Not the very largest: one knock at the start would leave the rest without colour.
    strongest = float(np.quantile(largest, 0.95))
    view = robot.RobotView(
        recording,
        found,
        scale=scale,
        full_colour=strongest,
    )
    view.log_shape(bag.seconds(log_time), frames["position"], frames["rigid_position"])
    shown.rows["robot/deformed"] = len(log_time)

    rows = 0
    status_times, statuses = [], []
    period = thinning(bag, state, MOST_PLOTTED)
    for times, batch in bag.batches(state, [*SHAPE, "status"], period=period):
        seconds = bag.seconds(times)
        view.log_deflection(seconds, batch["position"], batch["rigid_position"])
        status_times.append(seconds)
        statuses.append(batch["status"])
        rows += len(times)
    view.log_status(np.concatenate(status_times), np.concatenate(statuses))
    shown.rows["robot/tip/deflection"] = rows
    return np.array([nodes.min(axis=0), nodes.max(axis=0)]), strongest


def show_joints(bag: Bag, recording: rr.RecordingStream, topic: str, shown: Shown) -> None:
    """Log the joint states."""
    plots: JointPlots | None = None
    rows = 0
    fields = ["name", *QUANTITIES]
    for times, batch in bag.batches(topic, fields, period=thinning(bag, topic, MOST_PLOTTED)):
        if plots is None:
            plots = JointPlots(recording, list(batch["name"][0]))
        index = [rr.TimeColumn(robot.TIMELINE, duration=bag.seconds(times))]
        plots.log(index, batch)
        rows += len(times)
    for quantity in QUANTITIES:
        shown.rows[f"joints/{quantity}"] = rows
