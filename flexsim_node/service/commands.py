"""Torque commands: taken whole or refused whole, and counted either way."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np

LENGTH, NOT_FINITE, UNKNOWN_JOINT, REPEATED_JOINT, PASSIVE_JOINT, TOO_MANY, UNKNOWN_LINK = REASONS = (
    "wrong length",
    "not finite",
    "unknown joint",
    "joint named twice",
    "passive joint",
    "too many at once",
    "unknown link",
)


class CommandRefused(ValueError):
    """A command that can't be: what is wrong, and what would be right."""

    def __init__(self, reason: str, sentence: str) -> None:
        super().__init__(sentence)
        self.reason = reason


class Commands:
    """Checks commands for a robot with these joints, and remembers the last good one.

    Parameters
    ----------
    joint_names : in the scene's order
    passive : those of them without a motor, which take no torque but zero
    links : names of the links that loads may act on

    Attributes
    ----------
    torque : (m,) the last good command, N m; N for joints that slide
    accepted : int
    refused : count by reason
    """

    def __init__(
        self, joint_names: Sequence[str], passive: Sequence[str] = (), links: Sequence[str] = ()
    ) -> None:
        self.joint_names = tuple(joint_names)
        self.passive = tuple(passive)
        self.links = tuple(links)
        self.index = {name: k for k, name in enumerate(self.joint_names)}
        self.torque = np.zeros(len(self.joint_names))
        self.accepted = 0
        self.refused = Counter(dict.fromkeys(REASONS, 0))

    def in_order(self, values: Sequence[float]) -> np.ndarray:
        """Take torques in the scene's joint order.

        Raises
        ------
        CommandRefused
            for another number of values than joints, one that is not finite, or a torque on a passive joint
        """
        torque = np.array(values, dtype=float)
        if torque.shape != self.torque.shape:
            raise self._refusal(
                LENGTH,
                f"{torque.size} values for {len(self.joint_names)} joints; give one for each of "
                + ", ".join(self.joint_names),
            )
        return self._taken(torque)

    def by_name(self, names: Sequence[str], effort: Sequence[float]) -> np.ndarray:
        """Take torques of the named joints; the others keep theirs.

        Raises
        ------
        CommandRefused
            for names and efforts of different number, or none at all; a joint that is unknown
            or named twice; a value that is not finite; a torque on a passive joint
        """
        if len(names) != len(effort) or not names:
            raise self._refusal(
                LENGTH, f"{len(effort)} efforts for {len(names)} names; give one effort a name"
            )
        unknown = [name for name in names if name not in self.index]
        if unknown:
            raise self._refusal(
                UNKNOWN_JOINT, f"no joint {unknown[0]!r}; there are {', '.join(self.joint_names)}"
            )
        if len(set(names)) != len(names):
            raise self._refusal(REPEATED_JOINT, "a joint is named twice; name each once")
        torque = self.torque.copy()
        torque[[self.index[name] for name in names]] = effort
        return self._taken(torque)

    def load(self, link: str, values: Sequence[float]) -> np.ndarray:
        """Take a force and moment (6,), N and N m, on the named link's end.

        Raises
        ------
        CommandRefused
            for a link that is unknown, or a value that is not finite
        """
        if link not in self.links:
            raise self._refusal(
                UNKNOWN_LINK,
                f"no link {link!r}; name one as the header's frame_id: {', '.join(self.links)}",
            )
        load = np.array(values, dtype=float)
        if not np.isfinite(load).all():
            raise self._refusal(NOT_FINITE, "a value is not finite; give finite forces and moments")
        self.accepted += 1
        return load

    def too_many(self) -> CommandRefused:
        """Take back a command for which there was no room; returns what to say."""
        self.accepted -= 1
        return self._refusal(TOO_MANY, "too many commands wait; send one a state")

    def release(self) -> None:
        """Let go: joints that the next command by name does not name have no torque."""
        self.torque = np.zeros(len(self.joint_names))

    def _taken(self, torque: np.ndarray) -> np.ndarray:
        if not np.isfinite(torque).all():
            raise self._refusal(NOT_FINITE, "a value is not finite; give finite torques")
        for name in self.passive:
            if torque[self.index[name]] != 0.0:
                raise self._refusal(PASSIVE_JOINT, f"{name} is passive, it has no motor; give it zero")
        self.torque = torque
        self.accepted += 1
        return torque

    def _refusal(self, reason: str, sentence: str) -> CommandRefused:
        self.refused[reason] += 1
        return CommandRefused(reason, sentence)
