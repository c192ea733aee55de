"""Nodes are taken out in registers as row by row, whatever their rows are; half of a beam's are zeros."""

from types import SimpleNamespace

import numpy as np
import pytest

from flexsim_node.equations.solve.node_substitution import backward, forward

pytestmark = pytest.mark.equations
NODES = 3


def link():
    """Three nodes after a link's start, with rows of which no entry is zero."""
    random = np.random.default_rng(3)
    unknown = np.arange(6 * (NODES + 1)).reshape(-1, 6) - 6
    chain = SimpleNamespace(dofs=(0,) * 6, unknown=unknown)
    work = SimpleNamespace(pivot=random.uniform(0.5, 1.5, (6 * (NODES + 1), 19)))
    return chain, work, random.uniform(0.5, 1.5, 6 * NODES), random.uniform(0.5, 1.5, 18)


def test_loads_are_taken_out_row_by_row():
    chain, work, rhs, f = link()
    right, load = np.zeros(6 * NODES), f.copy()
    for i in range(NODES, 0, -1):
        for p in range(6):
            row, n = work.pivot[6 * i + p], chain.unknown[i, p]
            right[n] = (load[p] + rhs[n]) * row[18]
            load[p + 1 :] -= row[p + 1 : 18] * right[n]
        load[:6], load[6:12] = load[6:12].copy(), 0.0
    out = np.zeros(6 * NODES)
    assert forward(chain, work, NODES, 0, rhs, f, out) == 0
    np.testing.assert_allclose(out, right, rtol=1e-12)
    np.testing.assert_allclose(f, load, rtol=1e-12)


def test_answers_come_back_row_by_row():
    chain, work, out, f = link()
    right, answer = out.copy(), f.copy()
    for i in range(1, NODES + 1):
        for p in range(5, -1, -1):
            row, n = work.pivot[6 * i + p], chain.unknown[i, p]
            answer[p] = right[n] = right[n] - row[18] * (row[p + 1 : 18] @ answer[p + 1 :])
        answer[6:12] = answer[:6]
    assert backward(chain, work, 1, NODES, f, out) == NODES + 1
    np.testing.assert_allclose(out, right, rtol=1e-12)
    np.testing.assert_allclose(f[6:], answer[6:], rtol=1e-12)


def test_a_node_with_dependent_dofs_ends_it():
    chain, work, rhs, f = link()
    chain.unknown[2, 1:] -= 1
    chain.unknown[2, 1] = -1
    assert forward(chain, work, NODES, 0, rhs, f, np.zeros(6 * NODES)) == 2
    assert backward(chain, work, 1, NODES, f, rhs) == 2
