"""The equations of motion are those of the displacement field, with nothing left out.

Accelerations and energies of random states are compared with Lagrange's equations of the same
field, built
another way (independent_chain.py).
"""

import numpy as np
import pytest
from independent_chain import IndependentChain
from scenes import anthropomorphic, link, robot, two_link

from flexsim_node import load_scene
from flexsim_node.equations.dynamics.acceleration import acceleration
from flexsim_node.equations.dynamics.energy import energy
from flexsim_node.model.chain import workspace
from flexsim_node.model.model import build_model

pytestmark = pytest.mark.equations
INERTIA = [[0.02, 0.001, 0.002], [0.001, 0.03, -0.003], [0.002, -0.003, 0.025]]
PAYLOAD = {"mass": 1.3, "center_of_mass": [0.02, 0.03, -0.04], "inertia": INERTIA}
FLAT_BODY = {
    "mass": 0.7,
    "center_of_mass": [0.05, 0.02, 0.0],
    "inertia": np.diag([0.01, 0.02, 0.025]).tolist(),
}
SOFT = {"elements": 2, "youngs_modulus": 1e9}


def oblique(**keys):
    """Skew joints, unequal sections, offsets in every DH parameter, a payload, gravity askew."""
    return robot(
        link("a", {"a": 0.3, "alpha": 0.7, "d": 0.2, "theta": 0.4}, 0.05, 0.02, beam={"elements": 1}),
        link("b", {"a": 0.4, "alpha": -1.1, "d": -0.1}, 0.02, 0.03, beam=SOFT, payload=PAYLOAD),
        link("c", {"a": -0.2, "alpha": 0.3, "d": 0.3, "theta": -0.9}, 0.03, 0.02),
        **{"gravity": [3.0, -5.0, -7.0], **keys},
    )


def pieces(**keys):
    """A rigid link between flexible ones, a wrist of zero length with a body, a fixed joint, a
    rigid end.
    """
    body = {"mass": 0.9, "center_of_mass": [0.01, -0.03, 0.05], "inertia": INERTIA}
    return robot(
        link("a", {"a": 0.4, "alpha": 0.5}, beam={"elements": 1}),
        link("b", {"a": 0.3, "d": 0.1, "alpha": 1.2}, flexible=False, payload=PAYLOAD),
        link("w", {"alpha": -1.3, "theta": 0.2}, None, rigid=body),
        link("c", {"a": 0.25, "d": 0.1, "theta": 0.7}, joint={"type": "fixed"}, beam=SOFT),
        link("v", {"alpha": 0.8}, None),
        link("e", {"a": 0.2, "d": 0.15}, flexible=False),
        **{"gravity": [0.0, 2.0, -9.0], **keys},
    )


def sliding(**keys):
    """A prismatic joint between turning ones, on a bent beam."""
    return robot(
        link("a", {"a": 0.4, "alpha": 0.9}, beam=SOFT),
        link("b", {"a": 0.3, "alpha": 0.4, "d": 0.2}, joint={"type": "prismatic"}, payload=PAYLOAD),
        link("c", {"a": 0.2, "alpha": -0.4, "d": 0.1}, beam={"elements": 1}),
        **keys,
    )


def forked(**keys):
    """Two arms on a bent beam, one sliding, and a second chain from the base, set off by a bracket."""
    return robot(
        link("trunk", {"a": 0.4, "alpha": 0.6}, beam=SOFT),
        link("left", {"a": 0.3, "d": 0.1, "alpha": -0.5}, beam={"elements": 1}, payload=PAYLOAD),
        link("right", {"a": 0.2, "d": 0.2}, joint={"type": "prismatic"}, parent="trunk"),
        link("hand", {"a": 0.1, "alpha": 0.3}, beam={"elements": 1}),
        link("bracket", {"a": 0.5, "d": 0.1, "alpha": 0.4}, None, joint={"type": "fixed"}, parent="base"),
        link("other", {"a": 0.3, "theta": 0.5}, beam=SOFT),
        link("stub", {"a": 0.2}, parent="left", flexible=False),
        **{"gravity": [1.0, -5.0, -7.0], **keys},
    )


