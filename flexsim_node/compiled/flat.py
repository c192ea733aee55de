"""A contiguous array as a vector, for kernels: a view that costs nothing."""

from __future__ import annotations

from typing import Any

from numba import config, types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic


def flattened() -> Any:
    """Function (array) for kernels: all its entries, one after the other."""

    def plain(array):
        return array.reshape(-1)

    if config.DISABLE_JIT:
        return plain

    def emit(context, builder, signature, arguments):
        given = context.make_array(signature.args[0])(context, builder, arguments[0])
        view = context.make_array(signature.return_type)(context, builder)
        count, width = given.nitems, given.itemsize
        view.data, view.nitems, view.itemsize = given.data, count, width
        view.shape, view.strides = (cgutils.pack_array(builder, [number]) for number in (count, width))
        for counter in ("meminfo", "parent"):
            setattr(view, counter, cgutils.get_null_value(getattr(view, counter).type))
        return view._getvalue()

    def flat(_typing, array):
        if getattr(array, "layout", "") != "C":
            raise TypingError("only a contiguous array is flat")
        return types.Array(array.dtype, 1, "C")(array), emit

    return intrinsic(flat)


flat = flattened()
