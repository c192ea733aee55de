"""What `simulate` promises its caller: shapes, torques, prescribed motion, limits, sampling."""

import numpy as np
import pytest
from scenes import CONFIG, anthropomorphic, two_link

from flexsim_node import SceneError, load_scene, natural_frequencies, simulate, static_equilibrium
from flexsim_node.motion.simulation import Simulation

ROBOTS = [
    "simple_pendulum",
    "planar_double_pendulum",
    "spatial_double_pendulum",
    "anthropomorphic",
    "anthropomorphic_spherical_wrist",
    "dlr_spherical_wrist",
]


@pytest.mark.parametrize("name", ROBOTS)
def test_the_robots_of_the_thesis_run(name):
    """Each scene that we ship loads, has modes, moves for a second at 1 ms, and stands still where held."""
    scene = load_scene(CONFIG / f"{name}.yaml")
    pose = scene.initial.position
    modes = natural_frequencies(scene, pose)
    assert 1.0 < modes[0] < 100.0
    assert np.all(np.diff(modes) >= 0)
    held = static_equilibrium(scene, pose)
    run = simulate(scene, duration=1.0, sample_period=0.01)
    assert run.status == "ok"
    assert np.max(np.abs(run.node_displacement[:, :, 3:])) < 0.1
    moved = np.max(np.abs(run.link_end - run.link_end[0]))
    at_rest = {"initial.shape": "static", "initial.velocity": [0.0] * len(pose)}
    bent = load_scene(CONFIG / f"{name}.yaml", at_rest)
    still = simulate(bent, held.torque[None, :], duration=0.2)
    assert np.max(np.abs(still.link_end - still.link_end[0])) < 1e-6 < 1e-2 * moved


def test_arrays():
    """Shapes and frames of design section 5."""
    run = simulate(load_scene(anthropomorphic()), duration=0.02, sample_period=0.002)
    k, m, links, nodes = 11, 3, 3, 9
    assert run.time.shape == (k,)
    assert np.allclose(run.time, 0.002 * np.arange(k), rtol=0, atol=1e-15)
    assert run.joint_position.shape == run.joint_velocity.shape == run.torque.shape == (k, m)
    assert run.link_end.shape == (k, links, 3)
    assert run.node_position.shape == run.rigid_position.shape == (k, nodes, 3)
    assert run.node_displacement.shape == (k, nodes, 6)
    assert run.energy.shape == (k,)
    assert run.step_time.shape == (20,)
    assert run.status == "ok"
    assert run.node_names[:4] == ("link_1/0", "link_1/1", "link_1/2", "link_2/0")
    assert np.array_equal(run.link_end, run.node_position[:, [2, 5, 8]])
    assert np.allclose(run.link_end[0], [[0, 0, 0.5], [0.5, 0, 0.5], [1, 0, 0.5]])
    # node_displacement in link frames: at q = 0 link 2's frame is x along the base's x, y up
    lifted = run.node_position[-1, 5] - run.rigid_position[-1, 5]
    assert np.linalg.norm(lifted) == pytest.approx(np.linalg.norm(run.node_displacement[-1, 5, :3]), rel=1e-9)


def test_torque_as_function_and_as_array():
    """An array is held between samples; a function that is as constant gives the same motion."""
    scene = load_scene(two_link())
    table = np.array([[1.0, 0.2], [-0.5, 0.3], [0.25, -0.1]])

    def steps(t):
        return table[min(int(t / 0.01 + 1e-6), 2)]

    held = simulate(scene, table, duration=0.04, sample_period=0.01)
    assert np.array_equal(held.torque, table[[0, 1, 2, 2, 2]])
    free = simulate(scene, None, duration=0.04, sample_period=0.01)
    assert np.array_equal(free.torque, np.zeros((5, 2)))
    assert not np.allclose(free.joint_position, held.joint_position, atol=1e-6)
    one = simulate(scene, lambda t: table[0], duration=0.01)
    other = simulate(scene, table[:1], duration=0.01)
    assert np.array_equal(one.joint_position, other.joint_position)


@pytest.mark.parametrize(
    "wrong",
    [
        np.zeros(2),
        np.zeros((4, 3)),
        np.zeros((0, 2)),
        np.full((3, 2), np.nan),
        lambda t: np.zeros(3),
        lambda t: 0.0,
        lambda t: [np.nan, 0.0],
    ],
)
def test_wrong_torques_are_refused(wrong):
    with pytest.raises(ValueError, match="give"):
        simulate(load_scene(two_link()), wrong, duration=0.01)


def test_torque_that_goes_wrong_later():
    """A controller that turns out NaN half way ends the run with a reason, not with NaN."""

    def torque(t):
        return np.array([0.0, np.nan if t > 0.005 else 0.0])

    run = simulate(load_scene(two_link()), torque, duration=0.02)
    assert run.status != "ok"
    assert "finite" in run.status
    assert np.all(np.isfinite(run.joint_position))
    assert np.all(np.isfinite(run.energy))
    assert 2 < len(run.time) < 20


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"duration": -1.0}, "duration"),
        ({"duration": np.nan}, "duration"),
        ({"duration": 1.0, "sample_period": 0.0}, "sample_period"),
        ({"duration": 1.0, "sample_period": np.inf}, "sample_period"),
        ({"duration": 1.0, "prescribed": {"joint_9": lambda t: (0, 0, 0)}}, "joint_9"),
    ],
)
def test_impossible_runs_are_refused(keys, said):
    with pytest.raises((ValueError, SceneError), match=said):
        simulate(load_scene(two_link()), **keys)


