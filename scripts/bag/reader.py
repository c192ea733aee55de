"""Reads a bag: its topics, and their fields as NumPy arrays."""

from __future__ import annotations

import heapq
import warnings
from collections import Counter
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from mcap.records import Attachment, Metadata
from numpy.typing import NDArray

from . import opening, qos, storage
from .ahead import ahead, has, needed, record
from .cdr import Decoder, TopicDecoder
from .channels import Kind, Topic, decoder_of, type_name
from .errors import BagDamaged, BagError
from .index import Damage, FileIndex, Place
from .joints import TYPE as JOINTS
from .joints import JointDecoder, Names, sets_of
from .layout import LIST
from .messages import Messages, Thinner, merged
from .table import Table, changing

if TYPE_CHECKING:
    import pandas
    import pyarrow

# Chunks are read and unpacked ahead by other threads, which do that without Python's lock.
THREADS = 2
# What is decoded at once: enough to be quick, little enough for any memory.
BATCH_MESSAGES = 4096
BATCH_SIZE = 32 * 1024 * 1024
LOOKED_AT = 200  # messages, among which every set of joints has told of itself
SECONDS = 1e-9


class Bag:
    """A bag that was recorded by this program, rosbag2, or any other that writes MCAP or rosbag2's sqlite3.

    Parameters
    ----------
    path : str or Path
        The bag's folder, its metadata.yaml, or one of its files.
    robot : str
        Of several robots the one that is meant, by the name of its simulator; "": the first.

    Attributes
    ----------
    topics : dict of str to Topic
    kinds : list of Kind
        Channels of all files, those that are alike as one; messages name theirs by its number here.
    files : list of Path, those that are read
    start, end : int, ns since the epoch
        First and last log time.
    damages : list of Damage
        What can't be read; what is found while messages are read is added, with a `BagDamaged` warning.

    Raises
    ------
    BagError
        There is no bag at `path`.
    """

    def __init__(self, path: str | Path, robot: str = "") -> None:
        self.path = Path(path)
        self.robot = robot
        self.opened = opening.find(self.path)
        if self.path.suffix in opening.DESCRIPTIONS and self.path.is_file():
            self.path = self.opened.folder
        self.files = self.opened.files
        self.topics: dict[str, Topic] = {}
        self.kinds: list[Kind] = []
        self.start, self.end = 0, 0
        self.damages: list[Damage] = []
        self.indices: dict[Path, FileIndex] = {}
        self._decoders: dict[str, TopicDecoder] = {}
        self._given: dict[Path, dict[int, int]] = {}
        self._numbered: dict[Kind, int] = {}
        self._of_kind: dict[tuple[str, str, str, bytes], Decoder | BagError] = {}
        for file in self.files:
            self._open(file)
        told = [index for index in self.indices.values() if index.first is not None]
        self.start = min((i.first or 0 for i in told), default=0)
        self.end = max((i.last or 0 for i in told), default=0)
        for name in self.opened.missing:
            self.damages.append(Damage(Path(name), 0, "metadata.yaml lists this file, which is not there"))
        if self.opened.why_no_metadata:
            self.damages.append(Damage(self.opened.folder / "metadata.yaml", 0, self.opened.why_no_metadata))

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
        return sum(file.stat().st_size for file in self.opened.names)

    @property
    def duration(self) -> float:
        """Seconds from the first to the last message."""
        return (self.end - self.start) * SECONDS

    def seconds(self, log_time: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return log times as seconds since the bag's start."""
        return np.asarray((log_time - self.start) * SECONDS, dtype=np.float64)

    def needs_messages(self) -> None:
        """Raise BagError where there are none, with the reason as far as it is known."""
        if not self.count:
            why = f": {self.damages[0]}" if self.damages else "" if self.topics else ", nor topics"
            raise BagError(f"{self.path} holds no messages{why}")

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
        self, topic: str, fields: list[str], *, period: float = 0.0, by_joint: bool = False
    ) -> tuple[NDArray[np.int64], dict[str, NDArray[Any]]]:
        """Return several fields of a topic's messages, at most one message each `period`.

        by_joint : of joint states those of one set of joints, in one order of them; see `joints`

        Returns
        -------
        log_time : ndarray (K,), ns since the epoch
        values : dict of field to ndarray (K,) or (K, n)
        """
        table = self.table(topic, fields, period, by_joint)
        for messages in self.read([topic], {topic: period}):
            table.add(messages[topic])
        return table.columns()

    def table(self, topic: str, fields: list[str], period: float = 0.0, by_joint: bool = False) -> Table:
        """Return an empty table of some fields of a topic, for whoever reads several topics at once."""
        named = by_joint and JOINTS in self.topic(topic).types
        decoder = self.joints(topic) if named else self.decoder(topic)
        return Table(topic, decoder, fields, self.expected(topic, period), period)

    def joints(self, topic: str) -> JointDecoder | TopicDecoder:
        """Return what decodes a topic's joint states by name: of several sets of joints the largest."""
        decoder = self.decoder(topic)
        sets: dict[Names, Names] = {}
        seen = 0
        with suppress(BagError):
            for messages in self.read([topic]):
                for names in sets_of(decoder, messages[topic]):
                    sets.setdefault(tuple(sorted(names)), names)
                seen += len(messages[topic])
                if seen >= LOOKED_AT:
                    break
        if not sets:
            return decoder
        chosen = max(sets.values(), key=len)
        others = [names for names in sets.values() if names is not chosen]
        return JointDecoder(decoder, chosen, others, f"{self.path}: {topic}")

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
                reader = storage.reader(file, self._compressed)
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

        names = [n for n in self.fields(topic) if LIST not in n] if fields is None else fields
        log, values = self.columns(topic, names)
        cells = {n: list(v) if v.ndim > 1 else v for n, v in values.items()}
        return pyarrow.table({"log_time": pyarrow.array(log, pyarrow.timestamp("ns")), **cells})

    def fields(self, topic: str) -> list[str]:
        """Return the names of the fields of a topic's first message; `poses[].x` is x of all in a list."""
        for messages in self.read([topic]):
            return self.decoder(topic).fields(messages[topic])
        return []

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
                reader = storage.reader(file, self._compressed)
                stack.callback(reader.close)
                places = needed(self.indices[file].places, numbers, keep)
                for read in ahead(pool, reader, places):
                    by_topic: dict[str, list[Messages]] = {}
                    for number, some in self._checked(read).items():
                        if number in numbers:
                            by_topic.setdefault(numbers[number], []).append(
                                self._given_out(file, number, some)
                            )
                    found = {name: keep[name](merged(some)) for name, some in by_topic.items()}
                    found = {name: some for name, some in found.items() if len(some)}
                    if found:
                        yield found

    def by_time(self, topics: list[str]) -> Iterator[tuple[int, str, int, bytes]]:
        """Give log time, topic, channel and bytes of each message, in the order of their log times.

        Chunks whose times overlap are held together, no more of them than do.
        """
        places: list[tuple[Place, Path]] = []
        numbers = {file: self._numbers(file, topics) for file in self.files}
        for file, mine in numbers.items():
            places += [(p, file) for p in self.indices[file].places if mine and has(p, mine)]
        places.sort(key=lambda place: place[0].first)
        held: list[tuple[int, int, str, int, bytes]] = []
        count = 0
        with ExitStack() as stack:
            pool = stack.enter_context(ThreadPoolExecutor(1))
            readers = {file: storage.reader(file, self._compressed) for file in self.files if numbers[file]}
            for reader in readers.values():
                stack.callback(reader.close)
            # One is read ahead, so that whoever plays need not wait for the disk.
            coming = [pool.submit(readers[file], place) for place, file in places[:1]]
            for k, (place, file) in enumerate(places):
                read = self._checked(coming.pop().result())
                if k + 1 < len(places):
                    after, where = places[k + 1]
                    coming.append(pool.submit(readers[where], after))
                while held and held[0][0] < place.first:
                    log_time, _, topic, channel, data = heapq.heappop(held)
                    yield log_time, topic, channel, data
                for number, some in read.items():
                    if number not in numbers[file]:
                        continue
                    topic, channel = numbers[file][number], self._given[file][number]
                    for log_time, data in zip(some.log_time.tolist(), some.data(), strict=True):
                        # Those of one time stay in the order in which they lie.
                        heapq.heappush(held, (log_time, count, topic, channel, data))
                        count += 1
            while held:
                log_time, _, topic, channel, data = heapq.heappop(held)
                yield log_time, topic, channel, data

    def attachment(self, name: str) -> bytes | None:
        """Return a file that was put into the bag; None where there is none of that name."""
        for file, index in self.indices.items():
            for found, place in index.attachments:
                if found == name:
                    return bytes(record(file, place, Attachment).data)
        return None

    def notes(self) -> dict[str, dict[str, str]]:
        """Return the pairs of a key and a text that were put into the bag, by name, as far as readable."""
        found: dict[str, dict[str, str]] = {}
        for file, index in self.indices.items():
            for name, place in index.metadata:
                with suppress(BagError):
                    found[name] = dict(record(file, place, Metadata).metadata)
        return found

    def attachments(self) -> list[str]:
        """Return the names of the files that were put into the bag."""
        return sorted({name for index in self.indices.values() for name, _ in index.attachments})

    def decoder(self, topic: str) -> TopicDecoder:
        """Return what decodes a topic, each message by its own channel.

        Raises
        ------
        BagError
            None of the topic's messages can be decoded: they are JSON, say, or their type is not described.
        """
        if topic not in self._decoders:
            kinds = {number: self.decoder_of(number) for number in self.topic(topic).numbers}
            self._decoders[topic] = TopicDecoder(topic, kinds)
        return self._decoders[topic]

    def why_not(self, topic: str) -> str:
        """Say why a topic's messages can't be decoded; "" where all can be."""
        why = [d for n in self.topic(topic).numbers if isinstance(d := self.decoder_of(n), BagError)]
        return str(why[0]) if why else ""

    def decoder_of(self, number: int) -> Decoder | BagError:
        """Return what decodes a channel's messages, or why they can't be decoded."""
        kind = self.kinds[number]
        key = kind.type, kind.encoding, kind.schema_encoding, kind.schema
        if key not in self._of_kind:
            self._of_kind[key] = decoder_of(kind)
        return self._of_kind[key]

    @property
    def _compressed(self) -> str:
        """How each message is compressed by itself; ""."""
        told = self.opened.metadata
        return (told.compression_format.lower() or "zstd") if told is not None and told.per_message else ""

    def _given_out(self, file: Path, number: int, some: Messages) -> Messages:
        """Return messages with the number of their channel in the bag, not in the file."""
        return replace(some, channel=np.full(len(some), self._given[file][number], np.int64))

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
        index = storage.index(path)
        self.indices[path] = index
        self.damages += index.damages
        alike: Counter[Kind] = Counter()
        for channel in index.channels.values():
            schema = index.schemas.get(channel.schema_id)
            kind = Kind(
                channel.topic,
                type_name(schema.name) if schema else "",
                channel.message_encoding,
                schema.encoding if schema else "",
                schema.data if schema else b"",
                tuple(sorted(channel.metadata.items())),
                0,
            )
            alike[kind] += 1
            kind = replace(kind, publisher=alike[kind] - 1)
            if kind not in self._numbered:
                self._numbered[kind] = len(self.kinds)
                self.kinds.append(kind)
            number = self._given.setdefault(path, {})[channel.id] = self._numbered[kind]
            self._open_topic(path, channel.id, number, index.counts.get(channel.id, 0))

    def _open_topic(self, path: Path, channel: int, number: int, count: int) -> None:
        kind = self.kinds[number]
        metadata = dict(kind.metadata)
        profiles = qos.from_yaml(metadata.get("offered_qos_profiles", ""))
        topic = self.topics.get(kind.topic)
        if topic is None or (count and not topic.count):
            # What its first messages are, not what a channel without any says.
            before = topic
            topic = self.topics[kind.topic] = Topic(
                kind.topic,
                kind.type,
                kind.schema.decode("utf-8", "replace"),
                kind.encoding,
                profiles,
                metadata.get("topic_type_hash", ""),
            )
            if before is not None:
                topic.numbers, topic.channels = before.numbers, before.channels
        topic.profiles += [profile for profile in profiles if profile not in topic.profiles]
        topic.count += count
        topic.channels.add((path, channel))
        if number not in topic.numbers:
            topic.numbers.append(number)
        if kind.type not in topic.types:
            topic.types.append(kind.type)
