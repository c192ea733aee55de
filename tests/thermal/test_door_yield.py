"""Sheets yield as closed forms say, and where yielding is left out the leaf says how near it is."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner
from door_scenes import door
from flexsim.verbs.door import command
from scipy.integrate import quad
from scipy.optimize import brentq

from thermal_node import SceneError, door_model, load_scene, simulate
from thermal_node.analysis.report import facts
from thermal_node.deformation import yielding
from thermal_node.deformation.leaf import Deformation
from thermal_node.deformation.unilateral import Unsettled
from thermal_node.deformation.utilisation import von_mises
from thermal_node.deformation.yielding import plastic_flow
from thermal_node.model.strength import yield_strength

PLAIN = {"density": 7800.0, "specific_heat": 500.0, "conductivity": 40.0}
YIELD = 200e6
MODULUS = 2e11


def leaf(materials, sheets, size=(0.01, 1.0), **deformation):
    scene = load_scene(
        {
            "model": "fire_door",
            "leaf": {"height": size[1], "width": size[0], "layers": sheets},
            "materials": {name: PLAIN | part for name, part in materials.items()},
            "mesh": {"in_plane": [2, 2], "layers": [4] * len(sheets), "symmetry": "none"},
            "deformation": {"model": "shell", "yielding": "layered", "in_plane": [2, 40], **deformation},
        }
    )
    model = door_model(scene)
    return model, Deformation(model)


def test_stress_returns_to_the_yield_surface_along_its_normal():
    """Closed forms: pure shear, two equal axes; any other lies on the surface, its flow on the normal."""
    nu, strength = 0.3, np.full(4, YIELD)
    trial = np.array([[0.0, 0.0, 3e8], [5e8, 0.0, 0.0], [-6e8, -6e8, 0.0], [7e8, -2e8, 1e8]])
    flow = plastic_flow(trial, np.full(4, MODULUS), np.full(4, nu), strength)
    plane = MODULUS / (1.0 - nu**2) * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    stress = trial - flow @ plane
    np.testing.assert_allclose(von_mises(stress), YIELD, rtol=1e-10)
    np.testing.assert_allclose(stress[0, 2], YIELD / np.sqrt(3.0), rtol=1e-10)
    np.testing.assert_allclose(stress[2], [-YIELD, -YIELD, 0.0], rtol=1e-10, atol=1.0)
    normal = stress @ np.array([[1.0, -0.5, 0.0], [-0.5, 1.0, 0.0], [0.0, 0.0, 3.0]])
    turn = np.cross(flow, normal)
    assert np.abs(turn).max() < 1e-9 * np.abs(flow).max() * np.abs(normal).max()
    assert (np.einsum("pi,pi->p", flow, stress) > 0.0).all()  # plastic work is spent, never gained


@pytest.mark.parametrize("temperature", [300.0, 500.0, 700.0])
def test_a_restrained_sheet_bears_its_strength_at_its_temperature(temperature):
    """A thin steel sheet on a stiff plate that does not stretch: stress is the yield strength of table 3.1.

    The plastic strain is what of the elongation is not elastic: twice it as an equivalent one.
    """
    stiff = {"youngs_modulus": 1e13, "poissons_ratio": 0.3, "elongation": 0.0}
    model, deformation = leaf(
        {"steel": {"yield_strength": 275e6}, "stiff": stiff},
        [{"material": "steel", "thickness": 0.0005}, {"material": "stiff", "thickness": 0.2}],
        size=(1.0, 2.0),
        hinges=[-0.8, 0.8],
        in_plane=[6, 12],
    )
    used = deformation.solve(np.full(len(model.nodes), temperature)).utilisation
    factor = {300.0: (1.0, 0.8), 500.0: (0.78, 0.6), 700.0: (0.23, 0.13)}[temperature]
    strength, modulus = 275e6 * factor[0], 2.1e11 * factor[1]
    assert used.stress == pytest.approx(strength, rel=1e-3)
    assert used.strength == pytest.approx(strength, rel=1e-9)
    stretch = float(model.materials[model.mesh.material_names.index("steel")].elongation(temperature))
    plastic = stretch - 0.7 * strength / modulus
    assert used.plastic_strain == pytest.approx(2.0 * plastic, rel=0.01)


STRIP = {"hinges": [-0.5, 0.0, 0.5], "lock": [-0.5, 0.0, 0.5], "layers": [10]}
"""Deformation of a strip; layers are the bricks through it."""
WIDTH, DEPTH, LENGTH = 0.01, 0.01, 1.0
RIGIDITY = MODULUS * WIDTH * DEPTH**3 / 12.0
FIRST = YIELD * WIDTH * DEPTH**2 / 6.0
"""N m, moment of first yield; 1.5 times it is the plastic moment."""


def beam(curvature):
    """Moment over that of first yield at the middle of three supports, by the section's closed form.

    Half a beam of length a bends by curvature - phi(m s / a) and must not move at its support:
    the integral of phi(m s / a) s is curvature a^2 / 2, with phi = m M1 / EI to first yield and
    M1 / EI / sqrt(3 - 2 m) above.
    """
    first = FIRST / RIGIDITY

    def phi(m):
        return first * m if m <= 1.0 else first / np.sqrt(3.0 - 2.0 * m)

    def off(m):
        return quad(lambda s: phi(m * s) * s, 0.0, 1.0, points=[1.0 / m] if m > 1.0 else None)[0]

    return brentq(lambda m: off(m) - 0.5 * curvature, 1e-6, 1.5 - 1e-12)


@pytest.mark.parametrize("share", [0.8, 1.2, 1.5])
def test_a_strip_on_three_supports_is_an_elastic_plastic_beam(share):
    """Its moment at the middle against the closed form; after cooling what is left is locked in.

    share : of the moment of first yield that an elastic strip would have at its middle
    """
    curvature = share * FIRST / RIGIDITY * 2.0 / 3.0
    rise = curvature * DEPTH / 1.2e-5
    # Elastic and plastic strain narrow the strip alike, or its section would hold stress across as well.
    plain = {
        "youngs_modulus": MODULUS, "poissons_ratio": 0.49, "elongation": 1.2e-5, "yield_strength": YIELD,
    }  # fmt: skip
    sheets = [{"material": "plain", "thickness": DEPTH}]
    model, deformation = leaf({"plain": plain}, sheets, **{**STRIP, "in_plane": [2, 80]})
    hot = deformation.solve(20.0 + rise * (1.0 - model.nodes[:, 2] / DEPTH))
    expected = beam(curvature)
    assert moment_in_the_middle(hot) == pytest.approx(expected, rel=1e-3)
    cold = deformation.solve(np.full(len(model.nodes), 20.0), hot)
    assert moment_in_the_middle(cold) == pytest.approx(expected - share, abs=3e-3 * share)
    if share < 1.0:
        assert hot.utilisation.plastic_strain == 0.0
        assert hot.utilisation.share == pytest.approx(share, rel=0.08)  # its point is within the fibre
    else:
        assert hot.utilisation.share == pytest.approx(1.0, abs=5e-3)
        assert moment_in_the_middle(cold) < -0.01


def moment_in_the_middle(shape):
    """Of a strip on three supports, over that of first yield."""
    force = sum(r.force for r in shape.support_forces if r.name in ("hinge at 0 m", "lock at 0 m"))
    return 0.25 * LENGTH * force / FIRST


def test_a_door_that_yields_bends_alike_in_larger_and_smaller_increments(monkeypatch):
    """And against the stop: what it comes to is no matter of the increments."""
    scene = load_scene(
        door(
            mesh={"in_plane": [6, 8], "layers": [1, 4, 1], "symmetry": "quarter"},
            deformation={
                "model": "shell", "in_plane": [6, 12], "yielding": "layered", "opens": "towards_fire",
            },
        ),
        {"materials.rock_wool.youngs_modulus": 5e5},
    )  # fmt: skip
    model = door_model(scene)
    hot = 600.0 - 560.0 * model.nodes[:, 2] / 0.06
    found = {}
    for increment in (yielding.INCREMENT, 0.25 * yielding.INCREMENT):
        monkeypatch.setattr(yielding, "INCREMENT", increment)
        found[increment] = Deformation(model).solve(hot)
    one, other = found.values()
    assert one.bow == pytest.approx(other.bow, rel=5e-3)
    assert one.utilisation.share == pytest.approx(1.0, abs=0.01)
    elastic = Deformation(door_model(load_scene(scene.model_dump(), {"deformation.yielding": "none"}))).solve(
        hot
    )
    assert elastic.utilisation.share > 2.0 and elastic.utilisation.plastic_strain is None
    assert abs(elastic.bow - one.bow) > 0.05 * one.bow


@pytest.mark.parametrize("kind", ["shell", "solid"])
def test_utilisation_of_a_strip_is_that_of_a_beam(kind):
    """Three supports, elastic: the middle's outer fibre has M / W."""
    scene = {
        "model": "fire_door",
        "leaf": {"height": 1.0, "width": WIDTH, "layers": [{"material": "plain", "thickness": DEPTH}]},
        "materials": {
            "plain": PLAIN | {
                "youngs_modulus": MODULUS, "poissons_ratio": 0.0, "elongation": 1.2e-5,
                "yield_strength": YIELD,
            }
        },
        "mesh": {"in_plane": [2, 2], "layers": [4], "symmetry": "none"},
        "deformation": {"model": kind, "in_plane": [2, 40], **STRIP},
    }  # fmt: skip
    model = door_model(load_scene(scene))
    rise = 0.5 * FIRST / RIGIDITY * 2.0 / 3.0 * DEPTH / 1.2e-5
    used = Deformation(model).solve(20.0 + rise * (1.0 - model.nodes[:, 2] / DEPTH)).utilisation
    assert used.share == pytest.approx(0.5, rel=0.08)  # the outermost point is within the fibre
    assert abs(used.position[1]) < 0.03 and used.material == "plain"


