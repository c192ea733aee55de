"""Every input tried with nonsense: ten thousand each in one process, and some thousands of them over DDS."""

from __future__ import annotations

import array
import random
import struct
import time
from collections.abc import Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
from processes import ros_environment
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message, serialize_message
from robot_process import robot
from sensor_msgs.msg import JointState, Temperature
from simulation_interfaces import srv
from simulator import Client
from std_msgs.msg import Float64MultiArray

from flexsim_node.node import FlexsimNode
from flexsim_node.settings import CHANGEABLE, OVERRIDE, meanings
from thermal_node.node import ThermalNode

pytestmark = pytest.mark.ros
CONFIG = Path(__file__).parents[2] / "config"
COUNT = 10_000
SERVICES = (
    "GetSimulatorFeatures", "GetSimulationState", "SetSimulationState", "ResetSimulation", "StepSimulation",
    "GetEntities", "GetEntitiesStates", "GetEntityInfo", "GetEntityState",
)  # fmt: skip
NUMBERS = (
    0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, -1e300, 5e-324, float("nan"), float("inf"), float("-inf"), 1e9, 0.1,
)  # fmt: skip
WORDS = (
    "", "joint_1", "joint_2", "joint_1 ", "../../etc/passwd", "/dev/zero", "a" * 5000, "(", "(a+)+b",
    "[[:alpha:]]*", "{1,9}", "link_[0-9]", "\x00", "é漢😀", "anthropomorphic/link_1", "'; import os",
    "!!python/object:os.system x",
    "[{kind: delay, time: 0.01}]", "[{kind: drop, probability: 2}]", "[]", "[[[[[[", "nan", "-1", "%s%n",
)  # fmt: skip


class Nonsense:
    """Random messages of any type, from a seed."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)

    def number(self) -> float:
        """Any float."""
        r = self.random
        return r.choice(NUMBERS) if r.random() < 0.5 else r.gauss(0.0, 10.0)

    def word(self) -> str:
        """Any text."""
        r = self.random
        if r.random() < 0.6:
            return r.choice(WORDS)
        return "".join(chr(r.choice([*range(32, 127), 0xE9, 0x6F22])) for _ in range(r.randint(0, 30)))

    def value(self, kind: str) -> Any:
        """Any value of a field's type."""
        r = self.random
        if kind.startswith("sequence<"):
            inner = kind[9:-1].partition(",")[0]
            found = [self.value(inner) for _ in range(r.choice((0, 1, 2, 3, 3, 3, 7, 40)))]
            return array.array("d", found) if inner == "double" else found
        if kind == "string":
            return self.word()
        if kind in ("double", "float"):
            return self.number()
        if kind == "boolean":
            return r.random() < 0.5
        if kind.removeprefix("u").startswith("int"):
            bits = int(kind.rpartition("int")[2])
            low, high = (0, 2**bits - 1) if kind[0] == "u" else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
            return r.choice((low, high, r.randint(0, 4), r.randint(low, high)))
        package, _, name = kind.partition("/")
        return self.message(getattr(__import__(f"{package}.msg", fromlist=[name]), name))

    def message(self, kind: type) -> Any:
        """Any message of a type."""
        fields = kind.get_fields_and_field_types()
        return kind(**{name: self.value(field) for name, field in fields.items()})

    def parameter(self, names: list[str]) -> Parameter:
        """Any parameter."""
        r = self.random
        value = r.choice(
            [self.number(), self.word(), r.random() < 0.5, r.randint(-5, 1000), [self.number()] * 3, None]
        )
        return Parameter(r.choice(names) if r.random() < 0.9 else self.word() or "x", value=value)


@pytest.fixture
def context() -> Iterator[None]:
    """Hand the nodes a ROS of their own."""
    import os

    before = dict(os.environ)
    os.environ.update(ROS_DOMAIN_ID=ros_environment()["ROS_DOMAIN_ID"])
    yield
    rclpy.try_shutdown()
    os.environ.clear()
    os.environ.update(before)


def started(kind: type, **parameters: object) -> Any:
    """A node in this process, stepping."""
    words = [w for name, value in parameters.items() for w in ("-p", f"{name.replace('__', '.')}:={value}")]
    rclpy.init(args=["--ros-args", *words])
    node = kind()
    node.loop.start()
    return node


def answered(response: Any) -> Any:
    """A response, when it is there."""
    return response.result(30.0) if isinstance(response, Future) else response


def ask_everything(node: Any, nonsense: Nonsense, count: int) -> None:
    """Call each service with nonsense; each answers with a response that can be sent."""
    services = {service.srv_name.rpartition("/")[2]: service for service in node.services}
    for name in SERVICES:
        kind = getattr(srv, name)
        service = services["".join(f"_{c.lower()}" if c.isupper() else c for c in name)[1:]]
        for k in range(count):
            request = nonsense.message(kind.Request)
            if name == "StepSimulation" and request.steps > 5:
                request.steps = request.steps % 5 if k % 50 else 2**64 - 1
            response = service.callback(request, kind.Response())
            if name == "StepSimulation" and request.steps > 5:
                services["get_simulation_state"].callback(
                    srv.GetSimulationState.Request(), srv.GetSimulationState.Response()
                )
                node.loop.pause()  # whatever else is asked ends steps
            serialize_message(answered(response))
        node.simulation.quit_asked = False
        if node.simulation.state == 3:
            node.simulation.state = 2


