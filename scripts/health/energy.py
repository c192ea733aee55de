"""Whether a recorded robot's energy can have come from where it says: the work of its joints.

Between two reports the energy (kinetic, elastic, gravitational) may grow by no more than what the
joints' torques did: losses only take away. The effort of a joint state is the torque that was in
force since the state before it, so the work between two states is exactly effort times the way.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

# What may go wrong without anything being wrong: parts of the work that was done back and forth, of the
# kinetic energy (an integrator's error; what Rayleigh's alpha gives the joints), and of the energies that
# were reported with nine digits.
PART_OF_WORK, PART_OF_MOTION, PART_OF_ENERGY = 0.02, 1e-3, 1e-6
# Between two reports at most this part of the time may lack joint states.
MOST_LACKING = 0.02


@dataclass(frozen=True)
class Gain:
    """Energy that nothing accounts for: when, s since the bag's start, simulated time, s, and how much, J."""

    at: float
    time: float
    gained: float
    work: float

    def sentence(self) -> str:
        """Say it."""
        return (
            f"the energy grew by {self.gained:.4g} J while the joints' torques did {self.work:.4g} J of work;"
            " something else drives the robot, or the integration gains energy: try a smaller step"
        )


def gains(
    energy: list[tuple[float, float, float, float]],
    time: NDArray[np.float64],
    position: NDArray[np.float64],
    effort: NDArray[np.float64],
) -> list[Gain]:
    """Return the reports before which the energy grew by more than the work done.

    Parameters
    ----------
    energy : list of (time of the bag, simulated time, energy, kinetic energy)
    time : ndarray (K,), simulated s, rising
    position, effort : ndarray (K, m)
    """
    if len(time) < 2 or position.shape != effort.shape:
        return []
    part = np.sum(effort[1:] * np.diff(position, axis=0), axis=1)
    if not np.isfinite(part).all():
        return []
    work = np.concatenate([[0.0], np.cumsum(part)])
    gross = np.concatenate([[0.0], np.cumsum(np.abs(part))])
    period = float(np.median(np.diff(time)))
    found = []
    for (_, t0, e0, k0), (at, t1, e1, k1) in pairwise(energy):
        a, b = np.searchsorted(time, [t0 - 0.5 * period, t1 - 0.5 * period])
        if t1 <= t0 or b >= len(time) or abs(time[a] - t0) > period or abs(time[b] - t1) > period:
            continue
        if (b - a) * period < (1.0 - MOST_LACKING) * (t1 - t0):
            continue
        done, allowed = float(work[b] - work[a]), PART_OF_WORK * float(gross[b] - gross[a])
        allowed += PART_OF_MOTION * max(k0, k1) + PART_OF_ENERGY * (abs(e0) + abs(e1)) + 1e-9
        if e1 - e0 > done + allowed:
            found.append(Gain(at, t1, e1 - e0, done))
    return found
