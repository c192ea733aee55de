"""What is in a file of a bag, and where: the same of every storage."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from mcap.records import Channel, Schema


@dataclass(frozen=True)
class Place:
    """Where a chunk lies in its file, or messages in a row outside chunks, which are taken for one.

    Attributes
    ----------
    offset, length : bytes of the record, with its head; of a database the first and the last row
    indices : bytes of the message indices behind it
    first, last : ns, log times
    channels : those it has messages of; None where that is not known
    size : bytes, unpacked
    """

    offset: int
    length: int
    indices: int
    first: int
    last: int
    channels: frozenset[int] | None = None
    size: int = 0


@dataclass(frozen=True)
class Damage:
    """What can't be read, and where: bytes of a file, and log times as far as they are known."""

    file: Path
    offset: int
    what: str
    first: int = 0
    last: int = 0

    def __str__(self) -> str:
        return f"{self.file.name}, byte {self.offset}: {self.what}"


@dataclass
class FileIndex:
    """What is in a file.

    Attributes
    ----------
    attachments, metadata : names, and where each lies: place and length
    counts : messages by channel
    first, last : ns, log times; None where there are no messages
    ended : whether the file has its end
    summed : whether the file's own summary was found, and is what this was made of
    chunked : whether it has chunks
    """

    path: Path
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    counts: dict[int, int] = field(default_factory=dict)
    places: list[Place] = field(default_factory=list)
    attachments: list[tuple[str, tuple[int, int]]] = field(default_factory=list)
    metadata: list[tuple[str, tuple[int, int]]] = field(default_factory=list)
    first: int | None = None
    last: int | None = None
    ended: bool = True
    summed: bool = False
    chunked: bool = False
    damages: list[Damage] = field(default_factory=list)

    @property
    def count(self) -> int:
        """Messages of all channels."""
        return sum(self.counts.values())

    def extend(self, first: int, last: int) -> None:
        """Take up log times."""
        self.first = first if self.first is None else min(self.first, first)
        self.last = last if self.last is None else max(self.last, last)
