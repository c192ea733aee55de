"""A strip of the door by linear bricks, as most programs have them: another road to its temperatures.

Bricks of four nodes in the section (x along the leaf, z through it), consistent heat capacity, material
properties at 2 x 2 Gauss points and at the end of a step of implicit Euler.  Nothing here is of the door's
solver but the laws of steel.
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import spsolve

from thermal_node.model.materials import steel_conductivity, steel_specific_heat

Array = NDArray[np.float64]
KELVIN, STEFAN_BOLTZMANN, AMBIENT = 273.15, 5.670374419e-8, 20.0
STEEL_DENSITY, WOOL_CAPACITY = 7800.0, 120.0 * 1000.0
WOOL = ([10.0, 100.0, 300.0, 600.0, 1000.0], [0.035, 0.043, 0.073, 0.17, 0.30])
SHEET, THICKNESS, RIM = 0.001, 0.060, 0.499
EXPOSED, UNEXPOSED = (25.0, 0.8), (10.0, 0.0)  # W/(m2 K), emissivity

PLACE = 1.0 / np.sqrt(3.0)
GAUSS = np.array([(-PLACE, -PLACE), (PLACE, -PLACE), (PLACE, PLACE), (-PLACE, PLACE)])
CORNER = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
SHAPE = (1 + GAUSS[:, None, 0] * CORNER[:, 0]) * (1 + GAUSS[:, None, 1] * CORNER[:, 1]) / 4
ALONG = CORNER[:, 0] * (1 + GAUSS[:, None, 1] * CORNER[:, 1]) / 4
THROUGH = CORNER[:, 1] * (1 + GAUSS[:, None, 0] * CORNER[:, 0]) / 4


def burn(x: Array, z: Array, step: float, end: float, every: float) -> Array:
    """Temperatures (K, nz, nx), °C, each `every` s under ISO 834, of a strip with a rim of steel."""
    nx, nz = len(x), len(z)
    n = nx * nz
    i, k = (a.ravel() for a in np.meshgrid(np.arange(nx - 1), np.arange(nz - 1)))
    nodes = np.stack([k * nx + i, k * nx + i + 1, (k + 1) * nx + i + 1, (k + 1) * nx + i], axis=1)
    width, depth = np.diff(x)[i], np.diff(z)[k]
    area = 0.25 * width * depth
    middle = 0.5 * (z[k] + z[k + 1])
    of_steel = ((middle < SHEET) | (middle > THICKNESS - SHEET) | (0.5 * (x[i] + x[i + 1]) > RIM))[:, None]
    row, column = np.repeat(nodes, 4, axis=1).ravel(), np.tile(nodes, (1, 4)).ravel()

    def assembled(parts: Array) -> sp.csc_matrix:
        return sp.coo_matrix((parts.ravel(), (row, column)), (n, n)).tocsc()

    temperature = np.full(n, AMBIENT)
    found, faces = [], ((np.arange(nx), EXPOSED), (n - nx + np.arange(nx), UNEXPOSED))
    for count in range(1, round(end / step) + 1):
        furnace = 20.0 + 345.0 * np.log10(8.0 * count * step / 60.0 + 1.0)
        before = temperature.copy()
        for iteration in range(80):
            inside = temperature[nodes] @ SHAPE.T
            heat = np.where(of_steel, STEEL_DENSITY * steel_specific_heat(inside), WOOL_CAPACITY)
            conductivity = np.where(of_steel, steel_conductivity(inside), np.interp(inside, *WOOL))
            capacity = assembled(np.einsum("eg,gi,gj,e->eij", heat, SHAPE, SHAPE, area))
            conduction = assembled(
                np.einsum("eg,gi,gj,e->eij", conductivity, ALONG, ALONG, area * (2.0 / width) ** 2)
                + np.einsum("eg,gi,gj,e->eij", conductivity, THROUGH, THROUGH, area * (2.0 / depth) ** 2)
            )
            inflow, slope = surfaces(temperature, faces, np.diff(x), (furnace, AMBIENT))
            residual = step * (inflow - conduction @ temperature) - capacity @ (temperature - before)
            change = spsolve(capacity + step * (conduction + slope), residual)
            temperature = temperature + (1.0 if iteration < 25 else 0.5) * change
            if np.abs(change).max() < 1e-3:
                break
        else:
            raise RuntimeError(f"no solution at {count * step:g} s")
        if count % round(every / step) == 0:
            found.append(temperature.reshape(nz, nx))
    return np.array(found)


def surfaces(
    temperature: Array,
    faces: tuple[tuple[NDArray[np.int64], tuple[float, float]], ...],
    width: Array,
    gas: tuple[float, float],
) -> tuple[Array, sp.csc_matrix]:
    """Heat inflow (N,), W, through the faces at two Gauss points a brick, and minus its derivative."""
    n = len(temperature)
    inflow, slope = np.zeros(n), sp.csc_matrix((n, n))
    for (face, (film, emissivity)), outside in zip(faces, gas, strict=True):
        for place in (0.5 - 0.5 * PLACE, 0.5 + 0.5 * PLACE):
            ends = ((face[:-1], 1.0 - place), (face[1:], place))
            kelvin = sum(part * temperature[end] for end, part in ends) + KELVIN
            radiated = emissivity * STEFAN_BOLTZMANN
            flux = film * (outside + KELVIN - kelvin) + radiated * ((outside + KELVIN) ** 4 - kelvin**4)
            rise = film + 4.0 * radiated * kelvin**3
            for end, part in ends:
                np.add.at(inflow, end, 0.5 * width * part * flux)
                for other, its_part in ends:
                    values = 0.5 * width * part * its_part * rise
                    slope = slope + sp.coo_matrix((values, (end, other)), (n, n)).tocsc()
    return inflow, slope
