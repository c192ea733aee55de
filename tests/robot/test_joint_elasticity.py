"""A spring and damper between motor and link."""

import numpy as np
import pytest
from scenes import anthropomorphic, link, robot

from flexsim_node import SceneError, load_scene, natural_frequencies, simulate, static_equilibrium

MOTOR = {"rotor_inertia": 0.04, "stiffness": 500.0}
STILL = {"gravity": [0.0, 0.0, 0.0]}


def bar(joint, **keys):
    """A rigid bar, 0.5 m and 1.176 kg, on one joint."""
    return load_scene(
        robot(link("bar", {"a": 0.5}, flexible=False, joint=joint), **{"gravity": [0.0, -9.81, 0.0], **keys})
    )


def bar_inertia(scene):
    """Of the rectangular bar about its end."""
    beam = scene.links[0].beam
    mass = beam.density * beam.width * beam.depth * 0.5
    return mass, mass * (0.5**2 / 3 + beam.width**2 / 12)


def test_motor_locked_and_free_frequencies():
    """Two inertias on a spring: k / J against ground, k (1 / J + 1 / J_m) when the motor is free."""
    scene = bar(MOTOR, **STILL)
    inertia = bar_inertia(scene)[1]
    locked = natural_frequencies(scene, [0.3])
    free = natural_frequencies(scene, [0.3], locked=False)
    assert locked == pytest.approx(np.sqrt(500.0 / inertia) / (2 * np.pi), rel=1e-9)
    assert free[0] == 0.0
    assert free[1] == pytest.approx(np.sqrt(500.0 * (1 / inertia + 1 / 0.04)) / (2 * np.pi), rel=1e-9)


def test_link_sags_on_its_spring():
    """The weight's moment winds the spring; the motor holds that moment."""
    scene = bar({**MOTOR, "stiffness": 40.0})
    mass, _ = bar_inertia(scene)
    rest = static_equilibrium(scene, [0.0])
    x, y, _ = rest.link_end[0]
    sag = np.arctan2(y, x)
    moment = mass * 9.81 * 0.25 * np.cos(sag)
    assert rest.torque == pytest.approx(moment, rel=1e-9)
    assert -sag == pytest.approx(moment / 40.0, rel=1e-9)


def test_ring_down_of_a_damped_spring():
    """A prescribed motor: the link swings at k / J with the damper's decay, against the closed form."""
    scene = bar({**MOTOR, "damping": 0.3}, solver={"step": 2e-4}, **STILL)
    inertia = bar_inertia(scene)[1]
    step = 0.01  # rad, to which the motor goes at once
    run = simulate(
        scene, duration=0.3, prescribed={"bar_joint": lambda t: (step if t > 0 else 0.0, 0.0, 0.0)}
    )
    rate, omega = 0.3 / (2 * inertia), np.sqrt(500.0 / inertia)
    turning = np.sqrt(omega**2 - rate**2)
    t = run.time
    right = step * (1 - np.exp(-rate * t) * (np.cos(turning * t) + rate / turning * np.sin(turning * t)))
    angle = np.arctan2(run.link_end[:, 0, 1], run.link_end[:, 0, 0])
    assert np.max(np.abs(run.joint_position[1:, 0] - step)) == 0.0
    assert np.max(np.abs(angle - right)) < 0.02 * step


def test_stiff_spring_is_no_spring():
    """With a stiffer spring the motion goes to that of the rigid joint, in proportion to 1 / k."""
    joint = {"rotor_inertia": 0.05}
    runs = {}
    for k in (None, 1e4, 1e5):
        scene = anthropomorphic()
        for part in scene["links"]:
            part["joint"] = {**joint, "stiffness": k} if k else joint
            part["flexible"] = False
        scene["solver"] = {"method": "radau"}
        runs[k] = simulate(load_scene(scene), duration=0.2, sample_period=0.02)
    apart = [np.max(np.abs(runs[k].link_end - runs[None].link_end)) for k in (1e4, 1e5)]
    assert 0 < apart[1] < 0.2 * apart[0] < 1e-3
    for k in (1e4, 1e5):
        energy = runs[k].energy
        assert np.max(np.abs(energy - energy[0])) < 1e-6


def test_spring_is_left_out_when_its_effect_is_off():
    """Then neither unknowns nor motion know of it."""
    on, off = (bar(MOTOR, effects={"joint_elasticity": switch}) for switch in (True, False))
    plain = bar({"rotor_inertia": 0.04})
    ends = [simulate(scene, duration=0.1).link_end[-1] for scene in (on, off, plain)]
    assert np.array_equal(ends[1], ends[2])
    assert np.max(np.abs(ends[0] - ends[1])) > 1e-5


@pytest.mark.parametrize(
    ("joint", "words"),
    [
        ({"stiffness": 100.0}, "give its rotor_inertia"),
        ({"damping": 1.0}, "without a stiffness"),
        ({"stiffness": 100.0, "rotor_inertia": 0.1, "actuated": False}, "the joint is passive"),
        ({"stiffness": 0.0, "rotor_inertia": 0.1}, "more than 0"),
    ],
)
def test_half_a_spring_is_refused(joint, words):
    """What is missing is named."""
    with pytest.raises(SceneError, match=words):
        bar(joint)
