"""Reactions: what a material gives or takes once, as water that evaporates or a binder that burns.

A reaction of a material has a degree x from 0 to 1 at each node, and the node holds

    H = sum_m V_m h_m(T) + sum_p V_m(p) [q_p x_p + c_p (1 - x_p) (T - T_p)]

q : J/m3 that all of it takes, negative where it gives; c : J/(m3 K), heat capacity of what is to leave
T_p : where q holds; elsewhere it is q - c (T - T_p), Kirchhoff's law without what has left

x never falls, and comes from one of

    EQUILIBRIUM  x = the largest x_p(T) so far, a table
    TABLE        x' = r(T) (1 - x)^n, r a table
    ARRHENIUS    x' = A exp(-E / (R T)) (1 - x)^n above a least temperature

Rates are integrated with the temperature: in a stage x = b + g x'(T, x), with b from the stages before, is
solved node by node, so that H stays a function of T alone.

A reaction that needs oxygen goes on as fast as there is any: its rate counts with the share y of air's oxygen
at the node. Oxygen diffuses along z from the unexposed face, quasi-steady:

    d/dz (rho D dY/dz) = consumption, linear in Y;  rho D Y = 353/T D_20 (T/293)^1.75 0.232 y

(ideal gas; the exponent of Fuller, Schettler and Giddings 1966). It is found anew in each evaluation, from
its temperatures and the degrees of the one before.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..compiled.arithmetic import FAST

Array = NDArray[np.float64]

EQUILIBRIUM, TABLE, ARRHENIUS = 0, 1, 2
LEAST_CAPACITY = 0.2
"""Share of a node's capacity that Newton's matrix keeps where burning makes heat fall with temperature."""
AIR_OXYGEN = 0.232
"""Mass of oxygen in a mass of air."""


class Reactions(NamedTuple):
    """P reactions; see the module.

    material, kind (P,); taken : q, J/m3; leaving : c, J/(m3 K); held_at : T_p, °C
    factor : A, 1/s; activation : E / R, K; order : n; least : °C
    start (P + 1,), knot, value : tables of x_p or r, °C and - or 1/s
    oxygen (P,) : kg/m3 that all of it consumes, 0 where that is not looked at
    diffusion (N,) : m; what oxygen's edges along z have of D_20, cross-section over length; (0,) if none
    open (plane,) : whether air reaches the unexposed face's nodes, 1 or 0
    """

    material: NDArray[np.int64]
    kind: NDArray[np.int64]
    taken: Array
    leaving: Array
    held_at: Array
    factor: Array
    activation: Array
    order: Array
    least: Array
    start: NDArray[np.int64]
    knot: Array
    value: Array
    oxygen: Array
    diffusion: Array
    open: Array


class Progress(NamedTuple):
    """How far reactions are; allocated once.

    degree (P, N) : at the last step's end; base (P, N) : b of the stage
    now (P, N) : at the evaluated field, foreseen before there is one
    rate (P, N) : 1/s, there; supply (N,) : share of air's oxygen
    exchanged (2,) : J given and J taken since the last step's end, whole mesh
    sink, weight (N,) : work
    """

    degree: Array
    base: Array
    now: Array
    rate: Array
    supply: Array
    exchanged: Array
    sink: Array
    weight: Array


def progress_of(reactions: Reactions, n: int) -> Progress:
    """Room for n nodes, nothing reacted."""
    shape = len(reactions.kind), n
    return Progress(
        degree=np.zeros(shape),
        base=np.zeros(shape),
        now=np.zeros(shape),
        rate=np.zeros(shape),
        supply=np.ones(n),
        exchanged=np.zeros(2),
        sink=np.zeros(n),
        weight=np.zeros(n),
    )


@njit(cache=True, fastmath=FAST)
def _table(reactions: Reactions, p: int, t: float) -> tuple[float, float]:
    """The table of reaction p at t, end values held, and its slope."""
    first, last = reactions.start[p], reactions.start[p + 1] - 1
    knot, value = reactions.knot, reactions.value
    if t <= knot[first]:
        return value[first], 0.0
    if t >= knot[last]:
        return value[last], 0.0
    j = first
    while knot[j + 1] < t:
        j += 1
    slope = (value[j + 1] - value[j]) / (knot[j + 1] - knot[j])
    return value[j] + slope * (t - knot[j]), slope


@njit(cache=True, fastmath=FAST)
def rate_constant(reactions: Reactions, p: int, t: float) -> tuple[float, float]:
    """r (1/s) of reaction p at t (°C), and its slope."""
    if reactions.kind[p] == TABLE:
        return _table(reactions, p, t)
    if t < reactions.least[p]:
        return 0.0, 0.0
    kelvin = t + 273.15
    r = reactions.factor[p] * np.exp(-reactions.activation[p] / kelvin)
    return r, r * reactions.activation[p] / (kelvin * kelvin)


@njit(cache=True, fastmath=FAST)
def _left(b: float, gr: float, n: float) -> float:
    """y from y + gr y^n = b: what is left of a reaction of order n at a stage's end."""
    if b <= 0.0:
        return 0.0
    if gr <= 0.0:
        return b
    if n == 1.0:
        return b / (1.0 + gr)
    # Newton from above on a function that is convex in y where n > 1 and in y^n elsewhere.
    if n > 1.0:
        y = b
        for _ in range(60):
            power = y ** (n - 1.0)
            change = (y + gr * power * y - b) / (1.0 + gr * n * power)
            y -= change
            if change <= 1e-14 * y:
                break
        return y
    u, m = b**n, 1.0 / n
    for _ in range(60):
        power = u ** (m - 1.0)
        change = (power * u + gr * u - b) / (m * power + gr)
        u -= change
        if change <= 1e-14 * u:
            break
    return u**m


