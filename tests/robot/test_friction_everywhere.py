"""Friction holds joints in every formulation, beside elastic links, springs, slides and loops."""

import numpy as np
import pytest
from mechanisms import four_bar
from scenes import link, robot

from flexsim_node import load_scene, simulate
from flexsim_node.motion.simulation import Simulation

pytestmark = pytest.mark.equations

BEAM = {"elements": 2, "youngs_modulus": 2e10}
RUB = {"coulomb_friction": 3.0}


def arm(*joints, **keys) -> dict:
    """Two elastic links in a vertical plane, moving."""
    links = [
        link(f"link_{k + 1}", {"a": 0.3}, 0.02, 0.02, joint=joint, beam=BEAM)
        for k, joint in enumerate(joints)
    ]
    initial = {"velocity": [1.0, -1.5]}
    usual = {"gravity": [0.0, -1.0, 0.0], "initial": initial, "damping": {"beta": 1e-3}}
    return robot(*links, **{**usual, **keys})


def slide(**keys) -> dict:
    """A link that slides out of an oblique one."""
    return robot(
        link("a", {"a": 0.3, "alpha": 0.4}, joint=RUB, beam={**BEAM, "elements": 1}),
        link("b", {"a": 0.2, "d": 0.1, "alpha": 0.3}, None, joint={**RUB, "type": "prismatic"},
             rigid={"mass": 0.3, "inertia": [[1e-3, 0, 0], [0, 1e-3, 0], [0, 0, 1e-3]]}),
        gravity=[0.0, 0.0, -1.0], initial={"velocity": [0.5, 0.3]}, damping={"beta": 1e-3}, **keys,
    )  # fmt: skip


SPRUNG = {"coulomb_friction": 10.0, "rotor_inertia": 0.02, "stiffness": 300.0, "damping": 0.5}
LISTED = [{"link": "link_1", "node": 2, "dof": "rz"}, {"link": "link_2", "node": 0, "dof": "rz"}]
SCENES = {
    "root": arm(RUB, RUB, erls={"zeroed": "root"}),
    "chord": arm(RUB, RUB, erls={"zeroed": "chord"}),
    "list": arm(RUB, RUB, erls={"zeroed": LISTED}),
    "generalized-alpha": arm(RUB, RUB, solver={"method": "generalized_alpha"}),
    "co-moving": arm(RUB, RUB, formulation="co_moving"),
    "reduced": arm(RUB, RUB, reduction={"modes": 2}),
    "alpha": arm(RUB, RUB, damping={"alpha": 2.0, "beta": 1e-3}),
    "springs": arm(SPRUNG, SPRUNG),
    "springs, co-moving": arm(SPRUNG, SPRUNG, formulation="co_moving"),
    "slide": slide(),
    "slide, co-moving": slide(formulation="co_moving"),
}


@pytest.mark.parametrize("name", SCENES)
def test_joints_come_to_rest_and_stay(name):
    """After the brakes have taken the motion, encoders stand still under the arm's weight for good."""
    robot_now = Simulation(load_scene(SCENES[name]))
    assert np.max(np.abs(robot_now.joint_velocity())) > 0.1
    rates, places = [], []
    for _ in range(160):
        assert robot_now.step() == 0
        rates.append(robot_now.joint_velocity().copy())
        places.append(robot_now.joint_position().copy())
    assert np.max(np.abs(rates[100:])) <= 1e-6
    assert np.max(np.ptp(places[100:], axis=0)) < 1e-12


@pytest.mark.parametrize("beam", [None, BEAM], ids=["rigid", "elastic"])
@pytest.mark.parametrize("formulation", ["erls", "co_moving"])
def test_a_loop_is_held_by_its_passive_joints(beam, formulation):
    """Brakes in a four-bar's motor and pins stop it with the loop closed; one pin's brake alone does, too."""
    scene = four_bar(beam, formulation=formulation, gravity=[0.0, 0.0, 0.0], damping={"beta": 1e-3})
    for brakes in ((0, 1, 3), (3,)):
        braked = {**scene, "links": [dict(part) for part in scene["links"]]}
        for n in brakes:
            braked["links"][n]["joint"] = {**braked["links"][n].get("joint", {}), "coulomb_friction": 4.0}
        robot_now = Simulation(load_scene(braked))
        places = []
        for _ in range(220):
            assert robot_now.step() == 0
            places.append(robot_now.joint_position().copy())
        assert np.max(np.abs(np.diff(places[:5], axis=0))) > 1e-3
        held = [k for k, n in enumerate((0, 1, 3)) if n in brakes]
        assert np.max(np.ptp(np.array(places[180:])[:, held], axis=0)) < 1e-9
        assert np.max(np.abs(robot_now.joint_velocity()[held])) <= 1e-6


def test_energy_only_falls():
    """Three rigid links with unequal brakes and no weight: no step gains energy."""
    links = [
        link(f"link_{k}", {"a": 0.3}, joint={"coulomb_friction": f}, flexible=False)
        for k, f in enumerate((0.3, 0.02, 1.0))
    ]
    scene = robot(*links, gravity=[0.0, 0.0, 0.0], initial={"velocity": [2.0, -5.0, 4.0]})
    for step in (1e-3, 1e-2):
        run = simulate(load_scene(scene, {"solver.step": step}), duration=200 * step)
        assert run.status == "ok"
        # what the method itself gains of a motion without friction, of third order in the step
        assert np.max(np.diff(run.energy)) < 50.0 * step**3 * run.energy[0]
        assert run.energy[-1] < 0.6 * run.energy[0]
