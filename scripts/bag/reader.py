"""Reads a bag: its topics, and their fields as NumPy arrays."""

from __future__ import annotations

import warnings
from collections import deque
from collections.abc import Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from mcap.data_stream import ReadDataStream
from mcap.records import Attachment, Channel, Metadata, Schema
from numpy.typing import NDArray

from . import mcap_index, qos
from .cdr import Decoder
from .errors import BagDamaged, BagError
from .mcap_file import MAGIC
from .mcap_index import ChunkReader, Damage, FileIndex, Place
from .messages import RECORD, Messages, Thinner, merged
from .table import Table, changing

if TYPE_CHECKING:
    import pandas
    import pyarrow

# Chunks are read and unpacked ahead by other threads, which do that without Python's lock.
THREADS = 2
AHEAD = 6
# What is decoded at once: enough to be quick, little enough for any memory.
BATCH_MESSAGES = 4096
BATCH_SIZE = 32 * 1024 * 1024
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
    robot : str
        Of several robots the one that is meant, by the name of its simulator; "": the first.

    Attributes
    ----------
    topics : dict of str to Topic
    start, end : int, ns since the epoch
        First and last log time.
    damages : list of Damage
        What can't be read, as far as is known; all else can be. What is found later, while
        messages are read, is added, with a `BagDamaged` warning.

    Raises
    ------
    BagError
        There is no bag at `path`.
    """

    def __init__(self, path: str | Path, robot: str = "") -> None:
        self.path = Path(path)
        self.robot = robot
        self.files = mcap_files(self.path)
        self.topics: dict[str, Topic] = {}
        self.start, self.end = 0, 0
        self.damages: list[Damage] = []
        self.indices: dict[Path, FileIndex] = {}
        self._decoders: dict[str, Decoder] = {}
        for file in self.files:
            self._open(file)

    @property
    def complete(self) -> bool:
        """False where something can't be read, as far as is known."""
        return not self.damages

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
            Its path in the message, for example "position", "header.stamp.sec", or of an array's
            numbers only some: "position[-3:]".
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
        table = self.table(topic, fields, period)
        for messages in self.read([topic], {topic: period}):
            table.add(messages[topic])
        return table.columns()

    def table(self, topic: str, fields: list[str], period: float = 0.0) -> Table:
        """Return an empty table of some fields of a topic, for whoever reads several topics at once."""
        return Table(topic, self.decoder(topic), fields, self.expected(topic, period), period)

    def expected(self, topic: str, period: float) -> int:
        """Return about how many messages of a topic `columns` gives, by the index."""
        count = self.topic(topic).count
        return min(count, int(self.duration / period) + 2) if period else count

    def batches(
        self, topic: str, fields: list[str], *, period: float = 0.0
    ) -> Iterator[tuple[NDArray[np.int64], dict[str, NDArray[Any]]]]:
        """Give what `columns` returns piece by piece, so that a bag need not fit into memory."""
        found = self.topic(topic)
        decoder = self.decoder(topic)
        times: list[NDArray[np.int64]] = []
        parts: list[dict[str, NDArray[Any]]] = []
        count = size = 0

        def batch() -> tuple[NDArray[np.int64], dict[str, NDArray[Any]]]:
            columns = {n: self._joined(found.name, n, [p[n] for p in parts]) for n in fields}
            return np.concatenate(times), columns

        for messages in self.read([topic], {topic: period}):
            some = messages[topic]
            columns = decoder.columns(some, fields)
            alike = not parts or all(columns[n].shape[1:] == parts[0][n].shape[1:] for n in fields)
            if count and not (alike and count < BATCH_MESSAGES and size < BATCH_SIZE):
                yield batch()
                times, parts, count, size = [], [], 0, 0
            times.append(some.log_time)
            parts.append(columns)
            count += len(some)
            size += sum(values.nbytes for values in columns.values())
        if count:
            yield batch()

    def times(self, topic: str) -> NDArray[np.int64]:
        """Return the log times of a topic's messages: (K,), ns since the epoch."""
        self.topic(topic)
        parts = [messages[topic].log_time for messages in self.read([topic])]
        return np.concatenate(parts) if parts else np.empty(0, np.int64)

    def messages(self, topic: str) -> Iterator[tuple[int, bytes]]:
        """Give the log time and the CDR bytes of each message of a topic, in order."""
        self.topic(topic)
        for messages in self.read([topic]):
            some = messages[topic]
            yield from zip(some.log_time.tolist(), some.data(), strict=True)

    def last(self, topic: str) -> bytes | None:
        """Return the CDR bytes of a topic's last message; None where it has none."""
        self.topic(topic)
        found: bytes | None = None
        for file in reversed(self.files):
            numbers = self._numbers(file, [topic])
            places = [p for p in self.indices[file].places if has(p, numbers)]
            with ExitStack() as stack:
                reader = ChunkReader(file)
                stack.callback(reader.close)
                for place in reversed(places):
                    read = self._checked(reader(place))
                    some = [read[n] for n in numbers if n in read]
                    if some:
                        found = max(some, key=lambda m: int(m.log_time[-1]))[-1:].data()[0]
                        return found
        return found

    def dataframe(self, topic: str, fields: list[str] | None = None) -> pandas.DataFrame:
        """Return a topic as a table of pandas, indexed by receive time; see `arrow`."""
        import pandas

        table = self.arrow(topic, fields).to_pandas()
        table.index = pandas.to_datetime(table.pop("log_time"))
        return table

    def arrow(self, topic: str, fields: list[str] | None = None) -> pyarrow.Table:
        """Return a topic as a table of Arrow, for `pyarrow.parquet.write_table`.

        Arrays become lists. Without `fields` all are taken that all of the messages have.
        """
        import pyarrow

        names = self.fields(topic) if fields is None else fields
        log, values = self.columns(topic, names)
        cells = {n: list(v) if v.ndim > 1 else v for n, v in values.items()}
        return pyarrow.table({"log_time": pyarrow.array(log, pyarrow.timestamp("ns")), **cells})

    def fields(self, topic: str) -> list[str]:
        """Return the names of the fields of a topic's first message."""
        first = next(self.messages(topic), None)
        return [] if first is None else list(self.decoder(topic).layout(first[1]).places)

    def read(
        self,
        topics: list[str] | None = None,
        period: Mapping[str, float] | None = None,
    ) -> Iterator[dict[str, Messages]]:
        """Give messages as they lie in the bag, a chunk at a time, undecoded.

        Parameters
        ----------
        topics : list of str, optional
            All if not given.
        period : mapping of topic to s, optional
            At most one message of the topic each period is given.
        """
        wanted = list(self.topics) if topics is None else topics
        keep = {name: Thinner((period or {}).get(name, 0.0)) for name in wanted}
        with ExitStack() as stack:
            pool = stack.enter_context(ThreadPoolExecutor(THREADS))
            for file in self.files:
                numbers = self._numbers(file, wanted)
                if not numbers:
                    continue
                reader = ChunkReader(file)
                stack.callback(reader.close)
                places = needed(self.indices[file].places, numbers, keep)
                for read in ahead(pool, reader, places):
                    found: dict[str, Messages] = {}
                    for number, some in self._checked(read).items():
                        if number in numbers:
                            name = numbers[number]
                            some = keep[name](some)
                            if len(some):
                                found[name] = merged(found[name], some) if name in found else some
                    if found:
                        yield found

    def attachment(self, name: str) -> bytes | None:
        """Return a file that was put into the bag; None where there is none of that name."""
        for file, index in self.indices.items():
            if name in index.attachments:
                return bytes(record(file, index.attachments[name], Attachment).data)
        return None

    def notes(self) -> dict[str, dict[str, str]]:
        """Return the pairs of a key and a text that were put into the bag, by name."""
        return {
            name: dict(record(file, place, Metadata).metadata)
            for file, index in self.indices.items()
            for name, place in index.metadata.items()
        }

    def attachments(self) -> list[str]:
        """Return the names of the files that were put into the bag."""
        return sorted({name for index in self.indices.values() for name in index.attachments})

    def decoder(self, topic: str) -> Decoder:
        """Return what decodes a topic."""
        if topic not in self._decoders:
            found = self.topic(topic)
            self._decoders[topic] = Decoder(found.type, found.schema)
        return self._decoders[topic]

    def _joined(self, topic: str, name: str, pieces: list[NDArray[Any]]) -> NDArray[Any]:
        if len({piece.shape[1:] for piece in pieces}) > 1:
            raise BagError(changing(topic, name))
        return np.concatenate(pieces) if len(pieces) > 1 else pieces[0]

    def _numbers(self, file: Path, topics: list[str]) -> dict[int, str]:
        """Return the channels of some topics in a file."""
        return {n: t for t in topics for path, n in self.topics[t].channels if path == file}

    def _checked(self, read: dict[int, Messages] | Damage) -> dict[int, Messages]:
        if isinstance(read, Damage):
            if read not in self.damages:
                self.damages.append(read)
                warnings.warn(f"{self.path}: {read}; the rest is read", BagDamaged, stacklevel=4)
            return {}
        return read

    def _open(self, path: Path) -> None:
        index = mcap_index.read(path)
        nothing = index.damages and not (index.channels or index.places)
        if nothing and len(self.files) == 1 and path.stat().st_size and not is_mcap(path):
            raise BagError(f"{path} is not an MCAP file")
        self.indices[path] = index
        self.damages += index.damages
        for channel in index.channels.values():
            topic = self._open_topic(path, channel, index.schemas.get(channel.schema_id))
            topic.count += index.counts.get(channel.id, 0)
        if index.count:
            self.start = min(self.start or index.first, index.first)
            self.end = max(self.end, index.last)

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


