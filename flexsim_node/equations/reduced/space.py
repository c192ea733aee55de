"""Forces and inertia coupling of a reduced link in space: spatial_beam.py with the modes' functions added.

Rows first, first + 1 of the nodal arrays are the link's start and end; its modes follow, packed.  size, data,
own as in link.py; e is the row of the link as one element.
"""

from __future__ import annotations

from ...compiled.flat import flat
from ...compiled.kernel import kernel
from ...compiled.lanes import broadcast, load, multiply, multiply_add, total
from ...compiled.weighted_sum import add_mix, dot, eight_six, eight_thrice, mix
from ...elements import spatial_beam
from ...elements.beam import (
    INERTIA_Y,
    INERTIA_Z,
    LENGTH,
    POLAR,
    SHEAR_Y,
    SHEAR_Z,
    hermite,
    hermite_transpose,
    middle_rotation,
)
from ...model.reduced.layout import (
    ACROSS,
    AXIALS,
    CENTRELINE,
    FUNCTION,
    LINE,
    LUMP_GRAM,
    LUMPS,
    MASS_GRAM,
    MIX,
    MODES,
    ROTATION,
    SUMS,
    TENSIONS,
    TURN,
    TURN_GRAM,
    TURN_MIX,
    TURNED,
    WOUND,
    Y_MODES,
    Z_MODES,
)
from .link import elastic_forces, middle_forces, products, slope_energy, slopes, stiffen
from .turning import add_turning, write_twists


@kernel
def centreline(e, size, z, first, x, own, c):
    """Write the coefficients of the centreline's functions into own[c:] (3, F); x = 1 adds the rest shape.

    z are nodal rows, flat.  Of a mode only the one that is not always zero.
    """
    p, r, m, n, length = 6 * first, 6 * first + 6, 6 * first + 12, size[CENTRELINE], e[LENGTH]
    stretch, h = z[r] - z[p] + x * length, c + size[Y_MODES]
    own[h], own[h + 1], own[h + 2], own[h + 3] = z[p], stretch, z[r] + x * length, stretch
    h += n
    own[h], own[h + 1], own[h + 2], own[h + 3] = hermite(
        z[p + 1], z[p + 5], z[r + 1], z[r + 5], length, e[SHEAR_Z]
    )
    h += n
    own[h], own[h + 1], own[h + 2], own[h + 3] = hermite(
        z[p + 2], -z[p + 4], z[r + 2], -z[r + 4], length, e[SHEAR_Y]
    )
    for i in range(size[AXIALS] + size[Y_MODES] + size[Z_MODES]):
        own[c + size[FUNCTION + 2 * i]] = z[m + i]


@kernel
def rotation(e, size, z, first, own, phi):
    """Write the coefficients of the section's rotation into own[phi:] (3, G); z are nodal rows, flat."""
    p, r, m, n, length = 6 * first, 6 * first + 6, 6 * first + 12, size[ROTATION], e[LENGTH]
    h = phi + size[Y_MODES]
    own[h], own[h + 1], own[h + 2] = z[p + 3], 0.5 * (z[p + 3] + z[r + 3]), z[r + 3]
    h += n
    own[h], own[h + 2] = z[p + 4], z[r + 4]
    own[h + 1] = -middle_rotation(z[p + 2], -z[p + 4], z[r + 2], -z[r + 4], length, e[SHEAR_Y])
    h += n
    own[h], own[h + 2] = z[p + 5], z[r + 5]
    own[h + 1] = middle_rotation(z[p + 1], z[p + 5], z[r + 1], z[r + 5], length, e[SHEAR_Z])
    for i in range(size[AXIALS], size[MODES]):
        own[phi + size[FUNCTION + 2 * i + 1]] = z[m + i]


