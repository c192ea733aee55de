"""The formulas of docs/theory are those of the kernels, and a number that is cited is defined there.

Each Python block of a page is executed as it stands, so that page and test cannot part.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from flexsim_node import Run, load_scene, simulate
from flexsim_node.elements import spatial_beam
from flexsim_node.elements.beam import (
    AXIAL,
    BEND_Y,
    BEND_Z,
    COLUMNS,
    HELIX,
    HERMITE_MASS,
    INERTIA_Y,
    INERTIA_Z,
    LENGTH,
    MASS,
    QUADRATIC_MASS,
    SHEAR_Y,
    SHEAR_Z,
    STIFFENING,
    TORSION,
    TURNING,
    bending_stiffness,
    squared_slope,
)  # fmt: skip
from flexsim_node.elements.element import element_matrices
from flexsim_node.equations.constraints.closure import linearise
from flexsim_node.equations.constraints.friction import obeyed
from flexsim_node.equations.dynamics.acceleration import acceleration
from flexsim_node.equations.dynamics.energy import energy
from flexsim_node.equations.dynamics.residual import residual
from flexsim_node.equations.dynamics.tangent import mass_matrix
from flexsim_node.equations.forces.damping import oppose
from flexsim_node.equations.kinematics.nodal_motion import accelerate, place
from flexsim_node.equations.solve.factorization import eliminate_node
from flexsim_node.equations.solve.joint_elimination import eliminate_joint, joint_vectors
from flexsim_node.model.chain import (
    COORDINATES,
    FIXED,
    FRAME_COLUMNS,
    KIND,
    PHI,
    REVOLUTE,
    ROTOR,
    Q,
    workspace,
)  # fmt: skip
from flexsim_node.model.model import build_model
from flexsim_node.model.reduced.reduction import assemble, fixed_interface_modes
from flexsim_node.motion.simulation import Simulation
from flexsim_node.rotations.rotation_vector import coefficients
from flexsim_node.sensors.observation import Observation
from thermal_node import Heat, door_model
from thermal_node import load_scene as load_door
from thermal_node.heat.method import METHODS

ROOT = Path(__file__).parents[2]
THEORY = ROOT / "docs" / "theory"
PAGES = sorted(THEORY.glob("*.md"))
CONFIG = ROOT / "config"
BLOCK = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)
DEFINED = re.compile(r"\\tag\{([A-Z]\d+)\}|^(?! *- ).* {4,}\(([A-Z]\d+)\)$", re.MULTILINE)
NUMBERS = r"[CDEFHIKLMRT]\d{1,2}"
CITED = re.compile(rf"\(({NUMBERS}(?:(?:,| and| to) {NUMBERS})*)\)|\.md, ({NUMBERS})\b")
equations = pytest.mark.equations


def page(name: str) -> SimpleNamespace:
    """What the Python blocks of a page define."""
    names: dict[str, object] = {}
    exec("\n\n".join(BLOCK.findall((THEORY / f"{name}.md").read_text())), names)
    return SimpleNamespace(**{key: value for key, value in names.items() if not key.startswith("__")})


def element_row(**changes: float) -> np.ndarray:
    """An element in space with everything on."""
    e = np.zeros(COLUMNS)
    e[LENGTH], e[MASS], e[INERTIA_Y], e[INERTIA_Z] = 0.3, 1.7, 2e-3, 3e-3
    e[AXIAL], e[TORSION], e[BEND_Y], e[BEND_Z] = 1e5, 2.0, 5.0, 3.0
    e[SHEAR_Y], e[SHEAR_Z], e[HELIX] = 0.1, 0.2, 1e-3
    e[STIFFENING] = e[TURNING] = 1.0
    for column, value in changes.items():
        e[{"stiffening": STIFFENING, "turning": TURNING}[column]] = value
    return e


def gauss(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and weights on (0, 1)."""
    points, weights = np.polynomial.legendre.leggauss(count)
    return (points + 1) / 2, weights / 2


# numbers


