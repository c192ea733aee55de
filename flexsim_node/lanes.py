"""Four numbers side by side in a vector register, for kernels whose short loops go along a row.

    total = broadcast(0.0)
    for k in range(0, n, 4):
        total = multiply_add(load(x, k), load(y, k), total)

What stays in a register need not be written and read again, which takes longer than the arithmetic.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from llvmlite import ir
from numba import config, types
from numba.core.errors import TypingError
from numba.extending import intrinsic, models, register_model

NUMBER, PLACE = ir.DoubleType(), ir.IntType(32)
VECTOR = ir.VectorType(NUMBER, 4)


class Lanes(types.Type):
    """Type of four numbers in a register."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


LANES = Lanes()


@register_model(Lanes)
class LanesModel(models.PrimitiveModel):
    """How the compiler keeps them: as a vector of its own."""

    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, VECTOR)


def address(context, builder, signature, arguments):
    """Where the four numbers of an array's place are."""
    data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
    return builder.bitcast(builder.gep(data, [arguments[1]]), VECTOR.as_pointer())


def contiguous(array) -> None:
    """Refuse arrays with gaps."""
    if getattr(array, "layout", "") != "C":
        raise TypingError("four numbers side by side are of a contiguous vector")


def load(_typing, x, at):
    """x[at : at + 4]."""
    contiguous(x)

    def emit(context, builder, signature, arguments):
        return builder.load(address(context, builder, signature, arguments), align=8)

    return LANES(x, types.int64), emit


def store(_typing, x, at, lanes):
    """x[at : at + 4] = lanes."""
    contiguous(x)

    def emit(context, builder, signature, arguments):
        builder.store(arguments[2], address(context, builder, signature, arguments), align=8)
        return context.get_dummy_value()

    return types.void(x, types.int64, LANES), emit


def broadcast(_typing, number):
    """One number four times."""

    def emit(_context, builder, _signature, arguments):
        none = ir.Constant(VECTOR, ir.Undefined)
        first = builder.insert_element(none, arguments[0], ir.Constant(PLACE, 0))
        return builder.shuffle_vector(first, none, ir.Constant(ir.VectorType(PLACE, 4), [0] * 4))

    return LANES(types.float64), emit


def multiply(_typing, a, b):
    """a b, number by number."""

    def emit(_context, builder, _signature, arguments):
        return builder.fmul(*arguments, flags=("contract",))

    return LANES(LANES, LANES), emit


def multiply_add(_typing, a, b, c):
    """a b + c, number by number."""

    def emit(_context, builder, _signature, arguments):
        product = builder.fmul(arguments[0], arguments[1], flags=("contract",))
        return builder.fadd(product, arguments[2], flags=("contract",))

    return LANES(LANES, LANES, LANES), emit


def total(_typing, lanes):
    """Sum of the four."""

    def emit(_context, builder, _signature, arguments):
        a, b, c, d = (builder.extract_element(arguments[0], ir.Constant(PLACE, k)) for k in range(4))
        return builder.fadd(builder.fadd(a, c), builder.fadd(b, d))

    return types.float64(LANES), emit


if config.DISABLE_JIT:

    def load(x, at):
        return x[at : at + 4].copy()

    def store(x, at, lanes):
        x[at : at + 4] = lanes

    def broadcast(number):
        return np.full(4, number)

    def multiply(a, b):
        return a * b

    def multiply_add(a, b, c):
        return a * b + c

    def total(lanes):
        return float(lanes[0] + lanes[2] + (lanes[1] + lanes[3]))

else:
    load, store, broadcast = intrinsic(load), intrinsic(store), intrinsic(broadcast)
    multiply, multiply_add, total = intrinsic(multiply), intrinsic(multiply_add), intrinsic(total)
