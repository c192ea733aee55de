"""What `ros2 node|topic|param|service|action|interface` of a native ROS 2 ask of the nodes, and in which way.

ros2cli is no wheel.  Its verbs are thin: they look names and types up in the graph, import the types by name,
fill messages from YAML, and guess a parameter's type by rclpy's own `get_parameter_value`; so does this.
"""

from __future__ import annotations

import importlib
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rclpy
import yaml
from ament_index_python import get_resource, get_resources
from ament_index_python.packages import get_package_share_directory
from processes import Background, ros_environment
from rclpy.action import ActionClient, get_action_names_and_types
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import get_parameter_value, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_system_default
from rclpy.topic_or_service_is_hidden import topic_or_service_is_hidden

pytestmark = pytest.mark.ros
CONFIG = Path(__file__).parents[2] / "config"
OF_EVERY_NODE = {"/rosout", "/parameter_events"}
# Two robots of one cell: a namespace, and a name of the user's own.
NODES = {
    "/cell/arm": ("flexsim_node", "anthropomorphic.yaml", {"rate": "500.0", "override.solver.step": "0.001"}),
    "/cell/door": ("thermal_node", "thesis_door_column.yaml", {"time_scale": "10"}),
}
OWN_TOPICS = {
    "/cell/arm": {
        "/cell/arm/commands", "/cell/arm/wrench", "/cell/arm/elastic_state", "/cell/arm/elastic_layout",
        "/cell/arm/deformed_shape", "/cell/joint_states", "/cell/robot_description",
        "/cell/robot_joint_commands", "/cell/arm/scene", "/clock", "/diagnostics",
    },
    "/cell/door": {
        "/cell/furnace/temperature", "/cell/furnace/measured_temperature", "/cell/door/thermocouples",
        "/cell/door/criteria", "/cell/door/temperature_field", "/cell/door/temperature_points",
        "/cell/door/unexposed/image", "/cell/door/deflection", "/cell/door/mesh",
        "/cell/door/scene", "/diagnostics",
    },
}  # fmt: skip


class Tool:
    """A node as ros2cli makes one for a verb, beside the nodes that it asks."""

    def __init__(self, domain: int, processes: list[Background]) -> None:
        self.processes = processes
        self.context = rclpy.Context()
        rclpy.init(context=self.context, domain_id=domain)
        self.node = rclpy.create_node("_ros2cli_1", context=self.context, start_parameter_services=False)
        self.executor = SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)

    def until(self, condition: Callable[[], Any], timeout: float = 180.0) -> Any:
        """Spin until something is true, and return it."""
        end = time.monotonic() + timeout
        while not (found := condition()):
            for process in self.processes:
                assert process.process.poll() is None, process.errors.read_text()
            assert time.monotonic() < end, [p.errors.read_text() for p in self.processes]
            self.executor.spin_once(timeout_sec=0.02)
        return found

    def knows_all(self) -> bool:
        """Whether it has heard of both nodes and of whose each topic is, which a verb waits for too."""
        for name, own in OWN_TOPICS.items():
            space, _, word = name.rpartition("/")
            if (word, space) not in self.node.get_node_names_and_namespaces():
                return False
            heard = self.node.get_subscriber_names_and_types_by_node(word, space)
            said = self.node.get_publisher_names_and_types_by_node(word, space)
            if not own <= {topic for topic, _ in [*heard, *said]}:
                return False
        return True

    def answer(self, future: Any) -> Any:
        """The result of a call."""
        return self.until(lambda: future.done() and future.result())

    def call(self, name: str, kind: type, values: str = "{}") -> Any:
        """`ros2 service call NAME TYPE VALUES`."""
        client = self.node.create_client(kind, name)
        self.until(client.service_is_ready)
        answer = self.answer(client.call_async(filled(kind.Request(), values)))  # type: ignore[attr-defined]
        self.node.destroy_client(client)
        return answer

    def echo(self, topic: str) -> Any:
        """`ros2 topic echo --once TOPIC`: the type and the quality of service are those of its publishers."""
        ((kind),) = dict(self.node.get_topic_names_and_types())[topic]
        endpoints = self.node.get_publishers_info_by_topic(topic)
        profile = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
        if all(e.qos_profile.reliability == ReliabilityPolicy.RELIABLE for e in endpoints):
            profile.reliability = ReliabilityPolicy.RELIABLE
        if all(e.qos_profile.durability == DurabilityPolicy.TRANSIENT_LOCAL for e in endpoints):
            profile.durability = DurabilityPolicy.TRANSIENT_LOCAL
        heard: list[Any] = []
        subscription = self.node.create_subscription(interface(kind), topic, heard.append, profile)
        self.until(lambda: heard)
        self.node.destroy_subscription(subscription)
        return heard[0]


