"""Halving the step or the tolerance does what theory says; the same commands give the same bits."""

import numpy as np
import pytest
from scenes import anthropomorphic, link, robot, two_link
from scipy.special import ellipk

from flexsim_node import load_scene, simulate

DURATION = 0.08


def soft(damped):
    """A soft robot, all of whose modes the steps below resolve."""
    scene = anthropomorphic(
        initial={"position": [0.1, 0.2, 0.3], "velocity": [1.0, -2.0, 3.0]},
        damping={"alpha": 2.0, "beta": 1e-3} if damped else {},
        validity={"elastic_rotation": {"stop": 5.0}},  # orders show where the equations no longer hold, too
    )
    for part in scene["links"]:
        part["beam"].update(youngs_modulus=1e8, elements=1)
    # what a method passes by might be there, too: a body, friction, a motor
    scene["links"][2]["payload"] = {"mass": 0.05, "center_of_mass": [0.01, 0.02, 0.0]}
    scene["links"][1].setdefault("joint", {}).update(viscous_friction=0.05, rotor_inertia=1e-3)
    return scene


def torque(t):
    return np.array([0.5 * np.sin(20 * t), 0.0, 0.0])


def tips(damped, **solver):
    run = simulate(load_scene({**soft(damped), "solver": solver}), torque, DURATION, DURATION / 2)
    assert run.status == "ok"
    return run.link_end


@pytest.fixture(scope="module")
def exact():
    tight = {"method": "dop853", "relative_tolerance": 1e-12, "absolute_tolerance": 1e-13}
    return {damped: tips(damped, **tight) for damped in (True, False)}


@pytest.mark.parametrize(
    ("method", "order", "damped", "steps"),
    [
        ("rosenbrock_w", 2, True, (320, 640, 1280)),
        ("rosenbrock_w", 2, False, (320, 640, 1280)),
        ("generalized_alpha", 2, True, (320, 640, 1280)),
        ("runge_kutta_4", 4, False, (320, 640, 1280)),
    ],
)
def test_order_in_the_step(exact, method, order, damped, steps):
    """Each method converges to the tight reference with its order."""
    error = [np.max(np.abs(tips(damped, method=method, step=DURATION / n) - exact[damped])) for n in steps]
    assert np.log2(error[0] / error[-1]) / (len(steps) - 1) > order - 0.2
    assert error[-1] < 1e-4


@pytest.mark.parametrize("method", ["radau", "dop853"])
def test_error_follows_the_tolerance(exact, method):
    """A ten-thousandth of the tolerance gives less than a hundredth of the error, step by step
    less.
    """
    tolerances = (1e-3, 1e-5, 1e-7)
    error = []
    for r in tolerances:
        found = tips(True, method=method, relative_tolerance=r, absolute_tolerance=r / 100)
        error.append(np.max(np.abs(found - exact[True])))
    assert error[0] > error[1] > error[2]
    assert error[2] < error[0] / 100
    assert error[2] < 1e-7


def test_elements():
    """Twice the elements, a quarter of the error: the axial force of spin is constant in an
    element.

    Bending alone, without spin, converges with order four (test_frequencies.py).
    """

    def bent(count):
        scene = two_link(damping={"beta": 1e-3}, gravity=[0, 0, 0], solver={"step": 5e-5})
        scene = load_scene(scene, {f"links.{k}.beam.elements": count for k in (0, 1)})
        push = np.array([6.0, 0.0])
        run = simulate(scene, lambda t: push * np.sin(np.pi * t / 0.2) ** 2, 0.2, 0.01)
        return run.node_displacement[:, [count, 2 * count + 1]]

    fine = bent(16)
    error = [np.max(np.abs(bent(n) - fine)) for n in (1, 2, 4)]
    assert np.all(np.log2(np.divide(error[:-1], error[1:])) > 1.9)
    assert error[1] < 1e-3 * np.max(np.abs(fine))


@pytest.mark.parametrize("method", ["rosenbrock_w", "generalized_alpha", "runge_kutta_4", "radau"])
def test_same_commands_same_bits(method):
    """Two runs of the same commands agree to the last bit."""
    scene = {**soft(True), "solver": {"method": method, "relative_tolerance": 1e-5}}
    one, two = (simulate(load_scene(scene), torque, 0.02) for _ in range(2))
    for name in (
        "joint_position",
        "joint_velocity",
        "node_position",
        "node_displacement",
        "energy",
    ):
        assert np.array_equal(getattr(one, name), getattr(two, name))


def test_pendulum_period_at_large_amplitude():
    """A rigid bar released from horizontal: T = 4 K(sin 45 deg) sqrt(2 L / 3 g), to a millionth."""
    bar = link("bar", {"a": 0.5}, flexible=False)
    scene = load_scene(
        robot(
            bar,
            gravity=[0, -9.81, 0],
            effects={"rotary_inertia": False},
            initial={"position": [0.0]},
        ),
        {"solver.method": "dop853", "solver.relative_tolerance": 1e-11},
    )
    period = 4 * ellipk(0.5) * np.sqrt(2 * 0.5 / 3 / 9.81)
    run = simulate(scene, duration=period, sample_period=period / 2)
    assert run.joint_position[1, 0] == pytest.approx(-np.pi, abs=1e-6)
    assert run.joint_position[2, 0] == pytest.approx(0.0, abs=1e-6)
    assert np.allclose(run.joint_velocity[1:], 0.0, atol=1e-4)


@pytest.mark.parametrize("method", ["rosenbrock_w", "generalized_alpha"])
def test_alpha_over_chords_leaves_a_method_its_order(method):
    """What conjugate gradients leave of Rayleigh's alpha shows at no step, however short."""
    made = two_link(
        damping={"alpha": 2.0, "beta": 1e-3}, erls={"zeroed": "chord"}, initial={"velocity": [3.0, -5.0]}
    )
    scene = load_scene(made, {f"links.{k}.beam.youngs_modulus": 2e9 for k in (0, 1)})

    def ends(**solver):
        own = {f"solver.{key}": value for key, value in solver.items()}
        run = simulate(load_scene(scene.model_dump(), own), duration=0.06, sample_period=0.03)
        assert run.status == "ok"
        return run.link_end

    exact = ends(method="dop853", relative_tolerance=1e-11, absolute_tolerance=1e-12)
    coarse, fine = (np.max(np.abs(ends(method=method, step=0.06 / n) - exact)) for n in (320, 1280))
    assert np.log2(coarse / fine) / 2 > 1.9
