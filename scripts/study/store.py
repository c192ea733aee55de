"""A study's folder: what it reads and what it has found, kept so that it can be stopped and resumed.

scene.yaml      the scene as it was when the study began; runs read this one
points.jsonl    what the points depend on, then one point a line, each with a check of itself
reference.npz   the reference
written.json    what --write has made of the scene's file
lock            held while a study works here
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from .point import Outcome, Reference


class StudyError(ValueError):
    """A folder that a study can't go on in: which, why, and what to do."""


def digest(data: bytes) -> str:
    """A hash of bytes."""
    return hashlib.sha256(data).hexdigest()


class Store:
    """A study's folder, locked until it is closed.

    text : the scene as the user's file has it now

    Raises
    ------
    StudyError
        Where another study works there, or it holds a study of something else.
    """

    def __init__(self, folder: Path, text: bytes, fresh: bool = False) -> None:
        self.folder = folder
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._lock = (folder / "lock").open("a+", encoding="utf-8")
        except OSError as problem:
            raise StudyError(
                f"{folder}: can't be written ({problem.strerror}); give another --output"
            ) from None
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            self._lock.seek(0)
            who = self._lock.read().strip()
            self._lock.close()
            raise StudyError(
                f"{folder}: another study works here{f' (process {who})' if who else ''}; wait until it has"
                " ended, or give another --output"
            ) from None
        self._lock.truncate(0)
        self._lock.write(str(os.getpid()))
        self._lock.flush()
        self._points, self._reference = folder / "points.jsonl", folder / "reference.npz"
        self._scene, self._written = folder / "scene.yaml", folder / "written.json"
        self.outcomes: dict[str, Outcome] = {}
        self.conditions: dict[str, Any] = {}
        self.dropped = 0
        try:
            self._open(text, fresh)
        except BaseException:
            self.close()
            raise

    def _open(self, text: bytes, fresh: bool) -> None:
        head = None if fresh else self._head()
        if head is None:
            for path in (self._points, self._reference, self._written):
                path.unlink(missing_ok=True)
            _put(self._scene, text)
            self.text, self.own = text, digest(text)
            return
        self.own = str(head.get("scene"))
        kept = self._scene.read_bytes() if self._scene.exists() else b""
        if digest(kept) != self.own:
            raise StudyError(
                f"{self._scene}: is not the scene that the study began with; put that one back, or --fresh to"
                " begin anew"
            )
        now = digest(text)
        if now != self.own and now not in self._made():
            raise StudyError(
                f"{self.folder}: holds a study of another scene, duration or grid: the scene's file has"
                " changed since it began; give another --output, or --fresh to begin anew"
            )
        self.text = kept

    def __enter__(self) -> Store:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, what: BaseException | None, where: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let others work in the folder."""
        self._lock.close()

    @property
    def scene(self) -> Path:
        """The study's own copy of the scene."""
        return self._scene

    def _head(self) -> dict[str, Any] | None:
        """The first line; None where no study has got as far."""
        if not self._points.exists():
            return None
        lines = self._points.read_text(encoding="utf-8", errors="replace").splitlines()
        if not lines:
            return None
        found = _checked(lines[0])
        if found is None and len(lines) == 1:
            return None  # stopped while it wrote that line
        if found is None or "study" not in found:
            raise StudyError(
                f"{self._points}: its first line is damaged, or of an earlier version; give another --output,"
                " or --fresh to begin anew"
            )
        return found

    def begin(
        self, fingerprint: Mapping[str, Any], versions: Mapping[str, str], across: bool = False
    ) -> None:
        """Begin, or go on with, a study that depends on these.

        across : whether what other versions found counts

        Raises
        ------
        StudyError
            Where the folder's study depends on others.
        """
        head = json.loads(json.dumps({"study": fingerprint, "scene": self.own, "versions": dict(versions)}))
        kept = self._head()
        if kept is None:
            _put(self._points, (_line(head) + "\n").encode())
            return
        if kept["study"] != head["study"]:
            raise StudyError(
                f"{self._points}: holds a study of another scene, duration or grid; give another"
                " --output, or --fresh to begin anew"
            )
        if kept.get("versions") != head["versions"] and not across:
            mine, theirs = head["versions"], kept.get("versions") or {}
            other = ", ".join(
                f"{n} {theirs.get(n, 'unknown')} (now {v})" for n, v in mine.items() if theirs.get(n) != v
            )
            raise StudyError(
                f"{self._points}: was begun with {other}; give --across-versions to go on all the same,"
                " or --fresh to begin anew"
            )
        lines = self._points.read_text(encoding="utf-8", errors="replace").splitlines()
        read = [(line, _checked(line)) for line in lines[1:]]
        whole = [line for line, found in read if found is not None]
        self.dropped = len(read) - len(whole)
        if self.dropped or not self._points.read_bytes().endswith(b"\n"):
            _put(self._points, ("\n".join([lines[0], *whole]) + "\n").encode())
        for _, found in read:
            if found is None:
                continue
            if "conditions" in found:
                self.conditions[str(found["of"])] = found["conditions"]
                continue
            outcome = Outcome(**found)
            self.outcomes[outcome.point] = outcome

    # What is found

    def _append(self, record: Mapping[str, Any]) -> None:
        with self._points.open("a", encoding="utf-8") as file:
            file.write(_line(record) + "\n")
            file.flush()
            os.fsync(file.fileno())

    def keep(self, outcome: Outcome) -> None:
        """Add a point."""
        self.outcomes[outcome.point] = outcome
        self._append(outcome.record())

    def keep_conditions(self, of: str, found: Mapping[str, Any]) -> None:
        """Add what an advice depends on; of : the point and what was asked."""
        self.conditions[of] = json.loads(json.dumps(found))
        self._append({"of": of, "conditions": found})

    def reference(self) -> Reference | None:
        """The reference of an earlier run, if it is there and whole."""
        if not self._reference.exists():
            return None
        try:
            with np.load(self._reference, allow_pickle=False) as kept:
                arrays = {k: kept[k] for k in kept.files if k != "said"}
                said = json.loads(str(kept["said"]))
            return Reference(arrays, **said)
        except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile, zlib.error, EOFError):
            raise StudyError(
                f"{self._reference}: is damaged; --fresh to begin anew (its points count from it)"
            ) from None

    def keep_reference(self, reference: Reference) -> None:
        """Keep the reference."""
        said = json.dumps({
            "error": reference.error, "how": reference.how, "formulations": reference.formulations,
            "finer": reference.finer, "orders": reference.orders,
        })  # fmt: skip
        part = self._reference.with_suffix(".part")
        with part.open("wb") as file:
            np.savez_compressed(file, said=np.array(said), **reference.arrays)  # type: ignore[arg-type]
            file.flush()
            os.fsync(file.fileno())
        part.replace(self._reference)

    # What is written

    def _made(self) -> list[str]:
        try:
            return list(json.loads(self._written.read_text(encoding="utf-8")))
        except (OSError, ValueError):
            return []

    def knows(self, text: bytes) -> bool:
        """Whether this is the study's scene, or what --write has made of it."""
        return digest(text) in (self.own, *self._made())

    def will_write(self, text: bytes) -> None:
        """Know again what is about to be put into the scene's file, so that the same command goes on."""
        made = self._made()
        if digest(text) not in made:
            _put(self._written, json.dumps([*made, digest(text)]).encode())


def _line(record: Mapping[str, Any]) -> str:
    text = json.dumps(record)
    return json.dumps({**json.loads(text), "check": zlib.crc32(text.encode())})


def _checked(line: str) -> dict[str, Any] | None:
    """What a line says; None where it is not what was written."""
    try:
        found = json.loads(line)
    except json.JSONDecodeError:
        return None
    if not isinstance(found, dict) or "check" not in found:
        return None
    check = found.pop("check")
    return found if zlib.crc32(json.dumps(found).encode()) == check else None


def _put(path: Path, text: bytes) -> None:
    """Write a file at once or not at all."""
    part = path.with_name(path.name + ".part")
    with part.open("wb") as file:
        file.write(text)
        file.flush()
        os.fsync(file.fileno())
    part.replace(path)
