"""Every input tried with a hundred nonsensical ones; `benchmarks/fuzz.py` tries ten thousand each."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import ros_environment

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
from fuzz import SERVICES, fuzz_door, fuzz_robot, fuzz_wire

pytestmark = pytest.mark.ros
COUNT = 100


@pytest.fixture(autouse=True)
def domain() -> Iterator[None]:
    """Hand the nodes of this process a ROS domain of their own."""
    before = os.environ["ROS_DOMAIN_ID"]
    os.environ["ROS_DOMAIN_ID"] = ros_environment()["ROS_DOMAIN_ID"]
    yield
    os.environ["ROS_DOMAIN_ID"] = before


def test_the_robot() -> None:
    """Commands both ways, loads, parameters, services, goals; every state published is finite."""
    figures = fuzz_robot(COUNT)
    assert len(figures) == 3 + 1 + len(SERVICES) + 1
    # goals come in bursts of up to eight
    assert all(COUNT <= figure["inputs"] < COUNT + 8 for figure in figures.values())


def test_the_door() -> None:
    """Measured temperatures, parameters, services, goals."""
    assert len(fuzz_door(COUNT)) == 1 + 1 + len(SERVICES) + 1


def test_over_the_wire() -> None:
    """Nonsense, bytes that are no message, a flood from a second commander: the node goes on."""
    figures = fuzz_wire(10 * COUNT)
    assert sum(figure["inputs"] for figure in figures.values()) > 60 * COUNT
