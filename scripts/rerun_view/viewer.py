"""Where a recording goes: a file, a viewer's window, or a server; never beyond this host."""

from __future__ import annotations

import socket
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import rerun as rr

from ..terminal.stop import stopped_by_signals

LOOPBACK = "127.0.0.1"
START_TIMEOUT = 15.0


@dataclass
class Target:
    """Where a recording goes: its address where it is served, its file where it is saved."""

    address: str | None = None
    file: Path | None = None

    def discard(self) -> None:
        """Remove the file of a recording that came to nothing."""
        if self.file is not None:
            self.file.unlink(missing_ok=True)


def attach(recording: rr.RecordingStream, *, save: str | None, serve: bool) -> Target:
    """Connect a recording to a file, a server on loopback, or a new viewer.

    Raises
    ------
    OSError
        The file cannot be written.
    RuntimeError
        The viewer did not start.
    """
    if save:
        file = Path(save)
        file.parent.mkdir(parents=True, exist_ok=True)
        file.open("wb").close()  # says at once, and in plain words, if it cannot be written
        recording.save(save)
        return Target(file=file)
    port = free_port()
    if serve:
        recording.set_sinks(rr.GrpcServerSink(bind_ip=LOOPBACK, port=port))
    else:
        spawn(port)
        recording.connect_grpc(address(port))
    return Target(address=address(port))


def spawn(port: int) -> None:
    """Start rerun's viewer, listening on loopback only, and wait until it does.

    rerun's own `spawn` listens on every interface.
    """
    viewer = subprocess.Popen(
        [sys.executable, "-m", "rerun", "--bind", LOOPBACK, "--port", str(port),
         "--expect-data-soon"],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )  # fmt: skip
    end = time.monotonic() + START_TIMEOUT
    while time.monotonic() < end and viewer.poll() is None:
        with socket.socket() as probe:
            if probe.connect_ex((LOOPBACK, port)) == 0:
                return
        time.sleep(0.05)
    raise RuntimeError(
        f"rerun's viewer did not start (its exit code: {viewer.poll()}); "
        "--save FILE.rrd needs no viewer"
    )


def free_port() -> int:
    """Return a port that is free.

    Not rerun's own: two views that start together would both find it free.
    """
    with socket.socket() as probe:
        probe.bind((LOOPBACK, 0))
        return int(probe.getsockname()[1])


def address(port: int) -> str:
    """Return the address that rerun's viewers and recordings connect to."""
    return f"rerun+http://{LOOPBACK}:{port}/proxy"


def wait(duration: float | None) -> None:
    """Stay until Ctrl-C, which is passed on, or for `duration` seconds."""
    end = None if duration is None else time.monotonic() + duration
    with stopped_by_signals() as stopped:
        while not stopped.asked and (end is None or time.monotonic() < end):
            time.sleep(0.1)
    if stopped.asked:
        raise KeyboardInterrupt
