"""Contacts between layers and cavities: what crosses them is the closed form, in every model."""

import numpy as np
import pytest
from door_scenes import door, slab
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from thermal_node import Heat, SceneError, door_model, load_scene, simulate
from thermal_node.burning.steady import steady_state

ADIABATIC = {"film_coefficient": 0.0, "emissivity": 0.0}
LEFT_ALONE = {
    "furnace": {"curve": "constant", "temperature": 20.0},
    "exposed": ADIABATIC,
    "unexposed": ADIABATIC,
}
SIGMA = 5.670374419e-8
METAL = {"density": 7800.0, "specific_heat": 500.0, "conductivity": 2000.0}
BOTH = pytest.mark.parametrize("discretisation", ["finite_volume", "finite_element"])


def two_sheets(between, discretisation="finite_volume", thickness=0.001, **changes):
    """Two sheets of well conducting metal; `between` : a contact's resistance or a cavity's keys."""
    scene = slab(0.001, METAL, 1, **changes)
    sheet = {"material": "stuff", "thickness": thickness}
    if isinstance(between, float):
        scene["leaf"]["layers"] = [sheet, {**sheet, "contact_resistance": between}]
        layers = [1, 1]
    else:
        scene["leaf"]["layers"] = [sheet, between, sheet]
        layers = [1, 1, 1]
    scene["mesh"] = {"layers": layers, "discretisation": discretisation, "in_plane": [3, 3]}
    scene.setdefault("solver", {"model": "column"})
    return scene


def halves_apart(scene, hot, cold):
    """A march that begins with the exposed half hot and the other cold."""
    heat = Heat(door_model(load_scene(scene)))
    half = len(heat.temperature) // 2
    heat.temperature[:half], heat.temperature[half:] = hot, cold
    heat.restore(heat.save())
    return heat


@BOTH
def test_a_contact_is_a_resistance_in_series(discretisation):
    scene = two_sheets(
        0.05,
        discretisation,
        furnace={"curve": "constant", "temperature": 500.0},
        exposed={"film_coefficient": 25.0, "emissivity": 0.0, "held": False},
        unexposed={"film_coefficient": 10.0, "emissivity": 0.0},
        solver={"model": "steady", "of": "column"},
    )
    heat = steady_state(door_model(load_scene(scene)), 3600.0)
    flow = 480.0 / (1 / 25 + 0.001 / 2000 + 0.05 + 0.001 / 2000 + 1 / 10)
    assert heat.heat_flow()[0] == pytest.approx(flow, rel=1e-7)
    assert heat.temperature[1] - heat.temperature[2] == pytest.approx(0.05 * flow, rel=1e-7)


@BOTH
def test_two_plates_settle_through_a_contact(discretisation):
    """Their difference falls as exp(-2 t / (R C))."""
    scene = two_sheets(
        0.2,
        discretisation,
        **LEFT_ALONE,
        solver={"model": "column", "tolerance": 1e-4},
    )
    heat = halves_apart(scene, 420.0, 20.0)
    decay = 2.0 / (0.2 * 0.001 * 7800.0 * 500.0)
    for time in (200.0, 500.0, 1000.0):
        assert heat.advance(time).ok
        difference = heat.temperature[1] - heat.temperature[2]
        assert difference == pytest.approx(400.0 * np.exp(-decay * time), rel=1e-3)
    assert heat.temperature.mean() == pytest.approx(220.0, abs=1e-4)


def test_contacts_leave_the_rim_whole():
    """The channel runs on past the contacts, which part the faces everywhere else."""
    scene = door(solver={"model": "column_rim"}, mesh={"in_plane": [8, 4], "layers": [1, 6, 1]})
    for layer in scene["leaf"]["layers"][1:]:
        layer["contact_resistance"] = 0.05
    run = simulate(load_scene(scene), 1800.0, 1800.0)
    assert run.status.ok
    assert run.balance.worst < 1e-6
    jump = run.temperature[-1].reshape(11, 9)[1] - run.temperature[-1].reshape(11, 9)[2]
    assert jump[0] > 20.0
    assert abs(jump[-1]) < 0.5


