"""Shows a running door as it burns."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from ..bag.cdr import Decoder
from ..bag.definitions import definition
from ..ros.raw_topic import RawTopic
from ..ros.simulator import SimulatorWatch
from ..terminal.stop import Stop
from .door import STAMP, DoorView, cold_temperature, stamps
from .door_bag import (
    CRITERIA,
    DEFLECTION,
    FIELD,
    FIELDS,
    IMAGE,
    MESH,
    REACTIONS,
    TEMPERATURE,
    THERMOCOUPLES,
    mesh_of,
    reaction_names,
)

if TYPE_CHECKING:
    from rclpy.node import Node

MESH_TOPIC = "/door/mesh"
TOPICS = {
    MESH_TOPIC: MESH,
    "/door/temperature_field": FIELD,
    "/door/deflection": DEFLECTION,
    "/door/thermocouples": THERMOCOUPLES,
    "/door/criteria": CRITERIA,
    "/door/reactions": REACTIONS,
    "/door/unexposed/image": IMAGE,
    "/furnace/temperature": TEMPERATURE,
}
POLL_PERIOD = 0.05
DISCOVERY_PERIOD = 0.25


class LiveDoor:
    """Moves what thermal_node publishes into a recording.

    Parameters
    ----------
    node : rclpy.node.Node
    recording : rerun.RecordingStream
    scale : float
        Factor on displacements.
    """

    def __init__(self, node: Node, recording: rr.RecordingStream, *, scale: float) -> None:
        self.node = node
        self.recording = recording
        self.scale = scale
        self.rows: dict[str, int] = {}
        self._topics: dict[str, RawTopic] = {}
        self._decoders = {kind: Decoder(kind, definition(kind)) for kind in TOPICS.values()}
        self._view: DoorView | None = None
        self._bent: NDArray[np.float64] | None = None
        self._readings: dict[float, tuple[list[str], NDArray[np.float64]]] = {}
        self._cold: float | None = None

    def run(self, stopped: Stop, duration: float | None, simulator: SimulatorWatch) -> None:
        """Show until asked to stop, until the door is gone, or for `duration` s from the first message on."""
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
            for kind in TOPICS.values():
                self._take(kind)
            if begun is None and self.rows:
                begun = time.monotonic()
            if not last:
                time.sleep(POLL_PERIOD)

    def _discover(self) -> None:
        for name, kind in TOPICS.items():
            publishers = self.node.get_publishers_info_by_topic(name)
            if publishers and kind not in self._topics:
                self._topics[kind] = RawTopic(self.node, name, kind, publishers)

    def _take(self, kind: str) -> None:
        # What comes before the mesh waits in its queue.
        if kind not in self._topics or (kind != MESH and self._view is None):
            return
        data = [message.data for message in self._topics[kind].take()]
        if not data:
            return
        if kind == MESH:
            columns = self._decoders[MESH].columns(data[-1:], ["nodes", "hexahedra"])
            self._view = DoorView(self.recording, *mesh_of(columns), scale=self.scale)
            self.recording.send_blueprint(self._view.blueprint(live=True))
            return
        columns = self._decoders[kind].columns(data, [*FIELDS[kind], *STAMP])
        assert self._view is not None
        show = {
            FIELD: self._on_field,
            DEFLECTION: self._on_deflection,
            THERMOCOUPLES: self._on_thermocouples,
            CRITERIA: self._on_criteria,
            REACTIONS: self._on_reactions,
            IMAGE: self._on_image,
            TEMPERATURE: self._on_furnace,
        }[kind]
        show(self._view, stamps(columns), columns)

    def _on_field(self, view: DoorView, t: NDArray, columns: dict[str, Any]) -> None:
        shape = np.zeros_like(view.nodes) if self._bent is None else self._bent
        # The last of those that came together is all that can be seen.
        view.log_leaf(t[-1:], columns["temperature"][-1:], shape[None])
        self._count("door/fire_side", 1)
        self._count("door/unexposed_side", 1)

    def _on_deflection(self, view: DoorView, t: NDArray, columns: dict[str, Any]) -> None:
        self._bent = columns["displacement"][-1].reshape(-1, 3)
        view.log_deflection(t, columns["bow"], list(columns["edge_name"][0]), columns["edge_gap"])
        self._count("door/deflection", len(t))

    def _on_thermocouples(self, view: DoorView, t: NDArray, columns: dict[str, Any]) -> None:
        names = list(columns["name"][0])
        place = np.stack([columns[axis][0] for axis in "xyz"], axis=1)
        view.log_thermocouples(t, names, place, columns["temperature"])
        if self._cold is None:
            self._readings |= {
                float(time): (names, row) for time, row in zip(t, columns["temperature"], strict=True)
            }
        self._count("door/thermocouples/unexposed", len(t))

    def _on_criteria(self, view: DoorView, t: NDArray, columns: dict[str, Any]) -> None:
        names = list(columns["criterion"][0])
        view.log_criteria(t, names, columns["value"], columns["limit"], columns["verdict"])
        for at, value in zip(t, columns["value"], strict=True):
            if self._cold is None and float(at) in self._readings:
                self._cold = cold_temperature(*self._readings[float(at)], names, value)
                self._readings.clear()
        if self._cold is not None:
            view.log_limits(t, names, columns["limit"], self._cold)
        self._count("door/criteria", len(t))

    def _on_reactions(self, view: DoorView, t: NDArray, columns: dict[str, Any]) -> None:
        first = "door/reactions" not in self.rows
        view.log_reactions(t, reaction_names(columns), columns["degree"])
        self._count("door/reactions", len(t))
        if first:  # the view has room for them from now on
            self.recording.send_blueprint(view.blueprint(live=True))

    def _on_image(self, view: DoorView, t: NDArray, columns: dict[str, Any]) -> None:
        height, width = int(columns["height"][-1]), int(columns["width"][-1])
        data = np.ascontiguousarray(columns["data"][-1:]).view("<f4").reshape(1, height, width)
        view.log_image(t[-1:], data)
        self._count("door/infrared", 1)

    def _on_furnace(self, view: DoorView, t: NDArray, columns: dict[str, Any]) -> None:
        view.log_furnace(t, columns["temperature"])
        self._count("door/furnace", len(t))

    def _count(self, entity: str, rows: int) -> None:
        self.rows[entity] = self.rows.get(entity, 0) + rows
