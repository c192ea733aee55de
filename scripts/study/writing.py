"""Putting a study's choice into the scene's file: what the study changed, and no other byte."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from .scene_text import CannotEdit, edit, plain


def written(text: bytes, changes: Mapping[str, Any], read: Callable[[Any, Mapping[str, Any]], Any]) -> bytes:
    """Return a scene's text with changes, checked: read again it is the scene with these overrides.

    read : (document, overrides) to a scene, as load_scene does

    Raises
    ------
    ValueError
        Where the text can't be changed so.
    """
    try:
        before = text.decode("utf-8")
        after = edit(before, changes)
    except (UnicodeDecodeError, CannotEdit) as problem:
        raise ValueError(
            f"the choice can't be put into the file ({problem}); change it by hand: {said(changes)}"
        ) from None
    if read(plain(after.lstrip("\ufeff")), {}) != read(plain(before.lstrip("\ufeff")), changes):
        raise ValueError(f"the choice can't be put into the file; change it by hand: {said(changes)}")
    return after.encode("utf-8")


def said(changes: Mapping[str, Any]) -> str:
    """For example solver.step=0.001 solver.method=rosenbrock_w."""
    return " ".join(f"{key}={value}" for key, value in changes.items())


def put(path: Path, text: bytes) -> None:
    """Write a file at once or not at all; links, mode and owner stay.

    Raises
    ------
    ValueError
        Where the file can't be written.
    """
    real = path.resolve()
    if not os.access(real, os.W_OK):
        raise ValueError(f"{path}: can't be written; give it the right to be, or leave --write out")
    if real.read_bytes() == text:
        return
    try:
        if real.stat().st_nlink > 1:  # another name of this file is to see the change too
            real.write_bytes(text)
            return
        handle, part = tempfile.mkstemp(prefix=f".{real.name}.", dir=real.parent)
    except OSError as problem:
        raise ValueError(f"{path}: can't be written ({problem.strerror}); nothing was") from None
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        shutil.copymode(real, part)
        with suppress(OSError):  # who may not give files away keeps them
            os.chown(part, real.stat().st_uid, real.stat().st_gid)
        Path(part).replace(real)
    except OSError as problem:
        Path(part).unlink(missing_ok=True)
        raise ValueError(f"{path}: can't be written ({problem.strerror}); it is as it was") from None
