"""The command answers at once, and its exit codes and sentences can be relied on."""

from __future__ import annotations

import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from processes import Background, Recorded, command, flexsim, ros_environment

VERBS = ["info", "record", "report", "sweep", "view"]


def test_help_is_quick_and_light() -> None:
    """`flexsim --help` takes under 0.3 s of one core and loads none of the heavy packages."""
    spent = []
    for _ in range(3):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        shown = flexsim("--help")
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent.append(after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
    assert shown.returncode == 0
    for verb in VERBS:
        assert f"  {verb} " in shown.stdout
    assert min(spent) < 0.3

    program = (
        "import sys; from flexsim.cli import flexsim; flexsim(['--help'], standalone_mode=False);"
        "print('heavy:', sorted({'rclpy', 'numba', 'numpy', 'rerun', 'rich'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert "heavy: []" in done.stdout


@pytest.mark.parametrize("verb", VERBS)
def test_every_verb_has_an_example(verb: str) -> None:
    shown = flexsim(verb, "--help")
    assert shown.returncode == 0
    assert f"Example:\n    flexsim {verb}" in shown.stdout
    assert "--json" in shown.stdout


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        (["recrod"], 2, "Did you mean 'record'?"),
        (["info"], 2, "Missing argument"),
        (["record", "--duration", "-1"], 2, "--duration"),
        (["view", "run", "--save", "a.rrd", "--serve"], 2, "Give one of --save, --serve and --web"),
        (["info", "nowhere"], 1, "nowhere does not exist"),
        (["view", "nowhere", "--save", "a.rrd"], 1, "nowhere does not exist"),
        (["info", "notes.txt"], 1, "notes.txt is not an MCAP file"),
        (["view", "notes.txt", "--save", "a.rrd"], 1, "notes.txt is not an MCAP file"),
        (["info", "folder"], 1, "folder is not a bag"),
        (["view", "notes.txt"], 1, "there is no display"),
    ],
)
def test_mistakes(words: list[str], code: int, sentence: str, tmp_path: Path) -> None:
    """A mistake gets one clear sentence, the right exit code, and leaves nothing behind."""
    (tmp_path / "notes.txt").write_text("not a bag at all")
    (tmp_path / "folder").mkdir()
    done = flexsim(*words, cwd=tmp_path)
    assert done.returncode == code
    assert sentence in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "a.rrd").exists()


def test_what_libraries_print_is_no_result() -> None:
    """Fast DDS says its troubles on standard output; a program that reads --json must not find them there."""
    script = """
import os
from flexsim.terminal.own_output import own_output
own_output()
os.write(1, b"a library\\n")
print("ä result")
"""
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, encoding="utf-8", check=True)
    assert (said.stdout, said.stderr) == ("ä result\n", "a library\n")
    closed = subprocess.run(["sh", "-c", 'exec "$@" >&-', "sh", *command("--help")], capture_output=True)
    assert (closed.returncode, closed.stderr) == (0, b"")


def test_ctrl_c(recorded: Recorded, tmp_path: Path) -> None:
    """Ctrl-C is the ordinary end of what is served: 0, and no traceback."""
    words = command("view", recorded.bag, "--serve")
    serving = Background(words, ros_environment(), tmp_path)
    serving.wait_for("look at it with")
    time.sleep(0.1)
    assert serving.end(signal.SIGINT) == 0
    assert "Traceback" not in serving.errors.read_text()
