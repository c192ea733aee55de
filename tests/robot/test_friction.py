"""Coulomb friction stops a joint and holds it, whatever friction, inertia, step and coulomb_speed are."""

import itertools

import numpy as np
import pytest
from scenes import link, robot

from flexsim_node import load_scene, simulate
from flexsim_node.motion.simulation import Simulation

STILL = {"gravity": [0.0, 0.0, 0.0]}


def brake(friction, inertia, step, rate=0.0, method="rosenbrock_w", **joint):
    """A rigid link of a given moment of inertia about its joint, turning at a rate."""
    body = {"mass": 1e-9, "inertia": np.diag([1.0, 1.0, 1.0]) * inertia}
    scene = robot(
        link("a", {}, None, joint={"coulomb_friction": friction, **joint}, rigid=body),
        initial={"velocity": [rate]}, solver={"step": step, "method": method}, **STILL,
    )  # fmt: skip
    scene["links"][0]["rigid"]["inertia"] = body["inertia"].tolist()
    return load_scene(scene)


@pytest.mark.parametrize("method", ["rosenbrock_w", "generalized_alpha", "runge_kutta_4"])
def test_stops_over_decades(method):
    """Rest after I w / F seconds and I w^2 / 2F rad, to F h^2 / I, over six decades of F, I and h each."""
    decades = itertools.product((1e-3, 1.0, 1e3), (1e-4, 1e-1, 1e2), (1e-5, 1e-3, 1e-1), (0.03, 0.6, 7.3))
    for friction, inertia, step, steps in decades:
        rate = steps * friction * step / inertia  # so that it turns for so many steps
        run = simulate(brake(friction, inertia, step, rate, method), duration=12 * step)
        assert run.status == "ok"
        assert np.max(np.abs(run.joint_velocity[10:])) == 0.0
        assert np.ptp(run.joint_position[10:]) <= 1e-5 * friction * step**2 / inertia
        assert np.all(run.joint_velocity > -1e-12 * rate)  # it does not turn round
        angle = 0.5 * rate * steps * step
        assert abs(run.joint_position[-1, 0] - angle) < 0.2 * friction * step**2 / inertia


@pytest.mark.parametrize("method", ["radau", "dop853"])
def test_references_find_the_moment(method):
    """The references stop where the closed form does, to their tolerance, inside a step."""
    run = simulate(brake(0.5, 1e-3, 1e-2, 3.0, method), duration=0.03)
    assert run.joint_position[-1, 0] == pytest.approx(0.5 * 9.0 * 1e-3 / 0.5, rel=1e-7)
    assert np.all(run.joint_velocity[1:] == 0.0)


@pytest.mark.parametrize("method", ["rosenbrock_w", "generalized_alpha", "runge_kutta_4", "dop853"])
def test_holds_a_load_below_it(method):
    """It does not creep under 0.999 of the friction, and moves off under 1.001 of it."""
    for step, inertia in ((1e-3, 1e-3), (1e-4, 10.0), (1e-2, 1e-5)):
        scene = brake(0.5, inertia, step, method=method)
        held = simulate(scene, lambda t: np.array([0.4995]), 50 * step)
        # where the moment of stopping is a root, rounding is left
        if method == "dop853":
            assert max(np.max(np.abs(held.joint_position)), np.max(np.abs(held.joint_velocity))) < 1e-13
        else:
            assert np.max(np.abs(held.joint_position)) < 1e-15 and np.all(held.joint_velocity == 0.0)
        moved = simulate(scene, lambda t: np.array([0.5005]), 50 * step)
        right = 0.0005 * 50 * step / inertia
        assert moved.joint_velocity[-1, 0] == pytest.approx(right, rel=1e-6)


@pytest.mark.parametrize("method", ["rosenbrock_w", "generalized_alpha"])
def test_smooth_friction_over_decades(method):
    """With a coulomb_speed s it never runs away: the rate dies out, or creeps at s artanh(T / F)."""
    decades = itertools.product((1e-3, 1.0, 1e3), (1e-4, 1.0), (1e-4, 1e-2), (1e-8, 1e-4, 1e-1))
    for friction, inertia, step, speed in decades:
        rate = 3.3 * friction * step / inertia
        scene = brake(friction, inertia, step, rate, method, coulomb_speed=speed)
        free = simulate(scene, duration=40 * step)
        fastest = np.abs(free.joint_velocity[:, 0])
        assert free.status == "ok" and fastest[0] == np.max(fastest)
        # implicit methods divide what is left by 1 + F h / (I s) a step, once the friction has turned over
        slowness = 1.0 + 0.2 * friction * step / (inertia * speed)
        left = np.exp(-30.0 * np.log(slowness))
        assert fastest[-1] < max(1e-6, rate * left, 4.0 * speed * left)
        scene = brake(friction, inertia, step, 0.0, method, coulomb_speed=speed)
        if slowness > 3.0:
            creeps = simulate(scene, lambda t, f=friction: np.array([0.5 * f]), 60 * step)
            assert creeps.joint_velocity[-1, 0] == pytest.approx(speed * np.arctanh(0.5), rel=1e-3)


def test_explicit_method_says_that_smooth_friction_is_too_steep():
    """It does not chatter about zero with status ok."""
    run = simulate(brake(0.5, 1e-3, 1e-3, 3.0, "runge_kutta_4", coulomb_speed=1e-2), duration=0.02)
    assert run.status != "ok" and "coulomb_speed" in run.status
    fine = simulate(brake(0.5, 1e-3, 2e-5, 3.0, "runge_kutta_4", coulomb_speed=1e-2), duration=0.02)
    assert fine.status == "ok" and abs(fine.joint_velocity[-1, 0]) < 1e-6


def test_same_bits_from_a_restored_state():
    """Friction keeps nothing from step to step: state and memory restored, the same steps follow.

    With frames at the roots: along chords a factorisation is kept as well.
    """
    scene = robot(
        link("a", {"a": 0.3}, joint={"coulomb_friction": 0.4}, flexible=False),
        link("b", {"a": 0.3}, joint={"coulomb_friction": 0.1}, flexible=False),
        gravity=[0.0, -2.0, 0.0], erls={"zeroed": "root"}, initial={"velocity": [2.0, -3.0]},
    )  # fmt: skip
    now = Simulation(load_scene(scene))

    def steps(count):
        for _ in range(count):
            assert now.step() == 0
        return now.x.copy(), now.v.copy()

    steps(37)
    kept = now.x.copy(), now.v.copy(), now.work.memory.copy()
    first = steps(60)
    other = Simulation(load_scene(scene))
    other.x[:], other.v[:], other.work.memory[:] = kept
    now = other
    assert np.array_equal(first, steps(60))
