"""One implicit stage: find T with H(T) - g F(T) = B.

Newton's iteration with the symmetric conductance of `evaluate` in place of the exact
derivative. It must settle far below the heat that the stage exchanges, because that is what
the heat balance of a step is made of. Where a step of the iteration would cross the specific
heat peak of steel, the node is moved to where its heat, not its temperature, is what the step
asked for: the iteration cannot jump over the peak and back. Where the iteration does not settle and the
mesh is of finite elements, it begins anew with the exact derivative (newton.py).
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..compiled.arithmetic import FAST
from .conduction import Field, Grid, Surface, Tables, evaluate, heat_at
from .convection import Cavities
from .linear import Krylov, conjugate_gradients, factor_lines
from .newton import NewtonWork, exact_step
from .reactions import Progress, Reactions

Array = NDArray[np.float64]

CONVERGED, SLOW, NOT_FINITE = 0, 1, 2
HEAT_TOLERANCE = 2e-7
ROUNDING = 4e-16
"""Of a node's heat and of what its temperature stands for: twice what a number is rounded by."""
LINEAR_TOLERANCE = 0.02
PATIENCE = 8
"""Iterations after which a residual that does not fall sends finite elements to the exact derivative."""
EXACT_TOLERANCE = 1e-3


@njit(cache=True, fastmath=FAST)
def solve_stage(
    temperature: Array,
    base: Array,
    g: float,
    surroundings: Array,
    tables: Tables,
    grid: Grid,
    surface: Surface,
    field: Field,
    krylov: Krylov,
    newton: NewtonWork,
    step: Array,
    count: NDArray[np.int64],
    most: int,
    cavities: Cavities | None,
    reactions: Reactions | None,
    progress: Progress | None,
) -> int:
    """Solve in place for temperature (N,), °C; `field` is left evaluated there.

    base : B (N,), J; g : s; surroundings (3, 3) : see evaluate; newton, step (N,) : work
    count (2,) : evaluations and linear iterations, added to; cavities, reactions, progress : see evaluate
    """
    _count, _nz, ny, nx = grid.volume.shape
    plane = nx * ny
    n = temperature.size
    volume = grid.volume.reshape(grid.volume.shape[0], n)
    previous = np.inf
    can_be_exact, exact = newton.start.size > 0, False
    if can_be_exact:
        newton.start[:] = temperature
    for iteration in range(most):
        evaluate(temperature, surroundings, tables, grid, surface, field, g, cavities, reactions, progress)
        count[0] += 1
        residual, moved, rounding, conducted = 0.0, 0.0, 0.0, 0.0
        along = field.conductance.z
        for i in range(n):
            r = base[i] + g * field.flow[i] - field.heat[i]
            krylov.r[i] = r
            residual += abs(r)
            moved += abs(field.heat[i] - base[i])
            # What rounding of a temperature does to its heat, and to a surface that holds it.
            kelvin = abs(temperature[i]) + 273.0
            stored = abs(field.heat[i]) + field.capacity[i] * abs(temperature[i])
            rounding += ROUNDING * stored + 1e-15 * g * field.diagonal[i] * kelvin
            if i < along.size:
                conducted += 1e-15 * g * along[i] * kelvin
        if not residual < 1e300 and (exact or not can_be_exact):
            return NOT_FINITE
        through = g * (field.surface_flow[3] + field.surface_flow[4] + field.surface_flow[5])
        if reactions is not None and progress is not None:
            through += progress.exchanged[0] + progress.exchanged[1]
        scale = HEAT_TOLERANCE * max(through, 0.01 * moved) + rounding
        # Thin metal at rest gets no nearer than rounding of what its nodes conduct to each other.
        if residual <= scale or (residual > 0.5 * previous and residual <= 4.0 * scale + conducted):
            return CONVERGED
        if (
            can_be_exact
            and not exact
            and not (residual < 1e300 and (iteration < PATIENCE or residual <= 0.5 * previous))
        ):
            exact, previous = True, np.inf
            temperature[:] = newton.start
            continue
        previous = residual
        if exact:
            count[1] += exact_step(step, g, grid, field, krylov, newton, EXACT_TOLERANCE, 200)
        else:
            factor_lines(field, g, nx, plane, krylov)
            count[1] += conjugate_gradients(step, nx, plane, krylov, LINEAR_TOLERANCE, 500)
        for i in range(n):
            if abs(step[i]) > 0.5:
                temperature[i] = _not_past(tables, volume, i, temperature[i], step[i], reactions, progress)
            else:
                temperature[i] += step[i]
    return SLOW


@njit(cache=True, fastmath=FAST)
def _not_past(
    tables: Tables,
    volume: Array,
    i: int,
    t: float,
    step: float,
    reactions: Reactions | None,
    progress: Progress | None,
) -> float:
    """t + step, or short of it where the node already holds the heat that the step meant."""
    before, capacity = heat_at(tables, volume, i, t, reactions, progress)
    wanted = capacity * step
    low, high = t, t + step
    heat, _ = heat_at(tables, volume, i, high, reactions, progress)
    if abs(heat - before) <= 1.1 * abs(wanted):
        return high
    for _ in range(40):
        middle = 0.5 * (low + high)
        heat, _c = heat_at(tables, volume, i, middle, reactions, progress)
        if abs(heat - before) > abs(wanted):
            high = middle
        else:
            low = middle
        if abs(high - low) < 1e-3:
            break
    return 0.5 * (low + high)
