"""What heats a door: curves at the points that their standards print, natural fires, radiation, fluxes."""

import numpy as np
import pytest
from door_scenes import slab

from thermal_node import Heat, door_model, load_scene, simulate
from thermal_node.furnace.furnace import CURVES
from thermal_node.furnace.parametric import ParametricFire
from thermal_node.scene.load import SceneError

STUFF = {"density": 1000.0, "specific_heat": 1000.0, "conductivity": 1.0}
NOTHING = {"film_coefficient": 0.0, "emissivity": 0.0}
ROOM = {"opening_factor": 0.04, "absorptivity": 1160.0, "fire_load": 200.0}


@pytest.mark.parametrize(
    ("curve", "minutes", "printed"),
    [
        # EN 1363-1 5.1.1, whole degrees
        ("iso_834", [5, 10, 15, 30, 45, 60, 90, 120, 240], [576, 678, 739, 842, 902, 945, 1006, 1049, 1153]),
        # ASTM E119, 7.1: 1000, 1300, 1550, 1700, 1850, 2000 and 2300 °F
        ("astm_e119", [5, 10, 30, 60, 120, 240, 480], [538, 704, 843, 927, 1010, 1093, 1260]),
        # UL 1709: 2000 °F within 5 min and held
        ("ul_1709", [5, 30, 240], [1093, 1093, 1093]),
        # EN 1363-2, hydrocarbon
        ("hydrocarbon", [5, 10, 15, 30, 60], [948, 1034, 1071, 1098, 1100]),
        # Efectis-R0695
        ("rws", [0, 3, 5, 10, 30, 60, 90, 120], [20, 890, 1140, 1200, 1300, 1350, 1300, 1200]),
        # EN 1363-2 clause 6: 154 t^0.25 + 20 to 21 min, then ISO 834 at t - 20
        ("slow_heating", [0, 1, 16, 80], [20, 174, 328, 945]),
    ],
)
def test_a_curve_goes_through_the_points_that_its_standard_prints(curve, minutes, printed):
    np.testing.assert_allclose(CURVES[curve](60.0 * np.array(minutes)), printed, atol=0.6)


def test_slow_heating_goes_over_into_the_standard_curve_without_a_jump():
    before, after = CURVES["slow_heating"](np.array([1260.0, 1260.001]))
    assert abs(after - before) < 0.6


@pytest.mark.parametrize(
    ("opening", "at_10_to_70_minutes"),
    [
        (72.0, [689.1, 782.7, 167.4, 20, 20, 20, 20]),
        (50.4, [689.1, 782.7, 402.5, 20, 20, 20, 20]),
        (32.4, [844.0, 946.9, 781.2, 540.9, 304.3, 69.5, 20]),
        (21.6, [741.3, 827.5, 885.7, 818.9, 692.3, 565.8, 441.1]),
        (14.4, [601.4, 726.8, 777.5, 813.3, 843.5, 780.4, 719.1]),
        (7.2, [269.3, 430.1, 533.1, 604.3, 651.3, 685.2, 709.8]),
    ],
)
def test_natural_fires_of_the_eurocodes_handbook(opening, at_10_to_70_minutes):
    """Holicky et al., Implementation of Eurocodes, handbook 5 (2005), figure 7: 100 m2 floor, 360 m2 around
    it, 600 MJ/m2, b 1500, medium growth; it draws them from the tenth minute on, and reads to 10 K."""
    fire = ParametricFire(opening / 360.0, 1500.0, 600.0 * 100.0 / 360.0, "medium")
    np.testing.assert_allclose(fire.at(600.0 * np.arange(1, 8)), at_10_to_70_minutes, atol=10.0)


def test_a_natural_fire_of_unit_expansion_is_nearly_the_standard_fire():
    """EN 1991-1-2 A (3), note: where Gamma is 1, (A.1) approximates the standard curve."""
    fire = ParametricFire(0.04, 1160.0, 1000.0)
    t = np.arange(600.0, 7201.0, 600.0)
    assert fire.expansion == pytest.approx(1.0)
    np.testing.assert_allclose(fire.at(t), CURVES["iso_834"](t), atol=25.0)


@pytest.mark.parametrize(("load", "per_hour"), [(80.0, 625.0), (200.0, 500.0), (600.0, 250.0)])
def test_a_natural_fire_cools_at_the_rate_of_its_duration(load, per_hour):
    """(A.11) with Gamma 1: 625, 250 (3 - t*max), 250 K an hour for t*max of 0.4, 1 and 3 h."""
    fire = ParametricFire(0.04, 1160.0, load, "fast")
    t = 3600.0 * fire.hottest_time
    assert fire(t) == pytest.approx(fire.hottest, abs=1e-9)
    assert fire(t) - fire(t + 360.0) == pytest.approx(0.1 * per_hour, abs=1e-9)
    assert fire(1e6) == 20.0


def test_few_goods_behind_large_openings_burn_by_their_own_pace():
    """(A.8) to (A.10): Gamma_lim with its factor k, Theta_max at t_lim; cooling counts with Gamma."""
    fire = ParametricFire(0.06, 580.0, 60.0, "slow")
    limit = 25.0 / 60.0
    k = 1.0 + 0.5 * (60.0 - 75.0) / 75.0 * 0.5
    gamma = k * (0.1e-3 * 60.0 / limit / 580.0 / (0.04 / 1160.0)) ** 2
    t = limit * gamma
    hottest = 20 + 1325 * (1 - 0.324 * np.exp(-0.2 * t) - 0.204 * np.exp(-1.7 * t) - 0.472 * np.exp(-19 * t))
    assert fire.fuel_controlled
    assert fire(1500.0) == pytest.approx(hottest, abs=1e-9)
    # Gamma is 9 and t*max 0.2e-3 * 60 / 0.06 * 9 = 1.8 h, between the two bounds of (A.11).
    assert fire(1500.0) - fire(1500.0 + 36.0) == pytest.approx(250.0 * (3.0 - 1.8) * 9.0 * 0.01, abs=1e-9)


