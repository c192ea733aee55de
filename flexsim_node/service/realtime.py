"""The stepping thread: a robot at the pace of the steady clock, of its commands, or at full speed.

Nothing here knows of ROS.  Commands come in from another thread by `Loop.put`, wishes by `pause`, `resume`,
`reset`, `step` and `ask`; states go out by calling `Output.publish` from the stepping thread, right after
the step that made them.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Hashable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, replace
from queue import Empty, SimpleQueue
from typing import Any

import numpy as np

from ..equations.dynamics.acceleration import NOT_VALID, OK
from ..motion.envelope import Envelope
from ..motion.simulation import Simulation
from ..motion.validity import LOOK_PERIOD, Seen, ValidityWatch
from .pace import SECOND, Histogram, Pace, come_forward, go_first, sleep_finely, stand_back
from .report import Report

MODES = ("realtime", "lockstep", "fast")
# How often a state is repeated while time stands still.
REPEAT_PERIOD = 0.1
REPORT_PERIOD = SECOND
# Lockstep: for so many repeat periods nobody else comes before who has come is shown the state.
ARRIVAL = 3
# Lockstep: commands that may wait; a step that was asked for waits so long for its command, s.
LONGEST_QUEUE = 100_000
COMMAND_PATIENCE = 10.0
# With so many ticks from check to check each takes a bit of it: all of it at once may take most of a tick.
BITS = 20


@dataclass(frozen=True)
class Output:
    """What is published every so many ticks; `publish` gets the time of the state, ns."""

    every: int
    publish: Callable[[int], None]


@dataclass
class Job:
    """Steps that were asked for while paused."""

    done: Future[int]
    count: int
    progress: Callable[[int], bool]
    since: float
    taken: int = 0


@dataclass(frozen=True)
class Account:
    """What the stepping thread knows of itself each second, without what takes long to work out."""

    report: Report
    watch: ValidityWatch
    seen: Seen
    warning: str


class Loop:
    """Steps a robot in a thread of its own.

    Parameters
    ----------
    robot : Simulation
        From `start` on it belongs to the stepping thread.
    steps : int
        Steps of a tick: between two deadlines, or for one command in lockstep.
    mode : "realtime", "lockstep" or "fast"
    outputs : sequence of Output
        Called in this order.
    period : int
        Ticks of a control period, which is what `step` counts.
    command_timeout : float, s
        After which the torque becomes zero; 0 for never.
    wait_for_command : bool
        Time stands still until the first command, as it does in lockstep anyway.
    audience : callable
        Who listens and who commands now, as something that can be compared: lockstep shows its state again
        when somebody has come.
    scope : Envelope, or None
        That what the scene left to `auto` was decided over: the motion is held against it.
    """

    def __init__(
        self,
        robot: Simulation,
        steps: int,
        mode: str,
        outputs: Sequence[Output],
        *,
        period: int = 1,
        command_timeout: float = 0.0,
        wait_for_command: bool = False,
        audience: Callable[[], Hashable] = lambda: None,
        scope: Envelope | None = None,
    ) -> None:
        self.robot = robot
        self.steps = steps
        self.mode = mode
        self.outputs = list(outputs)
        self.period = period
        self.command_timeout = command_timeout
        self._account = Account(Report(), robot.watch, robot.watch.so_far(), "")
        self._scope = scope
        self._left = ""  # what has left the envelope that effects were decided over
        self.failure: Exception | None = None
        self.resets = 0  # to the first state
        self.pace = Pace(round(steps * robot.step_size * SECOND))
        self._check_every = max(1, round(LOOK_PERIOD / (steps * robot.step_size)))
        self.ended = threading.Event()
        self._wait = wait_for_command and mode != "lockstep"
        self._audience = audience
        self._zero = np.zeros(robot.model.joints)
        # The mailbox: the latest command wins.  One tuple, so that a reader never sees half of it.
        self._latest: tuple[np.ndarray, int] = (self._zero, 0)
        self._in_force = self._zero
        # Lockstep forgets no command; None wakes who waits for one.
        self._queue: SimpleQueue[np.ndarray | None] = SimpleQueue()
        self._wishes: SimpleQueue[tuple[Future[Any], Callable[[], Any]]] = SimpleQueue()
        self._wake = threading.Event()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="stepping", daemon=True)
        self._paused = False
        self._job: Job | None = None
        self._starved = ""  # why the last job's steps were not taken
        self._begun = False  # whether the first state has been shown
        self._offset = 0  # ns of stamps before the last reset
        self._taken = 0  # steps since then
        self._index = 0  # ticks since then
        self._ticks = 0
        self._timeouts = 0
        self._timed_out = False
        self._step_time, self._tick_time = Histogram(), Histogram()
        self._first = False
        self._stood_back: dict[int, int] = {}  # threads' priorities while steps are as fast as they go
        self._moving = 0  # ns of elapsed time in which time went on
        self._since = 0  # when it began to go on, ns; 0 while it stands still
        self._window = (0.0, 0.0, 0)
        self._next_report = 0
        self._shown: Hashable = None
        self._seen: Hashable = None
        self._unchanged = 0
        self._ticks_seen = 0

    @property
    def time(self) -> int:
        """Simulated time, ns; counted in whole steps, so that it does not drift."""
        return self._offset + round(self._taken * self.robot.step_size * SECOND)

    @property
    def ticks(self) -> int:
        """How many there were since the start, over all resets."""
        return self._ticks

    @property
    def report(self) -> Report:
        """How it went until the account that was taken last, put together by who asks."""
        account, pace = self._account, self.pace
        validity = account.watch.findings(account.seen)
        warning = account.warning or " ".join(f.sentence() for f in validity if f.passed == "warn")
        return replace(
            account.report,
            step_p50=self._step_time.quantile(0.5),
            step_p99=self._step_time.quantile(0.99),
            step_worst=self._step_time.worst / SECOND,
            tick_p99=self._tick_time.quantile(0.99),
            tick_worst=self._tick_time.worst / SECOND,
            late_p99=pace.lateness.quantile(0.99),
            late_worst=pace.lateness.worst / SECOND,
            warning=warning,
            validity=validity,
        )

    @property
    def trouble(self) -> str:
        """Why the solver has stopped, or nothing."""
        return "" if self.robot.status == OK else f"the solver has stopped: {self.robot.reason}"

    @property
    def hindrance(self) -> str:
        """Why steps can't be taken now, or nothing."""
        return self.trouble

    @property
    def shortage(self) -> str:
        """Why fewer steps were taken than were asked for the last time, or nothing."""
        return self.trouble or self._starved

    def start(self) -> None:
        """Begin to step."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread after the tick it is in."""
        self._stop.set()
        self._rouse()
        if self._thread.is_alive():
            self._thread.join()

    def put(self, torque: np.ndarray) -> bool:
        """Hand over a checked command (m,), N m, which holds until the next; whether there is room for it."""
        if self.mode == "lockstep":
            if self._queue.qsize() >= LONGEST_QUEUE:
                return False
            self._queue.put(torque)
        else:
            self._latest = (torque, time.monotonic_ns())
            if self._wait:
                self._wake.set()
        return True

    def ask(self, action: Callable[[], Any]) -> Future[Any]:
        """Have something done by the stepping thread between two ticks."""
        answer: Future[Any] = Future()
        self._wishes.put((answer, action))
        self._rouse()
        if self.ended.is_set():
            self._obey()
        return answer

    def pause(self) -> Future[None]:
        """Let time stand still after the control period it is in."""
        return self.ask(lambda: self._set_paused(True))

    def resume(self) -> Future[None]:
        """Let time go on."""
        return self.ask(lambda: self._set_paused(False))

    def step(self, count: int, progress: Callable[[int], bool] = lambda _: True) -> Future[int]:
        """Take control periods while paused, as fast as it goes; how many there were.

        The process has no real-time priority then: others would hardly run, who ends the steps among them.
        Whatever else is asked for ends them early, and so does `progress`, which gets how many are done and
        says whether to go on.  In lockstep each waits for its command, but not longer than ten seconds.
        """
        done: Future[int] = Future()

        def begin() -> None:
            if not self._paused:
                raise RuntimeError("the robot is not paused; pause it before you step")
            self._end_job()
            self._starved = ""
            self._job = Job(done, count, progress, time.monotonic())
            if self._first:
                self._stood_back = stand_back()
            if count == 0 or self.trouble:
                self._end_job()

        self.ask(begin).add_done_callback(
            lambda f: done.set_exception(f.exception()) if f.exception() else None
        )
        return done

    def reset(self, *, time: bool = False, state: bool = True) -> Future[None]:
        """Return to the scene's first state with no torque, or begin time anew, or both.

        Stamps go on, as ROS asks of time, unless `time` is to begin anew.
        """

        def begin_anew() -> None:
            self._end_job()
            now = self.time
            if state:
                self._forget_commands()
                self.robot.reset()
                self._left = ""
                self._taken = self._index = 0
                self._in_force = self._zero
                self.resets += 1
            stamp = 0 if time else now
            self._offset += stamp - self.time
            self._next_report = 0  # the last one is of another state
            self.pace.start()
            self._publish(everything=True)

        return self.ask(begin_anew)

    def _forget_commands(self) -> None:
        self._latest = (self._zero, 0)
        while True:
            try:
                self._queue.get_nowait()
            except Empty:
                return

    def _rouse(self) -> None:
        self._wake.set()
        if self.mode == "lockstep" and self._queue.empty():  # only then may someone wait for it
            self._queue.put(None)

    def _set_paused(self, paused: bool) -> None:
        self._end_job()
        # A control period that has begun is ended, so that steps are whole ones.
        while self._index % self.period and self.robot.status == OK and not self._stop.is_set():
            self._tick(self._command())
        self._paused = paused

    def _run(self) -> None:
        try:
            sleep_finely()
            self._first = self.mode == "realtime" and go_first()
            self._take_report(time.monotonic_ns())
            if self.mode != "lockstep":
                self._publish(everything=True)
            while not self._stop.is_set():
                self._wake.clear()
                self._obey()
                if self._standing():
                    self._stand()
                elif self.mode == "lockstep":
                    self._start_clock()
                    self._locked()
                else:
                    self._start_clock()
                    if self.mode == "realtime" and self._job is None:
                        self.pace.wait()
                    self._tick(self._command())
            self._take_report(time.monotonic_ns())
        except Exception as problem:
            self.failure = problem
        finally:
            self._end_job()
            self.ended.set()
            self._obey()

    def _obey(self) -> None:
        """Do what was asked for."""
        while not self._wishes.empty():
            try:
                answer, action = self._wishes.get_nowait()
            except Empty:
                return
            if not answer.set_running_or_notify_cancel():
                continue
            if self.ended.is_set():
                answer.set_exception(RuntimeError("the robot's process is ending"))
                continue
            try:
                answer.set_result(action())
            except Exception as problem:
                answer.set_exception(problem)

    def _waiting(self) -> bool:
        return self._wait and not self._latest[1]

    def _standing(self) -> bool:
        return (
            self.robot.status != OK
            or (self._paused and self._job is None)
            or (self._waiting() and self._job is None)
        )

    def _start_clock(self) -> None:
        if not self._since:
            self._since = time.monotonic_ns()
            self.pace.start()

    def _stop_clock(self) -> None:
        if self._since:
            self._moving += time.monotonic_ns() - self._since
            self._since = 0

    def _stand(self) -> None:
        """Let time stand still for a moment, and show where it does."""
        self._end_job()
        self._stop_clock()
        self._take_report(time.monotonic_ns())
        if self._wake.wait(REPEAT_PERIOD) or self._stop.is_set():
            return
        if self.mode == "lockstep" and self.robot.status == OK:
            self._welcome()
        else:
            self._publish(everything=True)

    def _welcome(self) -> None:
        """Show the state again to who has come, once all who come together are there.

        A state is not shown to lockstep's controllers twice without need, since one that answers it twice
        would be a period ahead from then on.
        """
        audience = self._audience()
        if self._ticks != self._ticks_seen:  # all who are there have heard a later state
            self._ticks_seen, self._shown = self._ticks, audience
        self._unchanged = self._unchanged + 1 if audience == self._seen else 0
        self._seen = audience
        if audience != self._shown and self._unchanged >= ARRIVAL:
            self._publish(everything=True)
            self._shown = audience

    def _locked(self) -> None:
        try:
            torque = self._queue.get(timeout=REPEAT_PERIOD)
        except Empty:
            self._welcome()
            self._take_report(time.monotonic_ns())
            if self._job is not None and time.monotonic() - self._job.since > COMMAND_PATIENCE:
                self._starved = f"no command came within {COMMAND_PATIENCE:g} s"
                self._end_job()
            return
        if torque is not None:
            if not self._begun:  # commands that came early: their first state is still shown first
                self._publish(everything=True)
            self._tick(torque)

    def _command(self) -> np.ndarray:
        """Return the torque in force."""
        torque, arrival = self._latest
        timeout = self.command_timeout
        if timeout and arrival and time.monotonic_ns() - arrival > timeout * SECOND:
            if not self._timed_out:
                self._timeouts += 1
                self._timed_out = True
            return self._zero
        self._timed_out = False
        return torque

    def _tick(self, torque: np.ndarray) -> None:
        begin = time.monotonic_ns()
        robot = self.robot
        if torque is not self._in_force:
            robot.command(torque)
            self._in_force = torque
        if self._taken == 0:
            robot.prepare()  # the first acceleration is that of the first torque
        for _ in range(self.steps):
            before = time.monotonic_ns()
            if robot.step() != OK:
                break
            self._step_time.add(time.monotonic_ns() - before)
            self._taken += 1
        if self._scope is not None and not self._left and robot.status == OK:
            self._look_at_scope(self._scope)
        self._index += 1
        self._ticks += 1
        due = self._ticks % self._check_every == 0
        if self._check_every >= BITS:
            robot.glance(due)
        elif due:
            robot.check()
        self._publish()
        now = time.monotonic_ns()
        self._tick_time.add(now - begin)
        if self._job is not None:
            self._count(self._job)
        if now >= self._next_report or robot.status != OK:
            self._take_report(now)

    def _look_at_scope(self, scope: Envelope) -> None:
        """Tell at once, or end, when the motion leaves what effects were decided over."""
        robot = self.robot
        q, v = robot.model.shown(robot.x), robot.model.shown(robot.v)
        self._left = scope.beyond(self._taken * robot.step_size, q, v, robot.torque[2])
        if self._left:
            self._next_report = 0
            if robot.scene.auto.beyond == "stop":
                robot.status = NOT_VALID

    def _count(self, job: Job) -> None:
        """A job is done when its control periods are, or its progress says so, or the solver stops."""
        if self.robot.status == OK and self._index % self.period:
            return
        job.taken += self.robot.status == OK
        job.since = time.monotonic()
        if self.robot.status != OK or not job.progress(job.taken) or job.taken >= job.count:
            self._end_job()

    def _end_job(self) -> None:
        job, self._job = self._job, None
        if job is not None:
            come_forward(self._stood_back)
            self._stood_back = {}
            self._stop_clock()
            self._take_report(time.monotonic_ns())
            job.done.set_result(job.taken)

    def _publish(self, *, everything: bool = False) -> None:
        """Publish what is due."""
        stamp = self.time
        self._begun = True
        for output in self.outputs:
            if everything or self._index % output.every == 0:
                output.publish(stamp)

    @property
    def _ended_by_scope(self) -> bool:
        return bool(self._left) and self.robot.status != OK and self.robot.scene.auto.beyond == "stop"

    @property
    def phase(self) -> str:
        """What it does now: waiting, running, paused, or stopped by the solver."""
        if self.robot.status != OK:
            return "stopped"
        if self._paused:
            return "paused"
        started = self._ticks > 0 if self.mode == "lockstep" else not self._waiting()
        return "running" if started else "waiting"

    def _take_report(self, now: int) -> None:
        if now < self._next_report and not self._since and self._account.report.phase == self.phase:
            return
        self._next_report = now + REPORT_PERIOD
        tick = self.steps * self.robot.step_size
        simulated = self._ticks * tick
        moving = (self._moving + (now - self._since if self._since else 0)) / SECOND
        last, last_simulated, last_overruns = self._window
        recent = moving - last
        kinetic, elastic, gravitational = map(float, self.robot.energy())
        overruns = self.pace.overruns
        loops, watch = self.robot.singularity, self.robot.watch
        report = Report(
            phase=self.phase,
            status=self._left if self._ended_by_scope else self.robot.reason,
            time=self.time / SECOND,
            real_time_factor=simulated / moving if moving else 0.0,
            recent_factor=(simulated - last_simulated) / recent if recent else 0.0,
            ticks=self._ticks,
            overruns=overruns,
            recent_overruns=overruns - last_overruns,
            longest_run=self.pace.longest_run,
            lost=self.pace.lost / SECOND,
            timeouts=self._timeouts,
            real_time_priority=self._first,
            energy=(kinetic, elastic, gravitational),
            conditioning=loops.worst if loops else None,
        )
        self._account = Account(report, watch, watch.so_far(), self._left or (loops.warning if loops else ""))
        if self.robot.status == OK:
            watch.clear()
        if loops is not None:
            loops.worst = loops.now
        self._window = (moving, simulated, overruns)