@kernel
def shape(size, data, own, e, d, first):
    """Write what the displacements d alone decide: coefficients, half gradients of the squared slopes."""
    centreline(e, size, flat(d), first, 1.0, own, size[LINE])
    slopes(size, data, own, 6)
    write_twists(size, flat(d), first, own, size[WOUND])
    if e[INERTIA_Y] + e[INERTIA_Z] > 0.0:
        rotation(e, size, flat(d), first, own, size[TURN])
        n, phi, t = size[ROTATION], size[TURN], size[TURNED]
        products(3, data, size[TURN_GRAM], n, own, phi, t)
        if size[TENSIONS] > 0:
            products(3, data, size[LUMP_GRAM], n, own, phi, size[LUMPS])
        # behind them integrals of phi
        h, k = t + size[Y_MODES], t + 3 * n
        for i in range(3):
            own[k + i] = own[h + i * n] + own[h + i * n + 1] + own[h + i * n + 2]
        write_across(size, own)
        eight_thrice(n, own, phi, 1, n, own, size[ACROSS], 8, own, size[SUMS], 8)


@kernel
def write_across(size, own):
    """Write the rotation's products and those at the elements' ends side by side, function by function."""
    n, t, lump, at = size[ROTATION], size[TURNED], size[LUMPS], size[ACROSS]
    for k in range(n):
        own[at], own[at + 1], own[at + 2] = own[t + k], own[t + n + k], own[t + 2 * n + k]
        own[at + 4], own[at + 5], own[at + 6] = own[lump + k], own[lump + n + k], own[lump + 2 * n + k]
        at += 8


@kernel
def spread(e, size, own, g, force, first):
    """Add forces own[g:] (3, F) on the centreline's functions to those of the ends and the modes, flat."""
    p, r, m, n, length = 6 * first, 6 * first + 6, 6 * first + 12, size[CENTRELINE], e[LENGTH]
    h = g + size[Y_MODES]
    pull = own[h + 1] + own[h + 3]
    force[p] += own[h] - pull
    force[r] += own[h + 2] + pull
    h += n
    w1, t1, w2, t2 = hermite_transpose(own[h], own[h + 1], own[h + 2], own[h + 3], length, e[SHEAR_Z])
    force[p + 1] += w1
    force[p + 5] += t1
    force[r + 1] += w2
    force[r + 5] += t2
    h += n
    w1, t1, w2, t2 = hermite_transpose(own[h], own[h + 1], own[h + 2], own[h + 3], length, e[SHEAR_Y])
    force[p + 2] += w1
    force[p + 4] -= t1
    force[r + 2] += w2
    force[r + 4] -= t2
    for i in range(size[AXIALS] + size[Y_MODES] + size[Z_MODES]):
        force[m + i] += own[g + size[FUNCTION + 2 * i]]


@kernel
def spread_rotation(e, size, own, g, force, first):
    """Add moments own[g:] (3, G) on the rotation's functions to those of the ends and the modes, flat."""
    p, r, m, n, h = 6 * first, 6 * first + 6, 6 * first + 12, size[ROTATION], g + size[Y_MODES]
    force[p + 3] += own[h] + 0.5 * own[h + 1]
    force[r + 3] += own[h + 2] + 0.5 * own[h + 1]
    h += n
    w1, t1, w2, t2 = middle_forces(e, e[SHEAR_Y], -own[h + 1])
    force[p + 2] += w1
    force[p + 4] += own[h] - t1
    force[r + 2] += w2
    force[r + 4] += own[h + 2] - t2
    h += n
    w1, t1, w2, t2 = middle_forces(e, e[SHEAR_Z], own[h + 1])
    force[p + 1] += w1
    force[p + 5] += own[h] + t1
    force[r + 1] += w2
    force[r + 5] += own[h + 2] + t2
    for i in range(size[AXIALS], size[MODES]):
        force[m + i] += own[g + size[FUNCTION + 2 * i + 1]]


