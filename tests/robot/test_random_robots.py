"""Robots that nobody thought of, held against others' programs and against themselves.

Each robot comes from a seed (random_robots.py).  A few run always, hundreds with the marker `nightly`
(make nightly).  What loads do to a robot's stiffness is in test_random_robots_loaded.py.
"""

from __future__ import annotations

import copy

import numpy as np
import pinocchio
import pytest
from direct_stiffness import Frame
from random_robots import KINDS, poses, random_robot
from rigid_chain import pinocchio_model
from robot_images import MIRROR, cut, mirrored, rotation, signs, straightened, turned, with_twice_the_elements
from scipy.integrate import simpson

from flexsim_node import Run, load_scene, natural_frequencies, simulate, static_equilibrium
from flexsim_node.equations.dynamics.acceleration import acceleration
from flexsim_node.equations.dynamics.energy import energy
from flexsim_node.model.chain import workspace
from flexsim_node.model.model import build_model
from flexsim_node.motion.simulation import Simulation
from flexsim_node.sensors.observation import Observation

NIGHTLY = 100  # seeds of every kind
FORMULATIONS = ("erls", "co_moving")


def seeds(*kinds: str, few: int = 2, many: int = NIGHTLY) -> pytest.MarkDecorator:
    """The test for the first seeds of every kind always, for the others by night."""
    rows = [
        pytest.param(kind, seed, marks=() if kind == "serial" and seed < few else pytest.mark.nightly)
        for kind in kinds
        for seed in range(many)
    ]
    return pytest.mark.parametrize(("kind", "seed"), rows)


def torque(scene, size: float = 1.0):
    """(m,) constant, on the motors alone."""
    rng = np.random.default_rng(len(scene.joints))
    driven = np.array([joint.actuated for joint in scene.joints])
    return size * rng.uniform(-1, 1, len(scene.joints)) * driven


def run(
    scene, duration: float = 0.06, step: float = 1e-3, formulation: str = "erls", period: float = 2e-3, **keys
) -> Run:
    """The robot let go, driven by constant torques."""
    loaded = load_scene(scene, {"formulation": formulation, "solver.step": step})
    effort = keys.pop("effort", None)
    effort = torque(loaded) if effort is None else effort
    found = simulate(loaded, lambda t: effort, duration, period, **keys)
    assert found.status == "ok", found.status
    return found


def rotation_of(*runs: Run) -> float:
    """Largest elastic rotation, rad."""
    return max(float(np.max(np.abs(r.node_displacement[:, :, 3:]))) for r in runs)


def moved(found: Run) -> float:
    """How far the robot's ends travelled, m."""
    return float(np.max(np.abs(found.link_end - found.link_end[0])))


@seeds("serial", "branched", "planar", few=8)
def test_rigid_robot_is_pinocchios(kind, seed):
    """Accelerations, mass matrix, energies and places of a robot with rigid links, both formulations."""
    made = random_robot(seed, kind)
    made["effects"].update(joint_elasticity=False, rotary_inertia=True)
    for part in made["links"]:
        part["flexible"] = False
    rng = np.random.default_rng(seed)
    for formulation in FORMULATIONS:
        scene = load_scene(made, {"formulation": formulation})
        model, other = build_model(scene), pinocchio_model(scene)
        work, data, m = workspace(model.chain), other.createData(), model.joints
        assert model.unknowns == m
        q, v, effort = rng.uniform(-2, 2, m), rng.uniform(-3, 3, m), rng.uniform(-5, 5, m)
        found, joules = np.zeros(m), np.zeros(3)
        assert acceleration(model.chain, work, q, v, effort, found) == 0
        right = pinocchio.aba(other, data, q, v, effort)
        assert np.allclose(found, right, rtol=0, atol=1e-9 * np.max(np.abs(right)))
        energy(model.chain, work, q, v, joules)
        above = joules[2] - pinocchio.computePotentialEnergy(other, data, q)
        assert joules[0] == pytest.approx(pinocchio.computeKineticEnergy(other, data, q, v), rel=1e-11)
        assert joules[1] == 0.0
        energy(model.chain, work, -q, v, joules)  # what stands on the base is no part of Pinocchio's height
        risen = joules[2] - pinocchio.computePotentialEnergy(other, data, -q)
        assert risen == pytest.approx(above, rel=1e-11, abs=1e-11)
        holds = pinocchio.computeGeneralizedGravity(other, data, q)
        assert np.allclose(
            static_equilibrium(scene, q).torque, holds, rtol=0, atol=1e-10 * np.max(np.abs(holds)) + 1e-13
        )
        view = Observation(model)
        view.look(work, q)
        places = poses(made["links"], dict(zip(scene.joint_names, q, strict=True)))
        assert np.allclose(view.link_end, [place[:3, 3] for place in places], rtol=0, atol=1e-13)


