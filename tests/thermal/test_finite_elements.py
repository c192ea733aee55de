"""Finite elements of the door: matrices by another program, balance, order of accuracy, steady state."""

import numpy as np
import pytest
from door_scenes import door, slab
from skfem import Basis, BilinearForm, ElementHex1, ElementQuad1, MeshHex, MeshQuad
from skfem.helpers import dot, grad

from thermal_node import Heat, door_model, load_scene
from thermal_node.burning.steady import steady_state
from thermal_node.heat.conduction import evaluate
from thermal_node.heat.linear import conjugate_gradients, factor_lines, krylov

ELEMENTS = {"discretisation": "finite_element"}
COARSE = {**ELEMENTS, "in_plane": [5, 4], "layers": [1, 3, 1]}
K, C = {"steel": 45.0, "rock_wool": 0.1}, {"steel": 3.9e6, "rock_wool": 1.2e5}


def plain(model):
    """The door of materials whose properties don't depend on the temperature."""
    materials = {
        "steel": {"density": 7800.0, "specific_heat": 500.0, "conductivity": 45.0},
        "rock_wool": {"density": 120.0, "specific_heat": 1000.0, "conductivity": 0.1},
    }
    return door_model(load_scene(door(mesh=COARSE, materials=materials, solver={"model": model})))


def matrices_by_skfem(model):
    """Conduction and capacity matrices, rows and columns in the order of the model's nodes."""
    mesh = model.mesh
    bricks = mesh.brick_material.transpose(2, 1, 0)
    if len(mesh.y) == 1:
        grid, element = MeshQuad.init_tensor(mesh.x, mesh.z), ElementQuad1()
        bricks = bricks[:, 0]
        position = np.insert(grid.p, 1, 0.0, axis=0)
    else:
        grid, element = MeshHex.init_tensor(mesh.x, mesh.y, mesh.z), ElementHex1()
        position = grid.p
    lines = [c for c in (mesh.x, mesh.y, mesh.z) if len(c) > 1]
    centre = grid.p[:, grid.t].mean(axis=1)
    which = tuple(np.searchsorted(line, c) - 1 for line, c in zip(lines, centre, strict=True))
    names = np.array(mesh.material_names)[bricks[which]]
    basis = Basis(grid, element, intorder=3)

    @BilinearForm
    def conduction(u, v, w):
        return w.k * dot(grad(u), grad(v))

    @BilinearForm
    def capacity(u, v, w):
        return w.c * u * v

    def each(values):
        return np.array([values[n] for n in names])[:, None] * np.ones(basis.X.shape[1])

    i, j, k = (
        np.abs(line[:, None] - p).argmin(axis=0)
        for line, p in zip((mesh.x, mesh.y, mesh.z), position, strict=True)
    )
    node = (k * len(mesh.y) + j) * len(mesh.x) + i
    place = np.argsort(node)
    return tuple(
        form.assemble(basis, **{name: each(values)}).toarray()[np.ix_(place, place)]
        for form, name, values in ((conduction, "k", K), (capacity, "c", C))
    )


@pytest.mark.parametrize("dimension", ["column_rim", "full"])
def test_conduction_and_capacity_are_those_that_scikit_fem_assembles(dimension):
    model = plain(dimension)
    conduction, capacity = matrices_by_skfem(model)
    heat = Heat(model)
    off = np.array([[20.0] * 3, [20.0] * 3, [0.0] * 3])
    surface = model.surface._replace(film=np.zeros(3), emissivity=np.zeros(3))
    rng = np.random.default_rng(7)
    cold = None
    for _ in range(3):
        t = rng.uniform(20.0, 900.0, len(heat.temperature))
        evaluate(t, off, model.tables, model.grid, surface, heat._field, 0.0, None, None, None)
        expected = -conduction @ t
        np.testing.assert_allclose(heat._field.flow, expected, rtol=0, atol=1e-9 * np.abs(expected).max())
        now = t, heat._field.heat.copy()
        if cold is not None:
            gained = capacity @ (now[0] - cold[0])
            np.testing.assert_allclose(now[1] - cold[1], gained, rtol=0, atol=1e-9 * np.abs(gained).max())
        cold = now


@pytest.mark.parametrize("dimension", ["column_rim", "full"])
def test_conjugate_gradients_solve_the_assembled_equations(dimension):
    """Capacity + 20 s conduction: the solution, and the lines through the thickness that precondition it."""
    model = plain(dimension)
    conduction, capacity = matrices_by_skfem(model)
    heat = Heat(model)
    surface = model.surface._replace(film=np.zeros(3), emissivity=np.zeros(3))
    evaluate(
        heat.temperature,
        np.array([[20.0] * 3, [20.0] * 3, [0.0] * 3]),
        model.tables,
        model.grid,
        surface,
        heat._field,
        0.0,
        None,
        None,
        None,
    )
    n, (ny, nx) = len(heat.temperature), model.mesh.shape[1:]
    plane = nx * ny
    work = krylov(n, plane, model.mesh.finite_elements)
    factor_lines(heat._field, 20.0, nx, plane, work)
    matrix = capacity + 20.0 * conduction
    np.testing.assert_allclose(work.own, np.diag(matrix), rtol=1e-9)
    behind = -np.diag(matrix, plane)
    np.testing.assert_allclose(work.line[plane:-plane], behind, rtol=1e-9, atol=1e-9 * np.abs(behind).max())
    right = np.random.default_rng(3).normal(size=n)
    work.r[:] = right
    found = np.empty(n)
    assert conjugate_gradients(found, nx, plane, work, 1e-12, 500) < 500
    expected = np.linalg.solve(matrix, right)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("step", ["auto", 60.0])
