"""How the hot functions are compiled: to machine code that neither allocates nor counts references.

A kernel called from Python is a library of its own: the kernels that it calls are copied into it, are private
there and are optimised there alone.  By numba's default each called kernel is first optimised and translated
by itself, which is most of the compiler's time; and its copies are shared symbols: which kernel's copy a call
then reaches depends on the order in which a process has loaded them.  Copies are optimised where they stand,
so their sums round differently, and the same run would differ in its last bits from process to process.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any, cast

import llvmlite.binding as llvm
from numba import config, njit, typeof
from numba._dynfunc import make_function
from numba.core.codegen import CPUCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.typed_passes import NativeLowering

optimize_shared = CPUCodeLibrary._optimize_final_module
translate_shared = CPUCodeLibrary._finalize_final_module


def optimize_private(library: CPUCodeLibrary) -> None:
    """Optimise a compiled library once its copies of other functions are its own.

    They get names of their own too.  What is private may lose arguments, and LLVM's loader finds functions by
    name, private ones too: another library's copy of the same function would be taken for it.
    """
    if getattr(library, "only_copied", False):
        return
    defined = [function for function in library._final_module.functions if not function.is_declaration]
    shared = [function for function in defined if function.linkage == llvm.Linkage.linkonce_odr]
    own = sorted(f.name for f in defined if f.linkage == llvm.Linkage.external)
    mark = hashlib.sha256("".join(own).encode()).hexdigest()[:16]
    for function in shared:
        function.linkage = llvm.Linkage.internal
        function.name = f"{function.name}.{mark}"
    optimize_shared(library)


def translate_called(library: CPUCodeLibrary) -> None:
    """Make machine code of a library, unless it is only ever copied into others."""
    if getattr(library, "only_copied", False):
        library._finalize_dynamic_globals()
        library._finalized = True
    else:
        translate_shared(library)


CPUCodeLibrary._optimize_final_module = optimize_private
CPUCodeLibrary._finalize_final_module = translate_called


@register_pass(mutates_CFG=True, analysis_only=False)
class CopiedLowering(NativeLowering):
    """Lowering of a kernel for the kernels that call it."""

    _name = "copied_lowering"

    def run_pass(self, state):
        """Lower into a library that is not translated."""
        state.library = state.targetctx.codegen().create_library(state.func_id.func_qualname)
        state.library.only_copied = True
        state.flags.no_compile = True
        super().run_pass(state)
        # numba knows a function by its entry for Python; this one leads nowhere and nobody can call it
        lowered = state["cr"]
        name = state.func_id.func_name
        nowhere = make_function(lowered.fndesc.lookup_module(), name, name, 0, lowered.env, (state.library,))
        state.targetctx.insert_user_function(nowhere, lowered.fndesc, [state.library])
        state["cr"] = lowered._replace(cfunc=nowhere)
        return True


class CopiedCompiler(CompilerBase):
    """Numba's compiler with this lowering."""

    def define_pipelines(self):
        """Numba's passes but for the lowering."""
        passes = PassManager("copied")
        for kind, words in DefaultPassBuilder.define_nopython_pipeline(self.state).passes:
            passes.add_pass(CopiedLowering if kind is NativeLowering else kind, words)
        passes.finalize()
        return [passes]


def compiled(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Decorator of a kernel: compiled for Python, kept on disk, and apart from that for other kernels."""

    def decorate(function: Callable[..., Any]) -> Any:
        if config.DISABLE_JIT:
            return function
        kernel = njit(cache=True, **options)(function)
        inner = njit(
            pipeline_class=CopiedCompiler, no_cpython_wrapper=True, no_cfunc_wrapper=True, **options
        )(function)
        kernel.get_call_template, kernel.get_overload = inner.get_call_template, inner.get_overload
        return kernel

    return decorate


# no assumption that NaN can't occur, since the step looks for it
FAST = {"reassoc", "contract", "nsz", "arcp"}

# without numba's runtime (_nrt) a kernel can't allocate, and slices are free
kernel = compiled(fastmath=FAST, error_model="numpy", nogil=True, _nrt=False)
# for functions outside the step that do allocate
allocating_kernel = compiled(fastmath=FAST, error_model="numpy", nogil=True)


def entry(function: Any, *arguments: Any) -> Callable[..., Any]:
    """A kernel compiled for arguments of these types: it does not look at them anew, a microsecond a call."""
    if config.DISABLE_JIT:
        return cast(Callable[..., Any], function)
    compiled: Callable[..., Any] = function.compile(tuple(typeof(x) for x in arguments))
    return compiled
