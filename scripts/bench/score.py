"""A run in numbers."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..controller.trajectory import Trajectory

Array = NDArray[np.float64]
# A run is lost where at its end a joint is off by more than this part of the longest way.
LOST = 0.5
# The tip has settled where it stays within this part of its way of where it comes to rest.
SETTLED = 0.005


@dataclass(frozen=True)
class Recording:
    """What a robot did in one run; K states, m joints.

    Attributes
    ----------
    time : (K,) s; position, velocity, effort : (K, m)
    tip : (K, 3) m, where the last link's end is; rigid_tip : where the rigid robot has it
    trouble : why the run ended before its time, or nothing
    missing : states on the way that did not reach the bench, so that the run can't be judged
    """

    time: Array
    position: Array
    velocity: Array
    effort: Array
    tip: Array
    rigid_tip: Array
    trouble: str = ""
    missing: int = 0


@dataclass(frozen=True)
class Score:
    """Numbers of one run, SI units.

    Attributes
    ----------
    tracking_rms, tracking_max : joints' errors while it moves
    final_error : the largest joint error in the last tenth of the run
    vibration : peak to peak of the tip's deflection from the rigid robot's, in its main direction, from 0.1 s
        after the move; how the joints come to rest is not in it
    settling : s from the move's end until the tip stays within 0.5 % of its way of where it comes to rest
    effort_rms, effort_max, energy : torques, and the sum of what each motor put in or took out, J
    lost : whether it did not arrive
    reason : why it is lost, or nothing
    """

    tracking_rms: float
    tracking_max: float
    final_error: float
    vibration: float
    settling: float
    effort_rms: float
    effort_max: float
    energy: float
    lost: bool
    reason: str = ""

    def as_dict(self) -> dict[str, Any]:
        """For programs."""
        return asdict(self)


def score(run: Recording, wanted: Trajectory, until: float) -> Score:
    """Judge a run that was to last until a time, s."""
    nothing = float("nan")
    if not len(run.time):
        why = run.trouble or "the robot showed no state"
        return Score(nothing, nothing, nothing, nothing, nothing, nothing, nothing, nothing, True, why)
    reference = np.array([wanted.at(t)[0] for t in run.time])
    error = run.position - reference
    moving = (run.time >= wanted.time[0]) & (run.time <= wanted.time[-1])
    settled = run.time >= wanted.time[-1] + 0.1
    end = run.time >= until - 0.1 * (until - wanted.time[-1])
    way = float(np.abs(wanted.position[-1] - wanted.position[0]).max())
    whole = not run.trouble and bool(end.any()) and bool(settled.any())
    final = float(np.abs(error[end]).max()) if end.any() else nothing
    vibration = nothing
    if settled.any():
        away = (run.tip - run.rigid_tip)[settled]
        away = away - away.mean(axis=0)
        main = np.linalg.svd(away, full_matrices=False)[2][0]  # the direction in which it swings most
        vibration = float(np.ptp(away @ main))
    step = np.diff(run.time, prepend=run.time[:1])
    reason = run.trouble
    if not reason and not whole:
        reason = "the robot showed no state at the end"
    elif not reason and not final < LOST * way:
        reason = f"a joint is {final:.3g} rad or m off at the end, more than {LOST:g} of its way"
    return Score(
        tracking_rms=float(np.sqrt(np.mean(error[moving] ** 2))) if moving.any() else nothing,
        tracking_max=float(np.abs(error[moving]).max()) if moving.any() else nothing,
        final_error=final,
        vibration=vibration,
        settling=settling(run, float(wanted.time[-1]), end) if whole else nothing,
        effort_rms=float(np.sqrt(np.mean(run.effort**2))),
        effort_max=float(np.abs(run.effort).max()),
        energy=float(np.sum(np.abs(run.effort * run.velocity) * step[:, None])),
        lost=bool(reason),
        reason=reason,
    )


def settling(run: Recording, moved: float, end: NDArray[np.bool_]) -> float:
    """How long after `moved`, s, the tip is still away from where it is in the end, on average."""
    away = np.linalg.norm(run.tip - run.tip[end].mean(axis=0), axis=1)
    late = run.time[away > SETTLED * away[0]]
    return max(0.0, float(late[-1]) - moved) if len(late) else 0.0