def test_the_robot(context: None) -> None:
    """Ten thousand of each: commands both ways, services, parameters; every state published is finite."""
    node = started(
        FlexsimNode, scene=CONFIG / "anthropomorphic_geared.yaml", mode="fast", elastic_rate=1000.0,
        shape_rate=1000.0, clock_rate=1000.0,
    )  # fmt: skip
    published: list[bytes] = []
    whole = node._joints.publish

    def publish(data: bytes) -> None:
        if len(published) < 200_000:
            published.append(data)
        whole(data)

    node._joints.publish = publish
    nonsense = Nonsense(1)
    try:
        for k in range(COUNT):
            node._on_commands(nonsense.message(Float64MultiArray))
            node._on_joints(nonsense.message(JointState))
            if k % 100 == 0 and node.loop.trouble:
                node.loop.reset().result(30.0)
        for names in ([*CHANGEABLE], [*meanings(), f"{OVERRIDE}solver.step", "use_sim_time"]):
            for _ in range(COUNT // 2):
                several = range(nonsense.random.randint(1, 3))
                answer = node._change([nonsense.parameter(names) for _ in several])
                assert answer.successful or answer.reason
        node._change([Parameter("faults", value="[]")])
        ask_everything(node, nonsense, COUNT)
        node.loop.pause().result(30.0)
        node.loop.reset(time=True).result(30.0)
        assert node.loop.step(100).result(60.0) == 100
        assert node.loop.failure is None
        assert node.commands.refused.total() > COUNT
        for data in published[:: max(1, len(published) // 5000)]:
            state = deserialize_message(data, JointState)
            assert np.isfinite([state.position, state.velocity, state.effort]).all()
        assert len(published) > 100
    finally:
        node.loop.stop()
        node.simulation.close()
        node.destroy_node()


def test_the_door(context: None) -> None:
    """The same for thermal_node: measured temperatures, services, parameters."""
    node = started(ThermalNode, scene=CONFIG / "thesis_door_column.yaml", time_scale=0.0, duration=1e6)
    nonsense = Nonsense(2)
    try:
        for _ in range(COUNT):
            node._on_measured(nonsense.message(Temperature))
        for _ in range(COUNT):
            names = ["time_scale", "duration", "field_rate", "furnace_timeout", "rate", "scene"]
            node._change([nonsense.parameter(names)])
        ask_everything(node, nonsense, COUNT)
        node._change([Parameter("duration", value=0.0), Parameter("time_scale", value=0.0)])
        node.loop.pause().result(30.0)
        node.loop.reset(time=True).result(30.0)
        node.loop.measure(500.0)
        assert node.loop.step(3).result(60.0) == 3
        assert np.isfinite(node.test.temperature).all()
        assert node.loop.failure is None
    finally:
        node.loop.stop()
        node.simulation.close()
        node.destroy_node()


def torn(data: bytes, rng: random.Random) -> bytes:
    """Bytes that were a message once."""
    found = bytearray(data)
    for _ in range(rng.randint(1, 8)):
        found[rng.randrange(len(found))] = rng.randrange(256)
    if rng.random() < 0.3:
        del found[rng.randrange(4, len(found)) :]
    if rng.random() < 0.2 and len(found) > 12:
        place = 4 * rng.randrange(1, len(found) // 4)
        struct.pack_into("<I", found, place, rng.choice((0xFFFFFFFF, 0x7FFFFFFF)))
    return bytes(found)


def test_over_the_wire(tmp_path: Path) -> None:
    """A flood of nonsense and of bytes that are no message, two commanders, SIGSTOP: the node goes on."""
    nonsense, rng = Nonsense(3), random.Random(3)
    with robot(tmp_path, scene=CONFIG / "anthropomorphic_geared.yaml", mode="realtime") as arm:
        arm.connected()
        other = arm.node.create_publisher(Float64MultiArray, "flexsim_node/commands", 10)
        arm.until(lambda: other.get_subscription_count())
        good = [serialize_message(JointState(name=["joint_1"], effort=[1.0])),
                serialize_message(Float64MultiArray(data=[1.0, 2.0, 3.0]))]  # fmt: skip
        for k in range(3000):
            arm._by_name.publish(nonsense.message(JointState))
            arm._torques.publish(nonsense.message(Float64MultiArray))
            arm._by_name.publish(torn(good[0], rng))
            other.publish(torn(good[1], rng))
            if k % 200 == 0:
                arm.executor.spin_once(timeout_sec=0.0)
        since = time.monotonic()
        while time.monotonic() - since < 1.0:  # 10 kHz and more
            other.publish(good[1])
        reset = arm.node.create_client(srv.ResetSimulation, "flexsim_node/reset_simulation")
        arm.until(reset.service_is_ready)
        arm.until(reset.call_async(srv.ResetSimulation.Request()).done)
        arm.heard["joint_states"].clear()
        arm.until(lambda: arm.states() and arm.time() < 60.0)
        before = arm.time()
        other.publish(Float64MultiArray(data=[0.25, 0.5, 0.75]))
        arm.until(lambda: list(arm.states()[-1].effort) == [0.25, 0.5, 0.75])
        arm.until(lambda: arm.time() > before + 0.1)
        for state in arm.states():
            assert np.isfinite([state.position, state.velocity, state.effort]).all()
        assert Client(arm).call("GetSimulationState").result.error_message == ""  # the solver goes on
        # Diagnostics come once a second; one from before the reset may be on its way yet.
        said = arm.until(lambda: arm.diagnostics() if arm.diagnostics().get("phase") == "running" else None)
        assert said["status"] == "ok"
        assert int(said["refused"]) > 100
