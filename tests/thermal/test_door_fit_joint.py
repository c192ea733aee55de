"""Several logs, what is known beforehand, what a log can't tell, and readings that do not belong."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner
from door_scenes import door
from flexsim.verbs.door import command

from thermal_node import SceneError, load_scene, simulate
from thermal_node.analysis.identifiability import ALIKE, READING_ERROR, foresee
from thermal_node.fit import fit, foresee_fit
from thermal_node.thermocouple_log import ThermocoupleLog

COLUMN = {"mesh": {"layers": [1, 5, 1]}, "solver": {"model": "column", "tolerance": 1.0}}
TRUTH = {"conductivity_600": 0.17, "conductivity_1000": 0.30, "density": 135.0}
INSIDE = ("ftp_centre", "interior_third", "interior_two_thirds")
SCENE = door(**COLUMN, furnace={"curve": "iso_834", "longest_gap": 120.0})


def burnt_log(names=INSIDE, curve="iso_834", duration=3600.0, seed=1, noise=0.5, source="log"):
    """A column that is denser than the scene says, and what it read."""
    real = load_scene(SCENE, {"materials.rock_wool.density": TRUTH["density"], "furnace.curve": curve})
    run = simulate(real, duration, 120.0)
    random = np.random.default_rng(seed)
    readings = {n: run.probes[n][1:] + random.normal(0.0, noise, len(run.time) - 1) for n in names}
    return ThermocoupleLog(run.time[1:], readings, run.furnace[1:], source=source)


@pytest.fixture(scope="module")
def log():
    return burnt_log()


def test_two_tests_tell_more_than_either():
    """A standard fire and a slow one of the same door, each in its own furnace, named apart."""
    logs = [
        burnt_log(("ftp_centre",), source="standard.csv"),
        burnt_log(("ftp_centre",), "slow_heating", seed=2, source="slow.csv"),
    ]
    scene = load_scene(SCENE)
    one, both = fit(scene, logs[0]), fit(scene, logs)
    assert both.used == ("standard: ftp_centre", "slow: ftp_centre")
    assert [r.readings for r in both.residuals] == [30, 30]
    for p in both.parameters:
        low, high = p.interval
        assert low < TRUTH[p.key] < high, p
    errors = [np.array([p.standard_error for p in f.parameters]) for f in (one, both)]
    assert (errors[1] < 1.02 * errors[0]).all() and errors[1].sum() < 0.9 * errors[0].sum()
    assert both.rms < 1.0


def test_what_is_known_beforehand_parts_what_a_log_does_not():
    """The back of a column alone tells of the wool's conductivity and density together."""
    short = burnt_log(("ftp_centre",), duration=1800.0)
    scene = load_scene(SCENE)
    alone = fit(scene, short)
    known = fit(scene, short, priors={"density": (135.0, 1.0)})
    by_key = {p.key: p for p in known.parameters}
    assert by_key["density"].value == pytest.approx(135.0, abs=3.0)
    assert by_key["density"].standard_error <= 1.01
    assert by_key["density"].prior == (135.0, 1.0)
    before = {p.key: p for p in alone.parameters}
    key = "conductivity_600"
    relative = [p[key].standard_error / p[key].value for p in (by_key, before)]
    assert relative[0] < 0.7 * relative[1]
    low, high = by_key[key].interval
    assert low < TRUTH[key] < high
    # Two normal estimates of one number: the mean that their variances weigh.
    mean, deviation = before["density"].value, before["density"].standard_error
    for value, spread, within in ((115.0, 20.0, 0.3), (115.0, 0.5, 1.0)):
        weighed = (mean / deviation**2 + value / spread**2) / (1.0 / deviation**2 + 1.0 / spread**2)
        found = fit(scene, short, priors={"density": (value, spread)})
        assert found.parameters[-1].value == pytest.approx(weighed, abs=within)


def test_a_prior_that_the_log_contradicts_is_named(log):
    found = fit(load_scene(SCENE), log, priors={"density": (80.0, 1.0)})
    assert any("standard deviations from its prior, 80 kg/m3: the two do not agree" in n for n in found.notes)


def linear(matrix):
    """Readings that move as a matrix says."""
    return lambda x: matrix @ x