def interface(name: str) -> type:
    """The class of `package/msg/Type`, found as ros2cli finds it."""
    package, kind, word = name.split("/")
    return getattr(importlib.import_module(f"{package}.{kind}"), word)  # type: ignore[no-any-return]


def filled(message: Any, values: str) -> Any:
    """A message with its fields from YAML, each turned into the field's own type."""
    for name, value in (yaml.safe_load(values) or {}).items():
        field = getattr(message, name)
        if isinstance(value, dict):
            filled(field, yaml.dump(value))
        elif type(field).__name__ == "array":
            setattr(message, name, [type(field)(field.typecode, [0])[0].__class__(v) for v in value])
        else:
            setattr(message, name, type(field)(value))
    return message


def plain(value: Any) -> Any:
    """What `ros2 topic echo` prints of a field."""
    if hasattr(value, "get_fields_and_field_types"):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, (str, bool, int, float)):
        return value
    return [plain(v) for v in value[:128]] if len(value) else []


@pytest.fixture(scope="module")
def tool(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Tool]:
    """Both nodes, and a tool beside them."""
    environment, started = ros_environment(), []
    for name, (package, scene, parameters) in NODES.items():
        given = {"scene": CONFIG / scene, **parameters}
        words = [w for key, value in given.items() for w in ("-p", f"{key}:={value}")]
        remapped = ["-r", "__ns:=/cell", "-r", f"__node:={name.rpartition('/')[2]}"]
        start = [sys.executable, "-m", f"{package}.node", "--ros-args", *words, *remapped]
        started.append(Background(start, environment, tmp_path_factory.mktemp(package)))
    found = Tool(int(environment["ROS_DOMAIN_ID"]), started)
    try:
        found.until(lambda: all("kernels ready" in p.errors.read_text() for p in started))
        found.until(found.knows_all)
        yield found
    finally:
        found.executor.shutdown()
        found.node.destroy_node()
        rclpy.shutdown(context=found.context)
        for process in started:
            assert process.end() == 0
            assert "Traceback" not in process.errors.read_text()


def test_node_list_and_topic_list(tool: Tool) -> None:
    """Names as the user gave them; nothing hidden, nothing twice, no topic of two types."""

    def listed() -> set[str]:
        found = tool.node.get_node_names_and_namespaces()
        return {f"{space}/{name}" for name, space in found if not name.startswith("_")}

    tool.until(lambda: listed() == set(NODES))
    expected = OF_EVERY_NODE.union(*OWN_TOPICS.values())
    topics = tool.until(
        lambda: (found := dict(tool.node.get_topic_names_and_types())).keys() >= expected and found
    )
    shown = {name for name in topics if not topic_or_service_is_hidden(name)}
    assert shown == expected
    for name in shown:
        assert len(topics[name]) == 1
    for node, own in OWN_TOPICS.items():
        space, _, word = node.rpartition("/")
        heard = tool.node.get_subscriber_names_and_types_by_node(word, space)
        said = tool.node.get_publisher_names_and_types_by_node(word, space)
        names = {n for n, _ in [*heard, *said] if not topic_or_service_is_hidden(n)}
        assert names - OF_EVERY_NODE == own


