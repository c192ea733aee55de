"""`flexsim door`: what it prints is what was computed, and mistakes cost one sentence."""

from __future__ import annotations

import json
from html import escape
from pathlib import Path

import numpy as np
import pytest
from processes import flexsim, flexsim_here

from thermal_node import load_scene, simulate

ROOT = Path(__file__).parents[2]
SCENE = ROOT / "config" / "thesis_door.yaml"
SMALL = {"mesh.in_plane": [6, 8], "mesh.layers": [1, 4, 1], "deformation.in_plane": [6, 8]}
SETTINGS = [word for k, v in SMALL.items() for word in ("--set", f"{k}={json.dumps(v)}")]


def test_simulate(tmp_path: Path) -> None:
    """Table, JSON, report and arrays say what `simulate` gives."""
    report, save = tmp_path / "door.html", tmp_path / "door.npz"
    words = ["door", "simulate", SCENE, *SETTINGS, "--duration", "600"]
    done = flexsim(*words, "--json", "--report", report, "--save", save)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    run = simulate(load_scene(SCENE, SMALL), 600.0, 60.0)
    assert said["verdict"] == run.verdict
    assert said["simulated_time"] == 600.0
    assert said["probes"]["tc_1"] == pytest.approx(run.probes["tc_1"][-1])
    for printed, criterion in zip(said["criteria"], run.criteria, strict=True):
        assert printed["name"] == criterion.name
        assert printed["value"] == pytest.approx(criterion.value)
        assert printed["time_of_failure"] == criterion.time_of_failure
        assert printed["judged"]
    assert run.bow is not None
    assert said["bow"] == pytest.approx(run.bow[-1])
    arrays = np.load(save)
    np.testing.assert_allclose(arrays["temperature"], run.temperature)
    assert arrays["deflection"].shape == (11, len(run.nodes), 3)
    assert escape(run.verdict) in report.read_text()

    table = flexsim(*words).stdout
    assert f"verdict: {run.verdict}" in table
    assert f"{run.criteria[0].value:.1f} K" in table
    assert "holds" in table


def test_a_run_that_has_to_stop_fails_with_the_reason() -> None:
    table = "materials.rock_wool.conductivity"
    done = flexsim("door", "simulate", SCENE, *SETTINGS, "--set", f"{table}.temperature=[10, 300]",
                   "--set", f"{table}.value=[0.035, 0.073]", "--json")  # fmt: skip
    assert done.returncode == 1
    assert "beyond the end of its conductivity table" in done.stderr
    assert json.loads(done.stdout)["status"].startswith("stopped at")


def test_fit_and_predict(tmp_path: Path) -> None:
    """A log of a door with other wool gives that wool back; a larger door is burnt with it."""
    model = ["--set", "solver.model=column_rim", "--set", "deformation.model=none"]
    scene = {**SMALL, "solver.model": "column_rim", "deformation.model": "none"}
    real = load_scene(SCENE, scene | {"materials.rock_wool.density": 140.0})
    run = simulate(real, 3600.0, 120.0)
    names = ["tc_1", "tc_6", "tc_9", "interior_third", "interior_two_thirds"]
    noise = np.random.default_rng(5).normal(0.0, 0.5, (len(run.time), len(names)))
    readings = np.column_stack([run.probes[name] for name in names]) + noise
    log = tmp_path / "log.csv"
    np.savetxt(log, np.column_stack([run.time, readings]), delimiter=",", comments="",
               header=",".join(["time", *names]))  # fmt: skip
    larger = tmp_path / "larger.yaml"
    larger.write_text(
        SCENE.read_text()
        .replace("name: thesis_door", "name: larger_door")
        .replace("width: 1.0", "width: 1.4")
        .replace("model: full", "model: column_rim")
        .replace("{model: shell, interval: 300.0}", "{model: none}")
    )
    report = tmp_path / "larger.md"
    done = flexsim("door", "fit", SCENE, log, *SETTINGS, *model, "--predict", larger,
                   "--duration", "1200", "--report", report, "--json")  # fmt: skip
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    found = {p["name"]: p for p in said["parameters"]}
    density = found["rock_wool density"]
    assert density["value"] == pytest.approx(140.0, rel=0.03)
    assert density["interval"][0] < density["value"] < density["interval"][1]
    assert said["rms"] < 1.0 < said["rms_before"]
    assert said["prediction"]["name"] == "larger_door"
    assert said["prediction"]["simulated_time"] == 1200.0
    assert f"density: {density['value']:.6g}"[:14] in report.read_text()


@pytest.mark.parametrize("words", [[], ["simulate"], ["fit"]])
def test_every_help_has_an_example(words: list[str]) -> None:
    shown = flexsim("door", *words, "--help")
    assert shown.returncode == 0
    assert f"Example:\n    flexsim door {words[0] if words else 'simulate'}" in shown.stdout


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        (["burn"], 2, "No such command 'burn'"),
        (["simulate"], 2, "Missing argument"),
        (["simulate", "nowhere.yaml"], 1, "nowhere.yaml: no such file"),
        (["simulate", SCENE, "--duration", "0"], 2, "--duration"),
        (["simulate", SCENE, "--report", "a.pdf"], 2, "give a name in .html or .md"),
        (["simulate", SCENE, "--save", "no/such/a.npz"], 1, "does not exist; make it first"),
        (["simulate", SCENE, "--set", "leaf.heigth=2"], 1, "did you mean 'height'?"),
        (["simulate", ROOT / "config" / "anthropomorphic.yaml"], 1, "give 'fire_door'"),
        (["fit", SCENE, "nowhere.csv"], 1, "nowhere.csv: can't be read"),
        (["fit", SCENE, "log.csv"], 1, "none of them a probe"),
    ],
)
def test_mistakes(words: list[object], code: int, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("time,thermocouple\n0,20\n60,21\n120,22\n")
    done = flexsim_here("door", *words, cwd=tmp_path)
    assert done.returncode == code, done.stderr
    assert sentence in done.stderr
    assert "Traceback" not in done.stderr
