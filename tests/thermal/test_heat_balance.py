"""No heat is lost or made, in any step: not at steel's 735 °C peak, not with long steps."""

import numpy as np
import pytest
from door_scenes import door, slab

from thermal_node import Heat, door_model, load_scene


@pytest.mark.parametrize("step", [0.1, 1.0, 10.0, 60.0])
@pytest.mark.parametrize("method", ["tr_bdf2", "sdirk2", "implicit_euler"])
def test_every_step_of_a_column_through_the_peak(step, method):
    scene = door(solver={"model": "column", "step": step, "method": method})
    heat = Heat(door_model(load_scene(scene)))
    duration = 1500.0 if step >= 1.0 else 150.0
    if step < 1.0:  # start just below the peak
        heat.temperature[:] = 725.0
        heat.restore(heat.save())
        heat.time = 1200.0
        duration = 1350.0
    assert heat.advance(duration).ok
    assert heat.temperature[0] > 740.0
    assert heat.balance.worst < 1e-6
    assert heat.balance.relative < 1e-6


@pytest.mark.parametrize("step", ["auto", 60.0])
def test_every_step_of_the_full_door(step):
    scene = door(mesh={"in_plane": [6, 8], "layers": [1, 6, 1]}, solver={"step": step})
    heat = Heat(door_model(load_scene(scene)))
    assert heat.advance(3600.0).ok
    assert heat.balance.worst < 1e-6


def test_stored_heat_is_the_closed_form_of_eurocode_3():
    scene = door(solver={"model": "column"})
    model = door_model(load_scene(scene))
    heat = Heat(model)
    heat.advance(2400.0)
    volume = model.mesh.volume.reshape(len(model.materials), -1)
    stored = sum(
        float(v @ (m.enthalpy(heat.temperature) - m.enthalpy(20.0)))
        for m, v in zip(model.materials, volume, strict=True)
    )
    assert abs(stored - heat.balance.stored) < 1e-6 * stored


def test_nothing_is_colder_than_its_surroundings_however_coarse():
    scene = door(mesh={"layers": [1, 6, 1]}, solver={"model": "column"})
    scene["leaf"]["layers"][0]["thickness"] = 0.0001
    scene["leaf"]["layers"][1]["thickness"] = 0.2
    heat = Heat(door_model(load_scene(scene)))
    for time in (0.5, 1.0, 5.0, 30.0, 120.0, 600.0):
        heat.advance(time)
        assert heat.temperature.min() > 20.0 - 1e-6
        assert np.all(np.diff(heat.temperature) <= 1e-6)


@pytest.mark.parametrize(("thickness", "conductivity", "bricks"), [(0.01, 1.0, 4), (0.002, 50.0, 1)])
@pytest.mark.parametrize(
    "furnace",
    [
        {"curve": "constant", "temperature": 500.0},
        {
            "curve": "parametric",
            "parametric": {"opening_factor": 0.04, "absorptivity": 1160.0, "fire_load": 200.0},
        },
    ],
    ids=["as_hot_as_the_gas", "cold_again"],
)
def test_a_leaf_that_has_come_to_rest_goes_on_resting(furnace, thickness, conductivity, bricks):
    """Nothing crosses any more, and rounding of what is stored is neither heat nor a failure.

    In thin metal rounding of what its nodes conduct to each other remains: the march goes on, and the
    balance is asked of the slab only.
    """
    stuff = {"density": 1000.0, "specific_heat": 1000.0, "conductivity": conductivity}
    scene = slab(thickness, stuff, bricks, furnace=furnace, unexposed={"film_coefficient": 0.0})
    heat = Heat(door_model(load_scene(scene)))
    assert heat.advance(50000.0).ok
    assert abs(heat.temperature[0] - heat.furnace(50000.0)) < 1e-6
    if conductivity < 10.0:
        assert heat.balance.worst < 1e-6