@pytest.mark.parametrize("topic", sorted({t for own in OWN_TOPICS.values() for t in own}))
def test_topic_info_and_echo(tool: Tool, topic: str) -> None:
    """Every end has a node, a type, a hash and a quality that a tool can name; every topic can be printed."""
    publishers = tool.node.get_publishers_info_by_topic(topic)
    subscribers = tool.node.get_subscriptions_info_by_topic(topic)
    kinds = {e.topic_type for e in [*publishers, *subscribers]}
    assert len(kinds) == 1
    share = Path(get_package_share_directory(next(iter(kinds)).split("/")[0]))
    for end in [*publishers, *subscribers]:
        assert f"{end.node_namespace}/{end.node_name}" in NODES
        assert str(end.topic_type_hash).startswith("RIHS01_")
        assert str(end.topic_type_hash) in (share / f"{end.topic_type.split('/', 1)[1]}.json").read_text()
        assert end.qos_profile.reliability in (ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT)
    if publishers and topic != "/cell/door/deflection":  # the leaf of one column has none
        assert yaml.safe_load(yaml.safe_dump(plain(tool.echo(topic))))


def test_diagnostics_say_whose_they_are(tool: Tool) -> None:
    """Each status begins with the name that the user gave the node, as diagnostic_updater has it."""
    heard: set[str] = set()

    def of_both() -> bool:
        heard.update(status.name for status in tool.echo("/diagnostics").status)
        return {"cell/arm: solver", "cell/door: solver"} <= heard

    tool.until(of_both)
    assert all(name.startswith(("cell/arm: ", "cell/door: ")) for name in heard)


def test_topic_pub(tool: Tool) -> None:
    """`ros2 topic pub` with its own quality of service is heard, whole numbers and all."""
    reset = interface("simulation_interfaces/srv/ResetSimulation")

    def published_until(topic: str, kind: str, values: str, taken: Callable[[], bool]) -> None:
        """Again and again, as the verb does: who subscribes with best effort may miss the first."""
        publisher = tool.node.create_publisher(interface(kind), topic, qos_profile_system_default)
        message = filled(interface(kind)(), values)

        def published() -> bool:
            publisher.publish(message)
            return taken()

        tool.until(published)
        tool.node.destroy_publisher(publisher)

    for topic, kind, values, wanted in (
        ("/cell/arm/commands", "std_msgs/msg/Float64MultiArray", "{data: [1, 2, 3]}", [1.0, 2.0, 3.0]),
        ("/cell/robot_joint_commands", "sensor_msgs/msg/JointState", "{name: [joint_2], effort: [4]}",
         [0.0, 4.0, 0.0]),
    ):  # fmt: skip
        tool.call("/cell/arm/reset_simulation", reset)  # an arm that nobody holds falls, and stops some day
        published_until(
            topic, kind, values, lambda wanted=wanted: list(tool.echo("/cell/joint_states").effort) == wanted
        )
    published_until(
        "/cell/furnace/measured_temperature",
        "sensor_msgs/msg/Temperature",
        "{temperature: 321}",
        lambda: tool.echo("/cell/furnace/temperature").temperature == 321.0,
    )


