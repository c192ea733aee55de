"""The hard cases hold, and their page names them all."""

import json
import subprocess
import sys
import warnings
from pathlib import Path

import pytest
from flexsim.hard_cases import all_cases

CASES = {case.name: case for case in all_cases()}
PAGE = Path(__file__).parents[2] / "docs" / "hard_cases.md"


@pytest.mark.parametrize("name", CASES)
def test_case_holds(name):
    """Bounded, balanced, right, or stopped for the right reason."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        outcome = CASES[name].play()
    assert outcome.held, f"{outcome.ended} {outcome.figures}"


def test_there_are_many():
    """More than sixty, each with its own name and a sentence on why it is hard and what must hold."""
    assert len(CASES) == len(all_cases()) > 60
    assert all(case.why and case.holds for case in CASES.values())


def test_page_is_current():
    """docs/hard_cases.md has a row for every case, with its words."""
    rows = [line for line in PAGE.read_text().splitlines() if line.startswith("| `")]
    assert rows == [f"| `{c.name}` | {c.why} | {c.holds} |" for c in CASES.values()]


def run(*words):
    return subprocess.run(
        [sys.executable, "-c", "from flexsim.cli import main; main()", "hardcases", *words],
        capture_output=True,
        text=True,
        check=False,
    )


def test_verb_lists_and_plays():
    """A name or a pattern chooses; what does not exist is refused."""
    listed = json.loads(run("--list", "--json").stdout)
    assert set(listed) == set(CASES)
    played = run("*_furnace_log", "zero_conductivity", "--json")
    assert played.returncode == 0
    found = json.loads(played.stdout)
    assert len(found["cases"]) == 3 and not found["failed"]
    assert "gap_in_furnace_log" in run("*_furnace_log").stdout
    wrong = run("no_such_case")
    assert wrong.returncode == 2 and "no_such_case" in wrong.stderr
