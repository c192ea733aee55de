"""Random scenes with the formulation left to auto: within the envelope the tip is within the tolerance."""

import numpy as np
import pytest
from scenes import link, robot

from flexsim_node import load_scene, resolve_effects, simulate
from flexsim_node.scene.torque_profile import torque_profile
from flexsim_node.scene.variants import nothing_left_out

FEW = (4, 8, 15)  # seeds: co_moving and the ERLS, effects left to auto and not
NIGHTLY = 60


def random_scene(random):
    """One to three driven links in a plane, stiff or soft, with or without weight and damping."""
    count = int(random.integers(1, 4))
    side = 10.0 ** random.uniform(-2.1, -1.5)
    beam = {"youngs_modulus": 10.0 ** random.uniform(8.5, 11.3), "elements": int(random.choice([1, 2, 4, 6]))}
    links = [link(f"l{n}", {"a": random.uniform(0.2, 0.5)}, side, side, beam=beam) for n in range(count)]
    size = 3e4 * side**2 * 10.0 ** random.uniform(-1.0, 0.3)
    torque = [
        {"joint": f"l{n}_joint", "type": "sine", "amplitude": size / (1 + 3 * n),
         "frequency": random.uniform(1.0, 5.0), "phase": random.uniform(0.0, 1.0)}
        for n in range(count)
    ]  # fmt: skip
    return load_scene(robot(
        *links, gravity=[0.0, float(random.choice([0.0, -9.81])), 0.0], torque=torque, formulation="auto",
        tolerance=10.0 ** random.uniform(-5.0, -3.0), duration=0.08,
        effects="auto" if random.random() < 0.3 else {},
        damping={"beta": 2e-4} if random.random() < 0.7 else {},
        erls={"zeroed": str(random.choice(["auto", "root", "chord"]))},
        solver={"method": str(random.choice(["rosenbrock_w", "generalized_alpha"]))},
    ))  # fmt: skip


def used(seed):
    """(formulation, distance from the exact run and what it may be, m, warnings) of a run in the envelope."""
    random = np.random.default_rng([11, seed])
    scene = random_scene(random)
    try:
        decision = resolve_effects(scene)
    except ArithmeticError:  # too soft for its own motion in either formulation
        return None
    profile = torque_profile(scene)
    scale, duration = random.uniform(0.3, 1.9), scene.duration * random.uniform(0.5, 1.9)

    def drive(t):
        return scale * profile(t)

    run, exact = (simulate(s, drive, duration) for s in (scene, nothing_left_out(scene)))
    least = min(len(run.time), len(exact.time))
    off = np.max(np.linalg.norm(run.link_end[:least, -1] - exact.link_end[:least, -1], axis=1))
    told = [w for w in run.warnings if w.startswith("auto:")]
    return decision.scene.formulation, off, scene.tolerance, told


def test_a_few_random_scenes():
    """Whatever was taken and left out, the tip is within the tolerance of the exact one, or that is told."""
    several = [used(seed) for seed in FEW]
    assert {row[0] for row in several} == {"erls", "co_moving"}
    assert all(row[1] <= row[2] or row[3] for row in several), several


@pytest.mark.nightly
def test_many_random_scenes():
    found = [row for seed in range(NIGHTLY) if (row := used(seed)) is not None]
    assert len(found) > 0.8 * NIGHTLY
    assert {row[0] for row in found} == {"erls", "co_moving"}
    broken = [row for row in found if row[1] > row[2] and not row[3]]
    assert len(broken) <= 0.02 * len(found), broken
