"""Which elastic dofs are zeroed changes the rigid-link system, not the robot's motion."""

import itertools

import numpy as np
import pytest
from scenes import anthropomorphic
from test_independent_equations import SETS

from flexsim_node import SceneError, load_scene, simulate

CHOICES = {"root": {"zeroed": "root"}, **{name: erls for name, (erls, _) in SETS.items()}}


def driven(erls, modulus, method="generalized_alpha"):
    """The driven robot of the reference, with stiffness-proportional damping of the same ratio."""
    scene = anthropomorphic(erls=erls, damping={"alpha": 0.0, "beta": 4e-5 * 2e11 / modulus})
    overrides = {f"links.{k}.beam.youngs_modulus": modulus for k in range(3)}

    def torque(t):
        return np.array([5.0 * np.sin(2 * np.pi * t), 0.0, 0.0])

    overrides["solver.method"] = method
    run = simulate(load_scene(scene, overrides), torque, 0.5, sample_period=0.01)
    assert run.status == "ok"
    return run


@pytest.fixture(scope="module")
def runs():
    return {
        (name, modulus): driven(erls, modulus) for name, erls in CHOICES.items() for modulus in (5e10, 2e10)
    }


def apart(runs, a, b, modulus):
    """Largest distance between the link ends of two choices, and the largest elastic rotation."""
    one, two = runs[a, modulus], runs[b, modulus]
    rotation = max(np.max(np.abs(r.node_displacement[:, :, 3:])) for r in (one, two))
    return np.max(np.linalg.norm(one.link_end - two.link_end, axis=2)), rotation


@pytest.mark.parametrize(("a", "b"), list(itertools.combinations(CHOICES, 2)))
def test_same_motion_to_the_squared_rotation(runs, a, b):
    """Tips of every pair of choices agree within phi^2 L / 2, L the 1 m reach of links 2 and 3."""
    for modulus in (5e10, 2e10):
        distance, rotation = apart(runs, a, b, modulus)
        assert rotation > 0.03
        assert distance < 0.5 * rotation**2


def test_difference_grows_faster_than_the_squared_rotation(runs):
    """2.5 times softer links bend 2.5 times as much and differ more than 12 times as much: the sets' terms of
    second order in the rotation are the same.
    """
    stiff = max(apart(runs, a, b, 5e10)[0] for a, b in itertools.combinations(CHOICES, 2))
    soft = max(apart(runs, a, b, 2e10)[0] for a, b in itertools.combinations(CHOICES, 2))
    bent = apart(runs, "root", "A", 2e10)[1] / apart(runs, "root", "A", 5e10)[1]
    assert np.log(soft / stiff) / np.log(bent) > 2.75


@pytest.mark.parametrize("name", CHOICES)
def test_default_integrator_whatever_is_zeroed(name):
    """At 1 ms with the default method, steel: each choice moves as `root` under generalized-alpha does."""
    right = driven(CHOICES["root"], 2e11)
    run = driven(CHOICES[name], 2e11, "rosenbrock_w")
    rotation = np.max(np.abs(right.node_displacement[:, :, 3:]))
    assert np.max(np.linalg.norm(run.link_end - right.link_end, axis=2)) < rotation**2


@pytest.mark.parametrize(
    ("zeroed", "said"),
    [
        ([("link_2", 2, "rz"), ("link_2", 0, "rz"), ("link_3", 0, "rz")], "J_0 is singular"),
        ([("link_1", 2, "x"), ("link_2", 0, "rz"), ("link_3", 0, "rz")], "J_0 is singular"),
        ([("link_2", 0, "rz"), ("link_3", 0, "rz")], "lists 2 dofs for 3 revolute joints"),
        ([("link_2", 0, "rz"), ("link_2", 0, "rz"), ("link_3", 0, "rz")], "listed twice"),
        ([("link_1", 2, "rz"), ("link_2", 3, "rz"), ("link_3", 0, "rz")], "the end of link_2 is node 2"),
        ([("link_1", 2, "rz"), ("link_2", 0, "ry"), ("link_3", 0, "rz")], "only rz"),
    ],
)
def test_choices_that_define_nothing_are_refused(zeroed, said):
    """Zeroed dofs must hold every joint, as thesis 2.16 demands; the refusal says what to give."""
    listed = [{"link": n, "node": i, "dof": d} for n, i, d in zeroed]
    with pytest.raises(SceneError, match=said):
        simulate(load_scene(anthropomorphic(erls={"zeroed": listed})), duration=0.0)
