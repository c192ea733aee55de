"""Shows a running robot or door as it moves, or burns."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from ..bag.cdr import Decoder
from ..bag.definitions import definition
from ..bag.diagnostics import statuses
from ..ros.parameters import ParameterQuestion
from ..ros.raw_topic import RawTopic
from ..ros.running_scene import not_the_file, running_scene
from ..ros.simulator import SimulatorWatch
from ..terminal.child import ending, start_child
from ..terminal.stop import Stop
from . import robot
from .bag import DOOR_SCALE, ROBOT_SCALE
from .door_live import MESH_TOPIC, LiveDoor
from .health import HealthPlots
from .joints import QUANTITIES, JointPlots
from .robot_bag import DIAGNOSTICS, JOINTS, LAYOUT, SHAPE, STATE
from .spectrum import Running
from .strain import KINDS, Strain
from .tube import LAYOUT_FIELDS, Skeleton
from .window import window

if TYPE_CHECKING:
    from rclpy.node import Node

EXECUTABLE = "flexsim_node"
LAYOUT_TOPIC = f"/{EXECUTABLE}/elastic_layout"
FIELDS: dict[str, tuple[str, list[str]]] = {
    "/joint_states": (JOINTS, ["name", *QUANTITIES]),
    f"/{EXECUTABLE}/elastic_state": (STATE, [*SHAPE, "status"]),
    LAYOUT_TOPIC: (LAYOUT, LAYOUT_FIELDS),
    "/diagnostics": (DIAGNOSTICS, []),
}
# A running node is found in well under a second; a new one may compile its kernels first.
DISCOVERY_TIME = 1.5
START_TIMEOUT = 600.0
END_TIMEOUT = 5.0
POLL_PERIOD = 1.0 / 60.0
DISCOVERY_PERIOD = 0.25
# s that diagnostics wait for the deadline that they are held against.
ASKING = 5.0
# Of so many shapes the beams' axes are found, anew as often as this, s: a robot at rest does not tell them.
LOOKED_AT = 200
LOOKING_PERIOD = 0.5


@dataclass(frozen=True)
class Kind:
    """What is shown: its word, the node that simulates it, and the topic that says it is there."""

    what: str
    executable: str
    topic: str


ROBOT = Kind("robot", EXECUTABLE, LAYOUT_TOPIC)
DOOR = Kind("door", "thermal_node", MESH_TOPIC)


def kind_of(scene: Path) -> Kind:
    """Say what a scene is of; what is wrong with it, its node will say."""
    return DOOR if keys_of(scene).get("model") == "fire_door" else ROBOT


def keys_of(scene: Path) -> dict[str, Any]:
    """Return a scene's keys, unchecked; none where it can't be read."""
    from ruamel.yaml import YAML
    from ruamel.yaml.error import YAMLError

    try:
        said = YAML(typ="safe", pure=True).load(scene.read_text(encoding="utf-8"))
    except (YAMLError, UnicodeDecodeError):
        return {}
    return said if isinstance(said, dict) else {}


def shown_live(
    kind: Kind, node: Node, recording: rr.RecordingStream, *, scale: float | None, rate: float
) -> LiveRobot | LiveDoor:
    """Return what shows a running robot or door."""
    if kind is DOOR:
        return LiveDoor(node, recording, scale=DOOR_SCALE if scale is None else scale)
    return LiveRobot(node, recording, scale=ROBOT_SCALE if scale is None else scale, rate=rate)


@contextmanager
def simulator(node: Node, scene: Path, stopped: Stop, kind: Kind = ROBOT) -> Iterator[SimulatorWatch]:
    """Start the node of a scene unless one is running, give a watch on it, and end it afterwards.

    Raises
    ------
    RuntimeError
        It is not installed, or ends before it publishes.
    """
    if running(node, DISCOVERY_TIME, stopped, kind.topic):
        found = SimulatorWatch(node, kind.executable)
        told = running_scene(node, kind.executable, DISCOVERY_TIME, stopped)
        if other := not_the_file(told, scene, kind is DOOR, kind.what):
            print(f"{other}; it is shown, since it is running already", file=sys.stderr, flush=True)
        yield found
        return
    beside = Path(sys.executable).with_name(kind.executable)
    executable = str(beside) if beside.exists() else shutil.which(kind.executable)
    if executable is None:
        raise RuntimeError(f"no {kind.executable} is running, and none is installed")
    words = [executable, "--ros-args", "-p", f"scene:={scene}"]
    child = start_child(words, subprocess.DEVNULL, None)
    try:
        end = time.monotonic() + START_TIMEOUT
        while not running(node, DISCOVERY_PERIOD, stopped, kind.topic):
            if stopped.asked:
                break
            if child.poll() is not None:
                raise RuntimeError(f"{kind.executable} {ending(child.returncode)}")
            if time.monotonic() > end:
                raise RuntimeError(f"{kind.executable} published nothing within {START_TIMEOUT:.0f} s")
        yield SimulatorWatch(node, kind.executable, child)
    finally:
        child.send_signal(signal.SIGINT)
        child.send_signal(signal.SIGCONT)  # what a signal has stopped hears no other
        try:
            child.wait(END_TIMEOUT)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()


def running(node: Node, timeout: float, stopped: Stop, topic: str = LAYOUT_TOPIC) -> bool:
    """Say whether a topic is published within `timeout` seconds."""
    end = time.monotonic() + timeout
    while not node.get_publishers_info_by_topic(topic):
        if time.monotonic() > end or stopped.asked:
            return False
        time.sleep(0.02)
    return True


class LiveRobot:
    """Moves what the node publishes into a recording.

    Parameters
    ----------
    node : rclpy.node.Node
    recording : rerun.RecordingStream
    scale : float
        Factor on elastic displacements.
    rate : float, Hz
        Frames a second of the 3-D view; plots get every message.
    """

    def __init__(self, node: Node, recording: rr.RecordingStream, *, scale: float, rate: float) -> None:
        self.node = node
        self.recording = recording
        self.scale = scale
        self.period = 1.0 / rate
        self.rows: dict[str, int] = {}
        self._topics: dict[str, RawTopic] = {}
        self._decoders = {t: Decoder(t, definition(t)) for t, _ in FIELDS.values()}
        self._skeleton: Skeleton | None = None
        self._view: robot.RobotView | None = None
        self._plots: JointPlots | None = None
        self._health = HealthPlots(recording, None)
        self._spectra = Running(1.0)
        self._start: int | None = None
        self._next_frame = 0.0
        self._looked_at: deque[tuple[NDArray, ...]] = deque(maxlen=LOOKED_AT)
        self._next_look = 0.0
        self._question: ParameterQuestion | None = ParameterQuestion(node, f"/{EXECUTABLE}")
        self._asked = time.monotonic()

    def run(self, stopped: Stop, duration: float | None, simulator: SimulatorWatch) -> None:
        """Show until asked to stop, until the robot is gone, or for `duration` s from the first message."""
        begun: float | None = None
        next_discovery = 0.0
        last = False
        while not last:
            # What came in before the end is shown.
            now = time.monotonic()
            last = stopped.asked or (duration is not None and begun is not None and now - begun >= duration)
            last |= bool(simulator.look())
            if now >= next_discovery:
                self._discover()
                next_discovery = now + DISCOVERY_PERIOD
            self._ask()
            self._take(LAYOUT, self._on_layout)
            self._take(STATE, self._on_states)
            self._take(JOINTS, self._on_joints)
            if self._question is None or last:
                self._take_diagnostics()
            if begun is None and self.rows:
                begun = time.monotonic()
            if not last:
                time.sleep(POLL_PERIOD)
        if self._question is not None:
            self._question.close()

    def _ask(self) -> None:
        """Ask the simulator for the time that a tick may take."""
        if self._question is None:
            return
        parameters = self._question.step()
        if parameters is None and time.monotonic() - self._asked < ASKING:
            return
        rate = (parameters or {}).get("rate")
        if isinstance(rate, float) and rate > 0.0:
            self._health.deadline = 1.0 / rate
        self._question.close()
        self._question = None

    def _discover(self) -> None:
        for name, (type_name, _) in FIELDS.items():
            publishers = self.node.get_publishers_info_by_topic(name)
            if publishers and type_name not in self._topics:
                self._topics[type_name] = RawTopic(self.node, name, type_name, publishers)

    def _take(self, type_name: str, show: Any) -> None:
        # A state before its layout waits in its queue.
        waits = type_name == STATE and self._skeleton is None
        if type_name not in self._topics or waits:
            return
        messages = self._topics[type_name].take()
        if not messages:
            return
        if self._start is None:
            self._start = messages[0].log_time
        times = np.array([m.log_time - self._start for m in messages]) * 1e-9
        fields = next(fields for t, fields in FIELDS.values() if t == type_name)
        show(times, self._decoders[type_name].columns([m.data for m in messages], fields))

    def _take_diagnostics(self) -> None:
        if DIAGNOSTICS not in self._topics or self._start is None:
            return
        for message in self._topics[DIAGNOSTICS].take():
            self._health.log([1e-9 * (message.log_time - self._start)], [statuses(message.data)])

    def _on_layout(self, times: NDArray, layout: dict[str, NDArray]) -> None:
        self._skeleton = Skeleton.from_layout(layout)
        self._view = None

    def _on_states(self, times: NDArray, states: dict[str, NDArray]) -> None:
        assert self._skeleton is not None
        position, rigid, displacement = (states[name] for name in SHAPE)
        if self._view is None:
            self._view = robot.RobotView(
                self.recording, self._skeleton, scale=self.scale, full_colour=0.0,
                strain=Strain(self._skeleton, position, rigid, displacement),
                full_strain=(0.0,) * len(KINDS),
            )  # fmt: skip
            self._looked_at.clear()
            # The blueprint is sent once, so it has room for what is yet to come.
            health = self._health.all_views()
            reach = whole_reach(rigid[0].reshape(-1, 3))
            most = "the most so far"
            layout = robot.layout(reach, self.scale, most, (most,) * len(KINDS), health)
            self.recording.send_blueprint(window(layout, live=True))
        elastic = np.linalg.norm((position - rigid).reshape(-1, 3), axis=1)
        # The colours' range is not known beforehand, so it grows.
        self._view.full_colour = max(self._view.full_colour, float(elastic.max()))
        off = position[:, -3:] - rigid[:, -3:]
        self._view.log_deflection(times, off)
        for spectrum in self._spectra.add(times, off):
            self._view.log_spectrum(*spectrum)
        self._view.log_status(times, states["status"])
        kept = []
        for i, t in enumerate(times):
            if t >= self._next_frame:
                kept.append(i)
                self._next_frame = t - t % self.period + self.period
        if kept:
            shapes = position[kept], rigid[kept], displacement[kept]
            self._view.log_shape(times[kept], *shapes[:2])
            self._look(times[kept], shapes)
            self._view.log_strain(times[kept], *shapes)
        self._count("robot/tip/deflection", len(times))
        self._count("robot/deformed", len(kept))

    def _look(self, times: NDArray, shapes: tuple[NDArray, ...]) -> None:
        """Find the beams' axes of what was seen so far, and the range of the strains' colours."""
        assert self._view is not None and self._skeleton is not None
        self._looked_at.extend(zip(*shapes, strict=True))
        if times[-1] >= self._next_look:
            self._next_look = times[-1] + LOOKING_PERIOD
            seen = [np.stack(some) for some in zip(*self._looked_at, strict=True)]
            self._view.strain = Strain(self._skeleton, *seen)
        assert self._view.strain is not None
        largest = self._view.strain(*shapes).max(axis=(0, 1))
        self._view.full_strain = tuple(np.maximum(self._view.full_strain, largest).tolist())

    def _on_joints(self, times: NDArray, states: dict[str, NDArray]) -> None:
        if self._plots is None:
            self._plots = JointPlots(self.recording, list(states["name"][0]))
        self._plots.log([rr.TimeColumn(robot.TIMELINE, duration=times)], states)
        for quantity in QUANTITIES:
            self._count(f"joints/{quantity}", len(times))

    def _count(self, entity: str, rows: int) -> None:
        self.rows[entity] = self.rows.get(entity, 0) + rows


def whole_reach(nodes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the box (2, 3), m, around all places that a robot's nodes (N, 3) can get to.

    A robot that lies in the x-y plane stays in it.
    """
    length = np.linalg.norm(np.diff(nodes, axis=0), axis=1).sum()
    reach = np.where(np.ptp(nodes, axis=0) > 1e-9 * length, 0.8 * length, 0.0)
    reach[:2] = 0.8 * length
    return np.array([nodes[0] - reach, nodes[0] + reach])
