"""What a fit holds as the scene has it is said with how far it moves the readings; doors of several sizes."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner
from door_scenes import door, slab
from flexsim.verbs.door import command

from thermal_node import SceneError, load_scene, simulate
from thermal_node.fit import fit, foresee_fit
from thermal_node.thermocouple_log import ThermocoupleLog

BINDER = {
    "name": "binder", "share": 0.03, "residue": 0.3, "heat_of_combustion": 2.5e7,
    "kinetics": {"frequency_factor": 0.056, "activation_energy": 21700.0, "order": 0.71},
}  # fmt: skip
WOOL = {
    "density": 100.0, "specific_heat": 1000.0, "reactions": [BINDER],
    "conductivity": {"temperature": [20, 300, 600, 1000], "value": [0.035, 0.08, 0.17, 0.3]},
}  # fmt: skip
BOARD = {"density": 800.0, "specific_heat": 950.0, "conductivity": 0.2, "moisture": {"share": 0.02}}
PROBES = ("ftp_centre", "interior_half", "interior_two_thirds")


def double_leaf():
    """Wool, a board that lies on it, a cavity and a board."""
    scene = slab(0.03, WOOL, 6, exposed={"film_coefficient": 25.0, "emissivity": 0.7})
    scene["leaf"]["layers"] += [
        {"material": "board", "thickness": 0.01, "contact_resistance": 0.02},
        {"cavity": 0.02, "emissivity": [0.9, 0.4]},
        {"material": "board", "thickness": 0.01},
    ]
    scene["materials"]["board"] = BOARD
    scene["mesh"] = {"layers": [6, 3, 1, 3]}
    return scene


def log_of(run, names, noise=0.0, source="log"):
    random = np.random.default_rng(len(source))
    readings = {n: run.probes[n][1:] + random.normal(0.0, noise, len(run.time) - 1) for n in names}
    return ThermocoupleLog(run.time[1:], readings, source=source)


def test_what_is_held_moves_the_readings_as_far_as_is_said():
    """Each against two runs of its own, one with 10 % less of it."""
    scene = load_scene(double_leaf())
    run = simulate(scene, 2400.0, 120.0)
    _, told = foresee_fit(scene, log_of(run, PROBES))
    held = {h.name: h for h in told.held}
    for name, change in (
        ("board moisture: share", {"materials.board.moisture.share": 0.018}),
        ("stuff binder: share", {"materials.stuff.reactions.0.share": 0.027}),
        ("stuff binder: frequency factor", {"materials.stuff.reactions.0.kinetics.frequency_factor": 0.0504}),
        ("leaf.layers.1 contact resistance", {"leaf.layers.1.contact_resistance": 0.018}),
        ("leaf.layers.2 cavity's emissivities", {"leaf.layers.2.emissivity": [0.81, 0.36]}),
        ("stuff specific heat", {"materials.stuff.specific_heat": 900.0}),
        ("board density", {"materials.board.density": 720.0}),
        ("exposed emissivity", {"exposed.emissivity": 0.63}),
    ):
        less = simulate(load_scene(double_leaf(), change), 2400.0, 120.0)
        moved = max(np.abs(less.probes[p] - run.probes[p]).max() for p in PROBES)
        assert held[name].moved == pytest.approx(moved, rel=1e-6), name
        assert held[name].seen == (moved > 2.5)
    assert held["leaf.layers.2 cavity's convection"].moved is None
    assert held["stuff conductivity to 300 °C"].value == "0.035 to 0.08"
    assert not {"stuff density", "stuff conductivity"} & set(held)  # those are fitted
    (note,) = [n for n in told.notes if n.startswith("held as the scene has it")]
    named = note.split("one by): ")[1].split(";")[0].split(", ")
    assert {words.rpartition(" (")[0] for words in named} == {h.name for h in told.held if h.seen}
    assert held["stuff binder: share"].seen


STRIP = {
    "mesh": {"in_plane": [8, 8], "layers": [1, 5, 1]},
    "solver": {"model": "column_rim", "tolerance": 0.5},
}
NARROW = {"leaf.width": 0.3}
TRUTH = {"materials.rock_wool.density": 135.0, "leaf.rim.contact": 0.6}
RIM = ("ftp_centre", "tc_9", "interior_half")


@pytest.fixture(scope="module")
def two_sizes():
    """Doors of one make, 1 m and 0.3 m wide, and their logs; narrow, heat from the rim reaches the middle."""
    scenes = [load_scene(door(**STRIP)), load_scene(door(**STRIP), NARROW)]
    runs = [simulate(load_scene(door(**STRIP), TRUTH | more), 3000.0, 120.0) for more in ({}, NARROW)]
    assert np.abs(runs[0].probes["ftp_centre"] - runs[1].probes["ftp_centre"]).max() > 3.0
    logs = [log_of(run, RIM, 0.5, name) for run, name in zip(runs, ("wide.csv", "narrow.csv"), strict=True)]
    return scenes, logs


def test_doors_of_two_sizes_are_fitted_together(two_sizes):
    """Each log with its own leaf, one wool and one rim; known better than from either."""
    scenes, logs = two_sizes
    both = fit(scenes, logs, mesh={})
    assert both.used[0] == "wide: ftp_centre" and both.used[3] == "narrow: ftp_centre"
    assert both.rms < 0.7
    values = {p.key: p for p in both.parameters}
    for key, real in (("density", 135.0), ("rim_contact", 0.6), ("conductivity_600", 0.17)):
        low, high = values[key].interval
        assert low < real < high and high < 1.2 * low, key
    assert [s.leaf.width for s in both.scenes] == [1.0, 0.3]
    assert {s.materials["rock_wool"].density for s in both.scenes} == {values["density"].value}
    one = {p.key: p for p in fit(scenes[0], logs[0], mesh={}).parameters}
    assert sum(p.standard_error / one[p.key].standard_error for p in both.parameters) < 0.9 * len(one)
    assert any(n.startswith("held as the scene has it") and "specific heat (" in n for n in both.notes)
    assert {h.name for h in both.held if h.moved is None} == {"steel conductivity and specific heat"}
    # The same logs with one leaf for both are not explained.
    assert fit(scenes[0], logs, mesh={}).rms > 2.0 * both.rms


def test_doors_and_logs_that_do_not_go_together(two_sizes):
    scenes, logs = two_sizes
    other = load_scene(door(**STRIP), {"materials.rock_wool.specific_heat": 900.0})
    copy = replace(logs[0], source="copy.csv")
    for given, tests, said in (
        ([scenes[0], other], logs, "materials.rock_wool.specific_heat: differs from that of"),
        (scenes[:1], logs, "there are 1 for 2 logs; give one for each log"),
        (scenes[0], [logs[0], copy], "copy.csv: holds the readings of wide.csv; give each test once"),
    ):
        with pytest.raises(SceneError, match=said):
            fit(given, tests)


def test_the_command_says_what_it_holds(tmp_path, two_sizes):
    """In the table, for programs and in the report; two doors by --also; a prior once."""
    _, logs = two_sizes
    words = []
    for log, more in zip(logs, ({}, {"width": 0.3}), strict=True):
        scene, path = tmp_path / f"{log.source}.yaml", tmp_path / log.source
        given = door(**STRIP)
        given["leaf"] |= more
        scene.write_text(json.dumps(given))
        rows = [
            ",".join(f"{v:.3f}" for v in row) for row in zip(log.time, *log.readings.values(), strict=True)
        ]
        path.write_text("\n".join([f"time,{','.join(log.readings)}", *rows]))
        words += [str(scene), str(path)]
    both = ["fit", *words[:2], "--also", *words[2:]]
    shown = CliRunner().invoke(command, [*both, "--check", "--json"])
    assert shown.exit_code == 0, shown.output
    held = {h["name"]: h for h in json.loads(shown.stdout)["held"]}
    assert json.loads(shown.stdout)["log"].endswith("wide.csv, " + words[3])
    assert held["rock_wool specific heat"]["seen"] and held["rock_wool specific heat"]["value"] == "1000"
    report = tmp_path / "door.md"
    shown = CliRunner().invoke(command, [*both[:3], "--report", str(report), "--duration", "60"])
    assert shown.exit_code == 0, shown.output
    assert "held as the scene has it" in shown.stdout and "3 thermocouples" in shown.stdout
    text = report.read_text()
    assert "| held: rock_wool specific heat | 1000 J/(kg K)" in text
    found = re.search(r"\| fitted: rock_wool density \| ([0-9.]+)", text)
    assert found is not None and float(found[1]) == pytest.approx(135.0, rel=0.1)
    shown = CliRunner().invoke(command, [*both, "--prior", "density=120±6", "--prior", "density=130±6"])
    assert shown.exit_code == 2 and "density has a prior already; give each once" in shown.output
