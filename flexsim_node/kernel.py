"""How the hot functions are compiled: to machine code that neither allocates nor counts references."""

from __future__ import annotations

from pathlib import Path

from numba import njit

# no assumption that NaN can't occur, since the step looks for it
FAST = {"reassoc", "contract", "nsz", "arcp"}

# compiled once, kept on disk.  Without numba's runtime (_nrt) a kernel can't allocate, and slices are free
kernel = njit(
    cache=True, fastmath=FAST, error_model="numpy", nogil=True, _nrt=False
)
# for functions outside the step that do allocate
allocating_kernel = njit(cache=True, fastmath=FAST, error_model="numpy", nogil=True)


def forget_stale_kernels(package: Path) -> None:
    """Remove compiled kernels that are older than any source of the package.

    numba looks only at the file of the function itself, not at those of the functions that it calls.
    """
    cache = package / "__pycache__"
    compiled = [*cache.glob("*.nbi"), *cache.glob("*/*.nbi")]
    if not compiled:
        return
    newest = max(path.stat().st_mtime for path in package.rglob("*.py"))
    if newest > min(path.stat().st_mtime for path in compiled):
        for path in [*compiled, *cache.glob("*.nbc"), *cache.glob("*/*.nbc")]:
            path.unlink(missing_ok=True)


forget_stale_kernels(Path(__file__).parent)
