"""Closed loops with `formulation: co_moving`: sections meet, however far the links are bent."""

import numpy as np
import pytest
from mechanisms import FourBar, crank_motion, four_bar
from scenes import CONFIG, DATA, link, robot
from scipy.integrate import solve_ivp
from scipy.optimize import root
from test_loops import GAP, SCENES, SOFT, TIGHT, delta_place, driven, rigid_delta
from test_loops_at_rest import beam_to_the_wall

from flexsim_node import load_scene, natural_frequencies, simulate, static_equilibrium

CO_MOVING = {"formulation": "co_moving"}


def test_rigid_four_bar_is_the_closed_form():
    """The crank under a torque: angles to 1e-8."""
    run = simulate(load_scene(four_bar(), {**TIGHT, **CO_MOVING}), driven(1.5, 3), 0.6, 0.05)
    assert run.status == "ok"
    theta, speed = crank_motion(FourBar(), 0.7, 8.0, 1.5, run.time)
    psi, chi = np.unwrap(FourBar().angles(theta), axis=1)
    assert np.allclose(run.joint_position.T, [theta, psi - theta, chi], rtol=0, atol=1e-8)
    assert np.allclose(run.joint_velocity[:, 0], speed, rtol=0, atol=1e-6)
    assert np.max(run.loop_gap) < GAP


def test_rigid_delta_is_the_closed_form():
    """Three motors on given paths: the platform is where three spheres meet."""

    def swing(k):
        w = 5.0 + k
        return lambda t: (0.4 + 0.3 * np.sin(w * t), 0.3 * w * np.cos(w * t), -0.3 * w * w * np.sin(w * t))

    motion = {f"motor_{k}": swing(k) for k in (1, 2, 3)}
    run = simulate(rigid_delta(**CO_MOVING), duration=0.2, sample_period=0.02, prescribed=motion)
    assert run.status == "ok"
    assert np.max(run.loop_gap) < GAP
    for t, place in zip(run.time, run.link_end[:, -1], strict=True):
        right = delta_place(np.array([swing(k)(t)[0] for k in (1, 2, 3)]))
        assert np.allclose(place, right, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("name", "bound"), [*zip(SCENES, (1e-4, 1e-4, 1e-4, 1e-5), strict=True)])
def test_stiff_robots_alike(name, bound):
    """The scenes that we ship move as in the ERLS; their loops stay closed in every step."""
    ends = []
    for formulation in ("erls", "co_moving"):
        scene = load_scene(CONFIG / f"{name}.yaml", {"formulation": formulation, "solver.step": 2e-4})
        actuated = np.array([joint.actuated for joint in scene.joints])
        push = 0.3 * actuated
        run = simulate(scene, lambda t, push=push: np.sin(40 * t) * push, duration=0.04, sample_period=2e-3)
        assert run.status == "ok"
        assert np.max(run.loop_gap) < GAP
        ends.append(run.link_end)
    assert np.max(np.ptp(ends[0], axis=0)) > 1e-3
    assert np.max(np.abs(ends[1] - ends[0])) < bound


@pytest.mark.parametrize("space", [False, True], ids=["planar", "in space"])
def test_energy_is_kept(space):
    """Radau at a tight tolerance, links that bend by a tenth of a radian."""
    scene = four_bar(SOFT, gravity=[0.0, -9.81, -3.0 if space else 0.0], **CO_MOVING)
    tight = {"solver.method": "radau", "solver.relative_tolerance": 1e-8, "solver.absolute_tolerance": 1e-10}
    run = simulate(load_scene(scene, tight), duration=0.03, sample_period=0.005)
    assert run.status == "ok"
    assert np.max(np.abs(run.energy - run.energy[0])) < 1e-7 * 0.5 * FourBar().inertia(0.7) * 8.0**2
    assert np.max(run.loop_gap) < GAP


@pytest.mark.parametrize("method", ["rosenbrock_w", "generalized_alpha"])
def test_order_in_the_step(method):
    """Loops and Rayleigh's damping leave each method its order."""
    duration = 0.06

    def tips(**solver):
        scene = four_bar(SOFT, damping={"alpha": 20.0, "beta": 1e-3}, solver=solver, **CO_MOVING)
        run = simulate(load_scene(scene), duration=duration, sample_period=duration / 2)
        assert run.status == "ok"
        return run.link_end

    exact = tips(method="dop853", relative_tolerance=1e-11, absolute_tolerance=1e-12)
    error = [np.max(np.abs(tips(method=method, step=duration / n) - exact)) for n in (320, 640, 1280)]
    assert np.log2(error[0] / error[-1]) / 2 > 1.75


