"""Linear models: their frequencies, their step response, and their matrices by another road."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest
from independent_chain import IndependentChain
from scenes import anthropomorphic, link, robot, two_link
from scipy import signal

from flexsim_node import LinearModel, linearize, load_scene, natural_frequencies, simulate, static_equilibrium

POSE = [0.3, 0.5, -0.8]
LOSSES = {"viscous_friction": 0.2, "coulomb_friction": 0.003, "coulomb_speed": 0.1, "rotor_inertia": 0.01}
JOINTS = ["link_1_joint", "joint_2", "link_3_joint"]


def arm(**keys) -> dict:
    """The anthropomorphic robot with everything that a linear model must hold."""
    scene = anthropomorphic(damping={"alpha": 0.1, "beta": 2e-4}, **keys)
    scene["links"][1]["joint"] = {"name": "joint_2", **LOSSES}
    scene["links"][2]["payload"] = {"mass": 0.4}
    return scene


def response(model: LinearModel, torque: np.ndarray, period: float, samples: int) -> np.ndarray:
    """(samples, p) deviation of the outputs after a step of torque."""
    ahead, drive = model.discretize(period)
    x, found = np.zeros(len(ahead)), []
    for _ in range(samples):
        found.append(model.C @ x + model.D @ torque)
        x = ahead @ x + drive @ torque
    return np.array(found)


@pytest.mark.parametrize("held", [[], JOINTS])
def test_frequencies_equal_natural_frequencies(held):
    """Without gravity those of the undeformed robot, with it those about the equilibrium."""
    weightless = load_scene(arm(effects={"gravity": False}))
    right = natural_frequencies(weightless, POSE, locked=bool(held))
    found = linearize(weightless, POSE, held=held).natural_frequencies()
    assert np.allclose(found, right, rtol=1e-6, atol=1e-3)  # the root of a zero's rounding
    # the linear elastic rotation is not the same in every rigid link system
    for zeroed, count, limit in (("root", None, 1e-6), ("chord", 8, 3e-3)):
        loaded = load_scene(arm(erls={"zeroed": zeroed}))
        right = natural_frequencies(loaded, POSE, locked=bool(held), loaded=True)[:count]
        found = linearize(loaded, POSE, held=held).natural_frequencies()[:count]
        assert np.allclose(found, right, rtol=limit, atol=1e-3)


def test_poles_are_those_of_the_undamped_modes():
    """Without damping A's poles are +-i times the natural frequencies."""
    scene = load_scene(anthropomorphic(effects={"gravity": False}))
    found = linearize(scene, POSE, held=["link_1_joint", "link_2_joint", "link_3_joint"]).poles()
    right = 2 * np.pi * natural_frequencies(scene, POSE)
    assert np.allclose(np.abs(found[1::2]), right, rtol=1e-6)
    assert np.max(np.abs(found.real)) < 1e-6 * np.max(np.abs(found))


@pytest.mark.parametrize("zeroed", ["root", "chord"])
def test_step_response_equals_the_simulation(zeroed):
    """After a small step of every torque: joints, tip and a node within 0.1 % for a fifth of a second."""
    scene = arm(erls={"zeroed": zeroed}, solver={"step": 1e-4}, initial={"position": POSE, "shape": "static"})
    outputs = ["joint_position", "joint_velocity", "tip_position", "node_displacement:link_2/1"]
    model = linearize(load_scene(scene), POSE, outputs)
    step = np.array([3e-4, 6e-4, -3e-4])
    run = simulate(load_scene(scene), lambda t: model.torque + step, duration=0.2, sample_period=2e-3)
    node = run.node_names.index("link_2/1")
    parts = [run.joint_position, run.joint_velocity, run.node_position[:, -1], run.node_displacement[:, node]]
    found = np.hstack(parts) - model.output
    right = response(model, step, 2e-3, len(run.time))
    assert np.max(np.abs(found[0])) < 1e-12
    size = np.max(np.abs(right), axis=0)
    assert np.all(np.max(np.abs(found - right), axis=0) < 1e-3 * size)


