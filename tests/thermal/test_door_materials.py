"""Materials and furnaces are the standards', and heat is their exact integral."""

import csv

import numpy as np
import pytest
from door_scenes import DATA

from thermal_node import Measured, load_scene
from thermal_node.furnace.burners import LumpedFurnace
from thermal_node.furnace.furnace import Curve, external, hydrocarbon, iso_834
from thermal_node.model.materials import (
    steel,
    steel_conductivity,
    steel_elongation,
    steel_enthalpy,
    steel_modulus_factor,
    steel_specific_heat,
    steel_yield_factor,
    table,
)
from thermal_node.scene.furnace_part import Burners

TABLE = DATA / "ec3_steel_table.csv"


def test_steel_is_eurocode_3():
    with TABLE.open() as file:
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)]
    t = np.array([row["T_C"] for row in rows])
    for name, function, tolerance in (
        ("c_J_kgK", steel_specific_heat, 1e-3),
        ("k_W_mK", steel_conductivity, 1e-3),
        ("elongation", steel_elongation, 1e-6),
        ("kE", steel_modulus_factor, 1e-3),
        ("ky", steel_yield_factor, 1e-3),
    ):
        expected = np.array([row[name] for row in rows])
        np.testing.assert_allclose(function(t), expected, rtol=tolerance, atol=tolerance * 0.1)


def test_the_peak_at_735_degrees():
    assert steel_specific_heat(735.0) == pytest.approx(5000.0)


def test_enthalpy_is_the_integral_of_the_specific_heat():
    t = np.linspace(20.0, 1150.0, 400_001)
    c = steel_specific_heat(t)
    summed = np.concatenate([[0.0], np.cumsum(0.5 * (c[1:] + c[:-1]) * np.diff(t))])
    np.testing.assert_allclose(steel_enthalpy(t), summed, rtol=2e-6, atol=1e-3)
    # And the knots that the solver interpolates between lose none of it.
    curve = steel().specific_heat
    np.testing.assert_allclose(curve.integrated(t), steel_enthalpy(t), rtol=2e-6, atol=0.02)


def test_a_table_is_integrated_exactly_and_continued_as_it_says():
    t, k = [10.0, 100.0, 300.0], [0.035, 0.043, 0.073]
    curve = table(t, k, "refuse")
    assert curve.integrated(300.0) == pytest.approx(90 * 0.039 + 200 * 0.058)
    assert curve.refuse_above == 300.0
    assert table(t, k, "hold")(900.0) == pytest.approx(0.073)
    assert table(t, k, "extend")(600.0) == pytest.approx(0.073 + 300 * 0.00015)
    assert curve(-40.0) == pytest.approx(0.035)


def test_curves_of_eurocode_1():
    assert iso_834(0.0) == 20.0
    assert iso_834(3600.0) == pytest.approx(945.34, abs=0.01)
    assert hydrocarbon(0.0) == pytest.approx(20.0)
    assert hydrocarbon(7200.0) == pytest.approx(1100.0, abs=0.1)
    assert external(7200.0) == pytest.approx(680.0, abs=0.1)


def test_a_lumped_furnace_follows_its_curve_within_the_standards_tolerance():
    from thermal_node import FurnaceTolerance

    furnace = LumpedFurnace(Curve(iso_834), Burners())
    tolerance = FurnaceTolerance()
    for t in range(0, 3601, 10):
        assert tolerance.watch(float(t), float(iso_834(t)), furnace.thermocouples(float(t)))
    four = furnace.thermocouples(1800.0)
    assert len(four) == 4
    assert four.max() - four.min() > 10.0  # it is a furnace, not the formula
    assert furnace(1800.0) != pytest.approx(float(iso_834(1800.0)), abs=1e-3)


def test_a_furnace_that_lags_behind_is_reported():
    from thermal_node import FurnaceTolerance

    tolerance = FurnaceTolerance()
    for t in range(0, 1801, 30):
        tolerance.watch(float(t), float(iso_834(t)), np.array([float(iso_834(t)) * 0.8]))
    assert "area under the furnace's curve" in tolerance.broken


def test_a_live_log_takes_only_what_it_can_use():
    log = Measured()
    assert log.add(0.0, 20.0)
    assert log.add(10.0, 120.0)
    assert not log.add(10.0, 130.0)
    assert not log.add(20.0, float("nan"))
    assert log(5.0) == pytest.approx(70.0)
    assert log(40.0) == 120.0
    assert log.stale == pytest.approx(30.0)


def test_a_scene_can_change_one_property_of_steel():
    from door_scenes import door

    from thermal_node.model.door_model import material_of

    scene = load_scene(door(), {"materials.steel.density": 7850.0})
    changed = material_of("steel", scene)
    assert changed.density == 7850.0
    assert changed.specific_heat(735.0) == pytest.approx(5000.0)
