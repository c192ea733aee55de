"""Signals end nodes and verbs well at any time of their start: 0, or 130 of a verb, and no traceback."""

from __future__ import annotations

import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from door_process import SCENE as DOOR
from flexsim_ros.first_instant import code_of
from processes import command, ros_environment
from robot_process import SCENE as ROBOT

pytestmark = pytest.mark.ros
BIN = Path(sys.executable).parent
PENDULUM = ROBOT.with_name("simple_pendulum.yaml")
COLUMN = DOOR.with_name("thesis_door_column.yaml")
NODES = {
    "flexsim_node": [str(BIN / "flexsim_node"), "--ros-args", "-p", f"scene:={PENDULUM}"],
    "flexsim_node.node": [
        sys.executable,
        "-m",
        "flexsim_node.node",
        "--ros-args",
        "-p",
        f"scene:={PENDULUM}",
    ],
    "thermal_node": [str(BIN / "thermal_node"), "--ros-args", "-p", f"scene:={COLUMN}"],
}
VERBS = {
    "record": ["record", "-o", "bag"],
    "simulate": ["simulate", str(PENDULUM), "--duration", "1000"],
    "accuracy": ["accuracy", str(PENDULUM), "--quick"],
    "effects": ["effects", str(PENDULUM)],
    "modes": ["modes", str(PENDULUM)],
    "hardcases": ["hardcases"],
    "door": ["door", "simulate", str(COLUMN)],
    "view": ["view", str(PENDULUM), "--save", "view.rrd"],
    "demo": ["demo", "--duration", "2"],
    "bench-controller": ["bench-controller", "joint_pd", str(ROBOT)],
}
SIGNALS = (signal.SIGINT, signal.SIGTERM)
TENTHS = [0.1 * k for k in range(100)]
PATIENCE = 120.0


def begun(process: subprocess.Popen[str]) -> bool:
    """Whether Python has read the first of our files, before which signals have their default effect."""
    try:
        status = Path(f"/proc/{process.pid}/status").read_text()
    except OSError:
        return True
    masks = {line.split(":")[0]: int(line.split()[1], 16) for line in status.splitlines()
             if line.startswith(("SigBlk", "SigCgt"))}  # fmt: skip
    bits = sum(1 << (number - 1) for number in SIGNALS)
    return bool((masks.get("SigBlk", bits) | masks.get("SigCgt", 0)) & bits == bits)


def stop(
    words: list[str], number: signal.Signals, after: float, folder: Path, **more: str
) -> tuple[int, str]:
    """Start a program, send it a signal so long after Python has begun, s; its exit code and what it said."""
    process = subprocess.Popen(words, env=ros_environment() | more, cwd=folder, stdin=subprocess.DEVNULL,
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)  # fmt: skip
    while not begun(process):
        time.sleep(0.002)
    time.sleep(after)
    process.send_signal(number)
    try:
        _, said = process.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        process.kill()
        raise
    return process.returncode, said


def check(
    words: list[str], number: signal.Signals, after: float, folder: Path, codes: tuple[int, ...]
) -> None:
    """A signal so long after the start: one of these codes and no traceback."""
    code, said = stop(words, number, after, folder)
    assert code in codes, (after, number, code, said)
    assert "Traceback" not in said and "Exception ignored" not in said, (after, number, said)


@pytest.mark.parametrize(
    ("after", "number"), [(0.0, signal.SIGTERM), (0.3, signal.SIGINT), (1.0, signal.SIGTERM)]
)
@pytest.mark.parametrize("node", NODES)
def test_a_node_as_it_starts(node: str, after: float, number: signal.Signals, tmp_path: Path) -> None:
    """While Python starts, while it imports, while it is built."""
    check(NODES[node], number, after, tmp_path, (0,))


@pytest.mark.parametrize("verb", ["record", "simulate", "demo"])
def test_a_verb_as_it_starts(verb: str, tmp_path: Path) -> None:
    """130, as the shell expects of what was stopped before it did something; record's ordinary end is 0."""
    for after, number in ((0.0, signal.SIGINT), (0.5, signal.SIGTERM)):
        check(command(*VERBS[verb]), number, after, tmp_path, (130, 0) if verb == "record" else (130,))


def test_while_kernels_compile(tmp_path: Path) -> None:
    """It is said that it compiles, and a signal then ends it, whatever the compiler is at."""
    words = [sys.executable, "-m", "flexsim_node.node", "--ros-args", "-p", f"scene:={PENDULUM}"]
    process = subprocess.Popen(
        words, env=ros_environment() | {"NUMBA_CACHE_DIR": str(tmp_path / "empty")}, cwd=tmp_path,
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=(tmp_path / "said").open("w"),
    )  # fmt: skip
    end = time.monotonic() + PATIENCE
    while "compiling the equations" not in (tmp_path / "said").read_text():
        assert process.poll() is None and time.monotonic() < end, (tmp_path / "said").read_text()
        time.sleep(0.05)
    process.send_signal(signal.SIGTERM)
    assert process.wait(PATIENCE) == 0
    assert "Traceback" not in (tmp_path / "said").read_text()


def test_whose_command_line_is_ours() -> None:
    """Only our programs' signals are taken early; any other Python in the environment keeps its own."""
    python = sys.executable
    assert code_of([python, "/somewhere/bin/flexsim_node", "--ros-args"]) == 0
    assert code_of([python, "-X", "dev", "-m", "thermal_node.node"]) == 0
    assert code_of([python, "-u", "/somewhere/bin/flexsim", "info", "run"]) == 130
    for words in (
        ["-m", "pytest", "flexsim_node"],
        ["-c", "import flexsim"],
        ["tests/flexsim_node/x.py"],
        [],
    ):
        assert code_of([python, *words]) is None


@pytest.mark.nightly
@pytest.mark.parametrize("number", SIGNALS)
@pytest.mark.parametrize("program", [*NODES, *VERBS])
def test_each_tenth_of_ten_seconds(program: str, number: signal.Signals, tmp_path: Path) -> None:
    """From Python's first file on, at each 0.1 s of the first ten seconds."""
    for k, after in enumerate(TENTHS):
        folder = tmp_path / str(k)
        folder.mkdir()
        words = NODES.get(program) or command(*VERBS[program])
        check(words, number, after, folder, (0,) if program in NODES else (0, 130))
        shutil.rmtree(folder)
