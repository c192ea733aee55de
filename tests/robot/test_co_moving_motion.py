"""`formulation: co_moving`: soft robots against geometrically exact beams, stiff ones against the ERLS."""

import numpy as np
import pytest
from scenes import DATA, anthropomorphic, robot, two_link
from static_frame import frame_ends
from test_reference_motion import distance, driven

from flexsim_node import load_scene, simulate, static_equilibrium

CO_MOVING = {"formulation": "co_moving"}


def modulus(scene, value, elements=2):
    """The scene with another Young's modulus, Pa, and number of elements."""
    for part in scene["links"]:
        part["beam"].update(youngs_modulus=value, elements=elements)
    return scene


def test_soft_falling_two_link_robot():
    """E = 2e9, 2 elements a link, 1 ms: within 2 mm for a second; with shear nearer still."""
    reference = np.loadtxt(DATA / "falling_two_link_soft.csv", delimiter=",")
    error = {}
    for shear in (False, True):
        scene = load_scene(modulus(two_link(effects={"shear": shear}), 2e9), CO_MOVING)
        error[shear] = distance(simulate(scene, duration=1.0, sample_period=0.01), reference)
    assert error[False] < 1e-3
    assert error[True] < 5e-4


def test_soft_driven_anthropomorphic_robot():
    """E = 5e9, link 1 bends and twists by a third of a radian: within 2 mm, where the ERLS is not."""
    reference = np.loadtxt(DATA / "driven_anthropomorphic_soft.csv", delimiter=",")
    error = {n: distance(driven(modulus(anthropomorphic(), 5e9, n), **CO_MOVING), reference) for n in (2, 4)}
    assert error[2] < 1.5e-3
    assert error[4] < 0.4 * error[2]
    erls = driven(modulus(anthropomorphic(), 5e9))
    assert erls.status != "ok" or distance(erls, reference) > 5e-3


def test_stiff_robots_alike():
    """On steel the references of both are met as the ERLS meets them."""
    reference = np.loadtxt(DATA / "driven_anthropomorphic_steel.csv", delimiter=",")
    assert distance(driven(anthropomorphic(), **CO_MOVING), reference) < 1e-4
    reference = np.loadtxt(DATA / "falling_two_link_steel.csv", delimiter=",")
    scene = load_scene(two_link(effects={"rotary_inertia": False}), CO_MOVING)
    assert distance(simulate(scene, duration=1.0, sample_period=0.01), reference) < 1e-4


BEAM = {"width": 0.02, "depth": 0.01, "density": 1500.0, "youngs_modulus": 3e9, "poissons_ratio": 0.3}


def frame(elements, gravity):
    """Two beams of 0.6 and 0.5 m at a right angle in a level plane: the first bends and is twisted."""
    beam = {"beam": {**BEAM, "elements": elements}}
    arm = {"joint": {"type": "fixed"}, "payload": {"mass": 0.2}, **beam}
    return robot(
        {"name": "root", "dh": {"a": 0.6}, **beam},
        {"name": "arm", "dh": {"a": 0.5, "theta": np.pi / 2}, **arm},
        gravity=[0.0, 0.0, -gravity],
    )


def exact_frame(gravity):
    from flexsim_node.elements.section import section
    from flexsim_node.scene.schema import Beam

    s = section(Beam(**BEAM))
    young = BEAM["youngs_modulus"]
    shear = young / (2 * (1 + BEAM["poissons_ratio"]))
    common = {
        "line_mass": BEAM["density"] * s.area,
        "stiffness": (young * s.area, shear * s.j, young * s.iy, young * s.iz),
    }
    corner = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    legs = [{"turn": np.eye(3), "length": 0.6, **common}, {"turn": corner, "length": 0.5, **common}]
    return frame_ends(legs, [0.0, 0.0, -gravity], 0.2)


def test_static_frame_bent_far():
    """A frame bent and twisted by half a radian: second order in the elements, to the exact beams' shape."""
    right = exact_frame(25.0)
    undeformed = np.array([0.6, 0.5, 0.0])
    assert np.linalg.norm(right[-1] - undeformed) > 0.3
    error = []
    for elements in (2, 4, 8):
        scene = load_scene(frame(elements, 25.0), CO_MOVING)
        error.append(np.max(np.abs(static_equilibrium(scene, [0.0]).link_end - right)))
    assert error[-1] < 3e-4
    assert np.log2(error[0] / error[-1]) / 2 > 1.7


