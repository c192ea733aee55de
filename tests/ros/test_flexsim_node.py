"""The node does over DDS what it promises: motion, refusals, diagnostics, a clean end."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as xml
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import WrenchStamped
from listening import PATIENCE, seconds
from processes import Background, ros_environment
from robot_process import SCENE, robot, words

from flexsim_node import load_scene, simulate, static_equilibrium

pytestmark = pytest.mark.ros
START = [0.3, 0.8, -0.6]


@pytest.mark.alone
def test_it_steps_in_real_time(tmp_path: Path) -> None:
    """States come a millisecond of simulated time apart, none missing."""
    with robot(tmp_path, override__initial__position=START, wait_for_command=True) as arm:
        arm.connected()
        assert arm.time() > 0.0  # zero means "no time" to ROS
        arm.until(lambda: arm.heard["flexsim_node/deformed_shape"])
        before = time.monotonic()
        arm.command([0.0, 0.0, 0.0])
        arm.until(lambda: arm.time() > 1.0)
        assert arm.time() < time.monotonic() - before + 0.2  # never ahead of the clock
        times = np.array([seconds(m) for m in arm.states()])
        moving = times[times >= 1e-3]
        np.testing.assert_allclose(np.diff(moving), 1e-3, atol=1e-9)
        assert len(arm.states()[-1].position) == len(arm.states()[-1].velocity) == 3
        elastic = arm.heard["flexsim_node/elastic_state"][-1]
        layout = arm.heard["flexsim_node/elastic_layout"][-1]
        nodes = len(layout.node_names)
        assert len(elastic.displacement) == 6 * nodes
        assert elastic.status == "ok"
        assert layout.link_names == ["link_1", "link_2", "link_3"]
        assert len(layout.segments) == 2 * len(layout.segment_width) == 12
        clock = [m.clock.sec + 1e-9 * m.clock.nanosec for m in arm.heard["/clock"]]
        assert clock[0] > 0.0
        assert (np.diff(clock) >= 0.0).all()
        said = arm.until(lambda: arm.diagnostics() if float(
            arm.diagnostics().get("simulated time, s", 0.0)) > 0.5 else None)  # fmt: skip
        assert 0.0 < float(said["step time p50, µs"]) <= float(said["step time worst, µs"])
        assert 0.0 < float(said["real-time factor"]) < 1.01
        assert int(said["overruns"]) >= 0
        assert said["status"] == "ok"
        # where it may, no thread that the stepping one can wait for stands back behind ordinary programs
        tasks = Path(f"/proc/{arm.process.process.pid}/task").iterdir()
        first = [os.sched_getscheduler(int(task.name)) == os.SCHED_FIFO for task in tasks]
        assert all(first) if said["real-time priority"] == "yes" else not any(first)


@pytest.mark.alone
def test_the_benchmark_of_real_time() -> None:
    """It runs and accounts for all of its time; how many answers come, the host decides."""
    program = Path(__file__).parents[2] / "benchmarks" / "realtime.py"
    # Long enough for a host that lends a fraction of its cores.
    words = ["--duration", "12", "--rate", "2000", "--controller", "--json"]
    done = subprocess.run(
        [sys.executable, str(program), *words],
        env=ros_environment(), capture_output=True, text=True, timeout=100,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    # Every due tick is made or said to be lost; what is read may be a second old.
    assert found["ticks"] / 2000 + found["lost_time"] >= 11.0
    assert found["ticks"] > 4000
    assert found["commands"] > 1000
    for latency in (found["latency"], found["echo_latency"]):
        assert latency["samples"] > 100
        assert 0.0 < latency["p50"] <= latency["p99"] < 1.0


def test_lockstep_is_the_offline_simulation(tmp_path: Path) -> None:
    """A command a period gives the very motion that the same torques give offline."""
    periods = 200
    torque = np.random.default_rng(1).normal(0.0, 3.0, (periods, 3))
    scene = load_scene(SCENE, {"initial.position": START})
    offline = simulate(scene, torque, duration=periods * 2e-3, sample_period=2e-3)
    with robot(tmp_path, mode="lockstep", rate=500.0, override__initial__position=START) as arm:
        arm.connected()
        arm.heard["joint_states"].clear()
        for k in range(periods):
            arm.command(torque[k])
            arm.until(lambda k=k: arm.states() and round(arm.time() / 2e-3) == k + 1)
        arm.until(lambda: round(seconds(arm.heard["flexsim_node/elastic_state"][-1]) / 4e-3) == 100)
        moved = [m for m in arm.states() if seconds(m) > 1e-6]
        assert len(moved) == periods
        online = np.array([m.position for m in moved])
        np.testing.assert_array_equal(online, offline.joint_position[1:])
        np.testing.assert_array_equal([m.effort for m in moved], torque)
        last = np.array(arm.heard["flexsim_node/elastic_state"][-1].position).reshape(-1, 3)
        np.testing.assert_array_equal(last, offline.node_position[-1])
        cloud = arm.heard["flexsim_node/deformed_shape"][-1]
        assert cloud.point_step * cloud.width == len(cloud.data) == 40 * len(last)


NONSENSE = {
    "wrong length": [[1.0], [1.0] * 4, []],
    "not finite": [[0.0, float("nan"), 0.0], [0.0, 0.0, float("inf")]],
}
NONSENSE_BY_NAME = {
    "wrong length": [(["joint_1", "joint_2"], [1.0]), ([], []), (["joint_1"], [])],
    "unknown joint": [(["joint_1", "elbow"], [1.0, 2.0])],
    "joint named twice": [(["joint_1", "joint_1"], [1.0, 2.0])],
    "not finite": [(["joint_3"], [float("-inf")])],
}


def test_nonsense_is_refused_whole(tmp_path: Path) -> None:
    """Refused commands are counted by reason and change nothing; the last good one stays."""
    with robot(tmp_path, mode="lockstep") as arm:
        arm.connected()
        arm.command([0.5, 1.0, 2.0])
        arm.until(lambda: arm.time() > 0.9e-3)
        for torques in NONSENSE.values():
            for torque in torques:
                arm.command(torque)
        for commands in NONSENSE_BY_NAME.values():
            for names, effort in commands:
                arm.command_by_name(names, effort)
        arm.command_by_name(["joint_3", "joint_1"], [4.0, 3.0])
        arm.until(lambda: arm.time() > 1.9e-3)
        assert list(arm.states()[-1].effort) == [3.0, 1.0, 4.0]  # joint_2 keeps its torque
        many = sum(map(len, NONSENSE.values())) + sum(map(len, NONSENSE_BY_NAME.values()))
        said = arm.until(lambda: arm.diagnostics() if arm.diagnostics().get("refused") == str(many)
                         else None)  # fmt: skip
        assert said["accepted"] == "2"
        for reason in {*NONSENSE, *NONSENSE_BY_NAME}:
            count = len(NONSENSE.get(reason, [])) + len(NONSENSE_BY_NAME.get(reason, []))
            assert said[f"refused, {reason}"] == str(count)
        assert arm.time() < 2.1e-3
        log = arm.process.errors.read_text()
        assert "refused a command" in log
        assert log.count("refused a command") <= 3  # once a second, however many came


def test_a_load_on_a_link_moves_the_arm(tmp_path: Path) -> None:
    """Along the axes of the link that the header names, until the next; nonsense is refused and counted."""
    with robot(tmp_path, override__gravity=[0.0, 0.0, 0.0], override__initial__position=START) as arm:
        arm.connected()
        loads = arm.node.create_publisher(WrenchStamped, "flexsim_node/wrench", 10)
        arm.until(loads.get_subscription_count, PATIENCE)
        load = WrenchStamped()
        load.wrench.force.z = 2.0

        def sent_until(found: Callable[[], bool]) -> None:
            """A subscriber of best effort may not know of a new publisher yet."""

            def sent() -> bool:
                loads.publish(load)
                return found()

            arm.until(sent)

        load.header.frame_id = "no_such_link"
        sent_until(lambda: int(arm.diagnostics().get("refused, unknown link", 0)) > 0)
        assert np.ptp([m.position[0] for m in arm.states()]) < 1e-6
        load.header.frame_id = "link_3"
        sent_until(lambda: abs(arm.states()[-1].position[0] - START[0]) > 0.05)
        load.wrench.force.z = float("nan")
        sent_until(lambda: int(arm.diagnostics().get("refused, not finite", 0)) > 0)
        said = arm.diagnostics()
        assert int(said["refused"]) == int(said["refused, unknown link"]) + int(said["refused, not finite"])
        assert float(said["elastic_rotation"]) > 0.0


def test_leaving_the_equations_range_is_said(tmp_path: Path) -> None:
    """Beyond `warn` the diagnostics warn; beyond `stop` time stands still in the last good state."""
    limits = {"override__validity__elastic_rotation__warn": 1e-5}
    with robot(tmp_path, override__initial__position=START, **limits) as arm:
        arm.connected()
        arm.command([5.0, 20.0, 5.0])
        arm.until(lambda: b"\x01" in [s.level for m in arm.heard["/diagnostics"] for s in m.status
                                      if s.name.endswith("validity")])  # fmt: skip
    limits["override__validity__elastic_rotation__stop"] = 2e-3
    with robot(tmp_path, override__initial__position=START, **limits) as arm:
        arm.connected()
        arm.command([5.0, 20.0, 5.0])
        said = arm.until(lambda: arm.diagnostics() if arm.diagnostics().get("phase") == "stopped" else None)
        assert (
            "elastic rotation reaches" in said["status"]
            and "validity.elastic_rotation.stop" in said["status"]
        )
        assert all(np.isfinite(m.position).all() for m in arm.states())


def test_command_timeout(tmp_path: Path) -> None:
    """A controller that has fallen silent loses its grip, where the user asked for that."""
    with robot(tmp_path, command_timeout=0.2) as arm:
        arm.connected()
        arm.command([0.5, 1.0, 2.0])
        arm.until(lambda: any(list(m.effort) == [0.5, 1.0, 2.0] for m in arm.states()))
        arm.until(lambda: list(arm.states()[-1].effort) == [0.0, 0.0, 0.0])
        arm.until(lambda: arm.diagnostics().get("timeouts") == "1")


def test_whoever_comes_late_hears_what_the_robot_is(tmp_path: Path) -> None:
    """Layout and description are latched; the description has this robot's shape and weight."""
    import pinocchio as pin

    with robot(tmp_path, wait_for_command=True, override__initial__position=START) as arm:
        arm.connected()
        arm.listen()
        text = arm.until(lambda: arm.heard["robot_description"])[-1].data
        assert arm.until(lambda: arm.heard["flexsim_node/elastic_layout"])
        state = arm.until(lambda: arm.heard["flexsim_node/elastic_state"])[-1]
    root = xml.fromstring(text.partition("?>")[2])
    assert [link.get("name") for link in root.findall("link")] == [
        "base",
        "link_1",
        "link_2",
        "link_3",
        "tip",
    ]
    assert len(root.findall("link/visual/geometry/box")) == 3
    model = pin.buildModelFromXML(text)
    assert list(model.names)[1:] == ["joint_1", "joint_2", "joint_3"]
    data = model.createData()
    angles = np.concatenate([[np.cos(a), np.sin(a)] for a in START])
    pin.framesForwardKinematics(model, data, angles)
    tip = data.oMf[model.getFrameId("tip")].translation
    np.testing.assert_allclose(tip, np.array(state.rigid_position).reshape(-1, 3)[-1], atol=1e-12)
    rigid = load_scene(SCENE, {f"links.{k}.flexible": False for k in range(3)})
    weight = pin.rnea(model, data, angles, np.zeros(3), np.zeros(3))
    np.testing.assert_allclose(weight, static_equilibrium(rigid, START).torque, atol=1e-9)


