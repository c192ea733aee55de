"""Finds the torque of each tick of a run whose joint states came less often than its ticks.

A joint state names the torque of the tick that led to it. Where several ticks lie between two
states, and the torque changed, there are only a few ways in which it can have: the commands came
in order, and each was in force for some of the ticks. The simulation itself says which it was.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import combinations_with_replacement, islice
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flexsim_node import Scene
from flexsim_node.analysis.decide import decide
from flexsim_node.model.chain import Workspace
from flexsim_node.motion.simulation import Simulation
from flexsim_node.service.settings import Settings, schedule

from ..bag import Bag, BagError
from .drive import SECOND, STAMP, Drive, joint_topic, stamps

COMMANDS = "std_msgs/msg/Float64MultiArray"
# Where more commands than this came within a state's period, the last of them are looked at.
MOST_COMMANDS, MOST_WAYS = 6, 500
# rad and rad/s: further off than this, and none of the ways was it.
NEAR = 1e-6


def tick_by_tick(drive: Drive, bag: Bag, scene: Scene) -> Drive:
    """Return the drive with a torque for each tick.

    Raises
    ------
    BagError
        No way in which the torques can have changed leads to the recorded states.
    """
    names = ("rate", "elastic_rate", "shape_rate", "clock_rate", "mode")
    given = Settings(scene="-", **{n: drive.parameters[n] for n in names if n in drive.parameters})
    timing = schedule(replace(given, rate=drive.rate), scene.solver.step)
    if timing.state == 1:
        return drive
    search = Search(drive, bag, scene, timing.step, timing.steps, timing.state)
    return replace(drive, period=drive.period // timing.state, torque=search.run(), ticks=timing.state)


class Search:
    """Goes through a run once more, state by state."""

    def __init__(self, drive: Drive, bag: Bag, scene: Scene, step: float, steps: int, ticks: int) -> None:
        self.drive = drive
        self.steps, self.ticks = steps, ticks
        self.robot = Simulation(decide(scene)[0], step)
        self.robot.warm()
        topic = joint_topic(bag)
        _, columns = bag.columns(topic, ["position", "velocity", *STAMP])
        time, first = np.unique(stamps(columns), return_index=True)
        moved = time >= drive.period // 2
        self.states = np.hstack([columns["position"][first], columns["velocity"][first]])[moved]
        self.commands = commands(bag, scene, self.robot.limit)
        work = (getattr(self.robot.work, name) for name in Workspace._fields)
        self._memory = [a for a in work if isinstance(a, np.ndarray)]
        self._memory += [self.robot.x, self.robot.v]

    def run(self) -> NDArray[np.float64]:
        """Return the torque (ticks, m)."""
        found = []
        before = np.zeros(self.drive.torque.shape[1])
        at = 0  # how many commands have been in force
        for k, after in enumerate(self.drive.torque):
            between, at = self._between(before, after, at)
            chosen = self._way(k, [before, *between, after])
            found += chosen
            before = after
        return np.array(found)

    def _between(
        self, before: NDArray[np.float64], after: NDArray[np.float64], at: int
    ) -> tuple[list[NDArray[np.float64]], int]:
        """Return the commands that came before the one that is in force now."""
        if (before == after).all():
            return [], at
        here = np.flatnonzero((self.commands[at:] == after).all(axis=1))
        if not len(here):
            return [], at
        nearest = at + int(here[0])
        return list(self.commands[at:nearest][-MOST_COMMANDS:]), nearest + 1

    def _way(self, k: int, torques: list[NDArray[np.float64]]) -> list[NDArray[np.float64]]:
        """Return the torques of the ticks up to state k; the last of them is known."""
        last = len(torques) - 1
        earlier = self.ticks - 1
        ways: Iterable[tuple[int, ...]] = combinations_with_replacement(range(last + 1), earlier)
        if last == 1 and (torques[0] == torques[-1]).all():
            ways = [(last,) * earlier]
        saved = [a.copy() for a in self._memory]
        best: tuple[float, tuple[int, ...]] = (np.inf, ())
        for way in islice(ways, MOST_WAYS):
            off = self._try(k, [torques[i] for i in way] + [torques[last]])
            if off < best[0]:
                best = (off, way)
            if off == 0.0:
                break
            self._restore(saved)
        if best[0] > NEAR:
            raise BagError(
                f"the torques behind {k * self.drive.period / SECOND:g} s can't be found out: joint "
                f"states came only every {self.ticks} ticks, and no order of the commands leads from one "
                f"to the next; record with rate:={self.drive.rate * self.ticks:g}"
            )
        chosen = [torques[i] for i in best[1]] + [torques[last]]
        if best[0] > 0.0:
            self._try(k, chosen)
        return chosen

    def _try(self, k: int, torques: list[NDArray[np.float64]]) -> float:
        """Step through a state's ticks; returns how far off the recorded state the robot is."""
        robot = self.robot
        for n, torque in enumerate(torques):
            robot.command(torque)
            if k == 0 and n == 0:
                robot.prepare()
            for _ in range(self.steps):
                if robot.step() != 0:
                    return np.inf
        reached = np.concatenate([robot.joint_position(), robot.joint_velocity()])
        return float(np.abs(reached - self.states[k]).max())

    def _restore(self, saved: list[NDArray[Any]]) -> None:
        self.robot.status = 0
        for here, kept in zip(self._memory, saved, strict=True):
            here[...] = kept


def commands(bag: Bag, scene: Scene, limit: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the commands (C, m) in the order in which they came, as far as the joints allow them."""
    m = len(scene.joint_names)
    found = []
    for topic in bag.topics.values():
        if topic.type == COMMANDS and topic.count and topic.name.endswith("/commands"):
            for _, message in bag.messages(topic.name):
                data = bag.decoder(topic.name).columns([message], ["data"])["data"][0]
                if data.shape == (m,) and np.isfinite(data).all():
                    found.append(np.clip(data, -limit, limit))
    return np.array(found).reshape(-1, m)
