"""Nobody waits without end: the bench beside robots and controllers that stop, die, hang or are refused."""

from __future__ import annotations

import json
import os
import shlex
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
import rclpy
from flexsim.bench import rig as bench_rig
from flexsim.bench.cases import Case, move
from flexsim.bench.rig import Rig, rig
from flexsim.bench.score import score
from flexsim.replay.lockstep import Driver, Stopped
from flexsim.ros import simulator
from flexsim.ros.simulator import SimulatorWatch
from flexsim.terminal.stop import stopped_by_signals
from flexsim_ros import SimulatorStatus
from listening import PATIENCE, node_words
from processes import Background, command, ros_environment
from simulation_interfaces.msg import SimulationState
from simulation_interfaces.srv import SetSimulationState

from flexsim_node import Scene, load_scene

ROOT = Path(__file__).parents[2]
SCENE = ROOT / "config" / "simple_pendulum.yaml"
MISBEHAVING = Path(__file__).with_name("misbehaving_controller.py")
RATE, UNTIL = 100.0, 0.6
LIMITS = {"warn": 1e-10, "stop": 1e-9}  # rad, which a beam that bears its weight passes at once
STOPS = {f"override__validity__elastic_rotation__{name}": value for name, value in LIMITS.items()}
pytestmark = [pytest.mark.ros, pytest.mark.slow]


def controller(how: str) -> str:
    return shlex.join([sys.executable, str(MISBEHAVING), how])


@pytest.fixture(scope="module")
def scene() -> Scene:
    return load_scene(SCENE)


@pytest.fixture
def short_patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four seconds in which a controller does nothing, for ten."""
    monkeypatch.setattr(bench_rig, "IDLE", 4.0)


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rig]:
    before = dict(os.environ)
    with (
        stopped_by_signals() as stopped,
        rig(tmp_path_factory.mktemp("rig"), SCENE, {}, RATE, stopped) as one,
    ):
        yield one
    os.environ.clear()
    os.environ.update(before)


def run(bench: Rig, scene: Scene, how: str) -> tuple[str, float]:
    """Why the run with a controller had no end, and how long it took, s."""
    begun = time.monotonic()
    found = bench.run(controller(how), Case("nominal", ""), move(scene, None, 0.2), UNTIL, scene)
    judged = score(found, move(scene, None, 0.2), UNTIL)
    assert bool(found.trouble) <= judged.lost
    assert judged.reason.startswith(found.trouble)
    return found.trouble, time.monotonic() - begun


@pytest.mark.usefixtures("short_patience")
@pytest.mark.parametrize(
    ("how", "sentence"),
    [
        ("dies", "ended with exit code 3: [ERROR] a cable is loose"),
        ("nan", "the robot refuses its commands: a value is not finite"),
        ("wrong_length", "the robot refuses its commands: 2 values for 1 joints"),
        ("pushes", "the solver has stopped"),
        ("stands", "was stopped by a signal"),
        ("silent", "it has not answered the state at 0 s"),
        ("deaf", "it has not answered the state at 0 s"),
        ("holds", ""),
    ],
)
def test_a_controller_on_the_bench(bench: Rig, scene: Scene, how: str, sentence: str) -> None:
    """One that has no answers is lost with the reason; the next one, of the same robot, is none the worse."""
    trouble, _ = run(bench, scene, how)
    assert sentence in trouble
    assert bool(trouble) == bool(sentence)


@contextmanager
def node(name: str, folder: Path, environment: dict[str, str], **parameters: object) -> Iterator[Background]:
    """A simulator in a process of its own, which is killed afterwards."""
    process = Background(
        node_words(f"{name}.node", parameters.pop("scene"), **parameters), environment, folder
    )
    try:
        process.wait_for("kernels ready", PATIENCE)
        yield process
    finally:
        process.process.kill()
        process.process.wait(20)


@contextmanager
def watch(name: str, environment: dict[str, str]) -> Iterator[Callable[[Callable[[], Any]], Any]]:
    """A tool's watch on a simulator; gives the watch, and a way to wait until something is true."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=int(environment["ROS_DOMAIN_ID"]))
    listener = rclpy.create_node("waiting", context=context)
    found = SimulatorWatch(listener, name)

    def until(condition: Callable[[], Any]) -> Any:
        end = time.monotonic() + PATIENCE
        while not (true := condition()):
            assert time.monotonic() < end, found.status
            found.poll()
            time.sleep(0.01)
        return true

    found.until = until  # type: ignore[attr-defined]
    try:
        yield found  # type: ignore[misc]
    finally:
        listener.destroy_node()
        rclpy.shutdown(context=context)


