"""Compiled kernels of heat conduction on a leaf mesh.

Nodes hold temperature T (°C). With h_m the enthalpy per volume and theta_m the conductivity
integral (Kirchhoff's transform) of material m, node i holds the heat H_i = sum_m V_mi h_m(T_i), and
edge i-j carries sum_m G_mij (theta_m(T_j) - theta_m(T_i)): exact for steady one-dimensional
conduction with k(T). Finite elements exchange along faces and bodies as well, and heat as they do
theta; see mesh/exchange.py.

Arrays are (nz, ny, nx) or flat in that order, material arrays have M in front.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from ..compiled.arithmetic import FAST
from ..mesh.exchange import Exchange
from .convection import Cavities, add_convection
from .flows import Flows, exchange, flows_of
from .reactions import Progress, Reactions, react, reacted_heat

Array = NDArray[np.float64]

STEFAN_BOLTZMANN = 5.670374419e-8
"""W/(m2 K4), CODATA 2018."""
ABSOLUTE_ZERO = -273.15


class Tables(NamedTuple):
    """Every material's enthalpy (J/m3) and conductivity integral (W/m) at its knots (°C).

    Material m owns the knots start[m] to start[m + 1]; bin[m] finds the knot below a
    temperature without a search.
    """

    start: NDArray[np.int64]
    knot: Array
    enthalpy: Array
    capacity: Array
    theta: Array
    conductivity: Array
    bin: NDArray[np.int64]
    bins_per_kelvin: Array


class Grid(NamedTuple):
    """What a mesh gives to the kernels; shapes as in LeafMesh.

    conduction : of each material, m, by which theta is exchanged
    mass : m3 of each material, by which enthalpy is exchanged: a compact or a consistent sum of heat
    """

    volume: Array
    conduction: Exchange
    mass: Exchange


class Surface(NamedTuple):
    """Three surfaces (exposed, unexposed, lateral): areas and how they meet their gas.

    area (3, nz, ny, nx), m2; film (3,), W/(m2 K); emissivity (3,), -
    """

    area: Array
    film: Array
    emissivity: Array


class Field(NamedTuple):
    """Everything the kernels write, allocated once.

    heat, capacity, flow : H (J), dH/dT (J/K) and net heat inflow (W) of each node
    theta, conductivity, enthalpy, density_heat (M, N) : the integrals and their slopes, each
        material
    conductance (N,), W/K, and capacitance (N,), J/K : the exchanges' derivatives, materials summed
    diagonal : boundary conductance, W/K; surface_flow : see _surfaces; flows : work
    """

    heat: Array
    capacity: Array
    flow: Array
    theta: Array
    conductivity: Array
    enthalpy: Array
    density_heat: Array
    conductance: Exchange
    capacitance: Exchange
    diagonal: Array
    surface_flow: Array
    flows: Flows


def field_of(grid: Grid) -> Field:
    """Room for a mesh's field."""
    count, n = grid.volume.shape[0], grid.volume[0].size
    return Field(
        heat=np.zeros(n),
        capacity=np.zeros(n),
        flow=np.zeros(n),
        theta=np.zeros((count, n)),
        conductivity=np.zeros((count, n)),
        enthalpy=np.zeros((count, n)),
        density_heat=np.zeros((count, n)),
        conductance=Exchange(*(np.zeros(n if part.size else 0) for part in grid.conduction)),
        capacitance=Exchange(*(np.zeros(n if part.size else 0) for part in grid.mass)),
        diagonal=np.zeros(n),
        surface_flow=np.zeros(6),
        flows=flows_of(n, grid.volume[0, 0].size, grid.mass.xz.size > 0),
    )


@njit(cache=True, fastmath=FAST, inline="always")
def lookup(tables: Tables, m: int, t: float) -> tuple[float, float, float, float]:
    """h (J/m3), dh/dT, theta (W/m), k of material m at t; end values held outside."""
    first, last = tables.start[m], tables.start[m + 1] - 1
    if t <= tables.knot[first]:
        c, k, d = tables.capacity[first], tables.conductivity[first], t - tables.knot[first]
        return tables.enthalpy[first] + c * d, c, tables.theta[first] + k * d, k
    if t >= tables.knot[last]:
        c, k, d = tables.capacity[last], tables.conductivity[last], t - tables.knot[last]
        return tables.enthalpy[last] + c * d, c, tables.theta[last] + k * d, k
    j = tables.bin[m, int((t - tables.knot[first]) * tables.bins_per_kelvin[m])]
    while tables.knot[j + 1] < t:
        j += 1
    w = tables.knot[j + 1] - tables.knot[j]
    s = (t - tables.knot[j]) / w
    r = 1.0 - s
    c0, c1 = tables.capacity[j], tables.capacity[j + 1]
    k0, k1 = tables.conductivity[j], tables.conductivity[j + 1]
    dh = tables.enthalpy[j + 1] - tables.enthalpy[j]
    dk = tables.theta[j + 1] - tables.theta[j]
    a, b, e = s * s * (3.0 - 2.0 * s), s * r * r, s * s * r
    slope_a, slope_b, slope_e = 6.0 * s * r, r * (1.0 - 3.0 * s), s * (2.0 - 3.0 * s)
    return (
        tables.enthalpy[j] + a * dh + w * (b * c0 - e * c1),
        slope_a * dh / w + slope_b * c0 - slope_e * c1,
        tables.theta[j] + a * dk + w * (b * k0 - e * k1),
        slope_a * dk / w + slope_b * k0 - slope_e * k1,
    )


