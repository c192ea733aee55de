"""How the stepping thread does, in numbers."""

from __future__ import annotations

from dataclasses import dataclass

from ..motion.validity import Finding


@dataclass(frozen=True)
class Report:
    """How a loop does; times in s, counts since it started.

    Attributes
    ----------
    phase : "waiting" for the first command, "running", "paused", or "stopped" by the solver
    status : "ok", or why the solver stopped
    time : simulated
    real_time_factor, recent_factor : simulated over elapsed time while time goes on, and in the last second
    longest_run : most overruns in a row, before the deadlines were kept again
    step_p50, step_p99, step_worst : one step of the solver
    tick_p99, tick_worst : all work between two deadlines, publishing included
    late_p99, late_worst : from a deadline to the beginning of its work
    energy : kinetic, elastic, gravitational, J
    conditioning : of closed loops, the least since the last report; None without loops
    warning : what a user should know of a robot that still runs
    validity : the largest of each figure of the validity watch since the last report
    """

    phase: str = "waiting"
    status: str = "ok"
    time: float = 0.0
    real_time_factor: float = 0.0
    recent_factor: float = 0.0
    ticks: int = 0
    overruns: int = 0
    recent_overruns: int = 0
    longest_run: int = 0
    lost: float = 0.0
    step_p50: float = 0.0
    step_p99: float = 0.0
    step_worst: float = 0.0
    tick_p99: float = 0.0
    tick_worst: float = 0.0
    late_p99: float = 0.0
    late_worst: float = 0.0
    timeouts: int = 0
    real_time_priority: bool = False
    energy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    conditioning: float | None = None
    warning: str = ""
    validity: tuple[Finding, ...] = ()
