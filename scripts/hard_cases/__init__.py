"""The hard cases: scenes that break simulators, each with what must hold of it."""

from __future__ import annotations

from .case import Case


def all_cases() -> list[Case]:
    """Every case, in the order of the table."""
    from .doors import CASES as DOORS
    from .loads import CASES as LOADS
    from .losses import CASES as LOSSES
    from .mechanisms import CASES as MECHANISMS
    from .motions import CASES as MOTIONS
    from .robots import CASES as ROBOTS

    return [*ROBOTS, *MOTIONS, *LOADS, *LOSSES, *MECHANISMS, *DOORS]
