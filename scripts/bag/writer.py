"""Writes a bag: a folder with MCAP files and metadata.yaml, as rosbag2 lays it out."""

from __future__ import annotations

import errno
import os
import resource
import time
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType

from . import qos
from .definitions import definition, type_hash
from .errors import BagError
from .mcap_file import CHUNK_SIZE, SMALLEST_END, McapFile
from .metadata import BagInformation, FileInformation, TopicInformation, write_metadata

# What a killed recorder loses: a chunk is handed to the system at least this often, s.
FLUSH_PERIOD = 1.0
# Kept free on the disk, so that a bag can be closed in good order when the disk is full.
RESERVE = 2 * CHUNK_SIZE
RESERVE_NAME = ".reserve"
# What a file system says that can reserve nothing, or a limit on files of that size.
UNABLE = {errno.EOPNOTSUPP, errno.EINVAL, errno.ENOSYS, errno.EFBIG}


@dataclass
class Written:
    """What one topic has received so far; `channel` is its number in the open file."""

    name: str
    type: str
    schema: str
    profiles: list[qos.Qos]
    hash: str
    count: int = 0
    channel: int = 0


@dataclass
class Extras:
    """What lies in a bag beside messages; it is put into each of its files."""

    attachments: dict[str, tuple[str, bytes, int]] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)


