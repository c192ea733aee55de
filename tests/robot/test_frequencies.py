"""Natural frequencies: of cantilevers in closed form, of the thesis' robot as published."""

import numpy as np
import pytest
from scenes import anthropomorphic, link, robot, two_link

from flexsim_node import load_scene, mode_shapes, natural_frequencies
from flexsim_node.elements.section import section

POINTS = {"rotary_inertia": False}
LIMIT = [8.3474, 20.4347, 64.839, 79.488]  # Hz, Euler-Bernoulli
TWO_ELEMENTS = [8.34744, 20.43875, 64.93151]


def with_elements(scene, count):
    return {f"links.{k}.beam.elements": count for k in range(len(scene["links"]))}


def test_two_link_robot_joints_locked():
    """2 elements a link: within 0.05 % of the figures of an independent 2-element model."""
    found = natural_frequencies(load_scene(two_link(effects=POINTS)), [0.0, 0.0])
    assert np.allclose(found[:3], TWO_ELEMENTS, rtol=5e-4)


def test_two_link_robot_joints_free():
    """Free joints: one zero each, then the bending of a hinged chain."""
    scene = two_link(effects=POINTS)
    found = natural_frequencies(load_scene(scene, with_elements(scene, 16)), [0.0, 0.0], locked=False)
    assert np.array_equal(found[:2], [0.0, 0.0])
    assert np.allclose(found[2:5], [8.34739, 64.83942, 159.768], rtol=2e-5)


def test_convergence_with_elements():
    """Frequencies fall to the limit with the fourth power of the element's length, as Hermite
    cubics do.
    """
    scene = two_link(effects=POINTS)
    found = np.array(
        [natural_frequencies(load_scene(scene, with_elements(scene, n)), [0, 0])[:4] for n in (2, 4, 8, 16)]
    )
    assert np.allclose(found[-1], LIMIT, rtol=2e-5)
    fall = found[:-1] - found[1:]
    assert np.all(fall > 0)
    order = np.log2(fall[:-1, 1:] / fall[1:, 1:])  # the first is at the limit to 1e-6 already
    assert np.all(order > 3.6)
    assert np.all(order[-1] < 4.3)


def test_many_elements_keep_the_lowest_mode():
    """The lowest frequency does not drown in the rounding of a stiff, finely divided chain."""
    scene = two_link(effects=POINTS)
    fine = load_scene(scene, with_elements(scene, 40))
    assert natural_frequencies(fine, [0, 0])[0] == pytest.approx(LIMIT[0], rel=2e-5)
    free = natural_frequencies(fine, [0, 0], locked=False)
    assert np.array_equal(free[:2], [0, 0])
    assert free[2] == pytest.approx(LIMIT[0], rel=2e-5)


def test_cantilever_in_closed_form():
    """Bending in both planes, torsion and extension of a clamped beam."""
    length, width, depth = 0.8, 0.02, 0.03
    scene = load_scene(
        robot(link("beam", {"a": length}, width, depth, beam={"elements": 16}), effects=POINTS)
    )
    beam = scene.links[0].beam
    s = section(beam)
    shear_modulus = beam.youngs_modulus / (2 * (1 + beam.poissons_ratio))
    line = beam.density * s.area
    bending = np.array([1.8751041, 4.6940911, 7.8547574]) ** 2 / length**2
    quarter = np.pi / (2 * length)
    right = [
        *(bending * np.sqrt(beam.youngs_modulus * depth * width**3 / 12 / line)),
        *(bending * np.sqrt(beam.youngs_modulus * width * depth**3 / 12 / line)),
        quarter * np.sqrt(shear_modulus * s.j / (beam.density * (s.iy + s.iz))),
        quarter * np.sqrt(beam.youngs_modulus / beam.density),
    ]
    found = natural_frequencies(scene, [0.3])
    for frequency in np.array(right) / (2 * np.pi):
        assert np.min(np.abs(found - frequency)) < 1e-3 * frequency


def test_torsion_constant_of_a_rectangle():
    """Tables of Saint-Venant's constant: 0.1406 for a square, 0.2287 at 2 to 1, 0.333 for a strip."""
    for ratio, factor in ((1, 0.1406), (2, 0.2287), (10, 0.3123)):
        beam = load_scene(robot(link("beam", {"a": 1.0}, 0.01, ratio * 0.01))).links[0].beam
        assert section(beam).j == pytest.approx(factor * ratio * 0.01**4, rel=1e-3)