def test_cited_equations_are_defined() -> None:
    """Every (K1) in code, comments and pages stands on a page of docs/theory, once."""
    found: dict[str, str] = {}
    for path in PAGES:
        for match in DEFINED.finditer(path.read_text()):
            number = match[1] or match[2]
            assert found.setdefault(number, path.name) == path.name, f"{number} is on two pages"
    assert {"K1", "M1", "T1", "E1", "C1", "R1", "I1", "L1", "D1", "F1", "H1"} <= set(found)
    by_letter = {number[0]: name for number, name in found.items()}
    assert len(set(by_letter.values())) == len(by_letter)
    lost = []
    sources = [*PAGES, *(ROOT / "docs").glob("*.md"), *(ROOT / "examples").glob("*.md")]
    for folder in ("flexsim_node", "thermal_node"):
        sources += (ROOT / folder).rglob("*.py")
    for path in sources:
        for match in CITED.finditer(path.read_text()):
            cited = re.findall(NUMBERS, match[1] or match[2])
            if " to " in match[0]:
                first, last = (int(number[1:]) for number in cited[:2])
                cited += [f"{cited[0][0]}{k}" for k in range(first, last)]
            lost += [f"{path.relative_to(ROOT)}: {number}" for number in cited if number not in found]
    assert not lost


def test_the_table_of_pages_is_whole() -> None:
    """docs/theory/README.md lists every page, with the letter that the page uses; files named exist."""
    listed = dict(re.findall(r"\]\((\w+\.md)\) \| ([A-Z]) \|", (THEORY / "README.md").read_text()))
    assert set(listed) == {path.name for path in PAGES} - {"README.md"}
    for name, letter in listed.items():
        text = (THEORY / name).read_text()
        assert {(m[1] or m[2])[0] for m in DEFINED.finditer(text)} == {letter}
        for path in re.findall(r"`((?:flexsim_node|thermal_node|tests)/[\w/]+(?:\.py|/))`", text):
            assert (ROOT / path).exists(), f"{name}: {path}"


def test_picture_of_the_blocks_is_what_the_program_draws(tmp_path: Path) -> None:
    program = THEORY / "elimination_blocks.py"
    plain = os.environ | {"NUMBA_DISABLE_JIT": "1"}  # a few calls of kernels are not worth compiling them
    subprocess.run([sys.executable, program, tmp_path / "new.svg"], check=True, env=plain)
    drawn = (ROOT / "docs" / "images" / "elimination_blocks.svg").read_text()
    assert (tmp_path / "new.svg").read_text() == drawn


# field


@equations
def test_mass_of_an_element_is_the_integral_of_its_field() -> None:
    """(K4), (K5), (K7) under Gauss points give the kernels' mass and stiffness matrices, and (M2)."""
    field, e = page("field"), element_row(stiffening=0.0, turning=0.0)
    l, points = e[LENGTH], gauss(6)  # noqa: E741
    mass, stiffness = element_matrices(e)

    def at(unit: np.ndarray, xi: float) -> tuple[np.ndarray, np.ndarray]:
        end, start = unit[:6], unit[6:]
        y = (start[1], start[5], end[1], end[5], l, e[SHEAR_Z])
        z = (start[2], -start[4], end[2], -end[4], l, e[SHEAR_Y])
        functions = field.hermite_functions(xi)
        centre = [
            (1 - xi) * start[0] + xi * end[0],
            functions @ field.hermite_coefficients(*y),
            functions @ field.hermite_coefficients(*z),
        ]
        turn = [
            (1 - xi) * start[3] + xi * end[3],
            -field.section_rotation(xi, *z),
            field.section_rotation(xi, *y),
        ]
        return np.array(centre), np.array(turn)

    whole = np.zeros((12, 12))
    for xi, weight in zip(*points, strict=True):
        centre, turn = (np.array(parts) for parts in zip(*(at(unit, xi) for unit in np.eye(12)), strict=True))
        e_y = np.cross(turn, [0.0, 1.0, 0.0])
        e_z = np.cross(turn, [0.0, 0.0, 1.0])
        whole += weight * e[MASS] * centre @ centre.T
        whole += weight * l * (e[INERTIA_Y] * e_y @ e_y.T + e[INERTIA_Z] * e_z @ e_z.T)
    # without twist on a rotary inertia of its own: e_y and e_z carry it
    assert np.allclose(mass, whole, rtol=0, atol=1e-14)

    def bend(unit: np.ndarray) -> float:
        return field.bending_energy(e[BEND_Z] * l, *unit, l, e[SHEAR_Z])

    units = np.eye(4)
    second = [[bend(i + k) - bend(i) - bend(k) for k in units] for i in units]
    assert np.allclose(bending_stiffness(e[BEND_Z], l, e[SHEAR_Z]), second, rtol=1e-13, atol=1e-12)
    assert np.allclose(stiffness, stiffness.T, rtol=0, atol=1e-9)

    products = sum(
        w * np.outer(field.hermite_functions(x), field.hermite_functions(x))
        for x, w in zip(*points, strict=True)
    )
    assert np.allclose(HERMITE_MASS, products, rtol=0, atol=1e-15)
    quadratics = np.array([[(1 - x) * (1 - 2 * x), 4 * x * (1 - x), x * (2 * x - 1)] for x in points[0]])
    assert np.allclose(QUADRATIC_MASS, quadratics.T @ (points[1][:, None] * quadratics), rtol=0, atol=1e-15)


