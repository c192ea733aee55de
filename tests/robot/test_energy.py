"""Energy: kept without damping and torque, lost with damping, gained by a torque's work."""

import numpy as np
import pytest
from scenes import anthropomorphic, two_link
from scipy.integrate import simpson
from test_independent_equations import oblique, pieces, sliding

from flexsim_node import load_scene, simulate
from flexsim_node.motion.simulation import Simulation


def softened(scene, **keys):
    """A soft version of a scene that a tight explicit reference can afford, thrown with some
    speed.
    """
    m = 0
    for part in scene["links"]:
        if "beam" in part:
            part["beam"].update(youngs_modulus=1e8, elements=1)
        m += part.get("joint", {}).get("type") != "fixed"
    velocity = [1.5 * (-1) ** k for k in range(m)]
    initial = {"position": [0.1 * (k + 1) for k in range(m)], "velocity": velocity}
    return {**scene, "initial": initial, **keys}


def exchanged(scene, duration):
    """Range of the kinetic energy, J."""
    robot = Simulation(load_scene(scene), 5e-4)
    kinetic = []
    for _ in range(round(duration / 5e-4)):
        assert robot.step() == 0
        kinetic.append(robot.energy()[0])
    return np.ptp(kinetic)


SCENES = {
    "planar": two_link(),
    "planar chord": two_link(erls={"zeroed": "chord"}),
    "spatial": anthropomorphic(),
    "chord": anthropomorphic(erls={"zeroed": "chord"}),
    "payload, shear": oblique(effects={"shear": True}),
    "payload, points": oblique(effects={"rotary_inertia": False}),
    "prismatic": sliding(),
    "wrist, rigid links": pieces(),
}


@pytest.mark.parametrize("name", SCENES)
def test_kept_without_damping_and_torque(name):
    """Radau at a tight tolerance keeps the energy to 1e-7 of what is exchanged.  Measured: 3e-12."""
    scene = softened(SCENES[name])
    tight = {"method": "radau", "relative_tolerance": 1e-9, "absolute_tolerance": 1e-11}
    run = simulate(load_scene({**scene, "solver": tight}), duration=0.05, sample_period=0.005)
    assert run.status == "ok"
    assert np.max(np.abs(run.energy - run.energy[0])) < 1e-7 * exchanged(scene, 0.05)


@pytest.mark.parametrize(
    ("scene", "allowed"), [(two_link(), 2e-5), (anthropomorphic(), 2e-4)], ids=["planar", "spatial"]
)
def test_drift_of_the_default_integrator(scene, allowed):
    """Undamped steel robots in free fall at 1 ms.  Measured: 9e-6 and 5e-5 of the energy exchanged
    in 1 s.
    """
    run = simulate(load_scene(scene), duration=1.0)
    assert run.status == "ok"
    assert np.max(np.abs(run.energy - run.energy[0])) < allowed * exchanged(scene, 1.0)


def test_stiffness_damping_only_takes():
    """Damping proportional to stiffness never feeds energy."""
    scene = two_link(damping={"beta": 5e-4}, gravity=[0, 0, 0])
    scene["initial"] = {"velocity": [3.0, -6.0]}
    run = simulate(load_scene(scene, {"solver.step": 2.5e-4}), duration=0.5, sample_period=1e-3)
    assert np.max(np.diff(run.energy)) < 1e-7 * run.energy[0]
    assert run.energy[-1] < run.energy[0]


def test_torque_gives_its_work():
    """The energy gained is the motors' work, integral of torque times the encoders' speed."""
    for zeroed in ("root", "chord"):
        scene = load_scene(
            softened(anthropomorphic(erls={"zeroed": zeroed})),
            {
                "solver.method": "dop853",
                "solver.relative_tolerance": 1e-10,
                "solver.absolute_tolerance": 1e-12,
                "validity.elastic_rotation.stop": 5.0,
            },
        )

        def torque(t):
            return np.array([0.9 * np.sin(20 * t), 0.3, -0.2 * np.cos(9 * t)])

        run = simulate(scene, torque, 0.1, sample_period=2.5e-5)
        work = simpson(np.sum(run.torque * run.joint_velocity, axis=1), x=run.time)
        assert run.status == "ok" and work > 0.5
        assert run.energy[-1] - run.energy[0] == pytest.approx(work, rel=1e-6)


@pytest.mark.parametrize("zeroed", ["root", "chord"])
def test_mass_damping_only_takes(zeroed):
    """Rayleigh's alpha gives no energy: no more than the method itself does without it (2.4e-6 J)."""
    scene = two_link(damping={"alpha": 2.0}, erls={"zeroed": zeroed})
    run = simulate(load_scene(scene, {"solver.step": 2e-4}), duration=0.5, sample_period=1e-3)
    lowest = np.minimum.accumulate(run.energy)
    assert run.status == "ok" and np.max(run.energy - lowest) < 3e-6
    thesis = load_scene(scene, {"solver.step": 2e-4, "damping.alpha_form": "thesis"})
    gained = simulate(thesis, duration=0.5, sample_period=1e-3).energy
    assert np.max(gained - np.minimum.accumulate(gained)) > 1e-4


def test_mass_damping_moves_every_set_alike():
    """The motion with alpha is the same to ten times the squared elastic rotation of a robot 1 m long."""
    runs = [
        simulate(
            load_scene(two_link(damping={"alpha": 2.0}, erls={"zeroed": zeroed}), {"solver.step": 2e-4}),
            duration=0.5, sample_period=2e-3,
        )
        for zeroed in ("root", "chord")
    ]  # fmt: skip
    rotation = max(run.validity["elastic_rotation"] for run in runs)
    assert np.max(np.abs(runs[0].link_end - runs[1].link_end)) < 10.0 * rotation**2
