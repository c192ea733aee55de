"""Forces and moments on the links' ends."""

import numpy as np
import pytest
from scenes import anthropomorphic, link, robot, two_link
from scipy.spatial.transform import Rotation

from flexsim_node import load_scene, simulate
from flexsim_node.equations.dynamics.residual import residual
from flexsim_node.model.chain import workspace
from flexsim_node.model.model import build_model
from flexsim_node.motion.simulation import Simulation
from flexsim_node.sensors.observation import Observation


@pytest.mark.parametrize("scene", [two_link(), anthropomorphic()], ids=["plane", "space"])
@pytest.mark.parametrize("base", [False, True])
def test_virtual_work(scene, base):
    """Generalized forces are load times the derivative of the end's place and attitude."""
    robot_now = Simulation(load_scene(scene, {"gravity": [0.0, 0.0, 0.0], "erls.zeroed": "root"}))
    model, chain = robot_now.model, robot_now.model.chain
    rng = np.random.default_rng(3)
    x = 1e-4 * rng.standard_normal(model.unknowns)
    x[: model.joints] = rng.uniform(-1, 1, model.joints)
    n = len(model.scene.links) - 1
    load = rng.uniform(-3, 3, 6) * ([1, 1, 0, 0, 0, 1] if model.planar else 1.0)
    zero, rest, loaded = np.zeros((3, model.unknowns))
    residual(chain, robot_now.work, x, zero, zero, np.zeros(model.joints), rest)
    robot_now.apply(model.scene.links[n].name, load, base)
    residual(chain, robot_now.work, x, zero, zero, np.zeros(model.joints), loaded)
    view, work = Observation(model), workspace(chain)

    def end(y):
        view.look(work, y)
        frame = view.pose[n, 3:].reshape(3, 3)
        bent = Rotation.from_rotvec(view.displacement[view.ends[n], 3:]).as_matrix()
        return view.link_end[n].copy(), frame @ bent

    _, section = end(x)
    frame = view.pose[n, 3:].reshape(3, 3).copy()
    force, moment = (load[:3], load[3:]) if base else (frame @ load[:3], frame @ load[3:])
    for k in range(model.unknowns):
        step = 1e-6 * np.eye(model.unknowns)[k]
        (ahead, turned), (behind, before) = end(x + step), end(x - step)
        spin = (turned - before) @ section.T / 2e-6
        rotation = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        work_done = force @ (ahead - behind) / 2e-6 + moment @ rotation
        assert loaded[k] - rest[k] == pytest.approx(work_done, abs=2e-6)


def test_weight_as_a_load():
    """Gravity's work and the load's become kinetic energy."""
    light = robot(link("bar", {"a": 0.5}, flexible=False), gravity=[0.0, -9.81, 0.0])
    run = simulate(
        load_scene(light),
        torque=lambda t: np.zeros(1),
        duration=0.3,
        wrench={"base:bar": lambda t: np.array([0.0, -4.0, 0.0, 0.0, 0.0, 0.0])},
    )
    beam = load_scene(light).links[0].beam
    mass = beam.density * beam.width * beam.depth * 0.5
    inertia = mass * (0.25 / 3 + beam.width**2 / 12)
    # m g L / 2 and 4 N at the end turn it; energy gives the speed
    angle = run.joint_position[:, 0]
    gained = -np.sin(angle) * (0.25 * mass * 9.81 + 0.5 * 4.0)
    assert np.allclose(0.5 * inertia * run.joint_velocity[:, 0] ** 2, gained, rtol=1e-4, atol=1e-6)


def test_follower_and_fixed_direction_differ():
    """In the link's frame a force turns with it."""
    scene = load_scene(two_link(gravity=[0.0, 0.0, 0.0]))
    push = np.array([0.0, 2.0, 0.0, 0.0, 0.0, 0.0])
    ends = [
        simulate(scene, duration=0.5, wrench={name: lambda t: push}).link_end[-1]
        for name in ("link_2", "base:link_2")
    ]
    assert np.linalg.norm(ends[0] - ends[1]) > 0.01


def test_loads_off():
    """Taking a load off leaves nothing behind; nonsense is refused."""
    robot_now = Simulation(load_scene(two_link()))
    robot_now.apply("link_1", np.array([1.0, 1.0, 0.0, 0.0, 0.0, 1.0]))
    assert robot_now.work.loaded.tolist() == [True, False]
    robot_now.apply("link_1", np.zeros(6))
    assert not robot_now.work.loaded.any()
    with pytest.raises(ValueError, match="give one of link_1, link_2"):
        robot_now.apply("link_9", np.ones(6))
    with pytest.raises(ValueError, match="leaves the plane"):
        robot_now.apply("link_1", np.ones(6))
    with pytest.raises(ValueError, match="six finite"):
        robot_now.apply("link_1", np.array([np.nan] * 6))


def test_static_load_in_the_model():
    """A model is not changed by what is put on it."""
    scene = load_scene(two_link())
    a = build_model(scene)
    simulate(scene, duration=0.01, wrench={"link_2": lambda t: np.ones(6)})
    b = build_model(scene)
    assert all(np.array_equal(x, y) for x, y in zip(a.chain.values[4:], b.chain.values[4:], strict=True))