def test_a_solver_in_trouble_stops_with_the_reason(tmp_path: Path) -> None:
    """The last good state is published on, with its reason; nothing that is not finite gets out."""
    with robot(tmp_path, override__solver__method="runge_kutta_4", override__solver__step=1e-3) as arm:
        arm.connected()
        arm.until(lambda: arm.diagnostics().get("phase") == "stopped", PATIENCE)
        (solver,) = [s for s in arm.heard["/diagnostics"][-1].status if s.name.endswith("solver")]
        assert solver.level == b"\x02"
        assert "stopped at" in solver.message
        count, stopped = len(arm.states()), arm.time()
        arm.until(lambda: len(arm.states()) > count + 3)
        assert arm.time() == stopped
        arm.until(lambda: arm.heard["flexsim_node/elastic_state"][-1].status != "ok")
        for message in arm.states():
            assert np.isfinite([message.position, message.velocity, message.effort]).all()
        for message in arm.heard["flexsim_node/elastic_state"]:
            assert np.isfinite(message.position).all()
        assert "its last good state is published on" in arm.process.errors.read_text()


@pytest.mark.parametrize(
    ("mode", "number"),
    [("realtime", signal.SIGINT), ("fast", signal.SIGTERM), ("lockstep", signal.SIGTERM)],
)
def test_signals_end_it(tmp_path: Path, mode: str, number: signal.Signals) -> None:
    """Ctrl-C and a launcher's SIGTERM end it with code 0 and without a traceback."""
    node = Background(words(mode=mode), ros_environment(), tmp_path)
    node.wait_for("kernels ready", PATIENCE)
    time.sleep(0.3)
    assert node.end(number) == 0
    assert "Traceback" not in node.errors.read_text()


