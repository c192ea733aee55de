"""How the frame's acceleration acts on a reduced link in space: its part of the mass matrix.

size, data, own, e as in space.py.
"""

from __future__ import annotations

from ...compiled.kernel import kernel
from ...compiled.weighted_sum import dot
from ...elements.beam import INERTIA_Y, INERTIA_Z, LENGTH, POLAR, SHEAR_Y, SHEAR_Z, hermite_transpose
from ...model.reduced.layout import (
    AXIALS,
    CENTRELINE,
    LINE,
    LUMPS,
    MASS_GRAM,
    MODES,
    PIVOTS,
    ROTATION,
    SUMS,
    TENSIONS,
    TURN_GRAM,
    TURNED,
    WIDTH,
    Y_MODES,
    Z_MODES,
)
from .link import middle_forces, products


@kernel
def bend_y(start, end, k, w1, t1, w2, t2):
    """Add forces on a deflection in y and its slopes to column k of both ends."""
    start[1, k] += w1
    start[5, k] += t1
    end[1, k] += w2
    end[5, k] += t2


@kernel
def bend_z(start, end, k, w1, t1, w2, t2):
    """Add forces on a deflection in z and its slopes to column k of both ends."""
    start[2, k] += w1
    start[4, k] -= t1
    end[2, k] += w2
    end[4, k] -= t2


@kernel
def inertia_coupling(size, data, own, e, start, end, inertia):
    """Add d(force)/d(link acceleration) of both ends to start and end (6, 6), of modes to their rows.

    The link's own is added to inertia (6, 6), upper triangle; the link is placed.
    """
    n, mass, width, length, y = size[CENTRELINE], size[MASS_GRAM], size[WIDTH], e[LENGTH], size[Y_MODES]
    c, at = size[LINE], size[PIVOTS] + 12
    q = c + 12 * n
    products(3, data, mass, n, own, c, q)
    mx, my, mz, q = q, q + n, q + 2 * n, q + y
    qx, qy, qz = q, q + n, q + 2 * n
    # the unit field is in the span of Hermite's functions: first and third
    first_one, second_one = mass + y * n, mass + (y + 2) * n
    total = data[first_one + y] + 2.0 * data[first_one + y + 2] + data[second_one + y + 2]
    # a unit acceleration along e_k has the coefficients (1, 0, 1, 0)
    half, twelfth = 0.5 * total, total * length / 12.0
    for k in range(3):
        start[k, k] += half
        end[k, k] += half
        inertia[k, k] += total
    start[5, 1] += twelfth
    end[5, 1] -= twelfth
    start[4, 2] -= twelfth
    end[4, 2] += twelfth
    # about e_k it has those of e_k x c
    w1, t1, w2, t2 = hermite_transpose(own[qz], own[qz + 1], own[qz + 2], own[qz + 3], length, e[SHEAR_Z])
    bend_y(start, end, 3, -w1, -t1, -w2, -t2)
    w1, t1, w2, t2 = hermite_transpose(own[qy], own[qy + 1], own[qy + 2], own[qy + 3], length, e[SHEAR_Y])
    bend_z(start, end, 3, w1, t1, w2, t2)
    w1, t1, w2, t2 = hermite_transpose(own[qx], own[qx + 1], own[qx + 2], own[qx + 3], length, e[SHEAR_Y])
    bend_z(start, end, 4, -w1, -t1, -w2, -t2)
    w1, t1, w2, t2 = hermite_transpose(own[qx], own[qx + 1], own[qx + 2], own[qx + 3], length, e[SHEAR_Z])
    bend_y(start, end, 5, w1, t1, w2, t2)
    pull = own[qz + 1] + own[qz + 3]
    start[0, 4] += own[qz] - pull
    end[0, 4] += own[qz + 2] + pull
    pull = own[qy + 1] + own[qy + 3]
    start[0, 5] += pull - own[qy]
    end[0, 5] -= pull + own[qy + 2]
    bent = size[AXIALS] + y
    space = bent + size[Z_MODES]
    k, row = y + 4 + size[Z_MODES], at
    for _ in range(size[AXIALS]):
        own[row], own[row + 1], own[row + 2] = data[first_one + k] + data[second_one + k], 0.0, 0.0
        own[row + 3], own[row + 4], own[row + 5] = 0.0, own[mz + k], -own[my + k]
        k, row = k + 1, row + width
    for k in range(y):
        own[row], own[row + 1], own[row + 2] = 0.0, data[first_one + k] + data[second_one + k], 0.0
        own[row + 3], own[row + 4], own[row + 5] = -own[mz + k], 0.0, own[mx + k]
        row += width
    k = y + 4
    for _ in range(bent, space):
        own[row], own[row + 1], own[row + 2] = 0.0, 0.0, data[first_one + k] + data[second_one + k]
        own[row + 3], own[row + 4], own[row + 5] = own[my + k], -own[mx + k], 0.0
        k, row = k + 1, row + width
    for _ in range(space, size[MODES]):
        own[row], own[row + 1], own[row + 2], own[row + 3] = 0.0, 0.0, 0.0, 0.0
        own[row + 4], own[row + 5] = 0.0, 0.0
        row += width
    sx, sy, sz = own[qx] + own[qx + 2], own[qy] + own[qy + 2], own[qz] + own[qz + 2]
    inertia[0, 4] += sz
    inertia[0, 5] -= sy
    inertia[1, 3] -= sz
    inertia[1, 5] += sx
    inertia[2, 3] += sy
    inertia[2, 4] -= sx
    xx, yy, zz = dot(n, own, c, own, mx), dot(n, own, c + n, own, my), dot(n, own, c + 2 * n, own, mz)
    xy, xz, yz = dot(n, own, c, own, my), dot(n, own, c, own, mz), dot(n, own, c + n, own, mz)
    inertia[3, 3] += yy + zz
    inertia[4, 4] += xx + zz
    inertia[5, 5] += xx + yy
    inertia[3, 4] -= xy
    inertia[3, 5] -= xz
    inertia[4, 5] -= yz
    if e[INERTIA_Y] + e[INERTIA_Z] > 0.0:
        section_coupling(size, data, own, e, start, end, inertia)
        if size[TENSIONS] > 0:
            turn_coupling(size, own, e, start, end, inertia)
    elif e[POLAR] > 0.0:
        half = 0.5 * e[POLAR] * length
        start[3, 3] += half
        end[3, 3] += half
        inertia[3, 3] += 2.0 * half
        for i in range(space, size[MODES]):
            own[at + i * width + 3] += e[POLAR] * turning(size, data, y + 3 + size[Z_MODES] + i - space)


