"""Loops at rest: starts that close or are refused, static equilibrium, natural frequencies, linear models."""

import numpy as np
import pytest
from mechanisms import CRANK, FourBar, four_bar
from scenes import CONFIG, link, robot
from test_loops import delta_place, rigid_delta

from flexsim_node import SceneError, load_scene, natural_frequencies, simulate, static_equilibrium
from flexsim_node.analysis.linearization import linearize
from flexsim_node.motion.simulation import Simulation
from flexsim_node.service.commands import CommandRefused, Commands

MASS, STIFFNESS = 7800.0 * 0.03 * 0.01, 2e11 * 0.01 * 0.03**3 / 12  # kg/m, N m2


def beam_to_the_wall(joint, **keys):
    """A beam on a motor, its other end held by the base."""
    return robot(
        link("beam", {"a": 0.5}, beam={"elements": 8}),
        loops=[{"links": ["beam", "base"], "joint": joint, "at": {"base": [0.5, 0.0, 0.0]}}],
        gravity=[0.0, -9.81, 0.0],
        **keys,
    )


@pytest.mark.parametrize(("joint", "root"), [("fixed", 4.730041), ("revolute", 3.926602)])
def test_frequency_of_a_beam_held_at_both_ends(joint, root):
    """Clamped-clamped and clamped-pinned Euler-Bernoulli beams, in the plane of their width."""
    scene = beam_to_the_wall(joint, effects={"rotary_inertia": False, "bending_y": False})
    right = (root / 0.5) ** 2 * np.sqrt(STIFFNESS / MASS) / (2 * np.pi)
    assert natural_frequencies(load_scene(scene), [0.0])[0] == pytest.approx(right, rel=1e-4)


def test_propped_cantilever():
    """A clamped beam with a pin at its end: w x^2 (3 L^2 - 5 L x + 2 x^2) / 48 EI, w L^2 / 8 holds it."""
    scene = load_scene(beam_to_the_wall("revolute"))
    held = static_equilibrium(scene, [0.0])
    weight = MASS * 9.81
    assert held.torque[0] == pytest.approx(weight * 0.5**2 / 8, rel=1e-4)
    x = np.linspace(0.0, 0.5, 9)
    right = -weight * x**2 * (0.75 - 2.5 * x + 2 * x**2) / (48 * STIFFNESS)
    assert np.allclose(held.node_position[:, 1], right, rtol=0, atol=1e-4 * np.max(np.abs(right)))
    assert np.allclose(held.link_end[0], [0.5, 0.0, 0.0], atol=1e-9)


def test_holding_torque_of_a_rigid_four_bar():
    """The derivative of the closed form's height."""
    for theta in (0.3, 1.2, 2.5):
        slope = (FourBar().height(theta + 1e-5) - FourBar().height(theta - 1e-5)) / 2e-5
        held = static_equilibrium(load_scene(four_bar()), [theta])
        assert held.torque == pytest.approx([slope, 0.0, 0.0], rel=1e-6)


def test_holding_torques_of_a_rigid_delta():
    """By virtual work: platform, and each rod's middle, from the closed form."""
    scene = rigid_delta()
    q = np.array([0.3, 0.5, 0.45])
    spread = 2.0 * np.pi / 3.0 * np.arange(3)
    arm, rod = 2700 * 0.03 * 0.02 * 0.3, 1600 * 0.008**2 * 0.8

    def height(q):
        z = delta_place(q)[2]
        elbows = -0.3 * np.sin(q)
        return 9.81 * (0.5 * z + np.sum(0.5 * arm * elbows + rod * 0.5 * (elbows + z)))

    slope = [(height(q + e) - height(q - e)) / 2e-5 for e in 1e-5 * np.eye(3)]
    held = static_equilibrium(scene, [q[1], q[2], q[0]])
    torque = dict(zip(scene.joint_names, held.torque, strict=True))
    assert [torque[f"motor_{k}"] for k in (1, 2, 3)] == pytest.approx(slope, rel=1e-6)
    assert np.allclose(held.link_end[-1], delta_place(q), atol=1e-10)
    assert spread.size == 3


def test_elastic_loop_stays_at_rest():
    """From its static shape under gravity, motors holding, nothing moves."""
    scene = load_scene(CONFIG / "delta.yaml")
    robot_now = Simulation(scene)
    held = static_equilibrium(scene, scene.start("position"))
    run = simulate(scene, lambda t: held.torque, duration=0.05)
    assert run.status == "ok"
    sag = np.max(np.abs(run.node_displacement[0, :, :3]))
    assert sag > 1e-5
    assert np.max(np.abs(run.node_position - run.node_position[0])) < 1e-3 * sag
    assert robot_now.model.planar is False


def test_linear_model_of_a_loop():
    """A small step of torque: the linear model moves as the simulation does, and has its frequencies."""
    scene = load_scene(
        four_bar({"elements": 2}, damping={"beta": 1e-4}, initial={"position": [1.2], "shape": "static"}),
        {"solver.step": 1e-4},
    )
    model = linearize(scene, [1.2], outputs=("joint_position", "tip_position"))
    free = natural_frequencies(scene, [1.2], locked=False, loaded=True)
    planar = model.natural_frequencies()
    assert planar[0] == pytest.approx(free[0], rel=1e-4)
    hold = static_equilibrium(scene, [1.2]).torque
    push = 1e-3 * abs(hold[0])
    run = simulate(scene, lambda t: hold + np.array([push, 0.0, 0.0]), 0.05, sample_period=1e-3)
    a, b = model.discretize(1e-3)
    state, moved = np.zeros(len(a)), []
    for _ in run.time:
        moved.append(model.C @ state + model.D @ [push])
        state = a @ state + b @ [push]
    moved = np.array(moved)
    right = run.joint_position - run.joint_position[0]
    assert np.allclose(moved[:, :3], right, rtol=0, atol=2e-3 * np.max(np.abs(right)))


