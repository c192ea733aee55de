"""Reads a bag: its topics, and their fields as NumPy arrays."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import SEEK_CUR, BytesIO
from pathlib import Path
from typing import IO, Any

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Message, Schema
from mcap.stream_reader import StreamReader, get_chunk_data_stream
from numpy.typing import NDArray

from . import qos
from .cdr import Decoder
from .errors import BagError

MAGIC = b"\x89MCAP0\r\n"
# What is decoded at once: enough to be quick, little enough for any memory.
BATCH_MESSAGES = 4096
BATCH_SIZE = 32 * 1024 * 1024
RECORD = struct.Struct("<BQ")
MESSAGE = struct.Struct("<HIQQ")
DAMAGED = (McapError, ValueError, EOFError, struct.error, OSError)
SECONDS = 1e-9


@dataclass
class Topic:
    """One topic of a bag."""

    name: str
    type: str
    schema: str
    profiles: list[qos.Qos]
    hash: str
    count: int = 0
    channels: set[tuple[Path, int]] = field(default_factory=set)


class Bag:
    """A bag that was recorded by this program, rosbag2, or any other that writes ROS 2 MCAP.

    Parameters
    ----------
    path : str or Path
        The bag's folder, or one .mcap file.

    Attributes
    ----------
    topics : dict of str to Topic
    start, end : int, ns since the epoch
        First and last log time.
    complete : bool
        False where the end of a file is missing; what can be read is there all the same.

    Raises
    ------
    BagError
        There is no bag at `path`.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.files = mcap_files(self.path)
        self.topics: dict[str, Topic] = {}
        self.start, self.end = 0, 0
        self.complete = True
        self._decoders: dict[str, Decoder] = {}
        for file in self.files:
            self._read_summary(file)

    @property
    def count(self) -> int:
        """Messages in the bag."""
        return sum(topic.count for topic in self.topics.values())

    @property
    def size(self) -> int:
        """Bytes of the bag's files."""
        return sum(file.stat().st_size for file in self.files)

    @property
    def duration(self) -> float:
        """Seconds from the first to the last message."""
        return (self.end - self.start) * SECONDS

    def seconds(self, log_time: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return log times as seconds since the bag's start."""
        return np.asarray((log_time - self.start) * SECONDS, dtype=np.float64)

    def topic(self, name: str) -> Topic:
        """Return a topic; raises BagError with the topics there are."""
        if name not in self.topics:
            there = ", ".join(sorted(self.topics)) or "no topics"
            raise BagError(f"{self.path} has no topic {name}; it has {there}")
        return self.topics[name]

    def array(
        self, topic: str, field: str, *, clock: str = "log"
    ) -> tuple[NDArray[np.float64], NDArray[Any]]:
        """Return a field of every message of a topic.

        Parameters
        ----------
        topic : str
            For example "/joint_states".
        field : str
            Its path in the message, for example "position" or "header.stamp.sec".
        clock : "log" or "stamp"
            Times are seconds since the bag's start, by receive time, or the messages' own
            header stamps.

        Returns
        -------
        t : ndarray (K,), s
        x : ndarray (K,) or (K, n)

        Raises
        ------
        BagError
            No such topic or field, or the field's length changes from message to message.
        """
        if clock not in ("log", "stamp"):
            raise BagError(f"clock is 'log' or 'stamp', not '{clock}'")
        stamps = ["header.stamp.sec", "header.stamp.nanosec"] if clock == "stamp" else []
        log, values = self.columns(topic, [field, *stamps])
        if clock == "stamp":
            t = np.float64(values[stamps[0]]) + values[stamps[1]] * SECONDS
        else:
            t = self.seconds(log)
        return t, values[field]

    def columns(
        self, topic: str, fields: list[str], *, period: float = 0.0
    ) -> tuple[NDArray[np.int64], dict[str, NDArray[Any]]]:
        """Return several fields of a topic's messages, at most one message each `period`.

        Returns
        -------
        log_time : ndarray (K,), ns since the epoch
        values : dict of field to ndarray (K,) or (K, n)
        """
        times: list[NDArray[np.int64]] = []
        parts: dict[str, list[NDArray[Any]]] = {name: [] for name in fields}
        for batch_times, columns in self.batches(topic, fields, period=period):
            times.append(batch_times)
            for name in fields:
                parts[name].append(columns[name])
        if not times:
            return np.empty(0, np.int64), {name: np.empty(0) for name in fields}
        for name, pieces in parts.items():
            if len({piece.shape[1:] for piece in pieces}) > 1:
                raise BagError(changing(self.topic(topic), name))
        values = {name: np.concatenate(pieces) for name, pieces in parts.items()}
        return np.concatenate(times), values

    def batches(
        self, topic: str, fields: list[str], *, period: float = 0.0
    ) -> Iterator[tuple[NDArray[np.int64], dict[str, NDArray[Any]]]]:
        """Give what `columns` returns piece by piece, so that a bag need not fit into memory."""
        found = self.topic(topic)
        for times, messages in self._raw_batches(found, Thinner(period)):
            yield np.asarray(times, dtype=np.int64), self._decoder(found).columns(messages, fields)

    def times(self, topic: str) -> NDArray[np.int64]:
        """Return the log times of a topic's messages: (K,), ns since the epoch."""
        parts = [np.asarray(t, dtype=np.int64) for t, _ in self._raw_batches(self.topic(topic))]
        return np.concatenate(parts) if parts else np.empty(0, np.int64)

    def messages(self, topic: str) -> Iterator[tuple[int, bytes]]:
        """Give the log time and the CDR bytes of each message of a topic, in order."""
        for times, batch in self._raw_batches(self.topic(topic)):
            yield from zip(times, batch, strict=True)

    def _decoder(self, topic: Topic) -> Decoder:
        if topic.name not in self._decoders:
            self._decoders[topic.name] = Decoder(topic.type, topic.schema)
        return self._decoders[topic.name]

    def _raw_batches(
        self, topic: Topic, keep: Callable[[int], bool] | None = None
    ) -> Iterator[tuple[list[int], list[bytes]]]:
        """Give a topic's log times and CDR bytes, some chunks together."""
        times: list[int] = []
        batch: list[bytes] = []
        size = 0
        for path in self.files:
            channels = {number for file, number in topic.channels if file == path}
            for records in self._chunks(path) if channels else ():
                before = len(batch)
                pick(records, channels, keep, times, batch)
                size += sum(map(len, batch[before:]))
                if size > BATCH_SIZE or len(batch) > BATCH_MESSAGES:
                    yield times, batch
                    times, batch, size = [], [], 0
        if batch:
            yield times, batch

    def _chunks(self, path: Path) -> Iterator[bytes]:
        """Give the records of each chunk, and each message that lies outside chunks.

        Message indices are skipped: reading them would cost more than the messages.
        """
        with path.open("rb") as file:
            file.seek(len(MAGIC))
            while True:
                head = file.read(RECORD.size)
                if len(head) < RECORD.size:
                    break
                opcode, length = RECORD.unpack(head)
                if opcode == Opcode.FOOTER:
                    return
                if opcode not in (Opcode.CHUNK, Opcode.MESSAGE):
                    file.seek(length, SEEK_CUR)
                    continue
                body = file.read(length)
                if len(body) < length:
                    break
                if opcode == Opcode.MESSAGE:
                    yield head + body
                    continue
                try:
                    chunk = Chunk.read(ReadDataStream(BytesIO(body)))
                    stream, size = get_chunk_data_stream(chunk, validate_crc=True)
                    yield stream.read(size)
                except DAMAGED:
                    self.complete = False
        self.complete = False

    def _records(self, file: IO[bytes]) -> Iterator[Any]:
        records = iter(StreamReader(file).records)
        while True:
            try:
                record = next(records)
            except StopIteration:
                return
            except DAMAGED:
                self.complete = False
                return
            yield record

    def _read_summary(self, path: Path) -> None:
        with path.open("rb") as file:
            try:
                summary = make_reader(file).get_summary()
            except DAMAGED:
                summary = None
        if summary is None or summary.statistics is None:
            self._scan(path)
            return
        statistics = summary.statistics
        for channel in summary.channels.values():
            topic = self._open_topic(path, channel, summary.schemas.get(channel.schema_id))
            topic.count += statistics.channel_message_counts.get(channel.id, 0)
        if statistics.message_count:
            self._extend(statistics.message_start_time, statistics.message_end_time)

    def _scan(self, path: Path) -> None:
        """Find the topics of a file without a summary by reading all of it."""
        schemas: dict[int, Schema] = {}
        topics: dict[int, Topic] = {}
        any_record = False
        with path.open("rb") as file:
            for record in self._records(file):
                any_record = True
                if isinstance(record, Schema):
                    schemas[record.id] = record
                elif isinstance(record, Channel):
                    topics[record.id] = self._open_topic(
                        path, record, schemas.get(record.schema_id)
                    )
                elif isinstance(record, Message) and record.channel_id in topics:
                    topics[record.channel_id].count += 1
                    self._extend(record.log_time, record.log_time)
        if not any_record:
            raise BagError(f"{path} is not an MCAP file")

    def _open_topic(self, path: Path, channel: Channel, schema: Schema | None) -> Topic:
        topic = self.topics.setdefault(
            channel.topic,
            Topic(
                channel.topic,
                schema.name if schema else "",
                schema.data.decode("utf-8", "replace") if schema else "",
                qos.from_yaml(channel.metadata.get("offered_qos_profiles", "")),
                channel.metadata.get("topic_type_hash", ""),
            ),
        )
        topic.channels.add((path, channel.id))
        return topic

    def _extend(self, first: int, last: int) -> None:
        self.start = min(self.start or first, first)
        self.end = max(self.end, last)


class Thinner:
    """Keeps at most one message each `period` seconds; a period of 0 keeps all."""

    def __init__(self, period: float) -> None:
        self.period = round(period / SECONDS)
        self.next = 0

    def __call__(self, log_time: int) -> bool:
        """Say whether the message of this time is kept."""
        if log_time < self.next:
            return False
        # On a fixed grid, so that jitter does not change the rate.
        if self.period:
            self.next = log_time - log_time % self.period + self.period
        return True


def pick(
    records: bytes,
    channels: set[int],
    keep: Callable[[int], bool] | None,
    times: list[int],
    batch: list[bytes],
) -> None:
    """Append log times and data of the messages of some channels among a chunk's records."""
    at, end = 0, len(records)
    while at + RECORD.size <= end:
        opcode, length = RECORD.unpack_from(records, at)
        at += RECORD.size
        if opcode == Opcode.MESSAGE and at + length <= end:
            channel, _, log_time, _ = MESSAGE.unpack_from(records, at)
            if channel in channels and (keep is None or keep(log_time)):
                times.append(log_time)
                batch.append(records[at + MESSAGE.size : at + length])
        at += length


def mcap_files(path: Path) -> list[Path]:
    """Return a bag's MCAP files; raises BagError where `path` is not a bag."""
    if not path.exists():
        raise BagError(f"{path} does not exist")
    files = sorted(path.glob("*.mcap"), key=file_number) if path.is_dir() else [path]
    if not files:
        raise BagError(f"{path} is not a bag: it holds no .mcap file")
    if path.is_file():
        with path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise BagError(f"{path} is not an MCAP file")
    return files


def file_number(path: Path) -> tuple[int, str]:
    """Return a split file's number, so that run_10 comes behind run_9."""
    last = path.stem.rpartition("_")[2]
    return (int(last) if last.isdigit() else 0, path.name)


def changing(topic: Topic, name: str) -> str:
    """Say that a field cannot be one array."""
    return f"the length of '{name}' changes within {topic.name}; read its messages one by one"
