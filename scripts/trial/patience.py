"""How long somebody is waited for who says nothing: not at all as long as it works."""

from __future__ import annotations

import os
import time
from pathlib import Path

LOOK_PERIOD = 0.5  # s
TICK = 1.0 / os.sysconf("SC_CLK_TCK")  # s, in which Linux counts the time that a process has computed


class Patience:
    """Patience with a silent process, which does not depend on how fast or busy the machine is.

    Time in which the process, or another of its session, computes or waits for a processor or the disk does
    not count.

    Parameters
    ----------
    session : int
        The process's number, who leads a session of its own.
    idle : float, s
        How long it may do nothing.
    longest : float, s
        How long it may be silent whatever it does.
    """

    def __init__(self, session: int, idle: float, longest: float) -> None:
        self.session = session
        self.restart(idle, longest)

    def restart(self, idle: float, longest: float) -> None:
        """Begin anew: it was heard."""
        self.idle, self.longest = idle, longest
        self._begun = self._looked = time.monotonic()
        self._work: float | None = None  # until the first look, so that a word a millisecond costs nothing
        self._idle = 0.0

    @property
    def over(self) -> bool:
        """Whether nothing can be expected any more; looks at the process twice a second."""
        now = time.monotonic()
        if now - self._looked >= LOOK_PERIOD:
            work, busy = working(self.session)
            if self._work is not None and not busy:
                self._idle += max(0.0, now - self._looked - max(0.0, work - self._work))
            self._looked, self._work = now, work
        return self._idle >= self.idle or now - self._begun > self.longest


def working(session: int) -> tuple[float, bool]:
    """How long the processes of a session have computed so far, s, and whether one has work just now."""
    total, busy = 0.0, False
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = after_name(stat)
            if int(fields[3]) != session:
                continue
            total += TICK * (int(fields[11]) + int(fields[12]))
            busy |= any(after_name(thread)[0] in "RD" for thread in stat.parent.glob("task/*/stat"))
        except (OSError, ValueError, IndexError):  # it has ended meanwhile
            continue
    return total, busy


def after_name(stat: Path) -> list[str]:
    """Fields of /proc/PID/stat behind the name, which may hold blanks: state, parent, group, session, ..."""
    return stat.read_text().rpartition(")")[2].split()
