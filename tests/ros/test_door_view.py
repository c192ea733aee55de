"""What rerun is given is the door that was recorded, and the door that burns."""

from __future__ import annotations

import json
import signal
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from door_process import SCENE, SMALL, Door, words
from flexsim.bag import Bag
from flexsim.rerun_view.leaf import NORMALS, skins
from listening import PATIENCE
from processes import Background, command, flexsim, ros_environment

try:
    from rerun.chunk import RrdReader
except ImportError:  # before 0.41
    from rerun.experimental import RrdReader

pytestmark = pytest.mark.ros
SCALE = 7.0
MOIST = SMALL | {"override__materials__rock_wool__moisture": 0.01}


def cells(rrd: Path, entity: str, component: str) -> list[np.ndarray]:
    """Return an entity's values of a component over time, one array a row."""
    return [
        np.array(cell)
        for chunk in RrdReader(rrd).stream()
        if chunk.entity_path == entity and not chunk.is_static
        for cell in chunk.to_record_batch().column(component).to_pylist()
    ]


def rows(rrd: Path) -> Counter[str]:
    """Count the rows of each entity of a recording, without what is static."""
    found: Counter[str] = Counter()
    for chunk in RrdReader(rrd).stream():
        if not chunk.is_static:
            found[chunk.entity_path] += chunk.num_rows
    return found


