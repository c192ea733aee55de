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

from .kernel import kernel


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
        number, shuffle, count = ir.DoubleType(), ir.IntType(32), ir.IntType(64)
        x, rows, out = (
            context.make_array(signature.args[k])(context, builder, arguments[k]).data for k in (1, 5, 8)
        )
        begins = range(0, lanes, 8)
        vectors = [ir.VectorType(number, min(8, lanes - begin)) for begin in begins]
        totals = [[cgutils.alloca_once(builder, vector) for vector in vectors] for _ in range(parts)]
        for part in totals:
            for total, vector in zip(part, vectors, strict=True):
                builder.store(ir.Constant(vector, None), total)
        with cgutils.for_range(builder, n) as loop:
            here = builder.add(at, builder.mul(loop.index, step))
            row = builder.gep(rows, [builder.add(first, builder.mul(loop.index, width))])
            pieces = []
            for begin, vector in zip(begins, vectors, strict=True):
                there = builder.bitcast(builder.gep(row, [ir.Constant(count, begin)]), vector.as_pointer())
                pieces.append(builder.load(there, align=8))
            for part in totals:
                weight = builder.load(builder.gep(x, [here]))
                for total, piece, vector in zip(part, pieces, vectors, strict=True):
                    same = ir.Constant(ir.VectorType(shuffle, vector.count), [0] * vector.count)
                    none = ir.Constant(vector, ir.Undefined)
                    spread = builder.insert_element(none, weight, ir.Constant(shuffle, 0))
                    spread = builder.shuffle_vector(spread, none, same)
                    product = builder.fmul(spread, piece, flags=("contract",))
                    builder.store(builder.fadd(builder.load(total), product, flags=("contract",)), total)
                here = builder.add(here, apart)
        for part in totals:
            for total, begin in zip(part, begins, strict=True):
                whole, end = builder.load(total), min(kept - begin, 8)
                at = 0
                while at < end:
                    size = 1 << ((end - at).bit_length() - 1)
                    some = ir.VectorType(number, size)
                    chosen = ir.Constant(ir.VectorType(shuffle, size), list(range(at, at + size)))
                    piece = builder.shuffle_vector(whole, whole, chosen)
                    there = builder.gep(out, [builder.add(place, ir.Constant(count, begin + at))])
                    there = builder.bitcast(there, some.as_pointer())
                    if add:
                        piece = builder.fadd(builder.load(there, align=8), piece, flags=("contract",))
                    builder.store(piece, there, align=8)
                    at += size
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
four_once = weighted_sums(4, 4, 1, False)
eight_once = weighted_sums(8, 8, 1, False)
twelve_once = weighted_sums(12, 12, 1, False)
lanes_once = weighted_sums(24, 24, 1, False)
add_four = weighted_sums(4, 4, 1, True)
add_eight = weighted_sums(8, 8, 1, True)
add_twelve = weighted_sums(12, 12, 1, True)
add_lanes = weighted_sums(24, 24, 1, True)
four_twice = weighted_sums(4, 4, 2, False)
eight_twice = weighted_sums(8, 8, 2, False)
twelve_twice = weighted_sums(12, 12, 2, False)
four_thrice = weighted_sums(4, 4, 3, False)
eight_thrice = weighted_sums(8, 8, 3, False)
twelve_thrice = weighted_sums(12, 12, 3, False)
add_four_thrice = weighted_sums(4, 4, 3, True)
add_eight_thrice = weighted_sums(8, 8, 3, True)
eight_six = weighted_sums(8, 8, 6, False)
add_lanes_thrice = weighted_sums(24, 24, 3, True)
add_twelve_thrice = weighted_sums(12, 12, 3, True)
# rows of a front over three nodes in space, those of a node or of two alike ones at once
add_whole_rows = weighted_sums(24, 18, 6, True)
add_later_rows = weighted_sums(12, 12, 6, True)
add_last_rows = weighted_sums(8, 6, 6, True)
add_row_pair = weighted_sums(8, 6, 2, True)
# likewise in the plane
add_whole_planar_rows = weighted_sums(12, 9, 3, True)
add_six = weighted_sums(8, 6, 1, True)
add_later_planar_rows = weighted_sums(8, 6, 3, True)
add_last_planar_rows = weighted_sums(4, 3, 3, True)
add_planar_row_pair = weighted_sums(4, 3, 2, True)


@kernel
def combine(n, x, at, rows, first, width, out, place, columns):
    """out[place:] = sum_i x[at + i] rows[first + i width:] over i < n, a multiple of four columns."""
    k = 0
    while columns - k >= 24:
        lanes_once(n, x, at, 1, 0, rows, first + k, width, out, place + k, 0)
        k += 24
    while columns - k >= 12:
        twelve_once(n, x, at, 1, 0, rows, first + k, width, out, place + k, 0)
        k += 12
    if columns - k >= 8:
        eight_once(n, x, at, 1, 0, rows, first + k, width, out, place + k, 0)
        k += 8
    if columns - k >= 4:
        four_once(n, x, at, 1, 0, rows, first + k, width, out, place + k, 0)


@kernel
def add_combined(n, x, at, rows, first, width, out, place, columns):
    """The same, added to out."""
    k = 0
    while columns - k >= 24:
        add_lanes(n, x, at, 1, 0, rows, first + k, width, out, place + k, 0)
        k += 24
    while columns - k >= 12:
        add_twelve(n, x, at, 1, 0, rows, first + k, width, out, place + k, 0)
        k += 12
    if columns - k >= 8:
        add_eight(n, x, at, 1, 0, rows, first + k, width, out, place + k, 0)
        k += 8
    if columns - k >= 4:
        add_four(n, x, at, 1, 0, rows, first + k, width, out, place + k, 0)


@kernel
def mix(parts, n, x, at, rows, first, width, out, place):
    """For 2 or 3 parts p: out[place + p width:] = sum_i x[at + p n + i] rows[first + i width:], i < n.

    width is a multiple of four.
    """
    k = 0
    while width - k >= 12:
        if parts == 3:
            twelve_thrice(n, x, at, 1, n, rows, first + k, width, out, place + k, width)
        else:
            twelve_twice(n, x, at, 1, n, rows, first + k, width, out, place + k, width)
        k += 12
    if width - k >= 8:
        if parts == 3:
            eight_thrice(n, x, at, 1, n, rows, first + k, width, out, place + k, width)
        else:
            eight_twice(n, x, at, 1, n, rows, first + k, width, out, place + k, width)
        k += 8
    if width - k >= 4:
        if parts == 3:
            four_thrice(n, x, at, 1, n, rows, first + k, width, out, place + k, width)
        else:
            four_twice(n, x, at, 1, n, rows, first + k, width, out, place + k, width)


@kernel
def add_mix(n, x, at, rows, first, width, out, place):
    """For three parts p: out[place + p width:] += sum_i x[at + p n + i] rows[first + i width:], i < n.

    width is a multiple of four.
    """
    k = 0
    while width - k >= 8:
        add_eight_thrice(n, x, at, 1, n, rows, first + k, width, out, place + k, width)
        k += 8
    if width - k >= 4:
        add_four_thrice(n, x, at, 1, n, rows, first + k, width, out, place + k, width)
