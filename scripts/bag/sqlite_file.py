"""A bag's file as rosbag2 wrote it by default before Iron: an sqlite3 database.

Nothing in it is trusted: it is opened to be read only, must hold plain tables, and no view, trigger or
function of its own is run.
"""

from __future__ import annotations

import sqlite3
import threading
from pathlib import Path
from typing import Any

import numpy as np
from mcap.records import Channel, Schema

from .definitions import definition
from .errors import BagError
from .index import Damage, FileIndex, Place
from .messages import Messages, of_list

# Messages that are read at once: so many, and so many bytes.
MOST, MOST_BYTES = 4096, 1 << 20
NEEDED = {"topics": {"id", "name", "type"}, "messages": {"id", "topic_id", "timestamp", "data"}}
BROKEN = (sqlite3.Error, OverflowError, ValueError, TypeError, MemoryError)


def connect(path: Path) -> sqlite3.Connection:
    """Open a database to be read, from any thread."""
    # A recorder that was killed leaves its last messages in a file beside, which such a reader would not see.
    beside = path.with_name(path.name + "-wal")
    immutable = "" if beside.exists() and beside.stat().st_size else "&immutable=1"
    uri = f"{path.absolute().as_uri()}?mode=ro{immutable}"
    connection = sqlite3.connect(uri, uri=True, check_same_thread=False, isolation_level=None)
    for pragma in ("trusted_schema = OFF", "query_only = ON", "cell_size_check = ON"):
        connection.execute(f"PRAGMA {pragma}")
    return connection


def read(path: Path) -> FileIndex:
    """Return what is in a file; never raises for what is in it."""
    found = FileIndex(path, summed=True)
    connection = connect(path)
    try:
        columns = plain_tables(connection)
        described = definitions_in(connection)
        read_topics(connection, found, columns["topics"], described)
        read_places(connection, found)
    except BROKEN as problem:
        found.ended = False
        found.damages.append(Damage(path, 0, f"the database can't be read: {problem}"))
    finally:
        connection.close()
    return found


def plain_tables(connection: sqlite3.Connection) -> dict[str, set[str]]:
    """Return the columns of the tables; raises ValueError where it is no bag's database."""
    kinds = dict(
        connection.execute("SELECT name, type || ' ' || sql FROM sqlite_master WHERE type != 'index'")
    )
    found = {}
    for table, needed in NEEDED.items():
        sql = str(kinds.get(table, ""))
        if not sql:
            raise ValueError(f"it has no table '{table}', so that it is no bag")
        if (
            not sql.lower().startswith("table create table")
            or "generated" in sql.lower()
            or " as (" in sql.lower()
        ):
            raise ValueError(f"'{table}' is not a plain table")
        found[table] = {str(row[1]) for row in connection.execute(f"PRAGMA table_info({table})")}
        if not needed <= found[table]:
            raise ValueError(f"its table '{table}' lacks {', '.join(sorted(needed - found[table]))}")
    return found


def definitions_in(connection: sqlite3.Connection) -> dict[str, tuple[str, str]]:
    """Return encoding and text of each type that the file defines; rosbag2 before Iron wrote none."""
    try:
        rows = connection.execute(
            "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions LIMIT 10000"
        ).fetchall()
    except sqlite3.OperationalError:
        return {}
    return {str(name): (str(encoding), str(text)) for name, encoding, text in rows if encoding != "unknown"}


