"""One line on a terminal that says how far long work is."""

from __future__ import annotations

import sys
import time

from .plain import plain


class Progress:
    """Shows a line a few times a second on a terminal; nothing elsewhere."""

    PERIOD = 0.2

    def __init__(self) -> None:
        # Work that is over within the first period shows nothing.
        self._shown = time.monotonic()
        self._there = False

    def show(self, line: str) -> None:
        """Say how far it is."""
        now = time.monotonic()
        if sys.stderr.isatty() and now - self._shown >= self.PERIOD:
            print(f"\r\x1b[K{plain(line)}", end="", file=sys.stderr, flush=True)
            self._shown, self._there = now, True

    def clear(self) -> None:
        """Leave the line empty for what comes next."""
        if self._there:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
            self._there = False
