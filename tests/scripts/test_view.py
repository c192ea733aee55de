"""What rerun is given is the robot that was recorded."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from processes import Background, Recorded, command, flexsim, ros_environment, synthetic_robot
from synthetic_robot import shape

try:
    from rerun.chunk import RrdReader
except ImportError:  # before 0.41
    from rerun.experimental import RrdReader

pytestmark = pytest.mark.ros


def rows(rrd: Path) -> Counter[str]:
    """Count the rows of each entity of a recording, without what is static."""
    found: Counter[str] = Counter()
    for chunk in RrdReader(rrd).stream():
        if not chunk.is_static:
            found[chunk.entity_path] += chunk.num_rows
    return found


def column(rrd: Path, entity: str, component: str) -> list[np.ndarray]:
    """Return an entity's values of a component, one array a row, in order of time."""
    values = []
    for chunk in RrdReader(rrd).stream():
        if chunk.entity_path == entity and not chunk.is_static:
            batch = chunk.to_record_batch()
            times = batch.column("time").cast("int64").to_pylist()
            cells = batch.column(component).to_pylist()
            values += zip(times, map(np.asarray, cells), strict=True)
    return [value for _, value in sorted(values, key=lambda pair: pair[0])]


@pytest.fixture(scope="module")
def shown(recorded: Recorded, tmp_path_factory: pytest.TempPathFactory) -> Path:
    rrd = tmp_path_factory.mktemp("shown") / "run.rrd"
    done = flexsim("view", recorded.bag, "--save", rrd, "--scale", 20, "--rate", 50, "--json")
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    found = rows(rrd)
    for entity, count in said["rows"].items():
        assert found[f"/{entity}"] == count
    assert said["without_view"] == ["/flexsim_node/commands"]
    return rrd


def test_every_state_is_plotted(shown: Path, recorded: Recorded) -> None:
    """Plots show every message; the 3-D view as many frames a second as asked for."""
    found = rows(shown)
    for entity in ("joints/position", "joints/velocity", "joints/effort", "robot/tip/deflection"):
        assert found[f"/{entity}"] == recorded.messages
    frames = recorded.messages / recorded.rate * 50
    for entity in ("deformed", "rigid", "nodes", "tip"):
        assert found[f"/robot/{entity}"] == pytest.approx(frames, abs=0.15 * frames)
    assert found["/robot/status"] == 3  # "ok", the warning of the second half, and that frames are thinned
    assert RrdReader(shown).blueprints()


def test_displacement_is_scaled_and_deflection_is_not(shown: Path, recorded: Recorded) -> None:
    """Shown is rigid + 20 (deformed - rigid); the tip's deflection is in true millimetres."""
    t = (1 + np.arange(recorded.messages)) / recorded.rate
    _, rigid, deformed = shape(t, 3)
    expected = rigid + 20.0 * (deformed - rigid)
    nodes = np.array(column(shown, "/robot/nodes", "Points3D:positions"))
    distance = np.abs(expected[:, None] - nodes[None]).max(axis=(2, 3)).min(axis=0)
    assert distance.max() < 1e-5

    tip = np.array(column(shown, "/robot/tip/deflection", "Scalars:scalars"))[:, 0]
    true = 1e3 * np.linalg.norm(deformed[:, -1] - rigid[:, -1], axis=1)
    np.testing.assert_allclose(tip, true, rtol=1e-12)


def test_live(tmp_path: Path) -> None:
    """A running robot is shown as it moves, all of its states."""
    environment = ros_environment()
    scene = tmp_path / "scene.yaml"
    scene.write_text("model: robot\n")
    rrd = tmp_path / "live.rrd"
    robot = synthetic_robot(environment, tmp_path, 300, 300.0, "--for-view")
    viewer = Background(command("view", scene, "--save", rrd, "--json"), environment, tmp_path)
    robot.wait_for("published")
    assert viewer.end() == 0, viewer.errors.read_text()
    robot.release()
    said = json.loads(viewer.output.read_text())["rows"]
    found = rows(rrd)
    assert {entity: found[f"/{entity}"] for entity in said} == said
    # All of it was acknowledged before Ctrl-C.
    assert said["robot/tip/deflection"] == said["joints/position"] == 300
    assert 1 <= said["robot/deformed"] <= 80
    for kind in ("axial", "bending", "torsion"):
        assert found[f"/robot/strain/{kind}"] == said["robot/deformed"]


def test_what_is_thinned_is_said(recorded: Recorded, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A recording of fewer states than the bag has says so, and how many there are."""
    import rerun as rr
    from flexsim.bag import Bag
    from flexsim.rerun_view import bag, robot_bag

    def converted(name: str) -> tuple[bag.Shown, str]:
        recording = rr.RecordingStream("test")
        recording.save(tmp_path / name)
        shown = bag.show(Bag(recorded.bag), recording, scale=None, rate=1000.0)
        recording.flush()
        words = [str(w[0]) for w in column(tmp_path / name, "/robot/status", "TextLog:text")]
        return shown, "; ".join(words)

    shown, words = converted("all.rrd")
    assert shown.thinned == {}
    assert "fewer" not in words
    monkeypatch.setattr(robot_bag, "MOST_PLOTTED", 200)
    monkeypatch.setattr(robot_bag, "MOST_FRAMES", 50)
    shown, words = converted("thin.rrd")
    assert set(shown.thinned.values()) == {recorded.messages}
    for entity in ("robot/deformed", "robot/tip/deflection", "joints/position"):
        assert 0 < shown.rows[entity] < shown.thinned[entity]
        assert f"{entity} {shown.rows[entity]} of {recorded.messages}" in words


def test_a_bag_without_a_robot(tmp_path: Path) -> None:
    """A bag with nothing to show is refused, and no empty recording stays behind."""
    assert flexsim("record", "-o", tmp_path / "empty", "-d", "0.2", "/silent").returncode == 0
    done = flexsim("view", tmp_path / "empty", "--save", tmp_path / "empty.rrd")
    assert done.returncode == 1
    assert "holds no messages, nor topics" in done.stderr
    assert not (tmp_path / "empty.rrd").exists()