def planar_fork(**keys):
    """The same in a plane."""
    return robot(
        link("trunk", {"a": 0.4}, beam=SOFT),
        link("left", {"a": 0.3, "theta": 0.7}, payload=FLAT_BODY),
        link("right", {"a": 0.2, "theta": -0.4}, parent="trunk", beam=SOFT),
        link("bracket", {"a": 0.5, "theta": 0.3}, None, joint={"type": "fixed"}, parent="base"),
        link("other", {"a": 0.3}, beam=SOFT),
        **{"gravity": [1.0, -9.0, 0.0], **keys},
    )


def closed(kind, **keys):
    """Two chains of soft links in space, joined at points beside their ends, and to the base."""
    at = {"left": [0.1, 0.05, -0.02], "right": [0.02, -0.1, 0.03]}
    axis = {"left": [1.0, 2.0, -1.0], "right": [0.3, -1.0, 0.2]}
    given = {"revolute": axis, "universal": axis, "slot": {"right": axis["right"]}}.get(kind)
    joint = {"links": ["left", "right"], "joint": kind, "at": at, **({"axis": given} if given else {})}
    ground = {"links": ["right", "base"], "joint": "spherical", "at": {"base": [0.1, 0.2, 0.3]}}
    slot = {"links": ["base", "left"], "joint": "slot", "axis": {"left": [0.0, 1.0, 1.0]}}
    return robot(
        link("trunk", {"a": 0.4, "alpha": 0.6}, beam={"elements": 1}),
        link("left", {"a": 0.3, "d": 0.1, "alpha": -0.5}, beam=SOFT, payload=PAYLOAD),
        link("bracket", {"a": 0.5, "d": 0.1, "alpha": 0.4}, None, joint={"type": "fixed"}, parent="base"),
        link("slide", {"a": 0.2, "d": 0.2}, joint={"type": "prismatic"}),
        link("right", {"a": 0.3, "theta": 0.5, "alpha": 0.2}, beam={"elements": 1}),
        **{"loops": [joint, ground, slot], "gravity": [1.0, -5.0, -7.0], **keys},
    )


def planar_closed(**keys):
    """Loops in a plane: a weld, a pin beside a link's end, a pin that slides."""
    return robot(
        link("trunk", {"a": 0.4}, beam=SOFT),
        link("left", {"a": 0.3, "theta": 0.7}, payload=FLAT_BODY),
        link("bracket", {"a": 0.5, "theta": 0.3}, None, joint={"type": "fixed"}, parent="base"),
        link("other", {"a": 0.3}, beam=SOFT),
        link("stub", {"a": 0.2}),
        **{
            "loops": [
                {"links": ["left", "stub"], "at": {"left": [0.1, 0.2, 0.0]}},
                {"links": ["trunk", "base"], "joint": "slot", "axis": {"base": [1.0, 2.0, 0.0]}},
                {"links": ["left", "other"], "joint": "fixed"},
            ],
            "gravity": [1.0, -9.0, 0.0],
            **keys,
        },
    )


def losses(**keys):
    """Friction, rotors and Rayleigh damping."""
    joint = {
        "viscous_friction": 0.7,
        "coulomb_friction": 0.4,
        "coulomb_speed": 1e-2,
        "rotor_inertia": 2e-4,
        "gear_ratio": 30.0,
    }
    scene = oblique(damping={"alpha": 3.0, "beta": 1e-3}, **keys)
    scene["links"][0]["joint"] = joint
    scene["links"][2]["joint"] = joint
    return scene


def springs(**keys):
    """Joints that give way between motor and link, turning and sliding."""
    motor = {"rotor_inertia": 3e-4, "gear_ratio": 20.0, "stiffness": 900.0, "damping": 1.5}
    scene = sliding(**keys)
    scene["links"][0]["joint"] = {**motor, "viscous_friction": 0.3}
    scene["links"][1]["joint"] = {"type": "prismatic", "rotor_inertia": 0.7, "stiffness": 4e4}
    return scene


def springs_in_loops(scene, *names):
    """The scene with springs behind the motors of some of its links."""
    motor = {"rotor_inertia": 3e-4, "gear_ratio": 20.0, "stiffness": 900.0, "damping": 1.5}
    for part in scene["links"]:
        if part["name"] in names:
            part["joint"] = {**part.get("joint", {}), **motor}
    return scene


