"""Reads diagnostic_msgs/DiagnosticArray: words of changing length, so each message by itself."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from dataclasses import dataclass

from .errors import BagError

TYPE = "diagnostic_msgs/msg/DiagnosticArray"
OK, WARN, ERROR = 0, 1, 2
LEVELS = {0: "ok", 1: "warning", 2: "error", 3: "stale"}


@dataclass(frozen=True)
class Status:
    """One status: its level, its name, its message, its values by key, its stamp in s, and of what it tells.

    A simulator tells of its scene, by the scene's name.
    """

    stamp: float
    level: int
    name: str
    message: str
    values: dict[str, str]
    hardware: str = ""

    def number(self, key: str) -> float | None:
        """Return a value as a number; None where it is none."""
        try:
            return float(self.values[key])
        except (KeyError, ValueError):
            return None


def statuses(data: bytes) -> list[Status]:
    """Return what a message says; raises BagError where it is cut off."""
    try:
        return list(_read(data))
    except (struct.error, IndexError) as problem:
        raise BagError(f"a {TYPE} message is cut off: {problem}") from None


def _read(data: bytes) -> Iterator[Status]:
    order = {b"\0\1": "<", b"\0\0": ">"}.get(data[:2])
    if order is None:
        raise BagError(f"a {TYPE} message is not CDR")
    at = 4

    def number() -> int:
        nonlocal at
        at += -at % 4
        (value,) = struct.unpack_from(f"{order}I", data, at)
        at += 4
        return int(value)

    def text() -> str:
        nonlocal at
        length = number()
        at += length
        if at > len(data):
            raise IndexError("a text is longer than the message")
        return data[at - length : at].rstrip(b"\0").decode("utf-8", "replace")

    stamp = number() + 1e-9 * number()
    text()
    for _ in range(number()):
        level = data[at]
        at += 1
        name, message, hardware = text(), text(), text()
        values = {}
        for _ in range(number()):
            key = text()
            values[key] = text()
        yield Status(stamp, level, name, message, values, hardware)