def air_conductivity(t):
    """U.S. Standard Atmosphere 1976, (53)."""
    kelvin = t + 273.15
    return 2.64638e-3 * kelvin**1.5 / (kelvin + 245.4 * 10.0 ** (-12.0 / kelvin))


def nusselt(rule, width, height, one, two):
    """EN 673 5.3.2; ElSherbiny, Raithby and Hollands 1982."""
    mean = 0.5 * (one + two) + 273.15
    viscosity = 1.458e-6 * mean**1.5 / (mean + 110.4)
    density = 101325.0 / (287.05287 * mean)
    grashof = 9.80665 * width**3 * abs(one - two) * density**2 / (mean * viscosity**2)
    rayleigh = grashof * viscosity * 1008.0 / air_conductivity(mean - 273.15)
    if rule == "en_673":
        return max(1.0, 0.035 * rayleigh**0.38)
    turbulent = 0.0605 * rayleigh ** (1 / 3)
    between = (1.0 + (0.104 * rayleigh**0.293 / (1.0 + (6310.0 / rayleigh) ** 1.36)) ** 3) ** (1 / 3)
    return max(turbulent, between, 0.242 * (rayleigh * width / height) ** 0.272)


def crossing(cavity, one, two, height=1.0):
    """W/m2 through a cavity between faces at one and two, °C."""
    first, second = cavity["emissivity"]
    e = 1.0 / (1.0 / first + 1.0 / second - 1.0)
    width, rule = cavity["cavity"], cavity.get("convection", "en_673")
    q = e * SIGMA * ((one + 273.15) ** 4 - (two + 273.15) ** 4)
    q += quad(air_conductivity, two, one)[0] / width
    if rule != "still":
        more = nusselt(rule, width, height, one, two) - 1.0
        q += more * air_conductivity(0.5 * (one + two)) * (one - two) / width
    return q


CAVITIES = [
    {"cavity": 0.02, "emissivity": [0.8, 0.6], "convection": "still"},
    {"cavity": 0.06, "emissivity": [0.1, 0.9]},
    {"cavity": 0.04, "emissivity": [0.05, 0.05], "convection": "elsherbiny"},
]


@BOTH
@pytest.mark.parametrize("cavity", CAVITIES, ids=["still", "en_673", "elsherbiny"])
def test_a_cavity_in_balance(cavity, discretisation):
    scene = two_sheets(
        cavity,
        discretisation,
        furnace={"curve": "constant", "temperature": 800.0},
        unexposed={"film_coefficient": 10.0, "emissivity": 0.0},
        solver={"model": "steady", "of": "column"},
    )
    heat = steady_state(door_model(load_scene(scene)), 3600.0)
    assert heat.status.ok

    def excess(flow):
        behind = 20.0 + flow / 10.0 + flow * 0.001 / 2000.0
        return crossing(cavity, 800.0 - flow * 0.001 / 2000.0, behind) - flow

    flow = brentq(excess, 1.0, 7800.0)
    assert -heat.heat_flow()[1] == pytest.approx(flow, rel=1e-4)


@BOTH
@pytest.mark.parametrize("cavity", CAVITIES, ids=["still", "en_673", "elsherbiny"])
def test_two_plates_settle_through_a_cavity(cavity, discretisation):
    """Two lumped plates of unlike temperature, by another integrator."""
    scene = two_sheets(
        cavity,
        discretisation,
        **LEFT_ALONE,
        solver={"model": "column", "tolerance": 1e-3},
    )
    heat = halves_apart(scene, 700.0, 20.0)
    capacity = 0.001 * 7800.0 * 500.0
    times = [60.0, 300.0, 900.0]
    exact = solve_ivp(
        lambda _, t: np.array([-1.0, 1.0]) * crossing(cavity, *t) / capacity,
        (0.0, 900.0), [700.0, 20.0], t_eval=times, rtol=1e-9, atol=1e-9,
    ).y  # fmt: skip
    for n, time in enumerate(times):
        assert heat.advance(time).ok
        found = heat.temperature[[0, -1]]
        np.testing.assert_allclose(found - 20.0, exact[:, n] - 20.0, rtol=1e-3)
    assert heat.balance.worst < 1e-6


