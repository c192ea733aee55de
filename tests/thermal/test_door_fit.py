"""A test's thermocouples give the wool and the rim back, with honest uncertainties."""

import numpy as np
import pytest
from door_scenes import door

from thermal_node import SceneError, load_scene, simulate
from thermal_node.fit import fit
from thermal_node.thermocouple_log import ThermocoupleLog, read_thermocouple_log

MESH = {"in_plane": [8, 8], "layers": [1, 6, 1], "symmetry": "quarter"}
GUESS = [0.035, 0.043, 0.073, 0.118, 0.178]


@pytest.fixture(scope="module")
def tested():
    """A door that differs from the scene in density, conductivity and rim, with 1 K of noise."""
    real = load_scene(door(mesh=MESH), {"materials.rock_wool.density": 135.0, "leaf.rim.contact": 0.6})
    run = simulate(real, 3600.0, 60.0)
    noise = np.random.default_rng(7)
    names = [f"tc_{i}" for i in range(1, 13)]
    readings = {n: run.probes[n][1:] + noise.normal(0.0, 1.0, len(run.time) - 1) for n in names}
    readings["tc_3"][4] = np.nan
    return run.time[1:], readings, run.furnace[1:]


def test_fit_finds_what_was_burnt(tested):
    """From rows a minute apart, the furnace's among them: what it did between them matters."""
    time, readings, furnace = tested
    scene = load_scene(door(mesh=MESH), {"materials.rock_wool.conductivity.value": GUESS})
    result = fit(scene, ThermocoupleLog(time, readings, furnace), mesh=MESH)
    real = {
        "rock_wool conductivity at 600 °C": 0.17,
        "rock_wool conductivity at 1000 °C": 0.30,
        "rock_wool density": 135.0,
        "rim contact": 0.6,
    }
    assert [p.name for p in result.parameters] == list(real)
    for p in result.parameters:
        assert abs(p.value - real[p.name]) < 4.0 * p.standard_error, p
        assert p.value == pytest.approx(real[p.name], rel=0.05), p
        low, high = p.interval
        assert low < real[p.name] < high, p
    assert 0.8 < result.rms < 1.3 < result.rms_before
    assert result.used == tuple(readings)
    larger = result.predict({"leaf.width": 1.5, "leaf.height": 2.5}, 600.0, 300.0)
    assert larger.status.ok
    assert larger.model.mesh.shape[2] > 9


def test_a_parameter_that_the_log_knows_nothing_of_is_named():
    """In five minutes the wool behind the face tells nothing of its conductivity at 1000 °C."""
    scene = load_scene(door(mesh=MESH))
    run = simulate(scene, 240.0, 60.0)
    noise = np.random.default_rng(3)
    log = ThermocoupleLog(
        run.time[1:], {"ftp_centre": run.probes["ftp_centre"][1:] + noise.normal(0, 0.5, 4)}
    )
    result = fit(scene, log, mesh=MESH)
    assert any("1000 °C is not determined" in note for note in result.notes)


def test_a_table_that_ends_at_300_degrees_is_continued():
    scene = load_scene(
        door(mesh=MESH, solver={"model": "column"}),
        {
            "materials.rock_wool.conductivity": {
                "temperature": [10, 100, 300],
                "value": [0.035, 0.043, 0.073],
                "beyond": "extend",
            }
        },
    )
    run = simulate(load_scene(door(mesh=MESH, solver={"model": "column"})), 3600.0, 120.0)
    log = ThermocoupleLog(
        run.time[1:],
        {n: run.probes[n][1:] for n in ("ftp_centre", "interior_third", "interior_two_thirds")},
    )
    result = fit(scene, log, mesh=MESH)
    found = {p.name: p.value for p in result.parameters}
    assert found["rock_wool conductivity at 600 °C"] == pytest.approx(0.17, rel=0.03)
    assert "rim contact" not in found


def test_logs_are_read_and_refused(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("time_s,furnace_c,tc_1\n0,20,20\n60,350,\n120,440,21.5\n")
    log = read_thermocouple_log(path)
    np.testing.assert_array_equal(log.time, [0.0, 60.0, 120.0])
    assert log.furnace is not None
    assert np.isnan(log.readings["tc_1"][1])
    path.write_text("time,tc_1\n0,20\n60,21\n30,22\n")
    with pytest.raises(SceneError, match=r"log\.csv:4: time is 30; give times that increase"):
        read_thermocouple_log(path)
    scene = load_scene(door(mesh=MESH))
    with pytest.raises(SceneError, match="none of them a probe"):
        fit(scene, ThermocoupleLog(np.array([60.0, 120.0]), {"TC 1": np.array([20.0, 21.0])}))


COLUMN = {"mesh": {"layers": [1, 5, 1]}, "solver": {"model": "column", "tolerance": 1.0}}


@pytest.fixture(scope="module")
def slipped():
    """An hour of a column whose wool conducts worse than the scene says, and the scene."""
    real = load_scene(door(**COLUMN), {"materials.rock_wool.conductivity.value": GUESS})
    run = simulate(real, 3600.0, 300.0)
    names = ("ftp_centre", "interior_third", "interior_two_thirds")
    return load_scene(door(**COLUMN)), run.time[1:], {n: run.probes[n][1:] for n in names}


@pytest.mark.parametrize(
    ("times", "readings", "said"),
    [
        (1.0, lambda v: 1.8 * v + 32.0, "if it is read as °F"),
        (1.0 / 60.0, lambda v: v, "if it is read as minutes"),
        (1.0, lambda v: v + 273.15, "if it is read as K"),
        (1.0, lambda v: v * np.nan, "nothing was measured"),
    ],
)
def test_a_log_in_other_units_is_refused_for_what_is_wrong(slipped, times, readings, said):
    scene, time, read = slipped
    with pytest.raises(SceneError, match=said):
        fit(scene, ThermocoupleLog(times * time, {n: readings(v) for n, v in read.items()}))