SCENES = {
    "planar": two_link(damping={"alpha": 2.0, "beta": 5e-4}),
    "planar payload": robot(
        link("a", {"a": 0.5}, payload=FLAT_BODY, beam=SOFT),
        link("b", {"a": 0.3, "theta": 0.3}, flexible=False),
        link("w", {}, None, rigid=FLAT_BODY),
        link("c", {"a": 0.4}, 0.01, 0.03, beam={"elements": 3}),
        gravity=[1.0, -9.0, 0.0],
    ),
    "planar shear": two_link(effects={"shear": True}),
    "planar, points": two_link(effects={"rotary_inertia": False}),
    "anthropomorphic": anthropomorphic(),
    "oblique": oblique(),
    "oblique, shear": oblique(effects={"shear": True}),
    "oblique, points": oblique(effects={"rotary_inertia": False, "shear": True}),
    "oblique, points, no torsion": oblique(effects={"rotary_inertia": False, "torsion": False}),
    "no axial": oblique(effects={"axial": False}),
    "no torsion": oblique(effects={"torsion": False}),
    "no bending y": pieces(effects={"bending_y": False}),
    "no bending z": pieces(effects={"bending_z": False}),
    "no gravity": pieces(effects={"gravity": False}),
    "planar, no spin": two_link(effects={"centrifugal": False}),
    "planar, no coriolis": two_link(effects={"coriolis": False}),
    "planar, neither": two_link(effects={"coriolis": False, "centrifugal": False}),
    "no spin": pieces(effects={"centrifugal": False}),
    "no coriolis": oblique(effects={"coriolis": False}),
    "neither": pieces(effects={"coriolis": False, "centrifugal": False}),
    "points, no spin": oblique(effects={"centrifugal": False, "rotary_inertia": False}),
    "points, neither": oblique(effects={"coriolis": False, "centrifugal": False, "rotary_inertia": False}),
    "sliding, no spin": sliding(effects={"centrifugal": False}),
    "pieces": pieces(),
    "pieces, shear": pieces(effects={"shear": True}),
    "sliding": sliding(),
    "forked": forked(),
    "planar fork": planar_fork(),
    "loops, revolute": closed("revolute"),
    "loops, universal": closed("universal"),
    "loops, spherical": closed("spherical"),
    "loops, fixed": closed("fixed"),
    "loops, slot": closed("slot"),
    "planar loops": planar_closed(),
    "springs": springs(),
    "springs, loops": springs_in_loops(closed("universal"), "trunk", "slide"),
    "springs, planar loops": springs_in_loops(planar_closed(), "trunk", "other"),
    "springs, off": springs(effects={"joint_elasticity": False}),
    "springs, no rotors": springs(effects={"rotor_inertia": False}),
    "losses": losses(),
    "losses, loops": closed("universal", damping={"alpha": 30.0, "beta": 1e-3}),
    "losses, planar loops": planar_closed(damping={"alpha": 30.0, "beta": 1e-3}),
    "losses, springs": springs(damping={"alpha": 30.0, "beta": 1e-3}),
    "losses, points": losses(effects={"rotary_inertia": False}),
}


def random_state(model, rng, size):
    """Joints anywhere, at several rad/s; elastic displacements and rates of the order of `size`."""
    x, v = np.zeros((2, model.unknowns))
    m = model.joints
    x[:m], v[:m] = rng.uniform(-2, 2, m), rng.uniform(-4, 4, m)
    x[m:] = size * rng.standard_normal(model.unknowns - m)
    v[m:] = 30 * size * rng.standard_normal(model.unknowns - m)
    return x, v


def compare(scene, zeroed=None, size=3e-3, seed=1):
    model = build_model(load_scene(scene, {"erls.zeroed": "root"} if zeroed is None else None))
    work = workspace(model.chain)
    road = IndependentChain(model.scene, model.planar, zeroed)
    assert road.unknowns == model.unknowns
    rng = np.random.default_rng(seed)
    zero = np.zeros(model.unknowns)
    m = model.joints
    for _ in range(2):
        x, v = random_state(model, rng, size)
        torque = rng.uniform(-5, 5, m)
        found = np.zeros(model.unknowns)
        assert acceleration(model.chain, work, x, v, torque, found) == 0
        right = road.acceleration(x, v, torque)
        assert np.allclose(found, right, rtol=0, atol=2e-9 * np.max(np.abs(right)))
        # joints' accelerations are small beside the elastic ones in a stiff chain: alone they
        # count too
        assert np.allclose(found[:m], right[:m], rtol=0, atol=1e-8 * np.max(np.abs(right[:m])))
        joules = np.zeros(3)
        energy(model.chain, work, x, v, joules)
        kinetic, elastic, height = joules
        assert kinetic == pytest.approx(road.kinetic(x, v).real, rel=1e-11)
        assert elastic + height == pytest.approx(road.potential(x).real, rel=1e-11)
    assert road.kinetic(x, zero).real == 0.0


