"""The observed orders of accuracy are those that theory promises."""

import numpy as np
from door_scenes import slab

from thermal_node import Heat, door_model, load_scene

WALL = {
    "density": 500.0,
    "specific_heat": 900.0,
    "conductivity": {"temperature": [0.0, 400.0], "value": [0.5, 1.5], "beyond": "hold"},
}


def wall(bricks, solver, duration):
    """A wall in a gas that warms smoothly, so that nothing but the method limits the order."""
    time = np.linspace(0.0, 4000.0, 4001)
    scene = slab(
        0.1,
        WALL,
        bricks,
        furnace={
            "curve": "measured",
            "time": time,
            "temperature": 20.0 + 300.0 * np.sin(np.pi * time / 8000.0) ** 2,
        },
        exposed={"film_coefficient": 30.0, "emissivity": 0.5},
        unexposed={"film_coefficient": 8.0, "emissivity": 0.3},
        solver={"model": "column", **solver},
    )
    heat = Heat(door_model(load_scene(scene)))
    assert heat.advance(duration).ok
    return heat.temperature[[0, -1]]


def observed(errors):
    return np.log2(errors[:-1] / errors[1:])


def time_errors(method):
    exact = wall(20, {"method": "tr_bdf2", "step": 1.0}, 2400.0)
    steps = [120.0, 60.0, 30.0]
    found = [wall(20, {"method": method, "step": s}, 2400.0) for s in steps]
    return np.array([np.abs(f - exact).max() for f in found])


def test_second_order_in_time():
    for method in ("tr_bdf2", "sdirk2"):
        order = observed(time_errors(method))
        assert np.all(order > 1.8), (method, order)


def test_implicit_euler_is_first_order():
    order = observed(time_errors("implicit_euler"))
    assert np.all((order > 0.85) & (order < 1.2)), order


def test_second_order_in_space():
    solver = {"method": "tr_bdf2", "step": 10.0}
    exact = wall(320, solver, 2400.0)
    errors = np.array([np.abs(wall(n, solver, 2400.0) - exact).max() for n in (10, 20, 40)])
    order = observed(errors)
    assert np.all(order > 1.8), (order, errors)


def test_the_adaptive_march_keeps_its_tolerance():
    exact = wall(20, {"step": 1.0}, 2400.0)
    errors = []
    for tolerance in (0.1, 0.01):
        errors.append(np.abs(wall(20, {"tolerance": tolerance}, 2400.0) - exact).max())
    assert errors[0] < 0.5
    assert errors[1] < 0.1
    assert errors[1] < errors[0]
