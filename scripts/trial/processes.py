"""The processes of a trial: started together, and ended whatever happens."""

from __future__ import annotations

import os
import random
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from ..terminal.child import ending, start_child
from ..terminal.stop import Stop

# The domains of trials: people choose low ones by hand; above 101 a domain's ports reach into those that
# Linux hands out to anybody.
TRIALS = range(51, 102)
# DDSI-RTPS 9.6.1: the port at which the first participant of domain 0 is found, and how far apart they are.
FIRST_PORT, PORTS_A_DOMAIN, PORTS_A_PARTICIPANT, PARTICIPANTS = 7410, 250, 2, 10
POLL_PERIOD = 0.05
SIGNS: list[socket.socket] = []  # of the domains that this process has taken
END_TIMEOUT = 10.0
DISMISS_TIMEOUT = 2.0
# s after which a process that a signal has stopped is not waited for.
SUSPENDED = 3.0
COMMAND = [sys.executable, "-c", "from flexsim.cli import main; main()"]
NODE = [sys.executable, "-m", "flexsim_node.node"]
CONTROLLER = [sys.executable, "-m", "flexsim.controller"]


def is_free(domain: int) -> bool:
    """Say whether no program of this host is in a ROS domain."""
    first = FIRST_PORT + PORTS_A_DOMAIN * domain
    for port in range(first, first + PORTS_A_PARTICIPANT * PARTICIPANTS, PORTS_A_PARTICIPANT):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            try:
                probe.bind(("", port))
            except OSError:
                return False
    return True


def taken(domain: int) -> bool:
    """Take a domain for as long as this process lives; whether no other trial has it.

    A trial opens its ports only when its robot is there: until then another one would find the domain free.
    """
    sign = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    try:
        sign.bind(f"\0flexsim_domain_{domain}")  # Linux forgets it with the process
    except OSError:
        sign.close()
        return False
    SIGNS.append(sign)
    return True


def own_domain() -> dict[str, str]:
    """Return an environment in which a trial neither hears nor disturbs this host's robots.

    Raises
    ------
    RuntimeError
        where each domain for trials is taken
    """
    order = random.SystemRandom().sample(TRIALS, len(TRIALS))
    domain = next((domain for domain in order if is_free(domain) and taken(domain)), None)
    if domain is None:
        raise RuntimeError(f"all ROS domains for trials are taken, {TRIALS.start} to {TRIALS.stop - 1}")
    return {
        **os.environ,
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
    }


class Failed(RuntimeError):
    """A process of a trial of which nothing can be expected any more."""

    def __init__(self, process: Process, sentence: str) -> None:
        super().__init__(sentence)
        self.process = process


class Process:
    """A program in the background; what it says goes into files.

    Parameters
    ----------
    name : str
        For sentences about it and for its files, `<name>.out` and `<name>.log`.
    words : list of str
    folder : Path
    environment : mapping
    """

    def __init__(self, name: str, words: list[str], folder: Path, environment: Mapping[str, str]) -> None:
        self.name = name
        self.output = folder / f"{name}.out"
        self.log = folder / f"{name}.log"
        self._stopped_since = 0.0
        with self.output.open("w") as out, self.log.open("w") as log:
            self.process = start_child(words, out, log, environment)

    @property
    def pid(self) -> int:
        """Its number."""
        return self.process.pid

    @property
    def code(self) -> int | None:
        """Its exit code; None while it runs."""
        return self.process.poll()

    @property
    def suspended(self) -> bool:
        """Whether a signal (SIGSTOP) has stopped it for longer than SUSPENDED."""
        try:
            state = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()[0]
        except (OSError, IndexError):
            state = ""
        now = time.monotonic()
        self._stopped_since = (self._stopped_since or now) if state in ("T", "t") else 0.0
        return bool(self._stopped_since) and now - self._stopped_since > SUSPENDED

    def said(self, *words: str) -> bool:
        """Say whether all of these words are in its log."""
        log = self.log.read_text(errors="replace")
        return all(word in log for word in words)

    def end(self, timeout: float = END_TIMEOUT) -> int:
        """Ask it to finish, insist if it does not, and return its exit code."""
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            if self.process.poll() is not None:
                break
            self.process.send_signal(number)
            self.process.send_signal(signal.SIGCONT)  # what a signal has stopped hears no other
            try:
                self.process.wait(timeout)
            except subprocess.TimeoutExpired:
                continue
        return self.process.wait()

    @property
    def error(self) -> str | None:
        """The last error that it told its ROS log, or None."""
        lines = self.log.read_text(errors="replace").splitlines()
        found = [line for line in lines if line.startswith("[ERROR]")]
        return found[-1].split("]: ", 1)[-1] if found else None

    def failure(self) -> Failed:
        """Return what to raise where it ended before its time: its own last line."""
        lines = self.log.read_text(errors="replace").strip().splitlines()
        why = lines[-1] if lines else "it said nothing"
        # who was killed had no time to say why
        killed = (self.code or 0) < 0 and why.startswith("[INFO]")
        return Failed(self, f"{self.name} {ending(self.code or 0)}" + ("" if killed else f": {why}"))


class Processes:
    """Those of one trial."""

    def __init__(self, folder: Path, environment: Mapping[str, str], stopped: Stop) -> None:
        self.folder = folder
        self.environment = environment
        self.stopped = stopped
        self.running: list[Process] = []

    def start(self, name: str, words: list[str]) -> Process:
        """Start one more."""
        process = Process(name, words, self.folder, self.environment)
        self.running.append(process)
        return process

    def wait_until_said(self, process: Process, *words: str, timeout: float) -> None:
        """Wait for words in a process's log.

        Raises
        ------
        RuntimeError
            where a process ends first
        TimeoutError
            where the time is over
        KeyboardInterrupt
            where we are asked to stop
        """
        end = time.monotonic() + timeout
        while not process.said(*words):
            self.check()
            if time.monotonic() > end:
                raise TimeoutError(f"{process.name} did not say {words[-1]!r} within {timeout:g} s")
            time.sleep(POLL_PERIOD)

    def check(self) -> None:
        """Raise where one has ended, or where we are asked to stop."""
        if self.stopped.asked:
            raise KeyboardInterrupt
        for process in self.running:
            if process.code is not None:
                # what ends one is often another's trouble: a robot that stopped, and its controller
                others = [other for other in self.running if other is not process and other.error]
                said = [str(process.failure()), *(f"{o.name}: {o.error}" for o in others)]
                raise Failed(process, "; ".join(said))
            if process.suspended:
                raise Failed(
                    process,
                    f"{process.name} was stopped by a signal and stood still for {SUSPENDED:g} s; "
                    f"kill -CONT {process.pid} lets such a process go on",
                )

    def dismiss(self, process: Process) -> None:
        """End one that need not know how to end."""
        self.running.remove(process)
        process.end(DISMISS_TIMEOUT)

    def end(self, process: Process) -> None:
        """End one in good order; raises RuntimeError where it fails to."""
        self.running.remove(process)
        if process.end() != 0:
            raise process.failure()


@contextmanager
def processes(folder: Path, environment: Mapping[str, str], stopped: Stop) -> Iterator[Processes]:
    """Give a trial its processes, all of which have ended afterwards."""
    trial = Processes(folder, environment, stopped)
    try:
        yield trial
    finally:
        for process in reversed(trial.running):
            process.end()
