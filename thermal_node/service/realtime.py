"""The marching thread: a door under test at the pace of the steady clock, or as fast as it goes.

Nothing here knows of ROS.  Measured temperatures come in from another thread by `Loop.measure`;
what is to be published goes out by calling `Output.publish` from the marching thread.
"""

from __future__ import annotations

import math
import threading
import time
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from typing import Any

from ..furnace.plausibility import Limits, Plausibility, Refusal
from .background_deformation import BackgroundDeformation, Bent
from .fire_test import FireTest

SECOND = 1_000_000_000
# A deadline missed by less is made up for; beyond this the lost time stays lost.
PATIENCE = 1.0
# How often what stands still is published again, and how often it looks around meanwhile.
REPEAT_PERIOD = 2.0
LOOK_PERIOD = 0.05
# A thread can't be asked to wait for centuries, which a slow door's next tick may be away.
LONGEST_WAIT = 60.0
# s, beyond which a stamp of ROS can't tell time.
LAST_STAMP = 2**31 - 1


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
    phase : waiting (for a measured temperature), running, paused, ended or stopped
    status : "ok", or why the march stopped
    time, exposure : simulated, and since the fire began (a reset begins it anew)
    factor, recent_factor : simulated over elapsed time while running, and in the last ticks
    lost : by how much the door is behind its pace for good
    tick_worst : longest time for a tick, publishing included
    stale : since the last measured temperature; measured : whether one drives the furnace
    resumed : how often the march went on after a stop, with what the furnace measured then
    """

    phase: str = "waiting"
    status: str = "ok"
    time: float = 0.0
    exposure: float = 0.0
    verdict: str = ""
    factor: float = 0.0
    ticks: int = 0
    overruns: int = 0
    lost: float = 0.0
    tick_worst: float = 0.0
    steps: int = 0
    rejected_steps: int = 0
    imbalance: float = 0.0
    furnace: float = 0.0
    measured: bool = False
    stale: float = 0.0
    tolerance: str = ""
    accepted: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    resumed: int = 0
    deflections: int = 0
    deflections_skipped: int = 0
    deformation_failure: str = ""


@dataclass
class Job:
    """Ticks that were asked for while paused."""

    done: Future[int]
    count: int
    progress: Callable[[int], bool]
    taken: int = 0


class Loop:
    """Marches a door in a thread of its own.

    Parameters
    ----------
    test : FireTest
        From `start` on it belongs to the marching thread.
    rate : float, Hz
        Ticks a second of simulated time: the march meets each tick exactly.
    pace : float
        Simulated over real time; infinite: ticks without a pause.
    outputs : sequence of Output
        Called in this order.
    duration : float, s
        Of exposure, after which time stands still; 0 for never.
    wait_for_furnace : bool
        Time stands still until the first measured temperature.
    limits : Limits
        Which measured temperatures are believed.
    deformation : BackgroundDeformation or None
        Given the temperatures every `deflection_period` s; what it solved goes to `bent`.
    """

    def __init__(
        self,
        test: FireTest,
        rate: float,
        pace: float,
        outputs: Sequence[Output],
        *,
        duration: float = 0.0,
        wait_for_furnace: bool = False,
        limits: Limits | None = None,
        deformation: BackgroundDeformation | None = None,
        deflection_period: float = 30.0,
        bent: Callable[[Bent], None] = lambda _: None,
    ) -> None:
        self.test = test
        self.rate = rate
        self.pace = pace
        self.outputs = list(outputs)
        self.report = Report()
        self.failure: Exception | None = None
        self.resets = 0  # to the cold door
        self.ended = threading.Event()
        self._duration = duration or math.inf
        self._wait = wait_for_furnace
        self.plausibility = Plausibility(limits or Limits())
        self._deformation = deformation
        self._deflection_every = max(1, round(deflection_period * rate))
        self._bent = bent
        # The mailbox: the latest measured temperature wins.
        self._measured: float | None = None
        self._accepted = 0
        self._resumed = 0
        self._refused: Counter[str] = Counter()
        self._requests: SimpleQueue[tuple[Future[Any], Callable[[], Any]]] = SimpleQueue()
        self._wake = threading.Event()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="marching", daemon=True)
        self._paused = False
        self._job: Job | None = None
        self._ticks = 0  # of this exposure
        self._offset = 0  # ns of stamps before this exposure
        self._submitted = -1
        self._deadline = 0.0
        self._overruns = 0
        self._lost = 0.0
        self._all_ticks = 0
        self._busy = 0.0
        self._worst = 0.0

    @property
    def time(self) -> int:
        """Time of the state, ns, as its stamps say; it goes on when the door is reset."""
        return self._offset + round(self.test.time * SECOND)

    def start(self) -> None:
        """Begin to march."""
        if self._deformation is not None:
            self._deformation.start()
        self._thread.start()

    def stop(self) -> None:
        """End the thread after the tick it is in."""
        self._stop.set()
        self._wake.set()
        if self._thread.is_alive():
            self._thread.join()
        if self._deformation is not None:
            self._deformation.stop()

    def measure(self, temperature: float) -> Refusal | None:
        """Hand over a measured furnace temperature, °C; why it is refused, or None."""
        refusal = self.plausibility.check(self.test.time, temperature)
        if refusal is not None:
            self._refused[refusal.reason] += 1
        else:
            self._accepted += 1
            self._measured = temperature
            if self._wait or not self.test.status.ok:
                self._wake.set()
        return refusal

    @property
    def ticks(self) -> int:
        """How many there were since the start, over all resets."""
        return self._all_ticks

    @property
    def trouble(self) -> str:
        """Why the march can't go on until a reset, or nothing."""
        if not self.test.status.ok:
            return f"the march has stopped: {self.test.status.reason}"
        return "the test has ended" if self._over() else ""

    @property
    def hindrance(self) -> str:
        """Why steps can't be taken now, or nothing."""
        if self._waiting() and not self.trouble:
            return (
                "it waits for the first measured temperature (wait_for_furnace);"
                " send one on furnace/measured_temperature"
            )
        return self.trouble

    @property
    def shortage(self) -> str:
        """Why fewer steps were taken than were asked for the last time, or nothing."""
        return self.hindrance

    def pause(self) -> Future[None]:
        """Let time stand still after the tick it is in."""
        return self.ask(lambda: self._set_paused(True))

    def resume(self) -> Future[None]:
        """Let time go on."""
        return self.ask(lambda: self._set_paused(False))

    def step(self, count: int = 1, progress: Callable[[int], bool] = lambda _: True) -> Future[int]:
        """March some ticks while paused, and stay paused; how many there were.

        Whatever else is asked for ends them early, and so does `progress`, which gets how many are done and
        says whether to go on.
        """
        done: Future[int] = Future()

        def begin() -> None:
            if not self._paused:
                raise RuntimeError("the door is not paused; pause it before you step")
            self._end_job()
            self._job = Job(done, count, progress)
            if count == 0 or not self._can_go():
                self._end_job()

        self.ask(begin).add_done_callback(
            lambda f: done.set_exception(f.exception()) if f.exception() else None
        )
        return done

    def reset(self, *, time: bool = False, state: bool = True) -> Future[None]:
        """Back to the cold door and the scene's furnace, or begin time anew, or both.

        Stamps go on, as ROS asks of time, unless `time` is to begin anew.
        """

        def begin_anew() -> None:
            self._end_job()
            stamp = 0 if time else self.time
            if state:
                self.test.reset()
                self._measured = None
                self.plausibility.forget()
                self._ticks, self._submitted = 0, -1
                self.resets += 1
                if self._deformation is not None:
                    self._deformation.forget()
            self._offset += stamp - self.time
            self._deadline = _now()
            self._publish(everything=True)

        return self.ask(begin_anew)

    def change(self, pace: float, duration: float, outputs: Sequence[Output]) -> None:
        """Take another pace, duration and outputs; for the marching thread, by `ask`."""
        self.pace, self._duration, self.outputs = pace, duration or math.inf, list(outputs)
        self._deadline = _now()

    def ask(self, action: Callable[[], Any]) -> Future[Any]:
        """Have something done by the marching thread between two ticks."""
        answer: Future[Any] = Future()
        self._requests.put((answer, action))
        self._wake.set()
        if self.ended.is_set():
            self._answer(refuse=True)
        return answer

    def _set_paused(self, paused: bool) -> None:
        self._end_job()
        self._paused = paused
        self._deadline = _now()

    def _run(self) -> None:
        try:
            self._take_report()
            self._publish(everything=True)
            self._deadline = _now()
            repeat = _now() + REPEAT_PERIOD
            while not self._stop.is_set():
                self._wake.clear()
                self._answer()
                if self._job is not None and self._can_go():
                    self._tick()
                    self._count(self._job)
                    continue
                self._end_job()
                if self._measured is not None and not self._paused and self.test.go_on():
                    self._resumed += 1
                if self._standing():
                    self._settle()
                    if _now() >= repeat:
                        self._publish(everything=True)
                        repeat = _now() + REPEAT_PERIOD
                    self._take_report()
                    self._wake.wait(LOOK_PERIOD)
                    self._deadline = _now()
                    continue
                repeat = _now() + REPEAT_PERIOD
                if self._due():
                    self._tick()
            self._take_report()
        except Exception as problem:
            self.failure = problem
        finally:
            self._end_job()
            self.ended.set()
            self._answer(refuse=True)

    def _count(self, job: Job) -> None:
        job.taken += self.test.status.ok
        if not self.test.status.ok or not job.progress(job.taken) or job.taken >= job.count:
            self._end_job()

    def _end_job(self) -> None:
        job, self._job = self._job, None
        if job is not None:
            self._take_report()
            job.done.set_result(job.taken)

    def _answer(self, refuse: bool = False) -> None:
        while True:
            try:
                answer, action = self._requests.get_nowait()
            except Empty:
                return
            if refuse:
                answer.set_exception(RuntimeError("the march has ended"))
                continue
            try:
                answer.set_result(action())
            except Exception as problem:
                answer.set_exception(problem)

    def _waiting(self) -> bool:
        return self._wait and self._measured is None and self.test.measured is None

    def _over(self) -> bool:
        next_stamp = self.time / SECOND + 1.0 / self.rate
        return self._ticks / self.rate >= self._duration - 1e-9 or next_stamp > LAST_STAMP

    def _can_go(self) -> bool:
        return self.test.status.ok and not self._over() and not self._waiting()

    def _standing(self) -> bool:
        return self._paused or not self._can_go()

    def _due(self) -> bool:
        """Wait for the next tick's deadline; False where something else came up."""
        if not math.isfinite(self.pace):
            return True
        period = 1.0 / (self.rate * self.pace)
        left = self._deadline + period - _now()
        if left > LONGEST_WAIT:
            self._wake.wait(LONGEST_WAIT)
            return False
        if left > 0.0:
            return not self._wake.wait(left)
        self._overruns += 1
        if left < -PATIENCE:
            self._lost -= left * self.pace
            self._deadline -= left
        return True

    def _tick(self) -> None:
        begin = _now()
        if math.isfinite(self.pace):
            self._deadline += 1.0 / (self.rate * self.pace)
        measured, self._measured = self._measured, None
        if measured is not None:
            self.test.measure(measured)
        # Counted in whole ticks, so that it does not drift.
        if self.test.advance((self._ticks + 1) / self.rate).ok:
            self._ticks += 1
        self._all_ticks += 1
        self._collect()
        self._publish(everything=not self.test.status.ok)
        if self._deformation is not None and self._ticks % self._deflection_every == 0:
            self._submit()
        took = _now() - begin
        self._busy += took
        self._worst = max(self._worst, took)
        self._take_report()

    def _submit(self) -> None:
        if self._deformation is not None and self._submitted != self._ticks:
            self._submitted = self._ticks
            self._deformation.submit(self.test.time, self.time, self.test.heat.temperature)

    def _settle(self) -> None:
        """What stands still gets the shape that belongs to it."""
        if self._deformation is not None and self._ticks:
            self._submit()
        self._collect()

    def _collect(self) -> None:
        bent = None if self._deformation is None else self._deformation.take()
        if bent is not None:
            shape = bent.deflection
            self.test.criteria.watch_deflection(bent.time, shape)
            self._bent(bent)

    def _publish(self, *, everything: bool = False) -> None:
        stamp = self.time
        for output in self.outputs:
            if everything or self._ticks % output.every == 0:
                output.publish(stamp)

    @property
    def phase(self) -> str:
        """What it does now: waiting, running, paused, ended, or stopped by the solver."""
        if not self.test.status.ok:
            return "stopped"
        if self._paused:
            return "paused"
        if self._waiting():
            return "waiting"
        return "running" if self._can_go() else "ended"

    def _take_report(self) -> None:
        test, deformation = self.test, self._deformation
        period = 1.0 / (self.rate * self.pace) if math.isfinite(self.pace) else 0.0
        elapsed = max(self._busy, self._all_ticks * period)
        self.report = Report(
            phase=self.phase,
            status="ok" if test.status.ok else test.status.reason,
            time=self.time / SECOND,
            exposure=test.time,
            verdict=test.criteria.verdict("" if test.status.ok else test.status.reason),
            factor=self._all_ticks / self.rate / elapsed if elapsed else 0.0,
            ticks=self._all_ticks,
            overruns=self._overruns,
            lost=self._lost,
            tick_worst=self._worst,
            steps=test.heat.steps,
            rejected_steps=test.heat.rejected,
            imbalance=test.heat.balance.worst,
            furnace=test.furnace,
            measured=test.measured is not None,
            stale=test.stale,
            tolerance=test.tolerance.broken,
            accepted=self._accepted,
            refused=self._refused.copy(),
            resumed=self._resumed,
            deflections=deformation.solved if deformation else 0,
            deflections_skipped=deformation.skipped if deformation else 0,
            deformation_failure=deformation.failure if deformation else "",
        )


def _now() -> float:
    return time.monotonic()
