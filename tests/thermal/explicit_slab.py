"""A slab by explicit finite volumes, for comparison: it shares nothing with the solver.

Cells with temperature as the unknown. What a reaction takes or gives in a step is found cell by cell: a rate
by forward Euler, an equilibrium by bisection for the temperature at which the step's heat is used up.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import solveh_banded

SIGMA, GAS = 5.670374419e-8, 8.314462618


@dataclass
class Reaction:
    """As a scene's; kg/m3 that take part, J/kg (negative: given), J/(kg K) and kg/m3 of what leaves."""

    amount: float
    taken: float
    leaving: float = 0.0
    specific_heat: float = 0.0
    held_at: float = 0.0
    temperature: tuple[float, ...] = ()
    degree: tuple[float, ...] = (0.0, 1.0)
    rate: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None
    oxygen: float = 0.0


@dataclass
class Slab:
    """thickness, m; stays : kg/m3; film, emissivity : of the exposed and the unexposed face."""

    thickness: float
    stays: float
    specific_heat: Callable[[np.ndarray], np.ndarray]
    conductivity: Callable[[np.ndarray], np.ndarray]
    furnace: Callable[[float], float]
    film: tuple[float, float]
    emissivity: tuple[float, float]
    reactions: list[Reaction] = field(default_factory=list)
    sheet: float = 0.0
    ambient: float = 20.0


def burn(slab: Slab, cells: int, step: float, times: list[float]) -> tuple[np.ndarray, list[np.ndarray]]:
    """Faces and middle (K, 3), °C, at `times`, s, and the reactions' degrees at the end.

    sheet : J/(m2 K) of a thin sheet on the exposed face, at its temperature
    """
    d = slab.thickness / cells
    t = np.full(cells, slab.ambient)
    degree = [
        np.interp(t, r.temperature, r.degree) if r.temperature else np.zeros(cells) for r in slab.reactions
    ]
    front, back, found, n = slab.ambient, slab.ambient, [], 0
    for target in times:
        while n * step < target - 1e-9:
            gas = slab.furnace((n + 0.5) * step)
            k = slab.conductivity(t)
            flow = np.zeros(cells + 1)
            flow[1:-1] = 2.0 / (1.0 / k[1:] + 1.0 / k[:-1]) * (t[:-1] - t[1:]) / d
            into = _enters(gas, front, slab.film[0], slab.emissivity[0])
            if slab.sheet > 0.0:
                flow[0] = 2.0 * k[0] * (front - t[0]) / d
                front += step * (into - flow[0]) / slab.sheet
            else:
                front = _face(front, t[0], gas, 2.0 * k[0] / d, slab.film[0], slab.emissivity[0])
                flow[0] = 2.0 * k[0] * (front - t[0]) / d
            back = _face(back, t[-1], slab.ambient, 2.0 * k[-1] / d, slab.film[1], slab.emissivity[1])
            flow[-1] = 2.0 * k[-1] * (t[-1] - back) / d
            heat = step * (flow[:-1] - flow[1:]) / d
            supply = _oxygen(slab, t, degree, d)
            capacity = slab.stays * slab.specific_heat(t)
            for r, x in zip(slab.reactions, degree, strict=True):
                capacity = capacity + r.leaving * r.specific_heat * (1.0 - x)
            for m, r in enumerate(slab.reactions):
                if r.rate is not None:
                    speed = r.rate(t, degree[m]) * (supply if r.oxygen else 1.0)
                    more = np.minimum(step * speed, 1.0 - degree[m])
                    degree[m] = degree[m] + more
                    heat = heat - _taken(r, t) * more
            t = _settle(t, heat, capacity, slab.reactions, degree)
            n += 1
        found.append((front, np.interp(0.5, (np.arange(cells) + 0.5) / cells, t), back))
    return np.array(found), degree


def _taken(r: Reaction, t: np.ndarray) -> np.ndarray:
    return r.amount * r.taken - r.leaving * r.specific_heat * (t - r.held_at)


def _settle(t, heat, capacity, reactions, degree):
    """Temperatures after `heat`, J/m3, of which reactions in equilibrium take their part."""
    new = t + heat / capacity
    for m, r in enumerate(reactions):
        if r.rate is not None:
            continue
        full = np.interp(new, r.temperature, r.degree)
        busy = np.flatnonzero(full > degree[m])
        if busy.size == 0:
            continue
        low, high = np.minimum(t[busy], new[busy]), new[busy].copy()
        for _ in range(30):
            middle = 0.5 * (low + high)
            x = np.maximum(np.interp(middle, r.temperature, r.degree), degree[m][busy])
            used = capacity[busy] * (middle - t[busy]) + _taken(r, middle) * (x - degree[m][busy])
            too_much = used > heat[busy]
            high, low = np.where(too_much, middle, high), np.where(too_much, low, middle)
        new[busy] = 0.5 * (low + high)
        degree[m][busy] = np.maximum(degree[m][busy], np.interp(new[busy], r.temperature, r.degree))
    return new


def _enters(gas, face, film, emissivity):
    return film * (gas - face) + emissivity * SIGMA * ((gas + 273.15) ** 4 - (face + 273.15) ** 4)


def _face(guess, inside, gas, conductance, film, emissivity):
    """Temperature of a massless face between its gas and half a cell."""
    for _ in range(4):
        slope = conductance + film + 4.0 * emissivity * SIGMA * (guess + 273.15) ** 3
        guess += (_enters(gas, guess, film, emissivity) - conductance * (guess - inside)) / slope
    return guess


def _oxygen(slab, t, degree, d):
    """Share of air's oxygen in the cells, which comes in from the unexposed face."""
    if not any(r.oxygen for r in slab.reactions):
        return np.ones(len(t))
    kelvin = np.append(0.5 * (t[1:] + t[:-1]), t[-1]) + 273.15
    g = 0.232 * 353.0 / kelvin * 2.05e-5 * (kelvin / 293.15) ** 1.75 / d
    g[-1] *= 2.0
    sink = np.zeros(len(t))
    for r, x in zip(slab.reactions, degree, strict=True):
        if r.oxygen:
            sink += d * r.oxygen * r.rate(t, x)
    banded = np.zeros((2, len(t)))
    banded[0, 1:] = -g[:-1]
    banded[1] = sink + g + np.concatenate([[0.0], g[:-1]])
    right = np.zeros(len(t))
    right[-1] = g[-1]
    return solveh_banded(banded, right, check_finite=False)
