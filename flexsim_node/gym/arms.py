"""Many robots of a scene as one Gymnasium vector environment."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from ..scene.load import Scene
from .arm import FlexibleArm
from .tasks import Task


class FlexibleArms(VectorEnv[np.ndarray, np.ndarray, np.ndarray]):
    """`count` robots as of FlexibleArm, each with its own draws; (count, ...) of everything.

    keys : those of FlexibleArm

    Robot k of a seed is FlexibleArm of the seed plus k. After an episode's end the next step begins the next
    one, and its reward is 0 (Gymnasium's NEXT_STEP).
    """

    metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP, "render_modes": []}  # noqa: RUF012

    def __init__(self, scene: Scene, task: Task, count: int, **keys: Any) -> None:
        if count < 1:
            raise ValueError(f"count {count!r}; give at least one robot")
        self.num_envs, self.render_mode = count, None
        self.arms = [FlexibleArm(scene, copy.deepcopy(task), **keys) for _ in range(count)]
        self.single_observation_space = self.arms[0].observation_space
        self.single_action_space = self.arms[0].action_space
        self.observation_space = batch_space(self.single_observation_space, count)
        self.action_space = batch_space(self.single_action_space, count)
        self.over = np.zeros(count, dtype=bool)

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode of each."""
        if seed is None or isinstance(seed, int):
            seeds = [None if seed is None else seed + k for k in range(self.num_envs)]
        else:
            seeds = list(seed)
            if len(seeds) != self.num_envs:
                raise ValueError(f"{len(seeds)} seeds for {self.num_envs} robots; give one each, or one")
        self.over[:] = False
        seen = [arm.reset(seed=own)[0] for arm, own in zip(self.arms, seeds, strict=True)]
        return np.array(seen), {}

    def step(
        self, actions: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """One control period of each."""
        seen, rewards = np.zeros(self.observation_space.shape or ()), np.zeros(self.num_envs)
        ended, cut = np.zeros((2, self.num_envs), dtype=bool)
        reasons = np.full(self.num_envs, "", dtype=object)
        for k, arm in enumerate(self.arms):
            if self.over[k]:
                seen[k] = arm.reset()[0]
                continue
            seen[k], rewards[k], ended[k], cut[k], info = arm.step(actions[k])
            reasons[k] = info.get("reason", "")
        self.over = ended | cut
        told = {"reason": reasons, "_reason": reasons != ""} if np.any(reasons != "") else {}
        return seen, rewards, ended, cut, told