def test_a_robot_says_how_it_does(tmp_path: Path) -> None:
    """Who comes late hears that the solver has stopped; then of a reset, of a pause, and of the end."""
    environment = ros_environment()
    with node("flexsim_node", tmp_path, environment, scene=SCENE, **STOPS) as robot:
        with watch("flexsim_node", environment) as first:
            first.until(lambda: first.trouble)
            heard = first.status
            assert (heard.phase, heard.resets, heard.scene) == ("stopped", 0, "simple_pendulum")
            assert first.news() == first.trouble
            assert first.trouble.startswith("flexsim_node stands still at ")
            assert "link_1: the elastic rotation reaches" in first.trouble
            assert first.news() == ""
        with watch("flexsim_node", environment) as late:
            late.until(lambda: late.status)
            assert late.status.phase == "stopped"
            assert not late.gone
            ask(late, SetSimulationState, "set_simulation_state", state=SimulationState(state=0))
            late.news()
            late.until(lambda: late.status.phase == "paused" and late.status.resets == 1)
            assert late.trouble == ""
            robot.process.send_signal(signal.SIGINT)
            assert late.until(lambda: late.gone) == "flexsim_node has ended"


def ask(watch: Any, kind: Any, name: str, **fields: Any) -> None:
    """Call a service of the robot."""
    client = watch._node.create_client(kind, f"flexsim_node/{name}")
    watch.until(client.service_is_ready)
    with client.handle:
        client.handle.send_request(kind.Request(**fields))
        watch.until(lambda: client.handle.take_response(kind.Response)[1])


def test_a_door_says_how_it_does(tmp_path: Path) -> None:
    """The end of a test is told with its reason, and a measured furnace that is waited for is no trouble."""
    environment = ros_environment()
    given = {"scene": ROOT / "config" / "thesis_door_column.yaml", "time_scale": 0.0}
    with node("thermal_node", tmp_path, environment, **given, duration=30.0) as door:
        with watch("thermal_node", environment) as heard:
            heard.until(lambda: heard.trouble)
            assert heard.status.phase == "ended"
            assert heard.trouble == "thermal_node stands still at 30 s: the test has ended"
        door.process.kill()
    with (
        node("thermal_node", tmp_path, environment, **given, wait_for_furnace=True),
        watch("thermal_node", environment) as heard,
    ):
        heard.until(lambda: heard.status)
        assert (heard.status.phase, heard.trouble) == ("waiting", "")


def test_who_was_held_up_heard_no_silence(monkeypatch: pytest.MonkeyPatch) -> None:
    """Silence counts in looks: a watcher that did not run for a minute does not call a robot gone."""
    now = [100.0]
    monkeypatch.setattr(simulator, "time", SimpleNamespace(monotonic=lambda: now[0]))
    nobody = SimpleNamespace(create_subscription=lambda *_: SimpleNamespace(topic_name="x"),
                             count_publishers=lambda _: 0)  # fmt: skip
    heard = SimulatorWatch(nobody, "/cell/flexsim_node")
    assert heard.gone == ""  # nobody was there yet
    heard.status = SimulatorStatus("running")
    now[0] += 60.0
    assert heard.gone == ""
    for _ in range(19):
        now[0] += 1.0
        assert heard.gone == ""
    now[0] += 1.0
    assert "nothing was heard of flexsim_node for 10 s" in heard.gone


def bench_words(*words: str) -> list[str]:
    given = ["--move-time", "0.2", "--settle", "0.5", "--rate", str(RATE), "--only", "nominal"]
    return command("bench-controller", controller("holds"), SCENE, *given, "--no-latency", *words)


def children(parent: int) -> dict[str, int]:
    """Numbers of the processes that a process has started, by a word of their command line."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            started_by = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
            line = (folder / "cmdline").read_bytes().decode()
        except (OSError, ValueError):
            continue
        if started_by == parent:
            found["robot" if "flexsim_node.node" in line else "controller"] = int(folder.name)
    return found


@pytest.mark.parametrize(
    ("number", "phase", "code", "sentence"),
    [
        (signal.SIGKILL, "robot", 1, "flexsim_node ended with exit code -9 (SIGKILL)"),
        (signal.SIGSTOP, "robot", 1, "flexsim_node was stopped by a signal and stood still for 3 s"),
        (signal.SIGINT, "start", 130, "stopped: not all runs are done"),
        (signal.SIGINT, "run", 130, "stopped: not all runs are done"),
        (signal.SIGTERM, "run", 130, "stopped: not all runs are done"),
    ],
)
def test_a_bench_that_is_interrupted(
    number: signal.Signals, phase: str, code: int, sentence: str, tmp_path: Path
) -> None:
    """A robot that is killed or stopped, and Ctrl-C: the bench ends with a sentence and leaves no process."""
    bench = Background(bench_words("--json"), ros_environment(), tmp_path)
    started: dict[str, int] = {}
    if phase == "start":
        while not started:
            started = children(bench.process.pid)
    else:
        bench.wait_for("nominal", PATIENCE)
        while len(started) < 2:
            started = children(bench.process.pid)
    os.kill(started["robot"] if phase == "robot" else bench.process.pid, number)
    assert bench.process.wait(60) == code
    said = bench.errors.read_text()
    assert sentence in said
    assert "Traceback" not in said
    assert bench.output.read_text() == ""
    assert not any(Path(f"/proc/{pid}").exists() for pid in started.values())


def test_a_scene_that_stops_at_once(tmp_path: Path) -> None:
    """Both controllers are lost with the robot's reason, and nothing else is run."""
    limits = [w for k, v in LIMITS.items() for w in ("--set", f"validity.elastic_rotation.{k}={v}")]
    words = bench_words("--json", *limits, "--against", controller("pushes"))
    bench = Background(words, ros_environment(), tmp_path)
    assert bench.process.wait(PATIENCE) == 1
    found = json.loads(bench.output.read_text())["controllers"]
    assert len(found) == 2
    for one in found.values():
        assert list(one["scores"]) == ["nominal"]
        assert one["scores"]["nominal"]["lost"]
        assert "the solver has stopped: " in one["scores"]["nominal"]["reason"]
    # 10 kN m can take the first step beyond all bounds before the beam's rotation is looked at
    (held,) = (one for name, one in found.items() if "holds" in name)
    assert "link_1: the elastic rotation reaches" in held["scores"]["nominal"]["reason"]


