"""With rigid links the robot is Pinocchio's: its joint angles after a second, and the torques that
hold it.
"""

import numpy as np
import pinocchio
import pytest
from rigid_chain import friction, pinocchio_model
from scenes import CONFIG, anthropomorphic, two_link
from scipy.integrate import solve_ivp
from test_independent_equations import forked, losses, oblique, pieces, planar_fork, sliding

from flexsim_node import load_scene, simulate, static_equilibrium

TIGHT = {
    "solver.method": "dop853",
    "solver.relative_tolerance": 1e-11,
    "solver.absolute_tolerance": 1e-12,
}


def stiffened(scene):
    """The same robot with every link rigid, undamped."""
    for part in scene["links"]:
        part["flexible"] = False
    return {**scene, "damping": {"alpha": 0.0, "beta": 0.0}}


SCENES = {
    "planar": two_link(),
    "spatial": anthropomorphic(),
    "payloads": oblique(),
    "wrist, fixed joint": pieces(),
    "prismatic": sliding(),
    "forked": forked(),
    "planar fork": planar_fork(),
    "rotors and friction": losses(),
}


@pytest.mark.parametrize("name", SCENES)
def test_joint_angles_are_pinocchios(name):
    """Joint angles within 1e-6 rad after 1 s of driven motion."""
    scene = load_scene(stiffened(SCENES[name]), TIGHT)
    m = len(scene.joints)

    def torque(t):
        return np.array([0.8, -0.5, 0.3, 0.2, 0.1, 0.05])[:m] * np.sin(5 * t + np.arange(m))

    model = pinocchio_model(scene)
    data = model.createData()

    def slope(t, y):
        q, v = y[:m], y[m:]
        effort = torque(t) + friction(scene, v)
        return np.concatenate([v, pinocchio.aba(model, data, q, v, effort)])

    right = solve_ivp(slope, (0, 1), np.zeros(2 * m), "DOP853", rtol=1e-11, atol=1e-12).y[:, -1]
    run = simulate(scene, torque=torque, duration=1.0, sample_period=0.5)
    assert run.status == "ok"
    assert np.max(np.abs(run.joint_position[-1] - right[:m])) < 1e-6
    assert np.max(np.abs(right[:m])) > 0.1


@pytest.mark.parametrize("name", [*SCENES, "anthropomorphic_spherical_wrist"])
def test_holding_torques_are_pinocchios(name):
    """A motor's holding torque in any pose is gravity's moment on what it carries."""
    scene = SCENES.get(name)
    if scene is None:
        links = [x.name for x in load_scene(CONFIG / f"{name}.yaml").links]
        scene = load_scene(CONFIG / f"{name}.yaml", {f"links.{x}.flexible": False for x in links})
    else:
        scene = load_scene(stiffened(scene))
    model = pinocchio_model(scene)
    rng = np.random.default_rng(7)
    for _ in range(5):
        q = rng.uniform(-2, 2, len(scene.joints))
        right = pinocchio.computeGeneralizedGravity(model, model.createData(), q)
        found = static_equilibrium(scene, q).torque
        assert np.allclose(found, right, rtol=0, atol=1e-10 * np.max(np.abs(right)))
