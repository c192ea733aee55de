"""What materials give or take once: against an explicit program, irreversible, kept, and balanced."""

import numpy as np
import pytest
from door_scenes import slab
from explicit_slab import GAS, Reaction, Slab, burn

from thermal_node import Heat, SceneError, door_model, load_scene, simulate
from thermal_node.analysis.report import facts
from thermal_node.furnace.furnace import Measured

TIMES = [300.0, 600.0, 900.0, 1200.0, 1800.0, 2400.0, 3600.0]
MOIST = {"density": 900.0, "specific_heat": 900.0, "conductivity": 0.2, "moisture": 0.05}
GYPSUM = {
    "density": 800.0,
    "specific_heat": 950.0,
    "conductivity": {"temperature": [20, 120, 400, 1000], "value": [0.25, 0.13, 0.13, 0.3], "beyond": "hold"},
    "reactions": [
        {"name": "to hemihydrate", "share": 0.15, "latent_heat": 3.0e6, "temperature": [100, 150]},
        {"name": "to anhydrite", "share": 0.05, "latent_heat": 2.6e6, "temperature": [160, 210]},
    ],
}
BINDER = {
    "name": "binder",
    "share": 0.09,
    "residue": 0.3,
    "heat_of_combustion": 2.5e7,
    "specific_heat": 1700.0,
    "kinetics": {"frequency_factor": 0.056, "activation_energy": 21700.0, "order": 0.71},
}
WOOL = {
    "density": 65.0,
    "specific_heat": 1000.0,
    "conductivity": {"temperature": [20, 500, 1000], "value": [0.032, 0.16, 0.55], "beyond": "hold"},
    "oxygen_diffusivity": 2.05e-5,
}


def iso(t):
    return 20.0 + 345.0 * np.log10(8.0 * max(t, 0.0) / 60.0 + 1.0)


def up_and_down(t):
    """Hot to half an hour, cold to an hour, hot again."""
    return float(np.interp(t, [0, 60, 1800, 1860, 3600, 3660, 7200], [20, 500, 500, 20, 20, 500, 500]))


def scene_of(thickness, stuff, bricks, curve=iso, end=3600, **changes):
    t = np.arange(0.0, end + 1.0, 5.0)
    furnace = {"curve": "table", "time": t, "temperature": np.array([curve(x) for x in t])}
    return slab(
        thickness,
        stuff,
        bricks,
        furnace=furnace,
        exposed={"film_coefficient": 25.0, "emissivity": 0.7},
        unexposed={"film_coefficient": 4.0, "emissivity": 0.7},
        **changes,
    )


def explicit(thickness, stays, stuff, reactions, curve=iso):
    def of(key):
        value = stuff[key]
        if isinstance(value, float):
            return lambda t: np.full(len(t), value)
        return lambda t: np.interp(t, value["temperature"], value["value"])

    return Slab(
        thickness, stays, of("specific_heat"), of("conductivity"), curve, (25.0, 4.0), (0.7, 0.7), reactions
    )  # fmt: skip


