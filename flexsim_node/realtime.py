"""The stepping thread: a robot at the pace of the steady clock, of its commands, or at full speed.

Nothing here knows of ROS.  Commands come in from another thread by `Loop.put`; states go out by
calling `Output.publish` from the stepping thread, right after the step that made them.
"""

from __future__ import annotations

import ctypes
import os
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from queue import Empty, SimpleQueue

import numpy as np

from .acceleration import OK
from .simulation import Simulation

SECOND = 1_000_000_000
MODES = ("realtime", "lockstep", "fast")
# A missed deadline is made up for by ticks without a pause; beyond this the lost time stays lost,
# since a robot that races to catch up would be a surprise to its controller.
PATIENCE = SECOND // 10
# The end of a wait is watched rather than slept: a thread wakes up some tens of microseconds late.
# Short, because watching holds Python's global lock.
WATCH = 30_000
# How often a state is repeated while time stands still.
REPEAT_PERIOD = 0.1
REPORT_PERIOD = SECOND
PR_SET_TIMERSLACK = 29
PRIORITY = 50  # of 1 to 99; what ros2_control's own loop takes


def sleep_finely() -> None:
    """Ask Linux to end this thread's sleeps on time: by default it may add 50 µs to save power."""
    with suppress(OSError, AttributeError):  # not Linux: sleeps end a little later
        ctypes.CDLL(None, use_errno=True).prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0)


