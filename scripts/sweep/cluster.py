"""Rows run by the workers of a Dask scheduler, on this machine or on many.

Each worker holds its versions and sources against the sweep's: a row of other programs would be kept under a
key that is not its own.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from types import TracebackType
from typing import Any

from .engine import BATCH_SECONDS, LARGEST_BATCH, Killed, Work, WorkError

Programs = Callable[[], Mapping[str, str]]
CONNECT, AGAIN = 10.0, 5
"""s within which a scheduler answers; how often a row is run alone that Dask has given up twice."""
_alone = threading.Lock()
"""A worker may have several threads; rows are run one at a time in a process."""


@dataclass(frozen=True)
class Batch:
    """What a worker runs; programs : tells versions; expected : what they are where the sweep is."""

    work: Work
    programs: Programs
    expected: Mapping[str, str]

    def __call__(self, tasks: Sequence[Any]) -> tuple[list[Any], float]:
        """Return outcomes, and s a row."""
        here = _once(self.programs)
        other = [name for name in self.expected if here.get(name) != self.expected[name]]
        if other:
            told = ", ".join(f"{name} {here.get(name)} for {self.expected[name]}" for name in other)
            raise WorkError(f"a worker has other programs than this machine: {told}; install the same there")
        with _alone:
            begun = time.monotonic()
            outcomes = [self.work(task) for task in tasks]
            return outcomes, (time.monotonic() - begun) / len(tasks)


@lru_cache(maxsize=8)
def _once(programs: Programs) -> Mapping[str, str]:
    return programs()


class Cluster:
    """Workers of the scheduler at an address, such as tcp://host:8786; `with` closes the connection.

    programs : picklable and hashable; what rows depend on, as the machine has it that it is called on

    Raises
    ------
    WorkError
        Where no scheduler answers, it has no workers, or Dask is not installed.
    """

    def __init__(self, work: Work, address: str, programs: Programs) -> None:
        try:
            from distributed import Client
        except ImportError:
            raise WorkError("--cluster needs Dask: pip install 'flexsim[cluster]'") from None
        self.address = address
        self._batch = Batch(work, programs, programs())
        self._seconds: float | None = None
        # What we say of its troubles is a sentence; its own would be pages.
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        try:
            self._client: Any = Client(address, timeout=CONNECT, set_as_default=False)
        except (OSError, ValueError) as problem:
            raise WorkError(
                f"no Dask scheduler answers at {address} ({problem}); start one, or give its address"
            ) from None
        if not self._client.nthreads():
            self.close()
            raise WorkError(f"the scheduler at {address} has no workers; start some: dask worker {address}")

    def __enter__(self) -> Cluster:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, what: BaseException | None, where: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Leave the scheduler; what its workers were at is lost."""
        self._client.close(timeout=CONNECT)

    def run(self, tasks: Sequence[Any]) -> Iterator[tuple[int, Any]]:
        """Run tasks and yield each outcome when its batch is over.

        Raises
        ------
        WorkError
            What the work itself raised, or a scheduler that is gone.
        """
        from distributed import as_completed
        from distributed.scheduler import KilledWorker

        todo = deque(range(len(tasks)))
        again: deque[int] = deque()
        suspects: deque[int] = deque()
        hits: dict[int, int] = {}
        waiting: dict[Any, list[int]] = {}
        done = as_completed(loop=self._client.loop)
        most = 2 * max(1, sum(self._client.nthreads().values()))

        def hand_out(numbers: list[int]) -> None:
            future = self._client.submit(self._batch, [tasks[n] for n in numbers], pure=False)
            waiting[future] = numbers
            done.add(future)

        while todo or again or suspects or waiting:
            while (todo or again) and len(waiting) < most and not suspects:
                hand_out([again.popleft()] if again else self._next(todo, most))
            if suspects and not waiting:
                hand_out([suspects.popleft()])
            future = next(done)
            numbers = waiting.pop(future)
            try:
                outcomes, self._seconds = future.result()
            except KilledWorker:
                # Dask blames all that its worker was to run, so a row is tried by itself, and at last alone.
                for n in numbers:
                    hits[n] = hits.get(n, 0) + 1
                    if hits[n] < 2:
                        again.append(n)
                    elif hits[n] < 2 + AGAIN:
                        suspects.append(n)
                    else:
                        yield n, Killed("it ended its workers on the cluster again and again")
                continue
            except Exception as problem:
                if self._client.status != "running" or future.cancelled():
                    raise WorkError(
                        f"the scheduler at {self.address} is gone; start it, and the same command goes on"
                    ) from None
                raise WorkError(f"{problem}" or type(problem).__name__) from None
            yield from zip(numbers, outcomes, strict=True)

    def _next(self, todo: deque[int], most: int) -> list[int]:
        share = max(1, len(todo) // most)
        size = 1 if not self._seconds else int(BATCH_SECONDS / self._seconds)
        size = max(1, min(size, share, LARGEST_BATCH))
        return [todo.popleft() for _ in range(size)]
