"""A robot at rest: how far it sags, what its motors hold, and where it buckles."""

import numpy as np
import pytest
from scenes import anthropomorphic, link, robot, two_link

from flexsim_node import load_scene, simulate, static_equilibrium

ROOT = {"zeroed": "root"}  # displacements are those from the clamped direction


@pytest.mark.parametrize(("shear", "right"), [(True, 8.0990e-4), (False, 7.7295e-4)])
def test_cantilever_with_a_tip_load(shear, right):
    """L 2 m, h 0.5 m, w 0.1 m, E 2.07e11 Pa, 62500 N at the tip: Exudyn's own test figures, to 0.1
    %.
    """
    beam = {"density": 10.1, "youngs_modulus": 2.07e11, "poissons_ratio": 0.3}
    scene = robot(
        link("beam", {"a": 2.0}, 0.5, 0.1, beam=beam, payload={"mass": 6250.0}),
        gravity=[0.0, -10.0, 0.0],
        effects={"shear": shear},
    )
    tip = static_equilibrium(load_scene(scene), [0.0]).link_end[-1]
    assert -tip[1] == pytest.approx(right, rel=1e-3)


def test_sag_under_own_weight():
    """A horizontal cantilever sags by rho A g L^4 / (8 E I) and needs half its weight times its
    length.
    """
    scene = robot(link("beam", {"a": 0.5}, 0.01, 0.03), gravity=[0.0, -9.81, 0.0], erls=ROOT)
    rest = static_equilibrium(load_scene(scene), [0.0])
    line, stiffness = 7800 * 0.01 * 0.03 * 9.81, 2e11 * 0.03 * 0.01**3 / 12
    assert rest.node_displacement[-1, 1] == pytest.approx(-line * 0.5**4 / 8 / stiffness, rel=1e-4)
    assert rest.node_displacement[-1, 5] == pytest.approx(-line * 0.5**3 / 6 / stiffness, rel=1e-4)
    assert rest.torque[0] == pytest.approx(line * 0.5**2 / 2, rel=1e-5)


def test_robot_that_hangs():
    """Hanging straight down it is stretched by its weight, rho g L^2 / (2 E), and needs no torque."""
    scene = robot(link("beam", {"a": 0.5}, 0.01, 0.03), gravity=[0.0, -9.81, 0.0], erls=ROOT)
    rest = static_equilibrium(load_scene(scene), [-np.pi / 2])
    assert rest.node_displacement[-1, 0] == pytest.approx(7800 * 9.81 * 0.25 / 4e11, rel=1e-6)
    assert np.allclose(rest.link_end[-1], [0.0, -0.5, 0.0], atol=1e-7)
    assert abs(rest.torque[0]) < 1e-9


def test_held_robot_stays_where_it_is():
    """Started in static equilibrium under its holding torques, the flexible robot does not move."""
    initial = {"position": [0.3, 0.5, -0.8], "shape": "static"}
    scene = load_scene(anthropomorphic(initial=initial, erls=ROOT))
    rest = static_equilibrium(scene, [0.3, 0.5, -0.8])
    run = simulate(scene, rest.torque[None, :], duration=0.1)
    assert np.max(np.abs(run.link_end - rest.link_end)) < 1e-9


def test_column_that_buckles():
    """An upright link stands below Euler's load, pi^2 E I / (4 L^2), and is refused above it."""
    stiffness = 2e11 * 0.03 * 0.002**3 / 12
    euler = np.pi**2 * stiffness / 4 / 0.5**2 / 9.81
    scene = robot(
        link("beam", {"a": 0.5}, 0.002, 0.03, beam={"density": 10.1, "elements": 4}),
        gravity=[0.001, -9.81, 0.0],
        erls=ROOT,
    )
    stands = load_scene(scene, {"links.beam.payload.mass": 0.9 * euler})
    assert abs(static_equilibrium(stands, [np.pi / 2]).node_displacement[-1, 1]) < 0.005
    with pytest.raises(ArithmeticError, match="buckle"):
        static_equilibrium(load_scene(scene, {"links.beam.payload.mass": 1.2 * euler}), [np.pi / 2])


@pytest.mark.parametrize("zeroed", ["chord", "C"])
def test_rest_does_not_depend_on_the_rigid_link_system(zeroed):
    """Motors at the same angles hold the same shape, to the squared elastic rotation."""
    pose = [0.3, 0.5, -0.8]
    listed = [{"link": f"link_{k}", "node": 2, "dof": "rz"} for k in (1, 2, 3)]
    erls = {"zeroed": "chord" if zeroed == "chord" else listed}
    root = static_equilibrium(load_scene(anthropomorphic()), pose)
    other = static_equilibrium(load_scene(anthropomorphic(erls=erls)), pose)
    rotation = np.max(np.abs(root.node_displacement[:, 3:]))
    assert np.max(np.abs(root.link_end - other.link_end)) < rotation**2
    assert np.allclose(root.torque, other.torque, rtol=0, atol=12 * rotation**2)


def test_position_of_the_wrong_size_is_refused():
    scene = load_scene(two_link())
    for wrong in ([0.0], [0.0, np.nan], [[0.0, 0.0, 0.0]]):
        with pytest.raises(ValueError, match="give 2 finite joint coordinates"):
            static_equilibrium(scene, wrong)
