"""Where a recording goes: a file, a viewer's window, or a server; never beyond this host."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

import rerun as rr

from ..terminal.stop import Stop

LOOPBACK = "127.0.0.1"
START_TIMEOUT = 60.0
# Of the host's memory: what a server of web pages keeps for browsers that come late.
KEPT = "50%"
# Of a disk, bytes: where less is left it counts as full.
SMALL = 16 * 1024 * 1024


@dataclass
class Target:
    """Where a recording goes: its address where it is served, its page in a browser, its file."""

    address: str | None = None
    file: Path | None = None
    page: str | None = None
    server: subprocess.Popen[bytes] | None = None

    def discard(self) -> None:
        """Remove the file of a recording that came to nothing."""
        if self.file is not None:
            self.file.unlink(missing_ok=True)

    def close(self) -> None:
        """End the server of a web page; a window goes on by itself."""
        if self.server is not None and self.server.poll() is None:
            # rerun's Python starts the program proper, which would outlive it.
            with suppress(ProcessLookupError):
                os.killpg(self.server.pid, signal.SIGTERM)
            self.server.wait()


def attach(recording: rr.RecordingStream, *, save: str | None, serve: bool, web: bool = False) -> Target:
    """Connect a recording to a file, a server on loopback, a web page on loopback, or a new viewer.

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
        return Target(address=address(port))
    if web:
        page = free_port()
        words = ["--serve-web", "--web-viewer-port", str(page), "--server-memory-limit", KEPT]
        target = Target(address=address(port), server=spawn([port, page], words))
        target.page = f"http://{LOOPBACK}:{page}/?url={quote(address(port), safe='')}"
    else:
        spawn([port], ["--expect-data-soon"])
        target = Target(address=address(port))
    recording.connect_grpc(address(port))
    return target


def spawn(ports: list[int], words: list[str]) -> subprocess.Popen[bytes]:
    """Start rerun's viewer, listening on loopback only, and wait until it does on all of its ports.

    rerun's own `spawn` listens on every interface.
    """
    viewer = subprocess.Popen(
        [sys.executable, "-m", "rerun", "--bind", LOOPBACK, "--port", str(ports[0]), *words],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )  # fmt: skip
    end = time.monotonic() + START_TIMEOUT
    while time.monotonic() < end and viewer.poll() is None:
        if all(answers(port) for port in ports):
            return viewer
        time.sleep(0.05)
    Target(server=viewer).close()
    raise RuntimeError(
        f"rerun's viewer did not start (its exit code: {viewer.poll()}); --save FILE.rrd needs no viewer"
    )


def answers(port: int) -> bool:
    """Say whether somebody listens on a port of this host."""
    with socket.socket() as probe:
        return probe.connect_ex((LOOPBACK, port)) == 0


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


def why_not_written(file: str) -> str:
    """Say why a recording could not be written to its end."""
    left = shutil.disk_usage(Path(file).absolute().parent).free
    return "no space is left on its disk" if left < SMALL else "the file or its disk does not take more"


def wait(duration: float | None, stopped: Stop) -> None:
    """Stay until it is stopped, or for `duration` seconds."""
    end = None if duration is None else time.monotonic() + duration
    while not stopped.asked and (end is None or time.monotonic() < end):
        time.sleep(0.1)
