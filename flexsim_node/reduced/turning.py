"""Moments, torque and shear of a reduced link in space turn with it: forces of its strains to second order.

A strain is q_k + sum_ab G_kab x_a y_b of the link's twists and slopes (turning_products.py), with the energy
K_k strain^2 / 2.  size, data, own as in link.py; e is the row of the link as one element.
"""

from __future__ import annotations

from ..beam import BEND_Y, BEND_Z, LENGTH, SHEAR_Y, SHEAR_Z, TORSION
from ..kernel import kernel
from ..weighted_sum import combine, dot
from .layout import (
    AXIALS,
    BENT,
    CROSS_T,
    CROSS_Y,
    CROSS_Z,
    HELICES,
    MODAL_STIFFNESS,
    MODES,
    TENSIONS,
    WOUND,
    Y_MODES,
    Z_MODES,
)


@kernel
def counts(size):
    """Numbers of twists and of slopes in y and in z, places of the slopes, and length of all."""
    y, z = 3 + size[Y_MODES], 3 + size[Z_MODES]
    twists = 2 + size[MODES] - size[AXIALS] - size[Y_MODES] - size[Z_MODES]
    at_y = fours(twists)
    at_z = at_y + fours(y)
    return twists, y, z, at_y, at_z, at_z + fours(z)


@kernel
def fours(n):
    """The next multiple of four."""
    return (n + 3) // 4 * 4


@kernel
def write_slopes(size, e, rows, first, own, at):
    """Write twists, slopes in y and in z of nodal rows, flat, into own[at:], each with zeros up to four."""
    p, r, m = 6 * first, 6 * first + 6, 6 * first + 12 + size[AXIALS]
    twists, y, z, at_y, at_z, count = counts(size)
    for k in range(count):
        own[at + k] = 0.0
    own[at], own[at + 1] = 0.5 * (rows[p + 3] + rows[r + 3]), 0.5 * (rows[r + 3] - rows[p + 3])
    for k in range(2, twists):
        own[at + k] = rows[m + y + z - 8 + k]
    h = at + at_y
    mean = 0.5 * (rows[p + 5] + rows[r + 5])
    own[h], own[h + 1] = mean, rows[r + 5] - rows[p + 5]
    own[h + 2] = (rows[r + 1] - rows[p + 1]) / e[LENGTH] - mean
    for k in range(3, y):
        own[h + k] = rows[m + k - 3]
    h = at + at_z
    mean = -0.5 * (rows[p + 4] + rows[r + 4])
    own[h], own[h + 1] = mean, rows[p + 4] - rows[r + 4]
    own[h + 2] = (rows[r + 2] - rows[p + 2]) / e[LENGTH] - mean
    for k in range(3, z):
        own[h + k] = rows[m + y + k - 6]


@kernel
def add_slope_forces(size, e, own, at, force, first):
    """Add the forces own[at:] on twists and slopes to those on the nodal rows, flat."""
    p, r, m = 6 * first, 6 * first + 6, 6 * first + 12 + size[AXIALS]
    twists, y, z, at_y, at_z, _ = counts(size)
    force[p + 3] += 0.5 * (own[at] - own[at + 1])
    force[r + 3] += 0.5 * (own[at] + own[at + 1])
    for k in range(2, twists):
        force[m + y + z - 8 + k] += own[at + k]
    h = at + at_y
    mean, pull = 0.5 * (own[h] - own[h + 2]), own[h + 2] / e[LENGTH]
    force[p + 1] -= pull
    force[r + 1] += pull
    force[p + 5] += mean - own[h + 1]
    force[r + 5] += mean + own[h + 1]
    for k in range(3, y):
        force[m + k - 3] += own[h + k]
    h = at + at_z
    mean, pull = 0.5 * (own[h] - own[h + 2]), own[h + 2] / e[LENGTH]
    force[p + 2] -= pull
    force[r + 2] += pull
    force[p + 4] -= mean - own[h + 1]
    force[r + 4] -= mean + own[h + 1]
    for k in range(3, z):
        force[m + y + k - 6] += own[h + k]


@kernel
def write_twists(size, rows, first, own, at):
    """Write half the difference of the ends' twists, modes that twist, and zeros up to four into own[at:]."""
    p, r, k = 6 * first, 6 * first + 6, size[AXIALS] + size[Y_MODES] + size[Z_MODES]
    count, m = 1 + size[MODES] - k, 6 * first + 12 + k
    own[at] = 0.5 * (rows[r + 3] - rows[p + 3])
    for i in range(1, fours(count)):
        own[at + i] = rows[m + i - 1] if i < count else 0.0


@kernel
def wound_gradient(size, data, own, count, j):
    """Write half the gradient of the squared twists that tension j sees behind the twists and their rates."""
    n, at = fours(count), size[WOUND]
    combine(count, own, at, data, size[HELICES] + j * count * n, n, own, at + 2 * n, n)


