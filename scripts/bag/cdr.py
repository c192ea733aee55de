"""Decodes many CDR messages of one type at once.

Messages of a robot repeat their shape: the same names, the same array lengths. So one message
is walked to find where each field lies, and where the lengths are that fix these places; every
other message with the same lengths in the same places is then sliced, not decoded.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .definitions import full_name
from .errors import BagError
from .messages import Messages, of_list, window

HEADER = 4  # the encapsulation header; alignment counts from behind it
DTYPES = {
    "bool": "u1",
    "byte": "u1",
    "char": "u1",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "int64": "i8",
    "uint64": "u8",
    "float32": "f4",
    "float64": "f8",
}
LINE = re.compile(
    r"^(?P<type>[A-Za-z][\w/]*)(?:<=\d+)?(?:\[(?P<bound><=)?(?P<size>\d*)\])?"
    r"\s+(?P<name>[A-Za-z]\w*)\s*(?P<constant>=)?"
)


# Part of an array: "position[-3:]" needs not read the rest.
PART = re.compile(r"(?P<name>.+)\[(?P<first>-?\d*):(?P<last>-?\d*)\]$")


@dataclass(frozen=True)
class Member:
    """One field of a message: `size` None is a scalar, 0 a sequence, n an array of n."""

    name: str
    type: str
    size: int | None


@dataclass(frozen=True)
class Place:
    """Where a field lies in a message: `count` None is a scalar; for text, its bytes."""

    offset: int
    dtype: str
    count: int | None

    def part(self, first: str, last: str) -> Place:
        """Return where some of an array's numbers lie, as Python's slices have it."""
        some = slice(int(first) if first else None, int(last) if last else None)
        start, stop, _ = some.indices(self.count or 0)
        size = np.dtype(self.dtype).itemsize
        return Place(self.offset + start * size, self.dtype, max(0, stop - start))


@dataclass
class Layout:
    """Where everything lies in the messages that have these `lengths`."""

    size: int
    places: dict[str, list[Place]] = field(default_factory=dict)
    lengths: dict[int, int] = field(default_factory=dict)
    listed: set[str] = field(default_factory=set)
    _lengths: tuple[NDArray[np.int64], NDArray[np.uint8]] | None = None

    def fits(self, messages: Messages) -> NDArray[np.bool_]:
        """Say which messages of this size have the layout: all lengths are where they are to be."""
        if not self.lengths:
            return np.ones(len(messages), dtype=bool)
        if self._lengths is None:
            at = np.fromiter(self.lengths, np.int64, len(self.lengths))
            bytes_at = (at[:, None] + np.arange(4)).ravel()
            said = np.fromiter(self.lengths.values(), np.uint32, len(self.lengths)).astype("<u4")
            self._lengths = bytes_at, said.view(np.uint8)
        place, wanted = self._lengths
        return (messages.buffer[messages.start[:, None] + place] == wanted).all(axis=1)

    def is_array(self, name: str) -> bool:
        """Say whether a field is an array of numbers."""
        places = self.places.get(name, [])
        return bool(places) and places[0].count is not None and places[0].dtype in DTYPES.values()

    def cut(self, name: str, messages: Messages, type_name: str, views: bool = False) -> NDArray[Any]:
        """Return a field of messages that have this layout."""
        if name not in self.places and (part := PART.match(name)) and self.is_array(part["name"]):
            place = self.places[part["name"]][0].part(part["first"], part["last"])
            return column(messages, place, views)
        if name not in self.places:
            there = ", ".join(self.places)
            raise BagError(f"{type_name} has no field '{name}'; it has {there}")
        places = self.places[name]
        if places and places[0].dtype in DTYPES.values():
            return column(messages, places[0], views)
        texts = [text(messages, place) for place in places]
        cells = np.empty(len(messages), dtype=object)
        if name not in self.listed:
            cells[:] = texts[0]
            return cells
        if all(t.count(t[0]) == len(t) for t in texts):  # as names are: one list for all
            cells.fill([t[0] for t in texts])
            return cells
        for i in range(len(messages)):
            cells[i] = [t[i] for t in texts]
        return cells


# Which of some messages share a layout, None where all do; the layout; and they.
Group = tuple[NDArray[np.intp] | None, Layout, Messages]


def parse(root: str, text: str) -> dict[str, list[Member]]:
    """Read a ros2msg schema: the members of the root type and of each that it depends on."""
    types: dict[str, list[Member]] = {}
    for part in re.split(r"^={80}\n", text, flags=re.MULTILINE):
        head, _, body = part.partition("\n")
        name = root
        if head.startswith("MSG: "):
            first, _, last = head[5:].strip().partition("/")
            name, part = f"{first}/msg/{last.removeprefix('msg/')}", body
        types[name] = [m for line in part.splitlines() if (m := member(line, name))]
    return types


def member(line: str, owner: str) -> Member | None:
    """Read one line of a message; comments and constants give None."""
    match = LINE.match(line.partition("#")[0].strip())
    if match is None or match["constant"]:
        return None
    kind = match["type"]
    if kind not in DTYPES and kind not in ("string", "wstring"):
        kind = full_name(kind, owner.partition("/")[0])
    if match["size"] is None:
        return Member(match["name"], kind, None)
    fixed = int(match["size"]) if match["size"] and not match["bound"] else 0
    return Member(match["name"], kind, fixed)


class Decoder:
    """Slices the messages of one type into columns.

    Parameters
    ----------
    type_name : str
        `pkg/msg/Type`.
    schema : str
        Its ros2msg text with all dependencies.
    """

    def __init__(self, type_name: str, schema: str) -> None:
        self.type = type_name
        self.types = parse(type_name, schema)
        self._layouts: dict[int, list[Layout]] = {}
        self._sorted: tuple[Messages, list[Group]] | None = None

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
                cut = layout.cut(name, some, self.type, views)
                if index is None:  # all are alike
                    columns[name] = cut
                    continue
                if name not in columns:
                    columns[name] = np.empty((len(found), *cut.shape[1:]), dtype=cut.dtype)
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
        found: list[Group] = []
        if not len(messages):
            return found
        # Whoever reads a bag for several purposes asks for the same messages several times.
        if self._sorted is not None and self._sorted[0] is messages:
            return self._sorted[1]
        sizes = messages.size
        for size in [int(sizes[0])] if (sizes == sizes[0]).all() else np.unique(sizes).tolist():
            index = np.flatnonzero(sizes == size)
            known = list(self._layouts.setdefault(size, []))
            while index.size:
                if known:
                    layout = known.pop(0)
                else:
                    layout = self.layout(messages[index[:1]].data()[0])
                    self._layouts[size].append(layout)
                some = messages if len(index) == len(messages) else messages[index]
                fits = layout.fits(some)
                if fits.all():
                    found.append((None if some is messages else index, layout, some))
                    break
                if fits.any():
                    found.append((index[fits], layout, some[fits]))
                index = index[~fits]
        self._sorted = messages, found
        return found

    def layout(self, message: bytes) -> Layout:
        """Walk one message and note where each field lies."""
        if len(message) < HEADER or message[0] != 0 or message[1] != 1:
            raise BagError(f"a {self.type} message is not little-endian CDR")
        layout = Layout(len(message))
        try:
            end = self._walk(self.type, message, HEADER, "", layout)
        except (IndexError, ValueError):
            end = len(message) + 1
        if end > len(message):
            raise BagError(f"a {self.type} message is shorter than its definition says")
        return layout

    def _walk(self, kind: str, message: bytes, at: int, prefix: str, layout: Layout) -> int:
        members = self.types.get(kind)
        if members is None:
            raise BagError(f"the bag's schema of {self.type} lacks {kind}")
        if not members:
            return at + 1  # an empty structure holds one unused byte
        for m in members:
            name = prefix + m.name
            count = m.size
            if count == 0:
                count, at = read_length(message, at, layout)
            if m.type in DTYPES:
                at = self._primitive(m, name, count, at, layout)
            elif m.type in ("string", "wstring"):
                if count is not None:
                    layout.listed.add(name)
                    layout.places.setdefault(name, [])
                for _ in range(1 if count is None else count):
                    length, at = read_length(message, at, layout)
                    width = 1 if m.type == "string" else 2
                    text = Place(at, m.type, length * width)
                    layout.places.setdefault(name, []).append(text)
                    at += length * width
            elif count is None:
                at = self._walk(m.type, message, at, f"{name}.", layout)
            else:
                for i in range(count):
                    at = self._walk(m.type, message, at, f"{name}[{i}].", layout)
        return at

    def _primitive(self, m: Member, name: str, count: int | None, at: int, layout: Layout) -> int:
        dtype = np.dtype(DTYPES[m.type])
        if count != 0:
            at = align(at, dtype.itemsize)
        layout.places[name] = [Place(at, DTYPES[m.type], count)]
        return at + dtype.itemsize * (1 if count is None else count)


def align(at: int, size: int) -> int:
    """Return the next place where a value of `size` bytes may begin."""
    return at + (HEADER - at) % size


def read_length(message: bytes, at: int, layout: Layout) -> tuple[int, int]:
    """Read a sequence's or string's length and remember that this shape depends on it."""
    at = align(at, 4)
    length = int.from_bytes(message[at : at + 4], "little")
    if length > len(message):
        raise ValueError("length beyond the message")
    layout.lengths[at] = length
    return length, at + 4


def column(messages: Messages, place: Place, views: bool = False) -> NDArray:
    """Cut one field out of messages of one layout: (k,) for a scalar, (k, count) for an array."""
    dtype = np.dtype(f"<{place.dtype}")
    count = 1 if place.count is None else place.count
    if count == 0:
        return np.empty((len(messages), 0), dtype=dtype)
    stride = messages.stride if views else None
    if stride is not None:
        values: NDArray = np.ndarray(
            (len(messages), count), dtype, messages.buffer.data, int(messages.start[0]) + place.offset,
            (stride, dtype.itemsize),
        )  # fmt: skip
        return values[:, 0] if place.count is None else values
    cut = window(messages.buffer, messages.start + place.offset, count * dtype.itemsize)
    values = np.ascontiguousarray(cut).view(dtype).reshape(len(messages), count)
    return values[:, 0] if place.count is None else values


def text(messages: Messages, place: Place) -> list[str]:
    """Cut a string field out of messages of one layout, one string a message."""
    if not place.count:
        return [""] * len(messages)
    cut = window(messages.buffer, messages.start + place.offset, place.count)
    encoding = "utf-8" if place.dtype == "string" else "utf-16-le"
    if len(cut) and (cut == cut[0]).all():
        return [cut[0].tobytes().decode(encoding, "replace").rstrip("\0")] * len(cut)
    return [row.tobytes().decode(encoding, "replace").rstrip("\0") for row in cut]
