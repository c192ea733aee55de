"""Steps are divided where a torque, a fault or a motion jumps, so that a method keeps its order."""

import numpy as np
import pytest
from scenes import link, robot

from flexsim_node import load_scene, simulate
from flexsim_node.motion.jumps import Jumps, torque_jumps

START = 0.0201933
RATE = 133.28002132  # rad/s2: 6 N m on the rod of `rod` about its end

METHODS = ["rosenbrock_w", "generalized_alpha", "runge_kutta_4"]


def rod(**keys):
    """A rigid rod, 0.5 m, 0.54 kg, that turns without weight."""
    beam = {"density": 2700.0, "youngs_modulus": 7e10}
    return robot(link("a", {"a": 0.5}, 0.02, 0.02, beam=beam, flexible=False), gravity=[0, 0, 0], **keys)


def jumping(**keys):
    torque = [{"joint": "a_joint", "type": "constant", "amplitude": 6.0, "start": START}]
    return load_scene(rod(torque=torque, **keys))


def closed_form(t, rate):
    return 0.5 * rate * np.maximum(t - START, 0.0) ** 2


def rate_of(scene):
    """rad/s2 that 6 N m give, from a run without a jump."""
    run = simulate(scene, lambda t: np.array([6.0]), 0.01)
    return run.joint_velocity[-1, 0] / run.time[-1]


@pytest.mark.parametrize("method", [*METHODS, "radau", "dop853"])
def test_a_torque_that_jumps_within_a_step(method):
    """A constant torque turns a rigid rod by a (t - t0)^2 / 2: exact, wherever in a step it begins."""
    scene = jumping(solver={"method": method, "step": 1e-3})
    rate = rate_of(scene)
    assert rate == pytest.approx(RATE, rel=1e-6)
    for step in (4e-3, 1e-3, 7e-4):
        run = simulate(jumping(solver={"method": method, "step": step}), duration=0.08, sample_period=4e-3)
        assert run.status == "ok"
        off = np.max(np.abs(run.joint_position[:, 0] - closed_form(run.time, rate)))
        assert off < 2e-9, (step, off)


@pytest.mark.parametrize("method", METHODS)
def test_a_callable_says_where_it_jumps(method):
    """Told the time, the step before ends with the torque before the jump; untold, the order is one."""
    scene = load_scene(rod(solver={"method": method, "step": 1e-3}))
    rate = rate_of(scene)

    def torque(t):
        return np.array([6.0 if t >= START else 0.0])

    told = simulate(scene, torque, 0.08, jumps=[START])
    untold = simulate(scene, torque, 0.08)
    right = closed_form(told.time, rate)
    assert np.max(np.abs(told.joint_position[:, 0] - right)) < 2e-9
    assert np.max(np.abs(untold.joint_position[:, 0] - right)) > 1e-4


@pytest.mark.parametrize("start", [0.02, 0.02 + 1e-12, 0.02 - 1e-12])
def test_a_jump_on_a_boundary_is_one(start):
    """Rounding of times makes no sliver of a step, and the step before it does not feel the torque."""
    torque = [{"joint": "a_joint", "type": "constant", "amplitude": 6.0, "start": start, "end": 0.05}]
    scene = load_scene(rod(torque=torque))
    run = simulate(scene, duration=0.08)
    rate = rate_of(scene)
    t = run.time
    pushed = np.clip(t - 0.02, 0.0, 0.03)
    right = rate * (0.5 * pushed**2 + pushed * np.maximum(t - 0.05, 0.0))
    assert np.max(np.abs(run.joint_position[:, 0] - right)) < 2e-9
    pieces = Jumps([start, 0.05]).pieces(0.019, 1e-3)
    assert len(pieces) == 1
    assert pieces[0].end < start
    assert Jumps([start]).pieces(0.02, 1e-3)[0].jumped


def test_faults_at_their_instants():
    """A push between steps: with whole steps it comes late, at its instant it is exact, delays included."""
    faults = [
        {"kind": "disturbance", "value": 6.0, "start": START, "end": 0.0411},
        {"kind": "delay", "time": 0.00137},
    ]
    scene = load_scene(rod(faults=faults))
    rate = RATE

    def command(t):
        return np.array([3.0 if t > 0.0499 else 0.0])

    exact = simulate(scene, command, 0.08, sample_period=1e-2, exact_faults=True)
    whole = simulate(scene, command, 0.08, sample_period=1e-2)
    t = exact.time
    pushed = np.clip(t - START, 0.0, 0.0411 - START)
    right = rate * (0.5 * pushed**2 + pushed * np.maximum(t - 0.0411, 0.0))
    right += 0.25 * rate * np.maximum(t - 0.05137, 0.0) ** 2
    assert np.max(np.abs(exact.joint_position[:, 0] - right)) < 1e-8
    assert np.max(np.abs(whole.joint_position[:, 0] - right)) > 1e-4


def test_a_payload_at_its_instant():
    """The body taken up between steps is felt from its instant on."""
    faults = [{"kind": "payload", "link": "a", "mass": 1.0, "start": 0.0201933}]
    scene = load_scene(rod(faults=faults, solver={"step": 2e-3}))
    fine = load_scene(rod(faults=faults, solver={"step": 2e-3 / 64}))
    torque = lambda t: np.array([6.0])  # noqa: E731
    a, b = (simulate(s, torque, 0.08, sample_period=4e-3, exact_faults=True) for s in (scene, fine))
    late = simulate(scene, torque, 0.08, sample_period=4e-3)
    off = [np.max(np.abs(r.joint_position - b.joint_position)) for r in (a, late)]
    assert off[0] < 1e-6
    assert off[1] > 100.0 * off[0]


def test_an_elastic_arm_keeps_its_order_across_jumps():
    """With a torque that begins and ends between steps the error falls with the step's square."""
    torque = [{"joint": "a_joint", "type": "constant", "amplitude": 0.5, "start": START, "end": 0.0433}]
    scene = robot(link("a", {"a": 0.5}, 0.02, 0.01, beam={"density": 2700.0, "youngs_modulus": 7e10}),
                  gravity=[0.0, 0.0, 0.0], torque=torque, damping={"beta": 1e-4})  # fmt: skip

    def tip(step, method):
        keys = {"solver.step": step, "solver.method": method}
        return simulate(load_scene(scene, keys), duration=0.08, sample_period=4e-3).link_end[:, -1]

    for method in METHODS[:2]:
        right = tip(1.5625e-5, method)
        errors = [np.max(np.linalg.norm(tip(h, method) - right, axis=1)) for h in (2.5e-4, 1.25e-4, 6.25e-5)]
        orders = np.log2(np.array(errors[:-1]) / errors[1:])
        assert np.all(orders > 1.7), (method, errors)


def test_where_the_scenes_torques_jump():
    torque = [
        {"joint": "a_joint", "type": "sine", "amplitude": 1.0, "start": 0.1, "end": 0.3},
        {"joint": "a_joint", "type": "table", "time": [0.0, 0.2, 0.25], "value": [0.0, 1.0, 0.0]},
    ]
    scene = load_scene(rod(torque=torque))
    assert torque_jumps(scene) == [0.1, 0.3]
    assert torque_jumps(scene, kinks=True) == [0.1, 0.2, 0.25, 0.3]