def test_effort_limit():
    """No motor gives more than its effort_limit, whatever is asked of it."""
    scene = two_link(gravity=[0, 0, 0])
    scene["links"][1]["joint"] = {"name": "elbow", "effort_limit": 0.2}
    asked = simulate(load_scene(scene), np.array([[0.0, 5.0]]), duration=0.05)
    given = simulate(load_scene(scene), np.array([[0.0, 0.2]]), duration=0.05)
    assert np.array_equal(asked.torque[:, 1], np.full(51, 0.2))
    assert np.array_equal(asked.joint_position, given.joint_position)
    called = simulate(load_scene(scene), lambda t: [0.0, -5.0], duration=0.05)
    assert np.array_equal(called.torque[:, 1], np.full(51, -0.2))


@pytest.mark.parametrize("method", ["rosenbrock_w", "generalized_alpha", "runge_kutta_4", "radau", "dop853"])
@pytest.mark.parametrize("zeroed", ["root", "chord"])
def test_prescribed_motion_is_followed(method, zeroed):
    """A joint that is driven shows the motion it was given, to rounding, on its encoder."""
    scene = two_link(erls={"zeroed": zeroed}, solver={"method": method, "step": 1e-3})
    for part in scene["links"]:
        part["beam"].update(youngs_modulus=1e8, elements=1)

    def motion(t):
        return 0.3 * np.sin(4 * t), 1.2 * np.cos(4 * t), -4.8 * np.sin(4 * t)

    run = simulate(load_scene(scene), duration=0.05, prescribed={"link_1_joint": motion})
    assert run.status == "ok"
    right = np.array([motion(t)[:2] for t in run.time])
    assert np.allclose(run.joint_position[:, 0], right[:, 0], rtol=0, atol=1e-12)
    assert np.allclose(run.joint_velocity[:, 0], right[:, 1], rtol=0, atol=1e-12)
    assert np.max(np.abs(run.joint_position[:, 1])) > 1e-4


def test_samples_and_steps():
    """Samples say how often one looks, steps how finely it is computed: the one does not change
    the other.
    """
    scene = load_scene(two_link())
    often = simulate(scene, duration=0.1)
    seldom = simulate(scene, duration=0.1, sample_period=0.02)
    assert np.array_equal(often.link_end[::20], seldom.link_end)
    assert len(seldom.step_time) == len(often.step_time) == 100
    # a period that is no multiple of the step shortens the steps
    odd = simulate(scene, duration=0.025, sample_period=0.0025)
    assert len(odd.step_time) == 30
    finer = simulate(scene, duration=0.01, sample_period=0.0005)
    assert len(finer.step_time) == 20


def test_too_large_a_step_ends_with_a_reason():
    """An explicit method beyond its limit says so and keeps what was good; nothing becomes NaN."""
    scene = load_scene(two_link(), {"solver.method": "runge_kutta_4"})
    run = simulate(scene, duration=0.5)
    assert "stopped at" in run.status
    assert "smaller step" in run.status
    for name in ("joint_position", "link_end", "node_displacement", "energy"):
        assert np.all(np.isfinite(getattr(run, name)))


def test_static_start():
    """`shape: static` starts with the links bent by gravity, `undeformed` with straight ones."""
    straight = simulate(load_scene(two_link()), duration=0.0)
    assert np.array_equal(straight.node_displacement, np.zeros((1, 6, 6)))
    scene = load_scene(two_link(initial={"shape": "static"}))
    bent = simulate(scene, duration=0.0)
    assert np.allclose(bent.link_end[0], static_equilibrium(scene, [0, 0]).link_end, atol=1e-12)


@pytest.mark.parametrize("zeroed", ["root", "chord"])
def test_static_start_at_rest(zeroed):
    """A robot that starts in static equilibrium under its holding torques stays, whatever is
    zeroed.
    """
    pose = [0.3, 0.5, -0.8]
    erls = {"zeroed": zeroed}
    scene = load_scene(anthropomorphic(erls=erls, initial={"position": pose, "shape": "static"}))
    rest = static_equilibrium(scene, pose)
    run = simulate(scene, rest.torque[None, :], duration=0.1)
    assert np.max(np.abs(run.link_end - rest.link_end)) < 1e-6


def test_scene_keys_may_be_overridden():
    """Dotted keys replace what a file says, by a link's name or number."""
    overrides = {
        "solver.step": 5e-4,
        "links.link_2.beam.elements": 3,
        "links.0.payload.mass": 0.2,
        "effects.shear": True,
    }
    scene = load_scene(CONFIG / "anthropomorphic.yaml", overrides)
    assert scene.solver.step == 5e-4
    assert [x.beam.elements for x in scene.links] == [2, 3, 2]
    assert scene.links[0].payload.mass == 0.2
    assert scene.effects.shear is True


def test_scene_is_immutable():
    scene = load_scene(two_link())
    with pytest.raises(ValueError, match="frozen"):
        scene.name = "other"


@pytest.mark.parametrize("method", ["rosenbrock_w", "generalized_alpha"])
def test_a_reset_robot_does_the_same_again(method):
    """Position, speed, torque, load and whatever the method keeps begin anew, to the last bit."""
    scene = two_link(initial={"position": [0.3, -0.5], "velocity": [2.0, -1.0]}, solver={"method": method})
    robot = Simulation(load_scene(scene))

    def run():
        states = []
        for k in range(40):
            robot.command(np.array([0.2, -0.1 * k]))
            robot.apply(scene["links"][1]["name"], np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.1]))
            assert robot.step() == 0
            states.append([*robot.x, *robot.v, robot.time])
        return np.array(states)

    robot.prepare()
    first = run()
    robot.reset()
    np.testing.assert_array_equal(robot.joint_velocity(), scene["initial"]["velocity"])
    np.testing.assert_array_equal(robot.joint_effort(), 0.0)
    np.testing.assert_array_equal(run(), first)
