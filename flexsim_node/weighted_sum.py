"""Sums of short rows, weight by weight, in vector registers.

Numba's optimiser turns a loop into vectors along its count alone, which short loops don't repay.  Here the
lanes of a vector are the entries of a row, and the sum stays in a register.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import config, types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic


def weighted_sum(lanes: int, kept: int) -> Callable[..., Any]:
    """Function (n, x, at, step, rows, first, width, out, place) for kernels.

    It adds sum_i x[at + i step] rows[first + i width :][:lanes] over i < n to out[place:], the first `kept`
    entries; all arrays are contiguous vectors.
    """

    def plain(n, x, at, step, rows, first, width, out, place):
        for i in range(n):
            for k in range(kept):
                out[place + k] += x[at + i * step] * rows[first + i * width + k]

    if config.DISABLE_JIT:
        return plain

    def emit(context, builder, signature, arguments):
        n, x, at, step, rows, first, width, out, place = arguments
        number = ir.DoubleType()
        vector = ir.VectorType(number, lanes)
        x, rows, out = (
            context.make_array(signature.args[k])(context, builder, arguments[k]).data for k in (1, 4, 7)
        )
        total = cgutils.alloca_once(builder, vector)
        builder.store(ir.Constant(vector, None), total)
        with cgutils.for_range(builder, n) as loop:
            here = builder.add(at, builder.mul(loop.index, step))
            weight = builder.load(builder.gep(x, [here]))
            spread = builder.insert_element(
                ir.Constant(vector, ir.Undefined), weight, ir.Constant(ir.IntType(32), 0)
            )
            same = ir.Constant(ir.VectorType(ir.IntType(32), lanes), [0] * lanes)
            spread = builder.shuffle_vector(spread, ir.Constant(vector, ir.Undefined), same)
            row = builder.gep(rows, [builder.add(first, builder.mul(loop.index, width))])
            row = builder.load(builder.bitcast(row, vector.as_pointer()), align=8)
            product = builder.fmul(spread, row, flags=("contract",))
            builder.store(builder.fadd(builder.load(total), product, flags=("contract",)), total)
        whole, begin = builder.load(total), 0
        while begin < kept:
            size = 1 << ((kept - begin).bit_length() - 1)
            part = ir.VectorType(number, size)
            chosen = ir.Constant(ir.VectorType(ir.IntType(32), size), list(range(begin, begin + size)))
            some = builder.shuffle_vector(whole, whole, chosen)
            there = builder.gep(out, [builder.add(place, ir.Constant(ir.IntType(64), begin))])
            there = builder.bitcast(there, part.as_pointer())
            some = builder.fadd(builder.load(there, align=8), some, flags=("contract",))
            builder.store(some, there, align=8)
            begin += size
        return context.get_dummy_value()

    def typed(_typing, n, x, at, step, rows, first, width, out, place):
        if any(getattr(kind, "layout", "") != "C" for kind in (x, rows, out)):
            raise TypingError("a weighted sum is of contiguous vectors")
        count = types.int64
        return types.void(count, x, count, count, rows, count, count, out, count), emit

    typed.__name__ = f"weighted_sum_{lanes}_{kept}"
    return intrinsic(typed)


sum_four = weighted_sum(4, 4)
sum_eight = weighted_sum(8, 8)
sum_three_of_four = weighted_sum(4, 3)
sum_six_of_eight = weighted_sum(8, 6)
