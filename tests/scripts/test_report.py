"""`flexsim report` tells of a run what was put into it."""

from __future__ import annotations

import array
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from flexsim.bag import Bag, BagWriter
from flexsim.bag.scenes import attached
from flexsim.bag_report.stress import LinkStrain
from flexsim.terminal.progress import Progress
from flexsim.verbs.report import look
from flexsim_msgs.msg import FireCriteria, Reactions, Thermocouples
from flexsim_ros.published_scene import scene_text
from made_bags import Topics, diagnostics, elastic_layout, elastic_state, joint_state, stamp
from processes import flexsim
from rclpy.serialization import serialize_message
from ruamel.yaml import YAML
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import Temperature
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from flexsim_node import load_scene

pytestmark = pytest.mark.ros

LENGTH, WIDTH, DEPTH, MODULUS, NU, ELEMENTS = 1.0, 0.03, 0.01, 2.0e11, 0.3, 4
SCENE = f"""
model: robot
name: cantilever
links:
  - name: link_1
    dh: {{a: {LENGTH}, alpha: 0.0, d: 0.0, theta: 0.0}}
    joint: {{name: joint_1, type: revolute, effort_limit: 9.0}}
    beam: {{width: {WIDTH}, depth: {DEPTH}, density: 7840.0, youngs_modulus: {MODULUS}, poissons_ratio: {NU},
            elements: {ELEMENTS}}}
effects: {{shear: SHEAR, centrifugal: false}}
"""
FORCE_Y, FORCE_Z, PULL, TORQUE = 20.0, 5.0, 300.0, 2.0  # at the link's end, N, N m
FREQUENCY, ZETA, BEGIN, DURATION, RATE = 5.0, 0.02, 1.5, 5.0, 500
LAG = 0.01  # rad


def bent(shear: bool) -> np.ndarray:
    """Displacement (N, 6) of a cantilever under loads at its end, in closed form."""
    x = np.linspace(0.0, LENGTH, ELEMENTS + 1)
    area, iz, iy = WIDTH * DEPTH, DEPTH * WIDTH**3 / 12.0, WIDTH * DEPTH**3 / 12.0
    g = MODULUS / (2.0 * (1.0 + NU))
    j = 0.263 * WIDTH * DEPTH**3  # Timoshenko and Goodier, table for sides 3 : 1
    cowper = 10.0 * (1.0 + NU) / (12.0 + 11.0 * NU)
    u = np.zeros((len(x), 6))
    u[:, 0] = PULL * x / (MODULUS * area)
    for axis, turn, sign, force, moment in ((1, 5, 1.0, FORCE_Y, iz), (2, 4, -1.0, FORCE_Z, iy)):
        u[:, axis] = force * x**2 * (3.0 * LENGTH - x) / (6.0 * MODULUS * moment)
        u[:, axis] += force * x / (g * cowper * area) if shear else 0.0
        u[:, turn] = sign * force * x * (2.0 * LENGTH - x) / (2.0 * MODULUS * moment)
    u[:, 3] = TORQUE * x / (g * j)
    return u