@njit(cache=True, fastmath=FAST)
def degree_at(
    reactions: Reactions, progress: Progress, p: int, i: int, t: float, g: float
) -> tuple[float, float, float]:
    """Degree of reaction p at node i in a stage of length g (s) at t (°C), dx/dT, and its rate (1/s)."""
    before = progress.degree[p, i]
    if reactions.kind[p] == EQUILIBRIUM:
        x, slope = _table(reactions, p, t)
        if x <= before:
            return before, 0.0, 0.0
        return x, slope, 0.0
    n = reactions.order[p]
    r, slope = rate_constant(reactions, p, t)
    if reactions.oxygen[p] > 0.0:
        r *= progress.supply[i]
        slope *= progress.supply[i]
    y = _left(1.0 - progress.base[p, i], g * r, n)
    if y <= 0.0:
        return 1.0, 0.0, 0.0
    if g == 0.0:
        return progress.base[p, i], 0.0, r * y**n
    power = y**n
    return 1.0 - y, g * slope * power / (1.0 + g * r * n * power / y), r * power


@njit(cache=True, fastmath=FAST)
def _supply_oxygen(temperature: Array, volume: Array, reactions: Reactions, progress: Progress) -> None:
    """Find the share of air's oxygen at each node, at temperatures (N,) and the latest degrees."""
    n, plane = temperature.size, reactions.open.size
    sink, weight, y = progress.sink, progress.weight, progress.supply
    sink[:] = 0.0
    for p in range(reactions.kind.size):
        if reactions.oxygen[p] > 0.0:
            m = reactions.material[p]
            for i in range(n):
                left = 1.0 - progress.now[p, i]
                if volume[m, i] > 0.0 and left > 0.0:
                    r, _ = rate_constant(reactions, p, temperature[i])
                    sink[i] += volume[m, i] * reactions.oxygen[p] * r * left ** reactions.order[p]
    # Elimination from the exposed face on: y[i] = weight[i] y[i + plane].
    for i in range(n - plane):
        kelvin = 0.5 * (temperature[i] + temperature[i + plane]) + 273.15
        g = AIR_OXYGEN * 353.0 / kelvin * (kelvin / 293.15) ** 1.75 * reactions.diffusion[i]
        pivot = sink[i] + g
        if i >= plane:
            pivot += sink[i - plane]
        weight[i] = g / pivot if pivot > 0.0 else 0.0
        # What this node and those before it draw from the node behind.
        sink[i] = weight[i] * (pivot - g)
    for j in range(plane):
        y[n - plane + j] = reactions.open[j]
    for i in range(n - plane - 1, -1, -1):
        y[i] = weight[i] * y[i + plane]


@njit(cache=True, fastmath=FAST)
def react(
    temperature: Array,
    g: float,
    volume: Array,
    reactions: Reactions,
    progress: Progress,
    heat: Array,
    capacity: Array,
) -> None:
    """Add the reactions to heat (N,), J, and capacity (N,), J/K, of nodes with volumes (M, N)."""
    if reactions.diffusion.size > 0:
        _supply_oxygen(temperature, volume, reactions, progress)
    given, taken = 0.0, 0.0
    plain = progress.weight
    plain[:] = capacity
    for p in range(reactions.kind.size):
        m = reactions.material[p]
        q, c = reactions.taken[p], reactions.leaving[p]
        for i in range(temperature.size):
            v = volume[m, i]
            if v > 0.0:
                x, slope, progress.rate[p, i] = degree_at(reactions, progress, p, i, temperature[i], g)
                progress.now[p, i] = x
                above = temperature[i] - reactions.held_at[p]
                heat[i] += v * (q * x + c * (1.0 - x) * above)
                capacity[i] += v * (c * (1.0 - x) + (q - c * above) * slope)
                plain[i] += v * c * (1.0 - x)
                change = v * q * (x - progress.degree[p, i])
                given -= min(change, 0.0)
                taken += max(change, 0.0)
    for i in range(temperature.size):
        capacity[i] = max(capacity[i], LEAST_CAPACITY * plain[i])
    progress.exchanged[0] = given
    progress.exchanged[1] = taken


@njit(cache=True, fastmath=FAST)
def reacted_heat(
    volume: Array, reactions: Reactions, progress: Progress, i: int, t: float
) -> tuple[float, float]:
    """What the reactions in equilibrium add to the heat (J) and capacity (J/K) of node i at t (°C).

    Rates do not jump, so they need no heed where a step of Newton's iteration is cut short.
    """
    heat, capacity = 0.0, 0.0
    for p in range(reactions.kind.size):
        v = volume[reactions.material[p], i]
        if v > 0.0:
            q, c = reactions.taken[p], reactions.leaving[p]
            above = t - reactions.held_at[p]
            x, slope = progress.now[p, i], 0.0
            if reactions.kind[p] == EQUILIBRIUM:
                x, slope, _ = degree_at(reactions, progress, p, i, t, 0.0)
            heat += v * (q * x + c * (1.0 - x) * above)
            capacity += v * (c * (1.0 - x) + (q - c * above) * slope)
    return heat, capacity