@kernel
def wound_elongation(size, data, own, j, still, beta):
    """How much the twist stretches the link in tension j, (T2): still times that, and beta times its rate.

    `write_twists` has written twists and rates into own[WOUND:]; their half gradient follows these.
    """
    count = 1 + size[MODES] - size[AXIALS] - size[Y_MODES] - size[Z_MODES]
    wound_gradient(size, data, own, count, j)
    n, at = fours(count), size[WOUND]
    return 0.5 * still * dot(n, own, at, own, at + 2 * n) + beta * dot(n, own, at + n, own, at + 2 * n)


@kernel
def add_wound_forces(size, own, pull, force, first):
    """Add a pull times the gradient that `wound_elongation` has left to the nodal rows, flat."""
    k = size[AXIALS] + size[Y_MODES] + size[Z_MODES]
    count, m = 1 + size[MODES] - k, 6 * first + 12 + k
    at = size[WOUND] + 2 * fours(count)
    force[6 * first + 3] -= 0.5 * pull * own[at]
    force[6 * first + 9] += 0.5 * pull * own[at]
    for i in range(1, count):
        force[m + i - 1] += pull * own[at + i]


@kernel
def stiffness_of(size, data, e, family, k):
    """Stiffness K_k of a strain: of bending in y (family 0), in z (1), of torsion (2)."""
    modal = size[MODAL_STIFFNESS] + size[AXIALS]
    if family == 0:
        if k >= 2:
            return data[modal + k - 2]
        return e[BEND_Z] if k == 0 else 12.0 * (1.0 - e[SHEAR_Z]) * e[BEND_Z]
    if family == 1:
        if k >= 2:
            return data[modal + size[Y_MODES] + k - 2]
        return e[BEND_Y] if k == 0 else 12.0 * (1.0 - e[SHEAR_Y]) * e[BEND_Y]
    return e[TORSION] if k == 0 else data[modal + size[Y_MODES] + size[Z_MODES] + k - 1]


@kernel
def family_of(size, family):
    """Of a family of strains: number, products, place of the linear ones; count of x, places, width of y."""
    twists, y, z, at_y, at_z, _ = counts(size)
    if family == 0:
        return y - 1, size[CROSS_Z], at_y + 1, twists, 0, at_z, fours(z)
    if family == 1:
        return z - 1, size[CROSS_Y], at_z + 1, twists, 0, at_y, fours(y)
    return twists - 1, size[CROSS_T], 1, y, at_y, at_z, fours(z)


@kernel
def add_turning(size, data, own, e, d, v, first, still, beta, force):
    """Add what the second order does: still times the forces at d, and beta times the stiffness at d times v.

    d, v and force are nodal rows, flat; the linear forces are those of `elastic_forces`.
    """
    if size[TENSIONS] == 0:
        return
    _, _, _, _, _, count = counts(size)
    at, rate, out, by_x = size[BENT], size[BENT] + count, size[BENT] + 2 * count, size[BENT] + 3 * count
    write_slopes(size, e, d, first, own, at)
    if beta != 0.0:
        write_slopes(size, e, v, first, own, rate)
    for k in range(count):
        own[out + k] = 0.0
    for family in range(3):
        number, cross, linear, nx, x, y, width = family_of(size, family)
        whole = number * width
        by_rate, spread = by_x + whole, by_x + 2 * whole
        combine(nx, own, at + x, data, cross, whole, own, by_x, whole)
        if beta != 0.0:
            combine(nx, own, rate + x, data, cross, whole, own, by_rate, whole)
        for k in range(number):
            stiffness, row = stiffness_of(size, data, e, family, k), by_x + k * width
            unit = 2.0 if family == 2 and k == 0 else 1.0
            more = still * dot(width, own, row, own, at + y)
            stress = more + still * unit * own[at + linear + k]
            if beta != 0.0:
                quick = dot(width, own, row, own, rate + y)
                quick += dot(width, own, by_rate + k * width, own, at + y)
                more += beta * quick
                stress += beta * (quick + unit * own[rate + linear + k])
            stress *= stiffness
            own[out + linear + k] += unit * stiffness * more
            for b in range(width):
                own[out + y + b] += stress * own[row + b]
                own[spread + k * width + b] = stress * own[at + y + b]
        for a in range(nx):
            own[out + x + a] += dot(whole, data, cross + a * whole, own, spread)
    add_slope_forces(size, e, own, out, force, first)


@kernel
def turning_energy(size, data, own, e, d, first):
    """What the second order adds to the strain energy of the nodal rows d, flat, J."""
    if size[TENSIONS] == 0:
        return 0.0
    _, _, _, _, _, count = counts(size)
    at, by_x, total = size[BENT], size[BENT] + 3 * count, 0.0
    write_slopes(size, e, d, first, own, at)
    for family in range(3):
        number, cross, linear, nx, x, y, width = family_of(size, family)
        whole = number * width
        combine(nx, own, at + x, data, cross, whole, own, by_x, whole)
        for k in range(number):
            unit = 2.0 if family == 2 and k == 0 else 1.0
            more = dot(width, own, by_x + k * width, own, at + y)
            stiffness = stiffness_of(size, data, e, family, k)
            total += stiffness * more * (unit * own[at + linear + k] + 0.5 * more)
    return total