@kernel
def turned_frame(f, coriolis):
    """Matrix of the acceleration of a point by its place, row by row, and the vector of that by its rate."""
    w0, w1, w2 = f[0], f[1], f[2]
    x0, x1, x2 = (2.0 * w0, 2.0 * w1, 2.0 * w2) if coriolis else (0.0, 0.0, 0.0)
    return (
        -w1 * w1 - w2 * w2,
        w0 * w1 - f[8],
        w0 * w2 + f[7],
        w0 * w1 + f[8],
        -w0 * w0 - w2 * w2,
        w1 * w2 - f[6],
        w0 * w2 - f[7],
        w1 * w2 + f[6],
        -w0 * w0 - w1 * w1,
        x0,
        x1,
        x2,
    )


@kernel
def leave_out_softening(f, n, own, h, g):
    """spatial_beam.leave_out_softening for components one after the other."""
    w0, w1, w2 = f[0], f[1], f[2]
    square = w0 * w0 + w1 * w1 + w2 * w2
    for k in range(n):
        along = w0 * own[h + k] + w1 * own[h + n + k] + w2 * own[h + 2 * n + k]
        own[g + k] -= along * w0 - square * own[h + k]
        own[g + n + k] -= along * w1 - square * own[h + n + k]
        own[g + 2 * n + k] -= along * w2 - square * own[h + 2 * n + k]


@kernel
def forces(size, data, own, e, f, d, v, a, first, alpha, beta, coriolis, spin, force, wrench):
    """Add inertia, elastic and damping forces of the placed link to nodes, modes and the link's wrench.

    Frame, coriolis and spin as in spatial_beam.inertia_force.
    """
    b00, b01, b02, b10, b11, b12, b20, b21, b22, x0, x1, x2 = turned_frame(f, coriolis)
    n, c, r = size[CENTRELINE], size[LINE], size[MIX]
    x, y, z, out = flat(d), flat(v), flat(a), flat(force)
    ca, g, h = c + 9 * n, c + 12 * n, size[Y_MODES]
    centreline(e, size, y, first, 0.0, own, c + 3 * n)
    centreline(e, size, z, first, 0.0, own, c + 6 * n)
    # by place, rate and acceleration
    own[r], own[r + 1], own[r + 2], own[r + 3], own[r + 4], own[r + 5] = b00, b01, b02, alpha, -x2, x1
    own[r + 9], own[r + 10], own[r + 11], own[r + 12], own[r + 13], own[r + 14] = (
        b10,
        b11,
        b12,
        x2,
        alpha,
        -x0,
    )
    own[r + 18], own[r + 19], own[r + 20], own[r + 21], own[r + 22], own[r + 23] = (
        b20,
        b21,
        b22,
        -x1,
        x0,
        alpha,
    )
    own[r + 6], own[r + 16], own[r + 26] = 1.0, 1.0, 1.0
    mix(3, 9, own, size[MIX], own, c, n, own, ca)
    for k in range(3):
        own[ca + h + k * n] += f[3 + k]
        own[ca + h + k * n + 2] += f[3 + k]
    products(3, data, size[MASS_GRAM], n, own, ca, g)
    for k in range(3):
        wrench[k] += own[g + h + k * n] + own[g + h + k * n + 2]
    mx, my, mz = moments(n, own, c, g)
    wrench[3] += mx
    wrench[4] += my
    wrench[5] += mz
    if not spin:
        centreline(e, size, x, first, 0.0, own, c)
        products(3, data, size[MASS_GRAM], n, own, c, ca)
        leave_out_softening(f, n, own, ca, g)
        centreline(e, size, x, first, 1.0, own, c)
    if size[TENSIONS] > 0:
        stiffen(size, data, own, x, y, first, 6, 1.0, beta, out)
    spread(e, size, own, g, out, first)
    if e[INERTIA_Y] + e[INERTIA_Z] > 0.0:
        section_forces(size, data, own, e, f, y, z, first, alpha, coriolis, spin, out, wrench)
    elif e[POLAR] > 0.0:
        spin_forces(size, data, own, e, f, y, z, first, alpha, coriolis, out, wrench)
    elastic_forces(size, data, own, x, y, first, 6, 1.0, beta, out)
    add_turning(size, data, own, e, x, y, first, 1.0, beta, out)


