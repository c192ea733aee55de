"""Ways to run the command, and a synthetic robot, as processes of their own."""

from __future__ import annotations

import io
import os
import signal
import subprocess
import sys
import time
import warnings
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

import pytest
from domains import DOMAINS
from flexsim.cli import main

SYNTHETIC = Path(__file__).with_name("synthetic_robot.py")


def ros_environment() -> dict[str, str]:
    """Return an environment whose nodes no other test can see."""
    environment = dict(os.environ)
    environment.pop("DISPLAY", None)
    environment.pop("WAYLAND_DISPLAY", None)
    environment["ROS_DOMAIN_ID"] = str(next(DOMAINS))
    environment["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    return environment


def flexsim(*words: object, **options: object) -> subprocess.CompletedProcess[str]:
    """Run the command to its end."""
    settings = {"env": ros_environment(), "timeout": 60, **options}
    return subprocess.run(command(*words), capture_output=True, text=True, **settings)


def flexsim_here(*words: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run the command in this process: for mistakes that are found before anything is started."""
    out, errors = io.StringIO(), io.StringIO()
    given, place, shown = sys.argv, Path.cwd(), warnings.showwarning
    sys.argv = ["flexsim", *map(str, words)]
    os.chdir(cwd)
    try:
        with redirect_stdout(out), redirect_stderr(errors), pytest.raises(SystemExit) as end:
            main()
    finally:
        sys.argv, warnings.showwarning = given, shown
        os.chdir(place)
    return subprocess.CompletedProcess(words, int(end.value.code or 0), out.getvalue(), errors.getvalue())


def command(*words: object) -> list[str]:
    """Return the command line of `flexsim` in this Python."""
    start = "from flexsim.cli import main; main()"
    return [sys.executable, "-c", start, *map(str, words)]


class Background:
    """A process that runs while a test goes on, and its output line by line."""

    def __init__(
        self, words: list[str], environment: dict[str, str], folder: Path, cwd: Path | None = None
    ) -> None:
        self.output = folder / f"{time.monotonic_ns()}.out"
        self.errors = self.output.with_suffix(".err")
        with self.output.open("w") as out, self.errors.open("w") as err:
            self.process = subprocess.Popen(
                words, env=environment, cwd=cwd, stdin=subprocess.PIPE, stdout=out, stderr=err
            )

    def wait_for(self, text: str, timeout: float = 40.0) -> None:
        """Wait until the process has printed something."""
        end = time.monotonic() + timeout
        while text not in self.output.read_text() + self.errors.read_text():
            if time.monotonic() > end or self.process.poll() is not None:
                pytest.fail(f"no '{text}' from {self.process.args}: {self.errors.read_text()}")
            time.sleep(0.02)

    def end(self, number: int = signal.SIGINT, timeout: float = 20.0) -> int:
        """Send a signal and return the exit code."""
        if self.process.poll() is None:
            self.process.send_signal(number)
        return self.process.wait(timeout)

    def release(self) -> None:
        """Close the process's standard input, which a synthetic robot takes as its end."""
        self.process.stdin.close()
        self.process.wait(20)


def synthetic_robot(
    environment: dict[str, str], folder: Path, messages: int, rate: float, *options: str
) -> Background:
    """Start a stand-in for flexsim_node."""
    words = [sys.executable, str(SYNTHETIC), str(messages), str(rate), *options]
    return Background(words, environment, folder)


@dataclass
class Recorded:
    """A bag and what the recorder said about it."""

    bag: Path
    output: str
    messages: int
    rate: float
