"""Many runs at once: how far a payload's mass and a controller's gain let the tip swing, 60 robots."""

from pathlib import Path

import numpy as np

from flexsim_node import load_scene, simulate_many

CONFIG = Path(__file__).parents[1] / "config"
GAINS, MASSES = (4.0, 8.0, 16.0), np.linspace(0.0, 0.2, 20)


def servo(time, position, velocity, given, memory, torque):
    """A joint PD that moves to given[0]; numba compiles it, so that no run waits for Python."""
    for i in range(torque.size):
        torque[i] = given[1] * (given[0] - position[i]) - given[2] * velocity[i]


scene = load_scene(CONFIG / "planar_double_pendulum.yaml", {"gravity": [0.0, 0.0, 0.0]})
overrides = [{"links.link_2.payload": {"mass": m}} for _ in GAINS for m in MASSES]
given = [[0.3, gain, 1.0] for gain in GAINS for _ in MASSES]
runs = simulate_many(
    scene, overrides, law=servo, given=np.array(given), duration=2.0, sample_period=0.01, control_period=0.001
)
assert set(runs.status) == {"ok"}

print("gain/Nm   overshoot of joint 1/mrad: mean   least   most")
over = 1e3 * (runs.joint_position[:, :, 0].max(axis=1) - 0.3).reshape(len(GAINS), -1)
for gain, values in zip(GAINS, over, strict=True):
    print(f"{gain:7.1f} {values.mean():32.2f} {values.min():7.2f} {values.max():6.2f}")
