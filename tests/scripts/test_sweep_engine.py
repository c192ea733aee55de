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
from typing import Any

import pytest
from flexsim.sweep import engine
from flexsim.sweep.campaign import Campaign
from flexsim.sweep.engine import Processes, WorkError
from flexsim.sweep.runs import Misasked, Task
from flexsim.sweep.table import Row, Table
from sweep_work import Cheap, Here, points, serial, tasks_at

PATIENCE = 120.0


@pytest.mark.parametrize("workers", [1, 2])
def test_the_table_does_not_depend_on_how_many_work(workers: int, tmp_path: Path) -> None:
    with Table(tmp_path / "t.sqlite") as table, Processes(Cheap(), workers) as processes:
        rows = Campaign(table, processes, tasks_at).rows(points(50))
        assert [row.inputs["x"] for row in rows if row] == list(range(50))
        assert table.rows() == serial(50)
        assert len(processes.pids) <= workers


@pytest.mark.parametrize(("by", "deaths"), [(signal.SIGSEGV, 1), (signal.SIGKILL, 2)])
def test_a_deadly_row_fails_and_the_others_are_run(
    by: int, deaths: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A row that ends worker after worker fails with its reason; its batch loses nothing else."""
    assert 1 < engine.OWN_DEATHS < engine.OUTSIDE_DEATHS
    monkeypatch.setattr(engine, "OWN_DEATHS", 1)
    monkeypatch.setattr(engine, "OUTSIDE_DEATHS", 2)
    with Table(tmp_path / "t.sqlite") as table, Processes(Cheap(deadly=12.0, by=by), 2) as processes:
        rows = Campaign(table, processes, tasks_at).rows(points(30))
        assert processes.deaths == deaths
    failed = rows[12]
    assert failed is not None and failed.observed is None
    name = signal.Signals(by).name
    assert failed.reason == f"its worker ended with exit code -{int(by)} ({name}), {deaths} times"
    assert [row for n, row in enumerate(rows) if n != 12] == [
        Cheap()(task) for n, task in enumerate(tasks_at(points(30))) if n != 12
    ]


class Stillborn:
    """Work with which no worker begins."""

    def __call__(self, task: Any) -> None:
        raise AssertionError("no worker gets so far")

    def __reduce__(self) -> Any:
        return os._exit, (3,)


def interrupted() -> Cheap:
    os.kill(os.getpid(), signal.SIGINT)
    return Cheap()


class InterruptedAtFirst:
    """Work whose worker gets SIGINT as it begins, as every process of a terminal does."""

    def __call__(self, task: Any) -> None:
        raise AssertionError("no worker gets so far")

    def __reduce__(self) -> Any:
        return interrupted, ()


def test_ctrl_c_is_the_sweep_s_alone() -> None:
    """A worker neither ends by it nor says anything."""
    with Processes(InterruptedAtFirst(), 1) as processes:
        assert [row for _, row in processes.run(tasks_at(points(1)))] == [Cheap()(tasks_at(points(1))[0])]
        assert processes.deaths == 0


@pytest.mark.parametrize("size", [1, 10_000_000])
def test_workers_that_never_begin_end_the_sweep(size: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whether they die before they take a row, or while it is handed to them: a pipe holds less."""
    monkeypatch.setattr(engine, "IDLE_DEATHS", -1)
    with Processes(Stillborn(), 1) as processes:
        with pytest.raises(WorkError, match=r"^workers end before they begin: the last .* exit code 3$"):
            list(processes.run(["x" * size]))
        assert processes.deaths == 2


def impossible(task: Task) -> None:
    raise ValueError("no run can have this")


def test_what_no_row_can_do_ends_the_sweep(tmp_path: Path) -> None:
    """A mistake of the study's is said at the first row, and nothing is kept."""
    with Table(tmp_path / "t.sqlite") as table, Processes(impossible, 2) as processes:
        with pytest.raises(WorkError, match=r"^no run can have this$"):
            Campaign(table, processes, tasks_at).rows(points(9))
        assert len(table) == 0


@dataclass(frozen=True)
class Lacking:
    """Rows whose scene lacks what is observed, from one on."""

    first: float

    def __call__(self, task: Task) -> Row | Misasked:
        row = Cheap()(task)
        return Misasked(Row(row.key, row.inputs, None, "no bow")) if task.inputs["x"] >= self.first else row


def test_what_the_first_row_lacks_is_the_study_s_mistake_and_later_a_failed_row(tmp_path: Path) -> None:
    with Table(tmp_path / "a.sqlite") as table:
        with pytest.raises(WorkError, match=r"^no bow$"):
            Campaign(table, Here(Lacking(0.0)), tasks_at).rows(points(3))
        assert len(table) == 0
    with Table(tmp_path / "b.sqlite") as table:
        rows = Campaign(table, Here(Lacking(2.0)), tasks_at).rows(points(4))
        assert [row.reason for row in rows if row] == ["", "", "no bow", "no bow"]
        assert len(table) == 4


def test_parts_come_to_the_table_of_the_whole(tmp_path: Path) -> None:
    """Also where the first row of a part lacks what is observed, which the first of all has."""
    for name, parts in (("whole", [(1, 1)]), ("parts", [(2, 2), (1, 2)])):
        with Table(tmp_path / f"{name}.sqlite") as table:
            for part in parts:
                Campaign(table, Here(Lacking(1.0)), tasks_at, part).rows(points(4))
    with Table(tmp_path / "whole.sqlite", False) as one, Table(tmp_path / "parts.sqlite", False) as two:
        assert one.rows() == two.rows()
        assert sorted(row.reason for row in one.rows()) == ["", "no bow", "no bow", "no bow"]


def killed_at_random(kills: int, tmp_path: Path, seed: int) -> None:
    """Kill a worker or the whole sweep at random times so often, begin again, compare with a plain loop."""
    rng = random.Random(seed)
    table, count = tmp_path / "t.sqlite", 100 * kills
    program = Path(__file__).with_name("sweep_work.py")
    words = [sys.executable, str(program), str(table), str(count), "0.01", "2"]
    sweep = subprocess.Popen(words)
    before = 0
    for _ in range(kills):
        # Now and then before it has done anything; else as it works, whenever that is on this machine.
        least = before + rng.choice([0, 1, 1, 5, 20])
        waited = time.monotonic()
        while rows_of(table) < least or not workers_of(sweep.pid):
            assert sweep.poll() is None, "it has ended before all the kills"
            assert time.monotonic() - waited < PATIENCE
            time.sleep(0.005)
        time.sleep(rng.random() * 0.1)
        workers = workers_of(sweep.pid)
        if rng.random() < 0.4:
            sweep.kill()
            sweep.wait()
            gone(workers)
            sweep = subprocess.Popen(words)
        elif workers:  # one that has just been killed may not be buried yet
            os.kill(int(rng.choice(workers)), signal.SIGKILL)
        now = rows_of(table)
        assert now >= before
        before = now
    assert before < count, "it was killed too late for this to be a test"
    assert sweep.wait(PATIENCE) == 0
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


def workers_of(pid: int) -> list[str]:
    """A sweep's workers, without what multiprocessing begins beside them."""
    try:
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
        return [c for c in children if b"spawn_main" in Path(f"/proc/{c}/cmdline").read_bytes()]
    except OSError:  # one has just ended
        return []


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
    children = workers_of(sweep.pid)
    assert children
    sweep.kill()
    sweep.wait()
    gone(children)


def test_a_sweep_killed_at_random_comes_to_the_table_of_a_plain_loop(tmp_path: Path) -> None:
    killed_at_random(3, tmp_path, 3)


@pytest.mark.nightly
def test_a_sweep_killed_a_hundred_times_comes_to_the_table_of_a_plain_loop(tmp_path: Path) -> None:
    killed_at_random(100, tmp_path, 2)
