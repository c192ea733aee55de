"""Single keys from a terminal, read without waiting."""

from __future__ import annotations

import os
import select
import sys
from collections.abc import Iterator
from contextlib import contextmanager


class Keys:
    """Gives the keys that were pressed; without a terminal there are none."""

    def __init__(self, number: int | None) -> None:
        self._number = number

    def __call__(self) -> str:
        """Return the keys since the last call."""
        pressed = ""
        while self._number is not None and select.select([self._number], [], [], 0.0)[0]:
            read = os.read(self._number, 64)
            if not read:
                self._number = None
                break
            pressed += read.decode("utf-8", "replace")
        return pressed


@contextmanager
def keys() -> Iterator[Keys]:
    """Take keys from the terminal one by one, and give it back afterwards as it was."""
    if not sys.stdin.isatty():
        yield Keys(None)
        return
    import termios
    import tty

    number = sys.stdin.fileno()
    before = termios.tcgetattr(number)
    try:
        tty.setcbreak(number)
        yield Keys(number)
    finally:
        termios.tcsetattr(number, termios.TCSADRAIN, before)
