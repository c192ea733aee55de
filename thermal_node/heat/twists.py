"""The twists of finite elements: what their nodes exchange along faces and bodies, beside their edges.

A face's four nodes meet in their twist s . f, s = (+ - - +), a body's eight in the difference of two
twists; see mesh/exchange.py. Every twist is weighed first, and then gathered by the nodes around it:
loops over shifted views without borders or index arithmetic. Twists are kept at 2 plane + i for node i,
with zeros before.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..compiled.arithmetic import FAST

Array = NDArray[np.float64]

XY, XZ, YZ, BODY = range(4)


def twists_of(n: int, plane: int, finite_elements: bool) -> Array:
    """Room (4, N + 2 plane) for the twists of n nodes; of size 0 where there are none."""
    return np.zeros((4, n + 2 * plane if finite_elements else 0))


@njit(cache=True, fastmath=FAST)
def add_to_lines(
    diagonal: Array, edge: Array, faces: Array, bodies: Array, row: int, plane: int, own: Array, line: Array
) -> None:
    """The lines through the thickness: diagonal (N,) and edges (N + plane,) with faces' and bodies' shares.

    faces (3, N + 2 plane) xy, xz, yz and bodies (N + 2 plane,) : weights; own, line : what comes out
    """
    o = 2 * plane
    xy, xz, yz = faces[XY], faces[XZ], faces[YZ]
    _line(
        line[plane:],
        edge[plane:],
        bodies[o:],
        bodies[o - 1 :],
        bodies[o - row :],
        bodies[o - row - 1 :],
        xz[o:],
        xz[o - 1 :],
        yz[o:],
        yz[o - row :],
    )
    _own(
        own,
        diagonal,
        xy[o:],
        xy[o - 1 :],
        xy[o - row :],
        xy[o - row - 1 :],
        line[plane:],
        edge[plane:],
        line,
        edge,
    )


@njit(cache=True, fastmath=FAST)
def _line(
    line: Array,
    edge: Array,
    b0: Array,
    b1: Array,
    b2: Array,
    b3: Array,
    xz0: Array,
    xz1: Array,
    yz0: Array,
    yz1: Array,
) -> None:
    for i in range(line.size):
        line[i] = edge[i] + ((b0[i] + b1[i]) + (b2[i] + b3[i])) + (xz0[i] + xz1[i]) + (yz0[i] + yz1[i])


@njit(cache=True, fastmath=FAST)
def _own(
    own: Array,
    diagonal: Array,
    xy0: Array,
    xy1: Array,
    xy2: Array,
    xy3: Array,
    line1: Array,
    edge1: Array,
    line0: Array,
    edge0: Array,
) -> None:
    """Faces and bodies give both ends of a line's edge what they give the edge."""
    for i in range(own.size):
        own[i] = (
            diagonal[i]
            + ((xy0[i] + xy1[i]) + (xy2[i] + xy3[i]))
            + (line1[i] - edge1[i])
            + (line0[i] - edge0[i])
        )


@njit(cache=True, fastmath=FAST)
def add_product(p: Array, q: Array, faces: Array, bodies: Array, twists: Array, row: int, plane: int) -> None:
    """q += (faces and bodies) p; p goes on for two planes behind q's size."""
    n, o = q.size, 2 * plane
    xy, xz, yz, body = twists[XY], twists[XZ], twists[YZ], twists[BODY]
    _twist(xy[o:], p, p[1:], p[row:], p[row + 1 :])
    _behind(body[o : o + n - plane], bodies[o:], xy[o:], xy[o + plane :])
    _weigh_through(xy[o:], faces[XY, o:], body[o:], body[o - plane :])
    _weighed_twist(xz[o:], faces[XZ, o:], p, p[1:], p[plane:], p[plane + 1 :])
    _weighed_twist(yz[o:], faces[YZ, o:], p, p[row:], p[plane:], p[plane + row :])
    gather_twists(q, twists, row, plane)


@njit(cache=True, fastmath=FAST)
def _twist(out: Array, a: Array, b: Array, c: Array, d: Array) -> None:
    for i in range(out.size):
        out[i] = (a[i] - b[i]) - (c[i] - d[i])


@njit(cache=True, fastmath=FAST)
def _weighed_twist(out: Array, w: Array, a: Array, b: Array, c: Array, d: Array) -> None:
    for i in range(out.size):
        out[i] = w[i] * ((a[i] - b[i]) - (c[i] - d[i]))


@njit(cache=True, fastmath=FAST)
def _behind(out: Array, w: Array, front: Array, back: Array) -> None:
    """Of each body its front face's twist less that of the face behind, weighed."""
    for i in range(out.size):
        out[i] = w[i] * (front[i] - back[i])


@njit(cache=True, fastmath=FAST)
def _weigh_through(xy: Array, w: Array, here: Array, before: Array) -> None:
    """Weigh faces' twists and add what the bodies behind them and before them have of them."""
    for i in range(xy.size):
        xy[i] = w[i] * xy[i] + (here[i] - before[i])


@njit(cache=True, fastmath=FAST)
def through(twists: Array, plane: int) -> None:
    """Add to the twists of faces xy what the bodies behind them and before them have of them."""
    o = 2 * plane
    _through(twists[XY, o:], twists[BODY, o:], twists[BODY, o - plane :])


@njit(cache=True, fastmath=FAST)
def _through(xy: Array, here: Array, before: Array) -> None:
    for i in range(xy.size):
        xy[i] += here[i] - before[i]


@njit(cache=True, fastmath=FAST)
def gather_twists(q: Array, twists: Array, row: int, plane: int) -> None:
    """Add to q (N,) what its nodes have of all twists."""
    o = 2 * plane
    xy, xz, yz = twists[XY], twists[XZ], twists[YZ]
    _gather(
        q,
        xy[o:],
        xy[o - 1 :],
        xy[o - row :],
        xy[o - row - 1 :],
        xz[o:],
        xz[o - 1 :],
        xz[o - plane :],
        xz[o - plane - 1 :],
        yz[o:],
        yz[o - row :],
        yz[o - plane :],
        yz[o - plane - row :],
    )


@njit(cache=True, fastmath=FAST)
def _gather(
    q: Array,
    xy0: Array,
    xy1: Array,
    xy2: Array,
    xy3: Array,
    xz0: Array,
    xz1: Array,
    xz2: Array,
    xz3: Array,
    yz0: Array,
    yz1: Array,
    yz2: Array,
    yz3: Array,
) -> None:
    """Add to q what its node has of the four twists around it in each plane."""
    for i in range(q.size):
        q[i] += (
            ((xy0[i] - xy1[i]) - (xy2[i] - xy3[i]))
            + ((xz0[i] - xz1[i]) - (xz2[i] - xz3[i]))
            + ((yz0[i] - yz1[i]) - (yz2[i] - yz3[i]))
        )
