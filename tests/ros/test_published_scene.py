"""The scene in a bag is the one that its node ran, whatever became of the file and whoever recorded it."""

from __future__ import annotations

import json
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from flexsim.bag import Bag
from flexsim.bag.robot import robot_in
from flexsim.bag.scenes import scenes_in
from flexsim_ros.published_scene import scene_hash
from listening import PATIENCE
from processes import Background, command, flexsim, ros_environment
from rclpy.qos import DurabilityPolicy, QoSProfile
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from ruamel.yaml import YAML
from std_msgs.msg import String

import thermal_node
from flexsim_node import load_scene

pytestmark = pytest.mark.ros
CONFIG = Path(__file__).parents[2] / "config"
ROBOT, DOOR = "simple_pendulum.yaml", "thesis_door_column.yaml"
NAME = "scene.yaml"  # of every file, so that only its folder tells one from another
DECIDED = {"links.link_1.beam.elements": 3, "effects.shear": "auto", "effects.rotary_inertia": "auto",
           "tolerance": 1e-3, "duration": 0.05}  # fmt: skip
LOG = "time,temperature\n0,20\n60,500\n"
OTHER_LOG = "time,temperature\n0,20\n60,900\n"

# Who runs what, and what becomes of its file once it runs.
NODES: dict[str, tuple[str, dict[str, Any], Callable[[Path], object]]] = {
    "/unchanged": (ROBOT, {}, lambda file: None),
    "/changed": (ROBOT, {}, lambda file: file.write_text(file.read_text().replace(": 2\n", ": 5\n"))),
    "/gone": (ROBOT, {"links.link_1.beam.elements": 4}, Path.unlink),
    "/decided": (ROBOT, DECIDED, lambda file: None),
    "/fire": (DOOR, {"furnace": None}, lambda file: file.with_name("log.csv").write_text(OTHER_LOG)),
}  # fmt: skip
RECORDERS = ("everything", "one topic", "the last of several files", "another program", "before the nodes")
LOOKED_AT = ("hash", "every key")


def scene_file(folder: Path, source: str, decoy: bool = False) -> Path:
    """Write a scene's file into a folder."""
    folder.mkdir(parents=True)
    file = folder / NAME
    scene = YAML(typ="safe").load((CONFIG / source).read_text())
    if source == DOOR:
        scene["furnace"] = {"curve": "measured", "file": "log.csv"}
        (folder / "log.csv").write_text(OTHER_LOG if decoy else LOG)
    if decoy:
        scene["name"] = "decoy"
    YAML(typ="safe").dump(scene, file)
    return file


def expected(file: Path, source: str, changes: dict[str, Any]) -> dict[str, Any]:
    """Return the scene that a node is to publish, every key of it; what it decides is told as it is."""
    if source == DOOR:
        found = thermal_node.load_scene(file).model_dump(exclude={"source"})
        log = {"file": None, "time": [0.0, 60.0], "temperature": [20.0, 500.0]}
        found["furnace"] = {**found["furnace"], **log}
    else:
        found = load_scene(file, changes).model_dump()
    return dict(json.loads(json.dumps(found)))


def words(node: str) -> list[str]:
    """Return the command line of a node, on a scene that it names without its folder."""
    source, changes, _ = NODES[node]
    kind = "thermal_node" if source == DOOR else "flexsim_node"
    given: dict[str, Any] = {"rate": 10.0} if source == DOOR else {"rate": 100.0, "elastic_rate": 100.0}
    given |= {
        "scene": NAME,
        **{f"override.{key}": value for key, value in changes.items() if value is not None},
    }
    parameters = [word for name, value in given.items() for word in ("-p", f"{name}:={value}")]
    return [sys.executable, "-m", f"{kind}.node", "--ros-args", "-r", f"__ns:={node}", *parameters]


