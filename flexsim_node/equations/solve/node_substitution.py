"""Substitution along a link in space, over nodes whose six dofs are six unknowns in a row.

A node's six pivots have a row each, over (node, node before, A), 18 and 1 / pivot.  What goes from node to
node stays in registers: f0 to f5 of the node, and x, y, z, four each, of the node before and A.
"""

from __future__ import annotations

from ...compiled.flat import flat
from ...compiled.kernel import kernel
from ...compiled.lanes import apart, broadcast, four, load, multiply, multiply_add, store, total
from ..kinematics.dependent_nodes import six_of_its_own

ROW = 19


@kernel
def forward(chain, work, i, first, rhs, f, out):
    """Take the unknowns of nodes i, i - 1, ... out of the load f (18,), their first answers to out (n,).

    It ends at the node `first` or at one with dependent dofs, and returns which: f is then its.
    """
    pivot = flat(work.pivot)
    f0, f1, f2, f3, f4, f5 = f[0], f[1], f[2], f[3], f[4], f[5]
    x, y, z = load(f, 6), load(f, 10), load(f, 14)
    while i > first and six_of_its_own(chain.dofs, chain.unknown, i):
        n, a = chain.unknown[i, 0], 6 * ROW * i
        b, c, d, e, g = a + ROW, a + 2 * ROW, a + 3 * ROW, a + 4 * ROW, a + 5 * ROW
        y0 = (f0 + rhs[n]) * pivot[a + 18]
        y1 = (f1 + rhs[n + 1] - pivot[a + 1] * y0) * pivot[b + 18]
        f2 += rhs[n + 2] - pivot[a + 2] * y0 - pivot[b + 2] * y1
        y2 = f2 * pivot[c + 18]
        f3 += rhs[n + 3] - pivot[a + 3] * y0 - pivot[b + 3] * y1 - pivot[c + 3] * y2
        y3 = f3 * pivot[d + 18]
        f4 += rhs[n + 4] - pivot[a + 4] * y0 - pivot[b + 4] * y1 - pivot[c + 4] * y2 - pivot[d + 4] * y3
        y4 = f4 * pivot[e + 18]
        f5 += rhs[n + 5] - pivot[a + 5] * y0 - pivot[b + 5] * y1 - pivot[c + 5] * y2 - pivot[d + 5] * y3
        y5 = (f5 - pivot[e + 5] * y4) * pivot[g + 18]
        out[n], out[n + 1], out[n + 2], out[n + 3], out[n + 4], out[n + 5] = y0, y1, y2, y3, y4, y5
        for p in range(6):
            taken = broadcast(-out[n + p])
            x = multiply_add(taken, load(pivot, a + 6), x)
            y = multiply_add(taken, load(pivot, a + 10), y)
            z = multiply_add(taken, load(pivot, a + 14), z)
            a += ROW
        f0, f1, f2, f3 = apart(x)
        f4, f5, a0, a1 = apart(y)
        x, y = broadcast(0.0), four(0.0, 0.0, a0, a1)
        i -= 1
    f[0], f[1], f[2], f[3], f[4], f[5] = f0, f1, f2, f3, f4, f5
    store(f, 6, x)
    store(f, 10, y)
    store(f, 14, z)
    return i


@kernel
def known(pivot, row, x, y, z):
    """What the answers of the node before and A make of a pivot's row."""
    others = multiply_add(load(pivot, row + 6), x, multiply(load(pivot, row + 10), y))
    return total(multiply_add(load(pivot, row + 14), z, others))


@kernel
def backward(chain, work, i, last, f, out):
    """Write the answers of nodes i, i + 1, ... to out (n,); f[6:18] has those of the node before and A.

    It ends beyond the node `last` or at one with dependent dofs, and returns which: f is then its.
    """
    pivot = flat(work.pivot)
    x, y, z = load(f, 6), load(f, 10), load(f, 14)
    a0, a1 = f[12], f[13]
    while i <= last and six_of_its_own(chain.dofs, chain.unknown, i):
        n, a = chain.unknown[i, 0], 6 * ROW * i
        b, c, d, e, g = a + ROW, a + 2 * ROW, a + 3 * ROW, a + 4 * ROW, a + 5 * ROW
        # the six rows' known parts don't wait for each other
        k0, k1, k2 = known(pivot, a, x, y, z), known(pivot, b, x, y, z), known(pivot, c, x, y, z)
        k3, k4, k5 = known(pivot, d, x, y, z), known(pivot, e, x, y, z), known(pivot, g, x, y, z)
        f5 = out[n + 5] - pivot[g + 18] * k5
        f4 = out[n + 4] - pivot[e + 18] * (k4 + pivot[e + 5] * f5)
        k3 += pivot[d + 5] * f5 + pivot[d + 4] * f4
        f3 = out[n + 3] - pivot[d + 18] * k3
        k2 += pivot[c + 5] * f5 + pivot[c + 4] * f4 + pivot[c + 3] * f3
        f2 = out[n + 2] - pivot[c + 18] * k2
        k1 += pivot[b + 5] * f5 + pivot[b + 4] * f4 + pivot[b + 3] * f3 + pivot[b + 2] * f2
        f1 = out[n + 1] - pivot[b + 18] * k1
        k0 += pivot[a + 5] * f5 + pivot[a + 4] * f4 + pivot[a + 3] * f3 + pivot[a + 2] * f2
        f0 = out[n] - pivot[a + 18] * (k0 + pivot[a + 1] * f1)
        out[n], out[n + 1], out[n + 2], out[n + 3], out[n + 4], out[n + 5] = f0, f1, f2, f3, f4, f5
        x, y = four(f0, f1, f2, f3), four(f4, f5, a0, a1)
        i += 1
    store(f, 6, x)
    store(f, 10, y)
    return i
