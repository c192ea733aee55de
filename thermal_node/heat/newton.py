"""Newton's step with the exact derivative, for finite elements whose specific heat varies.

A consistent capacity spreads what a node holds over its neighbours: the derivative of the heat,
(L + X) diag(c), is not symmetric where c differs between neighbours, and a symmetric stand-in can lose its
definiteness from a few per cent of difference on. The product with the exact derivative takes the
exchanges themselves (see flows.py), and stabilised biconjugate gradients solve with it (van der Vorst 1992,
SIAM J. Sci. Stat. Comput. 13, 631-644), preconditioned by the lumped matrix' lines through the thickness.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..compiled.arithmetic import FAST
from ..mesh.exchange import Exchange
from .conduction import Field, Grid
from .flows import exchange
from .linear import Krylov, factor_lines, solve_lines

Array = NDArray[np.float64]

BREAKDOWN = 1e-290


class NewtonWork(NamedTuple):
    """Work of the exact step, allocated once; of size 0 where it is never taken.

    start (N,) : the stage's first guess
    f, slope (M, N) : what is exchanged; its derivative, which is not asked for
    unused : where the exchanges write derivatives that are not asked for
    r, shadow, p, v, s, t, y (N,) : vectors of the iteration
    """

    start: Array
    f: Array
    slope: Array
    unused: Exchange
    r: Array
    shadow: Array
    p: Array
    v: Array
    s: Array
    t: Array
    y: Array


def newton_work(grid: Grid) -> NewtonWork:
    """Room for a mesh; empty for finite volumes."""
    finite_elements = grid.mass.xz.size > 0
    count, n = grid.volume.shape[0], grid.volume[0].size if finite_elements else 0
    return NewtonWork(
        np.zeros(n),
        np.zeros((count, n)),
        np.zeros((count, n)),
        Exchange(*(np.zeros(n if part.size else 0) for part in grid.conduction)),
        *(np.zeros(n) for _ in range(7)),
    )


@njit(cache=True, fastmath=FAST)
def exact_step(
    step: Array, g: float, grid: Grid, field: Field, k: Krylov, work: NewtonWork, tolerance: float, most: int
) -> int:
    """Solve (dH/dT - g dF/dT) step = k.r at an evaluated field; iterations taken."""
    nx = grid.volume.shape[3]
    plane = grid.volume.shape[2] * nx
    _lump(field)
    factor_lines(field, g, nx, plane, k)
    r, shadow, p, v, s, t, y = work.r, work.shadow, work.p, work.v, work.s, work.t, work.y
    step[:] = 0.0
    r[:] = k.r
    shadow[:] = r
    p[:] = 0.0
    v[:] = 0.0
    rho, alpha, omega = 1.0, 1.0, 1.0
    goal = tolerance * np.sqrt(np.dot(r, r))
    for iteration in range(most):
        if np.sqrt(np.dot(r, r)) <= goal:
            return iteration
        before = rho
        rho = np.dot(shadow, r)
        if abs(rho) < BREAKDOWN or abs(omega) < BREAKDOWN:
            return iteration
        beta = rho / before * alpha / omega
        for i in range(p.size):
            p[i] = r[i] + beta * (p[i] - omega * v[i])
        solve_lines(p, y, plane, k)
        _product(y, v, g, grid, field, work)
        alpha = rho / np.dot(shadow, v)
        for i in range(p.size):
            s[i] = r[i] - alpha * v[i]
            step[i] += alpha * y[i]
        solve_lines(s, y, plane, k)
        _product(y, t, g, grid, field, work)
        size = np.dot(t, t)
        if size < BREAKDOWN:
            return iteration
        omega = np.dot(t, s) / size
        for i in range(p.size):
            step[i] += omega * y[i]
            r[i] = s[i] - omega * t[i]
    return most


@njit(cache=True, fastmath=FAST)
def _lump(field: Field) -> None:
    holds = field.capacitance
    holds.x[:] = 0.0
    holds.y[:] = 0.0
    holds.z[:] = 0.0
    holds.xy[:] = 0.0
    holds.xz[:] = 0.0
    holds.yz[:] = 0.0
    holds.xyz[:] = 0.0


@njit(cache=True, fastmath=FAST)
def _product(x: Array, out: Array, g: float, grid: Grid, field: Field, work: NewtonWork) -> None:
    """out = (dH/dT - g dF/dT) x."""
    nx = grid.volume.shape[3]
    plane = grid.volume.shape[2] * nx
    for i in range(x.size):
        out[i] = (field.capacity[i] + g * field.diagonal[i]) * x[i]
    for m in range(work.f.shape[0]):
        for i in range(x.size):
            work.f[m, i] = field.density_heat[m, i] * x[i]
    exchange(work.f, work.slope, grid.mass, work.unused, out, field.flows, nx, plane)
    for m in range(work.f.shape[0]):
        for i in range(x.size):
            work.f[m, i] = -g * field.conductivity[m, i] * x[i]
    exchange(work.f, work.slope, grid.conduction, work.unused, out, field.flows, nx, plane)