@equations
def test_elastic_forces_are_the_gradient_of_the_energy() -> None:
    """(T2) and (T7): forces are its first derivative, by complex steps; a pull's stiffness is its second."""
    second, e = page("second_order"), element_row()
    l = e[LENGTH]  # noqa: E741
    given = (e[AXIAL] * l, e[BEND_Y] * l, e[BEND_Z] * l, e[TORSION] * l, e[SHEAR_Y], e[SHEAR_Z], e[HELIX])
    rows = 1e-2 * np.sin(np.arange(12.0)).reshape(2, 6)
    rows[:, 0] *= 1e-2

    def gradient(at: np.ndarray) -> np.ndarray:
        out, step = np.zeros(12), 1e-30
        for k in range(12):
            moved = at.astype(complex).ravel()
            moved[k] += 1j * step
            start, end = moved.reshape(2, 6)
            out[k] = second.strain_energy(start, end, l, *given).imag / step
        return out

    force = np.zeros((2, 6))
    spatial_beam.elastic_force(e, rows, 1, force)
    assert np.allclose(force.ravel(), gradient(rows), rtol=1e-12, atol=1e-12 * np.abs(force).max())

    # geometric stiffness: bending of a straight element that is pulled, N times the second derivative of
    # the mean squared slope over two
    pulled = np.zeros((2, 6))
    pulled[1, 0] = 1e-3
    tension, step = e[AXIAL] * 1e-3, 1e-5
    bend = np.zeros(12)
    bend[7] = step
    stiff = (gradient(pulled + bend.reshape(2, 6)) - gradient(pulled - bend.reshape(2, 6))) / (2 * step)
    free = (gradient(bend.reshape(2, 6)) - gradient(-bend.reshape(2, 6))) / (2 * step)
    half_gradient = squared_slope(0.0, 0.0, 1.0, 0.0, l, e[SHEAR_Z])[3]
    assert np.isclose((stiff - free)[7], tension * l * half_gradient, rtol=1e-5)
    assert (stiff - free)[7] > 0.05 * free[7]  # it is there


# equations of motion


