"""Mends a bag: what can be read goes into files that are whole; what is whole already is left as it is.

Of a file that is written anew nothing is lost or relabelled that could be read: header, schemas and
channels with their numbers and encodings, compression, metadata, attachments, and each message byte for
byte. Then mcap's own reader has to find the same in it.
"""

from __future__ import annotations

import errno
import shutil
import zlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Attachment, Header, Metadata

from . import qos, storage
from .ahead import record
from .errors import BagError
from .index import Damage, FileIndex, Place
from .mcap_file import MAGIC, McapFile
from .mcap_index import BROKEN, ChunkReader, unpacked_head
from .messages import RECORD, Messages, merged
from .metadata import (
    NAME,
    BagInformation,
    FileInformation,
    TopicInformation,
    write_metadata,
)
from .metadata import (
    Metadata as Description,
)
from .opening import PACKED, Opened, find, is_sqlite
from .writer import RESERVE_NAME

UNFINISHED, DAMAGED = ".part", ".damaged"
Progress = Callable[[int, int], None]


@dataclass
class Mended:
    """What became of one file.

    Attributes
    ----------
    count : messages that it holds now
    expected : messages that it held, as far as its own index says; None where it has none
    lost : what could not be read
    kept : the file as it was, where something within it was damaged
    """

    file: Path
    count: int = 0
    expected: int | None = None
    lost: list[Damage] = field(default_factory=list)
    written_anew: bool = False
    kept: Path | None = None


def mend(path: Path, output: Path | None = None, progress: Progress = lambda *_: None) -> list[Mended]:
    """Mend a bag.

    Parameters
    ----------
    path : Path
        The bag's folder, its metadata.yaml, or one of its files.
    output : Path, optional
        Where to write a whole copy; if not given the bag itself is mended. A file that has damage
        within, not only a missing end, is kept beside as `.mcap.damaged`.
    progress : callable
        Called with the bytes of a file that were read, and its size.

    Raises
    ------
    BagError
        There is no bag, or nothing in it can be read, or `output` exists, or what was written could not
        be read back.
    """
    opened = find(path)
    found = [storage.index(file) for file in opened.files]
    damages = [damage for index in found for damage in index.damages]
    for name, file, index in zip(opened.names, opened.files, found, strict=True):
        if is_sqlite(file) and index.damages:
            raise BagError(no_database(name, index.damages[0]))
    if damages and not any(index.channels for index in found) and not any(map(begins, opened.files)):
        # It may be no bag at all: nothing is written, neither here nor beside it.
        raise BagError(f"{path} holds nothing that can be read: {damages[0]}")
    whole_bag = not path.is_file() or path.name == NAME
    folder = opened.folder
    if output is not None:
        if output.exists():
            raise BagError(f"{output} exists already; name another bag or remove it")
        output.mkdir(parents=True)
        folder = output
    results, indices = [], []
    try:
        for name, file, index in zip(opened.names, opened.files, found, strict=True):
            result, index = mend_file(name, file, index, folder / name.name, progress)
            results.append(result)
            indices.append(index)
        for missing in opened.missing:
            lost = Damage(Path(missing), 0, "metadata.yaml lists this file, which is not there")
            results.append(Mended(folder / Path(missing).name, lost=[lost]))
        if whole_bag or output is not None:
            describe(folder, opened, indices, any(r.lost or r.written_anew for r in results))
    except BaseException as problem:
        if output is not None:  # half a copy is none
            shutil.rmtree(output)
        if isinstance(problem, OSError) and problem.errno == errno.ENOSPC:
            raise BagError(f"the disk of {folder} is full; -o BAG writes elsewhere") from None
        raise
    for leftover in (RESERVE_NAME, "metadata.yaml.part"):
        (folder / leftover).unlink(missing_ok=True)
    return results


def no_database(name: Path, damage: Damage) -> str:
    """Say what to do with a damaged database."""
    return (
        f"{name} is an sqlite3 database that is damaged, {damage.what}; mend it with"
        f" sqlite3's own tool: sqlite3 {name} .recover | sqlite3 {name.stem}_mended.db3"
    )


def begins(file: Path) -> bool:
    """Say whether a file begins as MCAP files do, with a header that can be read."""
    with file.open("rb") as stream:
        start = stream.read(len(MAGIC) + 1)
    return start == MAGIC + bytes([Opcode.HEADER])


