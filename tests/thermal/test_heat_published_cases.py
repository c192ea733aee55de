"""More published cases: columns heated on all sides, fluxes, the conduction cases of FDS, NAFEMS T2 and T4.

SFPE S.02 is the SFPE standard on calculation methods to predict the thermal performance of structures; FDS'
verification guide holds cases of it and its own heat_conduction_a to d.
"""

import numpy as np
import pytest
from door_scenes import slab
from scipy.optimize import brentq

from thermal_node import Heat, door_model, load_scene, simulate
from thermal_node.burning.steady import steady_state

ADIABATIC = {"film_coefficient": 0.0, "emissivity": 0.0}


def column(side, stuff, bricks, **changes):
    """A square column, heated on its four sides; half of it is solved."""
    scene = slab(side, stuff, 2 * bricks)
    scene["leaf"]["width"] = side
    scene["mesh"] = {"in_plane": [bricks, 2], "layers": [2 * bricks], "first_brick": side / 100.0}
    scene["solver"] = {"model": "column_rim", "tolerance": 0.1}
    half = 0.5 * side
    scene["probes"] = {
        "sets": [],
        "points": {"centre": {"z": half}, "side": {"z": 0.0}, "corner": {"x": half, "z": 0.0}},
    }
    return {**scene, **changes}


def test_plate_under_an_incident_flux_sfpe_2():
    """50 kW/m2 of which 0.9 enters; it radiates back to nothing at all."""
    scene = slab(
        0.01,
        {"density": 7850.0, "specific_heat": 560.0, "conductivity": 500.0},
        2,
        furnace={"curve": "constant", "temperature": 20.0, "radiation": {"incident_flux": 50e3}},
        exposed={"film_coefficient": 12.0, "emissivity": 0.9},
        unexposed=ADIABATIC,
    )
    run = simulate(load_scene(scene), 900.0, 180.0)
    expected = [195.0, 347.3, 466.2, 547.5, 596.6]
    np.testing.assert_allclose(run.temperature[1:].mean(axis=1), expected, atol=1.0)
    assert run.balance.worst < 1e-6


def test_column_that_cools_on_four_sides_sfpe_6():
    gas = {"film_coefficient": 1.0, "emissivity": 0.0, "gas": "furnace"}
    scene = column(
        2.0,
        {"density": 1.0, "specific_heat": 1.0, "conductivity": 1.0},
        20,
        furnace={"curve": "constant", "temperature": 0.0},
        exposed=gas,
        unexposed=gas,
        lateral=gas,
        ambient=0.0,
        initial=1000.0,
    )
    run = simulate(load_scene(scene), 1.0, 0.1)
    expected = [986.26, 903.72, 690.48, 515.06, 383.19, 285.01]
    np.testing.assert_allclose(run.probes["centre"][[1, 2, 4, 6, 8, 10]], expected, atol=1.0)


FALLING = {"temperature": [0, 200, 1000], "value": [1.5, 0.7, 0.5], "beyond": "hold"}
MOIST = {"temperature": [99.9, 100.0, 120.0], "value": [1089.0, 5790.0, 1000.0], "beyond": "hold"}


COLUMNS = {
    "constant_sfpe_7": (1.0, 1000.0, 0.0),
    "falling_conductivity_sfpe_8": (FALLING, 1000.0, 0.0),
    "moist_sfpe_13": (FALLING, MOIST, 20.0),
}
"""Conductivity, specific heat, and the start and first gas temperature of three columns of 0.2 m."""
PRINTED = {
    "constant_sfpe_7": [
        [10.6, 720.9, 808.5], [129.6, 872.7, 920.9], [316, 952, 984],
        [493, 1005, 1028], [640, 1045, 1061], [757, 1077, 1089],
    ],
    "falling_conductivity_sfpe_8": [
        [19.6, 743, 814], [100.7, 884, 923], [191.1, 958, 985],
        [301.1, 1008, 1028], [411.6, 1046, 1062], [511.9, 1077, 1089],
    ],
    "moist_sfpe_13": [
        [31, 764, 835], [85, 904, 943], [147, 978, 1005],
        [272, 1028, 1048], [393, 1066, 1082], [500, 1097, 1109],
    ],
}  # fmt: skip
"""Centre, middle of a side and corner, °C, every half hour; most to whole degrees."""