@equations
def test_lagrange_of_the_page_is_the_kernels_motion() -> None:
    """(M1) to (M8): energies, mass matrix and accelerations of one planar link by the page's functions."""
    motion = page("motion")
    l, width, depth, density, E, gravity = 0.6, 0.02, 0.005, 2700.0, 7e9, np.array([1.0, -9.81])  # noqa: E741
    beam = {"width": width, "depth": depth, "density": density, "youngs_modulus": E, "poissons_ratio": 0.3,
            "elements": 1}  # fmt: skip
    scene = load_scene({
        "model": "robot", "name": "one", "gravity": [*gravity, 0.0], "erls": {"zeroed": "root"},
        "links": [{"name": "a", "dh": {"a": l}, "beam": beam}],
        "effects": {"rotary_inertia": False, "torsion": False},
    })  # fmt: skip
    model = build_model(scene)
    assert model.planar and model.unknowns == 4
    area = width * depth
    # in the plane the beam bends about its z axis: width lies along y
    stiffness = E * depth * width**3 / 12
    mass = density * area * l
    x = np.array([0.7, 1e-5, 0.03, 0.08])
    v = np.array([2.0, -0.01, 0.4, -0.9])
    torque = 0.3

    def potential(at: np.ndarray) -> float:
        return motion.potential_energy(at, mass, l, E * area, stiffness, gravity)

    found = np.zeros(3)
    work = workspace(model.chain)
    energy(model.chain, work, x, v, found)
    assert np.isclose(found[0], motion.kinetic_energy(x, v, mass, l), rtol=1e-13)
    assert np.isclose(found[1] + found[2], potential(x), rtol=1e-12)

    units = np.eye(4)

    def page_mass(at: np.ndarray) -> np.ndarray:
        def kinetic(rate: np.ndarray) -> float:
            return motion.kinetic_energy(at, rate, mass, l)

        return np.array([[kinetic(i + k) - kinetic(i) - kinetic(k) for k in units] for i in units])

    assert np.allclose(mass_matrix(model, x), page_mass(x), rtol=0, atol=1e-12)

    def slope(function, step: float) -> np.ndarray:  # five points along each unknown
        return sum(
            w * np.array([function(x + k * step * unit) for unit in units])
            for k, w in ((-2, 1), (-1, -8), (1, 8), (2, -1))
        ) / (12 * step)  # fmt: skip

    by_x = slope(page_mass, 1e-3)
    force = np.array([torque, 0.0, 0.0, 0.0]) - slope(potential, 1e-5)
    force += 0.5 * np.einsum("kij,i,j->k", by_x, v, v) - np.einsum("kij,k,j->i", by_x, v, v)
    a = np.zeros(4)
    acceleration(model.chain, work, x, v, np.array([torque]), a)
    assert np.allclose(page_mass(x) @ a, force, rtol=0, atol=1e-7 * np.abs(force).max())


# elimination


@equations
@pytest.mark.parametrize("b", [3, 6])
def test_a_node_is_eliminated_as_the_page_does(b: int) -> None:
    """(E3): what a front leaves is the Schur complement, in the kernel and on the page."""
    elimination = page("elimination")
    factor = np.random.default_rng(3).normal(size=(3 * b, 3 * b))
    front = factor @ factor.T
    size = 3 * b
    work = SimpleNamespace(
        front=np.triu(front).copy(), pivot=np.zeros((b, size + 1)), row=np.zeros((6, max(36, size)))
    )
    assert eliminate_node(np.arange(b).reshape(1, b), work, 0, b)
    left = elimination.eliminate(front, b)
    schur = front[b:, b:] - front[b:, :b] @ np.linalg.solve(front[:b, :b], front[:b, b:])
    assert np.allclose(left, schur, rtol=0, atol=1e-11 * np.abs(front).max())
    assert np.allclose(np.triu(work.front[b:, b:]), np.triu(left), rtol=0, atol=1e-11 * np.abs(front).max())


@equations
def test_a_joint_is_eliminated_as_the_page_does() -> None:
    """(E5) with a rotor, for a joint with a rotation of its own."""
    elimination = page("elimination")
    scene = load_scene(CONFIG / "anthropomorphic.yaml", {
        "erls.zeroed": "chord", "links.link_2.joint.rotor_inertia": 0.02,
    })  # fmt: skip
    model = build_model(scene)
    chain, work = model.chain, workspace(model.chain)
    n = 1
    assert chain.link[n, PHI] >= 0 and chain.link[n, KIND] == REVOLUTE and chain.joint[n, ROTOR] == 0.02
    place(chain, work, np.full(model.unknowns, 0.01))
    work.kept[:, :FRAME_COLUMNS] = work.frame[:, :FRAME_COLUMNS]
    factor = np.random.default_rng(4).normal(size=(12, 12))
    z = factor @ factor.T
    psi, q = np.zeros(12), np.zeros(12)
    joint_vectors(chain.link[n, KIND], chain.joint, work.kept[n], n, 6, psi, q)
    wanted = elimination.eliminate_joint(z, psi, q, 0.02)
    assert eliminate_joint(chain, work, n, z, 6, np.zeros(work.row.shape[1]), np.zeros(work.row.shape[1]))
    assert np.allclose(z, wanted, rtol=0, atol=1e-11 * np.abs(wanted).max())


