"""Kernels that numba keeps compiled on disk, and when they are too old to be used."""

from __future__ import annotations

from pathlib import Path


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
            path.unlink(missing_ok=True)


forget_stale_kernels(Path(__file__).parent)
