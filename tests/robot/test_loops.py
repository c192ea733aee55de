"""Closed loops: rigid mechanisms move as closed forms say, elastic ones keep their energy, gaps stay shut."""

import numpy as np
import pytest
from mechanisms import (
    FourBar,
    SliderCrank,
    crank_motion,
    four_bar,
    slider_crank,
)
from scenes import CONFIG, DATA
from scipy.integrate import simpson

from flexsim_node import load_scene, simulate
from flexsim_node.motion.simulation import Simulation

TIGHT = {
    "solver.method": "dop853",
    "solver.relative_tolerance": 1e-11,
    "solver.absolute_tolerance": 1e-12,
}
STEEL = {"elements": 2}
SOFT = {"elements": 1, "youngs_modulus": 1e8}
GAP = 1e-9  # m, what a user was promised
SCENES = ["four_bar", "five_bar", "slider_crank", "delta"]


def driven(torque, joints):
    return lambda t: np.array([torque] + [0.0] * (joints - 1))


@pytest.mark.parametrize("torque", [0.0, 1.5])
def test_rigid_four_bar_is_the_closed_form(torque):
    """Crank, coupler and rocker over 0.6 s, swinging or turned by a torque: angles to 1e-8, rates to 1e-6."""
    run = simulate(load_scene(four_bar(), TIGHT), driven(torque, 3), 0.6, 0.05)
    assert run.status == "ok"
    theta, speed = crank_motion(FourBar(), 0.7, 8.0, torque, run.time)
    psi, chi = np.unwrap(FourBar().angles(theta), axis=1)
    turn, swing = FourBar().ratios(theta)
    assert np.ptp(theta) > 2.0
    assert np.allclose(run.joint_position.T, [theta, psi - theta, chi], rtol=0, atol=1e-8)
    assert np.allclose(run.joint_velocity.T, [speed, (turn - 1) * speed, swing * speed], rtol=0, atol=1e-6)
    assert np.max(run.loop_gap) < GAP


def test_rigid_slider_crank_is_the_closed_form():
    """Crank and slider over 0.6 s; and with the crank driven at a constant speed."""
    run = simulate(load_scene(slider_crank(), TIGHT), driven(0.5, 2), 0.6, 0.05)
    theta, _ = crank_motion(SliderCrank(), 0.7, 8.0, 0.5, run.time)
    rod, place = SliderCrank().angles(theta)
    assert np.allclose(run.joint_position.T, [theta, rod - theta], rtol=0, atol=1e-8)
    assert np.allclose(run.link_end[:, 1, 0], place, rtol=0, atol=1e-8)
    assert np.max(np.abs(run.link_end[:, 1, 1])) < GAP

    turning = {"crank_joint": lambda t: (20.0 * t, 20.0, 0.0)}
    scene = slider_crank(initial={"position": [0.0]})
    run = simulate(load_scene(scene), duration=0.5, prescribed=turning)
    rod, place = SliderCrank().angles(20.0 * run.time)
    turn, _ = SliderCrank().ratios(20.0 * run.time)
    assert np.allclose(run.link_end[:, 1, 0], place, rtol=0, atol=1e-10)
    assert np.allclose(run.joint_velocity[:, 1], 20.0 * (turn - 1.0), rtol=0, atol=1e-8)


def test_rigid_five_bar_is_the_closed_form():
    """Both motors move; the tool is where the two circles meet."""
    scene = load_scene(
        CONFIG / "five_bar.yaml",
        {f"links.{name}.flexible": False for name in ("left_arm", "left_rod", "right_arm", "right_rod")},
    )
    motion = {
        "left_motor": lambda t: (2.0 + 0.4 * np.sin(6 * t), 2.4 * np.cos(6 * t), -14.4 * np.sin(6 * t)),
        "right_motor": lambda t: (1.1 - 0.3 * np.sin(9 * t), -2.7 * np.cos(9 * t), 24.3 * np.sin(9 * t)),
    }
    run = simulate(scene, duration=1.0, prescribed=motion)
    assert run.status == "ok"
    left = 0.25 * np.exp(1j * (2.0 + 0.4 * np.sin(6 * run.time)))
    right = 0.2 + 0.25 * np.exp(1j * (1.1 - 0.3 * np.sin(9 * run.time)))
    across = right - left
    tool = left + 0.5 * across + 1j * across / abs(across) * np.sqrt(0.35**2 - 0.25 * abs(across) ** 2)
    for n in (1, 4):
        found = run.link_end[:, n, 0] + 1j * run.link_end[:, n, 1]
        assert np.max(np.abs(found - tool)) < 1e-10


