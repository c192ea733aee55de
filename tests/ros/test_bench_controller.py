"""`flexsim bench-controller`: what its page says, two controllers side by side, and one that fails."""

from __future__ import annotations

import json
import os
import re
import shlex
import signal
import sys
import time
from concurrent.futures import Future
from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from flexsim.bench import rig as bench_rig
from flexsim.bench.rig import Rig, missing, recorded, stamp
from flexsim.bench.score import Recording
from flexsim.bench.session import NOMINAL, Session
from flexsim.controller.trajectory import Trajectory
from flexsim.terminal.stop import stopped_by_signals
from flexsim.trial.processes import processes
from processes import flexsim
from sensor_msgs.msg import JointState

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "controllers.md").read_text()
LINES = re.findall(r"^flexsim bench-controller .*$", PAGE, re.MULTILINE)
pytestmark = [pytest.mark.ros, pytest.mark.slow]


def test_the_commands_of_the_page(tmp_path: Path) -> None:
    """The one that draws: its picture and its scores are there, and LQG swings less than PD."""
    words = shlex.split(next(line for line in LINES if "bench.png" in line))[1:]
    words[words.index("bench.png")] = str(tmp_path / "bench.png")
    scene = words.index("config/anthropomorphic_geared.yaml")
    words[scene] = str(ROOT / words[scene])
    done = flexsim(*words, "--json", timeout=400)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    pd, lqg = found["controllers"]["joint_pd"]["scores"], found["controllers"]["lqg"]["scores"]
    assert not any(run["lost"] for scores in (pd, lqg) for run in scores.values())
    assert set(pd) == {"nominal", "push"}
    for case in pd:
        assert lqg[case]["vibration"] < 0.5 * pd[case]["vibration"]
        assert lqg[case]["settling"] < pd[case]["settling"]
    assert (tmp_path / "bench.png").stat().st_size > 10_000


def test_a_controller_that_says_nothing(tmp_path: Path) -> None:
    """It is lost, in words and by the exit code, and the bench does not wait for ever."""
    silent = tmp_path / "silent.py"
    silent.write_text("import sys\nsys.exit(3)\n")
    scene = ROOT / "config" / "anthropomorphic_geared.yaml"
    done = flexsim("bench-controller", str(silent), scene, "--no-latency", "--only", "push", timeout=300)
    assert done.returncode == 1
    assert "exit code 3" in done.stderr


def test_a_controller_that_knows_no_signals(tmp_path: Path) -> None:
    """It dies of the one that asks it to end, as most do: an end, but none of a recorder."""
    words = [
        sys.executable,
        "-c",
        "import sys, time; print('up', file=sys.stderr, flush=True); time.sleep(60)",
    ]
    with stopped_by_signals() as stopped, processes(tmp_path, dict(os.environ), stopped) as trial:
        for name, end in (("first", trial.dismiss), ("second", trial.end)):
            process = trial.start(name, words)
            trial.wait_until_said(process, "up", timeout=20.0)
            with pytest.raises(RuntimeError, match="exit code -2") if name == "second" else nullcontext():
                end(process)
            assert process.code == -signal.SIGINT
        assert not trial.running


def test_a_run_is_of_its_own_states() -> None:
    """What the last run left on its way is not taken for the next one's, which begins at time zero."""
    rig = object.__new__(Rig)
    rig.rate, run = 1000.0, []
    take = rig.taken(run)
    for nanoseconds in (2_099_000_000, 2_100_000_000, 1, 1_000_000, 2_000_000):
        message = JointState()
        message.header.stamp.sec, message.header.stamp.nanosec = divmod(nanoseconds, 10**9)
        take(message)
    assert [stamp(message) for message in run] == [1e-9, 1e-3, 2e-3]


def test_states_that_did_not_arrive_are_missed() -> None:
    """A run with a gap is not scored, but run again, and given up where that is of no use."""

    def state(k: int, **fields: list[float]) -> SimpleNamespace:
        stamp = SimpleNamespace(sec=0, nanosec=max(1, 10_000_000 * k))
        return SimpleNamespace(header=SimpleNamespace(stamp=stamp), **fields)

    def run(times: list[int]) -> Recording:
        states = [state(k, position=[0.0], velocity=[0.0], effort=[0.0]) for k in times]
        shapes = [state(k, position=[0.0] * 3, rigid_position=[0.0] * 3) for k in range(11)]
        return recorded(states, shapes, 0.1, "", 100.0)

    whole, gap = run([*range(11)]), run([0, 1, 2, 5, 6, 7, 8, 9, 10])
    assert (whole.missing, gap.missing) == (0, 2)
    runs = [gap, whole]
    session = object.__new__(Session)
    session.rig = SimpleNamespace(run=lambda *_: runs.pop(0))
    said: list[str] = []
    session.say, session.scene, session.until = said.append, None, 0.1
    session.wanted = Trajectory(np.array([0.0, 0.05]), np.zeros((2, 1)), np.zeros((2, 1)))
    session.recordings, session.scores = {"pd": {}}, {"pd": {}}
    session._run("pd", NOMINAL)
    assert session.recordings["pd"]["nominal"] is whole
    assert "2 states did not reach the bench; once more" in said[1]
    session.rig = SimpleNamespace(run=lambda *_: gap)
    with pytest.raises(RuntimeError, match="the machine is too busy"):
        session._run("pd", NOMINAL)


def test_an_answer_that_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """The question is asked again, and the client is given back."""
    monkeypatch.setattr(bench_rig, "AGAIN", 0.05)
    lost, told = Future(), Future()
    told.set_result("here")
    futures, given_back = [lost, told], []
    client = SimpleNamespace(service_is_ready=lambda: True, call_async=lambda _: futures.pop(0))
    rig = object.__new__(Rig)
    rig.trial = SimpleNamespace(check=lambda: None)
    rig.hear = lambda: time.sleep(0.01)
    rig.node = SimpleNamespace(create_client=lambda *_: client, destroy_client=given_back.append)
    assert rig.call(None, "reset_simulation", None) == "here"
    assert (futures, given_back) == ([], [client])


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--goal", "1.0"], "the goal has 1 values for 3 joints"),
        (["--against", "joint_pd"], "NODE and --against are the same"),
        (["--against", "joint_pid"], "there is no program 'joint_pid'"),
        (["--only", "pull"], "'pull' is not one of"),
        (["--set", "links.link_1.joint.rotor_inertia=much"], "give a number"),
    ],
)
def test_wrong_words(words: list[str], sentence: str) -> None:
    done = flexsim("bench-controller", "joint_pd", ROOT / "config" / "anthropomorphic_geared.yaml", *words)
    assert done.returncode == 2
    assert sentence in done.stderr


@pytest.mark.parametrize(
    ("times", "count"),
    [
        ([], 0),
        ([0.0, 0.01, 0.02], 0),
        ([0.0, 0.01, 0.03], 1),
        ([0.0, 0.01, 0.013], 0),
        ([0.0, 0.02, 0.025], 1),
    ],
)
def test_states_that_are_missing(times, count):
    """Counted in periods up to the last one: where a solver stops between two, its state is one more."""
    assert missing(times, 100.0) == count