def write(path: Path, topics: set[str] | None = None, *, shear: bool = False, scene: bool = True) -> Path:
    """Write a run: the joint follows a trajectory a little late, then the link rings."""
    shape = bent(shear)
    with BagWriter(path) as bag:
        into = Topics(bag)

        def put(topic: str, data: bytes, time: float, number: int = 0, kind: str = "") -> None:
            if topics is None or topic in topics:
                into.write(topic, data, time, number, kind)

        if scene:
            text = SCENE.replace("SHEAR", str(shear).lower())
            scene_of_it = load_scene(YAML(typ="safe", pure=True).load(text)).model_dump()
            told = scene_text("flexsim_node", scene_of_it, {"rate": 1000.0}, overrides={})
            bag.attach(attached("/flexsim_node"), "application/json", told.encode())
            bag.note(
                "/flexsim_node", {"scene": '"cantilever.yaml"', "rate": "1000.0", "elastic_rate": "500.0"}
            )
        put("/flexsim_node/elastic_layout", elastic_layout({"link_1": ELEMENTS + 1}, WIDTH, DEPTH), 0.0)
        way = JointTrajectory(joint_names=["joint_1"])
        for t, q in ((0.5, 0.0), (1.0, 0.4)):
            point = JointTrajectoryPoint(positions=[q], velocities=[0.0])
            point.time_from_start.sec, point.time_from_start.nanosec = int(t), round(t % 1 * 1e9)
            way.points.append(point)
        put("/joint_trajectory", serialize_message(way), 0.0, kind="trajectory_msgs/msg/JointTrajectory")
        for k in range(round(DURATION * RATE)):
            t = k / RATE
            s = np.clip((t - 0.5) / 0.5, 0.0, 1.0)
            q = 0.4 * s**2 * (3.0 - 2.0 * s) - LAG
            effort = 9.0 if 0.5 <= t < 0.6 else 1.0
            put("/joint_states", joint_state(t, ["joint_1"], [q], [0.0], [effort]), t, k + 1)
            after = max(0.0, t - BEGIN)
            omega = 2.0 * np.pi * FREQUENCY
            ring = np.exp(-ZETA * omega * after) * np.cos(omega * np.sqrt(1.0 - ZETA**2) * after)
            now = shape * (ring if t >= BEGIN else 0.0)
            c, n = np.cos(q), np.sin(q)
            turn = np.array([[c, -n, 0.0], [n, c, 0.0], [0.0, 0.0, 1.0]])
            rigid = np.linspace(0.0, LENGTH, ELEMENTS + 1)[:, None] * turn[:, 0]
            state = elastic_state(t, now, rigid + now[:, :3] @ turn.T, rigid)
            put("/flexsim_node/elastic_state", state, t, k + 1)
            if k % RATE == 0:
                values = {"overruns": k // RATE, "ticks": k, "real-time factor": 1.0,
                          "step time p50, µs": 40, "step time worst, µs": 90}  # fmt: skip
                put("/diagnostics", diagnostics(t, {"real time": (0, "realtime", values)}), t)
    return path


class Tags(HTMLParser):
    """Notes what a page would fetch, and whether its tags are closed."""

    VOID = ("meta", "br", "img", "link")

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.fetched: list[str] = []
        self.pictures = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.pictures += tag == "svg"
        assert tag not in ("script", "link", "iframe")
        self.fetched += [v or "" for n, v in attrs if n in ("src", "href") and not (v or "").startswith("#")]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def page(path: Path) -> Tags:
    """Read a page."""
    text = path.read_text()
    assert not re.search(r"https?:|@import|url\((?!#)", text)
    tags = Tags()
    tags.feed(text)
    assert tags.open == []
    assert tags.fetched == []
    return tags


