"""Joint states by joint name: an arm's and a gripper's on one topic, and joints whose order changes."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .cdr import Decoder
from .messages import Messages

TYPE = "sensor_msgs/msg/JointState"
QUANTITIES = ("position", "velocity", "effort")
Names = tuple[str, ...]


class JointDecoder:
    """Decodes the joint states of one set of joints, each quantity in one order of them.

    Parameters
    ----------
    decoder : Decoder, of the topic
    names : (m,) those whose states are wanted, in the order that is wanted
    others : further sets of joints on the topic
    where : what to name in a warning
    """

    def __init__(self, decoder: Decoder, names: Names, others: list[Names], where: str) -> None:
        self.decoder, self.names, self.others, self.where = decoder, names, others, where
        self._warned = False
        self._told: tuple[Messages, NDArray[Any]] | None = None

    def mine(self, messages: Messages) -> Messages:
        """Return the messages of these joints."""
        messages = self.decoder.only(messages, TYPE)
        if not len(messages):
            return messages
        own = sorted(self.names)
        told = self._names(messages)
        if one_list(told) and sorted(told[0]) == own:
            return messages
        keep = np.array([sorted(names) == own for names in told], dtype=bool)
        if keep.all():
            return messages
        if self.others and not self._warned:
            self._warned = True
            others = "; ".join(", ".join(some) for some in self.others)
            what = f"{self.where} has states of {', '.join(self.names)}, which are taken, and of {others}"
            warnings.warn(what, UserWarning, stacklevel=4)
        return messages[keep]

    def columns(self, messages: Messages, fields: list[str]) -> dict[str, NDArray[Any]]:
        """Return some fields of messages of these joints, as `Decoder.columns`, by joint."""
        if not set(fields) & {"name", *QUANTITIES}:
            return self.decoder.columns(messages, fields)
        columns = self.decoder.columns(messages, [name for name in fields if name != "name"])
        told = columns["name"] = self._names(messages)
        if len(told) and not (one_list(told) and tuple(told[0]) == self.names):
            self._turn(columns, told)
        return {name: columns[name] for name in fields}

    def _names(self, messages: Messages) -> NDArray[Any]:
        """Return each message's names; whoever asks whose messages are asks for their states next."""
        if self._told is None or self._told[0] is not messages:
            self._told = messages, self.decoder.columns(messages, ["name"])["name"]
        return self._told[1]

    def _turn(self, columns: dict[str, NDArray[Any]], told: NDArray[Any]) -> None:
        """Put what is by joint into the order of `names`."""
        order = np.array([[list(n).index(own) for own in self.names] for n in told], dtype=np.int64)
        for name in QUANTITIES:
            if name in columns and columns[name].shape == order.shape:
                columns[name] = np.take_along_axis(columns[name], order, axis=1)
        names = np.empty(len(told), dtype=object)
        names.fill(list(self.names))
        columns["name"] = names


def one_list(told: NDArray[Any]) -> bool:
    """Say whether all messages share one list of names, as mostly."""
    return len(set(map(id, told))) == 1


def sets_of(decoder: Decoder, messages: Messages) -> list[Names]:
    """Return the sets of joints that messages tell of, each in the order in which it came first."""
    messages = decoder.only(messages, TYPE)
    if not len(messages):
        return []
    found: dict[Names, Names] = {}
    before: Any = None
    for names in decoder.columns(messages, ["name"])["name"]:
        if names is not before:
            found.setdefault(tuple(sorted(names)), tuple(names))
            before = names
    return list(found.values())
