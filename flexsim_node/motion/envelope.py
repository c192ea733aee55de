"""The envelope that `auto` was decided over, and whether a motion is still within it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

ROOM = 0.05  # of an envelope's width, beside it: what is left out moves a little, samples miss peaks


@dataclass(frozen=True)
class Envelope:
    """Poses, speeds, torques and time that the decision's own runs went through.

    Attributes
    ----------
    joints : (m,) names
    low, high : (m,) rad or m; speed : (m,) rad/s or m/s; torque : (m,) N m or N, both by their size
    duration : s
    left_out : effects that may matter outside, the most important first
    formulation : that which may not hold outside, where it was decided too, or ""
    """

    joints: tuple[str, ...]
    low: np.ndarray
    high: np.ndarray
    speed: np.ndarray
    torque: np.ndarray
    duration: float
    left_out: tuple[str, ...]
    formulation: str = ""

    def beyond(self, time: float, position: np.ndarray, speed: np.ndarray, torque: np.ndarray) -> str:
        """What has left the envelope, with the figure and the effects that are missing then; else "".

        time : s; position, speed, torque : (m,)
        """
        size = np.abs(torque)
        if time > self.duration and time > self.duration * (1.0 + ROOM):
            return self._said(f"{time:.4g} s is beyond the {self.duration:g} s")
        for values, limit, what, unit in (
            (size, self.torque, "torque", "N m or N"),
            (np.abs(speed), self.speed, "speed", "rad/s or m/s"),
        ):
            if (values > limit).any():
                k = int(np.argmax(values - limit))
                return self._said(
                    f"{self.joints[k]}'s {what} reaches {values[k]:.3g} {unit} at {time:.4g} s, beyond"
                    f" the {limit[k]:.3g}"
                )
        if (position < self.low).any() or (position > self.high).any():
            k = int(np.argmax(np.maximum(self.low - position, position - self.high)))
            return self._said(
                f"{self.joints[k]} is at {position[k]:.3g} rad or m at {time:.4g} s, outside"
                f" the {self.low[k]:.3g} to {self.high[k]:.3g}"
            )
        return ""

    def _said(self, what: str) -> str:
        decided = " and ".join(
            [*(["the formulation"] if self.formulation else []), *(["effects"] if self.left_out else [])]
        )
        said = []
        if self.formulation:
            said.append(f"{self.formulation} may be off by more than the tolerance: give co_moving")
        if self.left_out:
            said.append(f"left out are {', '.join(self.left_out)}: switch them on")
        return (
            f"auto: {what} that {decided} {'were' if self.left_out else 'was'} decided over;"
            f" {'; '.join(said)}, or decide with a motion like this one (torque, duration, auto.margin)"
        )


def hull(
    joints: tuple[str, ...],
    motions: Iterable[tuple[np.ndarray, np.ndarray, np.ndarray]],
    duration: float,
    left_out: tuple[str, ...],
    formulation: str = "",
) -> Envelope:
    """The envelope of motions: positions, speeds and torques, (K, m) each."""
    several = list(motions)
    low = np.min([q.min(axis=0) for q, _, _ in several], axis=0)
    high = np.max([q.max(axis=0) for q, _, _ in several], axis=0)
    speed = np.max([np.abs(v).max(axis=0) for _, v, _ in several], axis=0)
    torque = np.max([np.abs(u).max(axis=0) for _, _, u in several], axis=0)
    room = ROOM * (high - low) + 1e-9
    return Envelope(
        joints,
        low - room,
        high + room,
        (1 + ROOM) * speed + 1e-9,
        (1 + ROOM) * torque + 1e-9,
        duration,
        left_out,
        formulation,
    )


def common(one: Envelope, other: Envelope | None) -> Envelope:
    """What lies in both envelopes, and what may be missing outside of it."""
    if other is None:
        return one
    return Envelope(
        one.joints,
        np.maximum(one.low, other.low),
        np.minimum(one.high, other.high),
        np.minimum(one.speed, other.speed),
        np.minimum(one.torque, other.torque),
        min(one.duration, other.duration),
        one.left_out or other.left_out,
        one.formulation or other.formulation,
    )
