"""However often workers and the sweep itself are killed, its table is the one that a plain loop makes."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import pytest
from flexsim.sweep.campaign import Campaign
from flexsim.sweep.engine import Processes, WorkError
from flexsim.sweep.runs import Misasked, Task
from flexsim.sweep.table import Row, Table
from sweep_work import Cheap, points, serial, tasks_at

PATIENCE = 120.0


@pytest.mark.parametrize("workers", [1, 2])
def test_the_table_does_not_depend_on_how_many_work(workers: int, tmp_path: Path) -> None:
    with Table(tmp_path / "t.sqlite") as table, Processes(Cheap(), workers) as engine:
        rows = Campaign(table, engine, tasks_at).rows(points(50))
        assert [row.inputs["x"] for row in rows if row] == list(range(50))
        assert table.rows() == serial(50)
        assert len(engine.pids) <= workers


def killed_workers(kills: int, tmp_path: Path, seed: int) -> None:
    """Kill a worker at a random time so often, and until one was at a row; let the rest be run; compare."""
    rng = random.Random(seed)
    count = killed = struck = 0
    with Table(tmp_path / "t.sqlite") as table, Processes(Cheap(0.002), 2) as engine:
        while killed < kills or engine.deaths < killed or not struck:
            tasks, over = tasks_at(points(count + 60)[count:]), set()
            count += 60
            for number, row in engine.run(tasks):
                assert row.key == tasks[number].key
                table.add(row)
                over.add(number)
                # A second blow to the same row would be the row's fault: not before it is over.
                more = killed < kills or not struck + len(engine.strikes)
                if more and engine.deaths == killed and over.issuperset(engine.strikes):
                    time.sleep(rng.random() * 0.004)
                    os.kill(rng.choice(engine.pids), signal.SIGKILL)
                    killed += 1
            struck += len(engine.strikes)
        assert engine.deaths == killed >= kills
        assert table.rows() == serial(count)


def test_killed_workers_lose_nothing(tmp_path: Path) -> None:
    killed_workers(3, tmp_path, 1)


@pytest.mark.nightly
def test_a_hundred_killed_workers_lose_nothing(tmp_path: Path) -> None:
    killed_workers(100, tmp_path, 2)


def test_a_deadly_row_fails_and_the_others_are_run(tmp_path: Path) -> None:
    """A row that ends two workers is a failure with its reason; its batch loses nothing else."""
    with Table(tmp_path / "t.sqlite") as table, Processes(Cheap(deadly=12.0), 2) as engine:
        rows = Campaign(table, engine, tasks_at).rows(points(30))
        assert engine.deaths == 2
    failed = rows[12]
    assert failed is not None and failed.observed is None
    assert failed.reason == "its worker ended with exit code -9 (SIGKILL), 2 times"
    assert [row for n, row in enumerate(rows) if n != 12] == [
        Cheap()(task) for n, task in enumerate(tasks_at(points(30))) if n != 12
    ]


def impossible(task: Task) -> None:
    raise ValueError("no run can have this")


def test_what_no_row_can_do_ends_the_sweep(tmp_path: Path) -> None:
    """A mistake of the study's is said at the first row, and nothing is kept."""
    with Table(tmp_path / "t.sqlite") as table, Processes(impossible, 2) as engine:
        with pytest.raises(WorkError, match=r"^no run can have this$"):
            Campaign(table, engine, tasks_at).rows(points(9))
        assert len(table) == 0


@dataclass(frozen=True)
class Lacking:
    """Rows whose scene lacks what is observed, from one on."""

    first: float

    def __call__(self, task: Task) -> Row | Misasked:
        row = Cheap()(task)
        return Misasked(Row(row.key, row.inputs, None, "no bow")) if task.inputs["x"] >= self.first else row


def test_what_the_first_row_lacks_is_the_study_s_mistake_and_later_a_failed_row(tmp_path: Path) -> None:
    with Table(tmp_path / "a.sqlite") as table, Processes(Lacking(0.0), 1) as engine:
        with pytest.raises(WorkError, match=r"^no bow$"):
            Campaign(table, engine, tasks_at).rows(points(3))
        assert len(table) == 0
    with Table(tmp_path / "b.sqlite") as table, Processes(Lacking(2.0), 1) as engine:
        rows = Campaign(table, engine, tasks_at).rows(points(4))
        assert [row.reason for row in rows if row] == ["", "", "no bow", "no bow"]
        assert len(table) == 4


def killed_parents(kills: int, tmp_path: Path, seed: int) -> None:
    """Kill the whole sweep at random times and begin again, until it has ended by itself."""
    rng = random.Random(seed)
    table, count = tmp_path / "t.sqlite", 200 * kills
    program = Path(__file__).with_name("sweep_work.py")
    words = [sys.executable, str(program), str(table), str(count), "0.01", "2"]
    before = -1
    for _ in range(kills):
        sweep = subprocess.Popen(words)
        waited = time.monotonic()
        # Killed as it works, whenever that begins on this machine.
        while rows_of(table) <= max(0, before):
            assert sweep.poll() is None and time.monotonic() - waited < PATIENCE
            time.sleep(0.01)
        time.sleep(rng.random() * 0.1)
        children = Path(f"/proc/{sweep.pid}/task/{sweep.pid}/children").read_text().split()
        sweep.kill()
        sweep.wait()
        gone(children)
        assert rows_of(table) >= before
        before = rows_of(table)
    assert 0 < before < count, "it was killed too late for this to be a test"
    subprocess.run(words, check=True, timeout=PATIENCE)
    with Table(table, write=False) as kept:
        assert kept.rows() == serial(count)


def rows_of(table: Path) -> int:
    """How many rows a reader sees meanwhile."""
    if not table.exists() or not table.stat().st_size:
        return 0
    try:
        with Table(table, write=False) as kept:
            return len(kept)
    except ValueError:  # it is just being made
        return 0


def gone(pids: list[str]) -> None:
    """Wait until workers whose parent has died are dead too."""
    begun = time.monotonic()
    while any(alive(pid) for pid in pids):
        assert time.monotonic() - begun < PATIENCE, "a worker outlives its sweep"
        time.sleep(0.01)


def alive(pid: str) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_workers_end_with_a_killed_sweep(tmp_path: Path) -> None:
    """Even in the midst of a row that would take ten minutes more."""
    begun = tmp_path / "begun"
    program = Path(__file__).with_name("sweep_work.py")
    words = [sys.executable, str(program), str(tmp_path / "t.sqlite"), "1", "600", "1", str(begun)]
    sweep = subprocess.Popen(words)
    waited = time.monotonic()
    while not begun.exists():
        assert sweep.poll() is None and time.monotonic() - waited < PATIENCE
        time.sleep(0.01)
    children = Path(f"/proc/{sweep.pid}/task/{sweep.pid}/children").read_text().split()
    assert children
    sweep.kill()
    sweep.wait()
    gone(children)


def test_a_killed_sweep_goes_on(tmp_path: Path) -> None:
    killed_parents(2, tmp_path, 1)


@pytest.mark.nightly
def test_a_sweep_killed_a_hundred_times_goes_on(tmp_path: Path) -> None:
    killed_parents(100, tmp_path, 2)
