"""The table of a sweep: one row a run, kept by what was run, in SQLite.

Rows are added, one transaction each, and never changed. Whoever writes holds a lock on the file beside it.
"""

from __future__ import annotations

import csv
import fcntl
import hashlib
import json
import os
import sqlite3
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, Any

APPLICATION, FORMAT = 0x666C7377, 1  # "flsw"
BEGIN = f"""
PRAGMA application_id = {APPLICATION};
PRAGMA user_version = {FORMAT};
CREATE TABLE rows (
    key TEXT PRIMARY KEY,
    inputs TEXT NOT NULL,
    observed TEXT,
    reason TEXT NOT NULL,
    warnings TEXT NOT NULL
) WITHOUT ROWID;
CREATE TRIGGER unchanged BEFORE UPDATE ON rows BEGIN SELECT RAISE(ABORT, 'rows are never changed'); END;
CREATE TRIGGER kept BEFORE DELETE ON rows BEGIN SELECT RAISE(ABORT, 'rows are never deleted'); END;
"""


class TableError(ValueError):
    """A table that can't be used: which, why, and what to do."""


@dataclass(frozen=True)
class Row:
    """One run that is over.

    key : hash of all that the run depends on
    inputs : what was varied; observed : what was read, or None where it failed, for a reason
    warnings : what the run warned of, though it came to its end
    """

    key: str
    inputs: Mapping[str, Any]
    observed: Mapping[str, Any] | None
    reason: str = ""
    warnings: tuple[str, ...] = ()


def key_of(run: Mapping[str, Any]) -> str:
    """A hash of what is run."""
    return hashlib.sha256(json.dumps(run, sort_keys=True).encode()).hexdigest()


class Table:
    """A table that is open; `with` closes it.

    write : whether rows will be added: the file is locked, and made where it is not there

    Raises
    ------
    TableError
        Where it is another program's file, damaged, locked, or can't be written.
    """

    def __init__(self, path: Path, write: bool = True) -> None:
        self.path = path
        self._lock: IO[str] | None = None
        if not write and not path.is_file():
            raise TableError(f"{path}: no such table; give the path of one that a sweep has made")
        if write:
            self._take_lock()
        self._connection: sqlite3.Connection | None = None
        try:
            with self._words():
                self._open(write)
        except BaseException:
            self.close()
            raise

    def _take_lock(self) -> None:
        # By whatever name or link the table is reached, it has one lock.
        real = self.path.resolve()
        beside = real.with_name(real.name + ".lock")
        try:
            lock = self._lock = beside.open("a+", encoding="utf-8")
        except OSError as problem:
            raise TableError(f"{self.path}: can't be written ({problem.strerror}); give another") from None
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            lock.seek(0)
            who = lock.read().strip()
            lock.close()
            raise TableError(
                f"{self.path}: another sweep writes it{f' (process {who})' if who else ''}; wait until it has"
                " ended, or give another table"
            ) from None
        lock.truncate(0)
        try:
            lock.write(str(os.getpid()))
            lock.flush()
        except OSError:
            pass  # a full disk: who holds the lock is a courtesy

    def _open(self, write: bool) -> None:
        fresh = not self.path.exists() or self.path.stat().st_size == 0
        where = f"{self.path.absolute().as_uri()}?mode={'rwc' if write else 'ro'}"
        self._connection = sqlite3.connect(where, uri=True, isolation_level=None)
        if not fresh:
            (mine,) = self._connection.execute("PRAGMA application_id").fetchone()
            (version,) = self._connection.execute("PRAGMA user_version").fetchone()
            made = self._connection.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]
            if made and mine != APPLICATION:
                raise TableError(f"{self.path}: is another program's database; give another table")
            if made and version != FORMAT:
                raise TableError(f"{self.path}: is a table of another version of flexsim; give another table")
            fresh = not made
        if write:
            self._connection.execute("PRAGMA journal_mode = WAL")
            # A killed process loses nothing that was added; a power cut may lose the last rows, no more.
            self._connection.execute("PRAGMA synchronous = NORMAL")
            if fresh:
                self._connection.executescript(f"BEGIN;{BEGIN}COMMIT;")
        elif fresh:
            raise TableError(f"{self.path}: is empty; give a table that a sweep has made")

    @contextmanager
    def _words(self) -> Iterator[None]:
        """Say SQLite's troubles in a sentence."""
        try:
            yield
        except sqlite3.Error as problem:
            code = getattr(problem, "sqlite_errorcode", 0) & 0xFF
            said = str(problem)
            if code == 13 or "full" in said:  # SQLITE_FULL
                why = "the disk is full; make room, and the same command goes on where it was"
            elif code in (11, 26) or "not a database" in said or "malformed" in said:
                why = "is no table of a sweep, or damaged; give another table"
            elif code in (5, 6):
                why = "another program holds it locked; close that, or give another table"
            elif code == 10:  # SQLITE_IOERR
                why = (
                    f"can't be read or written ({said}): make room on its disk, and the same command goes on"
                )
            else:
                why = f"can't be used ({said}); give another table"
            raise TableError(f"{self.path}: {why}") from None

    def __enter__(self) -> Table:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, what: BaseException | None, where: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let others write."""
        if self._connection is not None:
            self._connection.close()
            self._connection = None
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def _ask(self, words: str, values: Iterable[Any] = ()) -> list[Any]:
        assert self._connection is not None, "the table is closed"
        with self._words():
            return self._connection.execute(words, tuple(values)).fetchall()

    def add(self, row: Row) -> None:
        """Keep a row; the same run twice is a mistake of the program's."""
        observed = None if row.observed is None else json.dumps(dict(row.observed))
        self._ask(
            "INSERT INTO rows VALUES (?, ?, ?, ?, ?)",
            (row.key, json.dumps(dict(row.inputs)), observed, row.reason, json.dumps(row.warnings)),
        )

    def add_all(self, rows: Iterable[Row]) -> None:
        """Keep rows in one transaction: all of them or none."""
        self._ask("BEGIN")
        try:
            for row in rows:
                self.add(row)
        except BaseException:
            self._ask("ROLLBACK")
            raise
        self._ask("COMMIT")

    def get(self, key: str) -> Row | None:
        """Return the row of a run; None where it was not run yet."""
        found = self._ask("SELECT * FROM rows WHERE key = ?", (key,))
        return _row(*found[0]) if found else None

    def __len__(self) -> int:
        return int(self._ask("SELECT count(*) FROM rows")[0][0])

    def rows(self) -> list[Row]:
        """Return every row, in the order of the keys."""
        return [_row(*found) for found in self._ask("SELECT * FROM rows ORDER BY key")]


