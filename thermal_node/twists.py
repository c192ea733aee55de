"""What the nodes of finite elements exchange beside their edges: along faces and bodies.

A face's four nodes meet in their twist s . f, s = (+ - - +), a body's eight in the difference of two
twists; see mesh/exchange.py. Every twist is weighed first, and then gathered by the nodes around it:
loops over shifted views without borders or index arithmetic.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from .compiled import FAST
from .mesh.exchange import Exchange

Array = NDArray[np.float64]

XY, XZ, YZ, BODY, RAW, SLOPE = range(6)


def room(n: int, plane: int) -> Array:
    """Work (6, N + 2 plane) for twists, of n nodes: node i at 2 plane + i, zeros before."""
    return np.zeros((6, n + 2 * plane if n else 0))


@njit(cache=True, fastmath=FAST)
def exchange_twists(
    f: Array,
    slope: Array,
    weight: Exchange,
    total: Exchange,
    into: Array,
    twists: Array,
    row: int,
    plane: int,
) -> None:
    """Let materials exchange f (M, N) into `into` (N,); add the exchanges' derivatives to `total`.

    The derivatives take the least slope of a part's nodes: a face takes away from what its edges conduct, and
    Newton's iteration goes astray where that is too much.

    row, plane : nodes in a row along x, and in a plane of constant z
    """
    n, o = into.size, 2 * plane
    twists[:] = 0.0
    xy, xz, yz, body = twists[XY, o:], twists[XZ, o:], twists[YZ, o:], twists[BODY, o:]
    raw, least = twists[RAW, o:], twists[SLOPE, o:]
    for m in range(f.shape[0]):
        if weight.xz.size > 0:
            _face(raw, least, f[m], slope[m], 1, plane)
            _add_face(xz, total.xz, weight.xz[m].reshape(n), raw, least)
        if weight.yz.size > 0:
            _face(raw, least, f[m], slope[m], row, plane)
            _add_face(yz, total.yz, weight.yz[m].reshape(n), raw, least)
        if weight.xy.size > 0:
            _face(raw, least, f[m], slope[m], 1, row)
            _add_face(xy, total.xy, weight.xy[m].reshape(n), raw, least)
            _add_body(body, total.xyz, weight.xyz[m].reshape(n), raw, raw[plane:], least, least[plane:])
    _through(xy, body, twists[BODY, o - plane :])
    _gather_all(into, into, twists, row, plane)


@njit(cache=True, fastmath=FAST)
def _face(raw: Array, least: Array, f: Array, slope: Array, one: int, two: int) -> None:
    """Twist and least slope of the faces whose sides are `one` and `two` nodes apart."""
    both = one + two
    _twist(raw[: f.size - both], f, f[one:], f[two:], f[both:])
    _least(least[: f.size - both], slope, slope[one:], slope[two:], slope[both:])


@njit(cache=True, fastmath=FAST)
def _least(out: Array, a: Array, b: Array, c: Array, d: Array) -> None:
    for i in range(out.size):
        out[i] = min(min(a[i], b[i]), min(c[i], d[i]))


@njit(cache=True, fastmath=FAST)
def _add_face(out: Array, total: Array, w: Array, raw: Array, least: Array) -> None:
    """What leaves a face's first node, the last has its share of; the others gain it."""
    for i in range(out.size):
        out[i] -= w[i] * raw[i]
        total[i] += w[i] * least[i]


@njit(cache=True, fastmath=FAST)
def _add_body(
    out: Array, total: Array, w: Array, raw: Array, raw_behind: Array, least: Array, least_behind: Array
) -> None:
    for i in range(raw_behind.size):
        out[i] -= w[i] * (raw[i] - raw_behind[i])
        total[i] += w[i] * min(least[i], least_behind[i])


@njit(cache=True, fastmath=FAST)
def _through(xy: Array, here: Array, before: Array) -> None:
    """Add to faces' twists what the bodies behind them and before them have of them."""
    for i in range(xy.size):
        xy[i] += here[i] - before[i]


@njit(cache=True, fastmath=FAST)
def add_to_lines(own: Array, line: Array, faces: Array, bodies: Array, row: int, plane: int) -> None:
    """Add to the diagonal (N,) and the edges (N + plane,) of the lines through the thickness.

    faces (3, N) xy, xz, yz and bodies (N,) : weights
    """
    for x in (0, 1):
        for y in (0, row):
            _shift_add(faces[XY], own, x + y)
            _shift_add(bodies, own, x + y)
            _shift_add(bodies, own, x + y + plane)
            _shift_add(bodies, line, x + y + plane)
    for x in (0, 1):
        _shift_add(faces[XZ], own, x)
        _shift_add(faces[XZ], own, x + plane)
        _shift_add(faces[XZ], line, x + plane)
    for y in (0, row):
        _shift_add(faces[YZ], own, y)
        _shift_add(faces[YZ], own, y + plane)
        _shift_add(faces[YZ], line, y + plane)


@njit(cache=True, fastmath=FAST)
def _shift_add(weight: Array, to: Array, offset: int) -> None:
    for i in range(min(weight.size, to.size - offset)):
        to[i + offset] += weight[i]


@njit(cache=True, fastmath=FAST)
def add_product(
    p: Array, q: Array, faces: Array, bodies: Array, twists: Array, row: int, plane: int
) -> float:
    """q += (faces and bodies) p, and p.q; p goes on for two planes behind q's size."""
    n, o = q.size, 2 * plane
    xy, xz, yz, body = twists[XY], twists[XZ], twists[YZ], twists[BODY]
    _twist(xy[o:], p, p[1:], p[row:], p[row + 1 :])
    _behind(body[o : o + n - plane], bodies, xy[o:], xy[o + plane :])
    _weigh(xy[o:], faces[XY])
    _through(xy[o:], body[o:], body[o - plane :])
    _weighed_twist(xz[o:], faces[XZ], p, p[1:], p[plane:], p[plane + 1 :])
    _weighed_twist(yz[o:], faces[YZ], p, p[row:], p[plane:], p[plane + row :])
    return _gather_all(q, p, twists, row, plane)


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
def _weigh(xy: Array, w: Array) -> None:
    for i in range(xy.size):
        xy[i] *= w[i]


@njit(cache=True, fastmath=FAST)
def _gather_all(q: Array, p: Array, twists: Array, row: int, plane: int) -> float:
    """Add to q (N,) what its nodes have of all twists; p.q."""
    o = 2 * plane
    xy, xz, yz = twists[XY], twists[XZ], twists[YZ]
    return _gather(
        q,
        p,
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
    p: Array,
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
) -> float:
    """Add to q what its node has of the four twists around it in each plane; p.q."""
    total = 0.0
    for i in range(q.size):
        q[i] += (
            ((xy0[i] - xy1[i]) - (xy2[i] - xy3[i]))
            + ((xz0[i] - xz1[i]) - (xz2[i] - xz3[i]))
            + ((yz0[i] - yz1[i]) - (yz2[i] - yz3[i]))
        )
        total += p[i] * q[i]
    return total