@kernel
def moments(n, own, c, g):
    """Sum of the cross products of places own[c:] (3, n) and forces own[g:] (3, n)."""
    mx, my, mz = broadcast(0.0), broadcast(0.0), broadcast(0.0)
    less = broadcast(-1.0)
    for k in range(0, n, 4):
        x, y, z = load(own, c + k), load(own, c + n + k), load(own, c + 2 * n + k)
        fx, fy, fz = load(own, g + k), load(own, g + n + k), load(own, g + 2 * n + k)
        away_x, away_y, away_z = multiply(less, fx), multiply(less, fy), multiply(less, fz)
        mx = multiply_add(y, fz, multiply_add(z, away_y, mx))
        my = multiply_add(z, fx, multiply_add(x, away_z, my))
        mz = multiply_add(x, fy, multiply_add(y, away_x, mz))
    return total(mx), total(my), total(mz)


@kernel
def stiffness_product(size, data, own, e, d, y, first, scale, force):
    """Add scale times the stiffness at the placed displacements d times the nodal vector y to the forces.

    The stiffness is the tangent without the axial force's own (geometric) part.
    """
    n, c, g = size[CENTRELINE], size[LINE], size[LINE] + 12 * size[CENTRELINE]
    rows, out = flat(y), flat(force)
    elastic_forces(size, data, own, rows, rows, first, 6, 0.0, scale, out)
    if size[TENSIONS] > 0:
        centreline(e, size, rows, first, 0.0, own, c + 3 * n)
        for k in range(3 * n):
            own[g + k] = 0.0
        stiffen(size, data, own, flat(d), rows, first, 6, 0.0, scale, out)
        spread(e, size, own, g, out, first)
        add_turning(size, data, own, e, flat(d), rows, first, 0.0, scale, out)


