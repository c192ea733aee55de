"""Conjugate gradients with lines through the thickness solved exactly.

A leaf is thin and its sheets thinner: a node is tied far more strongly to the nodes behind it
than to those beside it. Solving every line through the thickness (a tridiagonal system each)
removes that stiffness, and what is left, conduction in the plane, takes a few iterations.

Vectors that are multiplied carry a plane of zeros in front and behind, so that the seven-point
product is one loop without borders. Loops are kept few and plane by plane: the time goes into
moving memory. What finite elements have beside their edges is in twists.py.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..compiled.arithmetic import FAST
from .conduction import Field
from .twists import add_product, add_to_lines, twists_of

Array = NDArray[np.float64]


class Krylov(NamedTuple):
    """The matrix diag(C) + g (conduction + boundary) and work vectors, allocated once.

    diagonal (N,) : the matrix's without faces and bodies
    ex, ey, ez (N + plane,) : edges, the edge of node i at plane + i
    faces (3, N + 2 plane), bodies (N + 2 plane,) : their weights, node i at 2 plane + i, of size 0 where
        there are none; twists : their work
    own (N,), line (N + plane,) : diagonal and edges of the lines through the thickness
    pivot (N,), lower (N + plane,) : the lines' factors: inverse pivots, and of the edge to the
        plane before
    p (N + 3 plane,) : direction, node i at plane + i; r, z, q (N,)
    """

    diagonal: Array
    ex: Array
    ey: Array
    ez: Array
    faces: Array
    bodies: Array
    twists: Array
    own: Array
    line: Array
    pivot: Array
    lower: Array
    p: Array
    r: Array
    z: Array
    q: Array


def krylov(n: int, plane: int, finite_elements: bool) -> Krylov:
    """Work space for n nodes, `plane` of them in a plane of constant z."""
    diagonal, ez = np.zeros(n), np.zeros(n + plane)
    return Krylov(
        diagonal=diagonal,
        ex=np.zeros(n + plane),
        ey=np.zeros(n + plane),
        ez=ez,
        faces=np.zeros((3, n + 2 * plane if finite_elements else 0)),
        bodies=np.zeros(n + 2 * plane if finite_elements else 0),
        twists=twists_of(n, plane, finite_elements),
        own=np.zeros(n) if finite_elements else diagonal,
        line=np.zeros(n + plane) if finite_elements else ez,
        pivot=np.zeros(n),
        lower=np.zeros(n + plane),
        p=np.zeros(n + 3 * plane),
        r=np.zeros(n),
        z=np.zeros(n),
        q=np.zeros(n),
    )


@njit(cache=True, fastmath=FAST)
def factor_lines(field: Field, g: float, nx: int, plane: int, k: Krylov) -> None:
    """Form the matrix diag(C) + g (conduction + boundary) and factor its lines along z.

    nx, plane : nodes in a row along x, and in a plane of constant z
    """
    n, o = field.capacity.size, plane
    conducts, holds = field.conductance, field.capacitance
    _weigh(conducts.x, g, holds.x, k.ex[o:])
    _weigh(conducts.y, g, holds.y, k.ey[o:])
    _weigh(conducts.z, g, holds.z, k.ez[o:])
    _diagonal(
        k.diagonal,
        field.capacity,
        field.diagonal,
        g,
        k.ex[o:],
        k.ex[o - 1 :],
        k.ey[o:],
        k.ey[o - nx :],
        k.ez[o:],
        k.ez,
    )
    if k.bodies.size > 0:
        _weigh(conducts.xy, g, holds.xy, k.faces[0, 2 * o :])
        _weigh(conducts.xz, g, holds.xz, k.faces[1, 2 * o :])
        _weigh(conducts.yz, g, holds.yz, k.faces[2, 2 * o :])
        _weigh(conducts.xyz, g, holds.xyz, k.bodies[2 * o :])
        add_to_lines(k.diagonal, k.ez, k.faces, k.bodies, nx, plane, k.own, k.line)
    _pivot(k.pivot[:o], k.own[:o], k.line[:o], k.lower[:o], k.pivot[:o])
    for s in range(o, n, o):
        e = s + o
        _pivot(k.pivot[s:e], k.own[s:e], k.line[s:e], k.lower[s:e], k.pivot[s - o : s])


@njit(cache=True, fastmath=FAST)
def _weigh(conductance: Array, g: float, capacitance: Array, weight: Array) -> None:
    """Weights of the matrix: heat that is exchanged lies where it doesn't conduct, hence the sign."""
    if capacitance.size == 0:
        for i in range(conductance.size):
            weight[i] = g * conductance[i]
    else:
        for i in range(conductance.size):
            weight[i] = g * conductance[i] - capacitance[i]


@njit(cache=True, fastmath=FAST)
def _diagonal(
    d: Array,
    c: Array,
    b: Array,
    g: float,
    e0: Array,
    e1: Array,
    n0: Array,
    n1: Array,
    u0: Array,
    u1: Array,
) -> None:
    for i in range(d.size):
        d[i] = c[i] + g * b[i] + (e0[i] + e1[i]) + (n0[i] + n1[i]) + (u0[i] + u1[i])


@njit(cache=True, fastmath=FAST)
def _pivot(pivot: Array, d: Array, edge: Array, lower: Array, before: Array) -> None:
    """One plane's factors; the first plane has no edge before it."""
    for i in range(d.size):
        lower[i] = edge[i] * before[i]
        pivot[i] = 1.0 / (d[i] - edge[i] * lower[i])