def mend_file(
    name: Path, file: Path, index: FileIndex, target: Path, progress: Progress = lambda *_: None
) -> tuple[Mended, FileIndex]:
    """Mend one file; `name` is its own, `file` where it lies unpacked, `target` may be `name` itself."""
    result = Mended(target, expected=index.count if index.summed else None, lost=list(index.damages))
    broken, counts = examined(file, index, progress)
    if not index.damages and not broken and counts == index.counts:
        if target != name:
            shutil.copyfile(name, target)
        result.count = index.count
        return result, index
    if is_sqlite(file):
        raise BagError(no_database(name, [*index.damages, *broken][0]))
    unfinished = target.with_name(target.name.removesuffix(PACKED) + UNFINISHED)
    unfinished.unlink(missing_ok=True)
    written = McapFile(unfinished, **of_source(file, index))
    try:
        digest = copy(file, index, written, result, progress)
        written.finish()
        if digest != read_back(unfinished):
            raise BagError(f"{unfinished} does not hold what was written; {name} is left as it was")
        if target.name.endswith(PACKED):
            packed(unfinished)
    except BaseException:
        if not written.closed:
            written.abandon()
        unfinished.unlink(missing_ok=True)
        raise
    result.written_anew = True
    if name == target and any(not is_end(d, file) for d in result.lost):
        result.kept = name.with_name(name.name + DAMAGED)
        name.replace(result.kept)
    unfinished.replace(target)
    if target.name.endswith(PACKED):
        result.count = written.count
        index.counts, index.first, index.last = written.counts, written.first, written.last
        return result, index
    found = storage.index(target)
    result.count = found.count
    return result, found


def examined(file: Path, index: FileIndex, progress: Progress) -> tuple[list[Damage], dict[int, int]]:
    """Read each chunk of a file; returns what can't be read, and the messages of each channel."""
    reader = storage.reader(file)
    counts = dict.fromkeys(index.counts, 0)
    broken = []
    size = file.stat().st_size
    try:
        for place in index.places:
            progress(min(place.offset, size), size)
            read = reader(place)
            if isinstance(read, Damage):
                broken.append(read)
                continue
            for number, some in read.items():
                counts[number] = counts.get(number, 0) + len(some)
    finally:
        reader.close()
    return broken, counts


def of_source(file: Path, index: FileIndex) -> dict[str, Any]:
    """Return what a file says of itself, and how its chunks are compressed, as McapFile takes it."""
    with file.open("rb") as stream:
        head = stream.read(4096)
    told = {"profile": "ros2", "library": "flexsim"}
    if head.startswith(MAGIC + bytes([Opcode.HEADER])):
        try:
            header = record(file, (len(MAGIC), RECORD.size + length_at(head, len(MAGIC))), Header)
            told = {"profile": header.profile, "library": header.library}
        except (BagError, *BROKEN):
            pass
    return told | {"compression": compression_of(file, index.places) if index.chunked or index.summed else ""}


def length_at(data: bytes, at: int) -> int:
    """Return the length of the record that begins here."""
    _, length = RECORD.unpack_from(data, at)
    return min(int(length), 1 << 20)


def compression_of(file: Path, places: Iterable[Place]) -> str:
    """Return how the first chunk is compressed."""
    for place in places:
        with file.open("rb") as stream:
            stream.seek(place.offset)
            data = stream.read(place.length)
        try:
            opcode, length = RECORD.unpack_from(data)
            if opcode == Opcode.CHUNK:
                return unpacked_head(data, 0, length)[4].decode()
        except BROKEN:
            continue
        return ""
    return "zstd"


