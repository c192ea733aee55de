"""Kernels that numba keeps compiled on disk: where, when they are too old, and what a bad disk costs."""

from __future__ import annotations

import atexit
import pickle
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from numba import config, njit
from numba.core.caching import Cache


@contextmanager
def go_on_without(cache: Any) -> Iterator[None]:
    """A full disk, or a file that a power cut left torn, costs a compilation and no more."""
    try:
        yield
    except OSError:
        pass
    except (EOFError, pickle.UnpicklingError):
        with suppress(OSError):
            Path(cache._cache_file._index_path).unlink()


Cache._guard_against_spurious_io_errors = go_on_without


def nothing() -> None:
    """A function that could be kept where this file's are."""


def find_room(function: Callable[[], None]) -> None:
    """Keep kernels for as long as this process lasts, where neither package nor home can be written.

    numba would end the process.  The folder is this process's alone: kept kernels are code that is run.
    """
    try:
        njit(cache=True)(function)
    except RuntimeError:
        config.CACHE_DIR = tempfile.mkdtemp(prefix="kernels-")
        atexit.register(shutil.rmtree, config.CACHE_DIR, ignore_errors=True)


def forget_stale_kernels(package: Path) -> None:
    """Remove compiled kernels older than any source of the package.

    numba compares a kernel with its own file only, not with the files of what it calls.
    """
    cache = package / "__pycache__"
    kept = [path for name in ("*.nb[ic]", "*/*.nb[ic]") for path in cache.glob(name)]
    try:
        newest = max(path.stat().st_mtime for path in package.rglob("*.py"))
        stale = [path for path in kept if path.stat().st_mtime < newest]
    except FileNotFoundError:  # another process is at it
        return
    if stale:
        for path in kept:
            with suppress(OSError):  # who may not remove them uses others
                path.unlink()


if not config.DISABLE_JIT:
    find_room(nothing)
forget_stale_kernels(Path(__file__).parent)