def delta_place(q):
    """(3,) platform of config/delta.yaml for motor angles (3,): where three spheres meet below the base."""
    spread = 2.0 * np.pi / 3.0 * np.arange(3)
    out = 0.2 - 0.05 + 0.3 * np.cos(q)
    centres = np.column_stack([out * np.cos(spread), out * np.sin(spread), -0.3 * np.sin(q)])
    place = np.array([0.0, 0.0, -0.8])
    for _ in range(20):
        away = place - centres
        place = place - np.linalg.solve(2.0 * away, np.sum(away**2, axis=1) - 0.8**2)
    return place


def rigid_delta(**overrides):
    links = [f"links.{part}_{i}.flexible" for part in ("arm", "rod") for i in (1, 2, 3)]
    return load_scene(CONFIG / "delta.yaml", {**dict.fromkeys(links, False), **overrides})


def test_rigid_delta_is_the_closed_form():
    """A spatial parallel robot: the platform is where three spheres meet, and keeps its orientation."""

    def swing(k):
        w = 5.0 + k
        return lambda t: (0.4 + 0.3 * np.sin(w * t), 0.3 * w * np.cos(w * t), -0.3 * w * w * np.sin(w * t))

    scene = rigid_delta()
    run = simulate(scene, duration=0.4, prescribed={f"motor_{k}": swing(k) for k in (1, 2, 3)})
    assert run.status == "ok"
    assert np.max(run.loop_gap) < GAP
    for t, place in zip(run.time[::40], run.link_end[::40, -1], strict=True):
        right = delta_place(np.array([swing(k)(t)[0] for k in (1, 2, 3)]))
        assert np.allclose(place, right, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", SCENES)
def test_loops_stay_closed_in_every_step(name):
    """The scenes that we ship, elastic as they are, for half a second or so."""
    scene = load_scene(CONFIG / f"{name}.yaml")
    run = simulate(scene, duration=100 * scene.solver.step if name == "delta" else 0.3)
    assert run.status == "ok"
    assert np.max(run.loop_gap) < GAP
    assert np.min(run.conditioning) > 0.05
    moved = np.ptp(run.joint_position, axis=0).max()
    assert moved > (0.005 if name == "delta" else 0.3) or name == "five_bar"


def test_a_reset_loop_does_the_same_again():
    robot = Simulation(load_scene(CONFIG / "four_bar.yaml", {"solver.method": "rosenbrock_w"}))

    def run():
        return np.array([[robot.step(), *robot.x, *robot.v] for _ in range(30)])

    robot.prepare()
    first = run()
    robot.reset()
    np.testing.assert_array_equal(run(), first)
    assert np.all(first[:, 0] == 0) and np.any(np.diff(first[:, 1:], axis=0))


def test_a_stiff_loop_comes_to_the_rigid_one():
    """Ten times the modulus, a tenth of the difference from the closed form."""
    times = np.linspace(0.0, 0.5, 51)
    theta, _ = crank_motion(FourBar(), 0.7, 8.0, 0.0, times)
    error = []
    for modulus in (2e11, 2e12, 2e13):
        scene = four_bar({**STEEL, "youngs_modulus": modulus}, damping={"beta": 1e-4})
        run = simulate(load_scene(scene, {"solver.step": 1e-4}), duration=0.5, sample_period=0.01)
        error.append(np.max(np.abs(run.joint_position[:, 0] - theta)))
    assert error[0] < 5e-3
    assert error[1] < 0.2 * error[0]
    assert error[2] < 0.3 * error[1]


@pytest.mark.parametrize("space", [False, True], ids=["planar", "in space"])
def test_energy_is_kept(space):
    """Elastic loops, undamped: Radau at a tight tolerance keeps the energy to 1e-7 of the kinetic one."""
    scene = four_bar(SOFT, gravity=[0.0, -9.81, -3.0 if space else 0.0])
    tight = {"solver.method": "radau", "solver.relative_tolerance": 1e-8, "solver.absolute_tolerance": 1e-10}
    run = simulate(load_scene(scene, tight), duration=0.03, sample_period=0.005)
    assert run.status == "ok"
    assert np.max(np.abs(run.energy - run.energy[0])) < 1e-7 * 0.5 * FourBar().inertia(0.7) * 8.0**2
    assert np.max(run.loop_gap) < GAP


def test_drift_of_the_default_integrator():
    """A steel four-bar turns undamped for two seconds at 1 ms."""
    run = simulate(load_scene(four_bar(STEEL)), duration=2.0)
    assert run.status == "ok"
    assert np.max(np.abs(run.energy - run.energy[0])) < 1e-3 * 0.5 * FourBar().inertia(0.7) * 8.0**2
    assert np.max(run.loop_gap) < GAP


def test_torque_gives_its_work():
    """The energy gained is the motor's work; the closing joint does none."""
    scene = load_scene(four_bar(SOFT), {**TIGHT, "solver.relative_tolerance": 1e-9})
    run = simulate(scene, lambda t: np.array([2.0 * np.sin(30 * t), 0.0, 0.0]), 0.1, sample_period=5e-4)
    work = simpson(np.sum(run.torque * run.joint_velocity, axis=1), x=run.time)
    assert abs(work) > 0.5
    assert run.energy[-1] - run.energy[0] == pytest.approx(work, rel=1e-5)


@pytest.mark.parametrize(
    ("method", "order", "steps"),
    [
        ("rosenbrock_w", 2, (320, 640, 1280)),
        ("generalized_alpha", 2, (320, 640, 1280)),
        ("runge_kutta_4", 4, (640, 1280)),
    ],
)
def test_order_in_the_step(method, order, steps):
    """Loops leave each method its order."""
    duration = 0.06

    def tips(**solver):
        scene = four_bar(SOFT, damping={"alpha": 2.0, "beta": 1e-3}, solver=solver)
        run = simulate(load_scene(scene), duration=duration, sample_period=duration / 2)
        assert run.status == "ok"
        return run.link_end

    exact = tips(method="dop853", relative_tolerance=1e-11, absolute_tolerance=1e-12)
    error = [np.max(np.abs(tips(method=method, step=duration / n) - exact)) for n in steps]
    assert np.log2(error[0] / error[-1]) / (len(steps) - 1) > order - 0.25


def test_a_planar_loop_written_in_space():
    """Three of five equations depend on the others: the motion is the planar one all the same."""
    flat = four_bar()
    space = four_bar(gravity=[0.0, -9.81, -5.0])
    one, two = (simulate(load_scene(s), duration=0.5, sample_period=0.01) for s in (flat, space))
    assert two.status == "ok"
    assert one.node_displacement.shape == two.node_displacement.shape
    assert np.allclose(one.joint_position, two.joint_position, rtol=0, atol=1e-9)


def test_elastic_rod_at_speed_is_exudyns():
    """150 rad/s through every dead centre: the rod bends by 4.6 mm, within 0.1 mm of ANCF cables."""
    scene = load_scene(CONFIG / "slider_crank.yaml", {"effects.rotary_inertia": False})
    right = np.genfromtxt(DATA / "slider_crank_steel.csv", delimiter=",", names=True)
    run = simulate(
        scene,
        duration=0.05,
        sample_period=2.5e-4,
        prescribed={"crank_joint": lambda t: (150.0 * t, 150.0, 0.0)},
    )
    assert run.status == "ok"
    assert np.max(run.loop_gap) < GAP
    assert np.allclose(run.time, right["t"], rtol=0, atol=1e-9)
    nodes = [i for i, name in enumerate(run.node_names) if name.startswith("rod/")]
    rod = run.node_position[:, nodes, 0] + 1j * run.node_position[:, nodes, 1]
    assert np.max(np.abs(rod[:, 2] - (right["middle_x"] + 1j * right["middle_y"]))) < 1e-4
    assert np.max(np.abs(rod[:, -1] - right["slider_x"])) < 1e-4
    along = rod[:, -1] - rod[:, 0]
    bent = ((rod[:, 2] - rod[:, 0]) / along * abs(along)).imag
    assert 4e-3 < np.max(np.abs(bent)) < 5e-3


def test_singular_configuration_is_announced():
    """Coupler and rocker come into line: the crank can go no further, and the conditioning says so before."""
    lengths = (0.3, 0.25, 0.25, 0.4)
    scene = four_bar(lengths=lengths, initial={"position": [1.0, -1.5, 1.9]}, gravity=[0, 0, 0])
    limit = np.arccos((0.3**2 + 0.4**2 - 0.5**2) / (2 * 0.3 * 0.4))

    def push(t):
        return 1.0 + 0.5 * t, 0.5, 0.0

    run = simulate(load_scene(scene), duration=2.0, prescribed={"crank_joint": push})
    assert "come near a singular configuration" in run.warnings[0]
    assert run.status != "ok"
    assert "a loop can't be kept closed" in run.status
    assert run.time[-1] == pytest.approx((limit - 1.0) / 0.5, abs=0.01)
    warned = np.flatnonzero(run.conditioning < 0.1)[0]
    assert run.time[warned] < run.time[-1] - 0.01
    assert np.all(np.diff(run.conditioning[len(run.time) // 2 :]) < 0)
    for values in (run.joint_position, run.joint_velocity, run.node_position, run.energy):
        assert np.all(np.isfinite(values))
    assert np.max(run.loop_gap) < GAP
