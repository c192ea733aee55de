"""Where torques, faults, wrenches and prescribed motions jump, and how steps are divided there.

A step across a jump is of first order whatever the method: the parabola through a step's torques does not
know where in the step they changed.  A step that ends at the jump, with the torque before it, and one that
begins there, with the torque after it, keep the method's order.
"""

from __future__ import annotations

import bisect
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..scene.schema import Scene

SLACK = 1e-6  # of a step: jumps this near to its start or end are there


@dataclass(frozen=True)
class Piece:
    """A part of a step, or the whole of it.

    begin, end : s, where what acts is read; just before the jump where the piece ends in one
    length : s
    jumped : whether it begins with a jump, after which the method begins anew
    """

    begin: float
    end: float
    length: float
    jumped: bool


class Jumps:
    """Times of jumps, s, by which steps are divided; those at or before 0 are the start itself."""

    def __init__(self, times: Iterable[float] = ()) -> None:
        self.times = sorted({float(t) for t in times if np.isfinite(t) and t > 0.0})

    def __bool__(self) -> bool:
        return bool(self.times)

    def after(self, t: float) -> float:
        """The first jump later than t; infinite where there is none."""
        k = bisect.bisect_right(self.times, t)
        return self.times[k] if k < len(self.times) else np.inf

    def pieces(self, t: float, h: float) -> list[Piece]:
        """Divide the step from t to t + h."""
        if not self.times:
            return [Piece(t, t + h, h, False)]
        near, end = SLACK * h, t + h
        first = bisect.bisect_left(self.times, t - near)
        last = bisect.bisect_right(self.times, end + near)
        begin, jumped, found = t, False, []
        for jump in self.times[first:last]:
            if jump <= t + near:
                begin, jumped = max(t, jump), True
            elif jump < end - near:
                found.append(Piece(begin, float(np.nextafter(jump, -np.inf)), jump - begin, jumped))
                begin, jumped = jump, True
            else:
                before = float(np.nextafter(jump, -np.inf))
                found.append(Piece(begin, min(end, before), end - begin, jumped))
                return found
        found.append(Piece(begin, end, h if begin == t else end - begin, jumped))
        return found


def torque_jumps(scene: Scene, kinks: bool = False) -> list[float]:
    """Times at which the scene's own torques jump, s; with `kinks` also where a slope does.

    A kink leaves a method its order two, but lets the error depend on where in a step it falls.
    """
    found: list[float] = []
    for entry in scene.torque:
        found.append(entry.start)
        if entry.end is not None:
            found.append(entry.end)
        if kinks:
            found += entry.time
    return sorted({t for t in found if t > 0.0})
