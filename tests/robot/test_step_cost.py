"""The benchmark of a step runs and says what it promises; its figures are not judged here."""

import json
import subprocess
import sys
from pathlib import Path


def test_formulation_cost_smoke():
    """Each scene in both formulations, and the ratio of their steps with its spread."""
    script = Path(__file__).parents[2] / "benchmarks" / "formulation_cost.py"
    done = subprocess.run(
        [sys.executable, script, "--quick", "--json"], capture_output=True, text=True, check=True
    )
    found = json.loads(done.stdout)
    assert {row["elements"] for row in found} == {1, 2}
    assert {row["scene"].rpartition(", ")[2] for row in found} == {"chord", "root"}
    assert all(row["ratio"] > 0.0 and row["erls_us"] > 0.0 for row in found)


def test_step_cost_smoke():
    script = Path(__file__).parents[2] / "benchmarks" / "step_cost.py"
    done = subprocess.run(
        [sys.executable, script, "--quick", "--json"], capture_output=True, text=True, check=True
    )
    found = json.loads(done.stdout)
    assert found["machine"]["numba"]
    assert set(found["robots"]) == {"anthropomorphic", "planar_double_pendulum"}
    for figures in found["robots"].values():
        assert figures["loop_us"] > 0
        assert 0 < figures["call_median_us"] <= figures["call_p99_us"]
    assert set(found["chains"]["spatial"]["links"]) == {"2", "4"}
    assert found["memory_mb"] > 0