def skins(model, **changes):
    """A door of two insulated skins with a cavity between them, without a rim."""
    scene = door(solver={"model": model, "tolerance": 0.01})
    board = {"material": "rock_wool", "thickness": 0.02}
    sheet = {"material": "steel", "thickness": 0.001}
    scene["leaf"]["layers"] = [
        sheet, board, {"cavity": 0.03, "emissivity": [0.9, 0.9]}, board, sheet
    ]  # fmt: skip
    del scene["leaf"]["rim"]
    scene["mesh"] = {"in_plane": [4, 5], "layers": [1, 4, 1, 4, 1], **changes}
    return scene


@pytest.mark.parametrize("discretisation", ["finite_volume", "finite_element"])
def test_a_cavity_is_the_same_in_every_model(discretisation):
    def column_of(model):
        run = simulate(load_scene(skins(model, discretisation=discretisation)), 1200.0, 1200.0)
        assert run.balance.worst < 1e-6
        return run.temperature[-1].reshape(12, -1)

    column = column_of("column")[:, 0]
    for model in ("column_rim", "full"):
        assert np.abs(column_of(model) - column[:, None]).max() < 0.02


def test_the_rim_bridges_a_cavity():
    scene = skins("column_rim")
    scene["leaf"]["rim"] = {"material": "steel", "thickness": 0.001}
    run = simulate(load_scene(scene), 1800.0, 1800.0)
    face = run.temperature[-1].reshape(12, -1)[-1]
    assert face[-1] > face[0] + 100.0


def test_a_probe_in_a_cavity_lies_between_its_faces():
    scene = skins("column")
    scene["probes"] = {"sets": [], "points": {"inside": {"z": 0.036}}}
    run = simulate(load_scene(scene), 1200.0, 1200.0)
    faces = run.temperature[-1].reshape(12, -1)[5:7, 0]
    assert run.probes["inside"][-1] == pytest.approx(faces.mean(), abs=1e-6)


CLOSED = {"cavity": 0.02, "emissivity": [0.8, 0.8]}
TOUCHING = {"material": "stuff", "thickness": 0.01, "contact_resistance": 0.1}


@pytest.mark.parametrize(
    ("layers", "said"),
    [
        ([CLOSED], "leaf.layers.0: is a cavity at the leaf's face; give"),
        (["sheet", CLOSED, CLOSED, "sheet"], "leaf.layers.2: is a cavity beside a cavity; give one"),
        (["sheet", {**CLOSED, "emissivity": [0.8, 0.0]}, "sheet"], "leaf.layers.1.emissivity.1: is 0; give"),
        (["sheet", {**CLOSED, "cavity": 20.0}, "sheet"], "leaf.layers.1.cavity: .*metres, not millimetres"),
        (["sheet", {**CLOSED, "convection": "open"}, "sheet"], "leaf.layers.1.convection: .*en_673"),
        (["sheet", {"cavity": 0.02, "emisivity": [0.8, 0.8]}, "sheet"], "did you mean 'emissivity'"),
        ([TOUCHING], "contact_resistance: has no layer before it to touch; give"),
        (["sheet", CLOSED, TOUCHING], "contact_resistance: has a cavity before it to touch; give"),
        (["sheet", {**TOUCHING, "contact_resistance": 0.0}], "contact_resistance: is 0; give more than 0"),
    ],
)
def test_refusals(layers, said):
    scene = slab(0.01, METAL, 1)
    sheet = {"material": "stuff", "thickness": 0.01}
    scene["leaf"]["layers"] = [sheet if layer == "sheet" else layer for layer in layers]
    del scene["mesh"]
    with pytest.raises(SceneError, match=said):
        load_scene(scene)


def test_a_cavity_has_one_brick_and_no_shape():
    with pytest.raises(SceneError, match=r"mesh.layers.2: is 3 of a cavity, .* give 1"):
        load_scene(skins("column", layers=[1, 4, 3, 4, 1]))
    with pytest.raises(SceneError, match=r"deformation.model: is shell of a leaf with a cavity"):
        load_scene({**skins("full"), "deformation": {"model": "shell"}})
