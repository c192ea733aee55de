"""Turns a bag into a rerun recording: whatever kinds of model it holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import rerun as rr
import rerun.blueprint as rrb

from ..bag import Bag, BagError
from . import door_bag, robot_bag
from .door import PLAYBACK_SPEED
from .robot_bag import RobotConversion
from .window import TIMELINE, window

# What makes the usual motion of each easy to see.
ROBOT_SCALE, DOOR_SCALE = 20.0, 5.0


@dataclass
class Shown:
    """What was logged.

    Attributes
    ----------
    rows : of each entity
    without_view : topics
    scale : factor on displacements
    thinned : of each entity that shows fewer messages than the bag has, how many these are
    """

    rows: dict[str, int]
    without_view: list[str]
    scale: float = 1.0
    thinned: dict[str, int] = field(default_factory=dict)


def show(
    bag: Bag,
    recording: rr.RecordingStream,
    *,
    scale: float | None,
    rate: float,
    progress: Callable[[float], None] = lambda _: None,
) -> Shown:
    """Log all of a bag that has a view: a robot, a door, or both.

    Parameters
    ----------
    bag : Bag
    recording : rerun.RecordingStream
    scale : float or None
        Factor on displacements; None: what suits a robot or a door.
    rate : float, Hz
        Frames a second of a robot's 3-D view.
    progress : callable
        Called with s of the bag that were read.

    Raises
    ------
    BagError
        The bag holds nothing that has a view.
    """
    bag.needs_messages()
    robots, doors = robot_bag.topics(bag), door_bag.topics(bag)
    if not (robots or doors):
        raise BagError(f"{bag.path} holds neither elastic states nor joint states, nor a door, to show")
    used = {*robots.values(), *doors.values()}
    without = sorted(t.name for t in bag.topics.values() if t.count and t.name not in used)
    first = ROBOT_SCALE if robots else DOOR_SCALE
    shown = Shown({}, without, first if scale is None else scale)
    recording.send_recording_name(bag.path.name)
    views: list[tuple[str, rrb.Horizontal]] = []
    recorded: dict[str, int] = {}
    if robots:
        conversion = RobotConversion(bag, recording, robots, ROBOT_SCALE if scale is None else scale, rate)
        consumers = conversion.consumers()
        for messages in bag.read([*consumers], {name: period for name, (period, _) in consumers.items()}):
            for name, some in messages.items():
                consumers[name][1](some)
            progress((int(some.log_time[-1]) - bag.start) * 1e-9)
        conversion.finish()
        shown.rows |= conversion.rows
        recorded |= conversion.recorded()
        views.append(("Robot", conversion.view()))
    if doors:
        view, rows = door_bag.show(bag, recording, doors, DOOR_SCALE if scale is None else scale)
        shown.rows |= rows
        recorded |= door_bag.recorded(bag, doors)
        views.append(("Door", view))
    shown.thinned = {
        entity: count for entity, count in recorded.items() if 0 < shown.rows.get(entity, 0) < count
    }
    if shown.thinned:
        fewer = ", ".join(f"{name} {shown.rows[name]} of {count}" for name, count in shown.thinned.items())
        recording.set_time(TIMELINE, duration=0.0)
        recording.log(
            "robot/status" if robots else "door/verdict",
            rr.TextLog(f"fewer messages are shown than were recorded: {fewer}", level="INFO"),
        )
    for name, view in views:
        view.name = name
    root = views[0][1] if len(views) == 1 else rrb.Tabs(*[view for _, view in views])
    recording.send_blueprint(window(root, speed=1.0 if robots else PLAYBACK_SPEED))
    return shown