def go_first() -> bool:
    """Ask Linux to run this thread before all ordinary ones; says whether it is allowed.

    Root may, and users with an rtprio limit, as ros2_control asks them to have.
    """
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(PRIORITY))
    except (OSError, AttributeError):
        return False
    return True


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
    lost : ns by which the deadlines were put off because too many had been missed
    lateness : Histogram of how long after its deadline a wait ended
    """

    def __init__(self, period: int) -> None:
        self.period = period
        self.overruns = 0
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
            self.overruns += 1
            behind = now - self.deadline
            if behind > PATIENCE:
                missed = behind - behind % self.period
                self.deadline += missed
                self.lost += missed
                self.overruns += missed // self.period
        else:
            if self.deadline - now > WATCH:
                time.sleep((self.deadline - now - WATCH) / SECOND)
            while (now := time.monotonic_ns()) < self.deadline:
                pass
        self.lateness.add(max(0, now - self.deadline))


@dataclass(frozen=True)
class Output:
    """What is published every so many ticks; `publish` gets the time of the state, ns."""

    every: int
    publish: Callable[[int], None]


@dataclass(frozen=True)
class Report:
    """How a loop does; times in s, counts since it started.

    Attributes
    ----------
    phase : "waiting" for the first command, "running", or "stopped"
    status : "ok", or why the solver stopped
    time : simulated
    real_time_factor, recent_factor : simulated over elapsed time, and that of the last second
    step_p50, step_p99, step_worst : one step of the solver
    tick_p99, tick_worst : all work between two deadlines, publishing included
    late_p99, late_worst : from a deadline to the beginning of its work
    energy : kinetic, elastic, gravitational, J
    conditioning : of closed loops, the least since the last report; None without loops
    warning : what a user should know of a robot that still runs
    """

    phase: str = "waiting"
    status: str = "ok"
    time: float = 0.0
    real_time_factor: float = 0.0
    recent_factor: float = 0.0
    ticks: int = 0
    overruns: int = 0
    recent_overruns: int = 0
    lost: float = 0.0
    step_p50: float = 0.0
    step_p99: float = 0.0
    step_worst: float = 0.0
    tick_p99: float = 0.0
    tick_worst: float = 0.0
    late_p99: float = 0.0
    late_worst: float = 0.0
    timeouts: int = 0
    real_time_priority: bool = False
    energy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    conditioning: float | None = None
    warning: str = ""


class Loop:
    """Steps a robot in a thread of its own.

    Parameters
    ----------
    robot : Simulation
        From `start` on it belongs to the stepping thread.
    steps : int
        Steps of a tick: commands are taken up, and deadlines kept, once a tick.
    mode : str
        realtime: a tick whenever its time has come.  fast: ticks without a pause.  lockstep: a tick
        for each command.
    outputs : sequence of Output
        Called in this order.
    command_timeout : float, s
        Without a command for so long the torque becomes zero; 0 for never.
    wait_for_command : bool
        Time stands still until the first command.  Always so in lockstep.
    """

    def __init__(
        self,
        robot: Simulation,
        steps: int,
        mode: str,
        outputs: Sequence[Output],
        *,
        command_timeout: float = 0.0,
        wait_for_command: bool = False,
    ) -> None:
        self.robot = robot
        self.steps = steps
        self.mode = mode
        self.outputs = list(outputs)
        self.report = Report()
        self.failure: Exception | None = None
        self.ended = threading.Event()
        self.pace = Pace(round(steps * robot.step_size * SECOND))
        self._timeout = round(command_timeout * SECOND)
        self._wait = wait_for_command or mode == "lockstep"
        self._zero = np.zeros(robot.model.joints)
        # The mailbox: one reference, so that it is swapped in one go; the latest command wins.
        self._latest: tuple[np.ndarray, int] = (self._zero, 0)
        self._arrived = threading.Event()
        self._queue: SimpleQueue[np.ndarray] = SimpleQueue()  # lockstep forgets no command
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="stepping", daemon=True)
        self._taken = 0
        self._ticks = 0
        self._timeouts = 0
        self._timed_out = False
        self._step_time, self._tick_time = Histogram(), Histogram()
        self._begun = 0
        self._first = False
        self._window = (0, 0, 0)
        self._next_report = 0

    @property
    def time(self) -> int:
        """Simulated time, ns; counted in whole steps, so that it does not drift."""
        return round(self._taken * self.robot.step_size * SECOND)

    def start(self) -> None:
        """Begin to step."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread after the tick it is in."""
        self._stop.set()
        self._arrived.set()
        if self._thread.is_alive():
            self._thread.join()

    def put(self, torque: np.ndarray) -> None:
        """Hand over a checked command (m,), N m; it holds until the next one."""
        self._latest = (torque, time.monotonic_ns())
        if self.mode == "lockstep":
            self._queue.put(torque)
        self._arrived.set()

    def _run(self) -> None:
        try:
            sleep_finely()
            self._first = self.mode == "realtime" and go_first()
            self._publish()
            if self._wait:
                self._repeat(until=self._arrived)
            self._begun = time.monotonic_ns()
            self._window = (self._begun, 0, 0)
            {"realtime": self._paced, "fast": self._fast, "lockstep": self._locked}[self.mode]()
            if self.robot.status != OK:
                self._repeat(until=self._stop)
            self._take_report(time.monotonic_ns())
        except Exception as problem:
            self.failure = problem
        finally:
            self.ended.set()

    def _going(self) -> bool:
        return not self._stop.is_set() and self.robot.status == OK

    def _paced(self) -> None:
        self.pace.start()
        while self._going():
            self.pace.wait()
            self._tick(self._command())

    def _fast(self) -> None:
        while self._going():
            self._tick(self._command())

    def _locked(self) -> None:
        while self._going():
            try:
                torque = self._queue.get(timeout=REPEAT_PERIOD)
            except Empty:
                self._take_report(time.monotonic_ns())
                continue
            self._tick(torque)

    def _command(self) -> np.ndarray:
        """Return the torque in force."""
        torque, arrival = self._latest
        if self._timeout and arrival and time.monotonic_ns() - arrival > self._timeout:
            if not self._timed_out:
                self._timeouts += 1
                self._timed_out = True
            return self._zero
        self._timed_out = False
        return torque

    def _tick(self, torque: np.ndarray) -> None:
        begin = time.monotonic_ns()
        robot = self.robot
        robot.command(torque)
        if self._taken == 0:
            robot.prepare()  # the first acceleration is that of the first torque
        for _ in range(self.steps):
            before = time.monotonic_ns()
            if robot.step() != OK:
                break
            self._step_time.add(time.monotonic_ns() - before)
            self._taken += 1
        self._ticks += 1
        self._publish()
        now = time.monotonic_ns()
        self._tick_time.add(now - begin)
        if now >= self._next_report or robot.status != OK:
            self._take_report(now)

    def _publish(self, *, everything: bool = False) -> None:
        """Publish what is due."""
        stamp = self.time
        for output in self.outputs:
            if everything or self._ticks % output.every == 0:
                output.publish(stamp)

    def _repeat(self, until: threading.Event) -> None:
        """Publish the state again and again while time stands still."""
        while not until.wait(REPEAT_PERIOD) and not self._stop.is_set():
            self._publish(everything=True)
            self._take_report(time.monotonic_ns())

    def _take_report(self, now: int) -> None:
        self._next_report = now + REPORT_PERIOD
        simulated = self.time
        last, last_simulated, last_overruns = self._window
        elapsed, recent = now - self._begun, now - last
        moving = self._begun > 0
        stopped = self.robot.status != OK
        kinetic, elastic, gravitational = map(float, self.robot.energy())
        overruns = self.pace.overruns
        loops = self.robot.singularity
        self.report = Report(
            phase="stopped" if stopped else "running" if moving else "waiting",
            status=self.robot.reason,
            time=simulated / SECOND,
            real_time_factor=simulated / elapsed if moving and elapsed else 0.0,
            recent_factor=(simulated - last_simulated) / recent if moving and recent else 0.0,
            ticks=self._ticks,
            overruns=overruns,
            recent_overruns=overruns - last_overruns,
            lost=self.pace.lost / SECOND,
            step_p50=self._step_time.quantile(0.5),
            step_p99=self._step_time.quantile(0.99),
            step_worst=self._step_time.worst / SECOND,
            tick_p99=self._tick_time.quantile(0.99),
            tick_worst=self._tick_time.worst / SECOND,
            late_p99=self.pace.lateness.quantile(0.99),
            late_worst=self.pace.lateness.worst / SECOND,
            timeouts=self._timeouts,
            real_time_priority=self._first,
            energy=(kinetic, elastic, gravitational),
            conditioning=loops.worst if loops else None,
            warning=loops.warning if loops else "",
        )
        if loops is not None:
            loops.worst = loops.now
        if moving:
            self._window = (now, simulated, overruns)
