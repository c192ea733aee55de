"""Rows run once: what the table has is taken from it, the rest goes to an engine and into the table."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from ..terminal.progress import Progress
from .engine import Engine, Killed, WorkError
from .runs import Misasked, Task
from .table import Row, Table

Point = dict[str, Any]


class Campaign:
    """Runs points of a study.

    table : where rows are kept; engine : where they are run; tasks : what is run at points
    part : (k, n), k from 1: only every n-th run is this command's
    """

    def __init__(
        self,
        table: Table,
        engine: Engine,
        tasks: Callable[[list[Point]], list[Task]],
        part: tuple[int, int] = (1, 1),
    ) -> None:
        self._table, self._engine, self._tasks, self._part = table, engine, tasks, part
        self.ran = self.kept = self.failed = 0
        self._first: str | None = None

    def rows(self, points: Sequence[Point]) -> list[Row | None]:
        """Return a row for each point; None where it is another part's.

        Raises
        ------
        WorkError
            Where the study's first row does not have what is observed. In another part than the first, which
            does not run that row, such rows fail.
        """
        tasks = self._tasks(list(points))
        if tasks:
            self._first = self._first or tasks[0].key
        each: dict[str, Task] = {}
        for task in tasks:
            each.setdefault(task.key, task)
        k, n = self._part
        found: dict[str, Row] = {}
        missing: list[Task] = []
        for number, task in enumerate(each.values()):
            row = self._table.get(task.key)
            if row is not None:
                found[task.key] = row
            elif number % n == k - 1:
                missing.append(task)
        self.kept += len(found)
        for row in self._run(missing):
            found[row.key] = row
        return [found.get(task.key) for task in tasks]

    def _run(self, missing: list[Task]) -> list[Row]:
        # The first alone: it compiles what all need, and a study that can't be meant ends with it.
        rows: list[Row] = []
        progress, begun = Progress(), time.monotonic()
        try:
            for batch in (missing[:1], missing[1:]) if not self.ran else (missing,):
                if len(rows) == 1:
                    begun = time.monotonic()
                for number, outcome in self._engine.run(batch):
                    task = batch[number]
                    if isinstance(outcome, Misasked) and task.key == self._first and not self.kept:
                        raise WorkError(outcome.row.reason)
                    row = _row(task, outcome)
                    self._table.add(row)
                    rows.append(row)
                    self.ran += 1
                    self.failed += row.observed is None
                    progress.show(_so_far(len(rows), len(missing), self.failed, time.monotonic() - begun))
        finally:
            progress.clear()
        return rows


def _row(task: Task, outcome: Any) -> Row:
    """What is kept of an outcome."""
    if isinstance(outcome, Killed):
        return Row(task.key, task.inputs, None, outcome.reason)
    row: Row = outcome.row if isinstance(outcome, Misasked) else outcome
    return row


def _so_far(done: int, total: int, failed: int, seconds: float) -> str:
    left = (total - done) * seconds / max(1, done - 1)
    words = (
        f"{left:.0f} s"
        if left < 120.0
        else f"{left / 60.0:.0f} min"
        if left < 7200.0
        else f"{left / 3600.0:.1f} h"
    )
    told = f", about {words} left" if done > 1 else ""
    return f"{done} of {total} rows{f', {failed} failed' if failed else ''}{told}"
