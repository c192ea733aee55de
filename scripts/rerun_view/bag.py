"""Turns a bag into a rerun recording: whatever kinds of model it holds."""

from __future__ import annotations

from dataclasses import dataclass

import rerun as rr
import rerun.blueprint as rrb

from ..bag import Bag, BagError
from . import door_bag, robot_bag
from .door import PLAYBACK_SPEED
from .robot_bag import RobotConversion
from .window import window

# What makes the usual motion of each easy to see.
ROBOT_SCALE, DOOR_SCALE = 20.0, 5.0


@dataclass
class Shown:
    """How many rows of each entity were logged, the topics without a view, and the scale."""

    rows: dict[str, int]
    without_view: list[str]
    scale: float = 1.0


def show(bag: Bag, recording: rr.RecordingStream, *, scale: float | None, rate: float) -> Shown:
    """Log all of a bag that has a view: a robot, a door, or both.

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
    robots, doors = robot_bag.topics(bag), door_bag.topics(bag)
    if not (robots or doors):
        raise BagError(f"{bag.path} holds neither elastic states nor joint states, nor a door, to show")
    used = {*robots.values(), *doors.values()}
    without = sorted(t.name for t in bag.topics.values() if t.count and t.name not in used)
    first = ROBOT_SCALE if robots else DOOR_SCALE
    shown = Shown({}, without, first if scale is None else scale)
    recording.send_recording_name(bag.path.name)
    views: list[tuple[str, rrb.Horizontal]] = []
    if robots:
        conversion = RobotConversion(bag, recording, robots, ROBOT_SCALE if scale is None else scale, rate)
        consumers = conversion.consumers()
        for messages in bag.read([*consumers], {name: period for name, (period, _) in consumers.items()}):
            for name, some in messages.items():
                consumers[name][1](some)
        conversion.finish()
        shown.rows |= conversion.rows
        views.append(("Robot", conversion.view()))
    if doors:
        view, rows = door_bag.show(bag, recording, doors, DOOR_SCALE if scale is None else scale)
        shown.rows |= rows
        views.append(("Door", view))
    for name, view in views:
        view.name = name
    root = views[0][1] if len(views) == 1 else rrb.Tabs(*[view for _, view in views])
    recording.send_blueprint(window(root, speed=1.0 if robots else PLAYBACK_SPEED))
    return shown
