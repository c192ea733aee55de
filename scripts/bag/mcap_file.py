"""Writes one MCAP file, so that whatever ends it, all but the open chunk can be read.

Layout: https://mcap.dev/spec. A chunk goes to the system in one piece, with its message indices.
Schemas and channels stand in the chunk that first needs them, as the format asks, and before it
once more, so that no single damage hides what the rest of the file is.
"""

from __future__ import annotations

import errno
import struct
import zlib
from array import array
from collections.abc import Callable
from pathlib import Path

from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

MAGIC = b"\x89MCAP0\r\n"
MESSAGE_HEAD = struct.Struct("<BQHIQQ")
MESSAGE_FIELDS = MESSAGE_HEAD.size - 9  # channel, sequence, log time, publish time
INDEX_HEAD = struct.Struct("<BQHI")
FOOTER_HEAD = struct.Struct("<BQQQ")
FOOTER_LENGTH = 20
# What the smallest end takes: DataEnd, Footer and the magic.
SMALLEST_END = 13 + 29 + len(MAGIC)
CHUNK_SIZE = 768 * 1024
# A message as large as this has a chunk of its own, so that whoever wants the small ones of a bag
# of images or temperature fields need not unpack those.
LARGE = 64 * 1024
# Of zstd: numbers of a robot become 3 to 5 % smaller at level 1, for twice the time there and back.
LEVEL = -1