def recorded_by_another(path: Path, domain: int, topics: list[str]) -> None:
    """Record the scenes as any program can that knows nothing of us."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain)
    node = rclpy.create_node("another_recorder", context=context)
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    heard = {
        name: node.create_subscription(String, name, lambda _: None, latched, raw=True) for name in topics
    }
    store = get_typestore(Stores.ROS2_JAZZY)
    end = time.monotonic() + PATIENCE
    with Writer(path, version=9, storage_plugin=StoragePlugin.MCAP) as writer:
        while heard and time.monotonic() < end:
            for name, subscription in list(heard.items()):
                with subscription.handle:
                    taken = subscription.handle.take_message(String, True)
                if taken:
                    connection = writer.add_connection(name, "std_msgs/msg/String", typestore=store)
                    writer.write(connection, time.time_ns(), taken[0])
                    del heard[name]
            time.sleep(0.01)
    node.destroy_node()
    rclpy.shutdown(context=context)
    assert not heard


@pytest.fixture(scope="module")
def ran(
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[tuple[dict[str, Bag], dict[str, dict[str, Any]]]]:
    """Run all nodes at once, change their files, record them in every way: bags and expected scenes."""
    folder = tmp_path_factory.mktemp("scenes")
    environment = ros_environment()
    started: list[Background] = []

    def begin(words: list[str], cwd: Path) -> Background:
        started.append(Background(words, environment, folder, cwd))
        return started[-1]

    try:
        yield gather(folder, int(environment["ROS_DOMAIN_ID"]), begin)
    finally:
        for process in started:
            process.process.kill()


def gather(
    folder: Path, domain: int, begin: Callable[[list[str], Path], Background]
) -> tuple[dict[str, Bag], dict[str, dict[str, Any]]]:
    """Go through it: recorders before and after, nodes, and what becomes of their files."""
    elsewhere = folder / "recorder"
    scene_file(elsewhere, ROBOT, decoy=True)  # the file of the same name where the recorders work
    first = begin(command("record", "-o", folder / "before"), elsewhere)
    wanted, nodes = {}, {}
    for node, (source, changes, _) in NODES.items():
        file = scene_file(folder / "nodes" / node.strip("/"), source)
        wanted[node] = expected(file, source, changes)
        nodes[node] = begin(words(node), file.parent)
    for node, process in nodes.items():
        process.wait_for("kernels ready", 2 * PATIENCE)
        first.wait_for(f"+ scene of {node}/", PATIENCE)
    for node, (_, _, fate) in NODES.items():
        fate(folder / "nodes" / node.strip("/") / NAME)
    assert first.end(timeout=PATIENCE) == 0
    ways = {
        "everything": (),
        "one topic": ("*/joint_states", "*/door/criteria"),
        "several": ("--max-duration", "1"),
    }
    recorders = {
        way: begin(command("record", "-o", folder / way, *more), elsewhere) for way, more in ways.items()
    }
    names = {"/fire": "thermal_node"}
    topics = [f"{node}/{names.get(node, 'flexsim_node')}/scene" for node in NODES]
    recorded_by_another(folder / "another", domain, topics)
    for process in recorders.values():
        for node in NODES:
            process.wait_for(f"+ scene of {node}/", PATIENCE)
    several = folder / "several"
    end = time.monotonic() + PATIENCE
    while len(list(several.glob("*.mcap"))) < 3 and time.monotonic() < end:
        time.sleep(0.1)
    for process in (*recorders.values(), *nodes.values()):
        assert process.end(signal.SIGINT, PATIENCE) == 0, process.errors.read_text()
    last = sorted(several.glob("*.mcap"), key=lambda p: int(p.stem.rpartition("_")[2]))[-1]
    bags = {way: folder / way for way in ("everything", "one topic")}
    bags |= {"another program": folder / "another", "before the nodes": folder / "before"}
    bags["the last of several files"] = last
    return {way: Bag(path) for way, path in bags.items()}, wanted


@pytest.mark.parametrize("looked_at", LOOKED_AT)
@pytest.mark.parametrize("recorder", RECORDERS)
@pytest.mark.parametrize("node", NODES)
def test_the_bag_s_scene_is_the_node_s(ran: Any, node: str, recorder: str, looked_at: str) -> None:
    """Fifty arrangements: what became of the file, who recorded it and where, and what is read of it."""
    bags, wanted = ran
    (found,) = [one for name, one in scenes_in(bags[recorder]).items() if name.startswith(f"{node}/")]
    assert found.scene is not None, found.why_not
    told = found.scene
    if looked_at == "hash":
        assert told.hash == scene_hash(told.scene)
        assert {other for other, scene in wanted.items() if scene_hash(scene) == told.hash} <= {
            node,
            "/changed",
            "/unchanged",
        }
        return
    scene = json.loads(json.dumps(wanted[node]))
    if node == "/decided":  # both effects are decided, and it is told how
        assert {told.scene["effects"][name] for name in ("shear", "rotary_inertia")} <= {True, False}
        assert any(line.startswith("shear: ") for line in told.effects)
        for name in ("shear", "rotary_inertia"):
            scene["effects"][name] = told.scene["effects"][name]
    assert told.scene == scene
    assert told.file == NAME
    assert told.versions["numba"] and told.versions["flexsim"]
    if told.simulator == "flexsim_node":
        assert load_scene(told.scene).model_dump() == load_scene(scene).model_dump()
    else:
        assert thermal_node.load_scene(told.scene).furnace.temperature == (20.0, 500.0)


def test_who_reads_a_bag_says_which_scene_ran(ran: Any, tmp_path: Path) -> None:
    """`info` names each with its hash; a robot of the bag is simulated from its own scene."""
    bags, wanted = ran
    done = flexsim("info", bags["everything"].path, "--json", timeout=120)
    scenes = json.loads(done.stdout)["scenes"]
    assert scenes["/gone/flexsim_node"]["hash"] == scene_hash(wanted["/gone"])
    assert scenes["/gone/flexsim_node"]["overrides"] == {"links.link_1.beam.elements": 4}
    robot = robot_in(Bag(bags["everything"].path, "/gone/flexsim_node"))
    assert robot.scene is not None
    assert robot.scene.scene["links"][0]["beam"]["elements"] == 4
