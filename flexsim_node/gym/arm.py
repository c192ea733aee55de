"""A scene as a Gymnasium environment."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import gymnasium
import numpy as np

from ..scene.load import Scene
from .episodes import Draw, Episodes, Servo
from .tasks import Task


class FlexibleArm(gymnasium.Env[np.ndarray, np.ndarray]):
    """Any robot scene, one control period a step.

    Actions are (actuated joints,), -1 to 1: torques, or with a `servo` the speeds of the joints' goals.
    Observations are joint positions (m,) and velocities (m,), as the encoders show them, what the task shows,
    and the readings of `sensors`. An episode that ends because the robot can't go on is `terminated`, loses
    FAILED (episodes.py), and has the `reason` in its info; one whose time is over is `truncated`. Episodes
    are the same, bit for bit, for the same seed and actions.

    Parameters
    ----------
    scene : a Scene
    task : Reach(), Settle(), Track(), or one of your own (tasks.Task)
    control_period, duration : s, between actions and of an episode
    torque : (actuated joints,) N m or N of an action of 1; the joints' effort_limit where None
    servo : actions move these instead
    sensors : names of the scene's sensors that are seen too
    randomize : keys of the scene, as of load_scene's overrides, to what each episode draws: (low, high), a
        list of choices, a function of a NumPy generator, or for `seed` True
    render_mode : "rerun": render() logs the links to rerun's current recording, at the simulated time

    Raises
    ------
    ValueError, SceneError
        for what can't be
    """

    metadata = {"render_modes": ["rerun"], "render_fps": 50}  # noqa: RUF012  Gymnasium's own way

    def __init__(
        self,
        scene: Scene,
        task: Task,
        *,
        control_period: float = 0.01,
        duration: float = 2.0,
        torque: np.ndarray | None = None,
        servo: Servo | None = None,
        sensors: Sequence[str] = (),
        randomize: Mapping[str, Draw] | None = None,
        render_mode: str | None = None,
    ) -> None:
        if render_mode not in (None, "rerun"):
            raise ValueError(f"render_mode {render_mode!r}; give 'rerun', or none")
        self.render_mode = render_mode
        self.episodes = Episodes(
            scene, task, control_period, duration, torque, servo, sensors, randomize or {}
        )
        size = self.episodes.begin(np.random.default_rng(0)).size
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (size,), np.float64)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, self.episodes.scale.shape, np.float64)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode."""
        super().reset(seed=seed)
        return self.episodes.begin(self.np_random), {}

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """One control period."""
        reward, failed, over, reason = self.episodes.act(action)
        return self.episodes.seen(), reward, failed, over, {"reason": reason} if reason else {}

    def render(self) -> None:
        """Log the links' nodes to rerun, where the mode is that."""
        if self.render_mode is None:
            return
        import rerun

        robot = self.episodes.robot
        assert robot is not None, "reset comes first"
        position = robot.look().position
        first = robot.model.first_node
        strips = [position[a:b].copy() for a, b in itertools.pairwise(first)]
        rerun.set_time("time", duration=robot.time)
        rerun.log("robot", rerun.LineStrips3D(strips))
