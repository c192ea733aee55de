"""Every input of both nodes tried with nonsense: `python benchmarks/fuzz.py [--count 10000] [--json]`.

So many random messages, requests, goals and parameters, from a seed, for each input of a node in this
process that steps as fast as it can; then so many messages, and bytes that were messages once, for each topic
of a node in a process of its own.  It ends with exit code 1 where a node crashes, hangs, publishes a value
that is not finite, or does not go on afterwards.
"""

from __future__ import annotations

import argparse
import array
import json
import math
import multiprocessing
import os
import random
import struct
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from flexsim.ros.context import tool_node
from flexsim.terminal.stop import stopped_by_signals
from flexsim.trial.processes import NODE, own_domain, processes
from flexsim_msgs.msg import ElasticState
from geometry_msgs.msg import WrenchStamped
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message, serialize_message
from sensor_msgs.msg import JointState, Temperature
from simulation_interfaces import srv
from simulation_interfaces.action import SimulateSteps
from std_msgs.msg import Float64MultiArray

from flexsim_node.node import SWITCH_INTERVAL, FlexsimNode
from flexsim_node.service.settings import CHANGEABLE, OVERRIDE, meanings
from thermal_node.node import ThermalNode

CONFIG = Path(__file__).resolve().parent.parent / "config"
ROBOT, DOOR = CONFIG / "anthropomorphic_geared.yaml", CONFIG / "thesis_door_column.yaml"
STARTED, ANSWERED = 240.0, 60.0
SERVICES = (
    "GetSimulatorFeatures", "GetSimulationState", "SetSimulationState", "ResetSimulation", "StepSimulation",
    "GetEntities", "GetEntitiesStates", "GetEntityInfo", "GetEntityState",
)  # fmt: skip
PLAYING, PAUSED, QUITTING = 1, 2, 3
ENDLESS = 2**64 - 1
NUMBERS = (
    0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, -1e300, 5e-324, float("nan"), float("inf"), float("-inf"), 1e9, 0.1,
)  # fmt: skip
WORDS = (
    "", "joint_1", "joint_2", "joint_1 ", "link_2", "link_3", "../../etc/passwd", "/dev/zero", "a" * 5000,
    "(", "(a+)+b",
    "[[:alpha:]]*", "{1,9}", "link_[0-9]", "\x00", "é漢😀", "anthropomorphic/link_1", "'; import os",
    "!!python/object:os.system x",
    "[{kind: delay, time: 0.01}]", "[{kind: drop, probability: 2}]", "[]", "[[[[[[", "nan", "-1", "%s%n",
)  # fmt: skip
DOOR_PARAMETERS = ("time_scale", "duration", "field_rate", "furnace_timeout", "rate", "scene")

