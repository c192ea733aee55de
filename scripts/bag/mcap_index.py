"""Finds out what is in an MCAP file: from its summary, or where that is missing by reading on.

Reading on goes past damage: what can't be read is noted with its place, and the next chunk is
looked for.
"""

from __future__ import annotations

import mmap
import os
import struct
import threading
import zlib
from dataclasses import replace
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Footer,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
)
from numpy.typing import NDArray

from .index import Damage, FileIndex, Place
from .mcap_file import FOOTER_HEAD, FOOTER_LENGTH, MAGIC
from .messages import RECORD, Messages, by_index, by_walking

CHUNK_HEAD = struct.Struct("<QQQI")
LARGEST_CHUNK = 1 << 29
TOGETHER = 1 << 20
COMPRESSIONS = (b"", b"lz4", b"zstd")
BROKEN = (McapError, ValueError, EOFError, struct.error, OverflowError, MemoryError, RuntimeError)
TIMES = struct.Struct("<QQ")
# Times, place and length of a chunk, and the bytes of the places of its message indices.
CHUNK_INDEX = struct.Struct("<QQQQI")
INDEX_OFFSET = struct.Struct("<HQ")


def read(path: Path) -> FileIndex:
    """Return what is in a file; never raises for what is in it, only OSError where it can't be read."""
    with path.open("rb") as file:
        if path.stat().st_size == 0:
            empty = FileIndex(path, ended=False)
            empty.damages.append(Damage(path, 0, "the file is empty"))
            return empty
        with mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
            damaged = ""
            try:
                found = from_summary(path, data)
            except BROKEN:
                found, damaged = None, "the index at the file's end is damaged"
            return scan(path, data, damaged) if found is None else found


def parsed(kind: Any, body: bytes) -> Any:
    """Read a record's body; raises one of BROKEN."""
    stream = BytesIO(body)
    record = kind.read(ReadDataStream(stream))
    if stream.tell() > len(body):
        raise ValueError("longer than its record")
    return record


