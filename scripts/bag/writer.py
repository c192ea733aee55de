"""Writes a bag: a folder with one MCAP file and metadata.yaml, as rosbag2 lays it out."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

from mcap.writer import CompressionType, Writer
from ruamel.yaml import YAML

from . import qos
from .definitions import definition, type_hash
from .errors import BagError

# Small chunks and a flush a second bound what a killed recorder loses.
CHUNK_SIZE = 256 * 1024
FLUSH_PERIOD = 1.0


@dataclass
class Written:
    """What one topic's channel has received so far."""

    name: str
    type: str
    profiles: list[qos.Qos]
    hash: str
    count: int = 0


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

    Raises
    ------
    BagError
        The folder exists.
    """

    def __init__(self, path: str | Path, *, flush_period: float = FLUSH_PERIOD) -> None:
        self.path = Path(path)
        try:
            self.path.mkdir(parents=True)
        except FileExistsError:
            raise BagError(f"{path} exists already; name another bag or remove it") from None
        self.topics: dict[int, Written] = {}
        self.count = 0
        self._file_name = f"{self.path.absolute().name}_0.mcap"
        self._file = (self.path / self._file_name).open("wb")
        self._writer = Writer(self._file, chunk_size=CHUNK_SIZE, compression=CompressionType.ZSTD)
        self._writer.start("ros2", "flexsim")
        self._schemas: dict[str, int] = {}
        self._first = 0
        self._last = 0
        self._flush_period = flush_period
        self._flushed = time.monotonic()

    @property
    def size(self) -> int:
        """Bytes in the file so far."""
        return self._file.tell()

    def add_topic(self, name: str, type_name: str, profiles: list[qos.Qos] | None = None) -> int:
        """Open a channel for a topic and return its number.

        Parameters
        ----------
        name : str
            The topic, with its leading slash.
        type_name : str
            `pkg/msg/Type`; its definition is taken from the installed package.
        profiles : list of dict, optional
            The quality of service that the publishers offer; reliable, depth 10 if not given.
        """
        offered = [qos.offered()] if profiles is None else profiles
        if type_name not in self._schemas:
            text = definition(type_name).encode()
            self._schemas[type_name] = self._writer.register_schema(type_name, "ros2msg", text)
        written = Written(name, type_name, offered, type_hash(type_name))
        channel = self._writer.register_channel(
            name,
            "cdr",
            self._schemas[type_name],
            {"offered_qos_profiles": qos.to_yaml(offered), "topic_type_hash": written.hash},
        )
        self.topics[channel] = written
        return channel

    def write(
        self,
        channel: int,
        data: bytes,
        log_time: int,
        publish_time: int | None = None,
        sequence: int = 0,
    ) -> None:
        """Append one message.

        Parameters
        ----------
        channel : int
            What `add_topic` returned.
        data : bytes
            The message in CDR, with its encapsulation header.
        log_time, publish_time : int, ns since the epoch
            When it was received and sent. Times in a bag never run backwards, so an earlier
            `log_time` than the last one is written as the last one.
        """
        if self.count == 0:
            self._first = log_time
        elif log_time < self._last:
            log_time = self._last
        self._last = log_time
        self._writer.add_message(
            channel, log_time, data, log_time if publish_time is None else publish_time, sequence
        )
        self.topics[channel].count += 1
        self.count += 1

    def flush_if_due(self) -> None:
        """Hand the open chunk to the file system if it has waited long enough."""
        now = time.monotonic()
        if now - self._flushed >= self._flush_period:
            self._writer.flush()
            self._flushed = now

    def close(self) -> None:
        """Finish the file and write metadata.yaml; closing twice does nothing."""
        if self._file.closed:
            return
        try:
            self._writer.finish()
        finally:
            self._file.close()
        write_metadata(self.path, self._metadata())

    def __enter__(self) -> BagWriter:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _metadata(self) -> dict[str, Any]:
        extent = {
            "duration": {"nanoseconds": self._last - self._first},
            "starting_time": {"nanoseconds_since_epoch": self._first},
            "message_count": self.count,
        }
        return {
            "version": 9,
            "storage_identifier": "mcap",
            **extent,
            "topics_with_message_count": [
                {
                    "topic_metadata": {
                        "name": topic.name,
                        "type": topic.type,
                        "serialization_format": "cdr",
                        "offered_qos_profiles": topic.profiles,
                        "type_description_hash": topic.hash,
                    },
                    "message_count": topic.count,
                }
                for topic in self.topics.values()
            ],
            "compression_format": "",
            "compression_mode": "",
            "relative_file_paths": [self._file_name],
            "files": [{"path": self._file_name, **extent}],
            "custom_data": None,
            "ros_distro": os.environ.get("ROS_DISTRO", "jazzy"),
        }


def write_metadata(folder: Path, information: dict[str, Any]) -> None:
    """Write metadata.yaml whole or not at all."""
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False
    # A reader that follows no aliases must still see every profile.
    yaml.representer.ignore_aliases = lambda data: True
    yaml.sort_base_mapping_type_on_output = False  # type: ignore[assignment]
    unfinished = folder / "metadata.yaml.part"
    with unfinished.open("w", encoding="utf-8") as file:
        yaml.dump({"rosbag2_bagfile_information": information}, file)
    unfinished.replace(folder / "metadata.yaml")
