"""A motor that follows a given motion: how far the tip swings behind a rigid robot."""

from pathlib import Path

import numpy as np

from flexsim_node import load_scene, simulate

CONFIG = Path(__file__).parents[1] / "config"


def turn(duration: float, angle: float):
    """A fifth-order move from 0 to `angle`: position, velocity, acceleration."""

    def at(t: float) -> tuple[float, float, float]:
        s = min(t / duration, 1.0)
        place = 10 * s**3 - 15 * s**4 + 6 * s**5
        rate = 30 * s**2 - 60 * s**3 + 30 * s**4
        change = 60 * s - 180 * s**2 + 120 * s**3
        return angle * place, angle * rate / duration, angle * change / duration**2

    return at


scene = load_scene(CONFIG / "planar_double_pendulum.yaml", {"gravity": [0.0, 0.0, 0.0]})
still = turn(1.0, 0.0)
print("move of 1 rad in   largest deflection on the way   left 0.2 s after it")
for duration in (0.8, 0.4, 0.2):
    motion = {"joint_1": turn(duration, 1.0), "joint_2": still}
    run = simulate(scene, duration=duration + 0.2, prescribed=motion)
    bent = 1e3 * np.linalg.norm(run.node_position[:, -1] - run.rigid_position[:, -1], axis=1)
    print(f"{duration:14.1f} s {bent.max():27.3f} mm {bent[-50:].max():19.3f} mm")