Figures = dict[str, dict[str, Any]]


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
        fields = kind.get_fields_and_field_types()  # type: ignore[attr-defined]
        return kind(**{name: self.value(field) for name, field in fields.items()})

    def torn(self, data: bytes) -> bytes:
        """Bytes that were a message once."""
        r = self.random
        found = bytearray(data)
        for _ in range(r.randint(1, 8)):
            found[r.randrange(len(found))] = r.randrange(256)
        if r.random() < 0.3:
            del found[r.randrange(4, len(found)) :]
        if r.random() < 0.2 and len(found) > 12:
            place = 4 * r.randrange(1, len(found) // 4)
            struct.pack_into("<I", found, place, r.choice((0xFFFFFFFF, 0x7FFFFFFF)))
        return bytes(found)

    def parameter(self, names: list[str]) -> Parameter:
        """Any parameter."""
        r = self.random
        value = r.choice(
            [self.number(), self.word(), r.random() < 0.5, r.randint(-5, 1000), [self.number()] * 3, None]
        )
        return Parameter(r.choice(names) if r.random() < 0.9 else self.word() or "x", value=value)


class Ear:
    """Between a node and one of its publishers: keeps some of what is published."""

    DENSE, SPARSE = 2000, 20

    def __init__(self, publisher: Any, kind: type, numbers: tuple[str, ...]) -> None:
        self.kind, self.numbers = kind, numbers
        self.count = 0
        self.kept: list[bytes] = []
        self._publish = publisher.publish
        publisher.publish = self.publish

    def publish(self, data: bytes) -> None:
        """Keep the first messages, then some, and pass them on."""
        if self.count < self.DENSE or self.count % self.SPARSE == 0:
            self.kept.append(data)
        self.count += 1
        self._publish(data)

    def check(self) -> None:
        """Raise where a number that was published is not finite."""
        for data in self.kept:
            message = deserialize_message(data, self.kind)
            for name in self.numbers:
                if not np.isfinite(getattr(message, name)).all():
                    raise AssertionError(f"published {name} {getattr(message, name)}")


@contextmanager
def running(kind: type, **parameters: object) -> Iterator[Any]:
    """Give a node in this process, stepping."""
    words = [w for name, value in parameters.items() for w in ("-p", f"{name}:={value}")]
    rclpy.init(args=["--ros-args", *words])
    interval = sys.getswitchinterval()
    sys.setswitchinterval(SWITCH_INTERVAL)
    try:
        node = kind()
        node.loop.start()
        try:
            yield node
        finally:
            node.loop.stop()
            node.simulation.close()
            node.destroy_node()
    finally:
        sys.setswitchinterval(interval)
        rclpy.try_shutdown()


def give(figures: Figures, name: str, count: int, one: Callable[[int], int | None]) -> None:
    """Try one input so many times; `one` gets how many there were and says how many it gave, if not one."""
    begun, given = time.monotonic(), 0
    while given < count:
        given += one(given) or 1
    seconds = time.monotonic() - begun
    print(f"  {name}: {given} inputs in {seconds:.1f} s", file=sys.stderr, flush=True)
    figures[name] = {"inputs": given, "seconds": round(seconds, 1)}


def answered(response: Any) -> Any:
    """A response, when it is there."""
    return response.result(ANSWERED) if isinstance(response, Future) else response


def ask_everything(node: Any, nonsense: Nonsense, count: int, figures: Figures) -> None:
    """Call each service with nonsense; each answers with a response that can be sent."""
    services = {service.srv_name.rpartition("/")[2]: service for service in node.services}
    for name in SERVICES:
        kind = getattr(srv, name)
        word = "".join(f"_{c.lower()}" if c.isupper() else c for c in name)[1:]

        def ask(k: int, kind: Any = kind, service: Any = services[word]) -> None:
            request = nonsense.message(kind.Request)
            if kind is srv.StepSimulation and request.steps > 5:
                request.steps = request.steps % 5 if k % 50 else ENDLESS
            response = service.callback(request, kind.Response())
            if kind is srv.StepSimulation and request.steps > 5:
                node.loop.pause()  # whatever else is asked ends steps
            serialize_message(answered(response))

        give(figures, f"~/{word}", count, ask)
        node.simulation.quit_asked = False
        if node.simulation.state == QUITTING:
            node.simulation.state = PAUSED


def send_goals(node: Any, nonsense: Nonsense, count: int, figures: Figures) -> None:
    """Send goals of any number of steps, playing and paused; the endless ones are cancelled."""
    other = rclpy.create_node("fuzz")
    client = ActionClient(other, SimulateSteps, f"/{node.get_name()}/simulate_steps")
    executor = EventsExecutor()
    executor.add_node(node)
    executor.add_node(other)

    def done(future: Any) -> Any:
        end = time.monotonic() + ANSWERED
        while not future.done():
            if time.monotonic() > end:
                raise TimeoutError("a goal has no answer")
            executor.spin_once(timeout_sec=0.01)
        return future.result()

    def send(_: int) -> int:
        """Some goals at once: each ends those before it."""
        r = nonsense.random
        node.simulation.state = PAUSED if r.random() < 0.9 else PLAYING
        node.loop.pause().result(ANSWERED)
        asked = [r.choice((0, 1, 2, 3, ENDLESS)) for _ in range(r.choice((1, 4, 8)))]  # a service keeps ten
        sent = [client.send_goal_async(SimulateSteps.Goal(steps=steps)) for steps in asked]
        goals = [done(future) for future in sent]
        for steps, goal in zip(asked, goals, strict=True):
            if steps == ENDLESS:
                goal.cancel_goal_async()
        for steps, goal in zip(asked, goals, strict=True):
            result = done(goal.get_result_async()).result.result
            if steps == ENDLESS and result.result == result.RESULT_OK:
                raise AssertionError("endless steps are done")
        return len(asked)

    try:
        done_before = time.monotonic()
        while not client.server_is_ready():
            executor.spin_once(timeout_sec=0.1)
            if time.monotonic() - done_before > ANSWERED:
                raise TimeoutError("no action server")
        give(figures, "~/simulate_steps", count, send)
    finally:
        executor.shutdown()
        client.destroy()
        other.destroy_node()


def fuzz_robot(count: int, seed: int = 1) -> Figures:
    """So many of each: commands both ways, loads, parameters, services, goals; all published is finite."""
    figures: Figures = {}
    nonsense = Nonsense(seed)
    rates = dict.fromkeys(("elastic_rate", "shape_rate", "clock_rate"), 1000.0)
    with running(FlexsimNode, scene=ROBOT, mode="fast", **rates) as node:
        ears = [Ear(node._joints, JointState, ("position", "velocity", "effort")),
                Ear(node._elastic, ElasticState, ("displacement", "position"))]  # fmt: skip

        def message(k: int, kind: type, hear: Callable[[Any], None]) -> None:
            hear(nonsense.message(kind))
            if k % 100 == 0 and node.loop.trouble:
                node.loop.reset().result(ANSWERED)

        for topic, kind, hear in (
            ("~/commands", Float64MultiArray, node._on_commands),
            ("robot_joint_commands", JointState, node._on_joints),
            ("~/wrench", WrenchStamped, node._on_wrench),
        ):
            give(figures, topic, count, lambda k, kind=kind, hear=hear: message(k, kind, hear))  # type: ignore[misc]

        def change(k: int) -> None:
            names = [*CHANGEABLE] if k % 2 else [*meanings(), f"{OVERRIDE}solver.step", "use_sim_time"]
            several = range(nonsense.random.randint(1, 3))
            answer = node._change([nonsense.parameter(names) for _ in several])
            assert answer.successful or answer.reason

        give(figures, "~/set_parameters", count, change)
        node._change([Parameter("faults", value="[]")])
        ask_everything(node, nonsense, count, figures)
        send_goals(node, nonsense, count, figures)
        node.loop.pause().result(ANSWERED)
        node.loop.reset(time=True).result(ANSWERED)
        assert node.loop.step(100).result(ANSWERED) == 100
        assert node.loop.failure is None
        assert node.commands.refused.total() > count
        for ear in ears:
            assert ear.count > 100
            ear.check()
    return figures


def fuzz_door(count: int, seed: int = 2) -> Figures:
    """The same for thermal_node: measured temperatures, parameters, services, goals."""
    figures: Figures = {}
    nonsense = Nonsense(seed)
    with running(ThermalNode, scene=DOOR, time_scale=0.0, duration=1e6) as node:
        give(figures, "furnace/measured_temperature", count,
             lambda _: node._on_measured(nonsense.message(Temperature)))  # fmt: skip

        def change(_: int) -> None:
            answer = node._change([nonsense.parameter([*DOOR_PARAMETERS])])
            assert answer.successful or answer.reason

        give(figures, "~/set_parameters", count, change)
        ask_everything(node, nonsense, count, figures)
        send_goals(node, nonsense, count, figures)
        node._change([Parameter("duration", value=0.0), Parameter("time_scale", value=0.0)])
        node.loop.pause().result(ANSWERED)
        node.loop.reset(time=True).result(ANSWERED)
        node.loop.measure(500.0)
        assert node.loop.step(3).result(ANSWERED) == 3
        assert np.isfinite(node.test.temperature).all()
        assert node.loop.failure is None
    return figures


def fuzz_wire(count: int, seed: int = 3) -> Figures:
    """Over DDS: so many messages and torn ones a topic, a flood, two commanders; the node goes on."""
    figures: Figures = {}
    nonsense = Nonsense(seed)
    environment = own_domain()
    before = os.environ.get("ROS_DOMAIN_ID")
    os.environ["ROS_DOMAIN_ID"] = environment["ROS_DOMAIN_ID"]
    try:
        with (
            tempfile.TemporaryDirectory() as folder,
            stopped_by_signals() as stopped,
            processes(Path(folder), environment, stopped) as trial,
        ):
            robot = trial.start("flexsim_node", [*NODE, "--ros-args", "-p", f"scene:={ROBOT}"])
            trial.wait_until_said(robot, "kernels ready", timeout=STARTED)
            with tool_node("fuzz") as node:
                over_the_wire(node, trial.check, nonsense, count, figures)
            trial.end(robot)
            if "Traceback" in robot.log.read_text(errors="replace"):
                raise AssertionError(robot.log.read_text(errors="replace"))
    finally:
        if before is not None:
            os.environ["ROS_DOMAIN_ID"] = before
    return figures


def over_the_wire(
    node: Any, check: Callable[[], None], nonsense: Nonsense, count: int, figures: Figures
) -> None:
    """Send to the node that is there, and look whether it goes on."""
    kinds = {"flexsim_node/commands": Float64MultiArray, "robot_joint_commands": JointState,
             "flexsim_node/wrench": WrenchStamped}  # fmt: skip
    publishers = {topic: node.create_publisher(kind, topic, 10) for topic, kind in kinds.items()}
    other = node.create_publisher(Float64MultiArray, "flexsim_node/commands", 10)
    states = node.create_subscription(JointState, "joint_states", lambda _: None, 1000)
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)
    good = {
        "flexsim_node/commands": Float64MultiArray(data=[1.0, 2.0, 3.0]),
        "robot_joint_commands": JointState(name=["joint_1"], effort=[1.0]),
        "flexsim_node/wrench": WrenchStamped(),
    }
    last: JointState | None = None

    def hear() -> None:
        nonlocal last
        check()
        with states.handle:
            while taken := states.handle.take_message(JointState, False):
                last = taken[0]
                for values in (last.position, last.velocity, last.effort):
                    if not all(map(math.isfinite, values)):
                        raise AssertionError(f"published {last}")

    def until(condition: Callable[[], Any], failure: str) -> Any:
        end = time.monotonic() + ANSWERED
        while not (found := condition()):
            if time.monotonic() > end:
                raise TimeoutError(failure)
            executor.spin_once(timeout_sec=0.005)
            hear()
        return found

    def ask(kind: Any, name: str) -> Any:
        client = node.create_client(kind, f"flexsim_node/{name}")
        until(client.service_is_ready, f"no service {name}")
        future = client.call_async(kind.Request())
        return until(lambda: future.done() and future.result(), f"{name}: no answer")

    until(lambda: all(p.get_subscription_count() for p in [*publishers.values(), other]), "nobody listens")

    def send(k: int, topic: str) -> None:
        publisher = publishers[topic]
        publisher.publish(nonsense.message(kinds[topic]))
        publisher.publish(nonsense.torn(serialize_message(good[topic])))
        if k % 200 == 0:
            hear()

    for topic in kinds:
        give(figures, f"{topic} over DDS, whole and torn", count, lambda k, topic=topic: send(k, topic))  # type: ignore[misc]
        figures[f"{topic} over DDS, whole and torn"]["inputs"] *= 2
    flood = serialize_message(good["flexsim_node/commands"])
    begun, sent = time.monotonic(), 0
    while time.monotonic() - begun < 1.0:
        other.publish(flood)
        sent += 1
        if sent % 200 == 0:
            hear()
    figures["flexsim_node/commands over DDS, a flood"] = {"inputs": sent, "seconds": 1.0}
    ask(srv.ResetSimulation, "reset_simulation")

    def obeyed() -> bool:
        other.publish(Float64MultiArray(data=[0.25, 0.5, 0.75]))
        return last is not None and list(last.effort) == [0.25, 0.5, 0.75]

    until(obeyed, "a good command does nothing")
    trouble = ask(srv.GetSimulationState, "get_simulation_state").result.error_message
    if trouble:
        raise AssertionError(trouble)
    executor.shutdown()


PARTS = {"flexsim_node": fuzz_robot, "thermal_node": fuzz_door, "over DDS": fuzz_wire}


def fuzz(part: str, count: int, seed: int) -> Figures:
    """One part, in a ROS domain of its own."""
    os.environ.update(own_domain())
    return PARTS[part](count, seed)


def main() -> None:
    """Try all of it, each part in a process of its own, and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=10_000, help="inputs of each interface")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    arguments = parser.parse_args()
    with ProcessPoolExecutor(len(PARTS), multiprocessing.get_context("spawn")) as pool:
        asked = {part: pool.submit(fuzz, part, arguments.count, arguments.seed) for part in PARTS}
        found = {part: figures.result() for part, figures in asked.items()}
    if arguments.json:
        print(json.dumps(found, indent=2))
        return
    for name, figures in found.items():
        print(name)
        for interface, figure in figures.items():
            print(f"  {interface:55} {figure['inputs']:8} inputs {figure['seconds']:8.1f} s")


if __name__ == "__main__":
    main()