@pytest.mark.parametrize("zeroed", ["chord", "C"])
def test_frequencies_do_not_depend_on_the_rigid_link_system(zeroed):
    """Locked joints are locked motors, and the robot's frequencies are its own, whatever is
    zeroed.
    """
    listed = [{"link": f"link_{k}", "node": 2, "dof": "rz"} for k in (1, 2, 3)]
    erls = {"zeroed": "chord" if zeroed == "chord" else listed}
    root = load_scene(anthropomorphic())
    other = load_scene(anthropomorphic(erls=erls))
    for locked in (True, False):
        right = natural_frequencies(root, [0.2, 0.4, -0.3], locked)
        found = natural_frequencies(other, [0.2, 0.4, -0.3], locked)
        assert np.allclose(found[:12], right[:12], rtol=1e-6)


def test_mode_shapes_of_a_cantilever():
    """Mass-normalised, a cantilever's end moves 2 / sqrt(m) in bending, sqrt(2 / m) in extension."""
    scene = load_scene(
        robot(
            link("beam", {"a": 0.8}, 0.02, 0.03, beam={"elements": 16, "poissons_ratio": 0.3}), effects=POINTS
        )
    )
    modes = mode_shapes(scene, [0.3])
    mass = 7800 * 0.02 * 0.03 * 0.8
    across = [-np.sin(0.3), np.cos(0.3), 0.0]
    assert modes.name(0) == "beam bending_z 100 %"
    assert np.allclose(np.abs(modes.shape[0, -1]), np.abs(across) * 2 / np.sqrt(mass), rtol=1e-4)
    assert modes.name(1) == "beam bending_y 100 %"
    assert np.allclose(np.abs(modes.shape[1, -1]), [0, 0, 2 / np.sqrt(mass)], rtol=1e-4, atol=1e-9)
    # the end's slope is 1.37651 / L of its deflection
    slope = modes.slope[1, -1, 2] / modes.shape[1, -1, 2]
    assert slope == pytest.approx(1.376505 / 0.8, rel=1e-4)
    names = [modes.name(k) for k in range(len(modes.frequency))]
    torsion, axial = names.index("beam torsion 100 %"), names.index("beam axial 100 %")
    assert np.max(np.abs(modes.shape[torsion])) < 1e-6
    along = modes.shape[axial, -1] @ [np.cos(0.3), np.sin(0.3), 0.0]
    assert abs(along) == pytest.approx(np.sqrt(2 / mass), rel=1e-3)


def test_loaded_frequencies_hold_the_loads():
    """A rod that hangs swings with sqrt(3 g / (2 L)); a mass that hangs on a beam stiffens it."""
    rod = load_scene(robot(link("rod", {"a": 0.5}, 0.01, 0.03), gravity=[0.0, -9.81, 0.0], effects=POINTS))
    swings = natural_frequencies(rod, [-np.pi / 2], locked=False, loaded=True)[0]
    assert swings == pytest.approx(np.sqrt(1.5 * 9.81 / 0.5) / 2 / np.pi, rel=1e-4)
    assert natural_frequencies(rod, [np.pi / 2], locked=False, loaded=True)[0] == 0.0  # it falls over
    # a heavy end on a slender beam: K + N L stiffness of a taut cantilever, k = N b / (b L - tanh b L)
    scene = robot(
        link("beam", {"a": 0.5}, 0.002, 0.03, beam={"density": 10.1, "elements": 8}, payload={"mass": 50.0}),
        gravity=[0.0, -9.81, 0.0],
    )
    pull, bending = 50 * 9.81, 2e11 * 0.03 * 0.002**3 / 12
    b = np.sqrt(pull / bending)
    stiffness = pull * b / (b * 0.5 - np.tanh(b * 0.5))
    found = natural_frequencies(load_scene(scene), [-np.pi / 2], loaded=True)[0]
    assert found == pytest.approx(np.sqrt(stiffness / 50) / 2 / np.pi, rel=1e-3)
    unloaded = natural_frequencies(load_scene(scene), [-np.pi / 2])[0]
    assert unloaded == pytest.approx(np.sqrt(3 * bending / 0.5**3 / 50) / 2 / np.pi, rel=1e-3)
    assert found > 1.5 * unloaded
