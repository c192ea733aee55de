"""How a run stands: it goes on, or it has stopped and says why."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class State(Enum):
    """What a run came to."""

    RUNNING = "running"
    BEYOND_TABLE = "beyond a table's end"
    NOT_CONVERGED = "did not converge"
    NOT_FINITE = "not finite"


@dataclass(frozen=True)
class Status:
    """State, and the reason in one line where the run has stopped."""

    state: State = State.RUNNING
    reason: str = ""

    @property
    def ok(self) -> bool:
        """Whether the run goes on."""
        return self.state is State.RUNNING

    def __str__(self) -> str:
        return self.reason or self.state.value
