"""The robot's part of a bag, as a rerun recording: read once, from beginning to end."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from ..bag import Bag, BagError
from ..bag.diagnostics import TYPE as DIAGNOSTICS
from ..bag.diagnostics import statuses
from ..bag.joints import JointDecoder, sets_of
from ..bag.messages import Gathered, Messages, Thinner
from ..bag.robot import parameter, robot_in
from . import robot
from .health import HealthPlots
from .joints import QUANTITIES, JointPlots
from .spectrum import Running
from .strain import Strain
from .tube import LAYOUT_FIELDS, Skeleton

STATE = "flexsim_msgs/msg/ElasticState"
LAYOUT = "flexsim_msgs/msg/ElasticLayout"
JOINTS = "sensor_msgs/msg/JointState"
SHAPE = ["position", "rigid_position", "displacement"]
TIP = ["position[-3:]", "rigid_position[-3:]", "status"]
# More rows than a screen has pixels only cost time: long bags are thinned to these.
MOST_FRAMES = 18_000
MOST_PLOTTED = 500_000
MOST_SPECTRA = 600
# From so many states the range of the colours is found.
LOOKED_AT = 400
# Messages that are decoded together, since each time costs the same for one and for a thousand.
DECODED = 1000
SAID = 200
# Rows that are logged together.
TOGETHER = 20_000


def topics(bag: Bag) -> dict[str, str]:
    """Return the robot's topics by type; empty where the bag holds no robot."""
    robot = robot_in(bag)
    said = next((t.name for t in bag.topics.values() if t.type == DIAGNOSTICS and t.count), None)
    kinds = ((STATE, robot.state), (LAYOUT, robot.layout), (JOINTS, robot.joints), (DIAGNOSTICS, said))
    found = {kind: name for kind, name in kinds if name is not None}
    return found if STATE in found or JOINTS in found else {}


def skeleton(bag: Bag, topic: str) -> Skeleton:
    """Read the robot's layout: the last, should a second robot have been started."""
    last = bag.last(topic)
    if last is None:
        raise BagError(f"{bag.path}: {topic} can't be read")
    return Skeleton.from_layout(bag.decoder(topic).columns([last], LAYOUT_FIELDS))


def thinning(bag: Bag, topic: str, most: int, rate: float = np.inf) -> float:
    """Return the period in s that keeps a topic under `most` messages and under `rate`."""
    count = bag.topic(topic).count
    needed = bag.duration / most if count > most else 0.0
    wanted = 1.0 / rate if count > rate * bag.duration else 0.0
    return max(needed, wanted)