class BagWriter:
    """Writes already serialized messages into a new bag.

    >>> with BagWriter("run") as bag:                                # doctest: +SKIP
    ...     channel = bag.add_topic("/joint_states", "sensor_msgs/msg/JointState")
    ...     bag.write(channel, cdr_bytes, log_time=time.time_ns())

    Parameters
    ----------
    path : str or Path
        The bag's folder; must not exist yet.
    flush_period : float, s
        How long a message may wait before it is handed to the file system.
    max_size : int, bytes
        A new file is begun before one grows beyond this; 0: never.
    max_duration : float, s
        A new file is begun when one is as long as this; 0: never.

    Attributes
    ----------
    lost : int
        Messages that were taken but could not be kept, because the disk was full.

    Raises
    ------
    BagError
        The folder exists.
    OSError
        It can't be made, or the disk has no room for a bag.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        flush_period: float = FLUSH_PERIOD,
        max_size: int = 0,
        max_duration: float = 0.0,
    ) -> None:
        self.path = Path(path)
        try:
            self.path.mkdir(parents=True)
        except FileExistsError:
            raise BagError(f"{path} exists already; name another bag or remove it") from None
        self.topics: list[Written] = []
        self.count = 0
        self.lost = 0
        self.parts: list[McapFile] = []
        self._max_size = smallest_limit(max_size)
        self._max_duration = round(max_duration * 1e9)
        self._chunk_size = min(CHUNK_SIZE, max(4096, self._max_size // 4)) if self._max_size else CHUNK_SIZE
        self._last = 0
        self._extras = Extras()
        self._flush_period = flush_period
        self._flushed = time.monotonic()
        self._closed = False
        self._reserved = reserve(self.path / RESERVE_NAME, RESERVE)
        self._begin()

    @property
    def size(self) -> int:
        """Bytes in the files so far."""
        return sum(part.whole for part in self.parts)

    def add_topic(
        self,
        name: str,
        type_name: str,
        profiles: list[qos.Qos] | None = None,
        *,
        schema: str | None = None,
        hash: str | None = None,
    ) -> int:
        """Make a topic known and return its number.

        Parameters
        ----------
        name : str
            The topic, with its leading slash.
        type_name : str
            `pkg/msg/Type`.
        profiles : list of dict, optional
            The quality of service that the publishers offer; reliable, depth 10 if not given.
        schema, hash : str, optional
            The type's ros2msg text and its RIHS01 hash; from the installed package if not given.
        """
        offered = [qos.offered()] if profiles is None else profiles
        text = definition(type_name) if schema is None else schema
        said = type_hash(type_name) if hash is None else hash
        topic = Written(name, type_name, text, offered, said)
        self.topics.append(topic)
        self._open_channel(topic)
        return len(self.topics)

    def attach(self, name: str, media_type: str, data: bytes) -> None:
        """Put a file into the bag, such as the scene that was simulated."""
        self._extras.attachments[name] = (media_type, data, self._last)
        self._file.add_attachment(name, media_type, data, self._last)

    def note(self, name: str, pairs: dict[str, str]) -> None:
        """Put pairs of a key and a text into the bag, such as a node's parameters."""
        self._extras.metadata[name] = pairs
        self._file.add_metadata(name, pairs)

    def write(
        self,
        topic: int,
        data: bytes,
        log_time: int,
        publish_time: int | None = None,
        sequence: int = 0,
    ) -> None:
        """Append one message.

        Parameters
        ----------
        topic : int
            What `add_topic` returned.
        data : bytes
            The message in CDR, with its encapsulation header.
        log_time, publish_time : int, ns since the epoch
            When it was received and sent. Times in a bag never run backwards, so an earlier
            `log_time` than the last one is written as the last one.

        Raises
        ------
        OSError
            The disk is full, say. `close` then ends the bag in good order; what was taken so far
            is in it, except for what `lost` counts.
        """
        if self.count and log_time < self._last:
            log_time = self._last
        if self._is_full(len(data), log_time):
            self._split()
        self._last = log_time
        written = self.topics[topic - 1]
        written.count += 1
        self.count += 1
        self._file.write(
            written.channel, data, log_time, log_time if publish_time is None else publish_time, sequence
        )

    def flush_if_due(self) -> None:
        """Hand the open chunk to the file system if it has waited long enough.

        Raises
        ------
        OSError
            The disk has no room for it, or for the end of the file, which grows.
        """
        now = time.monotonic()
        if now - self._flushed >= self._flush_period:
            self._file.flush()
            self._flushed = now
            if self._reserved and self._reserved < RESERVE + self._file.end_size:
                # With so much to spare that it is not done again soon.
                self._reserved = reserve(self.path / RESERVE_NAME, RESERVE + 2 * self._file.end_size)

    def close(self) -> None:
        """Finish the file and write metadata.yaml; closing twice does nothing.

        Raises
        ------
        OSError
            The disk is so full that even this is not possible; `flexsim recover` mends the bag.
        """
        if self._closed:
            return
        self._closed = True
        (self.path / RESERVE_NAME).unlink(missing_ok=True)
        self._finish()
        write_metadata(self.path, self._information())

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def _file(self) -> McapFile:
        return self.parts[-1]

    def _begin(self) -> None:
        """Begin a file that can be read without the others."""
        name = f"{self.path.absolute().name}_{len(self.parts)}.mcap"
        self.parts.append(McapFile(self.path / name, chunk_size=self._chunk_size))
        self._schemas: dict[tuple[str, str], int] = {}
        for metadata, pairs in self._extras.metadata.items():
            self._file.add_metadata(metadata, pairs)
        for attachment, (media_type, data, created) in self._extras.attachments.items():
            self._file.add_attachment(attachment, media_type, data, created)
        for topic in self.topics:
            self._open_channel(topic)
        self._flushed = time.monotonic()

    def _open_channel(self, topic: Written) -> None:
        kind = (topic.type, topic.schema)
        if kind not in self._schemas:
            self._schemas[kind] = self._file.add_schema(topic.type, topic.schema.encode())
        topic.channel = self._file.add_channel(
            topic.name,
            self._schemas[kind],
            {"offered_qos_profiles": qos.to_yaml(topic.profiles), "topic_type_hash": topic.hash},
        )

    def _is_full(self, message: int, log_time: int) -> bool:
        file = self._file
        if file.count == 0:
            return False
        if self._max_duration and log_time - file.first >= self._max_duration:
            return True
        return bool(self._max_size) and file.size_with(message) > self._max_size

    def _split(self) -> None:
        self._finish()
        self._begin()

    def _finish(self) -> None:
        file = self._file
        if not file.closed:
            before = file.counts
            try:
                file.finish()
            finally:
                for topic in self.topics:
                    topic.count -= before.get(topic.channel, 0) - file.counts.get(topic.channel, 0)
                dropped = sum(before.values()) - file.count
                self.lost += dropped
                self.count -= dropped

    def _information(self) -> BagInformation:
        return BagInformation(
            [TopicInformation(t.name, t.type, t.profiles, t.hash, t.count) for t in self.topics],
            [FileInformation(p.path.name, p.first, p.last, p.count) for p in self.parts],
        )


def smallest_limit(asked: int) -> int:
    """Return how large a file may become, bytes: as asked, or as the system allows; 0: any size."""
    allowed, _ = resource.getrlimit(resource.RLIMIT_FSIZE)
    limits = [n for n in (asked, allowed) if 0 < n != resource.RLIM_INFINITY]
    return max(min(limits), SMALLEST_END) if limits else 0


def reserve(path: Path, size: int) -> int:
    """Keep space on the disk; returns how much, which is 0 where the file system can't; raises OSError."""
    new = not path.exists()
    try:
        with path.open("ab") as file:
            os.posix_fallocate(file.fileno(), 0, size)
    except OSError as failure:
        if new or failure.errno in UNABLE:
            path.unlink(missing_ok=True)
        if failure.errno in UNABLE:
            return 0
        if new:
            path.parent.rmdir()
        raise
    return size
