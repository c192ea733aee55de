"""The programs of examples/ run as they stand, and print what examples/README.md shows."""

from __future__ import annotations

import re
import runpy
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
from flexsim.bag import BagWriter

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "examples"
PROGRAMS = sorted(EXAMPLES.glob("*.py"))
SHOWN = re.compile(r"^## (\w+\.py)\n\n\[Program\]\(\1\)(.*?)^```text\n(.*?)^```", re.DOTALL | re.MULTILINE)
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
LONGEST = 60  # lines of a program: one idea each
pytestmark = pytest.mark.slow


def recorded(folder: Path) -> Path:
    """A bag of a joint that swings, a second at 100 Hz."""
    from made_bags import Topics, joint_state

    path = folder / "run"
    with BagWriter(path) as bag:
        topics = Topics(bag)
        for t in np.arange(0.0, 1.0, 0.01):
            swing = 0.5 * np.sin(6.0 * t), 3.0 * np.cos(6.0 * t)
            data = joint_state(t, ["joint_1", "joint_2"], [swing[0], 0.1], [swing[1], 0.0], [0.0, 0.0])
            topics.write("/joint_states", data, t)
    return path


def same(line: str, shown: str) -> bool:
    """Whether two lines have the same words, and numbers that agree to 2 %, or to 5 of their last digits."""
    if NUMBER.sub("#", line).split() != NUMBER.sub("#", shown).split():
        return False
    for one, other in zip(NUMBER.findall(line), NUMBER.findall(shown), strict=True):
        digits = len(other.partition("e")[0].partition(".")[2])
        slack = 5.0 * 10.0**-digits if "e" not in other else 0.0
        # an exponent is rounding itself: the same size is asked
        near = 0.02 if "e" not in other else 10.0
        if abs(float(one) - float(other)) > near * abs(float(other)) + slack:
            return False
    return True


@pytest.mark.parametrize(
    "program",
    [
        pytest.param(path, id=path.stem, marks=pytest.mark.ros if path.stem == "read_a_bag" else ())
        for path in PROGRAMS
    ],
)
def test_example(
    program: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    bag = [str(recorded(tmp_path))] if program.stem == "read_a_bag" else []
    monkeypatch.setattr(sys, "argv", [str(program), *bag])
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(program), run_name="__main__")
    printed = capsys.readouterr().out.splitlines()
    pictures = [line.removeprefix("picture: ") for line in printed if line.startswith("picture: ")]
    assert all(Path(picture).stat().st_size > 5000 for picture in pictures)
    shown = {name: text for name, _, text in SHOWN.findall((EXAMPLES / "README.md").read_text())}
    wanted = [line for line in shown[program.name].splitlines() if not line.startswith("picture: ")]
    printed = [line for line in printed if not line.startswith("picture: ")]
    assert len(printed) == len(wanted), "\n".join(printed)
    off = [(a, b) for a, b in zip(printed, wanted, strict=True) if not same(a, b)]
    assert not off


def test_the_list_of_examples_is_whole() -> None:
    """Each has one heading with what it prints, is short, and says in one line what it shows."""
    page = (EXAMPLES / "README.md").read_text()
    assert [name for name, _, _ in SHOWN.findall(page)] == [path.name for path in PROGRAMS]
    for path in PROGRAMS:
        text = path.read_text()
        assert len(text.splitlines()) < LONGEST, path.name
        assert f"| [{path.name}](#{path.stem}py) |" in page


@pytest.mark.parametrize(
    ("line", "shown", "agree"),
    [
        ("a 1.00 b", "a 1.01 b", True),
        ("a 1.00 b", "a 1.10 b", False),
        ("a 0.003", "a 0.000", True),
        ("a 0.013", "a 0.000", False),
        ("a 1.0 c", "a 1.0 b", False),
        ("balance to 5e-10", "balance to 9e-10", True),
    ],
)
def test_lines_are_compared(line: str, shown: str, agree: bool) -> None:
    assert same(line, shown) is agree