def copy(file: Path, index: FileIndex, written: McapFile, result: Mended, progress: Progress) -> int:
    """Copy all that can be read; returns a checksum over all messages with all that belongs to them."""
    for name, where in index.metadata:
        try:
            written.add_metadata(name, dict(record(file, where, Metadata).metadata))
        except BagError as problem:
            result.lost.append(Damage(file, where[0], f"the metadata {name}: {problem}"))
    for name, where in index.attachments:
        try:
            found = record(file, where, Attachment)
            written.add_attachment(name, found.media_type, found.data, found.log_time, found.create_time)
        except BagError as problem:
            result.lost.append(Damage(file, where[0], f"the attachment {name}: {problem}"))
    for n, s in index.schemas.items():
        written.add_schema(s.name, s.data, s.encoding, n)
    for n, c in index.channels.items():
        written.add_channel(c.topic, c.schema_id, dict(c.metadata), c.message_encoding, n)
    reader = ChunkReader(file)
    size = file.stat().st_size
    digest = 0
    try:
        for place in index.places:
            progress(place.offset, size)
            read = reader(place)
            if isinstance(read, Damage):
                result.lost.append(read)
                continue
            for channel, data, log_time, publish_time, sequence in in_order(read):
                if channel in index.channels:
                    written.write(channel, data, log_time, publish_time, sequence)
                    head = f"{index.channels[channel].topic} {log_time} {publish_time} {sequence} "
                    digest = zlib.crc32(data, zlib.crc32(head.encode("utf-8", "replace"), digest))
    finally:
        reader.close()
    return digest


def read_back(file: Path) -> int:
    """Read a file by another reader, mcap's own, and return the same checksum; -1 where it can't."""
    from mcap.reader import NonSeekingReader

    digest = 0
    try:
        with file.open("rb") as stream:
            reader = NonSeekingReader(stream, validate_crcs=True)
            for _, channel, m in reader.iter_messages(log_time_order=False):
                head = f"{channel.topic} {m.log_time} {m.publish_time} {m.sequence} "
                digest = zlib.crc32(m.data, zlib.crc32(head.encode("utf-8", "replace"), digest))
    except (McapError, *BROKEN):
        return -1
    return digest


def packed(file: Path) -> None:
    """Compress a file as a whole, as the one was that it replaces."""
    import zstandard

    target = file.with_name(file.name + PACKED)
    try:
        with file.open("rb") as source, target.open("wb") as into:
            zstandard.ZstdCompressor().copy_stream(source, into)
        target.replace(file)
    except BaseException:
        target.unlink(missing_ok=True)
        raise


def in_order(read: dict[int, Messages]) -> list[tuple[int, bytes, int, int, int]]:
    """Return a chunk's messages, of all channels, as they lie in it."""
    if not read:
        return []
    together = merged(list(read.values()))
    return list(
        zip(
            together.channel.tolist(),
            together.data(),
            together.log_time.astype(np.uint64).tolist(),  # as in the file, where no time is below zero
            together.publish_time.astype(np.uint64).tolist(),
            together.sequence.tolist(),
            strict=True,
        )
    )


def is_end(damage: Damage, file: Path) -> bool:
    """Say whether a damage is only that the file's end is missing."""
    return damage.offset >= file.stat().st_size or "ends within" in damage.what


def describe(folder: Path, opened: Opened, indices: list[FileIndex], changed: bool) -> None:
    """Write metadata.yaml where it is missing, can't be read or no longer fits; else leave it as it is."""
    told = opened.metadata
    there = opened.folder / NAME
    if told is not None and not changed and fits(told, indices):
        if folder != opened.folder:
            shutil.copyfile(there, folder / NAME)
        return
    names = [name.name for name in opened.names]
    write_metadata(
        folder, information(indices, names), told, "sqlite3" if any(map(is_sqlite, opened.files)) else "mcap"
    )


def fits(told: Description, indices: list[FileIndex]) -> bool:
    """Say whether a metadata.yaml says of its files what is in them."""
    return len(told.files) == len(indices) and told.raw.get("message_count") == sum(i.count for i in indices)


def information(indices: list[FileIndex], names: list[str]) -> BagInformation:
    """Return what metadata.yaml is to say."""
    topics: dict[str, TopicInformation] = {}
    for index in indices:
        for number, channel in index.channels.items():
            schema = index.schemas.get(channel.schema_id)
            before = topics.get(channel.topic)
            topics[channel.topic] = TopicInformation(
                channel.topic,
                before.type if before else schema.name if schema else "",
                before.profiles
                if before
                else qos.from_yaml(channel.metadata.get("offered_qos_profiles", "")),
                before.hash if before else channel.metadata.get("topic_type_hash", ""),
                (before.count if before else 0) + index.counts.get(number, 0),
                before.encoding if before else channel.message_encoding,
            )
    files = [
        FileInformation(name, i.first or 0, i.last or 0, i.count)
        for name, i in zip(names, indices, strict=True)
    ]
    return BagInformation(list(topics.values()), files)