def read_topics(
    connection: sqlite3.Connection, found: FileIndex, columns: set[str], described: dict[str, tuple[str, str]]
) -> None:
    """Take up the topics as channels, each with its type's definition."""
    wanted = ["serialization_format", "offered_qos_profiles", "type_description_hash"]
    there = [name for name in wanted if name in columns]
    for number, name, kind, *more in connection.execute(
        f"SELECT {', '.join(['id', 'name', 'type', *there])} FROM topics LIMIT 60000"
    ):
        said = dict(zip(there, map(str, more), strict=True))
        encoding, text = described.get(str(kind)) or ("ros2msg", installed(str(kind)))
        found.schemas[number] = Schema(number, text.encode(), encoding, str(kind))
        metadata = {
            "offered_qos_profiles": said.get("offered_qos_profiles", ""),
            "topic_type_hash": said.get("type_description_hash", ""),
        }
        form = said.get("serialization_format", "cdr")
        found.channels[number] = Channel(number, str(name), form, metadata, number)
        found.counts[number] = 0


def installed(kind: str) -> str:
    """Return the definition of a type that is installed here, or that every Jazzy has; "" of others."""
    try:
        return definition(kind)
    except BagError:
        pass
    from rosbags.typesys import Stores, get_typestore
    from rosbags.typesys.base import TypesysError

    try:
        return str(get_typestore(Stores.ROS2_JAZZY).generate_msgdef(kind, ros_version=2)[0])
    except (TypesysError, KeyError):
        return ""


def read_places(connection: sqlite3.Connection, found: FileIndex) -> None:
    """Find out where messages lie, piece by piece, without reading them."""
    rows: list[tuple[int, int, int]] = []
    size = 0

    def piece() -> None:
        if not rows:
            return
        times = np.array([row[2] for row in rows], dtype=np.int64)
        numbers = [row[1] for row in rows]
        first, last = int(times.min()), int(times.max())
        found.places.append(Place(rows[0][0], rows[-1][0], 0, first, last, frozenset(numbers), size))
        found.extend(first, last)
        for number in set(numbers):
            found.counts[number] = found.counts.get(number, 0) + numbers.count(number)
        rows.clear()

    for number, topic, timestamp, length in connection.execute(
        "SELECT id, topic_id, timestamp, length(data) FROM messages ORDER BY id"
    ):
        if rows and (len(rows) >= MOST or size + (length or 0) > MOST_BYTES):
            piece()
            size = 0
        rows.append((int(number), int(topic), int(timestamp)))
        size += length or 0
    piece()
    unknown = sum(count for number, count in found.counts.items() if number not in found.channels)
    if unknown:
        found.damages.append(
            Damage(found.path, 0, f"{unknown} messages are of topics that nothing describes")
        )
    found.counts = {number: found.counts.get(number, 0) for number in found.channels}


class SqliteReader:
    """Reads the messages of a piece; can be called from several threads."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._connection = connect(path)
        self._lock = threading.Lock()

    def close(self) -> None:
        """Close the file."""
        with self._lock:
            self._connection.close()

    def __call__(self, place: Place) -> dict[int, Messages] | Damage:
        """Return a piece's messages by channel, or why they can't be read."""
        try:
            with self._lock:
                rows = self._connection.execute(
                    "SELECT topic_id, timestamp, data FROM messages WHERE id BETWEEN ? AND ? ORDER BY id",
                    (place.offset, place.length),
                ).fetchall()
            return by_topic(rows)
        except BROKEN as problem:
            what = f"messages {place.offset} to {place.length} of the database can't be read: {problem}"
            return Damage(self.path, 0, what, place.first, place.last)


def by_topic(rows: list[tuple[Any, Any, Any]]) -> dict[int, Messages]:
    """Return messages by topic, all in one buffer."""
    if not rows:
        return {}
    together = of_list([data if isinstance(data, bytes) else b"" for _, _, data in rows])
    times = np.array([int(time) for _, time, _ in rows], dtype=np.int64)
    numbers = np.array([int(topic) for topic, _, _ in rows], dtype=np.int64)
    found = {}
    for number in np.unique(numbers).tolist():
        which = np.flatnonzero(numbers == number)
        some, when = together[which], times[which]
        found[number] = Messages(
            some.buffer,
            some.start,
            some.size,
            when,
            when,
            some.sequence,
            np.full(len(some), number, np.int64),
        )
    return found