@pytest.mark.parametrize(
    ("parameters", "code", "sentence"),
    [
        ({"scene": None}, 2, "no scene is given"),
        ({"scene": "/nowhere.yaml"}, 1, "/nowhere.yaml: no such file"),
        ({"mode": "slow"}, 2, "give realtime, lockstep, fast"),
        ({"elastik_rate": 100.0}, 2, "did you mean elastic_rate?"),
        ({"rate": "much"}, 2, "give a number"),
        ({"rate": 0.01}, 2, "give 0.1 to 100000 Hz"),
        ({"faults": "[]"}, 2, "text in quotes of its own"),
        ({"faults": "{"}, 2, "ROS does not start"),
        ({"clock_rate": 70}, 2, "71.4286 Hz"),
        ({"override__solver__stp": 1e-3}, 1, "did you mean 'step'?"),
        ({"override__solver__method": "radau"}, 1, "rosenbrock_w"),
    ],
)
def test_mistakes(parameters: dict[str, object], code: int, sentence: str) -> None:
    """A mistake gets one line on stderr and the right exit code."""
    done = subprocess.run(
        words(**parameters), env=ros_environment(), capture_output=True, text=True, timeout=60
    )
    assert done.returncode == code, done.stderr
    assert sentence in done.stderr
    own = [line for line in done.stderr.splitlines() if "[rcl]" not in line]
    assert len(own) == 1, done.stderr
