"""A sweep's table: rows once and for ever, and a sentence for every way in which it can't be used."""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import sys
from pathlib import Path

import pytest
from flexsim.sweep.table import Merged, Row, Table, TableError, key_of, merge

ROW = Row(key_of({"a": 1}), {"a": 1}, {"y": 0.1, "word": "A-60", "holds": True, "never": float("inf")},
          warnings=("turned far", "in doubt"))  # fmt: skip
FAILED = Row(key_of({"a": 2}), {"a": 2}, None, "stopped at 3 s")


def made(path: Path, *rows: Row) -> Path:
    with Table(path) as table:
        for row in rows:
            table.add(row)
    return path


def test_rows_come_back_as_they_were(tmp_path: Path) -> None:
    """To the bit, failures with their reasons and times that never come included."""
    path = made(tmp_path / "t.sqlite", ROW, FAILED)
    with Table(path, write=False) as table:
        assert table.get(ROW.key) == ROW
        assert table.get(FAILED.key) == FAILED
        assert table.get("none") is None
        assert len(table) == 2


def test_rows_are_never_changed(tmp_path: Path) -> None:
    path = made(tmp_path / "t.sqlite", ROW)
    with Table(path) as table, pytest.raises(TableError, match="UNIQUE"):
        table.add(ROW)
    with sqlite3.connect(path) as raw:
        for words in ("UPDATE rows SET reason = 'x'", "DELETE FROM rows"):
            with pytest.raises(sqlite3.IntegrityError, match="never"):
                raw.execute(words)


def test_one_sweep_at_a_time(tmp_path: Path) -> None:
    path = tmp_path / "t.sqlite"
    link = tmp_path / "elsewhere" / "link.sqlite"
    link.parent.mkdir()
    link.symlink_to(path)
    for name in (path, link):
        with Table(path), pytest.raises(TableError, match=f"another sweep writes it .process {os.getpid()}."):
            Table(name)
    made(path, ROW)  # it is free again


@pytest.mark.parametrize("write", [True, False])
def test_files_of_others_are_left_alone(write: bool, tmp_path: Path) -> None:
    other, text, path = tmp_path / "other.sqlite", tmp_path / "text.sqlite", tmp_path / "old.sqlite"
    raw = sqlite3.connect(other)
    raw.executescript("CREATE TABLE notes (word TEXT)")
    raw.close()
    text.write_text("a scene, not a table\n" * 100)
    raw = sqlite3.connect(made(path, ROW))
    raw.execute("PRAGMA user_version = 99")
    raw.close()
    for one, sentence in (
        (other, "another program's"),
        (text, "no table of a sweep"),
        (path, "another version"),
    ):
        before = one.read_bytes()
        with pytest.raises(TableError, match=sentence):
            Table(one, write)
        assert one.read_bytes() == before


def test_places_that_cant_be_written(tmp_path: Path) -> None:
    with pytest.raises(TableError, match="can't be written"):
        Table(tmp_path / "nowhere" / "t.sqlite")
    with pytest.raises(TableError, match="no such table"):
        Table(tmp_path / "t.sqlite", write=False)
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_is_said_and_nothing_is_lost(tmp_path: Path) -> None:
    """Files of this process may not grow beyond 200 kB: SQLite can't add a row, as on a full disk."""
    path = tmp_path / "t.sqlite"
    program = """
import resource, signal, sys
from pathlib import Path
from flexsim.sweep.table import Row, Table, TableError
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (200_000, 200_000))
n = 0
with Table(Path(sys.argv[1])) as table:
    try:
        while True:
            table.add(Row(f"{n:08d}", {"n": n}, {"word": "x" * 1000}))
            n += 1
    except TableError as problem:
        print(n)
        print(problem)
"""
    done = subprocess.run(
        [sys.executable, "-c", program, str(path)], capture_output=True, text=True, check=True
    )
    count, sentence = done.stdout.splitlines()
    assert int(count) > 10
    assert sentence.startswith(f"{path}: ") and "make room" in sentence and "goes on" in sentence
    with Table(path) as table:
        assert [row.inputs["n"] for row in table.rows()] == list(range(int(count)))
        table.add(ROW)


def test_sqlite_s_own_word_for_a_full_disk(tmp_path: Path) -> None:
    with Table(tmp_path / "t.sqlite") as table:
        table._ask("PRAGMA max_page_count = 5")
        with pytest.raises(TableError, match="the disk is full; make room, and the same command goes on"):
            for n in range(1000):
                table.add(Row(str(n), {}, {"word": "x" * 1000}))


def test_parts_are_merged_and_a_contradiction_is_none_of_them(tmp_path: Path) -> None:
    a, b = made(tmp_path / "a.sqlite", ROW), made(tmp_path / "b.sqlite", FAILED, ROW)
    assert merge([a, b], tmp_path / "c.sqlite") == Merged(2, 1, 1)
    with Table(tmp_path / "c.sqlite", write=False) as table:
        assert table.rows() == sorted([ROW, FAILED], key=lambda row: row.key)
    other = Row(FAILED.key, FAILED.inputs, {"y": 1.0})
    new = Row(key_of({"a": 3}), {"a": 3}, {"y": 2.0})
    with pytest.raises(TableError, match="different results of one run"):
        merge([made(tmp_path / "d.sqlite", other, new)], tmp_path / "c.sqlite")
    with Table(tmp_path / "c.sqlite", write=False) as table:
        assert table.get(new.key) is None
        assert table.get(FAILED.key) == FAILED


def test_parts_of_different_studies_are_told(tmp_path: Path) -> None:
    """They do no harm, but may be a slip."""
    a, b = made(tmp_path / "a.sqlite", ROW), made(tmp_path / "b.sqlite", Row("k", {"b": 1}, {"y": 1.0}))
    assert merge([a, b], tmp_path / "c.sqlite") == Merged(2, 0, 2)


def test_a_merge_that_lacks_a_part_makes_nothing(tmp_path: Path) -> None:
    a = made(tmp_path / "a.sqlite", ROW)
    with pytest.raises(TableError, match=r"b\.sqlite: no such table"):
        merge([a, tmp_path / "b.sqlite"], tmp_path / "c.sqlite")
    assert not list(tmp_path.glob("c.*"))


def test_a_key_is_of_what_was_run() -> None:
    """Not of the order in which it was written; 1 and 1.0, which a scene may read differently, are two."""
    assert key_of({"a": 1, "b": [0.1]}) == key_of(json.loads('{"b": [0.1], "a": 1}'))
    assert key_of({"a": 1}) != key_of({"a": 1.0})
