"""How the hot functions are compiled: to machine code that neither allocates nor counts references.

Each kernel is a library of its own: what it calls is copied into it and is private there.  By numba's default
those copies are shared symbols, and which kernel's copy a call then reaches depends on the order in which a
process has loaded them.  Copies are optimised where they stand, so their sums round differently: the same run
would differ in its last bits from process to process.  Private ones are also inlined and dropped more freely,
which makes a step a third cheaper.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
from numba import njit, typeof
from numba.core.codegen import CPUCodeLibrary

optimize_shared = CPUCodeLibrary._optimize_final_module


def optimize_private(library: CPUCodeLibrary) -> None:
    """Optimise a compiled library once its copies of other functions are its own."""
    for function in library._final_module.functions:
        if not function.is_declaration and function.linkage == llvm.Linkage.linkonce_odr:
            function.linkage = llvm.Linkage.internal
    optimize_shared(library)


CPUCodeLibrary._optimize_final_module = optimize_private

# no assumption that NaN can't occur, since the step looks for it
FAST = {"reassoc", "contract", "nsz", "arcp"}

# compiled once, kept on disk.  Without numba's runtime (_nrt) a kernel can't allocate, and slices are free
kernel = njit(cache=True, fastmath=FAST, error_model="numpy", nogil=True, _nrt=False)
# for functions outside the step that do allocate
allocating_kernel = njit(cache=True, fastmath=FAST, error_model="numpy", nogil=True)


def entry(function: Any, *arguments: Any) -> Callable[..., Any]:
    """A kernel compiled for arguments of these types: it does not look at them anew, a microsecond a call."""
    compiled: Callable[..., Any] = function.compile(tuple(typeof(x) for x in arguments))
    return compiled


def forget_stale_kernels(package: Path) -> None:
    """Remove compiled kernels that are older than any source of kernels in the package.

    numba looks only at the file of the function itself, not at those of the functions that it calls.
    """
    compiled = [*package.rglob("*.nbi")]  # beside each source, in the __pycache__ of its folder
    if not compiled:
        return
    compiles = re.compile(r"from \.+kernel import|NamedTuple")  # kernels, and the arrays that they work on
    newest = max(
        path.stat().st_mtime for path in package.rglob("*.py") if compiles.search(path.read_text("utf-8"))
    )
    if newest > min(path.stat().st_mtime for path in compiled):
        for path in [*compiled, *package.rglob("*.nbc")]:
            path.unlink(missing_ok=True)


forget_stale_kernels(Path(__file__).parent)
