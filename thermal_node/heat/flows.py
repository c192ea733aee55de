"""What the nodes of a leaf exchange along edges, faces and bodies; see mesh/exchange.py.

Every part's flow is computed first, materials summed, and then gathered by its nodes: loops over shifted
views without borders, branches or index arithmetic.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..compiled.arithmetic import FAST
from ..mesh.exchange import Exchange
from .twists import gather_twists, through, twists_of

Array = NDArray[np.float64]


class Flows(NamedTuple):
    """Work for the flows of n nodes: of node i's parts at 2 plane + i, zeros before.

    edges (3, N + 2 plane) : along x, y, z
    twists (4, N + 2 plane) : of faces xy, xz, yz and bodies; of size 0 where there are none
    """

    edges: Array
    twists: Array


def flows_of(n: int, plane: int, finite_elements: bool) -> Flows:
    """Room for the flows of n nodes, `plane` of them in a plane of constant z."""
    return Flows(np.zeros((3, n + 2 * plane)), twists_of(n, plane, finite_elements))


@njit(cache=True, fastmath=FAST)
def exchange(
    f: Array, slope: Array, weight: Exchange, total: Exchange, into: Array, flows: Flows, row: int, plane: int
) -> None:
    """Let materials exchange f (M, N) into `into` (N,); write the exchanges' derivatives to `total`.

    The derivatives of what edges exchange take the mean slope of their nodes: symmetric, and close enough for
    Newton's iteration. Those of faces and bodies take the least: they take away from what edges conduct, and
    the iteration goes astray where that is too much.

    row, plane : nodes in a row along x, and in a plane of constant z
    """
    n, o = into.size, 2 * plane
    flows.edges[:] = 0.0
    flows.twists[:] = 0.0
    _clear(total)
    for m in range(f.shape[0]):
        if weight.x.size > 0:
            _edges(flows.edges[0, o:], total.x, weight.x[m].reshape(n), f[m], slope[m], 1)
        if weight.y.size > 0:
            _edges(flows.edges[1, o:], total.y, weight.y[m].reshape(n), f[m], slope[m], row)
        if weight.z.size > 0:
            _edges(flows.edges[2, o:], total.z, weight.z[m].reshape(n), f[m], slope[m], plane)
        if weight.xy.size > 0:
            _faces(flows.twists[0, o:], total.xy, weight.xy[m].reshape(n), f[m], slope[m], 1, row)
        if weight.xz.size > 0:
            _faces(flows.twists[1, o:], total.xz, weight.xz[m].reshape(n), f[m], slope[m], 1, plane)
        if weight.yz.size > 0:
            _faces(flows.twists[2, o:], total.yz, weight.yz[m].reshape(n), f[m], slope[m], row, plane)
        if weight.xyz.size > 0:
            _bodies(flows.twists[3, o:], total.xyz, weight.xyz[m].reshape(n), f[m], slope[m], row, plane)
    x, y, z = flows.edges
    _gather_edges(into, x[o:], x[o - 1 :], y[o:], y[o - row :], z[o:], z[o - plane :])
    if flows.twists.size > 0:
        through(flows.twists, plane)
        gather_twists(into, flows.twists, row, plane)


@njit(cache=True, fastmath=FAST)
def _clear(exchange: Exchange) -> None:
    exchange.x[:] = 0.0
    exchange.y[:] = 0.0
    exchange.z[:] = 0.0
    exchange.xy[:] = 0.0
    exchange.xz[:] = 0.0
    exchange.yz[:] = 0.0
    exchange.xyz[:] = 0.0


@njit(cache=True, fastmath=FAST)
def _edges(out: Array, total: Array, w: Array, f: Array, slope: Array, side: int) -> None:
    """Edges whose nodes are `side` apart."""
    n = f.size - side
    _edge(out[:n], total, w, f, f[side:], slope, slope[side:])


@njit(cache=True, fastmath=FAST)
def _edge(out: Array, total: Array, w: Array, a: Array, b: Array, slope_a: Array, slope_b: Array) -> None:
    """What an edge's first node gains, its last loses."""
    for i in range(out.size):
        out[i] -= w[i] * (a[i] - b[i])
        total[i] += 0.5 * w[i] * (slope_a[i] + slope_b[i])


@njit(cache=True, fastmath=FAST)
def _faces(out: Array, total: Array, w: Array, f: Array, slope: Array, one: int, two: int) -> None:
    """Faces whose sides are `one` and `two` nodes apart."""
    n, both = f.size - one - two, one + two
    _face(out[:n], total, w, f, f[one:], f[two:], f[both:], slope, slope[one:], slope[two:], slope[both:])


@njit(cache=True, fastmath=FAST)
def _face(
    out: Array,
    total: Array,
    w: Array,
    a: Array,
    b: Array,
    c: Array,
    d: Array,
    slope_a: Array,
    slope_b: Array,
    slope_c: Array,
    slope_d: Array,
) -> None:
    """What leaves a face's first node, the last has its share of; the others gain it."""
    for i in range(out.size):
        out[i] -= w[i] * ((a[i] - b[i]) - (c[i] - d[i]))
        total[i] += w[i] * min(min(slope_a[i], slope_b[i]), min(slope_c[i], slope_d[i]))


@njit(cache=True, fastmath=FAST)
def _bodies(out: Array, total: Array, w: Array, f: Array, slope: Array, row: int, plane: int) -> None:
    """Bodies: the difference of the twists before and behind."""
    n = f.size - plane - row - 1
    _body(
        out[:n],
        w,
        f,
        f[1:],
        f[row:],
        f[row + 1 :],
        f[plane:],
        f[plane + 1 :],
        f[plane + row :],
        f[plane + row + 1 :],
    )
    _least(
        total[:n],
        w,
        slope,
        slope[1:],
        slope[row:],
        slope[row + 1 :],
        slope[plane:],
        slope[plane + 1 :],
        slope[plane + row :],
        slope[plane + row + 1 :],
    )


@njit(cache=True, fastmath=FAST)
def _body(
    out: Array,
    w: Array,
    a0: Array,
    b0: Array,
    c0: Array,
    d0: Array,
    a1: Array,
    b1: Array,
    c1: Array,
    d1: Array,
) -> None:
    for i in range(out.size):
        before, behind = (a0[i] - b0[i]) - (c0[i] - d0[i]), (a1[i] - b1[i]) - (c1[i] - d1[i])
        out[i] -= w[i] * (before - behind)


@njit(cache=True, fastmath=FAST)
def _least(
    total: Array,
    w: Array,
    a0: Array,
    b0: Array,
    c0: Array,
    d0: Array,
    a1: Array,
    b1: Array,
    c1: Array,
    d1: Array,
) -> None:
    for i in range(total.size):
        before, behind = min(min(a0[i], b0[i]), min(c0[i], d0[i])), min(min(a1[i], b1[i]), min(c1[i], d1[i]))
        total[i] += w[i] * min(before, behind)


@njit(cache=True, fastmath=FAST)
def _gather_edges(into: Array, x0: Array, x1: Array, y0: Array, y1: Array, z0: Array, z1: Array) -> None:
    for i in range(into.size):
        into[i] += (x0[i] - x1[i]) + (y0[i] - y1[i]) + (z0[i] - z1[i])