@pytest.fixture(scope="module")
def burnt():
    """The three columns in the standard fire: probes (6, 3)."""
    gas = {"film_coefficient": 10.0, "emissivity": 0.8, "gas": "furnace"}
    t = np.concatenate([np.linspace(0.0, 300.0, 301), np.linspace(310.0, 10800.0, 1050)])
    found = {}
    for name, (conductivity, specific_heat, start) in COLUMNS.items():
        curve = {"curve": "table", "time": t, "temperature": start + 345.0 * np.log10(8.0 * t / 60.0 + 1.0)}
        scene = column(
            0.2,
            {"density": 2400.0, "specific_heat": specific_heat, "conductivity": conductivity},
            30,
            furnace=curve,
            exposed=gas,
            unexposed=gas,
            lateral=gas,
            ambient=start,
        )
        run = simulate(load_scene(scene), 10800.0, 1800.0)
        assert run.balance.worst < 1e-6
        found[name] = np.stack([run.probes[at][1:] for at in ("centre", "side", "corner")], axis=1)
    return found


def test_moist_column_in_a_standard_fire_sfpe_13(burnt):
    """Printed to whole degrees; with finer bricks still 1.0 K from them."""
    np.testing.assert_allclose(burnt["moist_sfpe_13"], PRINTED["moist_sfpe_13"], atol=1.0)


@pytest.mark.parametrize("name", ["constant_sfpe_7", "falling_conductivity_sfpe_8"])
def test_columns_in_a_standard_fire_sfpe_7_and_8(burnt, name):
    """Sides within 1 K; corners at half an hour 1.2 K above and centres in the first hour 3.0 K below what is
    printed, by ours on any mesh and by the program below alike: printed values lag as those of long implicit
    steps do."""
    off = np.abs(burnt[name] - PRINTED[name])
    assert off[:, 1].max() < 1.0
    assert off[1:, 2].max() < 1.0
    assert off[0, 2] < 1.3
    assert off[:, 0].max() < 3.1


@pytest.mark.parametrize("name", ["constant_sfpe_7", "falling_conductivity_sfpe_8"])
def test_columns_in_a_standard_fire_by_another_program(burnt, name):
    conductivity = COLUMNS[name][0]
    if isinstance(conductivity, dict):
        knots, values = conductivity["temperature"], conductivity["value"]
    else:
        knots, values = [0.0, 1.0], [conductivity] * 2
    exact = explicit_column(lambda t: np.interp(t, knots, values))
    np.testing.assert_allclose(burnt[name], exact, atol=0.5)


def explicit_column(conductivity, side=0.2, rho_c=2.4e6, bricks=28):
    """A quarter of a column from 0 °C by explicit finite differences: centre, side, corner each half hour."""
    d = 0.5 * side / bricks
    share = np.ones(bricks + 1)
    share[[0, -1]] = 0.5
    capacity = np.outer(share, share) * d * d * rho_c
    t = np.zeros((bricks + 1, bricks + 1))
    steps = int(np.ceil(1800.0 / (0.2 * d * d * rho_c / 1.5)))
    step, found = 1800.0 / steps, []
    for n in range(6 * steps):
        gas = 345.0 * np.log10(8.0 * (n + 0.5) * step / 60.0 + 1.0)
        flow = np.zeros_like(t)
        for u, f in ((t, flow), (t.T, flow.T)):
            q = conductivity(0.5 * (u[1:] + u[:-1])) * (u[1:] - u[:-1]) * share
            f[:-1] += q
            f[1:] -= q
            absolute = u[-1] + 273.15
            radiated = 0.8 * 5.670374419e-8 * ((gas + 273.15) ** 4 - absolute**4)
            f[-1] += (10.0 * (gas - u[-1]) + radiated) * share * d
        t += step * flow / capacity
        if (n + 1) % steps == 0:
            found.append((t[0, 0], t[-1, 0], t[-1, -1]))
    return np.array(found)


def series(place, time, thickness, k, rho_c, h, start, gas):
    """Slab heated on one side, insulated at place 0: Carslaw and Jaeger, 3.11 (12)."""
    biot, fourier = h * thickness / k, k / rho_c * time / thickness**2
    total = 0.0
    for n in range(200):
        z = brentq(lambda b: b * np.sin(b) - biot * np.cos(b), n * np.pi + 1e-12, (n + 0.5) * np.pi)
        weight = 4.0 * np.sin(z) / (2.0 * z + np.sin(2.0 * z))
        total += weight * np.exp(-(z**2) * fourier) * np.cos(z * place / thickness)
    return gas + (start - gas) * total