@kernel
def section_forces(size, data, own, e, f, v, a, first, alpha, coriolis, spin, force, wrench):
    """Add the inertia forces of the sections' rotation; directors as in spatial_beam.inertia_force.

    All nodal rows are flat.
    """
    b00, b01, b02, b10, b11, b12, b20, b21, b22, x0, x1, x2 = turned_frame(f, coriolis)
    iy, iz, n = e[INERTIA_Y], e[INERTIA_Z], size[ROTATION]
    phi, r, y, t = size[TURN], size[TURN_MIX], size[Y_MODES], size[TURNED]
    pv, pa, moment, made = phi + 3 * n, phi + 6 * n, phi + 9 * n, phi + 12 * n
    rotation(e, size, v, first, own, pv)
    rotation(e, size, a, first, own, pa)
    # inertia forces on the director y by phi, its rate and its acceleration, from (-phi_z, 1, phi_x):
    #   x: -b00 pz + b02 px + x1 vx - alpha vz - az
    #   y: -b10 pz + b12 px - x2 vz - x0 vx
    #   z: -b20 pz + b22 px + x1 vz + alpha vx + ax
    # on the director z, from (phi_y, -phi_x, 1):
    #   x: b00 py - b01 px + x2 vx + alpha vy + ay
    #   y: b10 py - b11 px + x2 vy - alpha vx - ax
    #   z: b20 py - b21 px - x0 vx - x1 vy
    # the moment on phi is (y_z - z_y, z_x, -y_x)
    own[r], own[r + 1], own[r + 2] = iy * b22 + iz * b11, -iz * b10, -iy * b20
    own[r + 3], own[r + 4], own[r + 5], own[r + 6] = (iy + iz) * alpha, -iz * x2, iy * x1, iy + iz
    r += 9
    own[r], own[r + 1], own[r + 3], own[r + 4], own[r + 7] = -iz * b01, iz * b00, iz * x2, iz * alpha, iz
    r += 9
    own[r], own[r + 2], own[r + 3], own[r + 5], own[r + 8] = -iy * b02, iy * b00, -iy * x1, iy * alpha, iy
    mix(3, 9, own, size[TURN_MIX], own, phi, n, own, moment)
    for k in range(moment + y, moment + y + 3):
        own[k] += iy * b21 - iz * b12
        own[k + n] += iz * b02
        own[k + 2 * n] -= iy * b01
    products(3, data, size[TURN_GRAM], n, own, moment, made)
    m0 = m1 = m2 = 0.0
    for k in range(y, y + 3):
        m0 += own[made + k]
        m1 += own[made + n + k]
        m2 += own[made + 2 * n + k]
    # of the directors' own turning: products of phi with itself, its rate and its acceleration
    eight_six(n, own, pv, 1, n, own, size[ACROSS], 8, own, size[SUMS] + 24, 8)
    sx, sy, sz, k, at = t, t + n, t + 2 * n, t + 3 * n, size[SUMS]
    px, py, pz = own[k], own[k + 1], own[k + 2]
    pxx, pxy, pxz, pyy, pzz = own[at], own[at + 1], own[at + 2], own[at + 9], own[at + 18]
    vxx, vyx, vzx, vxy, vyy = own[at + 24], own[at + 25], own[at + 26], own[at + 32], own[at + 33]
    vxz, vzz = own[at + 40], own[at + 42]
    ayx, azx, axy, axz = own[at + 49], own[at + 50], own[at + 56], own[at + 64]
    m0 -= iy * (b12 * pxx - b10 * pxz - x0 * vxx - x2 * vxz + b11 * px)
    m0 -= iz * (b20 * pxy - b21 * pxx - x0 * vxx - x1 * vxy + b22 * px)
    m1 += iy * (b22 * pxz - b20 * pzz + alpha * vzx + x1 * vzz + azx + b21 * pz)
    m1 -= iy * (b00 * pxz - b02 * pxx - x1 * vxx + alpha * vxz + axz - b01 * px)
    m1 -= iz * (b20 * pyy - b21 * pxy - x0 * vyx - x1 * vyy + b22 * py)
    m2 += iz * (b00 * pxy - b01 * pxx + x2 * vxx + alpha * vxy + axy + b02 * px)
    m2 -= iy * (b12 * pxz - b10 * pzz - x0 * vzx - x2 * vzz + b11 * pz)
    m2 += iz * (b10 * pyy - b11 * pxy - alpha * vyx + x2 * vyy - ayx + b12 * py)
    wrench[3] += m0
    wrench[4] += m1
    wrench[5] += m2
    if not spin:
        # without the centrifugal force of what the rotation adds to the directors, (-pz, 0, px), (py, -px, 0)
        w0, w1, w2 = f[0], f[1], f[2]
        square = w0 * w0 + w1 * w1 + w2 * w2
        for k in range(n):
            ux, uy, uz = own[sx + k], own[sy + k], own[sz + k]
            along, across = w2 * ux - w0 * uz, w0 * uy - w1 * ux
            own[made + k] -= iy * (along * w2 - square * ux) - iz * (across * w1 + square * ux)
            own[made + n + k] -= iz * (across * w0 - square * uy)
            own[made + 2 * n + k] += iy * (along * w0 + square * uz)
    if size[TENSIONS] > 0:
        turn_forces(size, data, own, e, f, coriolis, made, wrench)
    spread_rotation(e, size, own, made, force, first)


