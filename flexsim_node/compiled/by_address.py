"""Compiled functions that kernels call by their address.

A kernel that calls another by name is compiled together with it, for each type of robot, and its copy rounds
differently in the last bits (kernel.py).  Called by address it is the very function that Python calls.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import config, typeof, types
from numba.core import cgutils
from numba.extending import intrinsic

from .by_reference import Reference


def address(function: Any, *arguments: Any) -> Any:
    """Where the code of a compiled function for arguments of these types begins; compiled where need be."""
    if config.DISABLE_JIT:
        return function
    kinds = tuple(typeof(x) for x in arguments)
    function.compile(kinds)
    found = function.overloads[kinds]
    return found.library.get_pointer_to_function(found.fndesc.llvm_func_name)


def image(values: Any) -> Any:
    """Where the image of what is handed over by reference begins."""
    return values.address if isinstance(values, Reference) else values


def by_address(result: Any, *arguments: Any) -> Any:
    """Function (address, *arguments) for kernels: calls what has these types, numba's, by its address.

    What kernels take by reference is types.voidptr here, and given by the address of its image.
    """
    if config.DISABLE_JIT:
        return called

    def emit(context: Any, builder: Any, _signature: Any, given: Any) -> Any:
        target, *rest = given
        convention = context.call_conv
        kind = convention.get_function_type(result, arguments)
        values = [
            builder.inttoptr(value, cgutils.voidptr_t) if wanted == types.voidptr else value
            for value, wanted in zip(rest, arguments, strict=True)
        ]
        status, answer = convention.call_function(
            builder, builder.inttoptr(target, kind.as_pointer()), result, arguments, values
        )
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        return answer

    kinds = tuple(types.int64 if kind == types.voidptr else kind for kind in arguments)
    # an intrinsic takes as many arguments as its function names
    names = ", ".join(f"a{k}" for k in range(len(kinds)))
    scope: dict[str, Any] = {"signature": lambda: (result(types.int64, *kinds), emit)}
    exec(f"def at(_typing, target, {names}): return signature()", scope)
    return intrinsic(scope["at"])


def called(function: Callable[..., Any], *arguments: Any) -> Any:
    """The same in plain Python, where a function is its own address."""
    return function(*arguments)
