"""The benchmarks run, and the cheap models keep their targets of processor time."""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def test_speed_of_the_cheap_models():
    done = subprocess.run(
        [sys.executable, "benchmarks/door_speed.py", "--smoke", "--json"],
        cwd=ROOT,
        env={"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"},
        capture_output=True,
        text=True,
        check=True,
    )
    found = json.loads(done.stdout)
    for row in found["rows"]:
        assert row["processor_s"] < 3.0 * row["target_s"], row  # a loaded machine may be slow
        assert row["worst_heat_balance"] < 1e-6
    assert found["memory_mib"] < 1024