# formulations


@equations
def test_co_moving_sections_are_where_the_page_says() -> None:
    """(C2) in the plane: ends of links whose rotations are not small."""
    co_moving = page("co_moving")
    scene = load_scene(CONFIG / "planar_double_pendulum.yaml", {
        "formulation": "co_moving", "links.link_1.beam.elements": 1, "links.link_2.beam.elements": 1,
    })  # fmt: skip
    model = build_model(scene)
    rows = np.array([[0.4, 1e-3, 0.3, -0.5], [-0.9, -2e-3, -0.4, 0.2]])
    x = np.zeros(model.unknowns)
    x[:2] = rows[:, 0]
    for row, node in zip(rows, (1, 3), strict=True):
        x[model.chain.unknown[node]] = row[1:]
    view = Observation(model)
    view.look(workspace(model.chain), x)
    assert np.allclose(view.link_end[:, :2], co_moving.section_ends(rows, 0.5), rtol=0, atol=1e-14)


@equations
@pytest.mark.parametrize("angle", [1e-3, 0.7, 2.9])
def test_tangent_of_a_rotation_vector(angle: float) -> None:
    """(C3): the coefficients are those of the page."""
    c1, c2, _, _ = coefficients(angle**2)
    assert np.isclose(c1, (1 - np.cos(angle)) / angle**2, rtol=1e-9)
    assert np.isclose(c2, (angle - np.sin(angle)) / angle**3, rtol=1e-9)


@equations
def test_modes_of_a_link_with_its_ends_held() -> None:
    """(R1), (R2): frequencies are the kernels', and stiffness does not couple modes to ends."""
    reduction, e = page("reduction"), element_row(stiffening=0.0, turning=0.0)
    mass, stiffness = (assemble(np.array([matrix] * 6)) for matrix in element_matrices(e))
    ends = np.r_[0:6, 36:42]
    M, K, frequency = reduction.craig_bampton(mass, stiffness, ends, 8)
    found = fixed_interface_modes(mass, stiffness, 7)
    lowest = np.sqrt(sorted(squared for squared, _, _ in found)[:8]) / (2 * np.pi)
    assert np.allclose(frequency, lowest, rtol=1e-9)
    assert np.allclose(K[:12, 12:], 0.0, rtol=0, atol=1e-9 * np.abs(K).max())
    assert np.allclose(K[:12, :12], static_condensation(stiffness, ends), rtol=0, atol=1e-9 * np.abs(K).max())
    assert np.abs(M[:12, 12:]).max() > 1e-3 * np.abs(M).max()


