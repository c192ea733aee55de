"""`flexsim effects` prints what each effect changes and costs, and what `auto` makes of it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from processes import flexsim, flexsim_here

SCENE = Path(__file__).parents[2] / "config" / "planar_double_pendulum.yaml"


def test_every_effect_has_its_row() -> None:
    """Each effect, each link's flexibility, and three dofs a node against six."""
    words = ["--duration", "0.2", "--tolerance", "1e-4", "--set", "effects=auto", "--json"]
    done = flexsim("effects", SCENE, *words, timeout=400)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    rows = {row["effect"]: row for row in said["effects"]}
    assert {"gravity", "bending_z", "shear", "damping", "flexible: link_1", "flexible: link_2"} <= set(rows)
    assert rows["gravity"]["verdict"] == "keep"
    assert rows["gravity"]["change"] > 0.01
    assert rows["torsion"]["change"] == 0.0
    assert rows["torsion"]["verdict"] == "can go"
    assert rows["gravity"]["relative"] == pytest.approx(rows["gravity"]["change"] / said["reach"])
    assert said["space_ratio"] > 1.2
    # so stiff an arm is the same in both formulations, as its own study finds
    assert 0.0 <= said["formulation"]["distance"] < 1e-4
    assert said["formulation"]["other"] == "co_moving"
    assert "torsion" in said["decision"]["left_out"]
    assert said["decision"]["together"] <= 1e-4
    for row in rows.values():
        if row["cost"] is not None:  # a cost is a figure only beyond its spread
            assert abs(row["cost"]) > row["cost_spread"] > 0.0
        else:
            assert not row["measurable"]


def test_the_table() -> None:
    """Without `auto` in the scene: verdicts against a default tolerance, also for what is off."""
    done = flexsim("effects", SCENE, "--duration", "0.1", timeout=400)
    assert done.returncode == 0, done.stderr
    for words in ("tolerance 0.1 mm", "flexible: link_2", "costs, µs a step", "verdict", "six would cost"):
        assert words in done.stdout


def test_a_formulation_left_to_auto(tmp_path: Path) -> None:
    """The one taken, how far the ERLS is from co-moving frames, and what the other's steps cost."""
    words = ["--duration", "0.05", "--set", "formulation=auto", "--set", "tolerance=1e-4",
             "--set", "damping.alpha=0"]  # fmt: skip
    done = flexsim("effects", SCENE, *words, "--json", timeout=400)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    taken = said["decision"]["formulation"]
    assert taken["taken"] in ("erls", "co_moving")
    assert taken["sentence"].startswith(f"formulation: {taken['taken']}; ")
    assert said["formulation"]["own"] == taken["taken"]
    assert {said["formulation"]["own"], said["formulation"]["other"]} == {"erls", "co_moving"}
    assert said["formulation"]["cost_ratio"] > 0.0
    assert said["decision"]["effects"] is None
    table = flexsim("effects", SCENE, *words, timeout=400)
    assert "auto: formulation: " in table.stdout
    assert "times as much" in table.stdout
    refused = flexsim_here("simulate", SCENE, "--set", "formulation=auto", "-d", "0.01", cwd=tmp_path)
    assert refused.returncode == 1
    assert "formulation: is auto, but the scene has no tolerance to decide by" in refused.stderr


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        (["--tolerance", "0"], 2, "tolerance"),
        (["--bag", "nowhere"], 1, "nowhere"),
        (["--set", "effects.gravity=maybe"], 1, "give true, false or auto"),
        (["--set", "solver.method=runge_kutta_4", "-d", "0.1"], 1, "stopped at"),
    ],
)
def test_mistakes(words: list[str], code: int, sentence: str, tmp_path: Path) -> None:
    """One sentence, the right exit code, no traceback."""
    done = flexsim_here("effects", SCENE, *words, cwd=tmp_path)
    assert done.returncode == code, done.stderr
    assert sentence in done.stderr
    assert "Traceback" not in done.stderr
