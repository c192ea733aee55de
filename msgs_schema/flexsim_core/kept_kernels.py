"""Kernels that numba keeps compiled on disk: where, when they are too old, and what a bad disk costs.

A package calls `keep_kernels` before it loads any.
"""

from __future__ import annotations

import atexit
import fcntl
import pickle
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from numba import config, njit
from numba.core.caching import Cache, IndexDataCacheFile


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


def one_at_a_time(method: Callable[..., Any], how: int) -> Callable[..., Any]:
    """Let no other process at a folder's kernels while this one saves (LOCK_EX), or loads (LOCK_SH).

    numba reads the index, writes it with the next free number, and then the code.  Two processes that save
    different signatures at once take the same number: an index leads to the other's code, which then runs.
    """

    def alone(file: Any, *arguments: Any) -> Any:
        try:
            lock = (Path(file._cache_path) / "kernels.lock").open("a")
        except OSError:  # nobody can write there
            return method(file, *arguments)
        with lock:
            fcntl.flock(lock, how)
            return method(file, *arguments)

    return alone


IndexDataCacheFile.save = one_at_a_time(IndexDataCacheFile.save, fcntl.LOCK_EX)
IndexDataCacheFile.load = one_at_a_time(IndexDataCacheFile.load, fcntl.LOCK_SH)


def find_room(function: Callable[[], None]) -> None:
    """Keep kernels for as long as this process lasts, where neither the package nor the home can be written.

    numba would end the process.  The folder is this process's alone: kept kernels are code that is run.
    """
    try:
        njit(cache=True)(function)
    except RuntimeError:
        config.CACHE_DIR = tempfile.mkdtemp(prefix="kernels-")
        atexit.register(shutil.rmtree, config.CACHE_DIR, ignore_errors=True)


def forget_stale_kernels(package: Path, sources: str = "") -> None:
    """Remove a package's compiled kernels where one is older than any of its sources.

    numba looks only at the file of the function itself, not at those of the functions that it calls.

    sources : regular expression of what a file has that kernels depend on; every file counts where ""
    """
    kept = [*package.rglob("*.nbi"), *package.rglob("*.nbc")]  # in the __pycache__ beside each source
    if not kept:
        return
    try:
        newest = max(
            path.stat().st_mtime
            for path in package.rglob("*.py")
            if re.search(sources, path.read_text("utf-8"))
        )
        stale = any(path.stat().st_mtime < newest for path in kept)
    except FileNotFoundError:  # another process is at it
        return
    for path in kept if stale else ():
        with suppress(OSError):  # who may not remove them uses others
            path.unlink()


def keep_kernels(package: Path, one: Callable[[], None], sources: str = "") -> None:
    """Find a place for a package's compiled kernels, and forget those that are too old.

    one : a function of the package that could be kept
    """
    if not config.DISABLE_JIT:
        find_room(one)
        forget_stale_kernels(package, sources)
