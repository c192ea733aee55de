"""Fields of a topic's messages as columns that grow while a bag is read."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .cdr import Decoder
from .errors import BagError
from .joints import JointDecoder
from .messages import Messages, Thinner


class Table:
    """Some fields of a topic, of all its messages or of at most one each `period`.

    Parameters
    ----------
    topic : str
    decoder : Decoder, of the topic's type
    fields : list of str
    room : int
        So many messages are expected; there may be more or fewer.
    period : float, s
        0 takes every message.
    """

    def __init__(
        self, topic: str, decoder: Decoder | JointDecoder, fields: list[str], room: int, period: float = 0.0
    ) -> None:
        self.topic, self.fields, self.period = topic, fields, period
        self._decoder = decoder
        self._room, self._filled = room, 0
        self._keep = Thinner(period)
        self._time: NDArray[np.int64] = np.empty(0, np.int64)
        self._values: dict[str, NDArray[Any]] = {}

    def add(self, messages: Messages) -> None:
        """Take up messages; raises BagError where their fields do not fit those before."""
        if isinstance(self._decoder, JointDecoder):
            messages = self._decoder.mine(messages)
        some = self._keep(messages)
        more = len(some)
        if not more:
            return
        columns = self._decoder.columns(some, self.fields)
        if not self._filled:
            # As many as are expected, so that what is read is not held twice.
            room = self._room = max(more, self._room)
            self._time = np.empty(room, np.int64)
            self._values = {n: np.empty((room, *v.shape[1:]), v.dtype) for n, v in columns.items()}
        elif self._filled + more > self._room:
            self._room = 2 * self._room + more
            self._time = enlarged(self._time, self._filled, self._room)
            self._values = {n: enlarged(v, self._filled, self._room) for n, v in self._values.items()}
        part = slice(self._filled, self._filled + more)
        self._time[part] = some.log_time
        for name, column in columns.items():
            if column.shape[1:] != self._values[name].shape[1:]:
                raise BagError(changing(self.topic, name))
            self._values[name][part] = column
        self._filled += more

    def columns(self) -> tuple[NDArray[np.int64], dict[str, NDArray[Any]]]:
        """Return log times (K,), ns since the epoch, and the fields' values, (K,) or (K, n)."""
        if not self._filled:
            return np.empty(0, np.int64), {name: np.empty(0) for name in self.fields}
        return self._time[: self._filled], {n: v[: self._filled] for n, v in self._values.items()}


def enlarged(values: NDArray[Any], filled: int, room: int) -> NDArray[Any]:
    """Return an array with more room, that holds the same."""
    found = np.empty((room, *values.shape[1:]), values.dtype)
    found[:filled] = values[:filled]
    return found


def changing(topic: str, name: str) -> str:
    """Say that a field cannot be one array."""
    return f"the length of '{name}' changes within {topic}; read its messages one by one"