def test_differs_from_the_erls_by_the_squared_rotation():
    """Half the load, a quarter of the difference, or less."""
    gap = []
    for gravity in (0.2, 0.1):
        ends = [
            static_equilibrium(load_scene(frame(2, gravity), {"formulation": f}), [0.0]).link_end
            for f in ("erls", "co_moving")
        ]
        gap.append(np.max(np.abs(ends[0] - ends[1])))
    assert 3.5 < gap[0] / gap[1] < 9.0


def test_prescribed_spin_stiffens():
    """Wu & Haug's slewing beam spins above its first bending frequency: the frames' geometry stiffens it."""
    young = 6.895e10
    area, second = 5.03e6 / young, 566.6 / young
    beam = {"area": area, "iy": second, "iz": second, "j": 2 * second}
    beam |= {"density": 0.2019 / area, "youngs_modulus": young, "elements": 8}
    scene = robot(
        {"name": "beam", "dh": {"a": 8.0}, "joint": {"name": "root"}, "beam": beam},
        gravity=[0.0, 0.0, 0.0],
        effects={"rotary_inertia": False},
        solver={"step": 5e-3},
        **CO_MOVING,
    )

    def root(t):
        s, w = t / 15.0, 2 * np.pi
        if s >= 1.0:
            return 4.0 * (t - 7.5), 4.0, 0.0
        angle = 60.0 * (s**2 / 2 + (np.cos(w * s) - 1) / w**2)
        return angle, 4.0 * (s - np.sin(w * s) / w), 4.0 / 15.0 * (1 - np.cos(w * s))

    run = simulate(load_scene(scene), duration=20.0, sample_period=0.05, prescribed={"root": root})
    assert run.status == "ok"
    reference = np.loadtxt(DATA / "slewing_beam_wu_haug.csv", delimiter=",")
    right = np.interp(run.time, reference[:, 0], reference[:, 2])
    v = run.node_displacement[:, -1, 1]
    # unlike a linear measure of bending, this one is the beams' own: 0.1 % of the largest, 0.534 m
    assert np.max(np.abs(v - right)) < 2e-3


@pytest.mark.parametrize("make", [two_link, anthropomorphic])
def test_energy_is_kept(make):
    """Radau at 1e-9: what a soft robot at speed holds stays to 1e-7 of what it exchanges."""
    scene = modulus(make(initial={"position": [0.1, 0.2, 0.3][: len(make()["links"])]}), 1e8, 1)
    tight = {"method": "radau", "relative_tolerance": 1e-9, "absolute_tolerance": 1e-11}
    run = simulate(load_scene({**scene, **CO_MOVING, "solver": tight}), None, 0.1, 0.01)
    assert run.status == "ok"
    moved = 9.81 * np.max(np.abs(run.link_end[:, -1] - run.link_end[0, -1])) * 2.0
    assert np.ptp(run.energy) < 1e-7 * moved


@pytest.mark.parametrize("method", ["rosenbrock_w", "generalized_alpha"])
def test_second_order_in_the_step(method):
    """The default integrator and the other real-time one keep their order."""
    scene = modulus(anthropomorphic(damping={"alpha": 2.0, "beta": 1e-3}), 1e8, 1)
    scene["initial"] = {"position": [0.1, 0.2, 0.3], "velocity": [1.0, -2.0, 3.0]}

    def ends(**solver):
        run = simulate(load_scene({**scene, **CO_MOVING, "solver": solver}), None, 0.08, 0.04)
        assert run.status == "ok"
        return run.link_end

    exact = ends(method="dop853", relative_tolerance=1e-11, absolute_tolerance=1e-12)
    error = [np.max(np.abs(ends(method=method, step=0.08 / n) - exact)) for n in (160, 320, 640)]
    assert np.log2(error[0] / error[-1]) / 2 > 1.8
    assert error[-1] < 1e-4
