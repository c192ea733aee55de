"""Runs of either kind: bags, and files of `flexsim simulate --save`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag, BagError
from ..bag.robot import robot_in
from .aligned import SECOND, STAMPS
from .difference import Difference, arrays_of, differences

JOINTS = "sensor_msgs/msg/JointState"
STATE = "flexsim_msgs/msg/ElasticState"
FIRST = 1  # ns: the initial state's stamp
# Arrays of a saved run, and where a bag has them.
PLACES = {
    "joint_position": (JOINTS, "position"),
    "joint_velocity": (JOINTS, "velocity"),
    "node_position": (STATE, "position"),
    "rigid_position": (STATE, "rigid_position"),
    "node_displacement": (STATE, "displacement"),
}
# More than this, and a picture or a view shows no more.
MOST = 20_000
ENDINGS = (".npz",)


@dataclass(frozen=True)
class SavedRun:
    """A robot's run as arrays.

    Attributes
    ----------
    joint_names : (m,)
    time : quantity to (K,) ns
    values : quantity to (K, ...)
    bag : the bag that it was read from, or None
    """

    joint_names: tuple[str, ...]
    time: dict[str, NDArray[np.int64]]
    values: dict[str, NDArray[np.float64]]
    bag: Bag | None = None


def is_saved(path: Path) -> bool:
    """Say whether a path is that of a saved run."""
    return path.suffix in ENDINGS and path.is_file()


def compared(
    first: Path,
    second: Path,
    topics: tuple[str, ...],
    progress: Callable[[str, float], None] = lambda *_: None,
    robot: str = "",
) -> tuple[list[Difference], tuple[Path, Path]]:
    """Compare two runs; returns the differences, and what is to be shown."""
    if not (is_saved(first) or is_saved(second)):
        return differences(Bag(first), Bag(second), topics, progress), (first, second)
    if topics:
        raise BagError("topics can be chosen where both runs are bags")
    a, b = read(first, None, robot), read(second, None, robot)
    found = []
    for name in PLACES:
        if name in a.values and name in b.values:
            difference = Difference(name)
            common, i, j = np.intersect1d(a.time[name], b.time[name], return_indices=True)
            difference.only_first = len(a.time[name]) - len(common)
            difference.only_second = len(b.time[name]) - len(common)
            x, y = a.values[name][i], b.values[name][j]
            difference.add(common, x.reshape(len(common), -1), y.reshape(len(common), -1))
            found.append(difference)
    if not any(d.compared for d in found):
        raise BagError(f"{first} and {second} have no times in common")
    return found, (first, second)


def read(path: Path, most: int | None = MOST, robot: str = "") -> SavedRun:
    """Read a run of a bag's robot; where it has more than `most` times, about so many of them.

    Raises
    ------
    BagError
        It is neither a bag of a robot nor a saved run.
    """
    if is_saved(path):
        return from_arrays(path, arrays_of(path), most)
    bag = Bag(path, robot)
    time: dict[str, NDArray[np.int64]] = {}
    values: dict[str, NDArray[np.float64]] = {}
    names: tuple[str, ...] = ()
    found = robot_in(bag)
    for kind, topic in ((JOINTS, found.joints), (STATE, found.state)):
        if topic is None:
            continue
        quantities = {q: f for q, (k, f) in PLACES.items() if k == kind}
        count = bag.topic(topic).count
        period = bag.duration / most if most and count > most else 0.0
        more = ["name"] if kind == JOINTS else []
        _, columns = bag.columns(topic, [*quantities.values(), *more, *STAMPS[0]], period=period)
        stamp = columns[STAMPS[0][0]].astype(np.int64) * SECOND + columns[STAMPS[0][1]]
        unique, first = np.unique(stamp, return_index=True)
        for quantity, field in quantities.items():
            time[quantity] = unique
            values[quantity] = columns[field][first]
        if more:
            names = tuple(columns["name"][0])
    if not values:
        raise BagError(f"{path} holds no robot")
    return SavedRun(names, time, values, bag)


def from_arrays(path: Path, arrays: dict[str, NDArray[Any]], most: int | None) -> SavedRun:
    """Read what `flexsim simulate --save` wrote."""
    if "time" not in arrays or "joint_position" not in arrays:
        raise BagError(f"{path} is not a run that flexsim simulate --save wrote")
    stride = 1 + len(arrays["time"]) // most if most else 1
    time = np.rint(arrays["time"] * SECOND).astype(np.int64)[::stride]
    time = np.maximum(time, FIRST)
    values = {n: arrays[n].reshape(len(arrays["time"]), -1)[::stride] for n in PLACES if n in arrays}
    return SavedRun(tuple(map(str, arrays["joint_names"])), dict.fromkeys(values, time), values)