@pytest.fixture(scope="module")
def burnt(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record a small door of two hundred seconds from beginning to end."""
    folder = tmp_path_factory.mktemp("burnt")
    environment = ros_environment()
    bag = folder / "run"
    topics = ("/door/*", "/furnace/temperature")
    recorder = Background(command("record", "-o", bag, *topics), environment, folder)
    recorder.wait_for("recording to")
    # It waits for its furnace, so that nothing burns before the recorder listens.
    start = words(time_scale=60.0, duration=200.0, deflection_period=50.0, wait_for_furnace=True,
                  **MOIST)  # fmt: skip
    node = Background(start, environment, folder)
    for topic in (
        "/door/mesh", "/door/criteria", "/door/reactions", "/door/deflection", "/furnace/temperature",
    ):  # fmt: skip
        recorder.wait_for(f"+ {topic} ", PATIENCE)
    listener = Door(node, int(environment["ROS_DOMAIN_ID"]))
    listener.measure_on(700.0)
    listener.close()
    node.wait_for("ended at 200 s", PATIENCE)
    node.process.send_signal(signal.SIGTERM)
    assert node.end() == 0
    assert recorder.end(signal.SIGINT) == 0, recorder.errors.read_text()
    return bag


def test_the_recorded_door(burnt: Path, tmp_path: Path) -> None:
    """The leaf is coloured, bent by `scale`, and plotted at its stamps, not at the clock's."""
    rrd = tmp_path / "run.rrd"
    done = flexsim("view", burnt, "--save", rrd, "--scale", SCALE, "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert said["scale"] == SCALE
    assert said["without_view"] == ["/door/temperature_points", "/thermal_node/scene"]
    found = rows(rrd)
    for entity, count in said["rows"].items():
        assert found[f"/{entity}"] == count > 0, entity
    assert {"door/fire_side", "door/infrared", "door/deflection", "door/furnace"} <= set(said["rows"])
    _, gone = Bag(burnt).array("/door/reactions", "degree")
    shown = np.concatenate(cells(rrd, "/door/reactions", "Scalars:scalars"))
    np.testing.assert_allclose(shown, 100.0 * gone.ravel())
    assert 0.0 < gone[-1, 0] < 1.0
    assert found["/door/thermocouples/limit_maximum"] == found["/door/criteria"]
    assert RrdReader(rrd).blueprints()

    bag = Bag(burnt)
    time, field = bag.array("/door/temperature_field", "temperature", clock="stamp")
    assert time[-1] == 200.0
    _, mesh = bag.array("/door/mesh", "nodes")
    nodes = mesh[0].reshape(-1, 3)
    at, shape = bag.array("/door/deflection", "displacement", clock="stamp")
    assert at[-1] == 200.0
    vertices = cells(rrd, "/door/unexposed_side", "Mesh3D:vertex_positions")[-1]
    bent = nodes + SCALE * shape[-1].reshape(-1, 3)
    face = nodes[:, 2] > nodes[:, 2].max() - 1e-9
    for place in bent[face]:
        assert np.abs(vertices - place).max(axis=1).min() < 1e-5
    colours = cells(rrd, "/door/unexposed_side", "Mesh3D:vertex_colors")[-1]
    assert len(colours) == len(vertices)
    assert len(set(colours.tolist())) > 5
    limits = np.concatenate(cells(rrd, "/door/thermocouples/limit_maximum", "Scalars:scalars"))
    np.testing.assert_allclose(limits, 200.0)  # 180 K above a cold door of 20 degrees
    assert field.min() > 19.0


def test_a_recorded_furnace_burns_the_same_door(burnt: Path) -> None:
    """`flexsim door simulate --furnace BAG` gives what the furnace did to the door before."""
    overrides = {k.removeprefix("override__").replace("__", "."): v for k, v in MOIST.items()}
    settings = [word for k, v in overrides.items() for word in ("--set", f"{k}={json.dumps(v)}")]
    done = flexsim("door", "simulate", SCENE, *settings, "--furnace", burnt, "-d", "200", "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    bag = Bag(burnt)
    _, names = bag.array("/door/thermocouples", "name")
    _, readings = bag.array("/door/thermocouples", "temperature")
    before = dict(zip(names[-1], readings[-1], strict=True))
    # The log is straight between its seconds, and the furnace leapt in the first.
    for name in ("exposed_centre", "tc_1", "tc_12"):
        assert said["probes"][name] == pytest.approx(before[name], abs=3.0), name
    assert said["probes"]["exposed_centre"] > 300.0
    done = flexsim("door", "simulate", SCENE, "--furnace", burnt.parent / "nowhere")
    assert done.returncode == 1
    assert "nowhere does not exist" in done.stderr


def test_a_door_that_burns(tmp_path: Path) -> None:
    """`flexsim view SCENE` starts the door's node, shows it, and ends it."""
    rrd = tmp_path / "live.rrd"
    view = Background(command("view", SCENE, "--save", rrd, "-d", "4", "--json"),
                      ros_environment(), tmp_path)  # fmt: skip
    assert view.process.wait(PATIENCE) == 0, view.errors.read_text()
    said = json.loads(view.output.read_text())
    found = rows(rrd)
    assert {entity: found[f"/{entity}"] for entity in said["rows"]} == said["rows"]
    assert said["scale"] == 5.0
    assert said["rows"]["door/furnace"] > 2


def test_a_door_without_its_mesh_is_refused(tmp_path: Path, burnt: Path) -> None:
    from flexsim.bag import BagWriter

    bag = Bag(burnt)
    topic = bag.topic("/door/criteria")
    writer = BagWriter(tmp_path / "half")
    channel = writer.add_topic(topic.name, topic.type, topic.profiles)
    for log_time, data in bag.messages(topic.name):
        writer.write(channel, data, log_time, log_time, 0)
    writer.close()
    done = flexsim("view", tmp_path / "half", "--save", tmp_path / "half.rrd")
    assert done.returncode == 1
    assert "record door/mesh too" in done.stderr
    assert not (tmp_path / "half.rrd").exists()


def test_the_skin_is_closed_and_looks_outwards() -> None:
    """Two bricks have ten outer faces; each triangle's normal points away from the leaf."""
    x, y, z = np.meshgrid([0.0, 1.0, 2.0], [0.0, 1.0], [0.0, 1.0], indexing="ij")
    nodes = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    number = {tuple(p): i for i, p in enumerate(nodes)}
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    bricks = np.array([[number[a + b, c, d] for a, c, d in corners] for b in (0, 1)])
    fire, unexposed = skins(bricks)
    assert len(fire.triangles) == len(unexposed.triangles) == 2 * 8
    for skin in (fire, unexposed):
        a, b, c = (nodes[skin.node[skin.triangles[:, k]]] for k in range(3))
        normal = np.cross(b - a, c - a)
        np.testing.assert_array_equal(normal, skin.normals[skin.triangles[:, 0]])
    assert set(map(tuple, np.unique(fire.normals, axis=0))) == {tuple(n) for n in NORMALS[[0, 2, 3, 4, 5]]}