@seeds(*KINDS, few=6)
def test_unloaded_frequencies_are_a_frames(kind, seed):
    """Natural frequencies are those of a frame assembled by direct stiffness, joints locked and free."""
    made = random_robot(seed, kind)
    for formulation in FORMULATIONS:
        scene = load_scene(made, {"formulation": formulation})
        start = scene.start("position")
        for locked in (True, False):
            found = natural_frequencies(scene, start, locked)
            right = Frame(scene, start, locked).frequencies()
            assert len(found) == len(right)
            free = int(np.sum(right < 0.01))  # what turns freely has no frequency
            assert np.all(found[:free] < 0.01)
            assert np.allclose(found[free : free + 10], right[free : free + 10], rtol=1e-6)


def same(one: Run, two: Run, ends: np.ndarray, allowed: float) -> None:
    """Both robots' ends on the same way, to a share of what they travelled."""
    assert two.link_end.shape[0] == one.link_end.shape[0]
    assert np.max(np.abs(ends - one.link_end)) < allowed * moved(one)
    assert two.energy - two.energy[0] == pytest.approx(
        one.energy - one.energy[0], abs=allowed * (np.ptp(one.energy) + 1.0)
    )


@seeds("serial", "branched", "closed")
def test_turned_robot_moves_alike(kind, seed):
    """Robot and gravity turned together: the same motion, turned."""
    made = random_robot(seed, kind, modulus=2e10)
    for formulation in FORMULATIONS:
        one = run(made, formulation=formulation)
        two = run(turned(made, 0.7, -1.1), formulation=formulation)
        same(one, two, two.link_end[:, 1:] @ rotation(0.7, -1.1), 1e-6)


@seeds(*KINDS)
def test_mirrored_robot_moves_alike(kind, seed):
    """The mirror image moves as the mirror shows it."""
    made = random_robot(seed, kind, modulus=2e10)
    image = mirrored(made)
    for formulation in FORMULATIONS:
        effort = torque(load_scene(made))
        one = run(made, formulation=formulation, effort=effort)
        flips = np.array(list(signs(made).values()))
        two = run(image, formulation=formulation, effort=effort * flips)
        same(one, two, two.link_end @ MIRROR, 1e-6)
        assert np.allclose(one.joint_position, two.joint_position * flips, rtol=0, atol=1e-6)


@seeds("serial", "branched", "planar")
def test_link_in_two_pieces_moves_alike(kind, seed):
    """A beam of two pieces that are welded together is the beam with twice the elements.

    In the ERLS to second order: the second piece's rotations count from the first one's end.
    """
    made = straightened(random_robot(seed, kind, modulus=2e10))
    whole, pieces = with_twice_the_elements(made), cut(made)
    kept = [n for n, k in enumerate(pieces["links"]) if not _first_half(pieces["links"], n)]
    for formulation in FORMULATIONS:
        one, two = (run(s | {"erls": {"zeroed": "root"}}, formulation=formulation) for s in (whole, pieces))
        allowed = 1e-6 + (rotation_of(one, two) ** 3 if formulation == "erls" else 0.0)
        same(one, two, two.link_end[:, kept], allowed)
        assert np.allclose(one.joint_position, two.joint_position, rtol=0, atol=allowed)


def _first_half(links, n) -> bool:
    return n + 1 < len(links) and links[n + 1]["name"] == f"{links[n]['name']}_2"


@seeds("planar", few=4)
def test_plane_is_space_without_the_rest(kind, seed):
    """A robot that stays in its plane moves there as the model in space does."""
    scene = load_scene(random_robot(seed, kind, modulus=2e10))
    ways = []
    for planar in (True, False):
        robot = Simulation(scene, 1e-3, planar=planar)
        assert robot.model.planar == planar
        robot.torque[:] = torque(scene)
        for _ in range(60):
            assert robot.step() == 0
        ways.append(robot.look().link_end.copy())
    assert np.allclose(*ways, rtol=0, atol=1e-7)
    assert np.max(np.abs(ways[1][:, 2])) < 1e-12


