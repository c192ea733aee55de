"""The marching loop and its parameters, without ROS: pause, step, reset, pace, refusals."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from door_scenes import door
from flexsim_core.kept_kernels import forget_stale_kernels

from thermal_node import load_scene
from thermal_node.furnace.plausibility import NOT_FINITE, TOO_HIGH, TOO_LOW
from thermal_node.service.background_deformation import BackgroundDeformation
from thermal_node.service.fire_test import FireTest
from thermal_node.service.realtime import Loop, Output
from thermal_node.service.settings import SettingError, settings

COLUMN = door(solver={"model": "column"})


def until(condition: Callable[[], object]) -> None:
    end = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def looped(pace: float = math.inf, **options: object) -> tuple[Loop, list[tuple[int, float]]]:
    test = FireTest(load_scene(COLUMN))
    test.warm()
    seen: list[tuple[int, float]] = []
    output = Output(1, lambda stamp: seen.append((stamp, test.time)))
    return Loop(test, 1.0, pace, [output], **options), seen  # type: ignore[arg-type]


def test_pause_step_reset_resume() -> None:
    """Steps are whole ticks; a reset gives the cold door and lets stamps go on."""
    loop, seen = looped(duration=50.0)
    loop.start()
    until(lambda: loop.report.phase == "ended")
    assert loop.test.time == pytest.approx(50.0)
    with pytest.raises(RuntimeError, match="pause it before you step"):
        loop.step().result(20)
    loop.pause().result(20)
    loop.reset().result(20)
    assert loop.test.time == 0.0
    assert loop.test.readings.max() == 20.0
    assert loop.test.criteria.time_to_failure is None
    assert loop.time == 50_000_000_000
    assert loop.step(3).result(20) == 3
    assert loop.test.time == pytest.approx(3.0)
    time.sleep(0.2)
    assert loop.test.time == pytest.approx(3.0)
    until(lambda: loop.report.phase == "paused")
    assert loop.step(100).result(20) == 47  # to the end of the test, not beyond
    loop.reset(time=True).result(20)
    assert loop.time == 0
    loop.resume().result(20)
    until(lambda: loop.report.phase == "ended")
    loop.stop()
    assert loop.failure is None
    before_the_reset = [stamp for stamp, _ in seen[:51]]
    assert before_the_reset == [k * 1_000_000_000 for k in range(51)]
    with pytest.raises(RuntimeError, match="has ended"):
        loop.pause().result(20)


def test_the_pace_is_kept() -> None:
    """At forty times real time ten ticks take a quarter of a second, and not less."""
    loop, _ = looped(pace=40.0, duration=10.0)
    begun = time.monotonic()
    loop.start()
    until(lambda: loop.report.phase == "ended")
    loop.stop()
    assert time.monotonic() - begun > 0.24


def test_centuries() -> None:
    """A tick that is centuries away is waited for, and a stamp that ROS can't tell ends the test."""
    loop, seen = looped(pace=1e-12)
    loop._offset = (2**31 - 4) * 1_000_000_000
    loop.start()
    until(lambda: loop.report.phase == "running")
    loop.ask(lambda: loop.change(math.inf, 0.0, loop.outputs)).result(20)
    until(lambda: loop.report.phase == "ended")
    loop.stop()
    assert loop.failure is None
    assert seen[-1][0] == (2**31 - 1) * 1_000_000_000


def test_it_waits_for_the_furnace_and_refuses_nonsense() -> None:
    loop, _ = looped(duration=30.0, wait_for_furnace=True)
    loop.start()
    refused = [loop.measure(value) for value in (math.nan, -1e3, 1e5)]
    assert [one and one.reason for one in refused] == [NOT_FINITE, TOO_LOW, TOO_HIGH]
    until(lambda: loop.report.phase == "waiting")
    time.sleep(0.1)
    assert loop.test.time == 0.0
    assert "waits for the first measured temperature" in loop.hindrance and not loop.trouble
    assert loop.measure(500.0) is None
    until(lambda: loop.report.phase == "ended")
    loop.stop()
    assert loop.report.furnace == 500.0
    assert loop.report.accepted == 1
    assert loop.report.refused.total() == 3


def test_deflections_come_beside_the_march() -> None:
    """The last state gets its shape, and a failure of the shape does not stop the march."""
    mesh = {"in_plane": [6, 8], "layers": [1, 4, 1], "symmetry": "quarter"}
    scene = load_scene(
        door(mesh=mesh, deformation={"model": "shell", "in_plane": [6, 8]}),
        {"materials.rock_wool.youngs_modulus": 5e5},
    )
    test = FireTest(scene)
    background = BackgroundDeformation(test.model)
    bent = []
    loop = Loop(test, 1.0, math.inf, [], duration=60.0, deformation=background,
                deflection_period=20.0, bent=bent.append)  # fmt: skip
    loop.start()
    until(lambda: bent and bent[-1].time == pytest.approx(60.0))
    assert bent[-1].whole.shape == test.whole.nodes.shape
    loop.reset().result(20)
    background._deformation = None  # type: ignore[assignment]
    until(lambda: loop.report.deformation_failure)
    loop.stop()
    assert loop.failure is None


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({}, "no scene is given"),
        ({"rate": 0.0}, "rate is 0; give"),
        ({"rate": math.nan}, "rate is nan; give"),
        ({"field_rate": 0.3}, "a whole part of it: 0.333333 Hz"),
        ({"field_rate": 2.0}, "at most rate: 1"),
        ({"time_scale": -1.0}, "give 1e-06 to 1e+09, or 0.0"),
        ({"time_scale": math.nan}, "give 1e-06 to 1e+09, or 0.0"),
        ({"time_scale": 5e-324}, "give 1e-06 to 1e+09, or 0.0"),
        ({"duration": math.inf}, "give seconds"),
        ({"publish_clock": 1}, "give true or false"),
        ({"duratoin": 1.0}, "did you mean duration?"),
    ],
)
def test_parameters_refused(given: dict[str, object], sentence: str) -> None:
    scene = {"scene": "door.yaml"} if given else {}
    with pytest.raises(SettingError) as refused:
        settings(scene | given)
    assert sentence in str(refused.value)


def test_stale_kernels_are_forgotten(tmp_path: Path) -> None:
    """A kernel that is older than any source goes, with its index; younger ones stay."""
    cache = tmp_path / "__pycache__"
    cache.mkdir()
    source, index, data = tmp_path / "heat.py", cache / "heat.f-1.py312.nbi", cache / "heat.1.nbc"
    for path in (source, index, data):
        path.write_text("")
    os.utime(source, (1000.0, 1000.0))
    forget_stale_kernels(tmp_path)
    assert index.exists() and data.exists()
    os.utime(index, (500.0, 500.0))
    forget_stale_kernels(tmp_path)
    assert not index.exists() and not data.exists()