def test_passive_joints_are_found():
    """From rough guesses, or none: the given joints stay, the passive ones close the loop."""
    for position in ([0.7], {"crank_joint": 0.7}, [0.7, 0.3, 0.9], {"crank_joint": 0.7, "rocker_joint": 1.0}):
        scene = load_scene(four_bar(initial={"position": position, "velocity": [2.0]}))
        robot_now = Simulation(scene)
        psi, chi = FourBar().angles(0.7)
        turn, swing = FourBar().ratios(0.7)
        assert robot_now.joint_position() == pytest.approx([0.7, psi - 0.7, chi], abs=1e-10)
        assert robot_now.joint_velocity() == pytest.approx([2.0, 2 * (turn - 1), 2 * swing], abs=1e-9)
    # a guess on the other side of the line closes the other way round
    other = load_scene(four_bar(initial={"position": [0.7, -1.5, -1.0]}))
    assert Simulation(other).joint_position()[2] < 0.0


def test_a_start_that_can_not_be_closed():
    """The gap is said in metres: what the links lack when they are stretched out."""
    scene = four_bar(lengths=(CRANK, 0.1, 0.15, 0.6), initial={"position": [np.pi / 2]})
    gap = np.hypot(CRANK, 0.6) - 0.25
    with pytest.raises(SceneError) as refusal:
        simulate(load_scene(scene), duration=0.1)
    message = str(refusal.value)
    assert "loops.0: coupler and rocker can't be closed" in message
    assert f"a gap of {gap:.3g} m remains" in message
    assert "coupler_joint, rocker_joint" in message
    assert "\n" not in message


def test_rates_that_a_loop_can_not_have():
    """All joints given, none passive: positions that close and rates that don't."""
    psi, chi = FourBar().angles(0.7)
    scene = four_bar(initial={"position": [0.7, psi - 0.7, chi], "velocity": [1.0, 0.0, 0.0]})
    for part in scene["links"]:
        part.get("joint", {}).pop("actuated", None)
    with pytest.raises(SceneError, match="initial velocities open a loop at"):
        simulate(load_scene(scene), duration=0.1)


def test_torques_on_passive_joints_are_refused():
    scene = load_scene(four_bar())
    for torque in (lambda t: np.array([0.0, 1.0, 0.0]), np.array([[0.0, 1.0, 0.0]])):
        with pytest.raises(ValueError, match="torque on coupler_joint, which is passive; give zero there"):
            simulate(scene, torque, duration=0.01)
    commands = Commands(scene.joint_names, scene.passive_joints)
    commands.in_order([1.0, 0.0, 0.0])
    with pytest.raises(CommandRefused, match="rocker_joint is passive, it has no motor"):
        commands.by_name(["rocker_joint"], [0.5])
    assert commands.refused["passive joint"] == 1
    assert list(commands.torque) == [1.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("loop", "said"),
    [
        ({"links": ["coupler"]}, "links: is a list of 1; give at least 2 values"),
        ({"links": ["coupler", "coupler"]}, "links.1: is 'coupler' again; give two different links"),
        ({"links": ["coupler", "rokcer"]}, "'rokcer', which does not exist; give rocker"),
        ({"links": ["coupler", "rocker"], "joint": "hinge"}, "give 'revolute', 'universal', 'spherical'"),
        ({"links": ["coupler", "rocker"], "at": {"crank": [0, 0, 0]}}, "is no link of this joint; give coup"),
        ({"links": ["coupler", "rocker"], "at": {"rocker": [0, 0]}}, "is a list of 2; give at least 3"),
        ({"links": ["coupler", "rocker"], "axis": {"rocker": [0, 0, 0]}}, "is zero; give a direction"),
        ({"links": ["coupler", "rocker"], "joint": "fixed", "axis": {"rocker": [0, 0, 1]}}, "has none"),
        ({"links": ["coupler", "rocker"], "joint": "slot"}, "give axis: {rocker: [1, 0, 0]}"),
        ({"links": ["coupler", "rocker"], "joint": "universal"}, "needs the directions of its two pins"),
        ({"links": ["coupler", "rocker"], "points": 3}, "points: unknown key; did you mean 'joint'?"),
    ],
)
def test_loops_that_are_none(loop, said):
    with pytest.raises(SceneError) as refusal:
        load_scene(four_bar(loops=[loop]))
    assert str(refusal.value).startswith("scene: loops.0")
    assert said in str(refusal.value)


@pytest.mark.parametrize(
    ("initial", "said"),
    [
        ({"position": [0.1, 0.2]}, "has 2 values for 3 moving joints (1 actuated); give 3, or 1"),
        ({"position": {"crank": 0.1}}, "position.crank: is no joint; give one of crank_joint, coupler_joint"),
        ({"position": {"crank_joint": "x"}}, "position.crank_joint: is 'x'; give a number"),
    ],
)
def test_starts_that_are_none(initial, said):
    with pytest.raises(SceneError) as refusal:
        load_scene(four_bar(initial=initial))
    assert said in str(refusal.value)