def test_every_step_keeps_the_balance(step):
    scene = door(mesh={**ELEMENTS, "in_plane": [6, 8], "layers": [1, 6, 1]}, solver={"step": step})
    heat = Heat(door_model(load_scene(scene)))
    assert heat.advance(3600.0).ok
    assert heat.balance.worst < 1e-6


def test_second_order_in_space_and_finite_volumes_tend_to_the_same():
    def wall(bricks, discretisation):
        stuff = {"density": 500.0, "specific_heat": 900.0, "conductivity": 0.8}
        scene = slab(
            0.1,
            stuff,
            bricks,
            furnace={"curve": "constant", "temperature": 300.0},
            exposed={"film_coefficient": 30.0, "emissivity": 0.5},
            unexposed={"film_coefficient": 8.0, "emissivity": 0.3},
        )
        scene["mesh"]["discretisation"] = discretisation
        scene["solver"]["step"] = 10.0
        heat = Heat(door_model(load_scene(scene)))
        assert heat.advance(2400.0).ok
        return heat.temperature[[0, -1]]

    exact = wall(320, "finite_volume")
    errors = [np.abs(wall(n, "finite_element") - exact).max() for n in (10, 20, 40)]
    order = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all(order > 1.8), (order, errors)


def test_steady_state_is_near_that_of_finite_volumes():
    def steady(discretisation):
        scene = door(
            mesh={"in_plane": [10, 12], "layers": [1, 6, 1], "discretisation": discretisation},
            solver={"model": "steady"},
        )
        heat = steady_state(door_model(load_scene(scene)), 3600.0)
        assert heat.status.ok
        return heat.temperature

    volumes, elements = steady("finite_volume"), steady("finite_element")
    assert np.abs(elements - volumes).max() < 0.02 * (volumes.max() - 20.0)


@pytest.mark.parametrize("value", [[0.02, 0.02, 0.02, 2.0, 5.0], [1.0, 0.5, 0.1, 0.05, 0.02]])
@pytest.mark.parametrize("layers", [[1, 2, 1], [2, 6, 2]])
def test_conductivity_that_changes_a_hundredfold(value, layers):
    """From the start to 60 min by long steps, and in balance."""
    scene = door(mesh={**ELEMENTS, "in_plane": [6, 5], "layers": layers}, solver={"step": 300.0})
    scene["materials"]["rock_wool"]["conductivity"]["value"] = value
    scene["materials"]["rock_wool"]["conductivity"]["beyond"] = "hold"
    heat = Heat(door_model(load_scene(scene)))
    assert heat.advance(3600.0).ok
    assert heat.balance.worst < 1e-6
    heat = steady_state(door_model(load_scene(scene, {"solver.model": "steady"})), 3600.0)
    assert heat.status.ok
    assert abs(heat.heat_flow().sum()) < 1e-6 * np.abs(heat.heat_flow()).sum()


def test_capacity_with_a_peak_is_lumped():
    """Steel's at 735 °C: shared with a node at the peak it would stop the march; wool's is consistent."""
    model = door_model(load_scene(door(mesh=COARSE)))
    names = [material.name for material in model.materials]
    for part in model.grid.mass:
        assert not part[names.index("steel")].any()
        assert part[names.index("rock_wool")].any()


@pytest.mark.parametrize("top", [1100.0, 1400.0, 1800.0])
def test_a_specific_heat_that_rises_within_twenty_kelvin_is_marched_through(top):
    """A damp board's table: the consistent capacity's derivative is then far from symmetric.

    Finite volumes, which have a lumped capacity, say what comes out in the middle: on eight bricks through
    the wool the two differ by 9 K within it, with the step in the table and without.
    """
    damp = {"temperature": [20, 95, 115, 135, 160, 1200], "value": [950, 950, top, top, 950, 950]}
    found = {}
    for kind in ("finite_element", "finite_volume"):
        mesh = {"discretisation": kind, "in_plane": [5, 5], "layers": [1, 8, 1], "first_brick": 6e-3}
        scene = load_scene(door(mesh=mesh), {"materials.rock_wool.specific_heat": damp})
        heat = Heat(door_model(scene))
        assert heat.advance(900.0).ok, heat.status.reason
        assert heat.balance.worst < 1e-6
        found[kind] = heat.temperature.reshape(heat.model.mesh.shape)[:, 0, 0].copy()
    assert np.abs(found["finite_element"] - found["finite_volume"]).max() < 10.0
