"""Where each field lies in a message of CDR, and in all others whose lists and words are as long.

One message is walked; every other one with the same lengths in the same places is then sliced, not
decoded. Structures of a list that are alike follow each other evenly, so that only the first is walked.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .errors import BagError
from .messages import Messages, window
from .schema import DTYPES, TEXTS, Member, Types

HEADER = 4  # the encapsulation header; alignment counts from behind it
LIST = "[]"
# A definition may double itself with each type; no message has so many fields.
MOST_FIELDS = 5_000
# The second byte of the header: CDR, big- and little-endian.
ENDIAN = {0: ">", 1: "<"}
OTHERS = {2: "PL_CDR", 3: "PL_CDR", 6: "XCDR2", 7: "XCDR2", 8: "XCDR2", 9: "XCDR2", 10: "XCDR2", 11: "XCDR2"}
# Part of an array: "position[-3:]" needs not read the rest.
PART = re.compile(r"(?P<name>.+)\[(?P<first>-?\d*):(?P<last>-?\d*)\]$")
STEP = re.compile(r"(?P<name>\w+)(?:\[(?P<index>\d*)\])?$")


class EndlessType(BagError):
    """A definition that no message needs: whoever met it need not look at further messages."""


@dataclass
class Field:
    """A field's places in a message.

    Attributes
    ----------
    dtype : NumPy's code of a number, or "string", "wstring"
    several : whether it is more than one value a message: an array, or within a list of structures
    parts : list of (places, count): at each place so many numbers, or bytes of a text
    """

    dtype: str
    several: bool
    parts: list[tuple[Any, int]] = field(default_factory=list)

    @property
    def is_text(self) -> bool:
        """Whether it is text."""
        return self.dtype in TEXTS

    @property
    def values(self) -> int:
        """Values a message."""
        return sum(len(places) * (1 if self.is_text else count) for places, count in self.parts)

    def put(self, place: int, count: int) -> None:
        """Note one place more."""
        if self.parts and self.parts[-1][1] == count and isinstance(self.parts[-1][0], list):
            self.parts[-1][0].append(place)
        else:
            self.parts.append(([place], count))

    def some(self, first: int, last: int, scalar: bool) -> Field:
        """Return where the values from first to last, in order, lie."""
        found = Field(self.dtype, not scalar)
        size = 1 if self.is_text else np.dtype(self.dtype).itemsize
        at = 0
        for places, count in self.parts:
            each = 1 if self.is_text else count
            for place in places:
                a, b = max(first - at, 0), min(last - at, each)
                if a < b:
                    found.put(
                        int(place) + (0 if self.is_text else a * size), count if self.is_text else b - a
                    )
                at += each
        return found.tidy()

    def tidy(self) -> Field:
        """Return the same with its places as arrays, those of one count together."""
        parts: list[tuple[Any, int]] = []
        for places, count in self.parts:
            if parts and parts[-1][1] == count:
                parts[-1][0].append(places)
            else:
                parts.append(([places], count))
        self.parts = [(np.concatenate([np.asarray(p, np.int64) for p in some]), n) for some, n in parts]
        return self


@dataclass
class Layout:
    """Where everything lies in the messages that have these lengths.

    Attributes
    ----------
    kind : the message's type
    size : bytes of a message
    order : "<" or ">"
    end : where its definition ends; a message may be longer
    fields : by name; "poses[].x" is x of all structures of a list
    counts : how many values each list has, by its name, list by list
    """

    kind: str
    size: int
    order: str
    end: int = HEADER
    fields: dict[str, Field] = field(default_factory=dict)
    counts: dict[str, list[Any]] = field(default_factory=dict)
    lengths: list[tuple[Any, Any]] = field(default_factory=list)

    @property
    def weight(self) -> int:
        """Numbers that it holds itself, about."""
        return 8 + sum(len(places) for f in self.fields.values() for places, _ in f.parts)

    def tidy(self) -> Layout:
        """Return the same as arrays."""
        for f in self.fields.values():
            f.tidy()
        self.counts = {n: [np.concatenate([np.atleast_1d(c) for c in cs])] for n, cs in self.counts.items()}
        at = [np.array([0]), *(np.atleast_1d(a) for a, _ in self.lengths)]
        said = [np.atleast_1d(n) for _, n in self.lengths]
        place = np.concatenate(at)[1:]
        words = np.concatenate(said).astype(f"{self.order}u4") if said else np.empty(0, "u4")
        bytes_at = (place[:, None] + np.arange(4)).ravel()
        self._places = np.concatenate([[0, 1], bytes_at]).astype(np.int64)
        self._wanted = np.concatenate([np.array([0, self.order == "<"], np.uint8), words.view(np.uint8)])
        return self

    def fits(self, messages: Messages) -> NDArray[np.bool_]:
        """Say which messages of this size have the layout: all lengths are where they are to be."""
        if self.size < HEADER:
            return np.ones(len(messages), dtype=bool)
        return (messages.buffer[messages.start[:, None] + self._places] == self._wanted).all(axis=1)

    def find(self, name: str) -> Field:
        """Return a field by its name: "position", "position[-3:]", "points[].x", "points[2].x".

        Raises
        ------
        BagError
            The message has no such field.
        """
        found = self.fields.get(name)
        if found is not None:
            return found
        part = PART.match(name)
        if (
            part
            and (whole := self.fields.get(part["name"])) is not None
            and whole.several
            and not whole.is_text
        ):
            ends = (int(part[k]) if part[k] else None for k in ("first", "last"))
            first, last, _ = slice(*ends).indices(whole.values)
            return whole.some(first, max(first, last), scalar=False)
        found = self._of_one(name)
        if found is None:
            raise BagError(f"{self.kind} has no field '{name}'; it has {', '.join(self.fields)}")
        return found

    def _of_one(self, name: str) -> Field | None:
        """Return a field of one structure of a list."""
        path, number = "", 0
        for step in name.split("."):
            match = STEP.match(step)
            if match is None:
                return None
            path += f".{match['name']}" if path else match["name"]
            if match["index"] and path + LIST in self.counts:
                path += LIST
                inside = self.counts[path][0]
                if number >= len(inside) or int(match["index"]) >= inside[number]:
                    return None
                number = int(inside[:number].sum()) + int(match["index"])
            elif match["index"] is not None:
                return None
        found = self.fields.get(path)
        if found is None:
            return None
        if path in self.counts:
            inside = self.counts[path][0]
            first = int(inside[:number].sum())
            return found.some(first, first + int(inside[number]), scalar=False)
        return found.some(number, number + 1, scalar=True)

    def cut(self, name: str, messages: Messages, views: bool = False) -> NDArray[Any]:
        """Return a field of messages that have this layout: (k,), or (k, n) for several values."""
        found = self.find(name)
        if found.is_text:
            return words(messages, found, self.order)
        return numbers(messages, found, self.order, views)


def walk(kind: str, types: Types, message: bytes) -> Layout:
    """Walk one message and note where each field lies; raises BagError where it is not as defined."""
    if len(message) < HEADER:
        if message or types[kind]:
            raise BagError(f"a {kind} message is shorter than its definition says")
        return Layout(kind, 0, "<").tidy()  # an empty structure, of which nothing was written
    if message[0] != 0 or message[1] not in ENDIAN:
        what = OTHERS.get(message[1], "not CDR") if message[0] == 0 else "not CDR"
        raise BagError(f"a {kind} message is {what}, which can't be decoded")
    layout = Layout(kind, len(message), ENDIAN[message[1]])
    try:
        end = _Walk(types, message, layout.order).structure(kind, HEADER, "", layout)
    except IndexError:
        raise BagError(f"a {kind} message is shorter than its definition says") from None
    layout.end = min(end, len(message)) if types[kind] else HEADER
    return layout.tidy()


class _Walk:
    """Walks a message, structure by structure; raises IndexError beyond its end."""

    def __init__(self, types: Types, message: bytes, order: str) -> None:
        self.types, self.message, self.order = types, message, order
        self._endian: Any = "little" if order == "<" else "big"
        self._bytes = np.frombuffer(message, np.uint8)

    def structure(self, kind: str, at: int, prefix: str, layout: Layout) -> int:
        """Note the fields of a structure that begins here; returns where it ends."""
        members = self.types[kind]
        if not members:
            return at + 1  # an empty structure holds one unused byte
        for m in members:
            at = self._member(m, at, prefix + m.name, layout)
            if at > len(self.message):
                raise IndexError("beyond the message")
        return at

    def _member(self, m: Member, at: int, name: str, layout: Layout) -> int:
        count = m.size
        if count == 0:
            count, at = self._length(at, layout)
        several = count is not None or LIST in name
        if m.type in DTYPES:
            dtype = DTYPES[m.type]
            size = np.dtype(dtype).itemsize
            if count is not None:
                layout.counts.setdefault(name, []).append(count)
            if count != 0:
                at += (HEADER - at) % size
            found = layout.fields.setdefault(name, Field(dtype, several))
            n = 1 if count is None else count
            if n:
                found.put(at, n)
            return at + size * n
        if m.type in TEXTS:
            if count is not None:
                layout.counts.setdefault(name, []).append(count)
            found = layout.fields.setdefault(name, Field(m.type, several))
            for _ in range(1 if count is None else count):
                length, at = self._length(at, layout)
                length *= TEXTS[m.type]
                found.put(at, length)
                at += length
                if at > len(self.message):
                    raise IndexError("beyond the message")
            return at
        if m.type not in self.types:
            raise BagError(f"{m.type} can't be decoded")
        if count is None:
            return self.structure(m.type, at, f"{name}.", layout)
        layout.counts.setdefault(name + LIST, []).append(count)
        return self._list(m.type, count, at, f"{name}{LIST}.", layout)

    def _list(self, kind: str, count: int, at: int, prefix: str, layout: Layout) -> int:
        """Note the structures of a list; those that are alike and lie evenly at once."""
        if not count:
            self._names(kind, prefix, layout)
        while count > 0:
            one = Layout(kind, layout.size, self.order)
            end = self.structure(kind, at, prefix, one)
            size, alike = end - at, 1
            # Alignment is the same again after eight bytes.
            if count > 1 and size % 8 == 0:
                alike = self._alike(one, at, size, count)
            step = size * np.arange(alike, dtype=np.int64)
            for name, f in one.fields.items():
                into = layout.fields.setdefault(name, Field(f.dtype, f.several))
                if alike == 1:
                    into.parts += f.parts
                elif len(parts := f.tidy().parts) == 1:
                    places, n = parts[0]
                    into.parts.append(((step[:, None] + places).ravel(), n))
                else:
                    into.parts += [(s + places, n) for s in step.tolist() for places, n in parts]
            for name, counts in one.counts.items():
                layout.counts.setdefault(name, []).extend(counts * alike)
            for places, said in one.lengths:
                many = (step[:, None] + np.atleast_1d(places)).ravel()
                layout.lengths.append((many, np.tile(np.atleast_1d(said), alike)))
            at += size * alike
            count -= alike
        return at

    def _alike(self, one: Layout, at: int, size: int, count: int) -> int:
        """Return how many structures in a row, this one first, have its lengths."""
        most = min(count, (len(self.message) - at) // size)
        if not one.lengths:
            return max(1, most)
        place = np.concatenate([np.atleast_1d(p) for p, _ in one.lengths])
        said = np.concatenate([np.atleast_1d(n) for _, n in one.lengths])
        bytes_at = (place[:, None] + np.arange(4)).ravel()
        wanted = said.astype(f"{self.order}u4").view(np.uint8)
        found, block = 1, 16
        while found < most:
            rows = np.arange(found, min(most, found + block)) * size
            same = (self._bytes[rows[:, None] + bytes_at] == wanted).all(axis=1)
            if not same.all():
                return found + int(np.argmin(same))
            found += len(rows)
            block = min(4 * block, 4096)
        return found

    def _names(self, kind: str, prefix: str, layout: Layout) -> None:
        """Make the fields of an empty list known."""
        if len(layout.fields) > MOST_FIELDS:
            raise EndlessType(f"{layout.kind} has more than {MOST_FIELDS} fields")
        for m in self.types[kind]:
            name = prefix + m.name
            if m.type in DTYPES or m.type in TEXTS:
                layout.fields.setdefault(name, Field(DTYPES.get(m.type, m.type), True))
                if m.size is not None:
                    layout.counts.setdefault(name, []).append(np.empty(0, np.int64))
            elif m.type in self.types:
                if m.size is not None:
                    layout.counts.setdefault(name + LIST, []).append(np.empty(0, np.int64))
                self._names(m.type, f"{name}{'' if m.size is None else LIST}.", layout)

    def _length(self, at: int, layout: Layout) -> tuple[int, int]:
        """Read a sequence's or text's length and remember that this shape depends on it."""
        at += (HEADER - at) % 4
        length = int.from_bytes(self.message[at : at + 4], self._endian)
        if at + 4 > len(self.message) or length > len(self.message):
            raise IndexError("beyond the message")
        layout.lengths.append((at, length))
        return length, at + 4


def numbers(messages: Messages, found: Field, order: str, views: bool = False) -> NDArray[Any]:
    """Cut numbers out of messages of one layout: (k,), or (k, n) for several."""
    dtype = np.dtype(f"{order}{found.dtype}")
    stride = messages.stride if views else None
    pieces = []
    for places, count in found.parts:
        if stride is not None and len(places) == 1:
            piece: NDArray[Any] = np.ndarray(
                (len(messages), count), dtype, messages.buffer.data, int(messages.start[0]) + int(places[0]),
                (stride, dtype.itemsize),
            )  # fmt: skip
        else:
            at = (messages.start[:, None] + places).ravel()
            cut = np.ascontiguousarray(window(messages.buffer, at, count * dtype.itemsize))
            piece = cut.view(dtype).reshape(len(messages), len(places) * count)
        pieces.append(piece)
    if not pieces:
        return np.empty((len(messages), 0), dtype.newbyteorder("="))
    values = pieces[0] if len(pieces) == 1 else np.concatenate(pieces, axis=1)
    if order == ">":
        values = values.astype(dtype.newbyteorder("="))
    return values if found.several else values[:, 0]


def words(messages: Messages, found: Field, order: str) -> NDArray[Any]:
    """Cut text out of messages of one layout: objects (k,), str or list of str."""
    encoding = "utf-8" if found.dtype == "string" else "utf-16-le" if order == "<" else "utf-16-be"
    one = shared(messages, found, encoding)
    if one is not None:
        cells = np.empty(len(messages), dtype=object)
        cells.fill(one)
        return cells
    columns: list[list[str]] = []
    for places, count in found.parts:
        columns += [text(messages, int(place), count, encoding) for place in places]
    cells = np.empty(len(messages), dtype=object)
    if not found.several:
        cells[:] = columns[0]
    elif all(c.count(c[0]) == len(c) for c in columns):  # as names are: one list for all
        cells.fill([c[0] for c in columns])
    else:
        for i in range(len(messages)):
            cells[i] = [c[i] for c in columns]
    return cells


def shared(messages: Messages, found: Field, encoding: str) -> list[str] | None:
    """Return the texts of a list where all messages have the same, as names are; else None."""
    if not (found.several and found.parts and len(messages)):
        return None
    places = np.concatenate([p for p, _ in found.parts])
    counts = np.concatenate([np.full(len(p), n) for p, n in found.parts])
    begin, end = int(places.min()), int((places + counts).max())
    # Between two texts of a list stand a length and what fills it up to four bytes, and nothing else.
    if end - begin > int(counts.sum()) + 7 * len(places):
        return None
    cut = window(messages.buffer, messages.start + begin, end - begin)
    if not (cut == cut[0]).all():
        return None
    plain = cut[0].tobytes()
    pairs = zip((places - begin).tolist(), counts.tolist(), strict=True)
    return [plain[at : at + n].decode(encoding, "replace").rstrip("\0") for at, n in pairs]


def text(messages: Messages, place: int, count: int, encoding: str) -> list[str]:
    """Cut a text out of messages of one layout, one a message."""
    if not count:
        return [""] * len(messages)
    cut = window(messages.buffer, messages.start + place, count)
    if len(cut) and (cut == cut[0]).all():
        return [cut[0].tobytes().decode(encoding, "replace").rstrip("\0")] * len(cut)
    return [row.tobytes().decode(encoding, "replace").rstrip("\0") for row in cut]
