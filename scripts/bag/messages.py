"""The messages of a chunk, found without decoding: where each lies, and when it came."""

from __future__ import annotations

import struct
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

HEAD = np.dtype(
    [
        ("opcode", "u1"),
        ("length", "<u8"),
        ("channel", "<u2"),
        ("sequence", "<u4"),
        ("log_time", "<u8"),
        ("publish_time", "<u8"),
    ]
)
FIELDS = HEAD.itemsize - 9
RECORD = struct.Struct("<BQ")
INDEX = struct.Struct("<HI")
# CDR counts alignment from behind its four bytes of head.
ALIGNED = 4
# What each message has beside its place.
OF_EACH = ("size", "log_time", "publish_time", "sequence", "channel")
SECOND = 1_000_000_000


@dataclass(frozen=True)
class Messages:
    """K messages within one buffer.

    Attributes
    ----------
    buffer : ndarray of bytes
    start, size : ndarray (K,), bytes
        Where each message's CDR lies.
    log_time, publish_time : ndarray (K,), ns since the epoch
    sequence : ndarray (K,)
        The publisher's own count, modulo 2**32, or 0 where it is not known.
    channel : ndarray (K,)
        The number of each message's channel: in its file, or in its bag once that has given it out.
    """

    buffer: NDArray[np.uint8]
    start: NDArray[np.int64]
    size: NDArray[np.int64]
    log_time: NDArray[np.int64]
    publish_time: NDArray[np.int64]
    sequence: NDArray[np.int64]
    channel: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.start)

    def __getitem__(self, which: NDArray | slice) -> Messages:
        return Messages(
            self.buffer,
            self.start[which],
            self.size[which],
            self.log_time[which],
            self.publish_time[which],
            self.sequence[which],
            self.channel[which],
        )

    @cached_property
    def stride(self) -> int | None:
        """Bytes from each message to the next, where they are of one size and lie evenly; else None."""
        if len(self) < 2:
            return None
        step = np.diff(self.start)
        even = (step == step[0]).all() and (self.size == self.size[0]).all()
        return int(step[0]) if even else None

    def compact(self) -> Messages:
        """Return the same in a buffer that holds nothing else, aligned where all are of one size."""
        size = int(self.size[0]) if len(self) else 0
        if (self.size == size).all():
            step = -(-(ALIGNED + size) // 8) * 8
            buffer: NDArray[np.uint8] = np.empty(len(self) * step, dtype=np.uint8)
            rows = buffer.reshape(len(self), step)
            rows[:, ALIGNED : ALIGNED + size] = self.rows(size)
            start: NDArray[np.int64] = ALIGNED + step * np.arange(len(self), dtype=np.int64)
        else:
            buffer = np.frombuffer(b"".join(self.data()), dtype=np.uint8)
            start = np.cumsum(self.size) - self.size
        return self.moved(buffer, start)

    def rows(self, size: int) -> NDArray[np.uint8]:
        """Return the first `size` bytes of each: (K, size); raises IndexError beyond the buffer."""
        stride = self.stride
        if stride is None or int(self.start.min()) < 0 or int(self.start.max()) + size > len(self.buffer):
            return window(self.buffer, self.start, size)
        # Where they lie evenly, as mostly, they need not be picked one by one.
        return np.ndarray((len(self), size), np.uint8, self.buffer.data, int(self.start[0]), (stride, 1))

    def moved(self, buffer: NDArray[np.uint8], start: NDArray[np.int64]) -> Messages:
        """Return the same messages elsewhere."""
        return replace(self, buffer=buffer, start=start)

    def data(self) -> list[bytes]:
        """Return the CDR of each."""
        plain = self.buffer.data
        return [bytes(plain[a : a + n]) for a, n in zip(self.start.tolist(), self.size.tolist(), strict=True)]


class Gathered:
    """Messages that are taken up a few at a time, copied out of their buffers, and given together.

    Whoever wants few messages of each chunk decodes many at once this way, and holds no chunk.

    Parameters
    ----------
    most : int
        So many are given together.
    size : int, bytes
        Or so much.
    """

    def __init__(self, most: int, size: int = 1 << 62) -> None:
        self.most, self.size = most, size
        self._parts: list[Messages] = []
        self._count = self._size = 0

    def add(self, messages: Messages) -> Messages | None:
        """Take up messages; all so far, where they are enough to be worked on."""
        if len(messages):
            self._parts.append(messages.compact())
            self._count += len(messages)
            self._size += len(self._parts[-1].buffer)
        return self.all() if self._count >= self.most or self._size >= self.size else None

    def all(self) -> Messages | None:
        """Give all that wait; None where none do."""
        parts, self._parts, self._count, self._size = self._parts, [], 0, 0
        if not parts:
            return None
        if len(parts) == 1:
            return parts[0]
        return joined(parts)


class Thinner:
    """Keeps at most one message each `period` seconds; a period of 0 keeps all."""

    def __init__(self, period: float) -> None:
        self.period = round(period * SECOND)
        self.cell = -1  # of a fixed grid, so that jitter does not change the rate
        self.planned = -1

    def __call__(self, messages: Messages) -> Messages:
        """Return the messages that are kept."""
        if not self.period or not len(messages):
            return messages
        cells = np.maximum.accumulate(messages.log_time // self.period)
        news = np.empty(len(cells), dtype=bool)
        news[0] = cells[0] > self.cell
        np.greater(cells[1:], cells[:-1], out=news[1:])
        self.cell = max(self.cell, int(cells[-1]))
        return messages[news]

    def needs(self, last_time: int) -> bool:
        """Say whether a chunk up to this log time may hold a message that is kept; asked in order."""
        if not self.period:
            return True
        last = last_time // self.period
        if last <= self.planned:
            return False
        self.planned = last
        return True


def joined(parts: list[Messages]) -> Messages:
    """Return messages of several buffers in one."""
    before = np.cumsum([0, *[len(part.buffer) for part in parts[:-1]]]).tolist()
    return Messages(
        np.concatenate([part.buffer for part in parts]),
        np.concatenate([part.start + at for part, at in zip(parts, before, strict=True)]),
        *(np.concatenate([getattr(part, name) for part in parts]) for name in OF_EACH),
    )


def of_list(data: list[bytes], channel: int = 0) -> Messages:
    """Return messages that came one by one; they bear no times."""
    size = np.fromiter(map(len, data), dtype=np.int64, count=len(data))
    none = np.zeros(len(data), dtype=np.int64)
    buffer = np.frombuffer(b"".join(data), dtype=np.uint8)
    return Messages(buffer, np.cumsum(size) - size, size, none, none, none, none + channel)


def merged(some: list[Messages]) -> Messages:
    """Join messages of one buffer, in the order in which they lie in it."""
    if len(some) == 1:
        return some[0]
    start = np.concatenate([one.start for one in some])
    order = np.argsort(start, kind="stable")
    each = (np.concatenate([getattr(one, name) for one in some])[order] for name in OF_EACH)
    return Messages(some[0].buffer, start[order], *each)


def window(buffer: NDArray[np.uint8], start: NDArray[np.int64], size: int) -> NDArray[np.uint8]:
    """Return `size` bytes from each start: (K, size); raises IndexError beyond the buffer."""
    if size > len(buffer):
        raise IndexError("beyond the buffer")
    # As sliding_window_view has it, at a tenth of the price.
    views: NDArray[np.uint8] = np.ndarray(
        (len(buffer) - size + 1, size), np.uint8, buffer=buffer.data, strides=(1, 1)
    )
    return views[start]


def heads(buffer: NDArray[np.uint8], offset: NDArray[np.int64]) -> NDArray:
    """Return the heads of the messages at these offsets."""
    return window(buffer, offset, HEAD.itemsize).view(HEAD)[:, 0]


def at_offsets(buffer: NDArray[np.uint8], offset: NDArray[np.int64], head: NDArray) -> Messages:
    """Return the messages at these offsets, whose heads are known."""
    return Messages(
        buffer,
        offset + HEAD.itemsize,
        head["length"].astype(np.int64) - FIELDS,
        head["log_time"].astype(np.int64),
        head["publish_time"].astype(np.int64),
        head["sequence"].astype(np.int64),
        head["channel"].astype(np.int64),
    )


def by_index(buffer: NDArray[np.uint8], indices: bytes | memoryview) -> dict[int, Messages] | None:
    """Find a chunk's messages by its message indices; None where these do not fit the chunk.

    The indices carry no checksum, so each is held against the message that it names, and all
    together against the size of the chunk.
    """
    found: dict[int, Messages] = {}
    at, covered = 0, 0
    while at + RECORD.size + INDEX.size <= len(indices):
        opcode, length = RECORD.unpack_from(indices, at)
        at += RECORD.size
        if opcode != Opcode.MESSAGE_INDEX or at + length > len(indices) or length < INDEX.size:
            return None
        channel, size = INDEX.unpack_from(indices, at)
        if size % 16 or size > length - INDEX.size or channel in found:
            return None
        pairs = np.frombuffer(indices, "<u8", size // 8, at + INDEX.size).reshape(-1, 2)
        at += length
        if not len(pairs):
            continue
        offset = pairs[:, 1].astype(np.int64)
        if offset.min() < 0 or offset.max() > len(buffer) - HEAD.itemsize:
            return None
        head = heads(buffer, offset)
        fits = (head["opcode"] == Opcode.MESSAGE) & (head["channel"] == channel)
        fits &= head["log_time"] == pairs[:, 0]
        if not fits.all() or (len(offset) > 1 and (np.diff(offset) <= 0).any()):
            return None
        covered += int(head["length"].sum()) + 9 * len(head)
        found[channel] = at_offsets(buffer, offset, head)
    return found if covered == len(buffer) else None


def by_walking(buffer: NDArray[np.uint8]) -> tuple[dict[int, Messages], list[tuple[int, bytes]]]:
    """Find a chunk's messages record by record.

    Returns
    -------
    messages : dict of channel to Messages
    others : list of (opcode, body)
        Its schemas and channels.

    Raises
    ------
    ValueError
        The chunk does not end where its last record does.
    """
    plain = buffer.tobytes()
    offsets: dict[int, list[int]] = {}
    others: list[tuple[int, bytes]] = []
    at, end = 0, len(plain)
    while at + RECORD.size <= end:
        opcode, length = RECORD.unpack_from(plain, at)
        body = at + RECORD.size
        if body + length > end:
            break
        if opcode == Opcode.MESSAGE and length >= FIELDS:
            offsets.setdefault(int.from_bytes(plain[body : body + 2], "little"), []).append(at)
        else:
            others.append((opcode, plain[body : body + length]))
        at = body + length
    if at != end:
        raise ValueError("its records do not fit into it")
    found = {}
    for channel, places in offsets.items():
        offset = np.array(places, dtype=np.int64)
        found[channel] = at_offsets(buffer, offset, heads(buffer, offset))
    return found, others
