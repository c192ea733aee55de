"""The 3-D door agrees with CalculiX on the same mesh, an independent program's elements and march.

The reference marched with implicit Euler and 10 s steps; its hot face is 6 K off its own
time-converged value at 60 s (136.0 against 129.9 °C in the reference's own text). So the march
is compared like for like with 10 s steps, and the adaptive march where that error has died out.
What then remains of finite volumes is the error of the reference's bricks: finite elements of ours and a
program of such bricks give the table itself, and the reference's own program on a finer mesh gives what
finite volumes do.
Its probes are the nodes nearest to the named places: on the same graded mesh so are ours.
"""

import csv

import linear_bricks
import numpy as np
import pytest
from door_scenes import DATA, door

from thermal_node import load_scene, simulate
from thermal_node.model.door_model import door_model

TABLE = DATA / "door_quarter_calculix_probes.csv"


@pytest.fixture(scope="module")
def reference():
    with TABLE.open() as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def columns(run):
    mesh = run.model.mesh
    field = run.temperature[1:].reshape(-1, *mesh.shape)
    cold, area = field[:, -1], mesh.unexposed_area

    def at(x, y):
        return cold[:, np.argmin(np.abs(mesh.y - y)), np.argmin(np.abs(mesh.x - x))]

    return {
        "hot_c": field[:, 0, 0, 0],
        "cold_c": cold[:, 0, 0],
        "cold_q": at(0.25, 0.5),
        "side_edge": cold[:, 0, -1],
        "top_edge": cold[:, -1, 0],
        "corner": cold[:, -1, -1],
        "side_25": at(0.475, 0.0),
        "side_50": at(0.45, 0.0),
        "side_100": at(0.4, 0.0),
        "side_150": at(0.35, 0.0),
        "top_25": at(0.0, 0.975),
        "top_100": at(0.0, 0.9),
        "side_mid": field[:, mesh.shape[0] // 2, 0, -1],
        "hot_side": field[:, 0, 0, -1],
        "cold_min": cold.min(axis=(1, 2)),
        "cold_max": cold.max(axis=(1, 2)),
        "cold_areamean": (cold * area).sum(axis=(1, 2)) / area.sum(),
    }


def test_like_for_like_with_the_references_own_steps_and_elements(reference):
    """Within 1 K at every probe and minute, 2 K to 120 s; measured 0.87 and 1.11 K."""
    scene = door(solver={"method": "implicit_euler", "step": 10.0})
    scene["mesh"]["discretisation"] = "finite_element"
    ours = columns(simulate(load_scene(scene)))
    early = reference["t_s"] <= 120.0
    for name, values in ours.items():
        error = np.abs(values - reference[name])
        assert error[early].max() < 2.0, name
        assert error[~early].max() < 1.0, name


def test_finite_volumes_with_the_references_own_steps(reference):
    scene = door(solver={"method": "implicit_euler", "step": 10.0})
    ours = columns(simulate(load_scene(scene)))
    early = reference["t_s"] <= 120.0
    for name, values in ours.items():
        error = np.abs(values - reference[name])
        assert error[early].max() < 2.0, name
        # What linear bricks leave on this mesh: 1.1 K at the hot sheet over the rim (below).
        assert error[~early].max() < (1.15 if name == "hot_side" else 1.05), name


def test_the_references_own_error_is_that_of_linear_bricks(reference):
    """The same bricks, steps and consistent capacity by another program give the table, at each minute."""
    mesh = door_model(load_scene(door(solver={"model": "column_rim"}))).mesh
    strip = linear_bricks.burn(mesh.x, mesh.z, step=10.0, end=2100.0, every=60.0)
    cold = strip[:, -1]
    found = {
        "hot_c": strip[:, 0, 0],
        "cold_c": cold[:, 0],
        "side_edge": cold[:, -1],
        "side_mid": strip[:, len(mesh.z) // 2, -1],
        "hot_side": strip[:, 0, -1],
        **{f"side_{k}": cold[:, np.argmin(np.abs(mesh.x - 0.5 + 1e-3 * k))] for k in (25, 50, 100, 150)},
    }
    for name, values in found.items():
        assert np.abs(values - reference[name][: len(values)]).max() < 0.4, name


def test_adaptive_march_where_the_references_first_steps_have_died_out(reference):
    ours = columns(simulate(load_scene(door())))
    late = reference["t_s"] >= 360.0
    for name, values in ours.items():
        error = np.abs(values - reference[name])[late]
        assert error.max() < (1.4 if name == "hot_side" else 1.0), name


def strip(**solver):
    run = simulate(load_scene(door(solver={"model": "column_rim", **solver})))
    mesh = run.model.mesh
    field = run.temperature[1:].reshape(-1, *mesh.shape)[:, :, 0]
    return {
        "hot_c": field[:, 0, 0],
        "cold_c": field[:, -1, 0],
        "side_edge": field[:, -1, -1],
        "side_mid": field[:, mesh.shape[0] // 2, -1],
        "hot_side": field[:, 0, -1],
    }


def test_default_mesh_and_march_against_a_finer_calculix_without_error_of_its_steps():
    """At every minute, the first two among them; measured 0.8 K over the rim, 0.5 K elsewhere."""
    with (DATA / "door_strip_calculix.csv").open() as file:
        rows = list(csv.DictReader(file))
    ours = strip()
    for name, values in ours.items():
        error = np.abs(values - [float(row[name]) for row in rows])
        assert error.max() < (0.9 if name == "hot_side" else 0.6), name


def test_the_default_march_has_next_to_no_error_of_its_own():
    ours, exact = strip(), strip(tolerance=1e-3)
    for name, values in ours.items():
        assert np.abs(values - exact[name]).max() < 0.1, name


def test_hot_sheet_in_the_first_minutes_is_the_time_converged_one():
    run = simulate(load_scene(door(mesh={"layers": [1, 60, 1]}, solver={"model": "column"})), 360.0)
    expected = [129.9, 276.1, 391.1, 468.7, 521.2, 559.3]
    np.testing.assert_allclose(run.probes["exposed_centre"][1:], expected, atol=0.25)
