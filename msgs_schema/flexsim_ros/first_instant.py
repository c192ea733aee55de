"""SIGINT and SIGTERM while Python itself starts: `python -m flexsim_ros.first_instant` sets it up.

Python knows a signal's default alone until a program sets a handler, and reads the .pth files of its
environment before: the ROS wheels' one executes Python anew.  Two further .pth files see to our programs:
the first of all has signals wait, and the one behind ours, which finds this module, answers them.  What is
left is Python's own first twenty milliseconds, before it reads any file.  Here are no imports that take time.
"""

from __future__ import annotations

import _signal  # signal itself takes some milliseconds
import os
import sys

SIGNALS = (_signal.SIGINT, _signal.SIGTERM)
# Exit codes of a program that is stopped before it has begun: of scripts by name, of modules (python -m).
SCRIPTS = {"flexsim_node": 0, "thermal_node": 0, "flexsim": 130}
MODULES = {"flexsim_node.node": 0, "thermal_node.node": 0, "flexsim.controller": 0,
           "flexsim.controller.follow": 0}  # fmt: skip
COMMAND = "from flexsim.cli import main; main()"
# In the order in which Python reads them; what is behind __editable__ finds our packages.
FILES = {
    "0_flexsim_signals.pth": "import sys, _signal; any('flexsim' in w or 'thermal_node' in w"
    " for w in sys.orig_argv[1:4]) and _signal.pthread_sigmask(_signal.SIG_BLOCK, (2, 15))",
    "_flexsim_signals.pth": "import _signal; exec('try:\\n from flexsim_ros.first_instant import begin"
    "\\n begin()"
    "\\nexcept Exception:\\n _signal.pthread_sigmask(_signal.SIG_UNBLOCK, (2, 15))')"
    " if _signal.pthread_sigmask(_signal.SIG_BLOCK, ()) else None",
}


def begin() -> None:
    """Let signals end the process, if it is one of our programs; before Python is executed anew they wait."""
    code = code_of(sys.orig_argv)
    if code is None:
        _signal.pthread_sigmask(_signal.SIG_UNBLOCK, SIGNALS)
    elif os.environ.get("_ROS_WHEELS_BOOTSTRAP_COMPLETE"):
        leave_at_signals(code)


def code_of(words: list[str]) -> int | None:
    """Exit code of a program of ours that is stopped before it has begun, by Python's command line."""
    rest = iter(words[1:])
    for word in rest:
        if word == "-m":
            return MODULES.get(next(rest, ""))
        if word == "-c":
            return SCRIPTS["flexsim"] if COMMAND in next(rest, "") else None
        if word in ("-X", "-W"):
            next(rest, "")
        elif not word.startswith("-"):
            return SCRIPTS.get(word.rpartition("/")[2])
    return None


def leave_at_signals(code: int) -> None:
    """Let SIGINT and SIGTERM end the process on the spot with this exit code; for the main thread."""
    for number in SIGNALS:
        _signal.signal(number, lambda *_: os._exit(code))
    _signal.pthread_sigmask(_signal.SIG_UNBLOCK, SIGNALS)


def set_up() -> None:
    """Write the files into this Python's environment."""
    import sysconfig
    from pathlib import Path

    for name, line in FILES.items():
        Path(sysconfig.get_path("purelib"), name).write_text(line + "\n", encoding="utf-8")


if __name__ == "__main__":
    set_up()
