"""The benchmarks of bags run, and nothing is lost in them; their figures are for a quiet machine."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from processes import ros_environment

pytestmark = pytest.mark.ros

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"


@pytest.mark.parametrize(
    "words", [["recorder_share", "--seconds", "1"], ["bag_conversion", "--minutes", "0.02"]]
)
def test_a_short_run(words: list[str]) -> None:
    program = BENCHMARKS / f"{words[0]}.py"
    done = subprocess.run(
        [sys.executable, str(program), *words[1:], "--json"],
        env=ros_environment(), capture_output=True, text=True, timeout=100,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    if words[0] == "recorder_share":
        assert set(found["missing"].values()) == {0}
        assert 0.0 < found["share_of_a_core"] < 1.0
    else:
        assert found["rows"]["joints/position"] == 1200