SET = (  # ros2 param set NODE NAME VALUE, whether it is taken, what is got then or said
    ("/cell/arm", "elastic_rate", "100", True, 100.0),
    ("/cell/arm", "elastic_rate", "125.0", True, 125.0),
    ("/cell/arm", "elastic_rate", "fast", False, "Wrong parameter type"),
    ("/cell/arm", "elastic_rate", ".nan", False, "give Hz"),
    ("/cell/arm", "elastic_rate", "1e3", False, "Wrong parameter type"),  # to YAML that is text
    ("/cell/arm", "publish_clock", "false", True, False),
    ("/cell/arm", "publish_clock", "True", True, True),
    ("/cell/arm", "command_timeout", "0", True, 0.0),
    ("/cell/arm", "faults", "[{kind: delay, time: 0.004}]", True, "[{kind: delay, time: 0.004}]"),
    ("/cell/arm", "faults", "[{kind: dely, time: 0.004}]", False, "give 'delay'"),
    ("/cell/arm", "faults", "[]", True, "[]"),
    ("/cell/arm", "faults", "", True, ""),
    ("/cell/arm", "mode", "fast", False, "read-only"),
    ("/cell/arm", "override.solver.step", "0.002", False, "read-only"),
    ("/cell/arm", "no_such", "1", False, "undeclared"),
    ("/cell/arm", "use_sim_time", "true", True, True),
    ("/cell/door", "time_scale", "20", True, 20.0),
    ("/cell/door", "time_scale", "-1", False, "give 1e-06 to 1e+09"),
    ("/cell/door", "duration", "1000000", True, 1e6),
    ("/cell/door", "rate", "2.0", False, "read-only"),
)


@pytest.mark.parametrize(("node", "name", "value", "taken", "then"), SET)
def test_param_set_and_get(tool: Tool, node: str, name: str, value: str, taken: bool, then: object) -> None:
    """A value is guessed from its text; where it is not taken a sentence says why."""
    client = AsyncParameterClient(tool.node, node)
    tool.until(client.services_are_ready)
    before = parameter_value_to_python(tool.answer(client.get_parameters([name])).values[0]) \
        if name != "no_such" else None  # fmt: skip
    guessed = rclpy.parameter.Parameter.from_parameter_msg(
        rclpy.parameter.ParameterMsg(name=name, value=get_parameter_value(value))
    )
    (result,) = tool.answer(client.set_parameters([guessed])).results
    assert result.successful is taken, result.reason
    if taken:
        assert parameter_value_to_python(tool.answer(client.get_parameters([name])).values[0]) == then
    else:
        assert str(then) in result.reason
        if before is not None:
            assert parameter_value_to_python(tool.answer(client.get_parameters([name])).values[0]) == before


@pytest.mark.parametrize("node", NODES)
def test_param_list_describe_dump_load(tool: Tool, node: str, tmp_path: Path) -> None:
    """Each has a type and a meaning, and says whether it may be set; what is dumped can be loaded."""
    client = AsyncParameterClient(tool.node, node)
    tool.until(client.services_are_ready)
    names = sorted(tool.answer(client.list_parameters()).result.names)
    assert {"scene", "rate", "publish_clock", "use_sim_time"} < set(names)
    own = [n for n in names if n not in ("use_sim_time", "start_type_description_service")]
    described = tool.answer(client.describe_parameters(own)).descriptors
    assert [d.name for d in described] == own
    assert all(d.type and d.description for d in described)
    changeable = {d.name for d in described if not d.read_only}
    assert "publish_clock" in changeable
    assert not {"scene", "rate"} & changeable
    values = [parameter_value_to_python(v) for v in tool.answer(client.get_parameters(names)).values]
    dump: dict[str, Any] = {}
    for name, value in zip(names, values, strict=True):
        *above, last = name.split(".")
        place = dump
        for part in above:
            place = place.setdefault(part, {})
        place[last] = value
    path = tmp_path / "dump.yaml"
    path.write_text(yaml.dump({node: {"ros__parameters": dump}}))
    (set_again,) = [tool.answer(client.load_parameter_file(str(path)))]
    for name, result in zip(sorted(names), set_again.results, strict=True):
        assert result.successful or "read-only" in result.reason, (name, result.reason)
    deleted = tool.answer(client.delete_parameters(["publish_clock"])).results
    assert not deleted[0].successful


