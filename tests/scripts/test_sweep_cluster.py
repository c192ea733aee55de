"""Rows of a sweep run by the workers of a Dask scheduler: the table is that of a plain loop."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import distributed
import pytest
from flexsim.sweep import cluster
from flexsim.sweep.campaign import Campaign
from flexsim.sweep.cluster import Cluster
from flexsim.sweep.engine import Processes, WorkError
from flexsim.sweep.table import Table
from sweep_work import Cheap, points, serial, tasks_at


@dataclass(frozen=True)
class Same:
    """Programs that are the same everywhere."""

    def __call__(self) -> dict[str, str]:
        return {"numpy": "2"}


@dataclass(frozen=True)
class Other:
    """Programs that differ from process to process."""

    def __call__(self) -> dict[str, str]:
        return {"numpy": "2", "sources": str(os.getpid())}


@pytest.fixture(scope="module")
def local() -> Iterator[Any]:
    """Two workers, processes of their own; what ends a worker once is handed back at once."""
    import dask

    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0}),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=50
        ) as made,
    ):
        yield made


@pytest.mark.slow
def test_the_table_is_that_of_a_plain_loop_though_workers_are_killed(local: Any, tmp_path: Path) -> None:
    """A worker is killed in the midst of its rows; none is lost, none twice."""
    with (
        Table(tmp_path / "t.sqlite") as table,
        Cluster(Cheap(0.01), local.scheduler_address, Same()) as engine,
    ):
        pids = [worker.pid for worker in local.workers.values()]
        add, added = table.add, []

        def adding(row: Any) -> None:
            add(row)
            added.append(row)
            if len(added) in (20, 120):
                os.kill(pids[len(added) // 100], signal.SIGKILL)

        table.add = adding  # type: ignore[method-assign]
        rows = Campaign(table, engine, tasks_at).rows(points(300))
        assert [row.inputs["x"] for row in rows if row] == list(range(300))
        assert table.rows() == serial(300)


def test_a_deadly_row_fails_and_the_others_are_run(
    local: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "AGAIN", 1)
    work = Cheap(deadly=12.0)
    with Table(tmp_path / "t.sqlite") as table, Cluster(work, local.scheduler_address, Same()) as engine:
        rows = Campaign(table, engine, tasks_at).rows(points(20))
    failed = rows[12]
    assert failed is not None and failed.reason == "it ended its workers on the cluster again and again"
    assert [row for n, row in enumerate(rows) if n != 12] == [
        Cheap()(task) for n, task in enumerate(tasks_at(points(20))) if n != 12
    ]


def test_workers_with_other_programs_are_refused(local: Any) -> None:
    """Their rows would be kept as those of the programs here."""
    with (
        Cluster(Cheap(), local.scheduler_address, Other()) as engine,
        pytest.raises(WorkError, match=r"^a worker has other programs than this machine: sources"),
    ):
        list(engine.run(tasks_at(points(3))))


def test_where_nobody_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "CONNECT", 0.2)
    for address in ("tcp://127.0.0.1:9", "nowhere"):
        with pytest.raises(WorkError, match=f"^no Dask scheduler answers at {address}"):
            Cluster(Cheap(), address, Same())


@pytest.mark.slow
def test_a_scheduler_that_vanishes_ends_the_sweep_which_goes_on_elsewhere(tmp_path: Path) -> None:
    import dask

    path = tmp_path / "t.sqlite"
    with (
        dask.config.set({"distributed.comm.timeouts.connect": "1s"}),
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, dashboard_address="127.0.0.1:0", silence_logs=50
        ) as made,
        Table(path) as table,
        Cluster(Cheap(0.01), made.scheduler_address, Same()) as engine,
    ):
        add = table.add

        def adding(row: Any) -> None:
            add(row)
            if len(table) == 30:
                threading.Thread(target=made.close).start()

        table.add = adding  # type: ignore[method-assign]
        with pytest.raises(WorkError, match=r"is gone; start it, and the same command goes on$"):
            Campaign(table, engine, tasks_at).rows(points(600))
    with Table(path) as table, Processes(Cheap(), 1) as here:
        assert 30 <= len(table) < 600
        Campaign(table, here, tasks_at).rows(points(600))
        assert table.rows() == serial(600)