def test_a_robot(tmp_path: Path) -> None:
    """Each figure of the report is the one that was put into the bag."""
    write(tmp_path / "run")
    done = flexsim("report", "run", "-o", "out.html", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["missing"] == []
    assert page(tmp_path / "out.html").pictures >= 7
    robot, health = found["robot"], found["health"]

    tracking = robot["tracking"]
    assert [tracking["topic"], tracking["kind"]] == ["/joint_trajectory", "trajectory"]
    assert tracking["joints"]["joint_1"]["rms"] == pytest.approx(LAG, rel=1e-6)
    assert tracking["joints"]["joint_1"]["last"] == pytest.approx(-LAG, rel=1e-6)

    torque = robot["torque"]["joint_1"]
    assert [torque["largest"], torque["limit"]] == [9.0, 9.0]
    assert torque["at_limit"] == pytest.approx(0.1 / DURATION, rel=0.03)

    tip = float(np.linalg.norm(bent(False)[-1, :3]))
    assert robot["deflection"]["largest"] == pytest.approx(tip, rel=1e-6)
    assert robot["deflection"]["at"] == pytest.approx(BEGIN)

    decay = robot["vibration"]["ring_downs"][0]
    assert decay["begin"] >= BEGIN - 0.25
    assert len(decay["modes"]) == 1
    assert decay["modes"][0]["frequency"] == pytest.approx(FREQUENCY, rel=1e-3)
    assert decay["modes"][0]["damping_ratio"] == pytest.approx(ZETA, rel=0.01)
    assert robot["vibration"]["peaks"][0] == pytest.approx(FREQUENCY, rel=0.02)
    # The first of a cantilever, about its weak axis: 1.8751^2 / (2 pi L^2) sqrt(E I / rho A).
    first = 1.87510407**2 / (2.0 * np.pi) * np.sqrt(MODULUS * DEPTH**2 / 12.0 / 7840.0)
    assert robot["vibration"]["scene_frequencies"][0] == pytest.approx(first, rel=2e-3)

    assert health["deadline"] == pytest.approx(1e-3)
    assert health["overruns"] == 4
    assert health["step_time_worst"] == pytest.approx(90e-6)


@pytest.mark.parametrize("shear", [False, True])
def test_peak_stress(tmp_path: Path, shear: bool) -> None:
    """The stress at a cantilever's root, in closed form: N/A + M c/I, shear of torsion and 3/2 Q/A."""
    found, _ = look(Bag(write(tmp_path / "run", shear=shear)), None, Progress())
    stress = found["robot"]["stress"]["link_1"]
    axial = PULL / (WIDTH * DEPTH)
    bending = 6.0 * LENGTH * (FORCE_Y / (DEPTH * WIDTH**2) + FORCE_Z / (WIDTH * DEPTH**2))
    shear_stress = TORQUE / (0.267 * WIDTH * DEPTH**2)
    assert stress["axial"] == pytest.approx(axial, rel=1e-9)
    assert stress["bending"] == pytest.approx(bending, rel=1e-9)
    assert stress["torsion"] == pytest.approx(shear_stress, rel=2e-3)  # of the table's digits
    transverse = 1.5 * np.hypot(FORCE_Y, FORCE_Z) / (WIDTH * DEPTH)
    assert stress["shear"] == pytest.approx(transverse, rel=1e-9)
    tangential = np.sqrt(3.0) * (shear_stress + transverse)
    assert stress["peak"] == pytest.approx(np.hypot(axial + bending, tangential), rel=1e-3)
    assert [stress["from_start"], stress["at"]] == [0.0, pytest.approx(BEGIN)]


def test_stress_of_a_link_that_bends_far() -> None:
    """A link bent to an arc by a moment, and twisted, by half a radian each: E c / R, and no axial stress."""
    text = SCENE.replace("SHEAR", "false").replace("centrifugal: false", "centrifugal: true")
    scene = load_scene(YAML(typ="safe", pure=True).load(text + "formulation: co_moving\n"))
    angle, elements = 0.5, 8
    radius = LENGTH / angle
    along = np.linspace(0.0, angle, elements + 1)
    length = np.full(elements, LENGTH / elements)
    nodes = np.arange(elements + 1)
    for axis, turn, sign, half in ((1, 2, 1.0, WIDTH / 2), (2, 1, -1.0, DEPTH / 2)):
        state = np.zeros((1, elements + 1, 6))
        state[0, :, 0] = radius * np.sin(along) - radius * along
        state[0, :, axis] = radius * (1.0 - np.cos(along))
        state[0, :, 3 + turn] = sign * along
        axial, bending, torsion, transverse = LinkStrain(scene.links[0], nodes, length, scene)(state)
        np.testing.assert_allclose(bending, MODULUS * half / radius, rtol=1e-9)
        assert axial.max() < 1e-4 * bending.max()
        assert torsion.max() < 1e-9 * bending.max()
        assert transverse.max() < 1e-9 * bending.max()  # a moment alone
        # Turned as a whole, as a link behind another is, nothing changes.
        whole = Rotation.from_rotvec([0.3, -0.4, 0.7])
        place = state[0, :, :3] + np.linspace(0.0, LENGTH, elements + 1)[:, None] * [1.0, 0.0, 0.0]
        other = np.zeros_like(state)
        other[0, :, :3] = whole.apply(place) - (place - state[0, :, :3])
        other[0, :, 3:] = (whole * Rotation.from_rotvec(state[0, :, 3:])).as_rotvec()
        again = LinkStrain(scene.links[0], nodes, length, scene)(other)
        np.testing.assert_allclose(again[1], bending, rtol=1e-9)
        assert again[2].max() < 1e-6 * bending.max()
    twisted = np.zeros((1, elements + 1, 6))
    twisted[0, :, 3] = along
    _, _, torsion, _ = LinkStrain(scene.links[0], nodes, length, scene)(twisted)
    shear_modulus = MODULUS / (2.0 * (1.0 + NU))
    arm = 0.263 * WIDTH * DEPTH**3 / (0.267 * WIDTH * DEPTH**2)
    np.testing.assert_allclose(torsion, shear_modulus * arm * angle / LENGTH, rtol=3e-3)


TOPICS = ("/joint_states", "/flexsim_node/elastic_state", "/flexsim_node/elastic_layout", "/diagnostics",
          "/joint_trajectory")  # fmt: skip


@pytest.mark.parametrize("topic", TOPICS)
def test_a_part_of_the_topics(tmp_path: Path, topic: str) -> None:
    """A bag with one topic, and one that lacks it, are reported on; what is missing is said."""
    for name, topics in (("only", {topic}), ("without", set(TOPICS) - {topic})):
        found, sections = look(Bag(write(tmp_path / name, topics, scene=False)), None, Progress())
        missing = " ".join(words for section in sections for words in section.gaps)
        if name == "without" and topic == "/joint_states":
            assert "holds no joint states" in missing
            assert found["robot"]["vibration"]["ring_downs"]
        if name == "without" and topic == "/diagnostics":
            assert "holds no /diagnostics" in missing
        if name == "without" and topic == "/joint_trajectory":
            assert "does not say where the joints were to be" in missing
        if name == "only" and topic == "/diagnostics":
            assert "neither joint states, elastic states nor a door" in missing
        if name == "without" and topic != "/flexsim_node/elastic_state":
            assert found["robot"]["deflection"]
            assert "Stress: the bag does not hold its scene" in missing
        elif name == "without":
            assert "holds no elastic states" in missing


def test_a_door(tmp_path: Path) -> None:
    """A door's curves, limits and verdict."""
    with BagWriter(tmp_path / "fire") as bag:
        topics = Topics(bag)
        for k in range(0, 3601, 10):
            rise = 150.0 * k / 3600.0
            criteria = FireCriteria(
                criterion=["mean temperature rise", "maximum temperature rise"],
                value=array.array("d", [rise, 1.5 * rise]), limit=array.array("d", [140.0, 180.0]),
                failed=[rise > 140.0, 1.5 * rise > 180.0],
                time_of_failure=array.array("d", [3360.0 if rise > 140.0 else -1.0,
                                                  2880.0 if 1.5 * rise > 180.0 else -1.0]),
                verdict=f"A-30 after {k} s",
            )  # fmt: skip
            wires = Thermocouples(name=["ftp_centre", "tc_1"], temperature=array.array("d", [20 + rise] * 2))
            gas = Temperature(temperature=20.0 + k / 4.0)
            gone = Reactions(material=["board"], reaction=["dry"], degree=array.array("d", [k / 7200.0]))
            for topic, kind, message in (
                ("/door/criteria", "flexsim_msgs/msg/FireCriteria", criteria),
                ("/door/thermocouples", "flexsim_msgs/msg/Thermocouples", wires),
                ("/furnace/temperature", "sensor_msgs/msg/Temperature", gas),
                ("/door/reactions", "flexsim_msgs/msg/Reactions", gone),
            ):
                message.header.stamp = stamp(k)
                topics.write(topic, serialize_message(message), k / 60.0, 0, kind)
    done = flexsim("report", "fire", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    door = json.loads(done.stdout)["door"]
    assert door["verdict"] == "A-30 after 3600 s"
    assert door["criteria"]["maximum temperature rise"] == {
        "value": pytest.approx(225.0), "limit": 180.0, "failed": True, "time_of_failure": 2880.0,
    }  # fmt: skip
    assert door["furnace"]["last"] == pytest.approx(920.0)
    assert door["reactions"] == {"board: dry": 0.5}
    assert page(tmp_path / "fire.html").pictures >= 3
    assert "A-30 after 3600 s" in (tmp_path / "fire.html").read_text()


def test_wrong_words(tmp_path: Path) -> None:
    """One sentence, and the exit code that says whose fault it is."""
    (tmp_path / "notes.txt").write_text("no bag")
    (tmp_path / "folder").mkdir()
    write(tmp_path / "run", {"/diagnostics"})
    for words, code, said in (
        (["nowhere"], 1, "nowhere does not exist"),
        (["notes.txt"], 1, "notes.txt is not an MCAP file"),
        (["folder"], 1, "folder is not a bag: it holds no .mcap file"),
        (["run", "-o", "no/such/out.html"], 1, "does not exist"),
        (["run", "--scene", "nothing.yaml"], 1, "nothing.yaml does not exist"),
        ([], 2, "Missing argument 'BAG'"),
        (["run", "--pages", "3"], 2, "No such option"),
    ):
        done = flexsim("report", *words, cwd=tmp_path)
        assert [done.returncode, said in done.stderr] == [code, True], done.stderr
        assert "Traceback" not in done.stderr
