"""The stepping thread by itself: what lock-step shows first, and who goes first."""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np

from flexsim_node import load_scene
from flexsim_node.motion.simulation import Simulation
from flexsim_node.service.pace import threads
from flexsim_node.service.realtime import Loop, Output

SCENE = Path(__file__).parents[2] / "config" / "simple_pendulum.yaml"


def test_early_commands_do_not_hide_the_first_state() -> None:
    """Commands that came before anybody was there: state 0 is shown once, and before they are taken."""
    robot = Simulation(load_scene(SCENE))
    robot.warm()
    shown: list[int] = []
    loop = Loop(robot, 1, "lockstep", [Output(1, shown.append)])
    for _ in range(3):
        loop.put(np.zeros(1))
    loop.start()
    try:
        while len(shown) < 4:
            assert not loop.ended.is_set()
            time.sleep(0.001)
    finally:
        loop.stop()
    assert shown == [0, 1_000_000, 2_000_000, 3_000_000]


def real_time_threads() -> int:
    """How many threads of this process go before ordinary ones."""
    return sum(os.sched_getscheduler(thread) == os.SCHED_FIFO for thread in threads())


def test_steps_that_are_not_paced_leave_others_the_processor() -> None:
    """Steps on request never wait: were they of real-time priority, who wants to end them would not run."""
    robot = Simulation(load_scene(SCENE))
    robot.warm()
    loop = Loop(robot, 1, "realtime", [])
    loop.start()
    try:
        loop.pause().result(timeout=60.0)
        paced = real_time_threads()  # one, where that is allowed
        seen: list[int] = []

        def ten(done: int) -> bool:
            seen.append(real_time_threads())
            return done < 10

        assert loop.step(2**63, ten).result(timeout=60.0) == 10
        assert seen == [0] * 10
        while real_time_threads() != paced:
            assert not loop.ended.is_set()
            time.sleep(0.001)
    finally:
        loop.stop()
