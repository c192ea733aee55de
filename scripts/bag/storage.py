"""The two storages of rosbag2 behind one door: MCAP and sqlite3."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol

import numpy as np

from . import mcap_index, sqlite_file
from .index import Damage, FileIndex, Place
from .mcap_index import LARGEST_CHUNK, ChunkReader, unzstd
from .messages import Messages, of_list
from .opening import ZSTD, is_sqlite
from .sqlite_file import SqliteReader


class Reader(Protocol):
    """Reads what lies at a place; can be called from several threads."""

    def __call__(self, place: Place) -> dict[int, Messages] | Damage:
        """Return a place's messages by channel, or why they can't be read."""

    def close(self) -> None:
        """Close the file."""


def index(path: Path) -> FileIndex:
    """Return what is in a file; never raises for what is in it, only OSError where it can't be read."""
    return sqlite_file.read(path) if is_sqlite(path) else mcap_index.read(path)


def reader(path: Path, compressed: str = "") -> Reader:
    """Return what reads a file's messages, unpacked.

    compressed : how each message is compressed by itself, as metadata.yaml says
    """
    plain: Reader = SqliteReader(path) if is_sqlite(path) else ChunkReader(path)
    return Unpacking(plain, path, compressed)


class Unpacking:
    """Unpacks messages that are compressed each by itself.

    A message of CDR begins with a zero, so one that begins as zstd's frames do is compressed, whether
    metadata.yaml is there to say so or not.
    """

    def __init__(self, plain: Reader, path: Path, compressed: str) -> None:
        self.plain, self.path, self.compressed = plain, path, compressed

    def close(self) -> None:
        """Close the file."""
        self.plain.close()

    def __call__(self, place: Place) -> dict[int, Messages] | Damage:
        """Return a place's messages by channel, or why they can't be read."""
        read = self.plain(place)
        if isinstance(read, Damage):
            return read
        if self.compressed not in ("", "zstd"):
            what = f"its messages are compressed by {self.compressed}, which can't be unpacked"
            return Damage(self.path, place.offset, what, place.first, place.last)
        if not any(is_packed(some) for some in read.values()):
            return read
        try:
            return dict(zip(read, unpacked(list(read.values())), strict=True))
        except ValueError as problem:
            what = f"a compressed message is damaged: {problem}"
            return Damage(self.path, place.offset, what, place.first, place.last)


def is_packed(some: Messages) -> bool:
    """Say whether messages are compressed each by itself."""
    if not len(some) or int(some.size.min()) < len(ZSTD):
        return False
    head = some.buffer[some.start[:1, None] + np.arange(len(ZSTD))]
    return bytes(head[0].tobytes()) == ZSTD


def unpacked(all_of_them: list[Messages]) -> list[Messages]:
    """Return messages of several channels, unpacked, in one buffer and in the order in which they lay.

    Raises
    ------
    ValueError
        One can't be unpacked, or all together are larger than any chunk.
    """
    import zstandard

    pieces: list[tuple[int, int, int, bytes]] = []
    room = LARGEST_CHUNK
    for channel, some in enumerate(all_of_them):
        for k, (start, data) in enumerate(zip(some.start.tolist(), some.data(), strict=True)):
            if data.startswith(ZSTD):
                try:
                    size = zstandard.frame_content_size(data)
                except zstandard.ZstdError as problem:
                    raise ValueError("it can't be decompressed") from problem
                if size > room:
                    raise ValueError("it is too large")
                data = unzstd(data, size if size >= 0 else min(room, 1 << 28))
            room -= len(data)
            pieces.append((start, channel, k, data))
    pieces.sort(key=lambda piece: piece[0])
    together = of_list([data for *_, data in pieces])
    start = {(channel, k): i for i, (_, channel, k, _) in enumerate(pieces)}
    found = []
    for channel, some in enumerate(all_of_them):
        which = np.array([start[channel, k] for k in range(len(some))], dtype=np.int64)
        mine = together[which]
        found.append(
            Messages(
                mine.buffer,
                mine.start,
                mine.size,
                some.log_time,
                some.publish_time,
                some.sequence,
                some.channel,
            )
        )
    return found