def test_elastic_rod_at_speed_is_exudyns():
    """150 rad/s through every dead centre: the rod bends by 4.6 mm, within 0.1 mm of ANCF cables."""
    scene = load_scene(CONFIG / "slider_crank.yaml", {"effects.rotary_inertia": False, **CO_MOVING})
    right = np.genfromtxt(DATA / "slider_crank_steel.csv", delimiter=",", names=True)
    motion = {"crank_joint": lambda t: (150.0 * t, 150.0, 0.0)}
    run = simulate(scene, duration=0.05, sample_period=2.5e-4, prescribed=motion)
    assert run.status == "ok"
    assert np.max(run.loop_gap) < GAP
    nodes = [i for i, name in enumerate(run.node_names) if name.startswith("rod/")]
    rod = run.node_position[:, nodes, 0] + 1j * run.node_position[:, nodes, 1]
    assert np.max(np.abs(rod[:, 2] - (right["middle_x"] + 1j * right["middle_y"]))) < 1e-4
    assert np.max(np.abs(rod[:, -1] - right["slider_x"])) < 1e-4


def elastica(angle, length, bending, stretching):
    """(x of the end, moment at the root) of a beam clamped at an angle whose end slides along y = 0, exactly.

    M' = -F x', EI phi' = M, stretched by F sin(phi) / EA (Reissner's beam without shear), by shooting.
    """

    def shoot(guess):
        moment, force = guess

        def rate(_, y):
            _, _, phi, m = y
            long = 1.0 + force * np.sin(phi) / stretching
            return long * np.cos(phi), long * np.sin(phi), m / bending, -force * long * np.cos(phi)

        return solve_ivp(rate, (0.0, length), [0.0, 0.0, angle, moment], rtol=1e-10, atol=1e-12).y[:, -1]

    first = 3.0 * bending * angle / length
    found = root(lambda guess: shoot(guess)[[1, 3]], [-first, -first / length], tol=1e-10)
    assert found.success
    return shoot(found.x)[0], found.x[0]


def test_beam_on_a_roller_is_the_elastica():
    """Its root turned by 0.8 rad, its end on a line: the exact shape, to second order in the elements.

    The motor turns it there, and damping brings it to rest.
    """
    x, _ = elastica(0.8, 0.5, 2e9 * 0.01 * 0.03**3 / 12, 2e9 * 0.01 * 0.03)
    assert x < 0.475

    def turn(t):
        s = min(t / 0.3, 1.0)
        rate = 0.8 * 30.0 * s**2 * (1.0 - s) ** 2 / 0.3
        return 0.8 * s**3 * (10 - 15 * s + 6 * s * s), rate, 0.8 * 60.0 * s * (1 - s) * (1 - 2 * s) / 0.09

    error = []
    for elements in (2, 4, 8):
        scene = robot(
            link("beam", {"a": 0.5}, beam={"elements": elements, "youngs_modulus": 2e9}),
            loops=[{"links": ["beam", "base"], "joint": "slot", "axis": {"base": [1.0, 0.0, 0.0]}}],
            gravity=[0.0, 0.0, 0.0], damping={"alpha": 20.0, "beta": 5e-3}, **CO_MOVING,
        )  # fmt: skip
        run = simulate(load_scene(scene), duration=0.8, prescribed={"beam_joint": turn})
        assert run.status == "ok"
        assert np.max(run.loop_gap) < GAP
        assert np.ptp(run.link_end[-20:], axis=0).max() < 1e-7
        error.append(run.link_end[-1, 0, 0] - x)
    assert abs(error[-1]) < 1e-5
    assert np.log2(error[0] / error[-1]) / 2 > 1.7


@pytest.mark.parametrize("name", SCENES)
def test_frequencies_alike(name):
    """Small vibrations about the undeformed robot are the same, its loops closed."""
    found = []
    for formulation in ("erls", "co_moving"):
        scene = load_scene(CONFIG / f"{name}.yaml", {"formulation": formulation})
        motors = [joint.actuated for joint in scene.joints]
        found.append(natural_frequencies(scene, scene.start("position")[motors]))
    np.testing.assert_allclose(found[1], found[0], rtol=1e-6)


def test_propped_cantilever():
    """A clamped beam with a pin at its end: w L^2 / 8 holds it."""
    scene = load_scene(beam_to_the_wall("revolute"), CO_MOVING)
    held = static_equilibrium(scene, [0.0])
    assert held.torque[0] == pytest.approx(7800.0 * 0.03 * 0.01 * 9.81 * 0.5**2 / 8, rel=1e-4)
    assert np.allclose(held.link_end[0], [0.5, 0.0, 0.0], atol=1e-9)
