"""Decodes many CDR messages at once, each by the definition of its own channel.

Messages of a robot repeat their shape: the same names, the same array lengths. So one message is
walked to find where each field lies; every other message of that shape is then sliced, not decoded.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import BagError
from .layout import EndlessType, Layout, walk
from .messages import Messages, of_list
from .schema import Types, types_of

# Shapes that are kept of one type: so many of one size, and so many numbers in all of them together.
MOST_SHAPES, MOST_KEPT = 16, 1 << 18

# Which of some messages share a layout, None where all do; the layout; and they.
Group = tuple[NDArray[np.intp] | None, Layout, Messages]


class Decoder:
    """Slices the messages of one type into columns.

    Parameters
    ----------
    type_name : str
        `pkg/msg/Type`.
    schema : str
        Its definition with all dependencies.
    encoding : str
        What language that is: "ros2msg", "ros2idl" or "omgidl".

    Raises
    ------
    BagError
        The definition can't be read.
    """

    def __init__(self, type_name: str, schema: str, encoding: str = "ros2msg") -> None:
        self.type = type_name
        self.types = types_of(type_name, encoding, schema)
        self._layouts: OrderedDict[int, list[Layout]] = OrderedDict()
        self._kept = 0
        self._endless: EndlessType | None = None
        self._sorted: tuple[Messages, list[Group]] | None = None

    @property
    def definition(self) -> tuple[str, Types] | None:
        """The type and what it consists of; None where there are several."""
        return self.type, self.types

    def columns(
        self, messages: list[bytes] | Messages, fields: list[str], *, views: bool = False
    ) -> dict[str, NDArray[Any]]:
        """Return some fields of K messages.

        views : whether numbers may be views of the messages' buffer, which then lives as long as they do

        Returns
        -------
        dict of field to ndarray
            (K,) for a scalar, (K, n) for an array; text and lists of text as objects (K,).

        Raises
        ------
        BagError
            The messages have no such field, or its length differs among them.
        """
        found = of_list(messages) if isinstance(messages, list) else messages
        columns: dict[str, NDArray[Any]] = {}
        for index, layout, some in self.groups(found):
            for name in fields:
                cut = layout.cut(name, some, views)
                if index is None:  # all are alike
                    columns[name] = cut
                    continue
                if name not in columns:
                    columns[name] = np.empty((len(found), *cut.shape[1:]), dtype=cut.dtype)
                elif columns[name].dtype != cut.dtype:
                    both = np.promote_types(columns[name].dtype, cut.dtype)
                    columns[name] = columns[name].astype(both)
                if columns[name].shape[1:] != cut.shape[1:]:
                    raise BagError(f"the length of '{name}' changes among {self.type} messages")
                columns[name][index] = cut
        return columns

    def groups(self, messages: Messages) -> list[Group]:
        """Sort messages by shape.

        Returns
        -------
        list of (index (k,) or None, Layout, Messages)
            Which messages share the layout; None where all do.
        """
        # Whoever reads a bag for several purposes asks for the same messages several times.
        if self._sorted is not None and self._sorted[0] is messages:
            return self._sorted[1]
        found = self._grouped(messages) if len(messages) else []
        self._sorted = messages, found
        return found

    def only(self, messages: Messages, kind: str) -> Messages:
        """Return the messages that are of a type; a topic may have several."""
        return messages if self.type == kind else messages[:0]

    def fields(self, messages: Messages) -> list[str]:
        """Return the names of the fields of the first of some messages."""
        return [name for _, layout, _ in self.groups(messages[:1]) for name in layout.fields]

    def layout(self, message: bytes) -> Layout:
        """Walk one message and note where each field lies."""
        if self._endless is not None:
            raise self._endless
        try:
            return walk(self.type, self.types, message)
        except EndlessType as problem:
            self._endless = problem
            raise

    def _grouped(self, messages: Messages) -> list[Group]:
        found: list[Group] = []
        for index in by_size(messages.size):
            known = list(self._layouts.get(int(messages.size[index[0]]), []))
            tried = 0
            while index.size:
                if known:
                    layout = known.pop()
                else:
                    layout = self.layout(messages[index[:1]].data()[0])
                    self._keep(layout)
                tried += 1
                # Of many shapes in one size each message is looked at by itself, or it takes squared time.
                some = index if tried <= MOST_SHAPES else index[:1]
                those = messages if len(some) == len(messages) else messages[some]
                fits = layout.fits(those)
                if fits.all():
                    found.append((None if those is messages else some, layout, those))
                elif fits.any():
                    found.append((some[fits], layout, those[fits]))
                index = np.concatenate([some[~fits], index[len(some) :]])
                if tried >= MOST_SHAPES:
                    known = []
        return found

    def _keep(self, layout: Layout) -> None:
        weight = layout.weight
        if weight > MOST_KEPT // 4:
            return
        some = self._layouts.setdefault(layout.size, [])
        some.append(layout)
        self._layouts.move_to_end(layout.size)
        self._kept += weight
        if len(some) > MOST_SHAPES:
            self._kept -= some.pop(0).weight
        while self._kept > MOST_KEPT and len(self._layouts) > 1:
            _, old = self._layouts.popitem(last=False)
            self._kept -= sum(one.weight for one in old)


class TopicDecoder(Decoder):
    """Decodes a topic's messages, each by its own channel.

    Parameters
    ----------
    topic : str
    kinds : mapping of channel to Decoder, or to why its messages can't be decoded
    """

    def __init__(self, topic: str, kinds: Mapping[int, Decoder | BagError]) -> None:
        self.topic = topic
        self.kinds = kinds
        sound = [kind for kind in kinds.values() if isinstance(kind, Decoder)]
        if not sound:
            raise next((k for k in kinds.values() if isinstance(k, BagError)), BagError(f"{topic} is empty"))
        self.type, self.types = sound[0].type, sound[0].types
        self._first = sound[0]
        self._sorted = None

    @property
    def definition(self) -> tuple[str, Types] | None:
        """The type and what it consists of; None where the topic's channels differ in it."""
        mine = self.type, self.types
        alike = all(isinstance(k, Decoder) and k.definition == mine for k in self.kinds.values())
        return mine if alike else None

    def layout(self, message: bytes) -> Layout:
        """Walk one message, taken for one of the topic's first type."""
        return self._first.layout(message)

    def only(self, messages: Messages, kind: str) -> Messages:
        """Return the messages that are of a type."""
        mine = [n for n, one in self.kinds.items() if isinstance(one, Decoder) and one.type == kind]
        if len(mine) == len(self.kinds):
            return messages
        keep = np.isin(messages.channel, mine)
        return messages if keep.all() else messages[keep]

    def decoder(self, channel: int) -> Decoder:
        """Return a channel's decoder; raises BagError where its messages can't be decoded."""
        found = self.kinds.get(channel, self._first)
        if isinstance(found, BagError):
            raise found
        return found

    def _grouped(self, messages: Messages) -> list[Group]:
        first = int(messages.channel[0])
        if (messages.channel == first).all():
            return self.decoder(first).groups(messages)
        found: list[Group] = []
        # Channels of one definition are decoded together.
        numbers = np.unique(messages.channel).tolist()
        for decoder in dict.fromkeys(self.decoder(n) for n in numbers):
            mine = [n for n in numbers if self.decoder(n) is decoder]
            index = np.flatnonzero(np.isin(messages.channel, mine))
            for some, layout, those in decoder.groups(messages[index]):
                found.append((index if some is None else index[some], layout, those))
        return found


def by_size(sizes: NDArray[np.int64]) -> list[NDArray[np.intp]]:
    """Return which messages are of one size, size by size."""
    if (sizes == sizes[0]).all():
        return [np.arange(len(sizes))]
    order = np.argsort(sizes, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(sizes[order])) + 1)
