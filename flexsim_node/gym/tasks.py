"""What an environment rewards: to reach a point, to settle without vibration, to follow a motion."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ..model.chain import TIP
from ..motion.simulation import Simulation, copy_to_motors


class Task(Protocol):
    """A task; one object serves one robot.

    `kick` (m,) of joint rates, rad/s or m/s, is added to the scene's at an episode's start.
    """

    def kick(self, joints: int, rng: np.random.Generator) -> np.ndarray:
        """Draw what the joints' rates at the start are more than the scene's, (m,)."""

    def begin(self, robot: Simulation, rng: np.random.Generator) -> None:
        """Draw an episode's goal; the robot is at its start."""

    def shown(self, robot: Simulation, t: float) -> np.ndarray:
        """What a controller sees of the goal at time t, always as many numbers."""

    def reward(self, robot: Simulation, t: float, period: float) -> float:
        """Of the control period that ended at t, s; 0 is best."""


class Tip:
    """The tip of a robot, and where it would be if nothing bent.

    Attributes
    ----------
    reach : m, the lengths of all links together
    """

    def __init__(self, robot: Simulation) -> None:
        tips = robot.scene.tips
        if len(tips) != 1:
            raise ValueError(
                f"{robot.scene.name}: it has {len(tips)} tips, a task needs one; name it with `tip: true`"
            )
        self.link = tips[0]
        self.reach = float(np.sum(np.abs(robot.model.chain.joint[:, TIP]))) or 1.0

    def now(self, robot: Simulation) -> np.ndarray:
        """(3,) m, in the base frame."""
        return robot.look().link_end[self.link].copy()

    def rigid(self, robot: Simulation, position: np.ndarray) -> np.ndarray:
        """(3,) m, with undeformed links and the joints at position (m,)."""
        if robot.scene.loops:
            raise ValueError(f"{robot.scene.name}: it has loops, so that joints can't be set one by one")
        x = np.zeros(robot.model.unknowns)
        x[: robot.model.joints] = position
        copy_to_motors(robot.model, x)
        robot.view.look(robot.work, x)
        found = robot.view.rigid_position[robot.view.ends[self.link]].copy()
        robot.look()
        return found


@dataclass
class Reach:
    """Bring the tip to a point, and hold it there.

    The point is where the rigid robot's tip is with each joint within `spread` (rad or m) of the start. What
    is seen is the way from the tip's start to it, over the reach. The reward is minus the tip's distance from
    it, over the reach.
    """

    spread: float = 1.0

    def kick(self, joints: int, rng: np.random.Generator) -> np.ndarray:
        """None."""
        return np.zeros(joints)

    def begin(self, robot: Simulation, rng: np.random.Generator) -> None:
        """Draw the point."""
        self.tip = Tip(robot)
        start = robot.model.shown(robot.x)
        self.goal = self.tip.rigid(robot, start + rng.uniform(-self.spread, self.spread, start.size))
        self.way = (self.goal - self.tip.now(robot)) / self.tip.reach

    def shown(self, robot: Simulation, t: float) -> np.ndarray:
        """(3,)"""
        return self.way

    def reward(self, robot: Simulation, t: float, period: float) -> float:
        """Minus the distance over the reach."""
        return -float(np.linalg.norm(self.tip.now(robot) - self.goal)) / self.tip.reach


@dataclass
class Settle:
    """Come to rest at the start after a kick, with as little vibration as can be.

    Each joint's rate at the start is within `push` (rad/s or m/s) of the scene's. The reward is minus the
    tip's distance from its place at rest over the reach, and minus its speed times `patience` (s) over the
    reach.
    """

    push: float = 1.0
    patience: float = 0.1

    def kick(self, joints: int, rng: np.random.Generator) -> np.ndarray:
        """The push."""
        return rng.uniform(-self.push, self.push, joints)

    def begin(self, robot: Simulation, rng: np.random.Generator) -> None:
        """Note where it starts."""
        self.tip = Tip(robot)
        self.home = self.last = self.tip.now(robot)

    def shown(self, robot: Simulation, t: float) -> np.ndarray:
        """Nothing: the goal never changes."""
        return np.zeros(0)

    def reward(self, robot: Simulation, t: float, period: float) -> float:
        """Minus distance and speed."""
        now = self.tip.now(robot)
        speed = np.linalg.norm(now - self.last) / period
        self.last = now
        return -float(np.linalg.norm(now - self.home) + self.patience * speed) / self.tip.reach


@dataclass
class Track:
    """Follow a smooth motion of the joints with the tip.

    Each joint is to follow q0 + a (1 - cos(2 pi f t)), a within `amplitude` (rad or m) and f, Hz, within
    `frequency`. What is seen is where the joints should be, less the start, and how fast. The reward is minus
    the tip's distance from the rigid robot's on that motion, over the reach.
    """

    amplitude: float = 0.5
    frequency: tuple[float, float] = (0.2, 1.0)
    start: np.ndarray = field(default_factory=lambda: np.zeros(0), init=False, repr=False)

    def kick(self, joints: int, rng: np.random.Generator) -> np.ndarray:
        """None."""
        return np.zeros(joints)

    def begin(self, robot: Simulation, rng: np.random.Generator) -> None:
        """Draw the motion."""
        self.tip, self.start = Tip(robot), robot.model.shown(robot.x)
        self.sizes = rng.uniform(-self.amplitude, self.amplitude, self.start.size)
        self.rates = 2.0 * np.pi * rng.uniform(*self.frequency, self.start.size)

    def wanted(self, t: float) -> tuple[np.ndarray, np.ndarray]:
        """(m,) off the start, rad or m, and the rate."""
        angle = self.rates * t
        return self.sizes * (1.0 - np.cos(angle)), self.sizes * self.rates * np.sin(angle)

    def shown(self, robot: Simulation, t: float) -> np.ndarray:
        """(2 m,)"""
        return np.concatenate(self.wanted(t))

    def reward(self, robot: Simulation, t: float, period: float) -> float:
        """Minus the distance over the reach."""
        goal = self.tip.rigid(robot, self.start + self.wanted(t)[0])
        return -float(np.linalg.norm(self.tip.now(robot) - goal)) / self.tip.reach
