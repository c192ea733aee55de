"""Kernels that numba keeps compiled on disk: where, when they are too old, and what a bad disk costs.

Imported before any kernel is.
"""

from __future__ import annotations

import atexit
import pickle
import re
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
    """Keep kernels for as long as this process lasts, where neither the package nor the home can be written.

    numba would end the process.  The folder is this process's alone: kept kernels are code that is run.
    """
    try:
        njit(cache=True)(function)
    except RuntimeError:
        config.CACHE_DIR = tempfile.mkdtemp(prefix="kernels-")
        atexit.register(shutil.rmtree, config.CACHE_DIR, ignore_errors=True)


def forget_stale_kernels(package: Path) -> None:
    """Remove compiled kernels that are older than any source of kernels in the package.

    numba looks only at the file of the function itself, not at those of the functions that it calls.
    """
    compiled = [*package.rglob("*.nbi"), *package.rglob("*.nbc")]  # in the __pycache__ beside each source
    if not compiled:
        return
    # kernels, their arrays and own code
    compiles = re.compile(r"from \.+(compiled\.)?kernel import|NamedTuple|intrinsic")
    newest = max(
        path.stat().st_mtime for path in package.rglob("*.py") if compiles.search(path.read_text("utf-8"))
    )
    for path in compiled:
        with suppress(OSError):  # another process removes them too; who may not remove them uses others
            if path.stat().st_mtime < newest:
                path.unlink()


if not config.DISABLE_JIT:
    find_room(nothing)
    forget_stale_kernels(Path(__file__).parents[1])