@kernel
def turn_forces(size, data, own, e, f, coriolis, made, wrench):
    """Add the inertia of the sections' second-order turn (T8) to moments own[made:] (3, G) and wrench.

    section_turn.section_load at the elements' ends, as sums over the functions of the rotation.
    """
    b00, b01, b02, b10, b11, b12, b20, b21, b22, x0, x1, x2 = turned_frame(f, coriolis)
    jy, jz, n, phi, lump = e[INERTIA_Y], e[INERTIA_Z], size[ROTATION], size[TURN], size[LUMPS]
    v, r = phi + 3 * n, lump + 3 * n
    c = r + 2 * n
    own[c], own[c + 1], own[c + 2] = -jy * b11 - jz * b22, jy * b01, jz * b02
    own[c + 3], own[c + 4], own[c + 5] = jy * b01, -jz * b22, 0.5 * (jy * b21 + jz * b12)
    own[c + 6], own[c + 7], own[c + 8] = jz * b02, 0.5 * (jy * b21 + jz * b12), -jy * b11
    add_mix(3, own, c, own, lump, n, own, made)
    # the rate's own products; sums of x, y, z with those of the displacement, the rate, the acceleration
    products(2, data, size[LUMP_GRAM], n, own, v + n, r)
    at = size[SUMS] + 4
    xx, yx, zx = own[at], own[at + 1], own[at + 2]
    yy, yz, zz = own[at + 9], 0.5 * own[at + 10], own[at + 18]
    at += 24
    turning, vyx, vzx = own[at], own[at + 1] + own[at + 8], own[at + 2] + own[at + 16]
    vyz = 0.5 * (own[at + 10] + own[at + 17])
    vyy, vzz = -turning - own[at + 18], -turning - own[at + 9]
    at += 24
    ayx = own[at + 1] + own[at + 8] + 2.0 * dot(n, own, v, own, r)
    azx = own[at + 2] + own[at + 16] + 2.0 * dot(n, own, v, own, r + n)
    ayz = 0.5 * (own[at + 10] + own[at + 17]) + dot(n, own, v + n, own, r + n)
    # what both axes turn by, c2 of y: (yx, yy2, yz), of z: (zx, yz, zz2)
    yy2, zz2 = -0.5 * (xx + zz), -0.5 * (xx + yy)
    px = ayx + x1 * vyz - x2 * vyy + b00 * yx + b01 * yy2 + b02 * yz
    pz = ayz + x0 * vyy - x1 * vyx + b20 * yx + b21 * yy2 + b22 * yz
    qx = azx + x1 * vzz - x2 * vyz + b00 * zx + b01 * yz + b02 * zz2
    qy = ayz + x2 * vzx - x0 * vzz + b10 * zx + b11 * yz + b12 * zz2
    wrench[3] += jy * (pz + yy2 * b21 - yz * b11) + jz * (-qy + yz * b22 - zz2 * b12)
    wrench[4] += jy * (yz * b01 - yx * b21) + jz * (qx + zz2 * b02 - zx * b22)
    wrench[5] += jy * (-px + yx * b11 - yy2 * b01) + jz * (zx * b12 - yz * b02)


@kernel
def spin_forces(size, data, own, e, f, v, a, first, alpha, coriolis, force, wrench):
    """Add the inertia of the sections' spin about the beam alone; all nodal rows are flat."""
    n, pv, pa = size[ROTATION], size[TURN] + 3 * size[ROTATION], size[TURN] + 6 * size[ROTATION]
    made = size[TURN] + 12 * n
    rotation(e, size, v, first, own, pv)
    rotation(e, size, a, first, own, pa)
    y = size[Y_MODES]
    for k in range(n):
        one = 1.0 if y <= k < y + 3 else 0.0
        own[pa + k] = e[POLAR] * (own[pa + k] + alpha * own[pv + k] + f[6] * one)
        own[pa + n + k] = e[POLAR] * ((own[pv + k] if coriolis else 0.0) + f[0] * one)
        own[pa + 2 * n + k] = 0.0
    products(3, data, size[TURN_GRAM], n, own, pa, made)
    turning = 0.0
    for k in range(y, y + 3):
        wrench[3] += own[made + k]
        turning += own[made + n + k]
    wrench[4] += f[2] * turning
    wrench[5] -= f[1] * turning
    for k in range(n):
        own[made + n + k] = 0.0
    spread_rotation(e, size, own, made, force, first)


@kernel
def axial_force(size, data, own, e, d, first):
    """Mean tension of a placed link, N."""
    if size[TENSIONS] == 0:
        return spatial_beam.axial_force(e, d, first + 1)
    return slope_energy(size, data, own, d, first, 6)[1]
