"""A robot in real time and all that happens to it: nobody can make it stumble, and what happened is said."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from listening import PATIENCE, seconds
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from robot_process import Robot, robot
from rosgraph_msgs.msg import Clock
from simulation_interfaces.srv import ResetSimulation
from simulator import Client
from std_msgs.msg import Float64MultiArray

pytestmark = pytest.mark.ros
SCENE = Path(__file__).parents[2] / "config" / "anthropomorphic_geared.yaml"
LISTENER = """
import rclpy
from rclpy.qos import QoSProfile, HistoryPolicy
from sensor_msgs.msg import JointState
rclpy.init()
node = rclpy.create_node("staller")
profile = QoSProfile(history=HistoryPolicy.KEEP_ALL)
node.create_subscription(JointState, "joint_states", lambda m: print("heard", flush=True), profile)
rclpy.spin(node)
"""
# Asks for much, waits for nothing, and is gone.
VANISHER = """
import os, signal
import rclpy
from rclpy.action import ActionClient
from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.srv import GetEntitiesStates, ResetSimulation
rclpy.init()
node = rclpy.create_node("vanisher")
steps = ActionClient(node, SimulateSteps, "flexsim_node/simulate_steps")
states = node.create_client(GetEntitiesStates, "flexsim_node/get_entities_states")
reset = node.create_client(ResetSimulation, "flexsim_node/reset_simulation")
assert steps.wait_for_server(20.0) and states.wait_for_service(20.0) and reset.wait_for_service(20.0)
for _ in range(20):
    steps.send_goal_async(SimulateSteps.Goal(steps=100000))
    states.call_async(GetEntitiesStates.Request())
    reset.call_async(ResetSimulation.Request())
os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Robot]:
    """One node for all tests: it must bear them one after the other."""
    folder = tmp_path_factory.mktemp("hardening")
    with robot(folder, scene=SCENE, use_sim_time=True) as found:
        found.connected()
        yield found


@pytest.fixture(autouse=True)
def sound(arm: Robot) -> Iterator[None]:
    """Begin anew; afterwards all that was heard is finite, and a good command is obeyed."""
    call(arm, ResetSimulation, "reset_simulation", ResetSimulation.Request())
    for heard in arm.heard.values():
        heard.clear()
    yield

    def obeyed() -> bool:
        arm.command([0.25, 0.5, 0.75])
        return bool(arm.states()) and list(arm.states()[-1].effort) == [0.25, 0.5, 0.75]

    arm.until(obeyed)
    for state in arm.states():
        assert np.isfinite([state.position, state.velocity, state.effort]).all()
    assert Client(arm).call("GetSimulationState").result.error_message == ""


def call(arm: Robot, kind: type, name: str, request: object) -> object:
    """Call a service of the node."""
    client = arm.node.create_client(kind, f"flexsim_node/{name}")
    try:
        arm.until(client.service_is_ready, PATIENCE)
        future = client.call_async(request)
        return arm.until(lambda: future.done() and future.result())
    finally:
        arm.node.destroy_client(client)


def spin(arm: Robot, duration: float) -> None:
    """Listen for some seconds."""
    end = time.monotonic() + duration
    arm.until(lambda: time.monotonic() > end)


def figures(arm: Robot) -> dict[str, str]:
    """The next diagnostics but one, which are of now."""
    arm.heard["/diagnostics"].clear()
    arm.until(lambda: len(arm.heard["/diagnostics"]) > 1)
    return arm.diagnostics()


def memory(arm: Robot) -> int:
    """Resident memory of the node, bytes."""
    status = Path(f"/proc/{arm.process.process.pid}/status").read_text()
    return 1024 * int(status.split("VmRSS:")[1].split()[0])


def test_stopped_for_a_second_and_continued(arm: Robot) -> None:
    """The second is lost, and said to be; simulated time does not race to make up for it."""
    before = figures(arm)
    arm.process.process.send_signal(signal.SIGSTOP)
    spin(arm, 1.0)  # all that was on its way is heard
    last, begun = arm.time(), time.monotonic()
    arm.process.process.send_signal(signal.SIGCONT)
    arm.until(lambda: arm.time() > last + 0.3)
    # at most 0.1 s is made up for, beside the tick in which it was stopped
    assert time.monotonic() - begun > 0.3 - 0.1 - 0.01
    said = figures(arm)
    assert float(said["lost time, s"]) - float(before["lost time, s"]) > 0.85
    assert int(said["overruns"]) - int(before["overruns"]) > 850
    assert said["status"] == "ok"


