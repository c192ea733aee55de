"""Deadlines on the steady clock, and how well they are kept."""

from __future__ import annotations

import ctypes
import os
import time
from contextlib import suppress
from pathlib import Path

import numpy as np

SECOND = 1_000_000_000
# A missed deadline is made up for by ticks without a pause; beyond this the lost time stays lost,
# since a robot that races to catch up would be a surprise to its controller.
PATIENCE = SECOND // 10
# The end of a wait is watched rather than slept: a thread wakes up some tens of microseconds late.
# Short, because watching holds Python's global lock.
WATCH = 30_000
PR_SET_TIMERSLACK = 29
PRIORITY = 50  # of 1 to 99; what ros2_control's own loop takes


def sleep_finely() -> None:
    """Ask Linux to end this thread's sleeps on time: by default it may add 50 µs to save power."""
    with suppress(OSError, AttributeError):  # not Linux: sleeps end a little later
        ctypes.CDLL(None, use_errno=True).prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0)


def threads() -> list[int]:
    """The process's threads, as Linux numbers them; none elsewhere."""
    tasks = Path("/proc/self/task")
    return [int(task.name) for task in tasks.iterdir()] if tasks.is_dir() else []


def go_first(priority: int = PRIORITY, thread: int = 0) -> bool:
    """Ask Linux to run a thread (0: this one) before all ordinary ones; says whether it is allowed.

    Root may, and users with an rtprio limit, as ros2_control asks them to have.
    """
    try:
        os.sched_setscheduler(thread, os.SCHED_FIFO, os.sched_param(priority))
    except (OSError, AttributeError):
        return False
    return True


def stand_back() -> dict[int, int]:
    """Run the threads of this process as ordinary ones; which had real-time priorities, and which.

    A thread that never waits, and goes before all others, leaves none of them the processor.
    """
    before: dict[int, int] = {}
    for thread in threads():
        with suppress(OSError):  # it has just ended
            if os.sched_getscheduler(thread) == os.SCHED_FIFO:
                before[thread] = os.sched_getparam(thread).sched_priority
                os.sched_setscheduler(thread, os.SCHED_OTHER, os.sched_param(0))
    return before


def come_forward(before: dict[int, int]) -> None:
    """Give threads back what stand_back has taken from them."""
    for thread, priority in before.items():
        go_first(priority, thread)


class Histogram:
    """Counts of durations in bins of half a microsecond; the last holds all above 5 ms."""

    BIN = 500
    BINS = 10_000

    def __init__(self) -> None:
        self.counts = np.zeros(self.BINS, dtype=np.int64)
        self.worst = 0

    def add(self, duration: int) -> None:
        """Count one duration, ns."""
        self.counts[min(duration // self.BIN, self.BINS - 1)] += 1
        if duration > self.worst:
            self.worst = duration

    def quantile(self, fraction: float) -> float:
        """Seconds that this fraction of the durations does not exceed; 0 where there are none."""
        total = np.cumsum(self.counts)
        if total[-1] == 0:
            return 0.0
        at = int(np.searchsorted(total, fraction * total[-1]))
        if at >= self.BINS - 1:
            return self.worst / SECOND
        return min((at + 0.5) * self.BIN, self.worst) / SECOND


class Pace:
    """Deadlines on the steady clock, a period apart, that do not drift.

    Parameters
    ----------
    period : int, ns

    Attributes
    ----------
    overruns : deadlines at which the work of the one before had not ended
    longest_run : the most of them in a row, before the deadlines were kept again
    lost : ns by which the deadlines were put off because too many had been missed
    lateness : Histogram of how long after its deadline a wait ended
    """

    def __init__(self, period: int) -> None:
        self.period = period
        self.overruns = 0
        self.longest_run = 0
        self._run = 0
        self.lost = 0
        self.lateness = Histogram()
        self.deadline = time.monotonic_ns()

    def start(self) -> None:
        """Count periods from now."""
        self.deadline = time.monotonic_ns()

    def wait(self) -> None:
        """Wait until the next deadline; return at once if it has passed."""
        self.deadline += self.period
        now = time.monotonic_ns()
        if now > self.deadline:
            missed = 1
            behind = now - self.deadline
            if behind > PATIENCE:
                given_up = behind - behind % self.period
                self.deadline += given_up
                self.lost += given_up
                missed += given_up // self.period
            self.overruns += missed
            self._run += missed
            self.longest_run = max(self.longest_run, self._run)
        else:
            self._run = 0
            if self.deadline - now > WATCH:
                time.sleep((self.deadline - now - WATCH) / SECOND)
            while (now := time.monotonic_ns()) < self.deadline:
                pass
        self.lateness.add(max(0, now - self.deadline))
