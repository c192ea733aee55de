"""The eight-node brick with incompatible modes, for sheets that are thin and bend.

Beside the eight trilinear functions every element has 1 - xi^2, 1 - eta^2 and 1 - zeta^2 for
each displacement (Wilson et al. 1973; Taylor, Beresford and Wilson 1976, IJNME 10, 1211), which
let it bend without locking; they belong to the element alone and are eliminated in it. The
bricks are rectangular, so the patch test needs no correction.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from skfem import ElementHex1

Array = NDArray[np.float64]

_POINT = 0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)
GAUSS = np.array([[x, y, z] for z in _POINT for y in _POINT for x in _POINT])
"""2 x 2 x 2 Gauss points (8, 3) on the unit cube; each weighs an eighth."""


def shape_functions() -> tuple[Array, Array]:
    """Trilinear functions (8, 8) at the Gauss points, and derivatives (8, 8, 3).

    Rows are Gauss points, columns the nodes in scikit-fem's order.
    """
    element = ElementHex1()
    pairs = [element.lbasis(GAUSS.T, i) for i in range(8)]
    value = np.array([pair[0] for pair in pairs]).T
    slope = np.array([pair[1] for pair in pairs]).transpose(2, 0, 1)
    return value, slope


def stiffness_and_load(
    size: Array, modulus: Array, poissons_ratio: Array, strain: Array
) -> tuple[Array, Array]:
    """Element stiffness (n, 24, 24), N/m, and thermal load (n, 24), N.

    size (n, 3) : m; modulus (n, 8) : Pa at the Gauss points; poissons_ratio (n,) : -
    strain (n, 8) : free thermal strain at the Gauss points, -
    Unknowns node by node: ux, uy, uz.
    """
    stiffness, load = _whole(size, modulus, poissons_ratio, strain)
    inner = stiffness[:, 24:, 24:]
    eliminate = np.linalg.solve(inner, stiffness[:, 24:, :24])
    outer = stiffness[:, :24, 24:]
    condensed = stiffness[:, :24, :24] - outer @ eliminate
    inner_load = np.linalg.solve(inner, load[:, 24:, None])
    return condensed, load[:, :24] - (outer @ inner_load)[:, :, 0]


def element_stress(size: Array, modulus: Array, poissons_ratio: Array, strain: Array, u: Array) -> Array:
    """Von Mises stress (n, 8), Pa, at the Gauss points of elements moved by u (n, 24), m."""
    stiffness, load = _whole(size, modulus, poissons_ratio, strain)
    rest = load[:, 24:] - np.einsum("nij,nj->ni", stiffness[:, 24:, :24], u)
    every = np.concatenate([u, np.linalg.solve(stiffness[:, 24:, 24:], rest[:, :, None])[:, :, 0]], axis=1)
    found = np.empty((len(size), 8))
    for g in range(8):
        e = np.einsum("nij,nj->ni", _strain_matrix(_gradient(size, g)), every)
        shear = modulus[:, g] / (2.0 * (1.0 + poissons_ratio))
        pull = 2.0 * shear[:, None] * e[:, :3]  # pressure does not matter
        twist = shear[:, None] * e[:, 3:]
        a, b, c = pull.T
        found[:, g] = np.sqrt(
            0.5 * ((a - b) ** 2 + (b - c) ** 2 + (c - a) ** 2) + 3.0 * (twist**2).sum(axis=1)
        )
    return found


def _gradient(size: Array, g: int) -> Array:
    """Gradients (n, 11, 3) of the functions at Gauss point g."""
    _, slope = shape_functions()
    gradient = np.zeros((len(size), 11, 3))
    gradient[:, :8] = slope[g] / size[:, None, :]
    for axis in range(3):
        # d/dx of 1 - xi^2 with xi = 2 x / size - 1
        gradient[:, 8 + axis, axis] = -4.0 * (2.0 * GAUSS[g][axis] - 1.0) / size[:, axis]
    return gradient


def _whole(size: Array, modulus: Array, poissons_ratio: Array, strain: Array) -> tuple[Array, Array]:
    """Stiffness (n, 33, 33) and load (n, 33) with the incompatible modes last."""
    count = len(size)
    volume = size.prod(axis=1) / 8.0
    stiffness = np.zeros((count, 33, 33))
    load = np.zeros((count, 33))
    for g in range(8):
        b = _strain_matrix(_gradient(size, g))
        shear = modulus[:, g] / (2.0 * (1.0 + poissons_ratio))
        lame = modulus[:, g] * poissons_ratio
        lame /= (1.0 + poissons_ratio) * (1.0 - 2.0 * poissons_ratio)
        d = np.zeros((count, 6, 6))
        d[:, :3, :3] = lame[:, None, None]
        for i in range(6):
            d[:, i, i] += (2.0 if i < 3 else 1.0) * shear
        db = d @ b
        stiffness += volume[:, None, None] * (b.transpose(0, 2, 1) @ db)
        pressure = (3.0 * lame + 2.0 * shear) * strain[:, g] * volume
        load += pressure[:, None] * b[:, :3, :].sum(axis=1)
    return stiffness, load


def _strain_matrix(gradient: Array) -> Array:
    """Strains (n, 6, 3 f) xx yy zz xy yz zx (engineering shear) of f functions' gradients."""
    count, functions, _ = gradient.shape
    b = np.zeros((count, 6, functions, 3))
    gx, gy, gz = gradient[:, :, 0], gradient[:, :, 1], gradient[:, :, 2]
    b[:, 0, :, 0] = gx
    b[:, 1, :, 1] = gy
    b[:, 2, :, 2] = gz
    b[:, 3, :, 0], b[:, 3, :, 1] = gy, gx
    b[:, 4, :, 1], b[:, 4, :, 2] = gz, gy
    b[:, 5, :, 0], b[:, 5, :, 2] = gz, gx
    return b.reshape(count, 6, 3 * functions)
