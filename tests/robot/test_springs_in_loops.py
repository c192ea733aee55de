"""Springs between motors and links of robots with closed loops."""

import numpy as np
import pytest
from mechanisms import FourBar, SliderCrank, four_bar, slider_crank, slope, sprung_crank_motion
from scenes import CONFIG
from test_loops import GAP, SCENES, SOFT, TIGHT, driven

from flexsim_node import linearize, load_scene, natural_frequencies, simulate, static_equilibrium

ROTOR, STIFFNESS, DAMPING = 0.02, 60.0, 0.05


def sprung(scene, stiffness=STIFFNESS, damping=DAMPING):
    """The scene with a spring behind the crank's motor."""
    scene["links"][0]["joint"] = {"rotor_inertia": ROTOR, "stiffness": stiffness, "damping": damping}
    return scene


@pytest.mark.parametrize(
    "make", [(four_bar, FourBar()), (slider_crank, SliderCrank())], ids=["four", "slide"]
)
def test_rigid_links_behind_a_spring_are_the_closed_form(make):
    """The mechanism's reduced inertia on a spring, and the motor's: angles to 1e-8, both of them."""
    build, mechanism = make
    scene = sprung(build())
    joints = len(load_scene(scene).joints)
    run = simulate(load_scene(scene, TIGHT), driven(1.5, joints), 0.6, 0.05)
    assert run.status == "ok"
    assert np.max(run.loop_gap) < GAP
    theta, _, motor, turn = sprung_crank_motion(
        mechanism, 0.7, 8.0, 1.5, (STIFFNESS, DAMPING), ROTOR, run.time
    )
    assert np.ptp(motor - theta) > 0.2
    assert np.allclose(run.joint_position[:, 0], motor, rtol=0, atol=1e-8)
    assert np.allclose(run.joint_velocity[:, 0], turn, rtol=0, atol=1e-6)
    crank = run.link_end[:, 0, 0] + 1j * run.link_end[:, 0, 1]
    assert np.allclose(crank, 0.15 * np.exp(1j * theta), rtol=0, atol=2e-9)


def test_a_driven_motor_leaves_the_mechanism_its_spring():
    """A motor that turns at a constant speed; the crank swings about it as the closed form says."""
    scene = sprung(four_bar())
    turning = {"crank_joint": lambda t: (0.7 + 8.0 * t, 8.0, 0.0)}
    run = simulate(load_scene(scene, TIGHT), duration=0.4, sample_period=0.05, prescribed=turning)
    # a rotor too heavy to feel the mechanism
    theta, *_ = sprung_crank_motion(FourBar(), 0.7, 8.0, 0.0, (STIFFNESS, DAMPING), 1e12, run.time)
    assert np.allclose(run.joint_position[:, 0], 0.7 + 8.0 * run.time, rtol=0, atol=1e-14)
    crank = run.link_end[:, 0, 0] + 1j * run.link_end[:, 0, 1]
    assert np.allclose(crank, 0.15 * np.exp(1j * theta), rtol=0, atol=2e-8)
    assert np.max(run.loop_gap) < GAP


@pytest.mark.parametrize("name", SCENES)
def test_a_stiff_spring_comes_to_none(name):
    """The scenes that we ship, elastic: ten times the stiffness, a tenth of the difference."""
    scene = load_scene(CONFIG / f"{name}.yaml")
    motors = [k for k, link in enumerate(scene.links) if link.joint.type != "fixed" and link.joint.actuated]
    actuated = np.array([joint.actuated for joint in scene.joints])
    size = {"four_bar": 0.05, "five_bar": 0.3}.get(name, 1.0) * actuated
    held = static_equilibrium(scene, scene.start("position")).torque if name == "delta" else 0.0
    ends = []
    for stiffness in (None, 1e4, 1e5):
        springs = {f"links.{k}.joint.stiffness": stiffness for k in motors}
        given = {**springs, **{f"links.{k}.joint.rotor_inertia": 2e-3 for k in motors}}
        run = simulate(
            load_scene(CONFIG / f"{name}.yaml", {**given, "solver.step": 2e-4}),
            lambda t: held + size * np.sin(40.0 * t) ** 2,
            duration=0.02,
            sample_period=2e-3,
        )
        assert run.status == "ok"
        assert np.max(run.loop_gap) < GAP
        ends.append(run.link_end)
    apart = [np.max(np.abs(end - ends[0])) for end in ends[1:]]
    assert 0.0 < apart[0] < 1e-3
    assert 0.9 < np.log10(apart[0] / apart[1]) < 1.1


def test_energy_is_kept():
    """Elastic links and joint, undamped: Radau keeps the energy, the spring's among it."""
    scene = sprung(four_bar(SOFT, gravity=[0.0, -9.81, 0.0]), damping=0.0)
    tight = {"solver.method": "radau", "solver.relative_tolerance": 1e-8, "solver.absolute_tolerance": 1e-10}
    run = simulate(load_scene(scene, tight), duration=0.03, sample_period=0.005)
    assert run.status == "ok"
    assert np.max(np.abs(run.energy - run.energy[0])) < 1e-7 * 0.5 * FourBar().inertia(0.7) * 8.0**2
    assert np.max(run.loop_gap) < GAP


def test_at_rest():
    """The mechanism's weight winds the spring; frequencies are those of two inertias on it."""
    scene = load_scene(sprung(four_bar(), damping=0.0))
    for motor in (0.3, 1.2):
        held = static_equilibrium(scene, [motor])
        crank = np.arctan2(held.link_end[0, 1], held.link_end[0, 0])
        assert held.torque == pytest.approx([slope(FourBar().height, crank), 0.0, 0.0], rel=1e-6)
        assert STIFFNESS * (motor - crank) == pytest.approx(held.torque[0], rel=1e-9)
        inertia = FourBar().inertia(motor)
        locked = natural_frequencies(scene, [motor])
        assert locked == pytest.approx(np.sqrt(STIFFNESS / inertia) / (2 * np.pi), rel=1e-7)
        free = natural_frequencies(scene, [motor], locked=False)
        assert free[0] < 1e-3 * free[1]
        both = np.sqrt(STIFFNESS * (1 / inertia + 1 / ROTOR)) / (2 * np.pi)
        assert free[1] == pytest.approx(both, rel=1e-7)
    held = natural_frequencies(scene, [0.3], loaded=True)
    linear = linearize(scene, [0.3], held=["crank_joint"])
    assert linear.natural_frequencies() == pytest.approx(held, rel=1e-6)
    assert linearize(scene, [0.3]).input_names == ("torque/crank_joint",)
