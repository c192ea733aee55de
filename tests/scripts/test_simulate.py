"""`flexsim simulate` gives what the Python interface gives, and says what is wrong with inputs."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from processes import flexsim, flexsim_here

from flexsim_node import load_scene, simulate

SCENE = Path(__file__).parents[2] / "config" / "anthropomorphic.yaml"


def run(*words: object, cwd: Path | None = None) -> dict[str, object]:
    done = flexsim("simulate", SCENE, *words, "--json", timeout=240, cwd=cwd)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_free_fall(tmp_path: Path) -> None:
    """The saved arrays are those of `simulate`."""
    file = tmp_path / "run"
    said = run("-d", 0.1, "--sample-period", 0.01, "--set", "solver.step=5e-4", "--save", file)
    expected = simulate(load_scene(SCENE, {"solver.step": 5e-4}), duration=0.1, sample_period=0.01)
    saved = np.load(file)
    assert list(saved["joint_names"]) == ["joint_1", "joint_2", "joint_3"]
    for name in ("time", "joint_position", "link_end", "node_displacement", "energy"):
        np.testing.assert_array_equal(saved[name], getattr(expected, name))
    assert said["steps"] == 200
    assert said["samples"] == 11
    assert said["joint_position"] == expected.joint_position[-1].tolist()


def test_torques_from_a_file(tmp_path: Path) -> None:
    """A row holds until the next; columns are found by name; samples may be further apart."""
    table = tmp_path / "torque.csv"
    table.write_text("# by hand\nt, joint_2, joint_1, joint_3\n0,11.5,0.3,2.9\n0.0205,11,-1,3\n")
    run("-d", 0.05, "--torque", table, "--sample-period", 0.01, "--save", tmp_path / "run.npz")
    torque = np.tile([0.3, 11.5, 2.9], (51, 1))
    torque[21:] = [-1.0, 11.0, 3.0]
    expected = simulate(load_scene(SCENE), torque, duration=0.05)
    saved = np.load(tmp_path / "run.npz")
    np.testing.assert_array_equal(saved["joint_position"], expected.joint_position[::10])
    np.testing.assert_array_equal(saved["torque"], torque[::10])


def test_the_table() -> None:
    shown = flexsim("simulate", SCENE, "-d", "0.01", timeout=240).stdout
    for word in ("joint_3", "tip deflection", "energy", "step time"):
        assert word in shown


def test_trouble_is_said(tmp_path: Path) -> None:
    """A run that stops before its time ends with code 1 and the reason."""
    words = ["--set", "solver.method=runge_kutta_4", "--set", "solver.step=1e-3"]
    done = flexsim("simulate", SCENE, *words, timeout=240)
    assert done.returncode == 1
    assert "stopped at" in done.stderr


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        (["nowhere.yaml"], 1, "nowhere.yaml does not exist"),
        ([SCENE, "--set", "solver.step"], 2, "KEY=VALUE"),
        ([SCENE, "--set", "solver.stp=1e-3"], 1, "did you mean 'step'?"),
        ([SCENE, "--save", "no/run.npz"], 1, "no does not exist"),
        ([SCENE, "--torque", "none.csv"], 1, "none.csv does not exist"),
        ([SCENE, "--torque", "names.csv"], 1, "give t, joint_1, joint_2, joint_3"),
        ([SCENE, "--torque", "words.csv"], 1, "give numbers"),
        ([SCENE, "--torque", "short.csv"], 1, "rows of 4 finite numbers"),
        ([SCENE, "--torque", "nan.csv"], 1, "rows of 4 finite numbers"),
        ([SCENE, "--torque", "back.csv"], 1, "t does not rise"),
    ],
)
def test_mistakes(words: list[object], code: int, sentence: str, tmp_path: Path) -> None:
    """One sentence, the right exit code, no traceback."""
    (tmp_path / "names.csv").write_text("t,a,b,c\n0,1,2,3\n")
    (tmp_path / "words.csv").write_text("0,1,2,three\n")
    (tmp_path / "short.csv").write_text("0,1,2\n")
    (tmp_path / "nan.csv").write_text("0,1,2,nan\n")
    (tmp_path / "back.csv").write_text("0,1,2,3\n0,1,2,3\n")
    done = flexsim_here("simulate", *words, "-d", "0.01", cwd=tmp_path)
    assert done.returncode == code, done.stderr
    assert sentence in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stderr.strip().count("\n") <= 3