def test_two_commanders_at_once(arm: Robot) -> None:
    """Each state names the command of one of them, whole; that there are two is said."""
    other = arm.node.create_publisher(Float64MultiArray, "flexsim_node/commands", 10)
    arm.until(other.get_subscription_count)
    first, second = [1.0, 2.0, 3.0], [-4.0, -5.0, -6.0]
    end = time.monotonic() + 1.0
    while time.monotonic() < end:
        arm.command(first)
        other.publish(Float64MultiArray(data=second))
        arm.hear(0.001)
    efforts = {tuple(m.effort) for m in arm.states()}
    assert efforts <= {tuple(first), tuple(second), (0.0, 0.0, 0.0)}
    assert {tuple(first), tuple(second)} <= efforts
    arm.until(lambda: any(s.message == "several publish commands: /listener (2)" and s.level == b"\x01"
                          for s in arm.heard["/diagnostics"][-1].status))  # fmt: skip
    assert "/listener (2); the latest holds" in arm.process.errors.read_text()
    arm.node.destroy_publisher(other)


def test_a_flood(arm: Robot) -> None:
    """Ten thousand commands a second and more: time goes on, the last command holds, memory does not grow."""
    before = memory(arm)
    begun, count = time.monotonic(), 0
    since = arm.until(arm.states) and arm.time()
    while time.monotonic() - begun < 2.0:
        for _ in range(20):
            arm.command([0.1 * (count % 7), 0.0, 0.0])
            count += 1
        arm.hear()
    arm.command([1.5, 2.5, 3.5])
    arm.until(lambda: list(arm.states()[-1].effort) == [1.5, 2.5, 3.5])
    assert arm.time() - since > 1.0
    assert memory(arm) < before + 20e6


def test_a_subscriber_that_stalls(arm: Robot, tmp_path: Path) -> None:
    """Who asks for every state, reliably, and then does not listen, holds nobody up and fills nothing."""
    environment = dict(os.environ, ROS_DOMAIN_ID=str(arm.context.get_domain_id()))
    with (tmp_path / "heard").open("w") as heard:
        words = [sys.executable, "-c", LISTENER]
        staller = subprocess.Popen(words, env=environment, stdout=heard, stderr=subprocess.DEVNULL)
    try:
        arm.until(lambda: (tmp_path / "heard").stat().st_size > 0)
        staller.send_signal(signal.SIGSTOP)
        before, since = memory(arm), arm.time()
        lost = float(figures(arm)["lost time, s"])
        spin(arm, 3.0)
        assert arm.time() - since + float(figures(arm)["lost time, s"]) - lost > 2.9
        assert memory(arm) < before + 10e6
    finally:
        staller.kill()
        staller.wait()


def test_clients_that_vanish_before_their_answer(arm: Robot) -> None:
    """Nobody is there to hear the answers; the robot goes on for all others."""
    environment = {**os.environ, "ROS_DOMAIN_ID": str(arm.context.get_domain_id())}
    for _ in range(2):
        gone = subprocess.run([sys.executable, "-c", VANISHER], env=environment, timeout=PATIENCE)
        assert gone.returncode == -signal.SIGKILL
    arm.until(arm.states)
    last = arm.time()
    arm.until(lambda: arm.time() > last + 0.2)


def test_jumps_of_the_ros_clock(arm: Robot) -> None:
    """The node listens to /clock, as use_sim_time asks, and another clock jumps: its own time goes on."""
    clock = arm.node.create_publisher(Clock, "/clock", 10)
    arm.until(lambda: clock.get_subscription_count() > 1)
    begun, count = arm.until(arm.states) and arm.time(), len(arm.heard["/diagnostics"])
    tick = Clock()
    for k in range(60):
        tick.clock.sec = (0, 2_000_000_000, 5)[k % 3]
        clock.publish(tick)
        spin(arm, 0.02)
    arm.until(lambda: arm.time() > begun + 1.0)
    stamps = [seconds(m) for m in arm.states()]
    assert stamps == sorted(stamps)
    arm.until(lambda: len(arm.heard["/diagnostics"]) > count)
    arm.node.destroy_publisher(clock)


def test_resets_and_parameters_in_mid_step(arm: Robot) -> None:
    """Asked for at any moment of its motion: each is answered, and stamps never go back."""
    scope = ResetSimulation.Request(scope=ResetSimulation.Request.SCOPE_STATE)
    texts = ("[{kind: delay, time: 0.004}]", "[{kind: lag, time_constant: 0.01}]", "[]",
             "[{kind: payload, link: link_3, mass: 0.3}]")  # fmt: skip
    for k in range(12):
        arm.command([0.5 * k, 5.0, 1.0])
        given = [
            Parameter("faults", value=texts[k % len(texts)]),
            Parameter("elastic_rate", value=100.0 + 25 * (k % 2)),
        ]
        request = SetParameters.Request(parameters=[p.to_parameter_msg() for p in given])
        for result in call(arm, SetParameters, "set_parameters", request).results:
            assert result.successful, result.reason
        assert call(arm, ResetSimulation, "reset_simulation", scope).result.result == 1
        spin(arm, 0.01 * (k % 3))
    stamps = [seconds(m) for m in arm.states()]
    assert stamps == sorted(stamps)
