"""The stepping loop and its schedule, without ROS: what is asked of it, and how it ends."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from flexsim_node import load_scene
from flexsim_node.motion.simulation import Simulation
from flexsim_node.service.realtime import Loop
from flexsim_node.service.settings import SettingError, Settings, schedule

SCENE = Path(__file__).parents[2] / "config" / "planar_double_pendulum.yaml"
PATIENCE = 60.0
IN_PLANE = np.array([1.0, 1.0, 0.0, 0.0, 0.0, 1.0])  # a load that leaves a planar robot in its plane


@contextmanager
def looped(mode: str, changes: dict[str, object] | None = None, **options: int) -> Iterator[Loop]:
    robot = Simulation(load_scene(SCENE, changes))
    robot.warm()
    loop = Loop(robot, 1, mode, [], **options)  # type: ignore[arg-type]
    loop.start()
    try:
        yield loop
    finally:
        loop.stop()
        assert loop.failure is None


@pytest.mark.parametrize("mode", ["realtime", "lockstep", "fast"])
def test_what_was_asked_for_leaves_nothing_behind(mode: str) -> None:
    """Thousands of wishes, as a flood of loads makes them, take no room where commands wait."""
    with looped(mode) as loop:
        loop.pause().result(PATIENCE)
        for _ in range(2000):
            last = loop.ask(lambda: loop.robot.apply("link_2", IN_PLANE))
        last.result(PATIENCE)
        assert loop._queue.qsize() <= 1
        loop.resume().result(PATIENCE)
        if mode == "lockstep":
            for _ in range(3):
                assert loop.put(np.ones(2))
            stepped = threading.Event()
            while not stepped.wait(0.01):
                if loop.ask(lambda: loop.time).result(PATIENCE) == 3_000_000:
                    stepped.set()


def test_a_wish_that_nobody_waits_for_is_not_done() -> None:
    with looped("fast") as loop:
        held, begun, done = threading.Event(), threading.Event(), []
        loop.ask(lambda: (begun.set(), held.wait(PATIENCE)))
        assert begun.wait(PATIENCE)
        late = loop.ask(lambda: done.append(1))
        assert late.cancel()
        held.set()
        loop.ask(lambda: None).result(PATIENCE)
        assert done == []


def test_it_ends_in_the_middle_of_a_control_period() -> None:
    """A pause comes at the end of the control period; an end does not wait for that."""
    with looped("fast", period=10**12) as loop:
        paused = loop.pause()
        loop.stop()
        assert not loop._thread.is_alive()
        assert paused.done()


def test_slow_rates_are_scheduled_at_once() -> None:
    slow = dict.fromkeys(("elastic_rate", "shape_rate", "clock_rate"), 1e-6)
    given = Settings(scene="robot.yaml", rate=0.1, **slow)  # type: ignore[arg-type]
    found = schedule(given, 1e-5)
    assert found.state * found.steps == 1_000_000
    assert found.clock * found.steps * 1e-5 == pytest.approx(1e6)
    assert found.steps * found.step >= 0.5e-3
    for rate in (0.0, 0.01, 2e5, float("nan"), float("inf")):
        with pytest.raises(SettingError, match=r"give 0\.1 to 100000 Hz"):
            schedule(Settings(scene="robot.yaml", rate=rate), 1e-3)


@pytest.mark.parametrize(("step", "ticks"), [(1e-3, 106), (0.02, 5)])
def test_what_is_looked_at_now_and_then_stops_it(step: float, ticks: int) -> None:
    """Bit by bit where ticks are short, at once where they are long; the report says why."""
    low = {"validity.mass_condition": {"warn": 1.0, "stop": 1.001}, "solver.step": step}
    with looped("fast", low) as loop:
        deadline = time.monotonic() + PATIENCE
        while loop.report.phase != "stopped" and time.monotonic() < deadline:
            time.sleep(0.01)
        report = loop.report
    assert report.phase == "stopped" and "condition of the mass matrix" in report.status
    assert report.ticks == ticks
    figures = {finding.name: finding.value for finding in report.validity}
    assert figures["mass_condition"] > 1.001
    assert 0.0 < report.step_p50 <= report.step_p99 <= report.step_worst <= report.tick_worst