@pytest.mark.parametrize("how", ["follow", "move"])
def test_an_example_controller_whose_robot_is_gone(how: str, tmp_path: Path) -> None:
    """It ends with exit code 1 and says so: of a robot that has ended, and of one that has stopped."""
    environment = ros_environment()
    params = ["-p", f"scene:={SCENE}", "-p", "rate:=100.0"]
    if how == "follow":
        words = [sys.executable, "-m", "flexsim.controller.follow", "joint_pd", "--ros-args", *params]
    else:
        numbers = {"duration": 5.0, "there": 1.0, "back": 2.0, "time": 0.5, "listeners": 1.0}
        lists = {"start": [0.0], "goal": [0.1], "stiffness": [1.0], "damping": [0.1]}
        given = [w for k, v in (numbers | lists).items() for w in ("-p", f"{k}:={v}")]
        words = [sys.executable, "-m", "flexsim.controller", "--ros-args", *params, *given]
    with node("flexsim_node", tmp_path, environment, scene=SCENE, **STOPS) as robot:
        law = Background(words, environment, tmp_path)
        if how == "follow":  # a robot that has stopped may be reset
            law.wait_for("flexsim_node stands still at")
            robot.process.send_signal(signal.SIGINT)
        assert law.process.wait(PATIENCE) == 1
    said = law.errors.read_text()
    assert ("flexsim_node has ended" if how == "follow" else "flexsim_node stands still at") in said
    assert "Traceback" not in said


def test_what_records_and_shows_a_robot_that_stops(tmp_path: Path) -> None:
    """The recorder says so, once, and records on; the viewer ends when the node that it started is killed."""
    environment = ros_environment()
    recorder = Background(command("record", "-o", tmp_path / "run", "--json"), environment, tmp_path)
    with node("flexsim_node", tmp_path, environment, scene=SCENE, **STOPS) as robot:
        recorder.wait_for("flexsim_node stands still at", PATIENCE)
        robot.process.send_signal(signal.SIGINT)
        recorder.wait_for("- flexsim_node has ended", PATIENCE)
    assert recorder.end() == 0
    recorded = json.loads(recorder.output.read_text())
    assert list(recorded["stopped"]) == ["/flexsim_node"]
    assert recorder.errors.read_text().count("stands still at") == 1
    assert recorded["topics"]["/flexsim_node/status"]["messages"] >= 1

    rrd = tmp_path / "robot.rrd"
    viewer = Background(command("view", SCENE, "--save", rrd), ros_environment(), tmp_path)
    end = time.monotonic() + PATIENCE
    while not (rrd.exists() and rrd.stat().st_size > 20_000):  # it shows something
        assert time.monotonic() < end and viewer.process.poll() is None, viewer.errors.read_text()
        time.sleep(0.05)
    (started,) = children(viewer.process.pid).values()
    os.kill(started, signal.SIGKILL)
    assert viewer.process.wait(PATIENCE) == 1
    assert "flexsim_node ended with exit code -9 (SIGKILL)" in viewer.errors.read_text()
    assert "robot/tip/deflection" in viewer.output.read_text()


@pytest.mark.parametrize(
    ("watched", "sentence"),
    [
        ({"gone": "flexsim_node ended with exit code -9 (SIGKILL)"}, "exit code -9"),
        ({"trouble": "flexsim_node stands still at 0.5 s: it bends"}, "stands still at 0.5 s: it bends"),
        ({"status": SimulatorStatus("running", resets=2)}, "somebody has reset flexsim_node"),
        (
            {"status": SimulatorStatus("paused", time=0.5, resets=1)},
            "somebody has paused flexsim_node at 0.5 s",
        ),
    ],
)
def test_a_replay_whose_robot_does_not_answer(watched: dict[str, object], sentence: str) -> None:
    """Driven in lockstep, a state that does not come has a reason, and the same state again is no answer."""
    driver = object.__new__(Driver)
    given = {"status": SimulatorStatus("running", resets=1), "gone": "", "trouble": "", "poll": lambda: None}
    driver._watch, driver._resets, driver._next = SimpleNamespace(**given | watched), 1, 0.0
    driver.meanwhile, driver._take = lambda _: None, lambda: 500_000_000
    with pytest.raises(Stopped, match=sentence):
        driver._wait(501_000_000, 500, SimpleNamespace(asked=False))
