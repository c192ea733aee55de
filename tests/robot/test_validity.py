"""The validity watch: what it sees, warns of and stops at."""

import numpy as np
import pytest
from scenes import anthropomorphic, link, robot, two_link

from flexsim_node import SceneError, load_scene, simulate
from flexsim_node.equations.dynamics.acceleration import NOT_VALID, OK
from flexsim_node.motion.load_stiffness import FIRST_STEPS
from flexsim_node.motion.simulation import Simulation

PUSH = {"base:bar": lambda t: np.array([-1.0, 0.0, 0.0, 0.0, 0.0, 0.0])}


def pushed_bar(load, **keys):
    """A cantilever with an axial load (N) on its end."""
    damping = {"alpha": 0.0, "beta": 1e-3}
    made = robot(link("bar", {"a": 1.0}, 0.01, 0.02), gravity=[0.0, 0.0, 0.0], damping=damping, **keys)
    scene = load_scene(made)
    held = {"bar_joint": lambda t: (0.0, 0.0, 0.0)}
    wrench = {"bar": lambda t: np.array([-load, 0.0, 0.0, 0.0, 0.0, 0.0])}
    return simulate(scene, duration=0.05, prescribed=held, wrench=wrench)


def test_axial_load_against_buckling():
    """Euler's load of a cantilever with the weaker bending, pi^2 E I / (4 L^2)."""
    euler = np.pi**2 * 2e11 * 0.02 * 0.01**3 / 12 / 4.0
    run = pushed_bar(0.4 * euler)
    assert run.validity["axial_load"] == pytest.approx(0.4, rel=1e-3) and not run.warnings
    run = pushed_bar(0.6 * euler)
    assert run.status == "ok" and "axial load over the buckling load" in run.warnings[0]
    run = pushed_bar(1.1 * euler, effects={"centrifugal": False})
    assert "switch that on" in run.status and "stopped at" in run.status


def test_elastic_rotation_of_a_tip_load():
    """P L^2 / (2 E I) at the end of a cantilever, twice that when the load comes at once."""
    scene = robot(
        link("bar", {"a": 1.0}, 0.01, 0.01), gravity=[0, 0, 0], damping={"alpha": 0.0, "beta": 1e-2}
    )
    held = {"bar_joint": lambda t: (0.0, 0.0, 0.0)}
    load = 2.0
    angle = load / (2 * 2e11 * 0.01**4 / 12)
    given = {"bar": lambda t: np.array([0.0, load, 0.0, 0.0, 0.0, 0.0])}
    run = simulate(load_scene(scene), duration=2.0, sample_period=0.01, prescribed=held, wrench=given)
    assert run.node_displacement[-1, -1, 5] == pytest.approx(angle, rel=1e-3)
    assert angle < run.validity["elastic_rotation"] < 2.1 * angle
    for key, status in (("warn", "ok"), ("stop", "stopped")):
        limits = {"warn": 0.5 * angle, "stop": 10.0} if key == "warn" else {"warn": None, "stop": 0.5 * angle}
        scene["validity"] = {"elastic_rotation": limits}
        run = simulate(load_scene(scene), duration=1.0, sample_period=0.01, prescribed=held, wrench=given)
        assert run.status.startswith(status)
        words = run.warnings[0] if key == "warn" else run.status
        assert f"validity.elastic_rotation.{key} = {0.5 * angle:g}" in words and "co_moving" in words


def test_stop_keeps_the_last_good_state():
    """The step that passes a limit is not taken; the state before it stays, finite."""
    robot_now = Simulation(load_scene(two_link(), {"validity.elastic_rotation.stop": 1e-3}))
    robot_now.command(np.array([300.0, 0.0]))
    for _ in range(1000):
        x, v = robot_now.x.copy(), robot_now.v.copy()
        if robot_now.step():
            break
    assert robot_now.status == NOT_VALID
    assert np.array_equal(x, robot_now.x) and np.array_equal(v, robot_now.v)
    assert np.all(np.isfinite(robot_now.look().position))
    assert "elastic rotation reaches" in robot_now.reason


def test_condition_of_the_mass_matrix():
    """An arm that stands upright has hardly any inertia about its first joint."""
    scene = anthropomorphic(gravity=[0.0, 0.0, 0.0])
    still = simulate(load_scene(scene), duration=0.002)
    upright = simulate(load_scene(scene, {"initial.position": [0.0, np.pi / 2, 0.0]}), duration=0.002)
    assert upright.validity["mass_condition"] > 50 * still.validity["mass_condition"]
    limit = {"validity.mass_condition": {"warn": 10.0, "stop": 100.0}, "initial.position": [0, np.pi / 2, 0]}
    stopped = simulate(load_scene(scene, limit), duration=0.002)
    assert "rotor_inertia" in stopped.status


UPRIGHT = {"initial.position": [0.0, np.pi / 2, 0.0]}


@pytest.mark.parametrize(("stop", "status"), [(100.0, NOT_VALID), (1e12, OK)])
def test_a_check_bit_by_bit_is_the_check(stop, status):
    """For a tick with a deadline: the same figures and the same end, of the state at which it began."""
    scene = anthropomorphic(gravity=[0.0, 0.0, 0.0])
    limit = {"validity.mass_condition": {"warn": 10.0, "stop": stop}}
    whole, bits = (Simulation(load_scene(scene, UPRIGHT | limit)) for _ in range(2))
    whole.check()
    bits.glance(begin=True)
    assert bits.status == OK
    bits.x[:] = 0.1  # the robot moves on meanwhile
    taken = 1
    while bits._check is not None:
        assert not bits.watch.sampled.any()
        bits.glance(begin=True)  # one at a time
        taken += 1
    assert taken == 3 + bits.model.joints + 2 * FIRST_STEPS
    np.testing.assert_array_equal(bits.watch.sampled, whole.watch.sampled)
    assert bits.status == whole.status == status


def test_a_reset_ends_a_check_that_is_under_way():
    robot_now = Simulation(load_scene(anthropomorphic(gravity=[0.0, 0.0, 0.0]), UPRIGHT))
    robot_now.glance(begin=True)
    robot_now.reset()
    for _ in range(20):
        robot_now.glance(begin=False)
    assert not robot_now.watch.sampled.any()


@pytest.mark.parametrize(
    ("validity", "words"),
    [
        ({"elastic_rotation": {"warn": 0.9}}, "above stop"),
        ({"elastic_rotation": {"stop": -1.0}}, "more than 0"),
        ({"rotation": {"stop": 1.0}}, "did you mean"),
    ],
)
def test_limits_that_make_no_sense(validity, words):
    """Are refused with what would be right."""
    with pytest.raises(SceneError, match=words):
        load_scene(two_link(validity=validity))