@pytest.mark.parametrize("node", NODES)
def test_service_list_type_call_and_interface_show(tool: Tool, node: str) -> None:
    """Each service has one type, whose definition is installed, and answers an empty request."""
    space, _, word = node.rpartition("/")
    offered = tool.until(
        lambda: len(found := tool.node.get_service_names_and_types_by_node(word, space)) > 15 and found
    )
    shown = {name: kinds for name, kinds in offered if not topic_or_service_is_hidden(name)}
    names = ("get_simulator_features", "reset_simulation", "step_simulation", "get_entity_state")
    assert {f"{node}/{name}" for name in names} < shown.keys()
    packages = get_resources("rosidl_interfaces")
    for name, (kind,) in shown.items():
        package, *rest = kind.split("/")
        assert package in packages
        listed = get_resource("rosidl_interfaces", package)[0].splitlines()
        assert f"{'/'.join(rest)}.srv" in listed
        assert Path(get_package_share_directory(package), *rest).with_suffix(".srv").is_file()
        tool.call(name, interface(kind))
    state = interface("simulation_interfaces/srv/SetSimulationState")
    for wanted in (1, 2):  # play, pause
        answer = tool.call(f"{node}/set_simulation_state", state, f"{{state: {{state: {wanted}}}}}")
        assert answer.result.result == 1, answer.result.error_message
    described = tool.call(
        f"{node}/get_type_description",
        interface("type_description_interfaces/srv/GetTypeDescription"),
        yaml.safe_dump(clock_type(tool)),
    )
    assert described.successful, described.failure_reason


def clock_type(tool: Tool) -> dict[str, str]:
    """Name and hash of a type that both nodes speak."""
    (end, *_) = tool.node.get_publishers_info_by_topic("/diagnostics")
    return {"type_name": end.topic_type, "type_hash": str(end.topic_type_hash)}


@pytest.mark.parametrize("node", NODES)
def test_action_list_and_send_goal(tool: Tool, node: str) -> None:
    """`ros2 action send_goal --feedback` steps a paused simulator."""
    name = f"{node}/simulate_steps"
    (kind,) = tool.until(lambda: dict(get_action_names_and_types(tool.node)).get(name))
    assert kind == "simulation_interfaces/action/SimulateSteps"
    state = interface("simulation_interfaces/srv/SetSimulationState")
    for wanted in (1, 2):  # play, pause
        tool.call(f"{node}/set_simulation_state", state, f"{{state: {{state: {wanted}}}}}")
    action = interface(kind)
    client = ActionClient(tool.node, action, name)
    tool.until(client.server_is_ready)
    goal = tool.answer(client.send_goal_async(filled(action.Goal(), "{steps: 5}")))  # type: ignore[attr-defined]
    result = tool.answer(goal.get_result_async()).result.result
    assert (result.result, result.error_message) == (1, "")
    client.destroy()


def test_topic_hz(tool: Tool) -> None:
    """Stamps are a period apart, as `ros2 topic hz --use-sim-time` and `ros2 topic delay` see them."""
    tool.call("/cell/arm/set_simulation_state", interface("simulation_interfaces/srv/SetSimulationState"),
              "{state: {state: 1}}")  # fmt: skip
    tool.call("/cell/arm/reset_simulation", interface("simulation_interfaces/srv/ResetSimulation"))
    stamps: list[float] = []
    subscription = tool.node.create_subscription(
        interface("sensor_msgs/msg/JointState"), "/cell/joint_states",
        lambda m: stamps.append(m.header.stamp.sec + 1e-9 * m.header.stamp.nanosec), 50,
    )  # fmt: skip
    tool.until(lambda: len(stamps) > 100)
    tool.node.destroy_subscription(subscription)
    gaps = np.diff(stamps[20:])
    np.testing.assert_allclose(gaps / 2e-3, np.round(gaps / 2e-3), atol=1e-3)
    assert np.median(gaps) == pytest.approx(2e-3, abs=1e-6)
