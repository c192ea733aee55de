"""Four numbers side by side in a vector register, for kernels whose short loops go along a row.

    total = broadcast(0.0)
    for k in range(0, n, 4):
        total = multiply_add(load(x, k), load(y, k), total)

What stays in a register need not be written and read again, which takes longer than the arithmetic.
"""

from __future__ import annotations

from collections.abc import Callable
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


def typed_load(_typing, x, at):
    """x[at : at + 4]."""
    contiguous(x)

    def emit(context, builder, signature, arguments):
        return builder.load(address(context, builder, signature, arguments), align=8)

    return LANES(x, types.int64), emit


def typed_store(_typing, x, at, lanes):
    """x[at : at + 4] = lanes."""
    contiguous(x)

    def emit(context, builder, signature, arguments):
        builder.store(arguments[2], address(context, builder, signature, arguments), align=8)
        return context.get_dummy_value()

    return types.void(x, types.int64, LANES), emit


def typed_broadcast(_typing, number):
    """One number four times."""

    def emit(_context, builder, _signature, arguments):
        none = ir.Constant(VECTOR, ir.Undefined)
        first = builder.insert_element(none, arguments[0], ir.Constant(PLACE, 0))
        return builder.shuffle_vector(first, none, ir.Constant(ir.VectorType(PLACE, 4), [0] * 4))

    return LANES(types.float64), emit


def typed_multiply(_typing, a, b):
    """a b, number by number."""

    def emit(_context, builder, _signature, arguments):
        return builder.fmul(*arguments, flags=("contract",))

    return LANES(LANES, LANES), emit


def typed_multiply_add(_typing, a, b, c):
    """a b + c, number by number."""

    def emit(_context, builder, _signature, arguments):
        product = builder.fmul(arguments[0], arguments[1], flags=("contract",))
        return builder.fadd(product, arguments[2], flags=("contract",))

    return LANES(LANES, LANES, LANES), emit


def typed_plus(_typing, a, b):
    """a + b, number by number."""

    def emit(_context, builder, _signature, arguments):
        return builder.fadd(*arguments, flags=("contract",))

    return LANES(LANES, LANES), emit


def typed_total(_typing, lanes):
    """Sum of the four."""

    def emit(_context, builder, _signature, arguments):
        a, b, c, d = (builder.extract_element(arguments[0], ir.Constant(PLACE, k)) for k in range(4))
        return builder.fadd(builder.fadd(a, c), builder.fadd(b, d))

    return types.float64(LANES), emit


def typed_four(_typing, a, b, c, d):
    """Four numbers side by side."""

    def emit(_context, builder, _signature, arguments):
        lanes = ir.Constant(VECTOR, ir.Undefined)
        for k, number in enumerate(arguments):
            lanes = builder.insert_element(lanes, number, ir.Constant(PLACE, k))
        return lanes

    return LANES(*[types.float64] * 4), emit


def typed_apart(_typing, lanes):
    """The four as numbers of their own."""

    def emit(context, builder, signature, arguments):
        numbers = [builder.extract_element(arguments[0], ir.Constant(PLACE, k)) for k in range(4)]
        return context.make_tuple(builder, signature.return_type, numbers)

    return types.UniTuple(types.float64, 4)(LANES), emit


def in_registers(typed: Callable[..., Any], plain: Callable[..., Any]) -> Callable[..., Any]:
    """A function for kernels, which is `plain` on arrays of four where kernels are plain Python."""
    if config.DISABLE_JIT:
        return plain
    found: Callable[..., Any] = intrinsic(typed)
    return found


def plain_store(x, at, lanes):
    """x[at : at + 4] = lanes."""
    x[at : at + 4] = lanes


load = in_registers(typed_load, lambda x, at: x[at : at + 4].copy())
store = in_registers(typed_store, plain_store)
broadcast = in_registers(typed_broadcast, lambda number: np.full(4, number))
multiply = in_registers(typed_multiply, lambda a, b: a * b)
multiply_add = in_registers(typed_multiply_add, lambda a, b, c: a * b + c)
plus = in_registers(typed_plus, lambda a, b: a + b)
total = in_registers(typed_total, lambda a: float(a[0] + a[2] + (a[1] + a[3])))
four = in_registers(typed_four, lambda a, b, c, d: np.array([a, b, c, d]))
apart = in_registers(typed_apart, lambda lanes: tuple(lanes.tolist()))