DAMPINGS = [(0.0, 0.0), (2.0, 0.0), (0.0, 1e-4)]  # alpha, beta
STEPS = (1e-3, 1e-4, 2.5e-5, 5e-6)  # s


@seeds(*KINDS)
def test_motion_does_not_depend_on_what_is_zeroed(kind, seed):
    """Roots and chords give one motion to the squared elastic rotation, at any step, damped and undamped."""
    made = random_robot(seed, kind, modulus=2e10)
    for alpha, beta in DAMPINGS:
        for step in STEPS if seed < 10 else STEPS[:2]:
            root, chord = (
                run(
                    made | {"erls": {"zeroed": zeroed}, "damping": {"alpha": alpha, "beta": beta}},
                    step=step,
                    duration=0.04,
                )
                for zeroed in ("root", "chord")
            )
            squared = rotation_of(root, chord) ** 2
            assert np.max(np.abs(root.link_end - chord.link_end)) < 3.0 * squared + 1e-6


@seeds(*KINDS)
def test_co_moving_frames_move_alike(kind, seed):
    """Frames that follow the elements give the ERLS' motion to the order of the squared elastic rotation."""
    made = random_robot(seed, kind, modulus=2e10, damping={"beta": 1e-4})
    one, two = (run(made, step=2.5e-4, duration=0.04, formulation=f) for f in FORMULATIONS)
    assert np.max(np.abs(one.link_end - two.link_end)) < 3.0 * rotation_of(one) ** 2 + 1e-6


@seeds("serial", "branched", "planar")
def test_reduced_links_with_all_modes_move_alike(kind, seed):
    """Every mode kept, a reduced robot is the full one to the order of the squared elastic rotation."""
    made = random_robot(seed, kind, modulus=2e10, damping={"beta": 1e-4})
    full = run(made, step=2.5e-4, duration=0.04)
    small = copy.deepcopy(made)
    for part in small["links"]:
        if "beam" in part and part.get("flexible", True):
            free = 3 if kind == "planar" else 6
            part["reduction"] = {"modes": free * (part["beam"].get("elements", 2) - 1)}
    reduced = run(small, step=2.5e-4, duration=0.04)
    assert np.max(np.abs(full.link_end - reduced.link_end)) < 3.0 * rotation_of(full) ** 2 + 1e-6


@seeds(*KINDS)
def test_energy_is_what_torques_and_loads_put_in(kind, seed):
    """Work of constant torques, a constant force and a constant couple, less what friction takes."""
    made = random_robot(seed, kind, modulus=2e9)
    end = made["links"][-1]["name"]
    for part in made["links"]:
        if part["joint"]["type"] != "fixed":
            part["joint"]["viscous_friction"] = 0.05
    # a couple: opposite forces on two points that ride on the end
    for name, place in (("left", 0.1), ("right", -0.1)):
        made["links"].append({"name": name, "parent": end, "dh": {"a": place}, "joint": {"type": "fixed"}})
    flat = np.array([1.0, 1.0, 0.0]) if kind == "planar" else np.ones(3)
    force, couple = flat * [3.0, -2.0, 1.0], flat * [1.5, 2.0, -1.0]
    pushes = {end: force, "left": couple, "right": -couple}
    wrench = {f"base:{name}": lambda t, f=f: np.append(f, [0.0, 0.0, 0.0]) for name, f in pushes.items()}
    places = [n for n, part in enumerate(made["links"]) if part["name"] in pushes]
    for formulation in FORMULATIONS:
        found = run(made, 0.03, 5e-5, formulation, period=5e-5, wrench=wrench)
        effort = found.torque[0]
        work = (found.joint_position[-1] - found.joint_position[0]) @ effort
        way = found.link_end[-1] - found.link_end[0]
        work += sum(f @ way[n] for n, f in zip(places, pushes.values(), strict=True))
        lost = 0.05 * simpson(np.sum(found.joint_velocity**2, axis=1), x=found.time)
        gained = found.energy[-1] - found.energy[0]
        assert gained == pytest.approx(work - lost, abs=2e-3 * (abs(work) + lost + np.ptp(found.energy)))


def test_the_same_seed_is_the_same_robot():
    """A robot that fails by night can be looked at by day."""
    assert random_robot(5, "closed") == random_robot(5, "closed") != random_robot(6, "closed")
