"""Reads the places of a file that are needed, some ahead while others are worked on."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from io import BytesIO
from pathlib import Path
from typing import Any

from mcap.data_stream import ReadDataStream

from . import storage
from .errors import BagError
from .index import Damage, Place
from .mcap_index import BROKEN
from .messages import RECORD, Messages, Thinner

# Places, and bytes, that wait unpacked at most.
AHEAD, MOST_AHEAD = 6, 1 << 26


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
    pool: ThreadPoolExecutor, reader: storage.Reader, places: Iterator[Place]
) -> Iterator[dict[int, Messages] | Damage]:
    """Give what lies at these places, in order, some being read while others are worked on."""
    waiting: deque[Future[dict[int, Messages] | Damage]] = deque()
    sizes: deque[int] = deque()
    held = 0
    try:
        for place in places:
            # A chunk that is said to be huge waits for those before.
            while waiting and (len(waiting) > AHEAD or held + place.size > MOST_AHEAD):
                held -= sizes.popleft()
                yield waiting.popleft().result()
            waiting.append(pool.submit(reader, place))
            sizes.append(place.size)
            held += place.size
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
    except BROKEN as problem:
        raise BagError(f"{file}, byte {offset}: a record can't be read: {problem}") from None
