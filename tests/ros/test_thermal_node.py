"""The door's node does over DDS what it promises: right numbers, a measured furnace, a clean end."""

from __future__ import annotations

import math
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest
from door_process import SCENE, SMALL, door, words
from listening import PATIENCE, seconds
from processes import Background, ros_environment

from thermal_node import load_scene, simulate

pytestmark = pytest.mark.ros
OVERRIDES = {name.removeprefix("override__").replace("__", "."): value for name, value in SMALL.items()}


def test_it_publishes_the_offline_simulation(tmp_path: Path) -> None:
    """Each topic has at its stamp what `simulate` has at that time; none is ever not finite."""
    begin = {"override__furnace__curve": "constant", "override__furnace__temperature": 600.0}
    scene = load_scene(SCENE, OVERRIDES | {"furnace": {"curve": "constant", "temperature": 600.0}})
    run = simulate(scene, duration=120.0, sample_period=1.0)
    # Started by a first measurement, so that nothing is published before all are connected.
    with door(tmp_path, **begin, rate=1.0, field_rate=0.1, time_scale=0.0, duration=120.0,
              deflection_period=30.0, wait_for_furnace=True, publish_clock=True) as burning:  # fmt: skip
        mesh = burning.until(lambda: burning.heard["door/mesh"])[-1]
        burning.until(lambda: burning.heard["furnace/temperature"])
        first = burning.until(lambda: burning.heard["door/thermocouples"])[-1]
        burning.until(lambda: burning.heard["door/temperature_field"])
        assert seconds(first) == 1e-9  # zero means "no time" to ROS
        np.testing.assert_allclose(first.temperature, 20.0)
        burning.measure_on(600.0)
        end = burning.at("door/thermocouples", 120.0)
        readings = dict(zip(end.name, end.temperature, strict=True))
        for name, found in readings.items():
            assert found == pytest.approx(run.probes[name][-1], abs=1e-6), name
        nodes = np.array(mesh.nodes).reshape(-1, 3)
        bricks = np.array(mesh.hexahedra).reshape(-1, 8)
        assert bricks.max() == len(nodes) - 1
        assert len(mesh.layer) == len(bricks) and set(mesh.layer) == {0, 1, 2}
        assert mesh.layer_names == ["steel", "rock_wool", "steel"]
        field = np.array(burning.at("door/temperature_field", 120.0).temperature)
        quarter = {tuple(np.round(p, 9)): t for p, t in zip(run.nodes, run.temperature[-1], strict=True)}
        for place, t in zip(np.abs(np.round(nodes, 9)), field, strict=True):
            assert t == pytest.approx(quarter[tuple(place)], abs=1e-6)
        points = burning.at("door/temperature_points", 120.0)
        cloud = np.frombuffer(points.data, "<f4").reshape(-1, 4)
        np.testing.assert_allclose(cloud, np.column_stack([nodes, field]), rtol=1e-6, atol=1e-6)
        image = burning.at("door/unexposed/image", 120.0)
        pixels = np.frombuffer(image.data, "<f4").reshape(image.height, image.width)
        assert image.encoding == "32FC1" and image.height == 2 * image.width
        assert 20.0 < pixels.min() < pixels.max() <= field.max() + 1e-3
        judged = burning.at("door/criteria", 120.0)
        offline = {c.name: c for c in run.criteria}
        for name, value, limit in zip(judged.criterion, judged.value, judged.limit, strict=True):
            if "gap" not in name:  # seen where shapes were solved, which the node chooses
                assert (value, limit) == (pytest.approx(offline[name].value, abs=1e-6), offline[name].limit)
        assert judged.verdict.split(":")[0] == run.verdict.split(":")[0]
        shape = burning.at("door/deflection", 120.0)
        assert run.bow is not None
        assert shape.bow == pytest.approx(run.bow[-1], rel=1e-6)
        assert len(shape.displacement) == len(mesh.nodes)
        assert max(shape.edge_gap) == pytest.approx(run.gap[-1], rel=1e-6)
        burning.until(lambda: burning.diagnostics().get("phase") == "ended")
        clock = [m.clock.sec + 1e-9 * m.clock.nanosec for m in burning.heard["/clock"]]
        assert clock[0] > 0.0 and (np.diff(clock) >= 0.0).all()
        for message in burning.heard["door/temperature_field"]:
            assert np.isfinite(message.temperature).all()
        # Whoever comes late gets the mesh, and soon the last state, which is repeated.
        burning.listen()
        assert burning.until(lambda: burning.heard["door/mesh"])[-1].nodes == mesh.nodes
        assert seconds(burning.until(lambda: burning.heard["door/temperature_field"])[-1]) == 120.0


