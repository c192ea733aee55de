"""One criterion: a value that must not exceed its limit, and when it did."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class Criterion:
    """One criterion: its value and limit in `unit`; when it failed, s, or None.

    clause : where the limit comes from; kind : insulation (with its class), integrity, radiation or own
    until : s after which it is not judged
    """

    name: str
    unit: str
    limit: float
    value: float = 0.0
    time_of_failure: float | None = None
    clause: str = ""
    kind: str = "own"
    until: float = float("inf")
    watched: bool = False
    _past: list[tuple[float, float]] = field(default_factory=list)

    @property
    def failed(self) -> bool:
        """Whether the limit has ever been exceeded."""
        return self.time_of_failure is not None

    def watch(self, time: float, value: float) -> None:
        """Take a value at a time, s; a failure lies on the parabola through the last three."""
        if time > self.until + 1e-9:
            return
        if self.time_of_failure is None and value > self.limit:
            self.time_of_failure = _crossing([*self._past, (time, value)], self.limit)
        self._past = [*self._past[-1:], (time, value)]
        self.value, self.watched = value, True


def _crossing(past: list[tuple[float, float]], limit: float) -> float:
    """When a value crossed its limit, between the last two of (time, value)."""
    end, last = past[-1]
    if len(past) < 2:
        return end
    begin, first = past[-2]
    if end <= begin or first > limit:
        return begin
    slope = (last - first) / (end - begin)
    bend = 0.0
    if len(past) > 2 and begin > past[0][0]:
        bend = (slope - (first - past[0][1]) / (begin - past[0][0])) / (end - past[0][0])
    # first + slope s + bend s (s - span) = limit on 0..span, where it grows from below to above.
    low, high = 0.0, end - begin
    span = high
    for _ in range(60):
        middle = 0.5 * (low + high)
        if first + middle * (slope + bend * (middle - span)) > limit:
            high = middle
        else:
            low = middle
    return begin + 0.5 * (low + high)
