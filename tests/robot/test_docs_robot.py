"""The pages on the robot's physics and on many runs: their Python runs as printed, and commands work."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "robot.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", PAGE, flags=re.DOTALL)
LINES = [line for kind, block in BLOCKS if kind == "bash" for line in block.splitlines()]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of its own where the page's paths lead to the scenes."""
    (tmp_path / "config").symlink_to(ROOT / "config")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("block", [block for kind, block in BLOCKS if kind == "python"])
def test_python(block, folder):
    exec(compile(block, "robot.md", "exec"), {})


@pytest.mark.parametrize("line", LINES)
def test_commands(line, folder):
    program, *words = shlex.split(line)
    assert program == "flexsim"
    start = [sys.executable, "-c", "from flexsim.cli import main; main()"]
    done = subprocess.run([*start, *words], capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr
    for flag in ("--save", "--plot"):
        if flag in words:
            assert (folder / words[words.index(flag) + 1]).stat().st_size > 1000


@pytest.mark.parametrize("name", ["many_runs", "learning"])
def test_many_runs(name, folder, capsys):
    """A page's blocks, one after the other, print what it shows."""
    page = (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")
    shown = re.findall(r"```(\w+)\n(.*?)```", page, flags=re.DOTALL)
    space = {}
    for kind, block in shown:
        if kind == "python":
            exec(compile(block, f"{name}.md", "exec"), space)
    assert [block for kind, block in shown if kind == "text"] == [capsys.readouterr().out]
