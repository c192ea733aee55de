"""A run that is driven again is recorded to its last message."""

from types import SimpleNamespace

import pytest
from flexsim.replay import again


class Busy:
    """A recorder whose robot has messages on their way for a while, each behind a pause."""

    def __init__(self, drains: int) -> None:
        self.left = drains
        self.topics = {again.WAITED_FOR[0]: SimpleNamespace(count=0)}

    def drain(self, *, everything: bool) -> None:
        assert everything
        if self.left > 0:
            self.left -= 1
            self.topics[again.WAITED_FOR[0]].count += self.left % 3 == 0


class Clock:
    """Time that goes on while someone sleeps, however busy the machine is."""

    now = 0.0

    def monotonic(self) -> float:
        return self.now

    def sleep(self, duration: float) -> None:
        self.now += duration


def test_what_is_still_on_its_way_is_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    """For longer than the pause that ends it, as long as something comes; not for ever."""
    clock = Clock()
    monkeypatch.setattr(again, "time", clock)
    recorder = Busy(60)
    again.keep_last(recorder)
    assert (recorder.left, recorder.topics[again.WAITED_FOR[0]].count) == (0, 20)
    begun = clock.now
    again.keep_last(Busy(10**6))
    assert again.LONGEST <= clock.now - begun < again.LONGEST + again.QUIET