def test_a_leaf_cools_with_a_natural_fire_and_its_heat_is_balanced():
    scene = slab(
        0.05,
        STUFF,
        10,
        furnace={"curve": "parametric", "parametric": ROOM},
        solver={"model": "column", "tolerance": 0.1},
    )
    heat = Heat(door_model(load_scene(scene)))
    assert heat.model.surface.film[0] == 35.0  # EN 1991-1-2 3.3.1.1 (3)
    heat.advance(3600.0)
    hot = heat.temperature[0]
    assert heat.advance(12000.0).ok
    assert heat.furnace(12000.0) == 20.0
    assert heat.temperature[0] < 0.2 * hot
    assert heat.balance.worst < 1e-6


def test_a_table_needs_no_values_each_minute_and_is_not_outlasted():
    scene = slab(
        0.01,
        STUFF,
        4,
        furnace={"curve": "table", "time": [0, 600, 3600], "temperature": [20, 800, 500]},
    )
    run = simulate(load_scene(scene), 1200.0, 300.0)
    np.testing.assert_allclose(run.furnace, [20.0, 410.0, 800.0, 770.0, 740.0])
    with pytest.raises(SceneError, match=r"furnace: its table ends at 3600 s"):
        simulate(load_scene(scene), 3601.0, 300.0)


def test_gas_and_radiation_of_two_temperatures():
    """A thin plate at rest between a gas and walls: h (Tg - T) + e sigma (Tr^4 - T^4) = 0."""
    scene = slab(
        0.002,
        {**STUFF, "conductivity": 50.0},
        1,
        furnace={"curve": "constant", "temperature": 300.0, "radiation": {"temperature": 800.0}},
        exposed={"film_coefficient": 25.0, "emissivity": 0.7},
        unexposed=NOTHING,
        solver={"model": "column", "tolerance": 0.3},
    )
    heat = Heat(door_model(load_scene(scene)))
    assert heat.advance(7200.0).ok
    t = heat.temperature[0] + 273.15
    convected, radiated = 25.0 * (573.15 - t), 0.7 * 5.670374419e-8 * (1073.15**4 - t**4)
    assert radiated > 5e3
    assert abs(convected + radiated) < 1e-4 * radiated
    assert heat.balance.worst < 1e-6


def test_a_flux_over_time_is_all_that_a_plate_gains():
    """Triangle of 20 kW/m2 and 600 s: 6 MJ/m2 into 20 kJ/(m2 K), 300 K; the balance has it all."""
    scene = slab(
        0.02,
        {**STUFF, "conductivity": 50.0},
        4,
        exposed={**NOTHING, "flux": {"time": [0, 300, 600], "value": [0.0, 2.0e4, 0.0]}},
        unexposed=NOTHING,
        solver={"model": "column", "tolerance": 0.001},
    )
    run = simulate(load_scene(scene), 600.0, 600.0)
    assert run.temperature[-1].mean() == pytest.approx(320.0, abs=0.01)
    assert run.balance.exposed == pytest.approx(6.0e6, rel=1e-4)
    assert run.balance.worst < 1e-6


def test_a_flux_at_rest_goes_through():
    """q = h (Tb - Ta) and q = k (Tf - Tb) / L."""
    scene = slab(
        0.05,
        STUFF,
        4,
        exposed={**NOTHING, "flux": 1000.0, "held": False},
        unexposed={"film_coefficient": 10.0},
        solver={"model": "steady", "of": "column"},
    )
    run = simulate(load_scene(scene), 3600.0)
    np.testing.assert_allclose(run.temperature[-1][[0, -1]], [170.0, 120.0], atol=1e-4)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"furnace": {"curve": "parametric"}}, "parametric.*is missing"),
        ({"furnace": {"parametric": ROOM}}, "give curve: parametric"),
        ({"furnace": {"curve": "parametric", "parametric": {**ROOM, "opening_factor": 0.3}}}, "0.2 m.0.5"),
        ({"furnace": {"curve": "parametric", "parametric": {**ROOM, "fire_load": 2000.0}}}, "MJ/m2"),
        ({"furnace": {"curve": "table", "time": [60, 120], "temperature": [20, 30]}}, "give 0 s"),
        ({"furnace": {"curve": "table", "time": [0, 120], "temperature": [20]}}, "one for each"),
        ({"furnace": {"curve": "table", "time": [0, 0], "temperature": [20, 30]}}, "increasing"),
        ({"furnace": {"curve": "table", "time": [0, 60], "temperature": [20, 9000]}}, "3000 °C"),
        ({"furnace": {"radiation": {}}}, "give temperature or incident_flux"),
        ({"furnace": {"radiation": {"incident_flux": -5.0}}}, "W/m2"),
        ({"furnace": {"radiation": {"temperature": [20, 30]}}}, "list without time"),
        ({"furnace": {"radiation": {"temperature": 500.0}}, "exposed": NOTHING}, "meets no surface"),
        ({"exposed": {"flux": 1e4, "held": True}}, "held"),
        ({"exposed": {"flux": 5e6}}, "W/m2"),
        ({"exposed": {"flux": 1e4}, "solver": {"model": "steady", "of": "column"}}, "held: false"),
    ],
)
def test_what_can_not_be_is_refused_with_its_place(changes, said):
    with pytest.raises(SceneError, match=said):
        load_scene(slab(0.01, STUFF, 2, **changes))
