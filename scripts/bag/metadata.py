"""metadata.yaml: what rosbag2 says of a bag beside its files; read, and written."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from .errors import BagError
from .qos import UNREADABLE, Qos
from .yaml_text import dump

NAME = "metadata.yaml"
KEY = "rosbag2_bagfile_information"
# YAML is slow to read, and no bag says so much of itself.
LARGEST = 1 << 22


@dataclass(frozen=True)
class Metadata:
    """What a metadata.yaml says.

    Attributes
    ----------
    files : names of the files, in order
    compression_mode, compression_format : as written; "" for none
    custom_data : pairs that a recorder put there
    types : type of each topic
    raw : all of it
    """

    files: list[str]
    compression_mode: str
    compression_format: str
    custom_data: dict[str, str]
    types: dict[str, str]
    raw: dict[str, Any]

    @property
    def per_message(self) -> bool:
        """Whether each message is compressed by itself."""
        return self.compression_mode.lower() == "message"


def read_metadata(path: Path) -> Metadata:
    """Read a metadata.yaml; raises BagError with the file and what is wrong."""
    if path.stat().st_size > LARGEST:
        raise BagError(f"{path} is larger than any description of a bag")
    try:
        read = YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8-sig"))
    except UNREADABLE as problem:
        said = str(problem).splitlines() or [type(problem).__name__]
        raise BagError(f"{path} can't be read: {said[0]}") from None
    told = read.get(KEY) if isinstance(read, dict) else None
    if not isinstance(told, dict):
        raise BagError(f"{path} does not describe a bag: it lacks {KEY}")
    files = told.get("relative_file_paths")
    if not isinstance(files, list) or not all(isinstance(name, str) for name in files):
        raise BagError(f"{path} does not list its bag's files under relative_file_paths")
    custom = told.get("custom_data")
    topics = told.get("topics_with_message_count")
    about = (
        [t.get("topic_metadata") for t in topics if isinstance(t, dict)] if isinstance(topics, list) else []
    )
    return Metadata(
        files,
        str(told.get("compression_mode") or ""),
        str(told.get("compression_format") or ""),
        {str(k): str(v) for k, v in custom.items()} if isinstance(custom, dict) else {},
        {str(t.get("name")): str(t.get("type")) for t in about if isinstance(t, dict)},
        told,
    )


@dataclass(frozen=True)
class TopicInformation:
    """A topic, the quality of service that was offered, its type's hash, its messages."""

    name: str
    type: str
    profiles: list[Qos]
    hash: str
    count: int
    encoding: str = "cdr"


@dataclass(frozen=True)
class FileInformation:
    """A file: its name, its first and last log time in ns, its messages."""

    name: str
    first: int
    last: int
    count: int


@dataclass(frozen=True)
class BagInformation:
    """All of a bag."""

    topics: list[TopicInformation]
    files: list[FileInformation]


# What a description says beside what is in the files, and keeps when it is written anew.
KEPT = ("compression_format", "compression_mode", "custom_data", "ros_distro")


def write_metadata(
    folder: Path, bag: BagInformation, before: Metadata | None = None, storage: str = "mcap"
) -> None:
    """Write metadata.yaml whole or not at all.

    before : what it said, of which is kept what the files don't say
    """
    told = as_mapping(bag) | {"storage_identifier": storage}
    if before is not None:
        told |= {key: before.raw[key] for key in KEPT if key in before.raw}
        told["custom_data"] = before.custom_data or None
    unfinished = folder / "metadata.yaml.part"
    try:
        unfinished.write_text(dump({KEY: told}), encoding="utf-8")
    except OSError:
        unfinished.unlink(missing_ok=True)
        raise
    unfinished.replace(folder / "metadata.yaml")


def as_mapping(bag: BagInformation) -> dict[str, Any]:
    """Return what metadata.yaml says, version 9."""
    filled = [file for file in bag.files if file.count]
    first = min((file.first for file in filled), default=0)
    last = max((file.last for file in filled), default=0)
    return {
        "version": 9,
        "storage_identifier": "mcap",
        **extent(first, last, sum(file.count for file in bag.files)),
        "topics_with_message_count": [
            {
                "topic_metadata": {
                    "name": topic.name,
                    "type": topic.type,
                    "serialization_format": topic.encoding,
                    "offered_qos_profiles": topic.profiles,
                    "type_description_hash": topic.hash,
                },
                "message_count": topic.count,
            }
            for topic in bag.topics
        ],
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file.name for file in bag.files],
        "files": [{"path": file.name, **extent(file.first, file.last, file.count)} for file in bag.files],
        "custom_data": None,
        "ros_distro": os.environ.get("ROS_DISTRO", "jazzy"),
    }


def extent(first: int, last: int, count: int) -> dict[str, Any]:
    """Return how long something is, from when on, and how many messages it has."""
    return {
        "duration": {"nanoseconds": last - first},
        "starting_time": {"nanoseconds_since_epoch": first},
        "message_count": count,
    }