def test_it_publishes_how_far_its_materials_have_reacted(tmp_path: Path) -> None:
    """The moisture that has gone, as `simulate` has it; a door without reactions has no such topic."""
    column = {"solver.model": "column", "furnace": {"curve": "constant", "temperature": 800.0}}
    scene = load_scene(SCENE, OVERRIDES | column | {"materials.rock_wool.moisture": 0.02})
    run = simulate(scene, duration=300.0, sample_period=1.0)
    name = "rock_wool: moisture"
    assert 0.1 < run.reacted[name][-1] < 1.0
    with door(tmp_path, override__solver__model="column", override__furnace__curve="constant",
              override__furnace__temperature=800.0, override__materials__rock_wool__moisture=0.02,
              time_scale=0.0, duration=300.0, deflection_period=0.0) as burning:  # fmt: skip
        gone = burning.at("door/reactions", 300.0)
        assert [f"{m}: {r}" for m, r in zip(gone.material, gone.reaction, strict=True)] == [name]
        assert list(gone.degree) == pytest.approx([run.reacted[name][-1]], abs=1e-9)
    with door(tmp_path, override__solver__model="column", time_scale=0.0, duration=2.0,
              deflection_period=0.0) as dry:  # fmt: skip
        dry.at("door/criteria", 2.0)
        assert not dry.node.get_publishers_info_by_topic("door/reactions")


def test_a_measured_furnace_drives_it(tmp_path: Path) -> None:
    """The curve until the first measurement, then the measurement; nonsense changes nothing."""
    with door(tmp_path, time_scale=20.0, rate=2.0, field_rate=1.0, furnace_timeout=30.0) as burning:
        burning.until(lambda: len(burning.heard["furnace/temperature"]) > 4)
        heard = burning.heard["furnace/temperature"]
        last = heard[-1]
        curve = 20.0 + 345.0 * math.log10(8.0 * seconds(last) / 60.0 + 1.0)
        assert last.temperature == pytest.approx(curve, abs=1e-6)
        burning.measure_on(333.0)
        for nonsense in (math.nan, math.inf, -300.0, 1e6, 1372.0):
            burning.measure(nonsense)
        burning.until(lambda: heard[-1].temperature == 333.0)
        said = burning.until(
            lambda: burning.diagnostics() if burning.diagnostics().get("refused") == "5" else None
        )
        assert said["source"] == "measured"
        assert said["refused, not finite"] == said["refused, above furnace_highest"] == "2"
        log = burning.process.errors.read_text()
        assert 1 <= log.count("refused a measured temperature") <= 5
        burning.until(lambda: float(burning.diagnostics()["since the last measured, s"]) > 30.0)
        (furnace,) = [s for s in burning.heard["/diagnostics"][-1].status
                      if s.name == "thermal_node: furnace"]  # fmt: skip
        assert furnace.level == b"\x01"
        burning.until(lambda: "the last one" in burning.process.errors.read_text())
        assert heard[-1].temperature == 333.0


def test_a_march_that_has_to_stop_says_why(tmp_path: Path) -> None:
    """A table that ends too early stops the march; its last good state is published on."""
    table = "override__materials__rock_wool__conductivity"
    with door(tmp_path, time_scale=0.0, deflection_period=0.0,
              **{f"{table}__temperature": [10.0, 100.0, 300.0],
                 f"{table}__value": [0.035, 0.043, 0.073]}) as burning:  # fmt: skip
        burning.until(lambda: burning.diagnostics().get("phase") == "stopped")
        (solver,) = [s for s in burning.heard["/diagnostics"][-1].status
                     if s.name == "thermal_node: solver"]  # fmt: skip
        assert solver.level == b"\x02"
        assert "beyond the end of its conductivity table at 300" in solver.message
        burning.heard["door/criteria"].clear()
        judged = burning.until(lambda: burning.heard["door/criteria"])[-1]
        assert "beyond the end of its conductivity table" in judged.verdict
        assert not burning.heard["door/deflection"]


@pytest.mark.parametrize(("scale", "number"), [(1.0, signal.SIGINT), (0.0, signal.SIGTERM)])
def test_signals_end_it(tmp_path: Path, scale: float, number: signal.Signals) -> None:
    """Ctrl-C and a launcher's SIGTERM end it with code 0 and without a traceback."""
    node = Background(words(time_scale=scale, **SMALL), ros_environment(), tmp_path)
    node.wait_for("kernels ready", PATIENCE)
    assert node.end(number) == 0
    assert "Traceback" not in node.errors.read_text()


@pytest.mark.parametrize(
    ("parameters", "code", "sentence"),
    [
        ({"scene": None}, 2, "no scene is given"),
        ({"scene": "/nowhere.yaml"}, 1, "/nowhere.yaml: no such file"),
        ({"time_skale": 2.0}, 2, "did you mean time_scale?"),
        ({"override__solver__model": "steady"}, 1, "has no time to go through"),
        ({"override__leaf__heigth": 2.0}, 1, "did you mean 'height'?"),
    ],
)
def test_mistakes(parameters: dict[str, object], code: int, sentence: str) -> None:
    """A mistake gets one line on stderr and the right exit code."""
    done = subprocess.run(
        words(**parameters), env=ros_environment(), capture_output=True, text=True, timeout=60
    )
    assert done.returncode == code, done.stderr
    assert sentence in done.stderr
    assert done.stderr.count("\n") == 1
