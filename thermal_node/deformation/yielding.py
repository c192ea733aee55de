"""Layers of the shell that yield: elastic and perfectly plastic, von Mises in plane stress.

Strength and stiffness fall with temperature. A shape is reached in increments of temperature; in each, stress
is returned to the yield surface by backward Euler (Simo and Hughes 1998, Computational Inelasticity, box 3.3,
without hardening): one equation in one unknown a point. Balance is found with the elastic stiffness and the
plastic strains as strains that are imposed, accelerated by Anderson's mixing (Walker and Ni 2011, SIAM J.
Numer. Anal. 49, 1715).
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_matrix

from ..model.materials import Curve
from ..model.strength import strength_at
from .deflection import YieldState
from .equilibrium import Equilibrium
from .holding import Holding
from .shell import ShellLeaf
from .unilateral import Unsettled
from .utilisation import von_mises

Array = NDArray[np.float64]

INCREMENT = 100.0
"""K by which no point warms or cools within one increment."""
SMALLEST = 0.1
"""Share of an increment below which one that finds no balance is not halved again."""
MOST_PASSES = 200
SETTLED = 1e-5
"""Change of the unknowns in a pass, of their size, at which a shape has settled."""
MIXED, WORSE = 6, 10.0
"""Passes that Anderson's mixing remembers; how far from the best pass it forgets them."""


def plane_stress(shell: ShellLeaf, temperature: Array, strain: Array) -> Array:
    """Stress xx, yy, xy (elements, 4, z, 3), Pa, of strains less what is plastic, free elongation within."""
    modulus, ratio, free = shell.elastic(temperature)
    return _hooke(modulus, ratio, strain - free[..., None] * np.array([1.0, 1.0, 0.0]))


def _hooke(modulus: Array, ratio: Array, elastic: Array) -> Array:
    stress = np.empty_like(elastic)
    plane = modulus / (1.0 - ratio**2)
    stress[..., 0] = plane * (elastic[..., 0] + ratio * elastic[..., 1])
    stress[..., 1] = plane * (elastic[..., 1] + ratio * elastic[..., 0])
    stress[..., 2] = plane * (0.5 * (1.0 - ratio)) * elastic[..., 2]
    return stress


def plastic_flow(trial: Array, modulus: Array, ratio: Array, strength: Array) -> Array:
    """Plastic strains (p, 3) that bring trial stresses (p, 3), Pa, back to the yield surface.

    With s = xx + yy, d = xx - yy and the shear t, the yield stress squared is s^2/4 + 3 d^2/4 + 3 t^2, and
    each of the three returns along itself: s / (1 + m E / (2 (1 - nu))), d and t / (1 + 3 m G). One over the
    yield stress is concave in the multiplier m, so Newton's iteration rises to the root from 0.
    """
    total, difference, shear = trial[:, 0] + trial[:, 1], trial[:, 0] - trial[:, 1], trial[:, 2]
    a = modulus / (2.0 * (1.0 - ratio))
    b = 1.5 * modulus / (1.0 + ratio)
    p, q = 0.25 * total**2, 0.75 * difference**2 + 3.0 * shear**2
    m = np.zeros_like(p)
    for _ in range(50):
        first, second = 1.0 + a * m, 1.0 + b * m
        square = p / first**2 + q / second**2
        slope = (a * p / first**3 + b * q / second**3) * square**-1.5
        step = (1.0 / strength - square**-0.5) / slope
        m += np.maximum(step, 0.0)
        if np.all(step <= 1e-13 * m):
            break
    total, difference, shear = total / (1.0 + a * m), difference / (1.0 + b * m), shear / (1.0 + b * m)
    flow = np.empty_like(trial)
    flow[:, 0] = m * (0.25 * total + 0.75 * difference)
    flow[:, 1] = m * (0.25 * total - 0.75 * difference)
    flow[:, 2] = 3.0 * m * shear
    return flow


def yielded(
    shell: ShellLeaf,
    holding: Holding,
    strengths: tuple[Curve | None, ...],
    cold: float,
    temperature: Array,
    before: YieldState | None,
) -> tuple[csc_matrix, Array, Equilibrium, Array, Array, YieldState]:
    """Stiffness, load, what holds, unknowns (n,), forces of the holds, N, and the state that is reached.

    cold : °C of the leaf without stress; temperature (elements, 4, z) : °C

    Raises
    ------
    Unsettled
    """
    if before is None:
        before = YieldState(np.full_like(temperature, cold), np.zeros((*temperature.shape, 3)))
    change = temperature - before.temperature
    count = max(1, int(np.ceil(float(np.abs(change).max()) / INCREMENT - 1e-9)))
    plastic = before.plastic_strain
    kind = np.broadcast_to(shell.kind_at()[:, None, :], temperature.shape)
    done, part = 0.0, 1.0 / count
    while done < 1.0 - 1e-9:
        at = before.temperature + min(done + part, 1.0) * change
        matrix, load = shell.equations(at)
        solved = holding.equilibrium(matrix)
        try:
            found = _settle(shell, solved, load, at, strength_at(strengths, kind, at), plastic)
        except Unsettled:
            part *= 0.5
            if part * count < SMALLEST:
                raise
            continue
        u, forces, plastic, load = found
        done += part
    return matrix, load, solved, u, forces, YieldState(temperature, plastic)


def _settle(
    shell: ShellLeaf, solved: Equilibrium, load: Array, temperature: Array, strength: Array, before: Array
) -> tuple[Array, Array, Array, Array]:
    """Unknowns, forces, plastic strains and the load that imposes them, at one temperature."""
    modulus, ratio, free = shell.elastic(temperature)
    eigen = before + free[..., None] * np.array([1.0, 1.0, 0.0])
    nu = np.broadcast_to(ratio, temperature.shape)

    def plastic_of(u: Array) -> Array:
        trial = _hooke(modulus, ratio, shell.strain(u) - eigen)
        over = von_mises(trial) > strength
        plastic = before.copy()
        plastic[over] += plastic_flow(trial[over], modulus[over], nu[over], strength[over])
        return plastic

    def pass_(plastic: Array) -> tuple[Array, Array, Array]:
        whole = load + shell.load(_hooke(modulus, ratio, plastic))
        return *solved.solve(whole), whole

    u, _, _ = pass_(before)
    steps: list[Array] = []
    places: list[Array] = []
    least = np.inf
    for _ in range(MOST_PASSES):
        plastic = plastic_of(u)
        new, forces, whole = pass_(plastic)
        step = new - u
        size = float(np.abs(new).max())
        if not np.isfinite(size):
            break
        moved_by = float(np.abs(step).max())
        if moved_by <= SETTLED * max(size, 1e-9):
            return new, forces, plastic, whole
        if moved_by > WORSE * least:
            steps, places = [], []  # what was remembered does not help here
        least = min(least, moved_by)
        steps, places = [*steps[-MIXED:], step], [*places[-MIXED:], u]
        u = new
        if len(steps) > 1:
            change = np.array([b - a for a, b in pairwise(steps)]).T
            moved = np.array([b - a for a, b in pairwise(places)]).T
            share = np.linalg.lstsq(change, step, rcond=1e-10)[0]
            u = new - (moved + change) @ share
    raise Unsettled(
        f"its layers, yielding, found no balance in {MOST_PASSES} passes; they may not bear what loads them,"
        " or a support presses on too small a place"
    )
