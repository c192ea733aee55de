"""What drove a recorded robot: the torque in force in each period of its joint states."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from flexsim_ros.published_scene import PublishedScene
from numpy.typing import NDArray

from ..bag import Bag, BagError
from ..bag.robot import robot_in

SECOND = 1_000_000_000
LAYOUT = "flexsim_msgs/msg/ElasticLayout"
STAMP = ["header.stamp.sec", "header.stamp.nanosec"]
# The initial state bears 1 ns, since zero means "no time" to ROS.
FIRST = 1
# Of a node that is driven again, these are our choice.
CHOSEN = ("scene", "mode", "wait_for_command", "command_timeout", "use_sim_time")


@dataclass(frozen=True)
class Drive:
    """The torques of a run, and the scene that they drove.

    Attributes
    ----------
    joint_names : (m,)
    period : int, ns
        From one joint state to the next; of a tick, where it is known tick by tick.
    torque : (K, m), N m or N
        In force in each period; the effort of the joint state at its end.
    scene : PublishedScene or None
        What the node published of the scene that it ran; None: why_not says why the bag has none.
    parameters : dict
        Those of the node that ran it, where the bag holds them.
    """

    joint_names: tuple[str, ...]
    period: int
    torque: NDArray[np.float64]
    scene: PublishedScene | None
    why_not: str
    parameters: dict[str, Any]
    ticks: int = 1
    """How many periods there are to a joint state."""

    @property
    def rate(self) -> float:
        """Periods a second, Hz."""
        # A period need not be a whole number of nanoseconds; then the node's parameter says more.
        said = self.ticks * float(self.parameters.get("rate", 0.0))
        near = abs(said * self.period / SECOND - 1.0) < 1e-3
        return said if near else SECOND / self.period

    @property
    def duration(self) -> float:
        """Simulated time, s."""
        return len(self.torque) / self.rate

    @property
    def overrides(self) -> dict[str, Any]:
        """What the node changed of its file, by key; the scene that it published has it."""
        return overrides_of(self.parameters) if self.scene is None else dict(self.scene.overrides)

    def held(self, source: str, joint_names: tuple[str, ...], steps: int, step: float) -> NDArray[np.float64]:
        """Return the torque (steps, m) in force at each of a simulation's steps, s long.

        Raises
        ------
        BagError
            The joints are others.
        """
        if sorted(joint_names) != sorted(self.joint_names):
            raise BagError(
                f"{source} drives {', '.join(self.joint_names)}; the scene has {', '.join(joint_names)}"
            )
        order = [self.joint_names.index(name) for name in joint_names]
        # A time that is a period's beginning but for rounding belongs to that period.
        at = ((np.arange(steps) + 1e-6) * step * self.rate).astype(np.int64)
        return self.torque[np.minimum(at, len(self.torque) - 1)][:, order]


def overrides_of(parameters: dict[str, Any]) -> dict[str, Any]:
    """Return what a node changed of its scene, by key."""
    prefix = "override."
    return {n.removeprefix(prefix): v for n, v in parameters.items() if n.startswith(prefix)}


def stamps(columns: dict[str, NDArray[Any]]) -> NDArray[np.int64]:
    """Return the times of messages, ns, by their stamps."""
    return columns[STAMP[0]].astype(np.int64) * SECOND + columns[STAMP[1]]


def read_drive(bag: Bag, topic: str | None = None) -> Drive:
    """Find out what drove a recorded robot.

    Raises
    ------
    BagError
        The bag has no joint states with effort, or lacks some of them, so that it is not known
        what the torque was.
    """
    name = joint_topic(bag) if topic is None else topic
    _, columns = bag.columns(name, ["name", "effort", *STAMP], by_joint=True)
    time, first = np.unique(stamps(columns), return_index=True)
    time = np.where(time == FIRST, 0, time)
    effort = columns["effort"][first]
    names = tuple(columns["name"][first[0]])
    if effort.ndim != 2 or effort.shape[1] != len(names):
        raise BagError(f"{bag.path}: {name} bears no effort, so it is not known what drove the robot")
    if any(tuple(other) != names for other in columns["name"]):
        raise BagError(f"{bag.path}: the joints of {name} change on the way")
    if len(time) < 2:
        raise BagError(f"{bag.path}: {name} has no motion: {len(time)} times")
    period = int(np.min(np.diff(time)))
    number = np.rint(time / period).astype(np.int64)
    if (np.abs(number * period - time) > len(time)).any():
        raise BagError(f"{bag.path}: the times of {name} are no whole number of periods apart")
    if number[0] > 1:
        raise BagError(
            f"{bag.path}: {name} begins at {time[0] / SECOND:g} s, not at the run's beginning, so what "
            "drove the robot before is not known; begin recording before the robot moves"
        )
    gaps = np.flatnonzero(np.diff(number) > 1)
    if len(gaps):
        raise BagError(
            f"{bag.path}: {name} lacks {number[gaps[0] + 1] - number[gaps[0]] - 1} states behind "
            f"{time[gaps[0]] / SECOND:g} s, so it is not known what drove the robot there"
        )
    torque = np.ascontiguousarray(effort[number >= 1])
    if not np.isfinite(torque).all():
        raise BagError(f"{bag.path}: an effort of {name} is not finite")
    robot = robot_in(bag)
    return Drive(names, period, torque, robot.scene, robot.why_not, robot.parameters)


def joint_topic(bag: Bag) -> str:
    """Return the topic that says what the joints did."""
    found = robot_in(bag).joints
    if found is None:
        raise BagError(f"{bag.path} holds no joint states, so it is not known what drove a robot")
    return found


def node_parameters(drive: Drive, scene: Path, changes: dict[str, Any]) -> dict[str, Any]:
    """Return the parameters of a node that is to go through the run again, in lock-step.

    changes : what it is to change of the scene, by key
    """
    given = {n: v for n, v in drive.parameters.items() if n not in CHOSEN and "qos_overrides" not in n}
    given = {n: v for n, v in given.items() if not n.startswith("override.")}
    given |= {f"override.{key}": value for key, value in changes.items()}
    given = {n: v for n, v in given.items() if n != "start_type_description_service"}
    given |= {"scene": str(scene), "mode": "lockstep", "rate": drive.rate}
    # Each tick is answered by a joint state; all else comes as often as it did.
    for name in ("elastic_rate", "shape_rate", "clock_rate"):
        # In lock-step nothing is published more often than joint states are.
        if float(given.get(name, 0.0)) > drive.rate:
            given[name] = drive.rate
    return given