def test_matrices_equal_differences_of_independent_equations():
    """A and B are the derivatives of accelerations that share no code with the model's."""
    beam = {"elements": 1, "youngs_modulus": 5e9}
    first = link("link_1", {"a": 0.4, "alpha": 1.1}, 0.02, 0.03, joint={"name": "j", **LOSSES}, beam=beam)
    second = link("link_2", {"a": 0.5, "d": 0.1}, 0.01, 0.03, beam=beam)
    damping = {"alpha": 0.3, "beta": 1e-3}
    effects = {"shear": True}
    scene = load_scene(
        robot(
            first,
            {**second, "payload": {"mass": 0.3}},
            damping=damping,
            effects=effects,
            erls={"zeroed": "root"},
        )
    )
    pose = [0.4, -0.3]
    model = linearize(scene, pose)
    chain = IndependentChain(scene)
    n = chain.unknowns
    assert model.A.shape == (2 * n, 2 * n)
    z, still = model.state[:n], np.zeros(n)
    assert np.max(np.abs(chain.acceleration(z, still, model.torque))) < 1e-6
    scale = np.abs(model.A[n:])
    for k, unit in enumerate(np.eye(n)):
        h = 1e-6
        slope = [chain.acceleration(z + s * h * unit, still, model.torque) for s in (1, -1)]
        by_position = (slope[0] - slope[1]) / (2 * h)
        assert np.allclose(model.A[n:, k], by_position, rtol=1e-6, atol=1e-7 * scale[:, :n].max())
        slope = [chain.acceleration(z, s * h * unit, model.torque) for s in (1, -1)]
        by_rate = (slope[0] - slope[1]) / (2 * h)
        assert np.allclose(model.A[n:, n + k], by_rate, rtol=1e-6, atol=1e-7 * scale[:, n:].max())
    for k, unit in enumerate(np.eye(2)):
        by_torque = chain.acceleration(z, still, model.torque + unit) - chain.acceleration(
            z, still, model.torque
        )
        assert np.allclose(model.B[n:, k], by_torque, rtol=1e-6, atol=1e-6 * np.abs(by_torque).max())


def test_rigid_pendulum_in_closed_form():
    """(I + J g^2) phi'' + (b + C / s) phi' - w phi = tau about a rod held at an angle."""
    joint = {**LOSSES, "gear_ratio": 3.0}
    rod = link("rod", {"a": 0.5}, 0.01, 0.03, joint=joint, flexible=False)
    scene = load_scene(
        robot(rod, gravity=[0.0, -9.81, 0.0], effects={"rotary_inertia": False}, damping={"alpha": 1.0})
    )
    model = linearize(
        scene, [0.3], ["joint_position", "joint_acceleration", "tip_position", "tip_acceleration"]
    )
    mass = 7800 * 0.01 * 0.03 * 0.5
    inertia = mass * 0.25 / 3 + 0.01 * 9
    weight = mass * 9.81 * 0.25
    assert model.torque[0] == pytest.approx(weight * np.cos(0.3), rel=1e-12)
    expected = [[0, 1], [weight * np.sin(0.3) / inertia, -(0.2 + 0.003 / 0.1) / inertia]]
    assert np.allclose(model.A, expected, rtol=1e-9)
    assert np.allclose(model.B[:, 0], [0, 1 / inertia], rtol=1e-9)
    across = 0.5 * np.array([-np.sin(0.3), np.cos(0.3), 0.0])
    assert np.allclose(model.C[2:5, 0], across, atol=1e-12)
    assert np.allclose(model.C[5:8], across[:, None] * expected[1], atol=1e-10)
    assert np.allclose(model.D[:, 0], [0, 1 / inertia, 0, 0, 0, *across / inertia], atol=1e-12)
    assert model.output_names[1] == "joint_acceleration/rod_joint"