def _row(key: str, inputs: str, observed: str | None, reason: str, warnings: str) -> Row:
    seen = None if observed is None else json.loads(observed)
    return Row(key, json.loads(inputs), seen, reason, tuple(json.loads(warnings)))


@dataclass(frozen=True)
class Merged:
    """Rows that came, rows that were there already, and how many sets of keys vary in the tables."""

    added: int
    had: int
    studies: int


def merge(parts: Sequence[Path], into: Path) -> Merged:
    """Put the rows of several tables into one, which may be there already.

    Raises
    ------
    TableError
        Where two tables hold different results of one run: nothing of that table is put in.
    """
    added = had = 0
    varied: set[frozenset[str]] = set()
    for path in parts:  # before anything is made
        with Table(path, write=False):
            pass
    with Table(into) as whole:
        for path in parts:
            with Table(path, write=False) as part:
                rows = part.rows()
            new = []
            varied.update(frozenset(row.inputs) for row in rows)
            for row in rows:
                there = whole.get(row.key)
                if there is None:
                    new.append(row)
                elif (there.observed, there.reason) != (row.observed, row.reason):
                    raise TableError(
                        f"{path} and {into}: hold different results of one run ({row.key[:12]},"
                        f" {dict(row.inputs)}); leave one of them out"
                    )
            whole.add_all(new)
            added, had = added + len(new), had + len(rows) - len(new)
    return Merged(added, had, len(varied))


def write_csv(
    points: Iterable[Mapping[str, Any]],
    rows: Iterable[Row],
    inputs: list[str],
    observed: list[str],
    path: Path,
) -> None:
    """Write rows as CSV: inputs, what was observed, why a row failed; at once or not at all."""
    part = path.with_name(path.name + ".part")
    with part.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow([*inputs, *observed, "failure", "warnings"])
        for point, row in zip(points, rows, strict=True):
            seen = row.observed or {}
            cells = [_cell(point.get(key)) for key in inputs] + [_cell(seen.get(name)) for name in observed]
            writer.writerow([*cells, row.reason, "; ".join(row.warnings)])
    part.replace(path)


def _cell(value: Any) -> Any:
    """A value as CSV has it: lists and conditions as JSON says them."""
    return json.dumps(value) if isinstance(value, (list, dict, bool)) else value