@kernel
def turn_coupling(size, own, e, start, end, inertia):
    """Add what the sections' second-order turn (T8) has, section_turn.section_coupling at elements' ends."""
    jy, jz, n, x = e[INERTIA_Y], e[INERTIA_Z], size[ROTATION], size[LUMPS]
    half, y, z = 0.5 * (jy - jz), x + n, x + 2 * n
    # moments about x, y and z by the link's angular acceleration about them:
    #   x: 0, jz z, -jy y;  y: half z, 0, -jy x;  z: half y, jz x, 0
    add_twists(size, own, jz, z, 4, start, end)
    add_twists(size, own, -jy, y, 5, start, end)
    add_turns_of_z(size, own, e, half, z, 3, start, end)
    add_turns_of_z(size, own, e, -jy, x, 5, start, end)
    add_turns_of_y(size, own, e, half, y, 3, start, end)
    add_turns_of_y(size, own, e, jz, x, 4, start, end)
    at = size[SUMS] + 4
    xx, xy, xz, yy, yz, zz = own[at], own[at + 1], own[at + 2], own[at + 9], own[at + 10], own[at + 18]
    inertia[3, 3] -= jy * (xx + zz) + jz * (xx + yy)
    inertia[4, 4] -= jz * (xx + yy)
    inertia[5, 5] -= jy * (xx + zz)
    inertia[3, 4] -= jy * xy
    inertia[3, 5] -= jz * xz
    inertia[4, 5] -= 0.5 * (jy + jz) * yz


@kernel
def add_twists(size, own, factor, g, column, start, end):
    """Add factor times own[g:] (G,), moments about x, to a column of the ends' and modes' rows."""
    h, space = g + size[Y_MODES], size[AXIALS] + size[Y_MODES] + size[Z_MODES]
    start[3, column] += factor * (own[h] + 0.5 * own[h + 1])
    end[3, column] += factor * (own[h + 2] + 0.5 * own[h + 1])
    at, h = size[PIVOTS] + space * size[WIDTH] + 12 + column, h + 3 + size[Z_MODES]
    for i in range(size[MODES] - space):
        own[at + i * size[WIDTH]] += factor * own[h + i]


@kernel
def add_turns_of_z(size, own, e, factor, g, column, start, end):
    """The same for moments about y, those of a deflection in z."""
    h = g + size[Y_MODES]
    w1, t1, w2, t2 = middle_forces(e, e[SHEAR_Y], -factor * own[h + 1])
    bend_z(start, end, column, w1, t1 - factor * own[h], w2, t2 - factor * own[h + 2])
    at = size[PIVOTS] + (size[AXIALS] + size[Y_MODES]) * size[WIDTH] + 12 + column
    for i in range(size[Z_MODES]):
        own[at + i * size[WIDTH]] += factor * own[h + 3 + i]