@pytest.mark.parametrize(
    ("k", "density", "h", "times", "printed"),
    [
        (0.1, 100.0, 100.0, (100.0, 1000.0), {}),
        (0.1, 100.0, 10.0, (400.0, 2000.0), {400.0: (94.46, 20.03), 2000.0: (107.75, 37.07)}),
        (1.0, 1000.0, 10.0, (1000.0, 10000.0), {1000.0: (47.64, 20.69), 10000.0: (85.18, 66.61)}),
        (10.0, 10000.0, 10.0, (5000.0, 50000.0), {}),
    ],
    ids="abcd",
)
def test_slab_heated_on_one_side_fds_heat_conduction(k, density, h, times, printed):
    """0.1 m from 20 °C in gas at 120 °C; Biot numbers 100, 10, 1 and 0.1."""
    scene = slab(
        0.1,
        {"density": density, "specific_heat": 1000.0, "conductivity": k},
        40,
        furnace={"curve": "constant", "temperature": 120.0},
        exposed={"film_coefficient": h, "emissivity": 0.0},
        unexposed=ADIABATIC,
        solver={"model": "column", "tolerance": 0.01},
    )
    heat = Heat(door_model(load_scene(scene)))
    for time in times:
        assert heat.advance(time).ok
        found = heat.temperature[[0, -1]]
        exact = [series(x, time, 0.1, k, 1000.0 * density, h, 20.0, 120.0) for x in (0.1, 0.0)]
        np.testing.assert_allclose(found, exact, atol=0.1)
        if time in printed:
            np.testing.assert_allclose(found, printed[time], atol=0.1)


def test_conductivity_and_heat_that_vary_fds_heat_conduction_kc():
    """Held against a converged solution; FDS' own differs from it by 1.4 K."""
    scene = slab(
        0.01,
        {
            "density": 1.0e4,
            "specific_heat": {"temperature": [0, 100, 200], "value": [1000, 1200, 1000], "beyond": "hold"},
            "conductivity": {"temperature": [0, 200], "value": [0.1, 0.2], "beyond": "hold"},
        },
        40,
        furnace={"curve": "constant", "temperature": 700.0},
        exposed={"film_coefficient": 10.0, "emissivity": 0.0},
        unexposed=ADIABATIC,
        ambient=0.0,
        solver={"model": "column", "tolerance": 0.01},
    )
    run = simulate(load_scene(scene), 1000.0, 100.0)
    np.testing.assert_allclose(run.temperature[[1, 5, 10], 0], [65.11, 123.21, 158.68], atol=0.1)
    assert run.temperature[10, -1] == pytest.approx(5.725, abs=0.1)


def test_bar_that_radiates_from_its_end_nafems_t2():
    scene = slab(
        0.1,
        {"density": 7850.0, "specific_heat": 460.0, "conductivity": 55.6},
        10,
        furnace={"curve": "constant", "temperature": 1000.0 - 273.15},
        unexposed={"film_coefficient": 0.0, "emissivity": 0.98},
        ambient=300.0 - 273.15,
        solver={"model": "steady", "of": "column"},
    )
    run = simulate(load_scene(scene), 3600.0)
    assert run.temperature[-1, -1] + 273.15 == pytest.approx(927.00, abs=0.01)


def test_plate_with_a_jump_at_its_corner_nafems_t4():
    """0.6 x 1 m, 100 °C below, insulated at the left, h 750 to 0 °C at the right and above: (0.6, 0.2)."""
    cold = {"film_coefficient": 750.0, "emissivity": 0.0}
    scene = slab(
        1.0,
        {"density": 7850.0, "specific_heat": 460.0, "conductivity": 52.0},
        60,
        furnace={"curve": "constant", "temperature": 100.0},
        unexposed=cold,
        lateral=cold,
        ambient=0.0,
        mesh={"in_plane": [40, 2], "layers": [60], "first_brick": 0.005},
        solver={"model": "steady", "of": "column_rim"},
        probes={"sets": [], "points": {"target": {"x": 0.6, "z": 0.2}}},
    )
    scene["leaf"]["width"] = 1.2
    run = simulate(load_scene(scene), 3600.0)
    assert run.probes["target"][-1] == pytest.approx(18.253, abs=0.02)


def test_heat_through_an_insulated_steel_plate():
    """460 K over 1/10 + 0.02/0.2 + 0.01/50 + 0.02/0.2 + 1/10 m2 K/W: 1149.4 W/m2."""
    scene = slab(
        0.02,
        {"density": 100.0, "specific_heat": 1000.0, "conductivity": 0.2},
        2,
        furnace={"curve": "constant", "temperature": 480.0},
        exposed={"film_coefficient": 10.0, "emissivity": 0.0, "held": False},
        unexposed={"film_coefficient": 10.0, "emissivity": 0.0},
        mesh={"layers": [2, 1, 2]},
        solver={"model": "steady", "of": "column"},
    )
    scene["materials"]["metal"] = {"density": 7850.0, "specific_heat": 460.0, "conductivity": 50.0}
    wool = scene["leaf"]["layers"][0]
    scene["leaf"]["layers"] = [wool, {"material": "metal", "thickness": 0.01}, wool]
    heat = steady_state(door_model(load_scene(scene)), 3600.0)
    assert heat.status.ok
    assert heat.heat_flow()[0] == pytest.approx(1149.4, abs=0.05)
    assert heat.heat_flow()[1] == pytest.approx(-1149.4, abs=0.05)
