"""Published cases that no code of ours produced: the solver is right about other people's physics.

SFPE S.02 cases 1, 2 and 9 and the back wall are those of FDS' verification guide; NAFEMS T3 is
of "The standard NAFEMS benchmarks".
"""

import numpy as np
from door_scenes import slab

from thermal_node import load_scene, simulate

ADIABATIC = {"film_coefficient": 0.0, "emissivity": 0.0}


def test_steel_plate_heated_on_both_sides_sfpe_1():
    both = {"film_coefficient": 25.0, "emissivity": 0.7, "gas": "furnace"}
    scene = slab(
        0.04,
        {"density": 7850.0, "specific_heat": 520.0, "conductivity": 500.0},
        4,
        furnace={"curve": "iso_834"},
        exposed=both,
        unexposed=both,
    )
    run = simulate(load_scene(scene), 1800.0, 300.0)
    mean = run.temperature[1:].mean(axis=1)
    expected = [97.8, 234.4, 390.2, 539.7, 662.9, 751.9]
    np.testing.assert_allclose(mean, expected, atol=0.5)


def test_cooling_slab_sfpe_2():
    scene = slab(
        1.0,
        {"density": 1000.0, "specific_heat": 1.0, "conductivity": 1.0},
        40,
        furnace={"curve": "constant", "temperature": 0.0},
        exposed={"film_coefficient": 1.0, "emissivity": 0.0},
        unexposed=ADIABATIC,
        ambient=0.0,
        initial=1000.0,
    )
    run = simulate(load_scene(scene), 1800.0, 60.0)
    back = run.temperature[:, -1]
    at = [1, 5, 10, 15, 20, 25, 30]
    expected = [999.3, 891.8, 717.7, 574.9, 460.4, 368.7, 295.3]
    np.testing.assert_allclose(back[at], expected, atol=0.5)


def test_insulated_tube_with_its_real_half_millimetre_skin_sfpe_9():
    around = {"film_coefficient": 10.0, "emissivity": 0.8, "gas": "furnace"}
    metal = {
        "density": 7850.0,
        "specific_heat": 600.0,
        "conductivity": {
            "temperature": [0.0, 800.0],
            "value": [54.7, 27.3],
            "beyond": "hold",
        },
    }
    skin = {"material": "metal", "thickness": 0.0005}
    scene = {
        "model": "fire_door",
        "name": "tube",
        "leaf": {
            "height": 1.0,
            "width": 0.201,
            "layers": [skin, {"material": "insulation", "thickness": 0.2}, skin],
            "rim": skin,
        },
        "materials": {
            "metal": metal,
            "insulation": {"density": 50.0, "specific_heat": 1000.0, "conductivity": 0.05},
        },
        "furnace": {"curve": "constant", "temperature": 1000.0},
        "exposed": around,
        "unexposed": around,
        "lateral": around,
        "ambient": 0.0,
        "mesh": {"in_plane": [16, 2], "layers": [1, 24, 1], "symmetry": "quarter"},
        "solver": {"model": "column_rim"},
        "probes": {"points": {"middle": {"z": 0.1005}}},
    }
    run = simulate(load_scene(scene), 10800.0, 1800.0)
    expected = [341.0, 723.0, 886.0, 953.0, 981.0, 992.0]
    np.testing.assert_allclose(run.probes["middle"][1:], expected, atol=2.0)


def test_bar_with_a_swinging_end_nafems_t3():
    time = np.arange(0.0, 40.01, 0.05)
    scene = slab(
        0.1,
        {"density": 7200.0, "specific_heat": 440.5, "conductivity": 35.0},
        20,
        furnace={
            "curve": "measured",
            "time": time,
            "temperature": 100.0 * np.sin(np.pi * time / 40.0),
        },
        exposed={"gas": "ambient", "held": True},
        unexposed={"gas": "furnace", "held": True},
        ambient=0.0,
        probes={"points": {"target": {"z": 0.08}}},
        solver={"model": "column", "tolerance": 0.02},
    )
    run = simulate(load_scene(scene), 32.0, 32.0)
    assert abs(run.probes["target"][-1] - 36.60) < 0.1


def test_plate_between_two_gases_at_rest_fds_back_wall():
    scene = slab(
        0.01,
        {"density": 1000.0, "specific_heat": 1000.0, "conductivity": 10.0},
        4,
        furnace={"curve": "constant", "temperature": 200.0},
        exposed={"film_coefficient": 50.0, "emissivity": 0.5},
        unexposed={"film_coefficient": 10.0, "emissivity": 1.0},
        ambient=20.0,
    )
    run = simulate(load_scene(scene), 2000.0, 2000.0)
    assert abs(run.temperature[-1, 0] - 154.51) < 0.1
    assert abs(run.temperature[-1, -1] - 151.76) < 0.1
    scene["solver"] = {"model": "steady", "of": "column"}
    scene["exposed"] = {**scene["exposed"], "held": False}
    steady = simulate(load_scene(scene), 2000.0)
    np.testing.assert_allclose(steady.temperature[-1], run.temperature[-1], atol=0.01)