@njit(cache=True, fastmath=FAST)
def heat_at(
    tables: Tables, volume: Array, i: int, t: float, reactions: Reactions | None, progress: Progress | None
) -> tuple[float, float]:
    """H (J) and dH/dT (J/K) of node i at temperature t."""
    heat, capacity = 0.0, 0.0
    for m in range(volume.shape[0]):
        v = volume[m, i]
        if v > 0.0:
            h, c, _, _ = lookup(tables, m, t)
            heat += v * h
            capacity += v * c
    if reactions is not None:
        reacted = reacted_heat(volume, reactions, progress, i, t)
        heat += reacted[0]
        capacity += reacted[1]
    return heat, capacity


@njit(cache=True, fastmath=FAST)
def evaluate(
    temperature: Array,
    surroundings: Array,
    tables: Tables,
    grid: Grid,
    surface: Surface,
    field: Field,
    g: float,
    cavities: Cavities | None,
    reactions: Reactions | None,
    progress: Progress | None,
) -> None:
    """Fill `field` at a temperature field and its surroundings; `progress` as far as that goes.

    g : s, length of the stage that reactions go on in
    cavities, reactions : None where there are none, and then no code is made for them
    surroundings (3, 3) : gas temperature (°C), radiation temperature (°C) and flux (W/m2) of each surface
    """
    count, nz, ny, nx = grid.volume.shape
    n, plane = nz * ny * nx, nx * ny
    volume = grid.volume.reshape(count, n)
    heat, capacity = field.heat, field.capacity
    heat[:] = 0.0
    capacity[:] = 0.0
    field.flow[:] = 0.0
    for m in range(count):
        theta, k = field.theta[m], field.conductivity[m]
        each_h, each_c = field.enthalpy[m], field.density_heat[m]
        for i in range(n):
            v = volume[m, i]
            if v > 0.0:
                h, c, theta[i], k[i] = lookup(tables, m, temperature[i])
                each_h[i], each_c[i] = h, c
                heat[i] += v * h
                capacity[i] += v * c
    exchange(
        field.theta,
        field.conductivity,
        grid.conduction,
        field.conductance,
        field.flow,
        field.flows,
        nx,
        plane,
    )
    exchange(field.enthalpy, field.density_heat, grid.mass, field.capacitance, heat, field.flows, nx, plane)
    if cavities is not None:
        add_convection(temperature, cavities, grid.conduction, field.conductance, field.flow, plane)
    if reactions is not None:
        react(temperature, g, volume, reactions, progress, heat, capacity)
    _surfaces(temperature, surroundings, surface, field)


@njit(cache=True, fastmath=FAST)
def _surfaces(temperature: Array, surroundings: Array, surface: Surface, field: Field) -> None:
    """Add convection, radiation and flux, and keep each surface's heat inflow (W) apart.

    surface_flow : the three inflows, then what crosses each surface in either direction: where gas and
    radiation have two temperatures, heat that one brings and the other takes counts
    """
    n = temperature.size
    field.diagonal[:] = 0.0
    for s in range(3):
        film, emissivity = surface.film[s], surface.emissivity[s] * STEFAN_BOLTZMANN
        total, magnitude = 0.0, 0.0
        area = surface.area[s].reshape(n)
        flux = surroundings[2, s]
        if film > 0.0 or emissivity > 0.0 or flux != 0.0:
            gas = surroundings[0, s] - ABSOLUTE_ZERO
            g = surroundings[1, s] - ABSOLUTE_ZERO
            for i in range(n):
                if area[i] > 0.0:
                    t = temperature[i] - ABSOLUTE_ZERO
                    convection = film * (gas - t)
                    radiation = emissivity * (g * g + t * t) * (g + t) * (g - t)
                    q = area[i] * (convection + radiation + flux)
                    field.flow[i] += q
                    field.diagonal[i] += area[i] * (film + 4.0 * emissivity * t * t * t)
                    total += q
                    magnitude += area[i] * (abs(convection) + abs(radiation) + abs(flux))
        field.surface_flow[s] = total
        field.surface_flow[3 + s] = magnitude