def from_summary(path: Path, data: mmap.mmap) -> FileIndex | None:
    """Read the summary; None where there is none, or not enough; raises one of BROKEN where it is damaged."""
    size = len(data)
    footer_at = size - len(MAGIC) - 9 - FOOTER_LENGTH
    if footer_at < len(MAGIC) or data[-len(MAGIC) :] != MAGIC:
        return None
    if RECORD.unpack_from(data, footer_at) != (Opcode.FOOTER, FOOTER_LENGTH):
        return None
    footer = parsed(Footer, data[footer_at + 9 : size - len(MAGIC)])
    start = footer.summary_start
    if not start or start == footer_at:
        return None
    if not len(MAGIC) < start < footer_at:
        raise ValueError("it is not where it is said to be")
    summary = data[start:footer_at]
    head = FOOTER_HEAD.pack(Opcode.FOOTER, FOOTER_LENGTH, start, footer.summary_offset_start)
    if footer.summary_crc and zlib.crc32(head, zlib.crc32(summary)) != footer.summary_crc:
        raise ValueError("its checksum is wrong")
    found = FileIndex(path, summed=True)
    statistics: Statistics | None = None
    at = 0
    while at + RECORD.size <= len(summary):
        opcode, length = RECORD.unpack_from(summary, at)
        body = summary[at + RECORD.size : at + RECORD.size + length]
        at += RECORD.size + length
        if at > len(summary):
            raise ValueError("it ends within a record")
        if opcode == Opcode.SCHEMA:
            schema = parsed(Schema, body)
            found.schemas[schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            channel = parsed(Channel, body)
            found.channels[channel.id] = channel
        elif opcode == Opcode.STATISTICS:
            statistics = parsed(Statistics, body)
        elif opcode == Opcode.CHUNK_INDEX:
            found.places.append(place_of(body))
        elif opcode == Opcode.ATTACHMENT_INDEX:
            a = parsed(AttachmentIndex, body)
            found.attachments.append((a.name, (a.offset, a.length)))
        elif opcode == Opcode.METADATA_INDEX:
            m = parsed(MetadataIndex, body)
            found.metadata.append((m.name, (m.offset, m.length)))
    if statistics is None or statistics.chunk_count != len(found.places):
        return None  # sound, but without an index
    said = (statistics.attachment_count, statistics.metadata_count)
    if said != (len(found.attachments), len(found.metadata)):
        return None
    if statistics.message_count and not (found.places and found.channels):
        return None  # messages outside chunks, or channels that only the data name
    found.counts = {n: statistics.channel_message_counts.get(n, 0) for n in found.channels}
    if found.count != statistics.message_count:
        return None
    if statistics.message_count:
        found.first, found.last = statistics.message_start_time, statistics.message_end_time
    for kind, named in ((Opcode.ATTACHMENT, found.attachments), (Opcode.METADATA, found.metadata)):
        for k, (name, (offset, _)) in enumerate(named):
            opcode, length = RECORD.unpack_from(data, offset)
            if opcode != kind or offset + RECORD.size + length > footer_at:
                raise ValueError("what it names is not where it is said to be")
            named[k] = name, (offset, RECORD.size + length)
    found.places.sort(key=lambda place: place.offset)
    at = 0
    for place in found.places:
        if place.offset < at or place.offset + place.length + place.indices > footer_at:
            raise ValueError("its chunks do not fit into the file")
        at = place.offset + place.length
    return found


def place_of(body: bytes) -> Place:
    """Read a chunk index, of which an hour has a hundred thousand; raises struct.error."""
    first, last, offset, length, size = CHUNK_INDEX.unpack_from(body)
    end = CHUNK_INDEX.size + size
    channels = frozenset(number for number, _ in INDEX_OFFSET.iter_unpack(body[CHUNK_INDEX.size : end]))
    (indices,) = struct.unpack_from("<Q", body, end)
    (name,) = struct.unpack_from("<I", body, end + 8)
    _, room = TIMES.unpack_from(body, end + 12 + name)
    return Place(offset, length, indices, first, last, channels or None, room)


def scan(path: Path, data: mmap.mmap, damaged: str = "") -> FileIndex:
    """Find all that can be read, from the beginning to the end of a file whose index may be damaged."""
    found = FileIndex(path, ended=False)
    size = len(data)
    inside: tuple[dict[int, Schema], dict[int, Channel]] = ({}, {})
    bare: list[Place] = []
    at = len(MAGIC)
    before: int | None = None
    if data[: len(MAGIC)] != MAGIC:
        found.damages.append(Damage(path, 0, "it does not begin as an MCAP file"))
        if not size > len(MAGIC) or not 1 <= data[len(MAGIC)] <= 0x0F:
            at = next_chunk(data, 0)
    while at < size:
        if data[at : at + len(MAGIC)] == MAGIC and at + len(MAGIC) == size:
            break
        length = sound_length(data, at, size)
        if length is None:
            # The record before may have said a wrong length; a chunk's has been checked.
            beyond = next_chunk(data, (at if before is None else before) + 1)
            before = None
            what = "the file ends within a record" if beyond >= size else "what stands here is no record"
            if not found.ended:
                found.damages.append(Damage(path, at, what))
            at = beyond
            continue
        opcode = data[at]
        body = at + RECORD.size
        before = None if opcode == Opcode.CHUNK else at
        try:
            if opcode in (Opcode.DATA_END, Opcode.FOOTER):
                if opcode == Opcode.DATA_END and not checked(data, at, body, length):
                    found.damages.append(Damage(path, at, "the checksum of all that lies before is wrong"))
                found.ended = True
            elif opcode == Opcode.CHUNK:
                take_chunk(found, data, at, RECORD.size + length, inside)
            elif opcode == Opcode.MESSAGE_INDEX:
                extend_indices(found, at, RECORD.size + length)
            elif not found.ended:
                take_record(found, opcode, data[body : body + length], at, bare)
        except BROKEN as problem:
            if opcode == Opcode.CHUNK:
                # Where its length is wrong, the next chunk begins within it.
                length = resumed(data, at, RECORD.size + length) - RECORD.size
            found.damages.append(damaged_record(path, data, at, opcode, problem))
        at = body + length
    if bare and found.chunked:
        # Nobody writes messages both in chunks and outside them.
        found.damages.append(Damage(path, bare[0].offset, "what stands here is no record"))
    else:
        take_bare(found, bare)
    # What bears a checksum counts for more.
    found.schemas.update(inside[0])
    found.channels.update(inside[1])
    unknown = sum(count for n, count in found.counts.items() if n not in found.channels)
    if unknown:
        found.damages.append(Damage(path, 0, f"{unknown} messages are of channels that nothing describes"))
    found.counts = {n: found.counts.get(n, 0) for n in found.channels}
    if not found.ended:
        if not any("ends within" in d.what for d in found.damages):
            found.damages.append(Damage(path, size, "the file has no end"))
    elif damaged or data[-len(MAGIC) :] != MAGIC:
        found.damages.append(Damage(path, size, damaged or "the file's end is damaged"))
    return found


def checked(data: mmap.mmap, at: int, body: int, length: int) -> bool:
    """Say whether the data's checksum is right, where there is one."""
    (said,) = struct.unpack_from("<I", data, body) if length >= 4 else (0,)
    if not said:
        return True
    found = 0
    for begin in range(0, at, 1 << 24):
        found = zlib.crc32(data[begin : min(at, begin + (1 << 24))], found)
    return bool(found == said)


def sound_length(data: mmap.mmap, at: int, size: int) -> int | None:
    """Return the length of the record that begins here; None where none does."""
    if at + RECORD.size > size:
        return None
    opcode, length = RECORD.unpack_from(data, at)
    if not 0 < opcode <= 0x0F or at + RECORD.size + length > size:
        return None
    return int(length)


def next_chunk(data: mmap.mmap, start: int) -> int:
    """Return where the next compressed chunk begins, or the end of the file."""
    back = RECORD.size + CHUNK_HEAD.size
    nearest = len(data)
    for name in (b"zstd", b"lz4"):
        mark = struct.pack("<I", len(name)) + name
        at = data.find(mark, start + back)
        while 0 <= at < nearest + back:
            begin = at - back
            length = sound_length(data, begin, len(data))
            if length is not None and data[begin] == Opcode.CHUNK and chunk_fits(data, begin, length):
                nearest = min(nearest, begin)
                break
            at = data.find(mark, at + 1)
    return nearest


def chunk_fits(data: mmap.mmap, at: int, length: int) -> bool:
    """Say whether a chunk's own lengths agree with its record's."""
    try:
        return unpacked_head(data, at, length)[-1] >= 0
    except BROKEN:
        return False


def unpacked_head(data: Any, at: int, length: int) -> tuple[int, int, int, int, bytes, int, int]:
    """Return a chunk's first, last, size, checksum, compression, and where its data lie, how long."""
    first, last, size, checksum = CHUNK_HEAD.unpack_from(data, at + RECORD.size)
    name_at = at + RECORD.size + CHUNK_HEAD.size
    (name_length,) = struct.unpack_from("<I", data, name_at)
    if name_length > 4:
        raise ValueError("its compression is unknown")
    compression = bytes(data[name_at + 4 : name_at + 4 + name_length])
    (packed,) = struct.unpack_from("<Q", data, name_at + 4 + name_length)
    begin = name_at + 12 + name_length
    if compression not in COMPRESSIONS:
        raise ValueError("its compression is unknown")
    if begin + packed != at + RECORD.size + length or size > LARGEST_CHUNK:
        raise ValueError("its lengths do not agree")
    return first, last, size, checksum, compression, begin, packed


def unpacked(data: Any, at: int, length: int) -> NDArray[np.uint8]:
    """Return a chunk's records; raises one of BROKEN.  `length` is without the record's head."""
    _, _, size, checksum, compression, begin, packed = unpacked_head(data, at, length)
    squeezed = memoryview(data)[begin : begin + packed]
    if compression == b"zstd":
        plain = unzstd(squeezed, size)
    elif compression == b"lz4":
        import lz4.frame

        plain = lz4.frame.LZ4FrameDecompressor().decompress(squeezed, max_length=size + 1)
    else:
        plain = bytes(squeezed)
    if len(plain) != size:
        raise ValueError("it is not as long as it says")
    if checksum and zlib.crc32(plain) != checksum:
        raise ValueError("its checksum is wrong")
    return np.frombuffer(plain, dtype=np.uint8)


def unzstd(squeezed: Any, size: int) -> bytes:
    """Decompress what is to have this size; raises ValueError, whatever it holds."""
    import zstandard

    try:
        # A frame that says of itself how large it is would get as much memory as it says.
        said = zstandard.frame_content_size(squeezed)
        if said not in (-1, size):
            raise ValueError("it is not as long as it says")
        return zstandard.ZstdDecompressor().decompress(squeezed, max_output_size=size)
    except zstandard.ZstdError as problem:
        raise ValueError("it can't be decompressed") from problem


def take_chunk(
    found: FileIndex,
    data: mmap.mmap,
    at: int,
    length: int,
    inside: tuple[dict[int, Schema], dict[int, Channel]],
) -> None:
    """Take up a chunk that was met; raises one of BROKEN."""
    found.chunked = True
    chunk = unpacked(data, at, length - RECORD.size)
    messages, others = by_walking(chunk)
    for opcode, body in others:
        if opcode == Opcode.SCHEMA:
            schema = parsed(Schema, body)
            inside[0][schema.id] = schema
        elif opcode == Opcode.CHANNEL:
            channel = parsed(Channel, body)
            inside[1][channel.id] = channel
    first = min((int(m.log_time.min()) for m in messages.values()), default=0)
    last = max((int(m.log_time.max()) for m in messages.values()), default=0)
    found.places.append(Place(at, length, 0, first, last, frozenset(messages), len(chunk)))
    for number, some in messages.items():
        found.counts[number] = found.counts.get(number, 0) + len(some)
        found.extend(int(some.log_time.min()), int(some.log_time.max()))


def extend_indices(found: FileIndex, at: int, length: int) -> None:
    """Count a message index to the chunk that it follows."""
    if not found.places:
        return
    last = found.places[-1]
    if last.offset + last.length + last.indices == at:
        found.places[-1] = replace(last, indices=last.indices + length)


def take_record(found: FileIndex, opcode: int, body: bytes, at: int, bare: list[Place]) -> None:
    """Take up a record that stands outside chunks; raises one of BROKEN."""
    if opcode == Opcode.SCHEMA:
        schema = parsed(Schema, body)
        found.schemas.setdefault(schema.id, schema)
    elif opcode == Opcode.CHANNEL:
        channel = parsed(Channel, body)
        found.channels.setdefault(channel.id, channel)
    elif opcode == Opcode.ATTACHMENT:
        name = parsed(Attachment, body).name
        found.attachments.append((name, (at, RECORD.size + len(body))))
    elif opcode == Opcode.METADATA:
        name = parsed(Metadata, body).name
        found.metadata.append((name, (at, RECORD.size + len(body))))
    elif opcode == Opcode.MESSAGE and len(body) >= 22:
        channel_number, _ = struct.unpack_from("<HI", body)
        log_time, _ = TIMES.unpack_from(body, 6)
        bare.append(Place(at, RECORD.size + len(body), 0, log_time, log_time, frozenset((channel_number,))))


def take_bare(found: FileIndex, places: list[Place]) -> None:
    """Take up the messages that stand outside chunks, those in a row together."""
    together: list[Place] = []
    for place in places:
        for number in place.channels or ():
            found.counts[number] = found.counts.get(number, 0) + 1
        found.extend(place.first, place.last)
        last = together[-1] if together else None
        if last and last.offset + last.length == place.offset and last.length + place.length < TOGETHER:
            together[-1] = Place(
                last.offset, last.length + place.length, 0, min(last.first, place.first),
                max(last.last, place.last), (last.channels or frozenset()) | (place.channels or frozenset()),
            )  # fmt: skip
        else:
            together.append(place)
    found.places = sorted([*found.places, *together], key=lambda place: place.offset)


def resumed(data: mmap.mmap, at: int, length: int) -> int:
    """Return by how much to go on behind a damaged chunk: its length, or to the next if that is near."""
    end = at + length
    if end < len(data) and sound_length(data, end, len(data)) is not None:
        return length
    return min(next_chunk(data, at + 1), len(data)) - at


def damaged_record(path: Path, data: mmap.mmap, at: int, opcode: int, problem: BaseException) -> Damage:
    """Say what is wrong with a record."""
    if opcode != Opcode.CHUNK:
        return Damage(path, at, f"a record of kind {opcode} can't be read")
    first, last = TIMES.unpack_from(data, at + RECORD.size)
    return Damage(path, at, f"a chunk is damaged: {problem}", first, last)


class ChunkReader:
    """Reads the messages of chunks; can be called from several threads."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file = path.open("rb")
        self._number = self._file.fileno()
        # Room that is used again costs much less than new room each time.
        self._room = threading.local()

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def __call__(self, place: Place) -> dict[int, Messages] | Damage:
        """Return a place's messages by channel, or why they can't be read."""
        data = self._read(place.offset, place.length + place.indices)
        damage = partial(Damage, self.path, place.offset, first=place.first, last=place.last)
        if len(data) < place.length:
            return damage("the file ends within a chunk")
        try:
            opcode, length = RECORD.unpack_from(data)
            if opcode == Opcode.MESSAGE and RECORD.size + length <= place.length and not place.indices:
                return by_walking(np.frombuffer(bytes(data), np.uint8))[0]
            if opcode != Opcode.CHUNK or RECORD.size + length != place.length:
                return damage("a chunk is damaged: it does not begin where the index says")
            if place.size and unpacked_head(data, 0, length)[2] != place.size:
                return damage("a chunk is damaged: it is not as long as the index says")
            chunk = unpacked(data, 0, length)
            found = by_index(chunk, data[place.length :]) if place.indices else None
            return by_walking(chunk)[0] if found is None else found
        except BROKEN as problem:
            return damage(f"a chunk is damaged: {problem}")

    def _read(self, offset: int, length: int) -> memoryview:
        """Return what stands in the file; it holds until this thread reads again."""
        room = getattr(self._room, "bytes", b"")
        if len(room) < length:
            room = self._room.bytes = bytearray(length + length // 4)
        into = memoryview(room)[:length]
        return into[: os.preadv(self._number, [into], offset)]