QUICK = {
    "mesh": {"in_plane": [4, 6], "layers": [1, 4, 1], "symmetry": "quarter"},
    "solver": {"model": "full", "step": 60.0, "method": "implicit_euler"},
}


def test_a_run_says_what_its_supports_bear_and_how_near_it_is_to_yield(tmp_path):
    scene = door(**QUICK, deformation={"model": "shell", "in_plane": [6, 12], "interval": 300.0})
    run = simulate(load_scene(scene, {"materials.rock_wool.youngs_modulus": 5e5}), 600.0, 300.0)
    said = dict(facts(run))
    assert "kN" in said["hinge at 0 m bears, at 10 min"]
    assert said["frame's stop"].startswith("none")
    assert "would yield" in said["largest use of the yield strength"]
    assert run.utilisation.share > 1.0 and run.utilisation_time in run.shapes
    assert sum(r.force for r in run.shapes[600.0].support_forces) == pytest.approx(0.0, abs=1e-3)
    path = tmp_path / "door.yaml"
    path.write_text(json.dumps(scene))
    wool = "materials.rock_wool.youngs_modulus=5e5"
    shown = CliRunner().invoke(
        command, ["simulate", str(path), "-d", "300", "--sample-period", "300", "--set", wool, "--json"]
    )
    assert shown.exit_code == 0, shown.output
    found = json.loads(shown.stdout)
    assert found["utilisation"]["share"] > 0.0
    assert [r["name"] for r in found["support_forces"]][-1] == "lock at 0 m"


