"""Numbers side by side in registers: compiled, they are what plain arrays of four are."""

from __future__ import annotations

import numpy as np
from numba import config, njit

from flexsim_node.compiled.kernel import FAST, kernel
from flexsim_node.compiled.lanes import (
    apart,
    broadcast,
    four,
    load,
    multiply,
    multiply_add,
    plus,
    store,
    total,
)


@kernel
def combined(n, x, y, factor, out):
    """Write factor x^2 + y into out, and return the sum."""
    found = broadcast(0.0)
    for k in range(0, n, 4):
        row = load(x, k)
        lanes = multiply_add(multiply(broadcast(factor), row), row, load(y, k))
        store(out, k, lanes)
        found = multiply_add(broadcast(1.0), lanes, found)
    return total(found)


@kernel
def turned_round(x, out):
    """Write twice x (4,), the last number first, into out."""
    a, b, c, d = apart(plus(load(x, 0), load(x, 0)))
    store(out, 0, four(d, c, b, a))


def test_numbers_are_taken_apart_and_put_together() -> None:
    x, out = np.array([1.0, 2.0, 3.0, 5.0]), np.zeros(4)
    turned_round(x, out)
    assert out.tolist() == [10.0, 6.0, 4.0, 2.0]


def test_rows_are_combined_number_by_number() -> None:
    """Every number is its own, none beyond the row is touched; a row may begin anywhere."""
    rng = np.random.default_rng(1)
    for n, begin in ((4, 0), (8, 1), (12, 3)):
        x, y = rng.standard_normal((2, n + begin))
        whole = np.full(n + begin + 4, 7.0)
        found = combined(n, x[begin:], y[begin:], 0.5, whole[begin : begin + n])
        expected = 0.5 * x[begin:] ** 2 + y[begin:]
        np.testing.assert_allclose(whole[begin : begin + n], expected, rtol=1e-15, atol=1e-15)
        assert abs(found - expected.sum()) < 1e-13
        assert (whole[:begin] == 7.0).all()
        assert (whole[begin + n :] == 7.0).all()


def test_it_runs_in_registers() -> None:
    """The loop is compiled to instructions on four numbers, unless kernels are plain Python."""
    if not config.DISABLE_JIT:
        # compiled here and now: what was kept from a run before has no words to look at
        fresh = njit(fastmath=FAST, error_model="numpy")(combined.py_func)
        fresh(4, np.ones(4), np.ones(4), 0.5, np.zeros(4))
        words = next(iter(fresh.inspect_llvm().values()))
        assert "<4 x double>" in words
