"""What the documented commands find in their folder."""

from __future__ import annotations

import shutil
import signal
from pathlib import Path

import numpy as np
from flexsim.sweep.table import Row, Table
from listening import PATIENCE, node_words
from processes import Background, command, ros_environment
from robot_process import Robot

ROOT = Path(__file__).parents[2]
# A controller of one's own, as docs/controllers.md asks for it: two joints, held on the trajectory.
CONTROLLER = """
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory

rclpy.init()
node = rclpy.create_node("my_controller")
commands = node.create_publisher(Float64MultiArray, "flexsim_node/commands", 10)
way, states, answered = [], [], []

def seconds(time):
    return time.sec + 1e-9 * time.nanosec

def heard(trajectory):
    way.append(trajectory)
    for state in states[-1:]:
        answer(state)

def answer(state):
    states.append(state)
    stamp = seconds(state.header.stamp)
    if not way or stamp in answered[-1:]:
        return
    answered.append(stamp)
    point = min(way[-1].points, key=lambda p: abs(seconds(p.time_from_start) - stamp))
    errors = zip(point.positions, state.position, state.velocity)
    commands.publish(Float64MultiArray(data=[20.0 * (w - q) - 2.0 * v for w, q, v in errors]))

latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
node.create_subscription(JointTrajectory, "joint_trajectory", heard, latched)
node.create_subscription(JointState, "joint_states", answer, 10)
try:
    rclpy.spin(node)
except KeyboardInterrupt:
    pass
"""

INERTIAL = (
    '<inertial><origin xyz="0 0 0.2"/><mass value="2"/>'
    '<inertia ixx="0.03" ixy="0" ixz="0" iyy="0.03" iyz="0" izz="0.003"/></inertial>'
)
# An arm of two links and a tool, as a URDF has it.
URDF = f"""<robot name="arm"><link name="ground"/><link name="tool"/>
<link name="upper_arm">{INERTIAL}</link><link name="forearm">{INERTIAL}</link>
<joint name="shoulder" type="continuous"><parent link="ground"/><child link="upper_arm"/>
<axis xyz="0 1 0"/></joint>
<joint name="elbow" type="continuous"><parent link="upper_arm"/><child link="forearm"/><origin xyz="0 0 0.4"/>
<axis xyz="0 1 0"/></joint>
<joint name="flange" type="fixed"><parent link="forearm"/><child link="tool"/><origin xyz="0 0 0.4"/></joint>
</robot>
"""


def recorded_robot(folder: Path) -> Path:
    """Record half a second of a robot in real time, from its first state on; returns the bag."""
    environment = ros_environment()
    bag = folder / "run"
    recorder = Background(command("record", "-o", bag, "--json"), environment, folder)
    scene = ROOT / "config" / "anthropomorphic.yaml"
    words = node_words("flexsim_node.node", scene, rate=200.0, wait_for_command=True)
    process = Background(words, environment, folder)
    arm = Robot(process, int(environment["ROS_DOMAIN_ID"]))
    try:
        recorder.wait_for("+ scene of /flexsim_node: anthropomorphic", PATIENCE)
        for topic in ("/joint_states", "/flexsim_node/elastic_state", "/flexsim_node/commands"):
            recorder.wait_for(f"+ {topic}")
        arm.connected()
        arm.command([1.0, 2.0, 0.5])
        arm.until(lambda: arm.time() > 0.5)
    finally:
        arm.close()
        assert process.end(signal.SIGINT) == 0, process.errors.read_text()
        assert recorder.end(signal.SIGINT) == 0, recorder.errors.read_text()
    return bag


def furnace_log(folder: Path) -> None:
    """Write the thermocouples of an hour of a fire, of a door with other wool, with noise; of three tests."""
    from thermal_node import load_scene, simulate

    door = load_scene(ROOT / "config" / "thesis_door.yaml", {
        "solver.model": "column_rim", "deformation.model": "none", "materials.rock_wool.density": 140.0,
    })  # fmt: skip
    run = simulate(door, 3600.0, 120.0)
    names = ["tc_1", "tc_6", "tc_7", "tc_9", "interior_third", "interior_two_thirds"]
    readings = np.column_stack([run.probes[name] for name in names])
    for name, seed in {"LOG.csv": 5, "log.csv": 5, "A.csv": 6, "B.csv": 7, "LARGER_LOG.csv": 8}.items():
        noise = np.random.default_rng(seed).normal(0.0, 0.5, readings.shape)
        rows = np.column_stack([run.time, readings + noise])
        np.savetxt(folder / name, rows, delimiter=",", comments="", header=",".join(["time", *names]))


def prepare(needs: tuple[str, ...], folder: Path, bag: Path | None) -> None:
    """Put what a command needs beside a copy of config/ into its folder."""
    shutil.copytree(ROOT / "config", folder / "config")
    for name in needs:
        if name in ("run", "again"):
            assert bag is not None
            shutil.copytree(bag, folder / name)
        elif name == "log":
            furnace_log(folder)
        elif name == "parts":
            for part in ("a", "b"):
                with Table(folder / f"{part}.sqlite") as table:
                    table.add(Row(part, {}, {"y": 1.0}))
        elif name == "larger":
            door = (ROOT / "config" / "thesis_door.yaml").read_text()
            (folder / "larger.yaml").write_text(
                door.replace("name: thesis_door", "name: larger_door").replace("width: 1.0", "width: 1.4")
            )
        elif name == "bench":
            (folder / "my_controller.py").write_text(CONTROLLER)
            robot = (ROOT / "config" / "planar_double_pendulum.yaml").read_text()
            (folder / "robot.yaml").write_text(
                robot.replace("gravity: [0.0, -9.81, 0.0]", "gravity: [0, 0, 0]")
            )
        elif name == "urdf":
            (folder / "arm.urdf").write_text(URDF)
        else:
            raise AssertionError(f"nobody knows how to make {name!r}")
