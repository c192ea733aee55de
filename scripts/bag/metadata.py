"""metadata.yaml: what rosbag2 says of a bag beside its files."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .plain_yaml import dump
from .qos import Qos


@dataclass(frozen=True)
class TopicInformation:
    """A topic, the quality of service that was offered, its type's hash, its messages."""

    name: str
    type: str
    profiles: list[Qos]
    hash: str
    count: int


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


def write_metadata(folder: Path, bag: BagInformation) -> None:
    """Write metadata.yaml whole or not at all."""
    unfinished = folder / "metadata.yaml.part"
    try:
        unfinished.write_text(dump({"rosbag2_bagfile_information": as_mapping(bag)}), encoding="utf-8")
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
                    "serialization_format": "cdr",
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
