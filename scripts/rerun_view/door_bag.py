"""The door's part of a bag, as a rerun recording."""

from __future__ import annotations

from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from ..bag import Bag, BagError
from .door import STAMP, DoorView, Range, between, cold_temperature, stamps

MESH = "flexsim_msgs/msg/LeafMesh"
FIELD = "flexsim_msgs/msg/TemperatureField"
DEFLECTION = "flexsim_msgs/msg/LeafDeflection"
THERMOCOUPLES = "flexsim_msgs/msg/Thermocouples"
CRITERIA = "flexsim_msgs/msg/FireCriteria"
REACTIONS = "flexsim_msgs/msg/Reactions"
IMAGE = "sensor_msgs/msg/Image"
TEMPERATURE = "sensor_msgs/msg/Temperature"
# Which topic of a type that others publish as well.
ENDING = {IMAGE: "unexposed/image", TEMPERATURE: "furnace/temperature"}
FIELDS = {
    FIELD: ["temperature"],
    DEFLECTION: ["displacement", "bow", "edge_name", "edge_gap"],
    THERMOCOUPLES: ["name", "temperature", "x", "y", "z"],
    CRITERIA: ["criterion", "value", "limit", "verdict"],
    REACTIONS: ["material", "reaction", "degree"],
    IMAGE: ["height", "width", "data"],
    TEMPERATURE: ["temperature"],
}
ENTITIES = {
    FIELD: ["door/fire_side", "door/unexposed_side"],
    DEFLECTION: ["door/deflection"],
    THERMOCOUPLES: ["door/thermocouples/unexposed"],
    CRITERIA: ["door/criteria"],
    REACTIONS: ["door/reactions"],
    IMAGE: ["door/infrared"],
    TEMPERATURE: ["door/furnace"],
}
# A leaf of fifty thousand nodes is drawn with some ten thousand: more frames cost only memory.
MOST_FRAMES = 400
MOST_PLOTTED = 5_000


def topics(bag: Bag) -> dict[str, str]:
    """Return the door's topics by type; empty where the bag holds no door."""
    found = {
        topic.type: topic.name
        for topic in bag.topics.values()
        if topic.count and topic.type in (MESH, *FIELDS) and topic.name.endswith(ENDING.get(topic.type, ""))
    }
    return found if set(found) - set(ENDING) else {}


def show(
    bag: Bag, recording: rr.RecordingStream, found: dict[str, str], scale: float
) -> tuple[rrb.Horizontal, dict[str, int]]:
    """Log the door; returns its view, and how many rows each entity has.

    Raises
    ------
    BagError
        The bag lacks the mesh.
    """
    if MESH not in found:
        raise BagError(f"{bag.path} has a door without its mesh; record door/mesh too")
    nodes, hexahedra = last_mesh(bag, found[MESH])
    rows: dict[str, int] = {}
    fire, unexposed = ranges(bag, found, nodes)
    view = DoorView(recording, nodes, hexahedra, scale=scale, fire=fire, unexposed=unexposed)
    known, shapes = deflections(bag, found, view, rows)
    if FIELD in found:
        for columns in parts(bag, found, FIELD, MOST_FRAMES):
            time, temperature = stamps(columns), columns["temperature"]
            if temperature.shape[1] != len(nodes):
                raise BagError(f"{bag.path}: {found[FIELD]} does not fit {found[MESH]}")
            for at in range(0, len(time), 50):
                some = slice(at, at + 50)
                bent = (
                    between(time[some], known, shapes)
                    if len(known)
                    else np.zeros((len(time[some]), *nodes.shape))
                )
                view.log_leaf(time[some], temperature[some], bent)
            for side in ("fire_side", "unexposed_side"):
                rows[f"door/{side}"] = rows.get(f"door/{side}", 0) + len(time)
    plots(bag, found, view, rows)
    return view.layout(), rows


def recorded(bag: Bag, found: dict[str, str]) -> dict[str, int]:
    """Return of each entity how many messages the bag has of what it shows."""
    return {
        entity: bag.topic(found[kind]).count
        for kind, entities in ENTITIES.items()
        if kind in found
        for entity in entities
    }


def last_mesh(bag: Bag, topic: str) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return nodes (N, 3) and bricks (C, 8) of the last mesh."""
    last = bag.last(topic)
    if last is None:
        raise BagError(f"{bag.path}: {topic} can't be read")
    columns = bag.decoder(topic).columns([last], ["nodes", "hexahedra"])
    return mesh_of(columns)


def mesh_of(columns: dict[str, Any]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return nodes (N, 3) and bricks (C, 8) from columns of LeafMesh, the last of which counts."""
    nodes = columns["nodes"][-1].reshape(-1, 3)
    return nodes, columns["hexahedra"][-1].reshape(-1, 8).astype(np.int64)


