"""Channels of a bag: each has its own type, encoding and definition; topics are what they share a name by."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from . import qos
from .cdr import Decoder
from .definitions import definition
from .errors import BagError

# Types without a field, whose definition is no text.
EMPTY = {"std_msgs/msg/Empty"}


@dataclass(frozen=True)
class Kind:
    """A channel's messages: their type, how they are encoded, and what the channel says of itself."""

    topic: str
    type: str
    encoding: str
    schema_encoding: str
    schema: bytes
    metadata: tuple[tuple[str, str], ...]
    publisher: int  # which of the channels of a file that are alike otherwise


@dataclass
class Topic:
    """One topic of a bag.

    Attributes
    ----------
    type, schema, encoding : of its first channel that holds something
    profiles : quality of service that was offered, of all its channels
    types : all that it has, in the order in which they come
    """

    name: str
    type: str
    schema: str
    encoding: str
    profiles: list[qos.Qos]
    hash: str
    count: int = 0
    types: list[str] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    channels: set[tuple[Path, int]] = field(default_factory=set)


def type_name(name: str) -> str:
    """Return a type's name as ROS writes it, whatever way it is written."""
    parts = name.replace("::", "/").split("/")
    return "/".join([parts[0], "msg", parts[1]] if len(parts) == 2 else parts)


def decoder_of(kind: Kind) -> Decoder | BagError:
    """Return what decodes a channel's messages, or why they can't be decoded."""
    if kind.encoding != "cdr":
        what = f"are {kind.encoding}" if kind.encoding else "say not how they are encoded"
        return BagError(f"the messages of {kind.topic} {what}, and only CDR is decoded")
    if not kind.type:
        return BagError(f"the bag does not say of which type the messages of {kind.topic} are")
    text = kind.schema.decode("utf-8", "replace")
    encoding = kind.schema_encoding or "ros2msg"
    if not text.strip() and kind.type not in EMPTY:
        try:
            text, encoding = definition(kind.type), "ros2msg"
        except BagError:
            return BagError(f"the bag does not describe {kind.type}, the type of {kind.topic}")
    try:
        return Decoder(kind.type, text, encoding)
    except BagError as problem:
        return problem