def test_directions_that_no_reading_tells_are_found():
    """Closed forms: two parameters that act as their sum, and one that does nothing."""
    random = np.random.default_rng(3)
    acts = 300.0 * random.normal(size=50)
    matrix = np.stack([acts, acts, 400.0 * random.normal(size=50), np.zeros(50)], axis=1)
    names = ["a", "b", "c", "d"]
    told = foresee(linear(matrix), np.zeros(4), np.ones(4), names, np.zeros(4))
    assert told.rank == 2 and told.condition > 1e6
    both, nothing = sorted(told.notes, key=len, reverse=True)
    assert "can't tell a from b" in both or "can't tell b from a" in both
    assert "+10 %" in both and "-10 %" in both
    assert float(both.split("more than ")[1].split()[0]) < 1e-9
    assert "can't tell d" in nothing
    noise = READING_ERROR * np.sqrt((1.0 + ALIKE) / (1.0 - ALIKE))
    plain = foresee(linear(matrix[:, 2:3]), np.zeros(1), np.ones(1), ["c"], np.zeros(1))
    assert plain.error[0] == pytest.approx(noise / np.linalg.norm(matrix[:, 2]), rel=1e-6)
    known = foresee(linear(matrix), np.zeros(4), np.ones(4), names, np.array([0.0, 100.0, 0.0, 400.0]))
    assert known.rank == 4 and known.error[1] == pytest.approx(0.1, rel=0.01) and not known.notes


def test_it_is_said_before_the_fit_what_the_log_cant_tell():
    """Four minutes say nothing of the wool at 1000 °C; said before, and by foresee_fit without a fit."""
    early = burnt_log(("ftp_centre",), duration=480.0)
    told = []
    runs = []
    fit(
        load_scene(SCENE), early, say=lambda note: told.append((note, len(runs))),
        progress=lambda run, _: runs.append(run),
    )  # fmt: skip
    assert any("conductivity at 1000 °C" in note for note, _ in told)
    assert max(done for _, done in told) <= 6 < len(runs)
    names, foreseen = foresee_fit(load_scene(SCENE), early)
    assert len(names) == 3 and foreseen.rank < 3
    assert foreseen.error[1] > 0.5 > 0.0


def test_readings_and_thermocouples_that_do_not_belong_are_named(log):
    """One reading that jumps, one thermocouple that has come off; left out, the fit is what it was."""
    readings = {n: v.copy() for n, v in log.readings.items()}
    readings["interior_third"][10] += 60.0
    readings["exposed_centre"] = burnt_log(("exposed_centre",)).readings["exposed_centre"] * 0.7
    bad = ThermocoupleLog(log.time, readings, log.furnace)
    clean = fit(load_scene(SCENE), log)
    assert not any("jumps" in n or "look at how it sits" in n for n in clean.notes)
    assert {r.name for r in clean.residuals} == set(INSIDE)
    kept = fit(load_scene(SCENE), bad, leave=["exposed_centre"])
    jumps = "interior_third jumps away from its neighbours in time at 1320 s"
    assert any(n.startswith(jumps) for n in kept.notes)
    assert "exposed_centre" not in kept.used
    worst = next(r for r in kept.residuals if r.name == "interior_third")
    assert worst.worst_time == 1320.0 and worst.worst == pytest.approx(-60.0, abs=5.0)
    every = fit(load_scene(SCENE), bad)
    assert any(n.startswith("exposed_centre is ") and "look at how it sits" in n for n in every.notes)


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ({"priors": {"densty": (120.0, 6.0)}}, "densty is not fitted; give one of conductivity_600"),
        ({"priors": {"density": (9e9, 6.0)}}, "density is 9e[+]09; give rock_wool density from"),
        ({"priors": {"density": (120.0, 0.0)}}, "standard deviation of 0; give more than 0 kg/m3"),
        ({"leave": ["tc_99"]}, "has no column tc_99 to leave out; it has ftp_centre"),
        ({"leave": list(INSIDE)}, "nothing was measured"),
    ],
)
def test_what_cant_be_known_or_left_out_is_refused(log, how, said):
    with pytest.raises(SceneError, match=said):
        fit(load_scene(SCENE), log, **how)


def test_the_command_says_what_logs_can_tell(tmp_path, log):
    scene, path = tmp_path / "door.yaml", tmp_path / "log.csv"
    scene.write_text(json.dumps(SCENE))
    columns = [log.time, log.furnace, *log.readings.values()]
    rows = [",".join(f"{v:.3f}" for v in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join([f"time,furnace,{','.join(INSIDE)}", *rows]))
    shown = CliRunner().invoke(command, ["fit", str(scene), str(path), "--check", "--json"])
    assert shown.exit_code == 0, shown.output
    found = json.loads(shown.stdout)
    assert found["rank"] == 3 and len(found["parameters"]) == 3
    assert all(p["standard_error"] < 0.5 for p in found["parameters"])
    shown = CliRunner().invoke(command, ["fit", str(scene), str(path), "--check"])
    assert "3 of 3 combinations of parameters can be told" in shown.output
    for words, said in (
        (["--prior", "density"], "give KEY=VALUE±DEVIATION"),
        (["--check", "--report", str(tmp_path / "r.html")], "--check fits nothing"),
    ):
        shown = CliRunner().invoke(command, ["fit", str(scene), str(path), *words])
        assert shown.exit_code == 2 and said in shown.output