class McapFile:
    """One file of a bag.

    Parameters
    ----------
    path : Path
        Must not exist yet.
    chunk_size : int
        Bytes, uncompressed, at which a chunk is closed.
    profile, library : str
        What the file says of itself.
    compression : "zstd", "lz4" or ""

    Attributes
    ----------
    count : int
        Messages so far.
    first, last : int, ns
        Log times of the first and the last message.
    whole : int
        Bytes of the file that hold whole records.
    """

    def __init__(
        self,
        path: Path,
        *,
        chunk_size: int = CHUNK_SIZE,
        profile: str = "ros2",
        library: str = "flexsim",
        compression: str = "zstd",
    ) -> None:
        self.path = path
        self.chunk_size = chunk_size
        self.count = 0
        self.first = self.last = 0
        self.whole = 0
        self._file = path.open("xb", buffering=0)
        self.compression = compression
        self._compress = compressor(compression)
        self._schemas: dict[int, Schema] = {}
        self._channels: dict[int, Channel] = {}
        self._counts: dict[int, int] = {}
        self._chunk = bytearray()
        self._in_chunk: dict[int, array[int]] = {}
        self._chunk_first = self._chunk_last = 0
        self._chunks: list[ChunkIndex] = []
        self._attachments: list[AttachmentIndex] = []
        self._metadata: list[MetadataIndex] = []
        self._summary = 1024  # bytes, at most, that the file's end takes
        self._put(MAGIC + encoded(Header(profile, library)))

    @property
    def closed(self) -> bool:
        """Whether the file is finished."""
        return self._file.closed

    def size_with(self, message: int) -> int:
        """Return the bytes of the file, at most, if it is finished with one more message of this length."""
        indices = sum(len(pairs) * pairs.itemsize for pairs in self._in_chunk.values())
        plain = len(self._chunk) + MESSAGE_HEAD.size + message
        # What can't be compressed grows by a little, and there are at most two chunks.
        return self.whole + plain + plain // 128 + indices + 16 + 2 * 1024 + self._summary

    @property
    def end_size(self) -> int:
        """Bytes that the end takes at most: it grows with every chunk."""
        return self._summary

    @property
    def counts(self) -> dict[int, int]:
        """Messages of each channel."""
        return dict(self._counts)

    def add_schema(self, name: str, text: bytes, encoding: str = "ros2msg", number: int = 0) -> int:
        """Describe a type; returns its number, the next one if none is asked for."""
        number = number or len(self._schemas) + 1
        schema = Schema(id=number, data=text, encoding=encoding, name=name)
        self._put(encoded(schema))
        self._chunk += encoded(schema)
        self._schemas[number] = schema
        self._summary += len(encoded(schema))
        return number

    def add_channel(
        self,
        topic: str,
        schema: int,
        metadata: dict[str, str],
        encoding: str = "cdr",
        number: int | None = None,
    ) -> int:
        """Open a channel; returns its number, the next one if none is asked for."""
        number = len(self._channels) + 1 if number is None else number
        channel = Channel(
            id=number, topic=topic, message_encoding=encoding, metadata=metadata, schema_id=schema
        )
        self._put(encoded(channel))
        self._chunk += encoded(channel)
        self._channels[number] = channel
        self._counts[number] = 0
        self._summary += len(encoded(channel)) + 10
        return number

    def add_attachment(
        self, name: str, media_type: str, data: bytes, time: int, created: int | None = None
    ) -> None:
        """Put a file into the bag."""
        created = time if created is None else created
        # mcap 1.6's fields stand in this order: created, logged.
        record = encoded(Attachment(created, time, name, media_type, data))
        index = AttachmentIndex(self.whole, len(record), time, created, len(data), name, media_type)
        self._put(record)
        self._attachments.append(index)
        self._summary += len(encoded(index))

    def add_metadata(self, name: str, pairs: dict[str, str]) -> None:
        """Put pairs of a key and a text into the bag."""
        record = encoded(Metadata(name, pairs))
        index = MetadataIndex(self.whole, len(record), name)
        self._put(record)
        self._metadata.append(index)
        self._summary += len(encoded(index))

    def write(self, channel: int, data: bytes, log_time: int, publish_time: int, sequence: int) -> None:
        """Append a message; raises OSError where the file system refuses a chunk: the message is kept."""
        large = len(data) >= LARGE
        try:
            if large:
                self.flush()
        finally:
            self._append(channel, data, log_time, publish_time, sequence)
        if large or len(self._chunk) >= self.chunk_size:
            self.flush()

    def _append(self, channel: int, data: bytes, log_time: int, publish_time: int, sequence: int) -> None:
        # Times rise where this program records; what it mends may be another's.
        self._chunk_first = min(self._chunk_first, log_time) if self._in_chunk else log_time
        self._chunk_last = max(self._chunk_last, log_time) if self._in_chunk else log_time
        self.first = min(self.first, log_time) if self.count else log_time
        self.last = max(self.last, log_time)
        index = self._in_chunk.get(channel)
        if index is None:
            index = self._in_chunk[channel] = array("Q")
        index.append(log_time)
        index.append(len(self._chunk))
        self._chunk += MESSAGE_HEAD.pack(
            Opcode.MESSAGE, MESSAGE_FIELDS + len(data), channel, sequence, log_time, publish_time
        )
        self._chunk += data
        self.count += 1
        self._counts[channel] += 1

    def flush(self) -> None:
        """Hand the open chunk to the system; raises OSError, and then can be called again."""
        if not self._in_chunk:
            return
        plain = bytes(self._chunk)
        squeezed = self._compress(plain)
        record = encoded(
            Chunk(
                compression=self.compression,
                data=squeezed,
                message_start_time=self._chunk_first,
                message_end_time=self._chunk_last,
                uncompressed_crc=zlib.crc32(plain),
                uncompressed_size=len(plain),
            )
        )
        indices, offsets = bytearray(), {}
        for channel, pairs in self._in_chunk.items():
            offsets[channel] = self.whole + len(record) + len(indices)
            body = pairs.tobytes()
            indices += INDEX_HEAD.pack(Opcode.MESSAGE_INDEX, 6 + len(body), channel, len(body))
            indices += body
        index = ChunkIndex(
            message_start_time=self._chunk_first,
            message_end_time=self._chunk_last,
            chunk_start_offset=self.whole,
            chunk_length=len(record),
            message_index_offsets=offsets,
            message_index_length=len(indices),
            compression=self.compression,
            compressed_size=len(squeezed),
            uncompressed_size=len(plain),
        )
        self._put(record + indices)
        self._chunks.append(index)
        self._summary += len(encoded(index))
        self._chunk.clear()
        self._in_chunk.clear()

    def finish(self) -> int:
        """Write the end of the file and close it; does what it can where the disk is full.

        Returns
        -------
        int
            Messages that could not be kept: those of the open chunk.

        Raises
        ------
        OSError
            Not even the smallest end could be written; the chunks are there all the same.
        """
        lost = 0
        try:
            try:
                self.flush()
            except OSError:
                lost = self._drop_chunk()
            for end in (self._end(), smallest_end()):
                try:
                    self._put(end)
                    return lost
                except OSError as failure:
                    problem = failure
            raise problem
        finally:
            self._file.close()

    def abandon(self) -> None:
        """Close the file as it is."""
        self._file.close()

    def _drop_chunk(self) -> int:
        lost = 0
        for channel, pairs in self._in_chunk.items():
            self._counts[channel] -= len(pairs) // 2
            lost += len(pairs) // 2
        self.count -= lost
        self.last = max((c.message_end_time for c in self._chunks), default=self.first)
        self._chunk.clear()
        self._in_chunk.clear()
        return lost

    def _put(self, data: bytes) -> None:
        """Append whole records, or nothing."""
        view = memoryview(data)
        try:
            while view:
                written = self._file.write(view)
                if not written:
                    raise OSError(errno.ENOSPC, "no space left on device")
                view = view[written:]
        except OSError:
            self._file.seek(self.whole)
            self._file.truncate()
            raise
        self.whole += len(data)

    def _end(self) -> bytes:
        """Return the end of the file: an index of all that is in it."""
        start = self.whole + len(encoded(DataEnd(0)))
        statistics = Statistics(
            attachment_count=len(self._attachments),
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._chunks),
            message_count=self.count,
            message_end_time=self.last,
            message_start_time=self.first,
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )
        groups: list[tuple[Opcode, list[McapRecord]]] = [
            (Opcode.SCHEMA, [*self._schemas.values()]),
            (Opcode.CHANNEL, [*self._channels.values()]),
            (Opcode.STATISTICS, [statistics]),
            (Opcode.CHUNK_INDEX, [*self._chunks]),
            (Opcode.ATTACHMENT_INDEX, [*self._attachments]),
            (Opcode.METADATA_INDEX, [*self._metadata]),
        ]
        summary, offsets = bytearray(), bytearray()
        for opcode, records in groups:
            body = b"".join(map(encoded, records))
            if body:
                offsets += encoded(SummaryOffset(opcode, start + len(summary), len(body)))
                summary += body
        offsets_start = start + len(summary)
        summary += offsets
        checked = zlib.crc32(
            FOOTER_HEAD.pack(Opcode.FOOTER, FOOTER_LENGTH, start, offsets_start), zlib.crc32(summary)
        )
        footer = encoded(Footer(start, offsets_start, checked))
        return encoded(DataEnd(0)) + bytes(summary) + footer + MAGIC


def compressor(name: str) -> Callable[[bytes], bytes]:
    """Return what compresses a chunk."""
    if name == "lz4":
        import lz4.frame

        return lambda data: bytes(lz4.frame.compress(data))
    if name == "":
        return lambda data: data
    import zstandard

    return zstandard.ZstdCompressor(level=LEVEL).compress


def smallest_end() -> bytes:
    """Return an end without an index: readers find their way through such a file by reading it."""
    return encoded(DataEnd(0)) + encoded(Footer(0, 0, 0)) + MAGIC


def encoded(record: McapRecord) -> bytes:
    """Return a record as it stands in a file."""
    builder = RecordBuilder()
    record.write(builder)
    return builder.end()