def test_reduction_keeps_slow_motion_and_the_static_gain():
    """Five elastic modes and the static share of the others: joints held by springs of a controller."""
    full = linearize(load_scene(arm()), POSE, ["joint_position", "tip_position"])
    small = full.reduced(10)
    assert small.A.shape == (20, 20)

    def gain(model: LinearModel, frequency: float) -> np.ndarray:
        """Transfer (p, m) with each joint's position fed back by 50 N m/rad."""
        s = 2j * np.pi * frequency
        through = model.C @ np.linalg.solve(s * np.eye(len(model.A)) - model.A, model.B) + model.D
        return through @ np.linalg.inv(np.eye(3) + 50.0 * through[:3])

    for frequency, limit in ((1e-3, 1e-5), (5.0, 2e-3)):
        right = gain(full, frequency)
        assert np.max(np.abs(gain(small, frequency) - right)) < limit * np.max(np.abs(right))
    assert np.allclose(small.natural_frequencies(), full.natural_frequencies()[:10], rtol=1e-6, atol=1e-3)
    with pytest.raises(ValueError, match="give a whole number from 1 to"):
        full.reduced(0)


def test_python_control_gets_the_model(monkeypatch):
    """to_control hands matrices and names to control.ss; the system responds as ours.

    scipy's state space stands in for python-control's, which is not among the tests' packages.
    """

    def ss(a, b, c, d, states, inputs, outputs):
        assert (len(states), len(inputs), len(outputs)) == (len(a), b.shape[1], len(c))
        assert outputs == list(model.output_names)
        return signal.StateSpace(a, b, c, d)

    model = linearize(load_scene(two_link(damping={"alpha": 2.0, "beta": 5e-4})), [-1.5, 0.1]).reduced(4)
    monkeypatch.setitem(sys.modules, "control", SimpleNamespace(ss=ss))
    time = np.arange(100) * 2e-3
    torque = np.array([1e-3, -2e-3])
    _, found, _ = signal.lsim(model.to_control(), np.tile(torque, (100, 1)), time)
    assert np.allclose(found, response(model, torque, 2e-3, 100), atol=1e-9)
    monkeypatch.setitem(sys.modules, "control", None)
    with pytest.raises(ImportError, match="pip install control"):
        model.to_control()


def test_saved_and_loaded(tmp_path):
    model = linearize(load_scene(two_link()), [0.1, 0.2], ["tip_position:link_1"])
    model.save(tmp_path / "model.npz")
    again = LinearModel.load(tmp_path / "model.npz")
    assert again.state_names == model.state_names
    assert again.output_names == ("tip_position:link_1/x", "tip_position:link_1/y", "tip_position:link_1/z")
    assert np.array_equal(again.A, model.A)
    np.savez(tmp_path / "other.npz", A=np.zeros(2))
    with pytest.raises(ValueError, match=r"has no .*; give a file"):
        LinearModel.load(tmp_path / "other.npz")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ({"position": [0.0]}, "give 2 finite joint coordinates"),
        ({"outputs": ["tip_positon"]}, "did you mean 'tip_position'"),
        ({"outputs": ["tip_position:link_9"]}, "give one of link_1, link_2"),
        ({"outputs": ["node_displacement:link_1/9"]}, "no node 'link_1/9'"),
        ({"held": ["elbow"]}, "no joint 'elbow'"),
    ],
)
def test_mistakes_are_named(words, sentence):
    with pytest.raises(ValueError, match=sentence):
        linearize(load_scene(two_link()), **{"position": [0.0, 0.0], **words})


def test_equilibrium_is_the_static_one():
    """The operating point is that of static_equilibrium."""
    scene = load_scene(arm())
    rest = static_equilibrium(scene, POSE)
    model = linearize(scene, POSE, ["tip_position"])
    assert np.allclose(model.torque, rest.torque, atol=1e-5)
    assert np.allclose(model.output, rest.link_end[-1], atol=1e-5)
