"""`formulation: co_moving`: the equations are Lagrange's, for rotations of any size."""

import numpy as np
import pytest
from independent_co_moving import IndependentCoMoving
from scenes import anthropomorphic, link, robot, two_link
from scipy.spatial.transform import Rotation
from test_independent_equations import PAYLOAD, SCENES

from flexsim_node import SceneError, load_scene
from flexsim_node.analysis.modes import natural_frequencies
from flexsim_node.equations.dynamics.acceleration import acceleration
from flexsim_node.equations.dynamics.energy import energy
from flexsim_node.model.chain import workspace
from flexsim_node.model.model import build_model
from flexsim_node.motion.simulation import Simulation

pytestmark = pytest.mark.equations
CO_MOVING = {"formulation": "co_moving"}
CASES = [
    "planar",
    "planar payload",
    "planar shear",
    "anthropomorphic",
    "oblique, points",
    "no axial",
    "no torsion",
    "no bending y",
    "pieces, shear",
    "sliding",
    "forked",
    "planar fork",
    "springs",
    "springs, loops",
    "springs, planar loops",
    "loops, revolute",
    "loops, spherical",
    "loops, fixed",
    "loops, slot",
    "losses",
    "losses, loops",
    "losses, planar loops",
]


def state(model, rng, size):
    """Joints anywhere at several rad/s, elastic unknowns of the order of `size`."""
    m, n = model.joints, model.unknowns
    x, v = size * rng.standard_normal(n), 30 * size * rng.standard_normal(n)
    x[:m], v[:m] = rng.uniform(-2, 2, m), rng.uniform(-4, 4, m)
    return x, v


@pytest.mark.parametrize("name", CASES)
def test_accelerations_and_energy_are_lagranges(name):
    """Elements turned by 0.1 rad each and more: the motion follows from the displacement field alone."""
    model = build_model(load_scene(SCENES[name], CO_MOVING))
    work, joules = workspace(model.chain), np.zeros(3)
    road = IndependentCoMoving(model.scene, model.planar)
    assert road.unknowns == model.unknowns
    rng = np.random.default_rng(3)
    x, v = state(model, rng, 0.1)
    torque, found = rng.uniform(-5, 5, model.joints), np.zeros(model.unknowns)
    assert acceleration(model.chain, work, x, v, torque, found) == 0
    right = road.acceleration(x, v, torque)
    assert np.allclose(found, right, rtol=0, atol=2e-9 * np.max(np.abs(right)))
    energy(model.chain, work, x, v, joules)
    kinetic, elastic, height = joules
    assert kinetic == pytest.approx(road.kinetic(x, v).real, rel=1e-12)
    assert elastic + height == pytest.approx(road.potential(x).real, rel=1e-12)


def test_the_other_road_is_sensitive():
    """A thousandth of a payload shows."""
    scene = robot(link("a", {"a": 0.3}, payload=PAYLOAD), link("b", {"a": 0.3, "alpha": 0.4}), **CO_MOVING)
    roads = [IndependentCoMoving(load_scene(scene, {"links.a.payload.mass": mass})) for mass in (1.3, 1.3013)]
    z = np.full(roads[0].unknowns, 0.02)
    a, b = (road.acceleration(z, z, np.zeros(2)) for road in roads)
    assert np.max(np.abs(a - b)) > 1e-6 * np.max(np.abs(a))


@pytest.mark.parametrize("name", ["pieces", "sliding", "planar payload"])
def test_rigid_links_move_alike(name):
    """Without elasticity both formulations are the same rigid robot (which Pinocchio has checked)."""
    rigid = {f"links.{k}.flexible": False for k in range(len(SCENES[name]["links"]))}
    found = []
    for formulation in ("erls", "co_moving"):
        here = Simulation(load_scene(SCENES[name], {**rigid, "formulation": formulation}))
        model, rng = here.model, np.random.default_rng(5)
        x, v = state(model, rng, 0.0)
        here.x[:], here.v[:] = x, v
        a, torque = np.zeros(model.unknowns), rng.uniform(-5, 5, model.joints)
        assert acceleration(model.chain, here.work, x, v, torque, a) == 0
        found.append([*a, *here.energy(), *here.look().position.ravel(), *here.look().pose.ravel()])
    np.testing.assert_allclose(found[1], found[0], rtol=0, atol=1e-9 * np.max(np.abs(found[0])))


@pytest.mark.parametrize("scene", [anthropomorphic(), two_link(), SCENES["sliding"]])
def test_natural_frequencies_alike(scene):
    """Small vibrations about the undeformed robot are the same."""
    position = 0.3 + 0.4 * np.arange(len(load_scene(scene).joints))
    erls, moving = (
        natural_frequencies(load_scene(scene, {"formulation": f}), position) for f in ("erls", "co_moving")
    )
    np.testing.assert_allclose(moving, erls, rtol=1e-8)


def test_what_is_seen():
    """Displacements are measured from a link that starts where its deformed one does, as rotation vectors."""
    scene = load_scene(anthropomorphic(), CO_MOVING)
    here = Simulation(scene)
    here.x[:], _ = state(here.model, np.random.default_rng(7), 0.1)
    view = here.look()
    ends = view.ends
    np.testing.assert_allclose(view.displacement[[0, 3, 6]], 0.0, atol=1e-15)
    np.testing.assert_allclose(view.position[[3, 6]], view.link_end[:2], atol=1e-15)
    np.testing.assert_allclose(view.rigid_position[[3, 6]], view.link_end[:2], atol=1e-15)
    turn = view.pose[2, 3:].reshape(3, 3)
    moved = view.displacement[ends[2], :3]
    np.testing.assert_allclose(
        view.position[ends[2]] - view.rigid_position[ends[2]],
        turn @ here.model.axes[2].T @ moved,
        atol=1e-15,
    )
    # two elements: the rotation shown is exp(b1) exp(c1) exp(b2) exp(c2) of their unknowns
    right = Rotation.identity()
    for node in (7, 8):
        _, bz, by, tau, cy, cz = here.x[here.model.chain.unknown[node]]
        right = right * Rotation.from_rotvec([tau / 2, by, bz]) * Rotation.from_rotvec([tau / 2, cy, cz])
    np.testing.assert_allclose(view.displacement[8, 3:], here.model.axes[2] @ right.as_rotvec(), atol=1e-14)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"erls.zeroed": "chord"}, "erls.zeroed: is chord"),
        ({"effects.centrifugal": False}, "effects.centrifugal: is false"),
        ({"formulation": "floating"}, "formulation: is 'floating'"),
    ],
)
def test_refused(change, said):
    """What the formulation can't be is refused with what would be right."""
    with pytest.raises(SceneError, match=said):
        load_scene(two_link(), {**CO_MOVING, **change})
