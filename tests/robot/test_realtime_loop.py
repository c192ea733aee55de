"""The stepping thread by itself: what lock-step shows first."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from flexsim_node import load_scene
from flexsim_node.motion.simulation import Simulation
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
