"""Every row of the pages' tables of states and codes, asked of a running node, in their order."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from door_process import SCENE as DOOR
from door_process import SMALL, Door
from listening import PATIENCE, Listener, node_words, running
from robot_process import SCENE as ROBOT
from robot_process import Robot
from simulation_interfaces.msg import SimulationState
from simulator import Client

pytestmark = pytest.mark.ros
PAGES = Path(__file__).parents[2] / "docs"
STATES = {"stopped": 0, "playing": 1, "paused": 2, "quitting": 3}
# A robot whose solver soon stops: a step that its method can't take. A test that soon ends.
TROUBLES: dict[str, dict[str, Any]] = {
    "": {},
    "solver stopped": {"override__solver__method": "runge_kutta_4", "override__solver__step": 1e-3},
    "test ended": {"duration": 2.0, "time_scale": 0.0},
    "waiting for the furnace": {"wait_for_furnace": True},
}
PHASES = {"solver stopped": "stopped", "test ended": "ended", "waiting for the furnace": "waiting"}


def rows(page: str) -> list[tuple[str, str, str, str]]:
    """Return the table of a page: state, what is asked for, code, state then."""
    text = (PAGES / page).read_text()
    table = text.split("### States and codes")[1].split("\n## ")[0]
    found = re.findall(r"^\| ([a-z ,]+) \| ([\w ]+) \| (\d+) \| ([^|]+) \|$", table, re.MULTILINE)
    assert len(found) > 20, "the table is gone"
    return [(a, b, c, d) for a, b, c, d in found]


def blocks(page: str) -> list[tuple[str, list[tuple[str, str, str, str]]]]:
    """Return the rows in runs of one node each, with the trouble that the node is to have."""
    found: list[tuple[str, list[tuple[str, str, str, str]]]] = []
    for row in rows(page):
        trouble = row[0].partition(", ")[2]
        goes_on = bool(found) and (
            trouble == found[-1][0] or (not trouble and row[1] == "PLAYING" and found[-1][0])
        )
        if not goes_on:
            found.append((trouble, []))
        found[-1][1].append(row)
    return found


@contextmanager
def node(page: str, trouble: str, folder: Path) -> Iterator[Listener]:
    """Run the page's node, with or without a trouble."""
    if page == "node.md":
        words = node_words("flexsim_node.node", ROBOT, **TROUBLES[trouble])
        with running(Robot, words, folder) as robot:
            robot.process.wait_for("kernels ready", PATIENCE)
            yield robot
    else:
        given = SMALL | {"override__solver__model": "column", "override__deformation__model": "none"}
        words = node_words("thermal_node.node", DOOR, **(given | TROUBLES[trouble]))
        with running(Door, words, folder) as door:
            door.process.wait_for("kernels ready", PATIENCE)
            yield door


def ask(client: Client, what: str) -> int:
    """Ask for what a row says; the code of the answer."""
    verb, _, number = what.partition(" ")
    if verb == "step":
        return int(client.call("StepSimulation", steps=2).result.result)
    if verb == "reset":
        return int(client.call("ResetSimulation", scope=int(number)).result.result)
    state = int(verb) if verb.isdigit() else getattr(SimulationState, f"STATE_{verb}")
    return client.set_state(state)


@pytest.mark.parametrize(
    ("page", "block"), [(p, n) for p in ("node.md", "thermal_node.md") for n in range(len(blocks(p)))]
)
def test_every_row(page: str, block: int, tmp_path: Path) -> None:
    """The code is the table's, and so is the state then."""
    trouble, table = blocks(page)[block]
    with node(page, trouble, tmp_path) as found:
        client = Client(found, page.removesuffix(".md").replace("node", "flexsim_node")
                        if page == "node.md" else "thermal_node")  # fmt: skip
        if trouble:
            found.until(lambda: found.diagnostics().get("phase") == PHASES[trouble], PATIENCE)
        for before, asked, code, after in table:
            wanted = STATES[before.partition(",")[0]]
            if client.state() != wanted:
                assert client.set_state(wanted) == 1
            assert ask(client, asked) == int(code), (before, asked)
            then = after.partition(":")[0]
            if then == "quitting":
                assert found.process.process.wait(60) == 0
                return
            assert client.state() == STATES[then], (before, asked)