def static_condensation(stiffness: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """The ends' stiffness as flexibility has it: unit loads on a link held at its start."""
    held = stiffness[6:, 6:]
    flexibility = np.linalg.inv(held)[-6:, -6:]
    tip = np.linalg.inv(flexibility)
    # a rigid motion of the start takes the end along
    length = 0.3 * 6
    along = np.eye(6)
    along[1, 5], along[2, 4] = length, -length
    rigid = np.hstack([-along, np.eye(6)])
    return rigid.T @ tip @ rigid


# integrators


def slowed(method: str) -> tuple[Run, float]:
    """One rigid link with viscous friction b and no gravity, J v' = -b v; and h b / J."""
    step, friction, mass, length = 0.02, 0.05, 0.5, 0.4
    inertia = mass * length**2
    scene = load_scene({
        "model": "robot", "name": "slowed", "gravity": [0.0, 0.0, 0.0],
        "solver": {"method": method, "step": step},
        "links": [{
            "name": "a", "dh": {"a": length}, "flexible": False,
            "joint": {"name": "j", "type": "revolute", "viscous_friction": friction},
            "payload": {"mass": mass},
        }],
        "initial": {"position": [0.3], "velocity": [1.5]},
    })  # fmt: skip
    run = simulate(scene, duration=6 * step)
    assert run.status == "ok"
    return run, -step * friction / inertia


@equations
@pytest.mark.parametrize("method", ["rosenbrock_w", "runge_kutta_4"])
def test_a_step_multiplies_by_the_stability_function(method: str) -> None:
    """(I4) and (I8), by the real integrators on a rate that friction slows down."""
    run, z = slowed(method)
    growth = getattr(page("integrators"), f"{method}_growth")(z)
    ratio = run.joint_velocity[1:, 0] / run.joint_velocity[:-1, 0]
    assert np.allclose(ratio, growth, rtol=1e-12)


@equations
def test_generalized_alpha_steps_as_the_page_does() -> None:
    """(I5) to (I7) by the real integrator."""
    integrators = page("integrators")
    run, z = slowed("generalized_alpha")
    h = run.time[1] - run.time[0]
    x, v = run.joint_position[0, 0], run.joint_velocity[0, 0]
    a = z / h * v  # the true acceleration is what the method begins with
    rho = load_scene(CONFIG / "simple_pendulum.yaml").solver.spectral_radius
    for k in range(1, len(run.time)):
        x, v, a = integrators.generalized_alpha_step(x, v, a, h, rho, 1.0, -z / h, 0.0)
        assert np.isclose(run.joint_velocity[k, 0], v, rtol=1e-11)
        assert np.isclose(run.joint_position[k, 0], x, rtol=1e-11)


def test_orders_and_stability_of_the_pages_methods() -> None:
    """rosenbrock_w, TR-BDF2, SDIRK2: order two, L-stable.  Generalized-alpha: its radius at infinity."""
    integrators, march = page("integrators"), page("march")
    methods = {
        "rosenbrock_w": integrators.rosenbrock_w_growth,
        "tr_bdf2": lambda z: march.growth(*march.TR_BDF2, z),
        "sdirk2": lambda z: march.growth(*march.SDIRK2, z),
    }
    for name, growth in methods.items():
        errors = [abs(growth(z) - np.exp(z)) for z in (-0.02, -0.01)]
        assert 7.5 < errors[0] / errors[1] < 8.5, name  # h^3 in a step
        assert abs(growth(-1e12)) < 1e-10, name
        for z in (1j * np.logspace(-3, 4, 60)).tolist():
            assert abs(growth(z)) <= 1 + 1e-14, name
    for rho in (0.0, 0.5, 0.8, 1.0):
        columns = [
            integrators.generalized_alpha_step(*unit, h=1.0, rho=rho, m=1e-12, c=0.0, k=1.0)
            for unit in np.eye(3)
        ]
        radius = np.abs(np.linalg.eigvals(np.array(columns).T)).max()
        assert np.isclose(radius, rho, atol=2e-4), rho


# loops, damping, friction


@equations
def test_loops_are_closed_by_the_pages_multipliers() -> None:
    """(L3), (L4): the kernels' accelerations, by dense algebra; what closes the loop does no work."""
    loops = page("loops")
    scene = load_scene(CONFIG / "four_bar.yaml")
    simulation = Simulation(scene, scene.solver.step)
    model, x, v = simulation.model, simulation.x.copy(), simulation.v.copy()
    chain, n = model.chain, simulation.model.unknowns
    x[3:] += 1e-5 * np.sin(np.arange(n - 3))  # undeformed links fly apart freely, and need no forces to close
    work, torque = workspace(chain), np.array([0.2, 0.0, 0.0])
    a, free, zero = np.zeros(n), np.zeros(n), np.zeros(n)

    def linear(rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        place(chain, work, x)
        accelerate(chain, work, rates, zero)
        linearise(chain, work, rates)
        return work.closure[:, :n].copy(), work.closure[:, 2 * n + work.closure.shape[0]].copy()

    G, _ = linear(v)
    v -= np.linalg.pinv(G) @ (G @ v)
    G, g2 = linear(v)
    acceleration(chain, work, x, v, torque, a)
    residual(chain, work, x, v, zero, torque, free)
    mass = mass_matrix(model, x)
    wanted, multipliers = loops.close_accelerations(mass, free, G, g2)
    # M is a difference of residuals, here with accelerations of 1e7
    assert np.allclose(mass @ a, mass @ wanted, rtol=0, atol=1e-9 * np.abs(mass @ a).max())
    assert np.allclose(G @ a, -g2, rtol=0, atol=1e-10 * np.abs(g2).max())
    assert np.abs(multipliers).max() > 1.0  # N: the loop holds something
    assert abs(v @ (G.T @ multipliers)) < 1e-9 * np.abs(multipliers).max()


@equations
@pytest.mark.parametrize("zeroed", ["root", "chord"])
def test_damping_takes_twice_the_dissipation(zeroed: str) -> None:
    """(D1) to (D4): the force of alpha takes energy at the rate 2 D, and none from rigid motion."""
    damping, alpha = page("damping"), 3.0
    scene = load_scene(CONFIG / "anthropomorphic.yaml", {
        "erls.zeroed": zeroed, "damping.alpha": alpha, "damping.beta": 0.0,
    })  # fmt: skip
    model = build_model(scene)
    chain, n = model.chain, model.unknowns
    coordinates = int(chain.setting[COORDINATES])
    x = np.zeros(n)  # undeformed: M is that of the undeformed links
    x[:3] = 0.3, 0.6, -0.8
    joints = [(row[Q], row[PHI]) for row in chain.link if row[KIND] != FIXED]
    P = damping.elastic_motion(n, joints, coordinates)
    v, force = np.cos(np.arange(n)), np.zeros(n)
    work = workspace(chain)
    place(chain, work, x)
    oppose(chain, work, v, force)
    assert np.isclose(force @ v, 2 * damping.dissipation(mass_matrix(model, x), P, v, alpha), rtol=1e-10)
    force[:] = 0.0
    v[coordinates:] = 0.0
    oppose(chain, work, v, force)
    assert np.allclose(force, 0.0, rtol=0, atol=1e-14)


@equations
def test_friction_of_one_joint() -> None:
    """(F4) obeys (F1), and the kernel's is the page's."""
    one = page("friction").friction_of_one_joint
    for u in (-2.0, -0.3, 0.0, 0.1, 0.5, 4.0):
        f = one(1.2, u, 0.4)
        rate = u - 0.4 * f
        assert f == obeyed(1.2, 0.0, u, 0.4)
        assert abs(f) <= 1.2 and (abs(rate) < 1e-15 or np.isclose(f, 1.2 * np.sign(rate)))


# the door


def test_tableaus_of_the_march() -> None:
    """(H5), (H6) are those that the door is marched with."""
    march = page("march")
    for name, (a, b) in (("tr_bdf2", march.TR_BDF2), ("sdirk2", march.SDIRK2)):
        method = METHODS[name]
        assert np.allclose(method.weight, b, rtol=0, atol=1e-15)
        for row, couple in zip(a, method.couple, strict=True):
            stage = [*couple, method.diagonal]
            assert np.allclose(row[: len(stage)], stage, rtol=0, atol=1e-15)
            assert not np.any(row[len(stage) :])


def test_heat_that_is_stored_is_heat_that_flowed() -> None:
    """(H1), (H2), (H10) in one step: H from the materials' integrals, flows with the weights b."""
    door = door_model(load_door(CONFIG / "thesis_door_column.yaml"))
    heat = Heat(door)
    heat.advance(120.0)

    def stored() -> float:
        volume = door.mesh.volume.reshape(len(door.materials), -1)
        return sum(
            float(volume[m] @ (material.density * material.specific_heat.integrated(heat.temperature)))
            for m, material in enumerate(door.materials)
        )

    before, step, flows = stored(), 30.0, [heat._flows[0].sum()]
    outcome, _ = heat.attempt(step)
    assert outcome == 0
    weights = page("march").TR_BDF2[1]
    flows += [heat._flows[k].sum() for k in (1, 2)]
    entered = step * float(np.dot(weights, flows))
    heat.accept(step)
    assert abs(stored() - before - entered) < 1e-6 * abs(entered)
    assert entered > 0.0
