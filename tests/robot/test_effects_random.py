"""Random scenes with effects left to auto: within the envelope the tolerance holds, outside is warned."""

import numpy as np
import pytest
from scenes import link, robot

from flexsim_node import load_scene, resolve_effects, simulate
from flexsim_node.scene.torque_profile import torque_profile
from flexsim_node.scene.variants import everything_open_on

NIGHTLY = 100


def random_scene(random):
    """Two driven links, stiff or soft, with or without weight."""
    side = 10.0 ** random.uniform(-2.0, -1.4)
    links = [link(f"l{n}", {"a": random.uniform(0.3, 0.6)}, side, 1.3 * side) for n in range(2)]
    size = 10.0 ** random.uniform(-0.5, 1.0)
    torque = [
        {"joint": f"l{n}_joint", "type": "sine", "amplitude": size / (1 + 3 * n),
         "frequency": random.uniform(1.0, 4.0), "phase": random.uniform(0.0, 1.0)}
        for n in range(2)
    ]  # fmt: skip
    return load_scene(robot(
        *links, gravity=[0.0, float(random.choice([0.0, -9.81])), 0.0], torque=torque, effects="auto",
        tolerance=10.0 ** random.uniform(-5.0, -3.0), duration=0.15, damping={"alpha": 0.5, "beta": 2e-4},
        initial={"shape": "static"} if random.random() < 0.3 else {},
    ))  # fmt: skip


def used(seed):
    """(true change, tolerance, warnings within; warnings outside) of one scene; None where nothing is out."""
    random = np.random.default_rng([5, seed])
    scene = random_scene(random)
    decision = resolve_effects(scene)
    if decision.envelope is None:
        return None
    full, profile = everything_open_on(scene), torque_profile(scene)
    scale, duration = random.uniform(0.3, 1.9), scene.duration * random.uniform(0.5, 1.9)

    def within(t):
        return scale * profile(t)

    own, right = simulate(scene, within, duration), simulate(full, within, duration)
    change = np.max(np.linalg.norm(own.link_end[:, -1] - right.link_end[:, -1], axis=1))

    def beyond(t):
        return random_far * profile(t)

    random_far = random.uniform(3.0, 30.0)
    out = simulate(scene, beyond, scene.duration)
    told = [w for w in own.warnings if w.startswith("auto:")]
    return change, scene.tolerance, told, [w for w in out.warnings if w.startswith("auto:")], out.status


@pytest.mark.nightly
def test_a_hundred_random_scenes():
    found = [row for seed in range(NIGHTLY) if (row := used(seed)) is not None]
    assert len(found) > 0.5 * NIGHTLY
    broken = [row for row in found if row[0] > row[1] and not row[2]]
    assert len(broken) <= 0.01 * len(found), broken
    assert all(row[3] or row[4] != "ok" for row in found)