@njit(cache=True, fastmath=FAST)
def _forward(
    alpha: float, p: Array, q: Array, x: Array, r: Array, lower: Array, before: Array, z: Array
) -> None:
    """x += alpha p, r -= alpha q and the plane's forward substitution in one pass."""
    for i in range(z.size):
        x[i] += alpha * p[i]
        r[i] -= alpha * q[i]
        z[i] = r[i] + lower[i] * before[i]


@njit(cache=True, fastmath=FAST)
def _backward(pivot: Array, lower: Array, after: Array, z: Array, r: Array) -> float:
    """The plane's back substitution; its share of r.z."""
    total = 0.0
    for i in range(z.size):
        z[i] = z[i] * pivot[i] + lower[i] * after[i]
        total += r[i] * z[i]
    return total


@njit(cache=True, fastmath=FAST)
def _precondition(alpha: float, x: Array, plane: int, k: Krylov) -> float:
    """Take a step of length alpha, solve the lines for z, and give r.z."""
    n = x.size
    _forward(
        alpha,
        k.p[plane : 2 * plane],
        k.q[:plane],
        x[:plane],
        k.r[:plane],
        k.lower[:plane],
        k.z[:plane],
        k.z[:plane],
    )
    for s in range(plane, n, plane):
        e = s + plane
        _forward(
            alpha,
            k.p[e : e + plane],
            k.q[s:e],
            x[s:e],
            k.r[s:e],
            k.lower[s:e],
            k.z[s - plane : s],
            k.z[s:e],
        )
    s = n - plane
    rz = _backward(k.pivot[s:n], k.lower[n : n + plane], k.z[s:n], k.z[s:n], k.r[s:n])
    for s in range(n - 2 * plane, -1, -plane):
        e = s + plane
        rz += _backward(k.pivot[s:e], k.lower[e : e + plane], k.z[e : e + plane], k.z[s:e], k.r[s:e])
    return rz


@njit(cache=True, fastmath=FAST)
def _stencil(
    q: Array,
    d: Array,
    e0: Array,
    e1: Array,
    n0: Array,
    n1: Array,
    u0: Array,
    u1: Array,
    p: Array,
    pe0: Array,
    pe1: Array,
    pn0: Array,
    pn1: Array,
    pu0: Array,
    pu1: Array,
) -> float:
    """q = (matrix) p from shifted views, so that the loop has no index arithmetic; p.q."""
    total = 0.0
    for i in range(q.size):
        v = (
            d[i] * p[i]
            - (e0[i] * pe0[i] + e1[i] * pe1[i])
            - (n0[i] * pn0[i] + n1[i] * pn1[i])
            - (u0[i] * pu0[i] + u1[i] * pu1[i])
        )
        q[i] = v
        total += v * p[i]
    return total


@njit(cache=True, fastmath=FAST)
def _multiply(nx: int, plane: int, k: Krylov) -> float:
    """q = (matrix) p, and p.q."""
    total = _multiply_edges(nx, plane, k)
    if k.bodies.size > 0:
        add_product(k.p[plane:], k.q, k.faces, k.bodies, k.twists, nx, plane)
        total = _dot(k.p[plane:], k.q)
    return total


@njit(cache=True, fastmath=FAST)
def _dot(p: Array, q: Array) -> float:
    total = 0.0
    for i in range(q.size):
        total += p[i] * q[i]
    return total


@njit(cache=True, fastmath=FAST)
def _multiply_edges(nx: int, plane: int, k: Krylov) -> float:
    """q = (matrix without faces and bodies) p, and p.q."""
    n, o = k.q.size, plane
    p, ex, ey, ez = k.p, k.ex, k.ey, k.ez
    return _stencil(
        k.q,
        k.diagonal,
        ex[o - 1 : o - 1 + n],
        ex[o : o + n],
        ey[o - nx : o - nx + n],
        ey[o : o + n],
        ez[:n],
        ez[o : o + n],
        p[o : o + n],
        p[o - 1 : o - 1 + n],
        p[o + 1 : o + 1 + n],
        p[o - nx : o - nx + n],
        p[o + nx : o + nx + n],
        p[:n],
        p[2 * o : 2 * o + n],
    )


@njit(cache=True, fastmath=FAST)
def conjugate_gradients(x: Array, nx: int, plane: int, k: Krylov, tolerance: float, most: int) -> int:
    """Solve for x (written from zero) with k.r holding the right side; iterations taken.

    `tolerance` bounds the preconditioned residual relative to that at the start. A result of
    `most` says that it was not reached.
    """
    n = x.size
    x[:] = 0.0
    k.q[:] = 0.0
    rz = _precondition(0.0, x, plane, k)
    k.p[plane : plane + n] = k.z
    goal = tolerance * tolerance * rz
    for iteration in range(most):
        if rz <= goal:
            return iteration
        new = _precondition(rz / _multiply(nx, plane, k), x, plane, k)
        beta = new / rz
        rz = new
        for i in range(n):
            k.p[plane + i] = k.z[i] + beta * k.p[plane + i]
    return most


@njit(cache=True, fastmath=FAST)
def solve_lines(r: Array, z: Array, plane: int, k: Krylov) -> None:
    """z = (the lines through the thickness, as factored)^-1 r."""
    n = r.size
    for i in range(plane):
        z[i] = r[i]
    for i in range(plane, n):
        z[i] = r[i] + k.lower[i] * z[i - plane]
    for i in range(n - plane, n):
        z[i] *= k.pivot[i]
    for i in range(n - plane - 1, -1, -1):
        z[i] = z[i] * k.pivot[i] + k.lower[i + plane] * z[i + plane]