def reaction_names(columns: dict[str, Any]) -> list[str]:
    """Return what the degrees of Reactions are of."""
    pairs = zip(columns["material"][0], columns["reaction"][0], strict=True)
    return [f"{material}: {reaction}" for material, reaction in pairs]


def parts(bag: Bag, found: dict[str, str], kind: str, most: int) -> Any:
    """Give the columns of a topic piece by piece, thinned to about `most` messages."""
    topic = found[kind]
    count = bag.topic(topic).count
    period = bag.duration / most if count > most else 0.0
    for _, columns in bag.batches(topic, [*FIELDS[kind], *STAMP], period=period):
        yield columns


def ranges(bag: Bag, found: dict[str, str], nodes: NDArray[np.float64]) -> tuple[Range, Range]:
    """Return the least and highest temperatures of the fire's side and of the unexposed side."""
    if FIELD not in found:
        return Range(20.0, 1000.0), Range(20.0, 250.0)
    face = nodes[:, 2] > nodes[:, 2].max() - 1e-9
    low, high, outside = np.inf, -np.inf, -np.inf
    for columns in parts(bag, found, FIELD, MOST_FRAMES):
        field = columns["temperature"]
        if field.shape[1] == len(nodes):
            low, high = min(low, float(field.min())), max(high, float(field.max()))
            outside = max(outside, float(field[:, face].max()))
    return Range(low, high), Range(low, outside)


def deflections(
    bag: Bag, found: dict[str, str], view: DoorView, rows: dict[str, int]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Log bow and gaps; returns times (D,) and displacements (D, N, 3) in order of time."""
    if DEFLECTION not in found:
        return np.empty(0), np.empty((0, 0, 3))
    times, shapes = [], []
    for columns in parts(bag, found, DEFLECTION, MOST_FRAMES):
        time = stamps(columns)
        view.log_deflection(time, columns["bow"], list(columns["edge_name"][0]), columns["edge_gap"])
        times.append(time)
        shapes.append(columns["displacement"].reshape(len(time), -1, 3).astype(np.float32))
        rows["door/deflection"] = rows.get("door/deflection", 0) + len(time)
    time, index = np.unique(np.concatenate(times), return_index=True)
    return time, np.concatenate(shapes)[index]


def plots(bag: Bag, found: dict[str, str], view: DoorView, rows: dict[str, int]) -> None:
    """Log thermocouples, limits, criteria, the furnace and the infrared image."""

    def count(entity: str, many: int) -> None:
        rows[entity] = rows.get(entity, 0) + many

    first: tuple[list[str], NDArray[np.float64], NDArray[np.float64]] | None = None
    if THERMOCOUPLES in found:
        for columns in parts(bag, found, THERMOCOUPLES, MOST_PLOTTED):
            names, time = list(columns["name"][0]), stamps(columns)
            place = np.stack([columns[axis][0] for axis in "xyz"], axis=1)
            view.log_thermocouples(time, names, place, columns["temperature"])
            first = first or (names, time, columns["temperature"])
            count("door/thermocouples/unexposed", len(time))
    if CRITERIA in found:
        cold = None
        for columns in parts(bag, found, CRITERIA, MOST_PLOTTED):
            names, time = list(columns["criterion"][0]), stamps(columns)
            view.log_criteria(time, names, columns["value"], columns["limit"], columns["verdict"])
            if cold is None and first is not None:
                both, i, k = np.intersect1d(first[1], time, return_indices=True)
                if len(both):
                    value = columns["value"][k[0]]
                    cold = cold_temperature(first[0], first[2][i[0]], names, value)
            if cold is not None:
                view.log_limits(time, names, columns["limit"], cold)
            count("door/criteria", len(time))
    if REACTIONS in found:
        for columns in parts(bag, found, REACTIONS, MOST_PLOTTED):
            view.log_reactions(stamps(columns), reaction_names(columns), columns["degree"])
            count("door/reactions", len(columns["degree"]))
    if TEMPERATURE in found:
        for columns in parts(bag, found, TEMPERATURE, MOST_PLOTTED):
            view.log_furnace(stamps(columns), columns["temperature"])
            count("door/furnace", len(columns["temperature"]))
    if IMAGE in found:
        for columns in parts(bag, found, IMAGE, MOST_FRAMES):
            height, width = int(columns["height"][0]), int(columns["width"][0])
            data = np.ascontiguousarray(columns["data"]).view("<f4").reshape(-1, height, width)
            view.log_image(stamps(columns), data)
            count("door/infrared", len(data))