def test_a_leaf_that_finds_no_balance_stops_the_run_and_gets_no_class(monkeypatch):
    monkeypatch.setattr(yielding, "MOST_PASSES", 2)
    scene = load_scene(
        door(
            **QUICK,
            deformation={
                "model": "shell", "in_plane": [6, 12], "interval": 60.0, "yielding": "layered",
            },
        ),
        {"materials.rock_wool.youngs_modulus": 5e5},
    )  # fmt: skip
    run = simulate(scene, 600.0, 60.0)
    assert not run.status.ok and "found no balance" in run.status.reason
    assert run.verdict.startswith("no class: no shape at ")
    assert 0 < len(run.time) == len(run.bow) == len(run.temperature) < 11
    assert np.isfinite(run.deflection).all()
    with pytest.raises(Unsettled):
        Deformation(run.model).solve(600.0 - 560.0 * run.nodes[:, 2] / 0.06)


def test_strengths_are_a_scenes_or_eurocodes():
    """A number is the strength at 20 °C and falls for steel; a table is taken as it is."""
    steel = door(materials=door()["materials"] | {"steel": {"yield_strength": 355e6}})
    assert float(yield_strength("steel", load_scene(steel))(600.0)) == pytest.approx(0.47 * 355e6)
    assert float(yield_strength("steel", load_scene(door()))(20.0)) == 235e6
    assert yield_strength("rock_wool", load_scene(door())) is None
    given = {"temperature": [20, 500], "value": [3e8, 1e8]}
    own = load_scene(door(materials=door()["materials"] | {"steel": {"yield_strength": given}}))
    assert float(yield_strength("steel", own)(260.0)) == pytest.approx(2e8)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"deformation.model": "solid", "deformation.yielding": "layered"}, "give model: shell"),
        ({"materials.rock_wool.yield_strength": -1.0}, "is negative"),
    ],
)
def test_what_cant_yield_is_refused(changes, said):
    with pytest.raises(SceneError, match=said):
        load_scene(door(deformation={"model": "shell"}), changes)


def test_layers_without_a_strength_cannot_yield():
    """Asked to yield, a leaf none of whose materials can would be elastic in silence."""
    sheet = [{"material": "plain", "thickness": 0.01}]
    elastic = {"plain": {"youngs_modulus": MODULUS}}
    with pytest.raises(SceneError, match=r"deformation\.yielding: is layered, and no material"):
        leaf(elastic, sheet)
    leaf(elastic, sheet, yielding="none")
