"""Each effect matters where it should, and leaves no trace in what a step computes when it is off."""

import numpy as np
import pytest
from scenes import anthropomorphic, link, robot

from flexsim_node import load_scene, simulate
from flexsim_node.elements.beam import INERTIA_Y, INERTIA_Z, POLAR, SHEAR_Y, SHEAR_Z, STIFFENING
from flexsim_node.equations.dynamics.acceleration import acceleration
from flexsim_node.model.chain import (
    ALPHA,
    BETA,
    CORIOLIS,
    COULOMB,
    DAMPER,
    GRAVITY,
    MOTOR,
    ROTOR,
    SPIN,
    SPRING,
    VISCOUS,
)
from flexsim_node.motion.simulation import Simulation
from flexsim_node.scene.schema import Effects

JOINT = {
    "viscous_friction": 0.5,
    "coulomb_friction": 0.3,
    "rotor_inertia": 1e-3,
    "gear_ratio": 10.0,
    "stiffness": 2e3,
    "damping": 0.4,
}
EFFECTS = list(Effects.model_fields)


def everything(**effects):
    """An oblique arm on which every effect acts."""
    scene = robot(
        link("a", {"a": 0.3, "alpha": 0.7, "d": 0.2}, 0.02, 0.01, joint=JOINT),
        link("b", {"a": 0.4, "alpha": -0.4}, 0.01, 0.02, joint=JOINT, payload={"mass": 0.4}),
        damping={"alpha": 1.0, "beta": 1e-4},
        effects={"shear": True, **effects},
        erls={"zeroed": "root"},
    )
    return load_scene(scene)


def moving(scene):
    """(2, m) accelerations of joints and motors in a state where everything is displaced and moves."""
    now = Simulation(scene)
    model, work = now.model, now.work
    rng = np.random.default_rng(7)
    # nodal rows that all effects share, thinned to the unknowns of this model
    rows, rates = 1e-3 * rng.standard_normal((2, len(model.node_link), 6))
    for n, row in enumerate(model.chain.unknown):
        for dof, k in zip(model.chain.dofs, row, strict=True):
            if k >= 0:
                now.x[k], now.v[k] = rows[n, dof], 100.0 * rates[n, dof]
    joints, speeds = np.array([0.4, -0.8]), np.array([5.0, -7.0])
    now.x[: model.joints], now.v[: model.joints] = joints, speeds
    for k, motor in enumerate(model.motor):
        if motor >= 0:
            now.x[motor], now.v[motor] = joints[k] + 0.01, speeds[k] + 0.5
    found = np.zeros(model.unknowns)
    assert acceleration(model.chain, work, now.x, now.v, np.array([3.0, -2.0]), found) == 0
    return np.array([found[: model.joints], found[model.turned]])


@pytest.mark.parametrize("effect", EFFECTS)
def test_effect_matters(effect):
    """Leaving one out changes accelerations by more than rounding would."""
    on, off = moving(everything(**{effect: True})), moving(everything(**{effect: False}))
    assert np.max(np.abs(on - off) / np.abs(on)) > 1e-6


def traces(model):
    """For each effect what a step would compute of it."""
    chain = model.chain
    free = np.zeros(6, dtype=int)
    for row in chain.unknown:
        for dof, k in zip(chain.dofs, row, strict=True):
            free[dof] += k >= 0
    element, joint, setting = chain.element, chain.joint, chain.setting
    return {
        "gravity": np.any(setting[GRAVITY : GRAVITY + 3]),
        "axial": free[0],
        "torsion": free[3],
        "bending_y": free[2] + free[4],
        "bending_z": free[1] + free[5],
        "shear": np.any(element[:, [SHEAR_Y, SHEAR_Z]]),
        "rotary_inertia": np.any(element[:, [INERTIA_Y, INERTIA_Z]]),
        "coriolis": setting[CORIOLIS],
        "centrifugal": setting[SPIN] + np.any(element[:, STIFFENING]),
        "damping": setting[ALPHA] + setting[BETA],
        "joint_friction": np.any(joint[:, [VISCOUS, COULOMB]]),
        "rotor_inertia": np.any(joint[:, ROTOR]),
        "joint_elasticity": np.any(chain.link[:, MOTOR] >= 0) + np.any(joint[:, [SPRING, DAMPER]]),
    }


@pytest.mark.parametrize("effect", EFFECTS)
def test_effect_is_skipped_when_off(effect):
    """No unknown, no matrix entry and no branch of a step knows of it; the others stay."""
    on, off = Simulation(everything()).model, Simulation(everything(**{effect: False})).model
    with_it, without = traces(on), traces(off)
    assert all(with_it.values())
    takes_along = {"axial": ["centrifugal"], "rotor_inertia": ["joint_elasticity"]}.get(effect, [])
    for name, trace in without.items():
        assert bool(trace) != (name == effect or name in takes_along), name
    if effect in ("axial", "torsion", "bending_y", "bending_z", "joint_elasticity"):
        assert off.unknowns < on.unknowns


def test_points_spin_about_the_beam():
    """Without rotary inertia sections have inertia about the beam while they can twist, and not else."""
    for torsion in (True, False):
        model = Simulation(everything(rotary_inertia=False, torsion=torsion)).model
        assert np.any(model.chain.element[:, POLAR]) == torsion


def test_plane_has_three_dofs_a_node():
    """A robot that can't leave its plane carries three, another six."""
    flat = robot(link("a", {"a": 0.5}), link("b", {"a": 0.5}), gravity=[0.0, -9.81, 0.0])
    assert len(Simulation(load_scene(flat)).model.chain.dofs) == 3
    assert len(Simulation(load_scene(anthropomorphic())).model.chain.dofs) == 6


def test_rigid_links_carry_no_unknowns():
    """`flexible: false` for one link leaves the other's."""
    scene = anthropomorphic()
    scene["links"][1]["flexible"] = False
    some, all_of_them = (Simulation(load_scene(s)).model for s in (scene, anthropomorphic()))
    assert some.unknowns == all_of_them.unknowns - 12
    run = simulate(load_scene(scene), duration=0.01)
    assert run.status == "ok"
