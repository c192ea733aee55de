"""Feedback laws, compiled: a Python function that writes torques, callable without Python's lock."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from numba import config, njit
from numba.core.errors import NumbaError

from .march import LAW

Function = Callable[..., None]


class CompiledLaw:
    """A law and its machine code.

    Attributes
    ----------
    function : law(time, position, velocity, given, memory, torque), see simulate_many
    """

    def __init__(self, function: Function) -> None:
        self.function = function
        name = getattr(function, "__name__", repr(function))
        if config.DISABLE_JIT:
            self.address: Any = function
            return
        # out of bounds it ends with an error, not with whatever lies there
        dispatcher = njit(nogil=True, error_model="numpy", boundscheck=True)(function)
        try:
            dispatcher.compile(LAW)
        except NumbaError as problem:
            reason = " ".join(str(problem).split())
            raise ValueError(
                f"the law {name} can't be compiled: {reason}; give a function (time, position, velocity,"
                " given, memory, torque) of numbers and arrays that numba knows"
            ) from None
        except TypeError as problem:  # another number of arguments
            raise ValueError(
                f"the law {name}: {problem}; give a function (time, position, velocity, given, memory,"
                " torque)"
            ) from None
        found = dispatcher.overloads[LAW]
        if str(found.signature.return_type) != "none":
            raise ValueError(
                f"the law {name} returns {found.signature.return_type}; let it write into `torque` and return"
                " nothing"
            )
        self.compiled = dispatcher  # keeps the code alive
        self.address = found.library.get_pointer_to_function(found.fndesc.llvm_func_name)
