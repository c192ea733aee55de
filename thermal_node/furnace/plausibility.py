"""Which measured furnace temperatures are believed: by their range, and by how fast they change."""

from __future__ import annotations

import math
from dataclasses import dataclass

NOT_FINITE, TOO_LOW, TOO_HIGH, TOO_FAST = REASONS = (
    "not finite",
    "below furnace_lowest",
    "above furnace_highest",
    "changes too fast",
)


@dataclass(frozen=True)
class Limits:
    """What a furnace can do.

    Attributes
    ----------
    lowest, highest : °C
    rate : K/s of simulated time; 0: any
    jump : K that a value may be off from one to the next however soon it comes
    confirmations : so many values in a row that change too fast, but agree with each other, are believed
    """

    lowest: float = -40.0
    highest: float = 1360.0
    rate: float = 50.0
    jump: float = 60.0
    confirmations: int = 5


@dataclass(frozen=True)
class Refusal:
    """Why a value is not believed: one of REASONS, and a sentence."""

    reason: str
    sentence: str


class Plausibility:
    """Judges values as they come.

    A value that is off is refused.  What stays off is no slip of a thermocouple: after some values in a row
    that agree with each other the last is believed, so that a first value that was wrong is put right too.
    """

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.forget()

    def forget(self) -> None:
        """Begin anew: the next value is held against the range alone."""
        self._last: tuple[float, float] | None = None
        self._other: tuple[float, float] | None = None
        self._agreeing = 0

    def check(self, time: float, temperature: float) -> Refusal | None:
        """Judge a value, °C, that came at a simulated time, s; None: it is believed."""
        limits = self.limits
        if not math.isfinite(temperature):
            return Refusal(NOT_FINITE, "it is not finite")
        if temperature < limits.lowest:
            return Refusal(TOO_LOW, f"it is below furnace_lowest, {limits.lowest:g} °C")
        if temperature > limits.highest:
            return Refusal(
                TOO_HIGH,
                f"it is above furnace_highest, {limits.highest:g} °C (an open thermocouple of type K"
                " shows 1372 °C)",
            )
        here = time, temperature
        if self._last is None or self._near(self._last, here):
            self._last, self._other, self._agreeing = here, None, 0
            return None
        self._agreeing = self._agreeing + 1 if self._other and self._near(self._other, here) else 1
        self._other = here
        if self._agreeing >= limits.confirmations:
            self._last, self._other, self._agreeing = here, None, 0
            return None
        before, believed = self._last
        return Refusal(
            TOO_FAST,
            f"it is {abs(temperature - believed):.0f} K off the last believed, {believed:g} °C,"
            f" {max(0.0, time - before):.3g} s ago; furnace_jump and furnace_rate allow"
            f" {self._allowed(before, time):.0f} K",
        )

    def _allowed(self, before: float, time: float) -> float:
        rate = self.limits.rate or math.inf
        return self.limits.jump + rate * max(0.0, time - before) if math.isfinite(rate) else math.inf

    def _near(self, before: tuple[float, float], here: tuple[float, float]) -> bool:
        return abs(here[1] - before[1]) <= self._allowed(before[0], here[0])
