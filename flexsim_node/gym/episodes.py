"""Episodes of one robot: what an environment does, without Gymnasium's words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..analysis.decide import decided
from ..equations.dynamics.acceleration import OK
from ..motion.simulation import Simulation
from ..motion.validity import LOOK_PERIOD
from ..scene.load import Scene, load_scene
from ..scene.variants import starting
from .tasks import Task

Draw = tuple[float, float] | Sequence[Any] | Callable[[np.random.Generator], Any]
FAILED = 10.0
"""What an episode loses where its robot can't go on: as much as the worst ten seconds."""


@dataclass(frozen=True)
class Servo:
    """Joint servos that an environment's actions move: an action of 1 turns a joint's goal at `speed`.

    Attributes
    ----------
    stiffness, damping : (actuated joints,) N m/rad and N m s/rad
    speed : (actuated joints,) rad/s or m/s, or one for all
    """

    stiffness: np.ndarray
    damping: np.ndarray
    speed: np.ndarray | float = 1.0


class Episodes:
    """Episodes of one robot, the same for the same seeds and actions.

    Parameters
    ----------
    scene : for all of them; what it leaves to `auto` is decided once
    task : what is rewarded
    control_period : s between actions, of which the scene's step is made a whole part
    duration : s of an episode
    torque : (actuated joints,) N m or N of an action of 1; the joints' effort_limit where None
    servo : actions move these instead of giving torques
    sensors : names of the scene's sensors that are seen too
    randomize : scene keys to what each episode draws: (low, high), a list of choices, or a function of a
        generator; and "seed": True for other noise in the scene's faults each time

    Raises
    ------
    ValueError
        for what can't be
    """

    def __init__(
        self,
        scene: Scene,
        task: Task,
        control_period: float,
        duration: float,
        torque: np.ndarray | None,
        servo: Servo | None,
        sensors: Sequence[str],
        randomize: Mapping[str, Draw],
    ) -> None:
        self.scene, self.task = decided(scene), task
        self.duration, self.period, self.servo = duration, control_period, servo
        if not (0.0 < control_period <= duration < np.inf):
            raise ValueError(
                f"control_period {control_period!r}, duration {duration!r}; give seconds, the first"
                " the smaller"
            )
        self.substeps = max(1, int(np.ceil(control_period / scene.solver.step - 1e-9)))
        self.steps = round(duration / control_period)
        self.randomize = dict(randomize)
        self.base = self.scene.model_dump()
        self.motors = np.flatnonzero([joint.actuated for joint in scene.joints])
        names = [scene.joint_names[k] for k in self.motors]
        if servo is None:
            limit = [scene.joints[k].effort_limit for k in self.motors] if torque is None else torque
            given: np.ndarray = np.array(
                [np.nan if x is None else x for x in np.atleast_1d(np.asarray(limit, dtype=object))], float
            )
            if given.shape != (len(names),) or not np.all(np.isfinite(given)):
                raise ValueError(
                    f"{scene.name}: what torque is an action of 1? give torque=[...] for {', '.join(names)},"
                    " or an effort_limit for each"
                )
            self.scale = given
        else:
            if torque is not None:
                raise ValueError("torque and servo are both given; give one of them")
            shape = (len(names),)
            try:
                self.stiffness = np.broadcast_to(np.asarray(servo.stiffness, dtype=float), shape)
                self.damping = np.broadcast_to(np.asarray(servo.damping, dtype=float), shape)
                self.scale = np.broadcast_to(np.asarray(servo.speed, dtype=float), shape)
            except ValueError:
                raise ValueError(
                    f"servo: give a value for each of {', '.join(names)}, or one for all"
                ) from None
        known = [sensor.name for sensor in scene.sensors]
        for name in sensors:
            if name not in known:
                raise ValueError(f"{scene.name}: no sensor {name!r}; it has {', '.join(known) or 'none'}")
        self.sensors = tuple(sensors)
        self.robot: Simulation | None = None
        self.count, self.looked = 0, 0.0
        self.goal: np.ndarray = np.zeros(len(names))

    def begin(self, rng: np.random.Generator) -> np.ndarray:
        """Begin an episode; what is seen of it."""
        change = {key: drawn(draw, rng) for key, draw in self.randomize.items()}
        if change or self.robot is None:
            scene = load_scene(self.base, change) if change else self.scene
            self.robot = Simulation(scene, self.period / self.substeps)
            if self.robot.advance is None:
                raise ValueError(
                    f"{scene.name}: {scene.solver.method} has no fixed steps; give another method"
                )
            self.robot.warm()
        robot = self.robot
        robot.start_at(kicked(robot.scene if change else self.scene, self.task.kick(robot.model.joints, rng)))
        robot.prepare()
        self.count, self.looked = 0, 0.0
        self.goal = robot.model.shown(robot.x)[self.motors].copy()
        self.task.begin(robot, rng)
        return self.seen()

    def seen(self) -> np.ndarray:
        """(k,) joint positions and velocities, the task's own, the sensors'."""
        robot = self.robot
        assert robot is not None
        parts = [robot.joint_position(), robot.joint_velocity(), self.task.shown(robot, robot.time)]
        if self.sensors:
            readings = robot.sense()
            parts += [readings[name] for name in self.sensors]
        return np.concatenate(parts)

    def act(self, action: np.ndarray) -> tuple[float, bool, bool, str]:
        """Take an action (actuated joints,) in -1 to 1: its reward, whether the robot can't go on, whether
        the time is over, and why."""
        robot = self.robot
        assert robot is not None, "reset comes first"
        torque = np.zeros(robot.model.joints)
        given = np.asarray(action, dtype=float)
        if given.shape != self.scale.shape or not np.all(np.isfinite(given)):
            raise ValueError(f"action {action!r}; give {self.scale.size} finite values from -1 to 1")
        push = self.scale * np.clip(given, -1.0, 1.0)
        for n in range(self.substeps):
            if self.servo is not None:
                self.goal += push * (self.period / self.substeps)
                error = self.goal - robot.joint_position()[self.motors]
                rate = robot.joint_velocity()[self.motors]
                torque[self.motors] = self.stiffness * error - self.damping * rate
                robot.command(torque)
            elif n == 0:
                torque[self.motors] = push
                robot.command(torque)
            if self.count == n == 0:  # the first torque is there from the start
                robot.prepare()
            if robot.step() != OK:
                break
        if robot.status == OK and robot.time >= self.looked:
            self.looked = robot.time + LOOK_PERIOD
            robot.check()
        self.count += 1
        if robot.status != OK:
            return -FAILED, True, False, robot.reason
        over = self.count >= self.steps
        return self.task.reward(robot, robot.time, self.period), False, over, ""


def drawn(draw: Any, rng: np.random.Generator) -> Any:
    """One episode's value."""
    if draw is True:
        return int(rng.integers(2**31))
    if callable(draw):
        return draw(rng)
    if isinstance(draw, tuple) and len(draw) == 2:
        return float(rng.uniform(*draw))
    return list(draw)[int(rng.integers(len(draw)))]


def kicked(scene: Scene, kick: np.ndarray) -> Scene:
    """The scene with joint rates (m,) on top of its own at the start."""
    if not np.any(kick):
        return scene
    return starting(scene, "velocity", scene.start("velocity") + kick)
