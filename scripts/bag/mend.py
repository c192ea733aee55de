"""Mends a bag: what can be read goes into files that are whole, and metadata.yaml is made anew."""

from __future__ import annotations

import errno
import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import Attachment, Metadata

from . import mcap_index, qos
from .errors import BagError
from .index import Damage, FileIndex
from .mcap_file import MAGIC, McapFile
from .mcap_index import ChunkReader
from .messages import Messages, merged
from .metadata import BagInformation, FileInformation, TopicInformation, write_metadata
from .opening import find
from .reader import record
from .writer import RESERVE_NAME

UNFINISHED, DAMAGED = ".part", ".damaged"


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


def mend(
    path: Path, output: Path | None = None, progress: Callable[[int, int], None] = lambda *_: None
) -> list[Mended]:
    """Mend a bag.

    Parameters
    ----------
    path : Path
        The bag's folder, or one .mcap file of it.
    output : Path, optional
        Where to write a whole copy; if not given the bag itself is mended. A file that has damage
        within, not only a missing end, is kept beside as `.mcap.damaged`.
    progress : callable
        Called with the bytes of a file that were read, and its size.

    Raises
    ------
    BagError
        There is no bag, or nothing in it can be read, or `output` exists.
    """
    files = find(path).files
    found = [mcap_index.read(file) for file in files]
    damages = [damage for index in found for damage in index.damages]
    if damages and not any(index.channels for index in found) and not any(map(begins, files)):
        # It may be no bag at all: nothing is written, neither here nor beside it.
        raise BagError(f"{path} holds nothing that can be read: {damages[0]}")
    folder = path if path.is_dir() else path.parent
    if output is not None:
        if output.exists():
            raise BagError(f"{output} exists already; name another bag or remove it")
        output.mkdir(parents=True)
        folder = output
    results, indices = [], []
    try:
        for number, (file, index) in enumerate(zip(files, found, strict=True)):
            target = folder / (f"{output.name}_{number}.mcap" if output is not None else file.name)
            result, index = mend_file(file, index, target, progress)
            results.append(result)
            indices.append(index)
    except BaseException as problem:
        if output is not None:  # half a copy is none
            shutil.rmtree(output)
        if isinstance(problem, OSError) and problem.errno == errno.ENOSPC:
            raise BagError(f"the disk of {folder} is full; -o BAG writes elsewhere") from None
        raise
    for leftover in (RESERVE_NAME, "metadata.yaml.part"):
        (folder / leftover).unlink(missing_ok=True)
    if path.is_dir() or output is not None:
        write_metadata(folder, information(indices))
    return results


def begins(file: Path) -> bool:
    """Say whether a file begins as MCAP files do, with a header that can be read."""
    with file.open("rb") as stream:
        start = stream.read(len(MAGIC) + 1)
    return start == MAGIC + bytes([Opcode.HEADER])


def mend_file(
    file: Path, index: FileIndex, target: Path, progress: Callable[[int, int], None] = lambda *_: None
) -> tuple[Mended, FileIndex]:
    """Mend one file, of which `index` is what could be found; `target` may be the file itself."""
    result = Mended(target, expected=index.count if index.summed else None, lost=list(index.damages))
    unfinished = target.with_name(target.name + UNFINISHED)
    unfinished.unlink(missing_ok=True)
    if file == target and not index.damages and sound(file, index, progress):
        result.count = index.count
        return result, index
    written = McapFile(unfinished)
    try:
        copy(file, index, written, result, progress)
        written.finish()
    except BaseException:
        if not written.closed:
            written.abandon()
        unfinished.unlink(missing_ok=True)
        raise
    result.written_anew = True
    if file == target and any(not is_end(d, file) for d in result.lost):
        result.kept = file.with_name(file.name + DAMAGED)
        file.replace(result.kept)
    unfinished.replace(target)
    found = mcap_index.read(target)
    result.count = found.count
    return result, found


def sound(file: Path, index: FileIndex, progress: Callable[[int, int], None]) -> bool:
    """Say whether each chunk can be read, and all together hold what the index says."""
    reader = ChunkReader(file)
    counts = dict.fromkeys(index.counts, 0)
    size = file.stat().st_size
    try:
        for place in index.places:
            progress(place.offset, size)
            read = reader(place)
            if isinstance(read, Damage):
                return False
            for number, some in read.items():
                counts[number] = counts.get(number, 0) + len(some)
    finally:
        reader.close()
    return counts == index.counts


def copy(
    file: Path, index: FileIndex, written: McapFile, result: Mended, progress: Callable[[int, int], None]
) -> None:
    """Copy all that can be read."""
    for name, where in index.metadata:
        try:
            written.add_metadata(name, dict(record(file, where, Metadata).metadata))
        except BagError as problem:
            result.lost.append(Damage(file, where[0], f"the metadata {name}: {problem}"))
    for name, where in index.attachments:
        try:
            found = record(file, where, Attachment)
            written.add_attachment(name, found.media_type, found.data, found.log_time)
        except BagError as problem:
            result.lost.append(Damage(file, where[0], f"the attachment {name}: {problem}"))
    schemas = {n: written.add_schema(s.name, s.data) for n, s in index.schemas.items()}
    channels = {
        n: written.add_channel(c.topic, schemas.get(c.schema_id, 0), dict(c.metadata))
        for n, c in index.channels.items()
    }
    reader = ChunkReader(file)
    size = file.stat().st_size
    try:
        for place in index.places:
            progress(place.offset, size)
            read = reader(place)
            if isinstance(read, Damage):
                result.lost.append(read)
                continue
            for channel, data, log_time, publish_time, sequence in in_order(read):
                if channel in channels:
                    written.write(channels[channel], data, log_time, publish_time, sequence)
    finally:
        reader.close()


def in_order(read: dict[int, Messages]) -> list[tuple[int, bytes, int, int, int]]:
    """Return a chunk's messages, of all channels, as they lie in it."""
    if not read:
        return []
    together = merged(list(read.values()))
    return list(
        zip(
            together.channel.tolist(),
            together.data(),
            together.log_time.tolist(),
            together.publish_time.tolist(),
            together.sequence.tolist(),
            strict=True,
        )
    )


def is_end(damage: Damage, file: Path) -> bool:
    """Say whether a damage is only that the file's end is missing."""
    return damage.offset >= file.stat().st_size or "ends within" in damage.what


def information(indices: list[FileIndex]) -> BagInformation:
    """Return what metadata.yaml is to say."""
    topics: dict[str, TopicInformation] = {}
    for index in indices:
        for number, channel in index.channels.items():
            schema = index.schemas.get(channel.schema_id)
            before = topics[channel.topic].count if channel.topic in topics else 0
            topics[channel.topic] = TopicInformation(
                channel.topic,
                schema.name if schema else "",
                qos.from_yaml(channel.metadata.get("offered_qos_profiles", "")),
                channel.metadata.get("topic_type_hash", ""),
                before + index.counts.get(number, 0),
            )
    files = [FileInformation(i.path.name, i.first or 0, i.last or 0, i.count) for i in indices]
    return BagInformation(list(topics.values()), files)
