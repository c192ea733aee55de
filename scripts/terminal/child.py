"""Programs that we start and that end with us."""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Mapping
from typing import IO, Any

PR_SET_PDEATHSIG = 1
# Taken here: between fork and exec a child must not import.
_libc = ctypes.CDLL(None, use_errno=True) if sys.platform == "linux" else None


def start_child(
    words: list[str],
    out: IO[Any] | int,
    errors: IO[Any] | int | None,
    environment: Mapping[str, str] | None = None,
) -> subprocess.Popen[bytes]:
    """Start a program in a session of its own: Ctrl-C is ours, and it ends when we say so.

    Where we are killed, and can say nothing any more, Linux tells it to end; so call this from a thread that
    lives as long as we do.
    """
    return subprocess.Popen(
        words,
        env=None if environment is None else dict(environment),
        stdin=subprocess.DEVNULL,
        stdout=out,
        stderr=errors,
        start_new_session=True,
        preexec_fn=_end_with(os.getpid()) if _libc is not None else None,
    )


def ending(code: int) -> str:
    """How a process with this exit code ended, in words."""
    try:
        return f"ended with exit code {code}" + (f" ({signal.Signals(-code).name})" if code < 0 else "")
    except ValueError:  # a signal without a name
        return f"ended with exit code {code}"


def _end_with(parent: int) -> Callable[[], None]:
    """What a child does before it becomes the program: ask for SIGTERM at its parent's death."""

    def ask() -> None:
        assert _libc is not None
        _libc.prctl(PR_SET_PDEATHSIG, signal.SIGTERM, 0, 0, 0)
        if os.getppid() != parent:  # it has died already
            os.kill(os.getpid(), signal.SIGTERM)

    return ask
