"""Where rows are run: an interface, and processes on this machine.

A worker says that it begins a batch of rows, and tells each as soon as it is over. A worker that dies loses
the row it was at, which is run again by itself; a row that ends worker after worker fails for that reason.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from types import TracebackType
from typing import Any, Protocol

from ..terminal.child import PR_SET_PDEATHSIG, ending

Work = Callable[[Any], Any]
"""What runs a row: a task to an outcome, both of which can be pickled. What it raises ends the sweep."""
BATCH_SECONDS, LARGEST_BATCH = 0.5, 1000
"""A batch takes about so long; what an engine costs a batch is small beside it."""
OWN_DEATHS, OUTSIDE_DEATHS, IDLE_DEATHS = 3, 20, 10
"""Workers that a row may end: by itself, as by SIGSEGV; by signals from outside, which may hit by chance."""
OUTSIDE = (-signal.SIGKILL, -signal.SIGTERM)
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


@dataclass(frozen=True)
class Killed:
    """In place of an outcome: the row ended its workers, and how."""

    reason: str


class WorkError(RuntimeError):
    """What a worker could not do for any row."""


class Engine(Protocol):
    """Runs tasks and yields (its number among them, outcome or Killed) in any order."""

    def run(self, tasks: Sequence[Any]) -> Iterator[tuple[int, Any]]: ...

    def close(self) -> None: ...


@dataclass
class _Worker:
    process: Any
    connection: Connection
    waiting: deque[int] = field(default_factory=deque)
    begun: float | None = None


class Processes:
    """Processes on this machine, which live as long as the engine; `with` closes it.

    work : picklable, as are tasks and outcomes; workers : how many at most
    """

    def __init__(self, work: Work, workers: int) -> None:
        self._work, self._most = work, workers
        self._context = multiprocessing.get_context("spawn")
        self._workers: list[_Worker] = []
        self._seconds: float | None = None
        self.deaths = self._idle_deaths = 0
        self.strikes: dict[int, int] = {}
        """Of the tasks that are run: those that ended a worker, and how many."""

    def __enter__(self) -> Processes:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, what: BaseException | None, where: TracebackType | None
    ) -> None:
        self.close()

    @property
    def pids(self) -> list[int]:
        """The workers' process numbers."""
        return [worker.process.pid for worker in self._workers]

    def close(self) -> None:
        """End the workers; what they were at is lost."""
        for worker in self._workers:
            worker.process.kill()
        for worker in self._workers:
            worker.process.join()
            worker.connection.close()
        self._workers.clear()

    def run(self, tasks: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        """Run tasks and yield each outcome as soon as it is there.

        Raises
        ------
        WorkError
            What the work itself raised, or workers that don't start.
        """
        todo = deque(range(len(tasks)))
        strikes = self.strikes = {}
        self._idle_deaths = 0
        while todo or any(worker.waiting for worker in self._workers):
            self._hand_out(tasks, todo, strikes)
            watched: list[Any] = [w.connection for w in self._workers]
            for ready in wait(watched):
                worker = next(w for w in self._workers if w.connection is ready)
                told = _told(worker)
                if told is not None:
                    kind, what = told
                    if kind == "failed":
                        raise WorkError(what)
                    now, begun = time.monotonic(), worker.begun
                    worker.begun = now
                    if kind == "begun":
                        continue
                    self._pace(now - (begun or now))
                    self._idle_deaths = 0
                    yield worker.waiting.popleft(), what
                    continue
                code = self._bury(worker)
                if worker.begun is None or not worker.waiting:
                    self._died_idle(worker, todo, code)
                    continue
                at = worker.waiting.popleft()
                todo.extendleft(reversed(worker.waiting))
                strikes[at] = strikes.get(at, 0) + 1
                if strikes[at] >= (OUTSIDE_DEATHS if code in OUTSIDE else OWN_DEATHS):
                    yield at, Killed(f"its worker {ending(code)}, {strikes[at]} times")
                else:
                    todo.appendleft(at)

    def _died_idle(self, worker: _Worker, todo: deque[int], code: int) -> None:
        """Take back what a worker was given that died at no row, so that none is to blame."""
        todo.extendleft(reversed(worker.waiting))
        worker.waiting.clear()
        self._idle_deaths += 1
        if self._idle_deaths > IDLE_DEATHS + 2 * self._most:
            raise WorkError(f"workers end before they begin: the last {ending(code)}")

    def _pace(self, seconds: float) -> None:
        self._seconds = seconds if self._seconds is None else 0.8 * self._seconds + 0.2 * seconds

    def _hand_out(self, tasks: Sequence[Any], todo: deque[int], strikes: dict[int, int]) -> None:
        while todo:
            free = next((w for w in self._workers if not w.waiting), None)
            if free is None:
                if len(self._workers) >= self._most:
                    return
                free = self._begin()
            # Batches end small, so that the workers end together.
            share = max(1, len(todo) // (2 * self._most))
            size = 1 if not self._seconds else int(BATCH_SECONDS / self._seconds)
            size = max(1, min(size, share, LARGEST_BATCH))
            batch = [todo.popleft()]
            while todo and len(batch) < size and not (strikes.get(batch[0]) or strikes.get(todo[0])):
                batch.append(todo.popleft())
            free.waiting.extend(batch)
            free.begun = None
            try:
                free.connection.send([tasks[n] for n in batch])
            except OSError:
                self._died_idle(free, todo, self._bury(free))

    def _begin(self) -> _Worker:
        ours, its = self._context.Pipe()
        before = {name: os.environ.get(name) for name in THREADS}
        # One thread each: the cores are the workers', and sums don't depend on how many they are.
        os.environ.update(dict.fromkeys(THREADS, "1"))
        # Ctrl-C is for the whole terminal: a worker ignores it from its first instant, and ours waits. The
        # tracker first, whose own start would take the block away.
        resource_tracker.ensure_running()
        blocked = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        answer = signal.signal(signal.SIGINT, signal.SIG_IGN)
        try:
            process = self._context.Process(target=_serve, args=(its, self._work, os.getpid()), daemon=True)
            process.start()
        finally:
            signal.signal(signal.SIGINT, answer)
            signal.pthread_sigmask(signal.SIG_SETMASK, blocked)
            for name, value in before.items():
                if value is None:
                    del os.environ[name]
                else:
                    os.environ[name] = value
        its.close()
        worker = _Worker(process, ours)
        self._workers.append(worker)
        return worker

    def _bury(self, worker: _Worker) -> int:
        """Forget a worker that is dead; its exit code."""
        self.deaths += 1
        worker.process.join(5.0)
        if worker.process.is_alive():  # its pipe is broken, so it is of no use
            worker.process.kill()
            worker.process.join()
        worker.connection.close()
        self._workers.remove(worker)
        return int(worker.process.exitcode)


def _told(worker: _Worker) -> Any:
    """What a worker says; None where it has died, in the midst of a word perhaps."""
    try:
        return worker.connection.recv()
    except (EOFError, OSError):
        return None


def _serve(connection: Connection, work: Work, parent: int) -> None:
    """A worker's life: batches in, outcomes out, until the parent ends it or is gone."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
        if os.getppid() != parent:
            return
    try:
        while True:
            batch = connection.recv()
            connection.send(("begun", None))
            for task in batch:
                try:
                    outcome = work(task)
                except Exception as problem:
                    connection.send(("failed", f"{problem}" or type(problem).__name__))
                    return
                connection.send(("done", outcome))
    except (EOFError, OSError):
        return