class RobotConversion:
    """Logs a recorded robot to a recording.

    Parameters
    ----------
    bag : Bag
    recording : rerun.RecordingStream
    found : dict
        What `topics` found.
    scale : float
        Factor on elastic displacements.
    rate : float, Hz
        Frames a second of the 3-D view.

    Raises
    ------
    BagError
        The bag has elastic states without their layout.
    """

    def __init__(
        self, bag: Bag, recording: rr.RecordingStream, found: dict[str, str], scale: float, rate: float
    ) -> None:
        self.bag = bag
        self.recording = recording
        self.rows: dict[str, int] = {}
        self.scale = scale
        self.state, self.joints = found.get(STATE), found.get(JOINTS)
        self.diagnostics = found.get(DIAGNOSTICS)
        self.reach = np.array([[-0.5, -0.5, 0.0], [0.5, 0.5, 0.5]])
        self._plots: dict[tuple[str, ...], JointPlots] = {}
        self._health = HealthPlots(recording, self._deadline())
        self._frames: list[tuple[NDArray, dict[str, NDArray]]] = []
        self._tips: list[tuple[NDArray, dict[str, NDArray]]] = []
        self._joint_rows: dict[tuple[str, ...], list[tuple[NDArray, dict[str, NDArray]]]] = {}
        self._waiting: dict[str, int] = {}
        self._states_read, self._joints_read = Gathered(DECODED), Gathered(DECODED)
        self._diagnostics_read = Gathered(SAID)
        self._view: robot.RobotView | None = None
        if self.state is not None:
            if LAYOUT not in found:
                raise BagError(f"{bag.path} has {self.state} without its layout; record elastic_layout too")
            self._prepare(skeleton(bag, found[LAYOUT]), rate)

    def _deadline(self) -> float | None:
        """Return the time that a tick may take, s, as far as the bag says."""
        for pairs in self.bag.notes().values():
            rate = parameter(pairs, "rate")
            if isinstance(rate, float):
                return 1.0 / rate if rate > 0.0 else None
        return None

    def _prepare(self, found: Skeleton, rate: float) -> None:
        """Look at some states for the range of the view and of its colours."""
        assert self.state is not None
        period = self.bag.duration / LOOKED_AT
        _, some = self.bag.columns(self.state, SHAPE, period=period)
        if not len(some["position"]):
            raise BagError(f"{self.bag.path}: {self.state} can't be read")
        nodes = some["rigid_position"].reshape(-1, 3)
        self.reach = np.array([nodes.min(axis=0), nodes.max(axis=0)])
        elastic = (some["position"] - some["rigid_position"]).reshape(len(some["position"]), -1, 3)
        # Not the very largest: one knock at the start would leave the rest without colour.
        strongest = float(np.quantile(np.linalg.norm(elastic, axis=2).max(axis=1), 0.95))
        strain = Strain(found, some["position"], some["rigid_position"], some["displacement"])
        amounts = strain(some["position"], some["rigid_position"], some["displacement"])
        largest = np.quantile(amounts.max(axis=1), 0.95, axis=0)
        self._view = robot.RobotView(
            self.recording, found, scale=self.scale, full_colour=strongest,
            strain=strain, full_strain=tuple(map(float, largest)),
        )  # fmt: skip
        self._thin_frames = Thinner(thinning(self.bag, self.state, MOST_FRAMES, rate))
        self._spectra = Running(max(1.0, self.bag.duration / MOST_SPECTRA))

    def consumers(self) -> dict[str, tuple[float, Callable[[Messages], None]]]:
        """Return what is to be called with each topic's messages, and the least period between them, s."""
        found: dict[str, tuple[float, Callable[[Messages], None]]] = {}
        if self.state is not None:
            found[self.state] = thinning(self.bag, self.state, MOST_PLOTTED), self.on_states
        if self.joints is not None:
            found[self.joints] = thinning(self.bag, self.joints, MOST_PLOTTED), self.on_joints
        if self.diagnostics is not None:
            found[self.diagnostics] = 0.0, self.on_diagnostics
        return found

    def on_states(self, messages: Messages) -> None:
        """Log elastic states."""
        if (enough := self._states_read.add(messages)) is not None:
            self._take_states(enough)

    def on_joints(self, messages: Messages) -> None:
        """Log joint states."""
        if (enough := self._joints_read.add(messages)) is not None:
            self._take_joints(enough)

    def on_diagnostics(self, messages: Messages) -> None:
        """Log diagnostics."""
        if (enough := self._diagnostics_read.add(messages)) is not None:
            self._take_diagnostics(enough)

    def _take_states(self, messages: Messages) -> None:
        assert self.state is not None
        decoder = self.bag.decoder(self.state)
        self._tips.append((self.bag.seconds(messages.log_time), decoder.columns(messages, TIP)))
        if self._full("tips", len(messages), TOGETHER):
            self._log_tips()
        shown = self._thin_frames(messages)
        if len(shown):
            self._frames.append((self.bag.seconds(shown.log_time), decoder.columns(shown, SHAPE)))
            if self._full("frames", len(shown), robot.FRAMES_PER_CHUNK):
                self._log_frames()

    def _take_joints(self, messages: Messages) -> None:
        assert self.joints is not None
        decoder = self.bag.decoder(self.joints)
        for names in sets_of(decoder, messages):
            # Each set of joints has its plots: an arm's and a gripper's may share a topic.
            names = next((known for known in self._plots if sorted(known) == sorted(names)), names)
            if names not in self._plots:
                self._plots[names] = JointPlots(self.recording, list(names), len(self._plots))
            own = JointDecoder(decoder, names, [], "")
            mine = own.mine(messages)
            columns = own.columns(mine, [*QUANTITIES])
            rows = self._joint_rows.setdefault(names, [])
            if rows and any(columns[q].shape[1:] != rows[-1][1][q].shape[1:] for q in QUANTITIES):
                self._log_joints()  # a driver may leave out a quantity for a while
                rows = self._joint_rows.setdefault(names, [])
            rows.append((self.bag.seconds(mine.log_time), columns))
        if self._full("joints", len(messages), TOGETHER):
            self._log_joints()

    def _take_diagnostics(self, messages: Messages) -> None:
        said = [statuses(data) for data in messages.data()]
        self._health.log(self.bag.seconds(messages.log_time).tolist(), said)
        self.rows |= self._health.rows

    def finish(self) -> None:
        """Log what still waits."""
        for read, take in (
            (self._states_read, self._take_states),
            (self._joints_read, self._take_joints),
            (self._diagnostics_read, self._take_diagnostics),
        ):
            if (rest := read.all()) is not None:
                take(rest)
        self._log_tips()
        self._log_frames()
        self._log_joints()

    def _full(self, what: str, more: int, most: int) -> bool:
        self._waiting[what] = self._waiting.get(what, 0) + more
        if self._waiting[what] < most:
            return False
        self._waiting[what] = 0
        return True

    def _log_tips(self) -> None:
        if not self._tips:
            return
        assert self._view is not None
        time, columns = joined(self._tips, TIP)
        self._tips = []
        off = columns[TIP[0]] - columns[TIP[1]]
        self._view.log_deflection(time, off)
        self._view.log_status(time, columns["status"])
        for at, frequency, amplitude in self._spectra.add(time, off):
            self._view.log_spectrum(at, frequency, amplitude)
        self._count("robot/tip/deflection", len(time))

    def _log_frames(self) -> None:
        if not self._frames:
            return
        assert self._view is not None
        time, columns = joined(self._frames, SHAPE)
        self._frames = []
        self._view.log_shape(time, columns["position"], columns["rigid_position"])
        self._view.log_strain(time, columns["position"], columns["rigid_position"], columns["displacement"])
        self._count("robot/deformed", len(time))

    def _log_joints(self) -> None:
        for names, rows in self._joint_rows.items():
            if not rows:
                continue
            time, columns = joined(rows, [*QUANTITIES])
            plots = self._plots[names]
            plots.log([rr.TimeColumn(robot.TIMELINE, duration=time)], columns)
            for quantity, place in plots.places.items():
                if columns[quantity].shape[1:] == (len(names),):
                    self._count(place, len(time))
        self._joint_rows = {}

    def _count(self, entity: str, rows: int) -> None:
        self.rows[entity] = self.rows.get(entity, 0) + rows

    def view(self) -> rrb.Horizontal:
        """Return what the blueprint shows of the robot."""
        red, strains = "", None
        if self._view is not None:
            red = f"{self._view.full_colour * robot.MILLIMETRES:.3g} mm"
            strains = tuple(f"{amount:.2g}" for amount in self._view.full_strain)
        return robot.layout(self.reach, self.scale, red, strains, health=self._health.views())

    def recorded(self) -> dict[str, int]:
        """Return of each entity how many messages the bag has of what it shows."""
        found: dict[str, int] = {}
        if self.state is not None:
            states = self.bag.topic(self.state).count
            found |= {"robot/deformed": states, "robot/tip/deflection": states}
        if self.joints is not None:
            found |= {f"joints/{q}": self.bag.topic(self.joints).count for q in QUANTITIES}
        return found


def joined(
    parts: list[tuple[NDArray, dict[str, NDArray]]], fields: list[str]
) -> tuple[NDArray[np.float64], dict[str, NDArray]]:
    """Put together what was read piece by piece."""
    time = np.concatenate([t for t, _ in parts])
    return time, {name: np.concatenate([columns[name] for _, columns in parts]) for name in fields}