@kernel
def add_turns_of_y(size, own, e, factor, g, column, start, end):
    """The same for moments about z, those of a deflection in y."""
    h = g + size[Y_MODES]
    w1, t1, w2, t2 = middle_forces(e, e[SHEAR_Z], factor * own[h + 1])
    bend_y(start, end, column, w1, factor * own[h] + t1, w2, factor * own[h + 2] + t2)
    at = size[PIVOTS] + size[AXIALS] * size[WIDTH] + 12 + column
    for i in range(size[Y_MODES]):
        own[at + i * size[WIDTH]] += factor * own[g + i]


@kernel
def turning(size, data, k):
    """Product of the rotation's function k with a unit rotation, that of the three quadratics together."""
    n, y = size[ROTATION], size[Y_MODES]
    at = size[TURN_GRAM] + y * n + k
    return data[at] + data[at + n] + data[at + 2 * n]


@kernel
def section_coupling(size, data, own, e, start, end, inertia):
    """The sections' part of inertia_coupling."""
    iy, iz, n, length = e[INERTIA_Y], e[INERTIA_Z], size[ROTATION], e[LENGTH]
    width, spun, y_modes = size[WIDTH], size[TURNED], size[Y_MODES]
    sx, sy, sz, k = spun, spun + n, spun + 2 * n, spun + 3 * n
    px, py, pz, at = own[k], own[k + 1], own[k + 2], size[SUMS]
    xx, xy, xz, yy, zz = own[at], own[at + 1], own[at + 2], own[at + 9], own[at + 18]
    # products of the directors' components: y = (-phi_z, 1, phi_x), z = (phi_y, -phi_x, 1)
    dxx, dyy, dzz = iy * zz + iz * yy, iy * length + iz * xx, iy * xx + iz * length
    inertia[3, 3] += dyy + dzz
    inertia[4, 4] += dxx + dzz
    inertia[5, 5] += dxx + dyy
    inertia[3, 4] += iy * pz + iz * xy
    inertia[3, 5] += iy * xz - iz * py
    inertia[4, 5] += (iz - iy) * px
    # moments of e_k x q on phi = (y_z - z_y, z_x, -y_x) of the directors y and z; of the quadratics the
    # integrals are a sixth, two thirds and a sixth of the length
    sixth = length / 6.0
    half = 0.5 * (iy + iz) * length
    start[3, 3] += half
    end[3, 3] += half
    sx, sy, sz = sx + y_modes, sy + y_modes, sz + y_modes
    mx, my, mz = own[sx + 1], own[sy + 1], own[sz + 1]
    for k, node in ((0, start), (2, end)):
        x, y, z = own[sx + k], own[sy + k], own[sz + k]
        node[3, 4] += iy * (z + 0.5 * mz)
        node[3, 5] -= iz * (y + 0.5 * my)
        node[4, 4] += iz * sixth
        node[4, 5] += iz * x
        node[5, 4] -= iy * x
        node[5, 5] += iy * sixth
    w1, t1, w2, t2 = middle_forces(e, e[SHEAR_Y], -4.0 * iz * sixth)
    bend_z(start, end, 4, w1, t1, w2, t2)
    w1, t1, w2, t2 = middle_forces(e, e[SHEAR_Y], -iz * mx)
    bend_z(start, end, 5, w1, t1, w2, t2)
    w1, t1, w2, t2 = middle_forces(e, e[SHEAR_Z], -iy * mx)
    bend_y(start, end, 4, w1, t1, w2, t2)
    w1, t1, w2, t2 = middle_forces(e, e[SHEAR_Z], 4.0 * iy * sixth)
    bend_y(start, end, 5, w1, t1, w2, t2)
    row = size[PIVOTS] + size[AXIALS] * width + 15
    for k in range(-y_modes, 0):
        own[row + 1] -= iy * own[sx + k]
        own[row + 2] += iy * turning(size, data, y_modes + k)
        row += width
    for k in range(3, 3 + size[Z_MODES]):
        own[row + 1] += iz * turning(size, data, y_modes + k)
        own[row + 2] += iz * own[sx + k]
        row += width
    for k in range(3 + size[Z_MODES], 3 + size[MODES] - size[AXIALS] - y_modes):
        own[row] += (iy + iz) * turning(size, data, y_modes + k)
        own[row + 1] += iy * own[sz + k]
        own[row + 2] -= iz * own[sy + k]
        row += width