def three(run):
    """Both faces and the middle (K, 3)."""
    t = run.temperature
    return t[:, [0, t.shape[1] // 2, -1]]


@pytest.mark.parametrize("discretisation", ["finite_volume", "finite_element"])
def test_moisture_evaporates_once_by_another_program(discretisation):
    """Heated, cooled and heated again: the second time there is no water left where it was hot."""
    times = [600.0, 1200.0, 1800.0, 2400.0, 3600.0, 4200.0, 4800.0, 6000.0]
    scene = scene_of(0.03, MOIST, 60, up_and_down, 7200)
    scene["mesh"]["discretisation"] = discretisation
    run = simulate(load_scene(scene), 6000.0, 600.0)
    assert run.balance.worst < 1e-6
    found = three(run)[[int(t / 600.0) for t in times]]
    water = Reaction(45.0, 2.257e6, 45.0, 4187.0, 110.0, (100.0, 120.0))
    exact, degree = burn(explicit(0.03, 855.0, MOIST, [water], up_and_down), 40, 0.25, times)
    np.testing.assert_allclose(found, exact, atol=1.0)
    assert run.temperature[6, 0] < 60.0  # it was cold again
    assert 0.5 < degree[0].mean() <= 1.0


def test_gypsum_loses_its_water_in_two_steps_by_another_program():
    run = simulate(load_scene(scene_of(0.02, GYPSUM, 60)), 3600.0, 300.0)
    assert run.balance.worst < 1e-6
    found = three(run)[[int(t / 300.0) for t in TIMES]]
    steps = [
        Reaction(120.0, 3.0e6, 120.0, 950.0, 125.0, (100.0, 150.0)),
        Reaction(40.0, 2.6e6, 40.0, 950.0, 185.0, (160.0, 210.0)),
    ]
    exact, degree = burn(explicit(0.02, 640.0, GYPSUM, steps), 40, 0.1, TIMES)
    np.testing.assert_allclose(found, exact, atol=1.0)
    assert min(x.mean() for x in degree) > 0.99


def arrhenius(t, x):
    return 0.056 * np.exp(-21700.0 / GAS / (t + 273.15)) * (1.0 - x) ** 0.71


@pytest.mark.parametrize("oxygen", ["unlimited", "diffusion"])
def test_binder_burns_once_by_another_program(oxygen):
    stuff = {**WOOL, "reactions": [{**BINDER, "oxygen": oxygen}]}
    run = simulate(
        load_scene(scene_of(0.05, stuff, 60, solver={"model": "column", "tolerance": 0.02})), 3600.0, 300.0
    )
    assert run.balance.worst < 1e-6
    amount = 65.0 * 0.09
    held_at = 21700.0 / GAS / np.log(56.0) - 273.15
    burns = Reaction(
        amount, -2.5e7, 0.7 * amount, 1700.0, held_at, rate=arrhenius,
        oxygen=amount * 2.5e7 / 13.1e6 if oxygen == "diffusion" else 0.0,
    )  # fmt: skip
    exact, _ = burn(explicit(0.05, 65.0 * (1.0 - 0.7 * 0.09), WOOL, [burns]), 30, 0.1, TIMES)
    np.testing.assert_allclose(three(run)[[int(t / 300.0) for t in TIMES]], exact, atol=1.0)


def everything():
    """Moisture, dehydration, a binder by Arrhenius and one by a table, a cavity and a contact."""
    scene = scene_of(0.02, GYPSUM, 1)
    binder = {**BINDER, "oxygen": "diffusion"}
    tabled = {"name": "facing", "share": 0.01, "heat_of_combustion": 1.5e7}
    tabled["rate"] = {"temperature": [200, 300, 400], "value": [0.0, 1e-3, 5e-3]}
    scene["materials"]["wool"] = {**WOOL, "moisture": 0.01, "reactions": [binder, tabled]}
    scene["leaf"]["layers"] = [
        {"material": "stuff", "thickness": 0.012},
        {"cavity": 0.03, "emissivity": [0.9, 0.9]},
        {"material": "stuff", "thickness": 0.012},
        {"material": "wool", "thickness": 0.04, "contact_resistance": 0.01},
    ]
    scene["mesh"] = {"layers": [8, 1, 8, 16]}
    return scene


def test_a_saved_state_goes_on_bit_by_bit():
    heat = Heat(door_model(load_scene(everything())))
    for time in (1000.0, 1500.0):
        assert heat.advance(time).ok
        saved = heat.save()
        heat.advance(time + 400.0)
        temperature, degree = heat.temperature.copy(), heat.degree.copy()
        heat.restore(saved)
        np.testing.assert_array_equal(heat.degree, saved.degree)
        heat.advance(time + 400.0)
        np.testing.assert_array_equal(heat.temperature, temperature)
        np.testing.assert_array_equal(heat.degree, degree)
    assert heat.degree[0, :9].mean() > 0.1
    heat.reset()
    assert heat.degree.max() == 0.0


@pytest.mark.parametrize("method", ["tr_bdf2", "sdirk2", "implicit_euler"])
def test_what_a_furnace_measures_after_a_save_does_not_reach_back(method):
    """A march that tried 900 °C, was restored and got 350 °C is the one that never tried."""

    def marched(slip):
        scene = everything()
        scene["solver"] = {"model": "column", "method": method}
        heat = Heat(door_model(load_scene(scene)))
        heat.furnace = furnace = Measured([0.0], [300.0])
        assert heat.advance(300.0).ok
        saved = heat.save()
        furnace.add(300.0, slip)
        if slip != 350.0:
            assert heat.advance(310.0).ok
            heat.restore(saved)
            furnace.temperature[-1] = 350.0
        flow = heat.heat_flow()
        assert heat.advance(330.0).ok
        return flow, heat.temperature, heat.degree, vars(heat.balance)

    for found, right in zip(marched(900.0), marched(350.0), strict=True):
        np.testing.assert_equal(found, right)


@pytest.mark.parametrize("step", ["auto", 20.0])
@pytest.mark.parametrize("method", ["tr_bdf2", "sdirk2", "implicit_euler"])
def test_every_step_of_all_of_it_is_balanced(step, method):
    scene = everything()
    scene["solver"] = {"model": "column", "step": step, "method": method, "tolerance": 0.1}
    heat = Heat(door_model(load_scene(scene)))
    status = heat.advance(3000.0)
    assert status.ok, status
    assert heat.balance.worst < 1e-6
    assert heat.balance.relative < 1e-6
    assert np.all((heat.degree >= 0.0) & (heat.degree <= 1.0))


def test_what_burns_without_loss_warms_by_its_heat():
    """Insulated all round: m Q = the enthalpy of what stays; it ends at T0 + Q share / c."""
    nothing = {"film_coefficient": 0.0, "emissivity": 0.0}
    share, heat_of = 0.01, 1.0e7
    stuff = {"density": 100.0, "specific_heat": 1000.0, "conductivity": 0.1}
    rate = {"temperature": [0, 1000], "value": [0.01, 0.01]}
    stuff["reactions"] = [{"share": share, "residue": 1.0, "heat_of_combustion": heat_of, "rate": rate}]
    scene = slab(0.02, stuff, 4, furnace={"curve": "constant", "temperature": 20.0})
    scene.update(exposed=nothing, unexposed=nothing, solver={"model": "column", "tolerance": 1e-3})
    heat = Heat(door_model(load_scene(scene)))
    for time in (50.0, 300.0, 2000.0):
        assert heat.advance(time).ok
        burnt = 1.0 - np.exp(-0.01 * time)
        np.testing.assert_allclose(heat.temperature, 20.0 + burnt * share * heat_of / 1000.0, atol=0.05)
    assert heat.balance.worst < 1e-6
    assert heat.balance.released == pytest.approx(0.02 * 100.0 * share * heat_of, rel=1e-6)


def test_what_has_gone_is_the_mean_over_its_own_material():
    """Two materials at one temperature, each with its own rate: 1 - exp(-r t), whatever their volumes."""
    nothing = {"film_coefficient": 0.0, "emissivity": 0.0}
    rates = {"stuff": 2e-3, "other": 5e-4}
    scene = slab(0.02, {}, 4, furnace={"curve": "constant", "temperature": 20.0})
    scene["leaf"]["layers"].append({"material": "other", "thickness": 0.005})
    scene["mesh"] = {"layers": [4, 3]}
    for name, r in rates.items():
        burns = {"share": 1e-6, "residue": 1.0, "heat_of_combustion": 1e6}
        burns["rate"] = {"temperature": [0, 1000], "value": [r, r]}
        scene["materials"][name] = {"density": 100.0, "specific_heat": 1000.0, "conductivity": 0.1}
        scene["materials"][name] |= {"moisture": 0.01, "reactions": [burns]}
    scene.update(exposed=nothing, unexposed=nothing, solver={"model": "column", "step": 5.0})
    run = simulate(load_scene(scene), 900.0, 300.0)
    assert list(run.reacted) == [f"{name}: {what}" for name in rates for what in ("moisture", "reactions.0")]
    for name, r in rates.items():
        np.testing.assert_allclose(
            run.reacted[f"{name}: reactions.0"], 1.0 - np.exp(-r * run.time), atol=2e-4
        )
        np.testing.assert_array_equal(run.reacted[f"{name}: moisture"], 0.0)
    assert ("other: reactions.0, gone at the end", "36.2 %") in facts(run)


def test_nothing_burns_behind_what_no_air_gets_through():
    stuff = {**WOOL, "reactions": [{**BINDER, "oxygen": "diffusion"}]}
    scene = scene_of(0.05, stuff, 20)
    scene["leaf"]["layers"].append({"material": "steel", "thickness": 0.001})
    scene["mesh"] = {"layers": [20, 1]}
    run = simulate(load_scene(scene), 1800.0, 1800.0)
    assert run.balance.released == 0.0


def test_a_steady_state_is_what_is_left_when_all_has_burnt():
    def of(reactions):
        stuff = {**WOOL, "reactions": reactions}
        scene = scene_of(0.05, stuff, 20, solver={"model": "steady", "of": "column"})
        return simulate(load_scene(scene), 3600.0).temperature[-1]

    np.testing.assert_allclose(of([BINDER]), of([]), atol=1e-3)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"moisture": 5.0}, "moisture.share: is 5; give .* not per cent"),
        ({"moisture": {"share": 0.1, "temperature": [120, 100]}}, "temperature.1: is 100 after 120; give"),
        ({"reactions": [{"share": 0.1, "temperature": [100, 200]}]}, "latent_heat or heat_of_combustion"),
        ({"reactions": [{"share": 0.1, "latent_heat": 2e6}]}, "give temperature, kinetics or rate"),
        (
            {"reactions": [{"share": 0.1, "heat_of_combustion": 2e7, "temperature": [100, 200]}]},
            "give kinetics",
        ),
        ({"reactions": [{"share": 0.1, "latent_heat": 200.0, "temperature": [1, 2]}]}, "not kilojoules"),
        ({"reactions": [{"share": 0.6, "latent_heat": 2e6, "temperature": [1, 2]}] * 2}, "give at most 0.95"),
        ({"moisture": {"share": 0.1, "temperature": [100, 900]}}, "a narrower range"),
        ({"reactions": [{**BINDER, "oxygen": "diffusion"}]}, "without oxygen_diffusivity; give it"),
        ({"reactions": [{"share": 0.1, "latent_heat": 2e6, "temperature": [1, 2, 3]}]}, "a degree for each"),
        (
            {"reactions": [{"share": 0.1, "latent_heat": 2e6, "temperature": [1, 2], "degree": [0, 0.5]}]},
            "1 last",
        ),
        (
            {"reactions": [{**BINDER, "kinetics": {"frequency_factor": 1.0, "activation_energy": 90.0}}]},
            "J/mol",
        ),
    ],
)
def test_refusals(change, said):
    stuff = {"density": 100.0, "specific_heat": 1000.0, "conductivity": 0.1, **change}
    with pytest.raises(SceneError, match=said):
        load_scene(slab(0.05, stuff, 4))
