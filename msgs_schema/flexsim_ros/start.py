"""A process that ends well whenever a signal comes, and says so when it compiles for long.

It needs nothing but Python, and comes before what takes a second to import.  Three stages:

1. `first_instant`: nothing is there yet that would have to be ended: a signal ends the process.
2. `attentive`: something is made or done; a signal raises KeyboardInterrupt, so that it is cleaned up.
   Within an import or a compilation, where that would leave a traceback or come after half a minute, it ends
   the process on the spot: there is nothing to clean up that the system doesn't.
3. What handlers the program sets itself.
"""

from __future__ import annotations

import os
import select
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from .first_instant import SCRIPTS, SIGNALS, leave_at_signals

IMPORTS = "<frozen importlib._bootstrap>"
COMPILER = "numba/core/compiler.py"
PATIENCE = 0.3  # s that the main thread has for a signal before it is looked at what it does
LOOK_PERIOD = 0.25  # s
SAID_AGAIN = 5.0  # s


def doing(frame: FrameType | None) -> str:
    """Whether a thread is at "compiling" or at an "import", by its stack, or at neither: ""."""
    found = ""
    while frame is not None:
        file = frame.f_code.co_filename
        if file.endswith(COMPILER):
            return "compiling"
        if file == IMPORTS:
            found = "import"
        frame = frame.f_back
    return found


@contextmanager
def attentive(name: str, code: int, asked: list[int] | None = None) -> Iterator[None]:
    """Raise KeyboardInterrupt at SIGINT and SIGTERM, and say on stderr how long kernels are compiled.

    Parameters
    ----------
    name : of the program, for what is said
    code : the exit code where a signal ends the process on the spot
    asked : gets the signals' numbers: compiled code may swallow what is raised in the middle of it
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    handled = [0]

    def interrupt(number: int, frame: FrameType | None) -> None:
        handled[0] += 1
        if doing(frame):
            os._exit(code)
        if asked is not None:
            asked.append(number)
        raise KeyboardInterrupt

    before: dict[int, Any] = {number: signal.signal(number, interrupt) for number in SIGNALS}
    signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    told = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    over = threading.Event()

    def in_force() -> bool:
        return signal.getsignal(signal.SIGINT) is interrupt

    watch = Watch(name, code, reading, lambda: handled[0], in_force, over)
    thread = threading.Thread(target=watch.run, name="attentive", daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        signal.set_wakeup_fd(told)
        os.write(writing, b"\0")
        thread.join()
        os.close(reading)
        os.close(writing)
        for number, handler in before.items():
            if handled[0]:  # one that comes while it is cleaned up ends it
                signal.signal(number, lambda *_: os._exit(code))
            elif signal.getsignal(number) is interrupt:
                signal.signal(number, handler)


class Watch:
    """Looks at what the main thread does; from a thread of its own, which compiled code does not hold up."""

    def __init__(
        self,
        name: str,
        code: int,
        reading: int,
        handled: Callable[[], int],
        in_force: Callable[[], bool],
        over: threading.Event,
    ) -> None:
        self.name, self.code, self.reading = name, code, reading
        self.handled, self.in_force, self.over = handled, in_force, over
        self.main = threading.main_thread().ident or 0
        self._since: float | None = None
        self._said = 0.0

    def run(self) -> None:
        """Watch until it is over."""
        while not self.over.is_set():
            before = self.handled()
            ready, _, _ = select.select([self.reading], [], [], LOOK_PERIOD)
            if self.over.is_set():
                return
            if ready:
                os.read(self.reading, 64)
                self._signalled(before)
            self._look()

    def _now(self) -> str:
        return doing(sys._current_frames().get(self.main))

    def _signalled(self, before: int) -> None:
        """End a process whose main thread is where it can't answer."""
        end = time.monotonic() + PATIENCE
        while self.handled() == before and not self.over.is_set() and self.in_force():
            if time.monotonic() > end and self._now():
                os._exit(self.code)
            time.sleep(0.02)
            if time.monotonic() > end + PATIENCE:
                return

    def _look(self) -> None:
        """Say that kernels are compiled: soon after it has begun, then every few seconds."""
        if self._now() != "compiling":
            if time.monotonic() > self._said + SAID_AGAIN:
                self._since = None
            return
        now = time.monotonic()
        if self._since is None:
            self._since, self._said = now, now - SAID_AGAIN + 2 * LOOK_PERIOD
        if now < self._said + SAID_AGAIN:
            return
        so_far = now - self._since
        what = "compiling the equations, once on this machine: a minute or so"
        print(f"{self.name}: {what if so_far < SAID_AGAIN else f'compiling, {so_far:.0f} s so far'}",
              file=sys.stderr, flush=True)  # fmt: skip
        self._said = now


def flexsim() -> None:
    """Start `flexsim`."""
    leave_at_signals(SCRIPTS["flexsim"])
    from flexsim.cli import main

    main()


def flexsim_node() -> int:
    """Start flexsim_node."""
    leave_at_signals(SCRIPTS["flexsim_node"])
    from flexsim_node.node import main

    return main()


def thermal_node() -> int:
    """Start thermal_node."""
    leave_at_signals(SCRIPTS["thermal_node"])
    from thermal_node.node import main

    return main()
