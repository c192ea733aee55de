"""Moments, torque and shear of a reduced link in space turn with it: forces of its strains to second order.

A strain is q_k + sum_ab G_kab x_a y_b of the link's twists and slopes (turning_products.py), with the energy
K_k strain^2 / 2.  size, data, own as in link.py; e is the row of the link as one element.
"""

from __future__ import annotations

from ..beam import BEND_Y, BEND_Z, LENGTH, SHEAR_Y, SHEAR_Z, TORSION
from ..kernel import kernel
from .layout import AXIALS, BENT, CROSS_T, CROSS_Y, CROSS_Z, MODAL_STIFFNESS, MODES, TENSIONS, Y_MODES, Z_MODES


@kernel
def counts(size):
    """Numbers of twists, of slopes in y and in z, and of all of them."""
    y, z = 3 + size[Y_MODES], 3 + size[Z_MODES]
    twists = 2 + size[MODES] - size[AXIALS] - size[Y_MODES] - size[Z_MODES]
    return twists, y, z, twists + y + z


@kernel
def write_slopes(size, e, rows, first, own, at):
    """Write twists, slopes in y and in z of nodal rows, flat, into own[at:]."""
    p, r, m = 6 * first, 6 * first + 6, 6 * first + 12 + size[AXIALS]
    twists, y, z, _ = counts(size)
    own[at], own[at + 1] = 0.5 * (rows[p + 3] + rows[r + 3]), 0.5 * (rows[r + 3] - rows[p + 3])
    for k in range(2, twists):
        own[at + k] = rows[m + y + z - 8 + k]
    at += twists
    mean = 0.5 * (rows[p + 5] + rows[r + 5])
    own[at], own[at + 1] = mean, rows[r + 5] - rows[p + 5]
    own[at + 2] = (rows[r + 1] - rows[p + 1]) / e[LENGTH] - mean
    for k in range(3, y):
        own[at + k] = rows[m + k - 3]
    at += y
    mean = -0.5 * (rows[p + 4] + rows[r + 4])
    own[at], own[at + 1] = mean, rows[p + 4] - rows[r + 4]
    own[at + 2] = (rows[r + 2] - rows[p + 2]) / e[LENGTH] - mean
    for k in range(3, z):
        own[at + k] = rows[m + y + k - 6]


@kernel
def add_slope_forces(size, e, own, at, force, first):
    """Add the forces own[at:] on twists and slopes to those on the nodal rows, flat."""
    p, r, m = 6 * first, 6 * first + 6, 6 * first + 12 + size[AXIALS]
    twists, y, z, _ = counts(size)
    force[p + 3] += 0.5 * (own[at] - own[at + 1])
    force[r + 3] += 0.5 * (own[at] + own[at + 1])
    for k in range(2, twists):
        force[m + y + z - 8 + k] += own[at + k]
    at += twists
    mean, pull = 0.5 * (own[at] - own[at + 2]), own[at + 2] / e[LENGTH]
    force[p + 1] -= pull
    force[r + 1] += pull
    force[p + 5] += mean - own[at + 1]
    force[r + 5] += mean + own[at + 1]
    for k in range(3, y):
        force[m + k - 3] += own[at + k]
    at += y
    mean, pull = 0.5 * (own[at] - own[at + 2]), own[at + 2] / e[LENGTH]
    force[p + 2] -= pull
    force[r + 2] += pull
    force[p + 4] -= mean - own[at + 1]
    force[r + 4] -= mean + own[at + 1]
    for k in range(3, z):
        force[m + y + k - 6] += own[at + k]


@kernel
def product(data, at, nx, x, ny, y, own):
    """sum_ab G_ab x_a y_b, G at data[at:], x and y at own[x:] and own[y:]."""
    total = 0.0
    for a in range(nx):
        inner = 0.0
        for b in range(ny):
            inner += data[at + a * ny + b] * own[y + b]
        total += own[x + a] * inner
    return total


@kernel
def add_product(data, at, stress, nx, x, ny, y, own, fx, fy):
    """Add the forces of a stress on that product to own[fx:] and own[fy:]."""
    for a in range(nx):
        weight, total = stress * own[x + a], 0.0
        for b in range(ny):
            g = data[at + a * ny + b]
            total += g * own[y + b]
            own[fy + b] += weight * g
        own[fx + a] += stress * total


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
    """Of a family of strains: number, its first product, places of its own linear strains and of x and y."""
    twists, y, z, _ = counts(size)
    if family == 0:
        return y - 1, size[CROSS_Z], twists + 1, twists, 0, z, twists + y
    if family == 1:
        return z - 1, size[CROSS_Y], twists + y + 1, twists, 0, y, twists
    return twists - 1, size[CROSS_T], 1, y, twists, z, twists + y


@kernel
def add_turning(size, data, own, e, d, v, first, still, beta, force):
    """Add what the second order does: still times the forces at d, and beta times the stiffness at d times v.

    d, v and force are nodal rows, flat; the linear forces are those of `elastic_forces`.
    """
    if size[TENSIONS] == 0:
        return
    _, _, _, count = counts(size)
    at, rate, out = size[BENT], size[BENT] + count, size[BENT] + 2 * count
    write_slopes(size, e, d, first, own, at)
    if beta != 0.0:
        write_slopes(size, e, v, first, own, rate)
    for k in range(count):
        own[out + k] = 0.0
    for family in range(3):
        number, cross, linear, nx, x, ny, y = family_of(size, family)
        for k in range(number):
            g, stiffness = cross + k * nx * ny, stiffness_of(size, data, e, family, k)
            unit = 2.0 if family == 2 and k == 0 else 1.0
            more = still * product(data, g, nx, at + x, ny, at + y, own)
            whole = more + still * unit * own[at + linear + k]
            if beta != 0.0:
                quick = product(data, g, nx, rate + x, ny, at + y, own)
                quick += product(data, g, nx, at + x, ny, rate + y, own)
                more += beta * quick
                whole += beta * (quick + unit * own[rate + linear + k])
            own[out + linear + k] += unit * stiffness * more
            add_product(data, g, stiffness * whole, nx, at + x, ny, at + y, own, out + x, out + y)
    add_slope_forces(size, e, own, out, force, first)


@kernel
def turning_energy(size, data, own, e, d, first):
    """What the second order adds to the strain energy of the nodal rows d, flat, J."""
    if size[TENSIONS] == 0:
        return 0.0
    at, total = size[BENT], 0.0
    write_slopes(size, e, d, first, own, at)
    for family in range(3):
        number, cross, linear, nx, x, ny, y = family_of(size, family)
        for k in range(number):
            unit = 2.0 if family == 2 and k == 0 else 1.0
            more = product(data, cross + k * nx * ny, nx, at + x, ny, at + y, own)
            stiffness = stiffness_of(size, data, e, family, k)
            total += stiffness * more * (unit * own[at + linear + k] + 0.5 * more)
    return total
