"""`flexsim modes` prints and saves what the Python interface gives."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from processes import flexsim, flexsim_here

from flexsim_node import LinearModel, linearize, load_scene, natural_frequencies

SCENE = Path(__file__).parents[2] / "config" / "anthropomorphic.yaml"
POSE = [0.0, 0.5, -0.8]


def test_figures_and_file(tmp_path: Path) -> None:
    """Frequencies, their change over a grid, and a linear model to load."""
    words = ["--position", "0,0.5,-0.8", "--grid", "joint_3=-1:1:3", "--output", "tip_acceleration"]
    done = flexsim("modes", SCENE, *words, "--save", tmp_path / "m.npz", "--json", timeout=240)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    scene = load_scene(SCENE)
    right = natural_frequencies(scene, POSE)
    assert [mode["frequency"] for mode in said["modes"]] == pytest.approx(right[:8])
    places = [[0.0, 0.5, q] for q in (-1.0, 0.0, 1.0)]
    grid = natural_frequencies(scene, places)
    assert grid.shape == (3, len(right))
    assert said["grid"]["lowest"] == pytest.approx(grid.min(axis=0)[:8])
    assert said["grid"]["change"][0] == pytest.approx(grid[:, 0].max() / grid[:, 0].min() - 1)
    model = LinearModel.load(tmp_path / "m.npz")
    expected = linearize(scene, POSE, ["tip_acceleration"])
    assert said["linear"]["outputs"] == [f"tip_acceleration/{k}" for k in "xyz"]
    assert np.allclose(model.A, expected.A, rtol=1e-9, atol=1e-6 * np.abs(expected.A).max())
    assert np.allclose(model.D, expected.D, rtol=1e-6)
    saved = np.load(tmp_path / "m.npz")
    assert saved["shape"].shape == (len(right), 9, 3)
    assert saved["grid_frequency"].shape == (3, len(right))
    shares = [sum(sum(link.values()) for link in mode["share"].values()) for mode in said["modes"]]
    assert shares == pytest.approx([1.0] * 8, abs=1e-6)  # all of the energy is in the beams


def test_the_table() -> None:
    shown = flexsim("modes", SCENE, "--free", "--count", "5", timeout=240).stdout
    assert "joints free" in shown
    assert "rigid" in shown
    assert "link_1 bending_y 99 %" in shown


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        (["--position", "0,1"], 2, "give 3 numbers: joint_1,joint_2,joint_3"),
        (["--position", "0,1,nan"], 2, "give 3 numbers"),
        (["--grid", "joint_3=0:1"], 2, "give JOINT=FROM:TO:COUNT"),
        (["--grid", "elbow=0:1:3"], 2, "give one of joint_1"),
        (["--output", "tip_positon", "--save", "m.npz"], 1, "did you mean 'tip_position'"),
        (["--plot", "no/m.png"], 1, "no does not exist"),
    ],
)
def test_mistakes(words: list[str], code: int, sentence: str, tmp_path: Path) -> None:
    """One sentence, the right exit code, no traceback."""
    done = flexsim_here("modes", SCENE, *words, cwd=tmp_path)
    assert done.returncode == code, done.stderr
    assert sentence in done.stderr
    assert "Traceback" not in done.stderr
