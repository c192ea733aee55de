"""Sums of short rows, weight by weight, and products of short vectors, in vector registers.

Numba's optimiser turns a loop into vectors along its count alone, which short loops don't repay.  Here the
lanes of a vector are the entries of a row, and the sums stay in registers: as many of the same rows as there
are parts, so that one need not wait for the other.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import config, types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic


def weighted_sums(lanes: int, kept: int, parts: int, add: bool) -> Callable[..., Any]:
    """Function (n, x, at, step, apart, rows, first, width, out, place, beside) for kernels.

    For every part p it writes sum_i x[at + i step + p apart] rows[first + i width :][:lanes] over i < n to
    out[place + p beside :], the first `kept` entries; or adds it to what is there.  All arrays are contiguous
    vectors.
    """

    def plain(n, x, at, step, apart, rows, first, width, out, place, beside):
        found = [[0.0] * kept for p in range(parts)]
        for i in range(n):
            for p in range(parts):
                for k in range(kept):
                    found[p][k] += x[at + i * step + p * apart] * rows[first + i * width + k]
        for p in range(parts):
            for k in range(kept):
                out[place + p * beside + k] = found[p][k] + (out[place + p * beside + k] if add else 0.0)

    if config.DISABLE_JIT:
        return plain

    def emit(context, builder, signature, arguments):
        n, x, at, step, apart, rows, first, width, out, place, beside = arguments
        number = ir.DoubleType()
        vector, shuffle = ir.VectorType(number, lanes), ir.IntType(32)
        x, rows, out = (
            context.make_array(signature.args[k])(context, builder, arguments[k]).data for k in (1, 5, 8)
        )
        totals = [cgutils.alloca_once(builder, vector) for _ in range(parts)]
        for total in totals:
            builder.store(ir.Constant(vector, None), total)
        same = ir.Constant(ir.VectorType(shuffle, lanes), [0] * lanes)
        none = ir.Constant(vector, ir.Undefined)
        with cgutils.for_range(builder, n) as loop:
            here = builder.add(at, builder.mul(loop.index, step))
            row = builder.gep(rows, [builder.add(first, builder.mul(loop.index, width))])
            row = builder.load(builder.bitcast(row, vector.as_pointer()), align=8)
            for total in totals:
                weight = builder.load(builder.gep(x, [here]))
                spread = builder.insert_element(none, weight, ir.Constant(shuffle, 0))
                spread = builder.shuffle_vector(spread, none, same)
                product = builder.fmul(spread, row, flags=("contract",))
                builder.store(builder.fadd(builder.load(total), product, flags=("contract",)), total)
                here = builder.add(here, apart)
        for total in totals:
            whole, begin = builder.load(total), 0
            while begin < kept:
                size = 1 << ((kept - begin).bit_length() - 1)
                part = ir.VectorType(number, size)
                chosen = ir.Constant(ir.VectorType(shuffle, size), list(range(begin, begin + size)))
                some = builder.shuffle_vector(whole, whole, chosen)
                there = builder.gep(out, [builder.add(place, ir.Constant(ir.IntType(64), begin))])
                there = builder.bitcast(there, part.as_pointer())
                if add:
                    some = builder.fadd(builder.load(there, align=8), some, flags=("contract",))
                builder.store(some, there, align=8)
                begin += size
            place = builder.add(place, beside)
        return context.get_dummy_value()

    def typed(_typing, n, x, at, step, apart, rows, first, width, out, place, beside):
        if any(getattr(kind, "layout", "") != "C" for kind in (x, rows, out)):
            raise TypingError("a weighted sum is of contiguous vectors")
        count = types.int64
        numbers = (count, x, count, count, count, rows, count, count, out, count, count)
        return types.void(*numbers), emit

    typed.__name__ = f"weighted_sums_{lanes}_{kept}_{parts}_{add}"
    return intrinsic(typed)


def scalar_product() -> Callable[..., Any]:
    """Function (n, x, at, y, begin) for kernels: sum_k x[at + k] y[begin + k], k < n, a multiple of four."""

    def plain(n, x, at, y, begin):
        total = 0.0
        for k in range(n):
            total += x[at + k] * y[begin + k]
        return total

    if config.DISABLE_JIT:
        return plain

    def emit(context, builder, signature, arguments):
        n, x, at, y, begin = arguments
        number, shuffle = ir.DoubleType(), ir.IntType(32)
        vector = ir.VectorType(number, 4)
        x, y = (context.make_array(signature.args[k])(context, builder, arguments[k]).data for k in (1, 3))
        total = cgutils.alloca_once(builder, vector)
        builder.store(ir.Constant(vector, None), total)
        with cgutils.for_range(builder, builder.udiv(n, ir.Constant(n.type, 4))) as loop:
            here = builder.mul(loop.index, ir.Constant(n.type, 4))
            parts = []
            for array, first in ((x, at), (y, begin)):
                place = builder.bitcast(builder.gep(array, [builder.add(first, here)]), vector.as_pointer())
                parts.append(builder.load(place, align=8))
            product = builder.fmul(*parts, flags=("contract",))
            builder.store(builder.fadd(builder.load(total), product, flags=("contract",)), total)
        found = builder.load(total)
        a, b, c, d = (builder.extract_element(found, ir.Constant(shuffle, k)) for k in range(4))
        return builder.fadd(builder.fadd(a, c), builder.fadd(b, d))

    def typed(_typing, n, x, at, y, begin):
        if any(getattr(kind, "layout", "") != "C" for kind in (x, y)):
            raise TypingError("a scalar product is of contiguous vectors")
        return types.float64(types.int64, x, types.int64, y, types.int64), emit

    typed.__name__ = "scalar_product"
    return intrinsic(typed)


dot = scalar_product()
# rows of four entries, or of eight
add_four = weighted_sums(4, 4, 1, True)
add_eight = weighted_sums(8, 8, 1, True)
four_once = weighted_sums(4, 4, 1, False)
four_twice = weighted_sums(4, 4, 2, False)
four_thrice = weighted_sums(4, 4, 3, False)
four_seven_times = weighted_sums(4, 4, 7, False)
# three of four entries, or six of eight, are those of a node
add_planar_node = weighted_sums(4, 3, 1, True)
add_spatial_node = weighted_sums(8, 6, 1, True)
add_planar_block = weighted_sums(4, 3, 3, True)
add_spatial_block = weighted_sums(8, 6, 6, True)
