"""What a report needs of a bag, taken up while the bag is read once from its beginning to its end."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..bag import Bag, BagError
from ..bag.messages import Messages
from ..bag.table import Table

# A topic with more messages is thinned to these, and the report says so.
MOST = 1_500_000
STAMP = ["header.stamp.sec", "header.stamp.nanosec"]
Taker = Callable[[Messages], Any]


class Reading:
    """Fields of a bag's topics.

    Parameters
    ----------
    bag : Bag
    wanted : dict of topic to fields
        What is taken up as the bag is read; other topics are read when they are asked for.
    """

    def __init__(self, bag: Bag, wanted: dict[str, list[str]] | None = None) -> None:
        self.bag = bag
        self._tables: dict[str, Table] = {}
        for topic, fields in (wanted or {}).items():
            with suppress(BagError):  # is said when it is asked for
                self._tables[topic] = self._table(topic, fields)
        self._problems: dict[str, BagError] = {}
        self._took = False

    def takers(self) -> dict[str, Taker]:
        """Return what is to be called with each topic's messages, all of them and in order."""
        self._took = True
        return {topic: self._taker(topic, table) for topic, table in self._tables.items()}

    def columns(
        self, topic: str, fields: list[str]
    ) -> tuple[NDArray[np.int64], dict[str, NDArray[Any]], float]:
        """Return log times, ns since the epoch, the fields and stamps, if any, and the period of thinning, s.

        Raises
        ------
        BagError
            They can't be read.
        """
        table = self._tables.get(topic)
        if not self._took or table is None or not set(fields) <= set(table.fields):
            table = self._table(topic, fields)
            for messages in self.bag.read([topic], {topic: table.period}):
                table.add(messages[topic])
        elif topic in self._problems:
            raise self._problems[topic]
        return *table.columns(), table.period

    def _table(self, topic: str, fields: list[str]) -> Table:
        found = self.bag.topic(topic)
        period = self.bag.duration / MOST if found.count > MOST else 0.0
        stamps = STAMP if set(STAMP) <= set(self.bag.fields(topic)) else []
        return self.bag.table(topic, [*fields, *stamps], period, by_joint=True)

    def _taker(self, topic: str, table: Table) -> Taker:
        def take(messages: Messages) -> None:
            if topic not in self._problems:
                try:
                    table.add(messages)
                except BagError as problem:
                    self._problems[topic] = problem

        return take
