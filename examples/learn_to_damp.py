"""Learning to damp: a controller that knows nothing learns, by evolution, to take out vibration."""

from pathlib import Path

import numpy as np

from flexsim_node import load_scene
from flexsim_node.gym import FlexibleArms, Settle

CONFIG = Path(__file__).parents[1] / "config"
CANDIDATES, BEST, GENERATIONS, TRIALS = 12, 3, 8, 2

scene = load_scene(CONFIG / "planar_double_pendulum.yaml", {"gravity": [0.0, 0.0, 0.0]})
torque = np.array([2.0, 0.5])  # N m, of an action of 1
arms = FlexibleArms(
    scene, Settle(push=1.0), CANDIDATES * TRIALS, control_period=0.01, duration=1.0, torque=torque
)


def rewards(gains, seed):
    """Mean reward of each candidate's linear feedback (candidates, 2, 4), all under the same kicks."""
    seen, _ = arms.reset(seed=[seed + k for k in range(TRIALS)] * CANDIDATES)
    each, total = np.repeat(gains, TRIALS, axis=0), np.zeros(arms.num_envs)
    for _ in range(100):
        seen, reward, _, _, _ = arms.step(np.clip(np.einsum("kij,kj->ki", each, seen), -1.0, 1.0))
        total += reward
    return total.reshape(CANDIDATES, TRIALS).mean(axis=1)


rng = np.random.default_rng(0)
mean, width = np.zeros((2, 4)), np.full((2, 4), 0.5)
print("generation   mean reward of the best")
for generation in range(GENERATIONS):
    gains = mean + width * rng.standard_normal((CANDIDATES, 2, 4))
    gains[0] = mean
    score = rewards(gains, seed=1)
    order = np.argsort(score)[::-1]
    best = gains[order[:BEST]]
    mean, width = best.mean(axis=0), best.std(axis=0) + 0.05
    if generation % 2 == 0 or generation == GENERATIONS - 1:
        print(f"{generation:10d} {score[order[0]]:25.2f}")
test = rewards(np.array([0.0 * mean, mean] * (CANDIDATES // 2)), seed=10_000)
print(f"kicks it has not seen: without a controller {test[0]:.2f}, with what it learned {test[1]:.2f}")