@pytest.mark.parametrize("name", SCENES)
def test_accelerations_and_energy_are_lagranges(name):
    """Whatever the chain is made of, its motion follows from the displacement field alone."""
    compare(SCENES[name])


@pytest.mark.parametrize("name", ["planar", "oblique, shear", "pieces", "sliding"])
def test_undeformed_robot_at_speed(name):
    """Without elastic displacement, centrifugal and Coriolis forces alone load the links."""
    compare(SCENES[name], size=0.0, seed=2)


X, Y, Z, RX, RY, RZ = np.eye(6)
JOINT = np.zeros(6)  # the joint's own rotation, node 0


def zero(*dofs):
    return {"zeroed": [{"link": name, "node": node, "dof": dof} for name, node, dof in dofs]}


SETS = {
    "A": (zero(("link_1", 2, "rz"), ("link_2", 0, "rz"), ("link_3", 0, "rz")),
          [(0, 2, RX), (1, 0, JOINT), (2, 0, JOINT)]),
    "B": (zero(("link_1", 2, "rz"), ("link_2", 0, "rz"), ("link_3", 2, "rz")),
          [(0, 2, RX), (1, 0, JOINT), (2, 2, RZ)]),
    "C": (zero(("link_1", 2, "rz"), ("link_2", 2, "rz"), ("link_3", 2, "rz")),
          [(0, 2, RX), (1, 2, RZ), (2, 2, RZ)]),
    "chord": ({"zeroed": "chord"}, [(0, 2, RX), (1, 2, Y), (2, 2, Y)]),
    "middle": (zero(("link_1", 1, "rz"), ("link_2", 1, "y"), ("link_3", 2, "rz")),
               [(0, 1, RX), (1, 1, Y), (2, 2, RZ)]),
}  # fmt: skip


@pytest.mark.parametrize("name", SETS)
def test_accelerations_whatever_is_zeroed(name):
    """The ERLS may be chosen freely; the equations hold for each choice."""
    erls, directions = SETS[name]
    compare(anthropomorphic(erls=erls, damping={"alpha": 0.087, "beta": 2.1e-3}), directions)


def test_zeroed_dof_askew_to_the_beam():
    """Where dh alpha is not zero the joint's axis lies askew in the beam axes: both dofs follow."""
    scene = robot(
        link("a", {"a": 0.4, "d": 0.3, "alpha": 0.6}, beam=SOFT),
        link("b", {"a": 0.4}, beam=SOFT),
        erls=zero(("a", 2, "rz"), ("b", 1, "y")),
    )
    # link a: x along the link, z the part of z_l normal to it; the joint's axis in these axes
    c, s = np.cos(0.6), np.sin(0.6)
    along = np.array([0.4, 0.3 * s, 0.3 * c]) / 0.5
    z = np.array([0.0, 0.0, 1.0]) - along[2] * along
    z /= np.linalg.norm(z)
    axis = np.array([0.0, s, c])
    direction = np.array([0, 0, 0, axis @ along, axis @ np.cross(z, along), axis @ z])
    compare(scene, [(0, 2, direction), (1, 1, Y)])


def test_planar_double_pendulum_of_the_thesis():
    """Equation 2.60: the deflection of node 2 and the rotation of node 3 are zeroed, one element a
    link.
    """
    scene = two_link(erls=zero(("link_1", 1, "y"), ("link_2", 0, "rz")))
    for part in scene["links"]:
        part["beam"]["elements"] = 1
    compare(scene, [(0, 1, Y), (1, 0, JOINT)])


def test_the_other_road_is_sensitive():
    """A thousandth of a payload's mass shows, so agreement to 1e-9 means something."""
    scene = load_scene(oblique())
    heavier = load_scene(oblique(), {"links.b.payload.mass": 1.3013})
    road, other = IndependentChain(scene), IndependentChain(heavier)
    rng = np.random.default_rng(4)
    z, zd = 0.01 * rng.standard_normal((2, road.unknowns))
    a, b = (r.acceleration(z, zd, np.zeros(3)) for r in (road, other))
    assert np.max(np.abs(a - b)) > 1e-6 * np.max(np.abs(a))