def needed(places: list[Place], numbers: dict[int, str], keep: dict[str, Thinner]) -> Iterator[Place]:
    """Give the chunks that hold wanted messages."""
    for place in places:
        inside = [t for n, t in numbers.items() if place.channels is None or n in place.channels]
        if inside and sum(keep[topic].needs(place.last) for topic in inside):
            yield place


def has(place: Place, numbers: Mapping[int, str]) -> bool:
    """Say whether a chunk may hold messages of these channels."""
    return place.channels is None or not place.channels.isdisjoint(numbers)


def ahead(
    pool: ThreadPoolExecutor, reader: ChunkReader, places: Iterator[Place]
) -> Iterator[dict[int, Messages] | Damage]:
    """Give what lies at these places, in order, some being read while others are worked on."""
    waiting: deque[Future[dict[int, Messages] | Damage]] = deque()
    try:
        for place in places:
            waiting.append(pool.submit(reader, place))
            if len(waiting) > AHEAD:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    finally:
        for future in waiting:
            future.cancel()


def record(file: Path, place: tuple[int, int], kind: Any) -> Any:
    """Read a record that the index names; raises BagError where it is damaged."""
    offset, length = place
    with file.open("rb") as stream:
        stream.seek(offset + RECORD.size)
        body = stream.read(length - RECORD.size)
    try:
        return kind.read(ReadDataStream(BytesIO(body)))
    except mcap_index.BROKEN as problem:
        raise BagError(f"{file}, byte {offset}: a record can't be read: {problem}") from None


def is_mcap(path: Path) -> bool:
    """Say whether a file begins as MCAP files do."""
    with path.open("rb") as file:
        return file.read(len(MAGIC)) == MAGIC


def mcap_files(path: Path) -> list[Path]:
    """Return a bag's MCAP files; raises BagError where `path` is not a bag."""
    if not path.exists():
        raise BagError(f"{path} does not exist")
    files = sorted(path.glob("*.mcap"), key=file_number) if path.is_dir() else [path]
    if not files:
        raise BagError(f"{path} is not a bag: it holds no .mcap file")
    return files


def file_number(path: Path) -> tuple[int, str]:
    """Return a split file's number, so that run_10 comes behind run_9."""
    last = path.stem.rpartition("_")[2]
    return (int(last) if last.isdigit() else 0, path.name)
