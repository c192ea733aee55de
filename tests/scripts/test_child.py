"""Programs that the command starts end with it, even where it is killed and can do nothing about it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

PARENT = """
import subprocess, sys, time
from flexsim.terminal.child import start_child
child = start_child([sys.executable, "-c", "import time; time.sleep(60)"], subprocess.DEVNULL, None)
print(child.pid, flush=True)
time.sleep(60)
"""


def ended(pid: int) -> bool:
    """Say whether a process is no more, or waits only for somebody to take its exit code."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] == "Z"
    except FileNotFoundError:
        return True


def test_a_child_ends_with_a_parent_that_is_killed() -> None:
    parent = subprocess.Popen([sys.executable, "-c", PARENT], stdout=subprocess.PIPE, text=True)
    assert parent.stdout is not None
    child = int(parent.stdout.readline())
    try:
        assert not ended(child)
        parent.kill()
        parent.wait()
        end = time.monotonic() + 10.0
        while not ended(child):
            assert time.monotonic() < end, "the child goes on"
            time.sleep(0.01)
    finally:
        if not ended(child):
            os.kill(child, signal.SIGKILL)
        parent.stdout.close()
