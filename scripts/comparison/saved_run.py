"""Runs of either kind: bags, and files of `flexsim simulate --save`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag, BagError
from ..bag.robot import robot_in
from . import pairing
from .bags import compare_bags
from .difference import SECOND, Compared, Comparison
from .pairing import STAMPS

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
    without: tuple[str, ...] = (),
    align: str = pairing.STAMP,
    offset: float = 0.0,
    progress: Callable[[str], None] = lambda _: None,
    robot: str = "",
) -> Comparison:
    """Compare two runs."""
    if not (is_saved(first) or is_saved(second)):
        return compare_bags(Bag(first), Bag(second), topics, without, align, offset, progress)
    if topics or without or align != pairing.STAMP:
        raise BagError("topics, and what aligns them, can be chosen where both runs are bags")
    a, b = (read(path, None, robot, every=True) for path in (first, second))
    found = Comparison()
    for name in dict.fromkeys([*a.values, *b.values]):
        if name not in a.values or name not in b.values:
            found.not_compared[name] = f"{first if name in b.values else second} does not hold it"
            continue
        i, j = pairing.equal(a.time[name], b.time[name] + round(offset * SECOND))
        rising = pairing.longest_rising(j)
        moved, i, j = len(j) - len(rising), i[rising], j[rising]
        if not len(i):
            found.not_compared[name] = "no time in common"
            continue
        only = len(a.time[name]) - len(i), len(b.time[name]) - len(j)
        topic = found.topics[name] = Compared(name, pairing.STAMP, len(i), *only, moved)
        x, y = a.values[name][i], b.values[name][j]
        topic.of("").add(a.time[name][i], x.reshape(len(i), -1), y.reshape(len(j), -1))
    if a.joint_names and b.joint_names and a.joint_names != b.joint_names:
        found.not_compared["joints"] = f"{', '.join(a.joint_names)} in A, {', '.join(b.joint_names)} in B"
    return found


def read(path: Path, most: int | None = MOST, robot: str = "", every: bool = False) -> SavedRun:
    """Read a run of a bag's robot; where it has more than `most` times, about so many of them.

    every : whether times that come again, as after a reset, are kept; else each is taken once, rising

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
        _, columns = bag.columns(
            topic, [*quantities.values(), *more, *STAMPS[0]], period=period, by_joint=True
        )
        stamp = columns[STAMPS[0][0]].astype(np.int64) * SECOND + columns[STAMPS[0][1]]
        unique, first = (stamp, np.arange(len(stamp))) if every else np.unique(stamp, return_index=True)
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


def arrays_of(path: Path) -> dict[str, NDArray[Any]]:
    """Return the arrays of a run that `flexsim simulate --save` wrote; raises BagError where it is none."""
    try:
        with np.load(path, allow_pickle=False) as saved:
            return {name: saved[name] for name in saved.files}
    except (ValueError, EOFError, KeyError, BadZipFile) as problem:
        raise BagError(
            f"{path} can't be read as a run that flexsim simulate --save wrote: {problem}"
        ) from None
