"""Rayleigh's alpha is a dissipation function of the elastic velocity, whatever is zeroed."""

import numpy as np
import pytest
from scenes import anthropomorphic, link, robot, two_link
from test_independent_equations import SCENES, SETS

from flexsim_node import SceneError, load_scene
from flexsim_node.equations.dynamics.tangent import damping_matrix, mass_matrix
from flexsim_node.equations.kinematics.nodal_motion import place
from flexsim_node.equations.solve.factorization import factorize, set_scale
from flexsim_node.equations.solve.substitution import solve
from flexsim_node.model.chain import COORDINATES, FIXED, KIND, PHI, Q, workspace
from flexsim_node.model.model import build_model

pytestmark = pytest.mark.equations

REDUCED = robot(
    link("a", {"a": 0.5}, beam={"elements": 6}, reduction={"modes": 4}),
    link("b", {"a": 0.4, "alpha": 0.7}, beam={"elements": 6}, reduction={"modes": 6}),
    link("c", {"a": 0.3}, beam={"elements": 1}),
)
FLAT = robot(
    link("a", {"a": 0.5}, beam={"elements": 6}), link("b", {"a": 0.4}, beam={"elements": 6}),
    gravity=[0.0, -9.81, 0.0], reduction={"modes": 4},
)  # fmt: skip
CASES = {
    **{name: SCENES[name] for name in ("planar payload", "oblique", "sliding", "planar fork", "springs")},
    **{f"set {name}": anthropomorphic(erls=erls) for name, (erls, _) in SETS.items()},
    "reduced": REDUCED,
    "reduced, chords": {**REDUCED, "erls": {"zeroed": "chord"}},
    "reduced, plane": FLAT,
    # no joint has an elastic rotation: the factors have alpha
    **{
        f"{name}, roots": {**SCENES[name], "erls": {"zeroed": "root"}}
        for name in ("planar payload", "oblique")
    },
    "reduced, roots": {**REDUCED, "erls": {"zeroed": "root"}},
    "reduced, plane, roots": {**FLAT, "erls": {"zeroed": "root"}},
    "springs, chords": {**SCENES["springs"], "erls": {"zeroed": "chord"}},
    "co-moving": {**SCENES["oblique"], "formulation": "co_moving"},
    "co-moving, plane": {**SCENES["planar payload"], "formulation": "co_moving"},
}


def rates_of_vibration(model):
    """P: the elastic motion's rates, of all rates."""
    own = np.eye(model.unknowns)
    own[: int(model.chain.setting[COORDINATES])] = 0.0
    for row in model.chain.link:
        if row[KIND] != FIXED and row[PHI] >= 0:
            own[row[Q], row[PHI]] = -1.0
    return own


def models(scene, alpha):
    """With alpha as its only damping of links, and with none."""
    scene = {key: value for key, value in scene.items() if key != "damping"}
    return (build_model(load_scene(scene, {"damping.alpha": a})) for a in (alpha, 0.0))


def matrices(scene, alpha, x):
    """The damping matrix of alpha alone, and P^T M P."""
    with_it, without = models(scene, alpha)
    own = rates_of_vibration(with_it)
    damping = damping_matrix(with_it, x(with_it)) - damping_matrix(without, x(without))
    return damping, own.T @ mass_matrix(without, x(without)) @ own


def straight(model):
    x = np.zeros(model.unknowns)
    x[: model.joints] = np.linspace(-0.8, 0.9, model.joints)
    return x


def bent(model):
    x = straight(model)
    x[int(model.chain.setting[COORDINATES]) :] = (
        3e-3 * np.sin(np.arange(x.size))[: x.size - int(model.chain.setting[COORDINATES])]
    )
    return x


@pytest.mark.parametrize("name", CASES)
def test_matrix_is_that_of_the_dissipation_function(name):
    """alpha P^T M P for straight links, to the elastic rotation for bent ones; never negative."""
    damping, right = matrices(CASES[name], 3.0, straight)
    assert np.allclose(damping, 3.0 * right, rtol=0, atol=1e-9 * np.max(np.abs(right)))
    damping, right = matrices(CASES[name], 3.0, bent)
    assert np.max(np.abs(damping - 3.0 * right)) < 0.06 * np.max(np.abs(right))
    size = np.max(np.abs(damping))
    assert np.max(np.abs(damping - damping.T)) < 1e-6 * size
    assert np.min(np.linalg.eigvalsh(0.5 * (damping + damping.T))) > -1e-6 * size


@pytest.mark.parametrize("name", CASES)
def test_a_step_is_solved_with_all_of_it(name):
    """The factors, or conjugate gradients after them, have the mass with alpha's whole matrix beside it."""
    model, without = models(CASES[name], alpha := 30.0)
    n, x, share = model.unknowns, straight(model), 0.02
    mass, own = mass_matrix(without, x), rates_of_vibration(model)
    plain = mass + share * damping_matrix(without, x)
    whole = plain + share * alpha * own.T @ mass @ own
    work = workspace(model.chain)
    place(model.chain, work, x)
    set_scale(model.chain, work, 0.0, share, 0.0)
    assert factorize(model.chain, work) == 0
    load, found = np.cos(np.arange(n)), np.zeros(n)
    solve(model.chain, work, load, found)
    right = np.linalg.solve(whole, load)
    # in the norm of the energy, in which the gradients end
    off = found - right
    assert off @ whole @ off < 1e-8 * (right @ whole @ right)
    off = np.linalg.solve(plain, load) - right
    assert off @ whole @ off > right @ whole @ right


def test_rigid_motion_is_not_damped():
    """Joints feel nothing of it, whatever is zeroed; the thesis' form lets elastic rates push them."""
    for erls in ({"zeroed": "root"}, {"zeroed": "chord"}):
        damping, _ = matrices(two_link(erls=erls), 3.0, straight)
        assert np.max(np.abs(damping[:2])) == 0.0 and np.max(np.abs(damping[:, :2])) == 0.0
    both = [
        build_model(load_scene(two_link(erls={"zeroed": "root"}, damping=damping)))
        for damping in ({"alpha": 3.0, "alpha_form": "thesis"}, {})
    ]
    thesis, none = (damping_matrix(model, straight(model)) for model in both)
    assert np.max(np.abs(thesis - none)[:2]) > 0.1


def test_no_form_but_these():
    """A misspelt form is refused."""
    with pytest.raises(SceneError, match="give 'elastic' or 'thesis'"):
        load_scene(two_link(damping={"alpha": 1.0, "alpha_form": "rayleigh"}))
