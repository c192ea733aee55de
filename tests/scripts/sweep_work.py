"""Rows of a cheap function for the tests of sweeps, run by processes as scenes are; a program to be killed.

python sweep_work.py TABLE COUNT SECONDS WORKERS [BEGUN]    runs a campaign to its end
"""

from __future__ import annotations

import math
import os
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flexsim.sweep.campaign import Campaign
from flexsim.sweep.engine import Processes
from flexsim.sweep.runs import Task
from flexsim.sweep.table import Row, Table, key_of


@dataclass(frozen=True)
class Cheap:
    """A row that takes some time; the one at `deadly` ends its worker by `by`; `begun` is a file it makes."""

    seconds: float = 0.0
    deadly: float | None = None
    by: int = signal.SIGKILL
    begun: str = ""

    def __call__(self, task: Task) -> Row:
        x = task.inputs["x"]
        if x == self.deadly:
            os.kill(os.getpid(), self.by)
        if self.begun:
            Path(self.begun).touch()
        time.sleep(self.seconds)
        if x % 7 == 3:
            return Row(task.key, task.inputs, None, f"no value at {x}")
        return Row(task.key, task.inputs, {"y": math.sin(x) / 3.0})


@dataclass(frozen=True)
class Here:
    """An engine without processes; `with` opens nothing."""

    work: Callable[[Task], Any]

    def __enter__(self) -> Here:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def run(self, tasks: Sequence[Task]) -> Iterator[tuple[int, Any]]:
        yield from enumerate(map(self.work, tasks))

    def close(self) -> None:
        """Nothing is open."""


def tasks_at(points: list[dict]) -> list[Task]:
    return [Task(key_of(point), point, point) for point in points]


def points(count: int) -> list[dict]:
    return [{"x": float(n)} for n in range(count)]


def serial(count: int) -> list[Row]:
    """The table as one loop makes it."""
    return sorted((Cheap()(task) for task in tasks_at(points(count))), key=lambda row: row.key)


def run_all(table: Path, count: int, seconds: float, workers: int, begun: str = "") -> None:
    with Table(table) as kept, Processes(Cheap(seconds, begun=begun), workers) as engine:
        Campaign(kept, engine, tasks_at).rows(points(count))


if __name__ == "__main__":
    run_all(Path(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4]), *sys.argv[5:])
