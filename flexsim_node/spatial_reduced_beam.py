"""Forces and inertia coupling of a reduced link in space: spatial_beam.py with the modes' functions added.

Rows first, first + 1 of the nodal arrays are the link's start and end; its modes follow, packed.  size, data,
own as in reduced_link.py; e is the row of the link as one element, t scratch (30, 3).
"""

from __future__ import annotations

from . import spatial_beam
from .beam import INERTIA_Y, INERTIA_Z, LENGTH, POLAR
from .kernel import kernel
from .reduced_chain import (
    AXIALS,
    CENTRELINE,
    MODES,
    ROTATION,
    TENSIONS,
    Y_MODES,
    Z_MODES,
    buffer_places,
    constant_places,
    row_width,
)
from .reduced_link import field, mode_rows, products, slope_energy, stiffen, tension_row


@kernel
def centreline(e, size, rows, first, x, t, c):
    """Write the coefficients of the centreline's functions into c (3 F,); x = 1 adds the rest shape.

    Of a mode only the one that is not always zero.
    """
    n, axial, plane = size[CENTRELINE], size[AXIALS], size[AXIALS] + size[Y_MODES]
    spatial_beam.centreline(e, rows[first], rows[first + 1], x, t)
    for k in range(3):
        for i in range(4):
            c[k * n + i] = t[i, k]
    for i in range(plane + size[Z_MODES]):
        at = 0 if i < axial else (1 if i < plane else 2)
        c[at * n + 4 + i] = rows[first + 2 + i // 6, i % 6]


@kernel
def rotation(e, size, rows, first, t, phi):
    """Write the coefficients of the section's rotation into phi (3 G,)."""
    n, axial, plane = size[ROTATION], size[AXIALS], size[Y_MODES]
    space = plane + size[Z_MODES]
    spatial_beam.section_rotation(e, rows[first], rows[first + 1], t)
    for k in range(3):
        for i in range(3):
            phi[k * n + i] = t[i, k]
        for i in range(3, n):
            phi[k * n + i] = 0.0
    for i in range(size[MODES] - axial):
        at = 2 if i < plane else (1 if i < space else 0)
        phi[at * n + 3 + i] = rows[first + 2 + (axial + i) // 6, (axial + i) % 6]


@kernel
def spread(e, size, g, t, force, first):
    """Add forces g (3 F,) on the centreline's functions to those of the ends and the modes."""
    n, axial, plane = size[CENTRELINE], size[AXIALS], size[AXIALS] + size[Y_MODES]
    for k in range(3):
        for i in range(4):
            t[i, k] = g[k * n + i]
    spatial_beam.spread(e, t, force[first], force[first + 1])
    for i in range(plane + size[Z_MODES]):
        at = 0 if i < axial else (1 if i < plane else 2)
        force[first + 2 + i // 6, i % 6] += g[at * n + 4 + i]


@kernel
def spread_rotation(e, size, g, t, force, first):
    """Add moments g (3 G,) on the rotation's functions to the forces of the ends and the modes."""
    n, axial, plane = size[ROTATION], size[AXIALS], size[Y_MODES]
    space = plane + size[Z_MODES]
    for k in range(3):
        for i in range(3):
            t[i, k] = g[k * n + i]
    spatial_beam.spread_rotation(e, t, force[first], force[first + 1])
    for i in range(size[MODES] - axial):
        at = 2 if i < plane else (1 if i < space else 0)
        force[first + 2 + (axial + i) // 6, (axial + i) % 6] += g[at * n + 3 + i]


@kernel
def leave_out_softening(f, n, h, g):
    """spatial_beam.leave_out_softening for components one after the other."""
    w0, w1, w2 = f[0], f[1], f[2]
    square = w0 * w0 + w1 * w1 + w2 * w2
    for k in range(n):
        along = w0 * h[k] + w1 * h[n + k] + w2 * h[2 * n + k]
        g[k] -= along * w0 - square * h[k]
        g[n + k] -= along * w1 - square * h[n + k]
        g[2 * n + k] -= along * w2 - square * h[2 * n + k]


@kernel
def forces(size, data, own, e, f, d, v, a, first, alpha, beta, coriolis, spin, force, wrench, t):
    """Add inertia, elastic and damping forces of a reduced link to nodes, modes and the link's wrench.

    Frame, coriolis and spin as in spatial_beam.inertia_force.
    """
    w0, w1, w2 = f[0], f[1], f[2]
    b00, b11, b22 = -w1 * w1 - w2 * w2, -w0 * w0 - w2 * w2, -w0 * w0 - w1 * w1
    b01, b10 = w0 * w1 - f[8], w0 * w1 + f[8]
    b02, b20 = w0 * w2 + f[7], w0 * w2 - f[7]
    b12, b21 = w1 * w2 - f[6], w1 * w2 + f[6]
    x0, x1, x2 = (2.0 * w0, 2.0 * w1, 2.0 * w2) if coriolis else (0.0, 0.0, 0.0)
    places, centre, n = constant_places(size, 6), buffer_places(size, 6)[3], size[CENTRELINE]
    mass = data[places[0] : places[1]]
    c, ca = own[centre : centre + 3 * n], own[centre + 9 * n : centre + 12 * n]
    g, r = own[centre + 12 * n : centre + 15 * n], own[centre + 15 * n : centre + 15 * n + 27]
    centreline(e, size, d, first, 1.0, t, c)
    centreline(e, size, v, first, 0.0, t, own[centre + 3 * n : centre + 6 * n])
    centreline(e, size, a, first, 0.0, t, own[centre + 6 * n : centre + 9 * n])
    r[0], r[1], r[2], r[3], r[4], r[5], r[6] = b00, b01, b02, alpha, -x2, x1, 1.0
    r[9], r[10], r[11], r[12], r[13], r[14], r[16] = b10, b11, b12, x2, alpha, -x0, 1.0
    r[18], r[19], r[20], r[21], r[22], r[23], r[26] = b20, b21, b22, -x1, x0, alpha, 1.0
    field(size, own, 6, 3)
    for k in range(3):
        ca[k * n] += f[3 + k]
        ca[k * n + 2] += f[3 + k]
    products(mass, n, 3, ca, g)
    m0 = m1 = m2 = 0.0
    for k in range(n):
        m0 += c[n + k] * g[2 * n + k] - c[2 * n + k] * g[n + k]
        m1 += c[2 * n + k] * g[k] - c[k] * g[2 * n + k]
        m2 += c[k] * g[n + k] - c[n + k] * g[k]
    for k in range(3):
        wrench[k] += g[k * n] + g[k * n + 2]
    wrench[3] += m0
    wrench[4] += m1
    wrench[5] += m2
    if not spin:
        c[1] -= e[LENGTH]
        c[2] -= e[LENGTH]
        c[3] -= e[LENGTH]
        products(mass, n, 3, c, ca)
        leave_out_softening(f, n, ca, g)
    if size[TENSIONS] > 0:
        stiffen(size, data, own, d, v, first, 6, 1.0, beta, force)
    spread(e, size, g, t, force, first)
    if e[INERTIA_Y] + e[INERTIA_Z] > 0.0:
        section_forces(size, data, own, e, f, d, v, a, first, alpha, coriolis, spin, force, wrench, t)
    elif e[POLAR] > 0.0:
        spin_forces(size, data, own, e, f, v, a, first, alpha, coriolis, force, wrench, t)
    spatial_beam.elastic_force(e, d, first + 1, force)
    if beta > 0.0:
        spatial_beam.stiffness_product(e, d, v, first + 1, beta, force)
    for i in range(size[MODES]):
        p, q = first + 2 + i // 6, i % 6
        force[p, q] += data[places[5] + i] * (d[p, q] + beta * v[p, q])


@kernel
def stiffness_product(size, data, own, e, d, y, first, scale, force, t):
    """Add scale times the stiffness at the displacements d times the nodal vector y to the forces.

    The stiffness is the tangent without the axial force's own (geometric) part.
    """
    places, centre, n = constant_places(size, 6), buffer_places(size, 6)[3], size[CENTRELINE]
    spatial_beam.stiffness_product(e, d, y, first + 1, scale, force)
    for i in range(size[MODES]):
        p, q = first + 2 + i // 6, i % 6
        force[p, q] += scale * data[places[5] + i] * y[p, q]
    if size[TENSIONS] > 0:
        g = own[centre + 12 * n : centre + 15 * n]
        centreline(e, size, d, first, 1.0, t, own[centre : centre + 3 * n])
        centreline(e, size, y, first, 0.0, t, own[centre + 3 * n : centre + 6 * n])
        for k in range(3 * n):
            g[k] = 0.0
        stiffen(size, data, own, d, y, first, 6, 0.0, scale, force)
        spread(e, size, g, t, force, first)


@kernel
def section_forces(size, data, own, e, f, d, v, a, first, alpha, coriolis, spin, force, wrench, t):
    """Add the inertia forces of the sections' rotation; directors as in spatial_beam.inertia_force."""
    w0, w1, w2 = f[0], f[1], f[2]
    b00, b11, b22 = -w1 * w1 - w2 * w2, -w0 * w0 - w2 * w2, -w0 * w0 - w1 * w1
    b01, b10 = w0 * w1 - f[8], w0 * w1 + f[8]
    b02, b20 = w0 * w2 + f[7], w0 * w2 - f[7]
    b12, b21 = w1 * w2 - f[6], w1 * w2 + f[6]
    x0, x1, x2 = (2.0 * w0, 2.0 * w1, 2.0 * w2) if coriolis else (0.0, 0.0, 0.0)
    iy, iz, n = e[INERTIA_Y], e[INERTIA_Z], size[ROTATION]
    places, at = constant_places(size, 6), buffer_places(size, 6)[4]
    section = data[places[1] : places[2]]
    phi, pv = own[at : at + 3 * n], own[at + 3 * n : at + 6 * n]
    pa, moment = own[at + 6 * n : at + 9 * n], own[at + 9 * n : at + 12 * n]
    made, spun = own[at + 12 * n : at + 15 * n], own[at + 15 * n : at + 18 * n]
    rotation(e, size, d, first, t, phi)
    rotation(e, size, v, first, t, pv)
    rotation(e, size, a, first, t, pa)
    products(section, n, 3, phi, spun)
    m0 = m1 = m2 = 0.0
    for k in range(n):
        px, py, pz = phi[k], phi[n + k], phi[2 * n + k]
        vx, vy, vz = pv[k], pv[n + k], pv[2 * n + k]
        ax, ay, az = pa[k] + alpha * vx, pa[n + k] + alpha * vy, pa[2 * n + k] + alpha * vz
        one = 1.0 if k < 3 else 0.0
        fy0 = iy * (-b00 * pz + b01 * one + b02 * px + x1 * vx - az)
        fy1 = iy * (-b10 * pz + b11 * one + b12 * px - x2 * vz - x0 * vx)
        fy2 = iy * (-b20 * pz + b21 * one + b22 * px + x1 * vz + ax)
        fz0 = iz * (b00 * py - b01 * px + b02 * one + x2 * vx + ay)
        fz1 = iz * (b10 * py - b11 * px + b12 * one + x2 * vy - ax)
        fz2 = iz * (b20 * py - b21 * px + b22 * one - x0 * vx - x1 * vy)
        moment[k], moment[n + k], moment[2 * n + k] = fy2 - fz1, fz0, -fy0
        sx, sy, sz = spun[k], spun[n + k], spun[2 * n + k]
        m0 -= sx * (fy1 + fz2)
        m1 += sx * fy0 + sz * fy2 - sy * fz2
        m2 += sx * fz0 - sz * fy1 + sy * fz1
    products(section, n, 3, moment, made)
    for k in range(3):
        m0 += made[k]
        m1 += made[n + k]
        m2 += made[2 * n + k]
    wrench[3] += m0
    wrench[4] += m1
    wrench[5] += m2
    if not spin:
        # without the centrifugal force of what the rotation adds to the directors, (-pz, 0, px), (py, -px, 0)
        for k in range(n):
            sx, sy, sz = spun[k], spun[n + k], spun[2 * n + k]
            along, across = w2 * sx - w0 * sz, w0 * sy - w1 * sx
            square = w0 * w0 + w1 * w1 + w2 * w2
            made[k] -= iy * (along * w2 - square * sx) - iz * (across * w1 + square * sx)
            made[n + k] -= iz * (across * w0 - square * sy)
            made[2 * n + k] += iy * (along * w0 + square * sz)
    spread_rotation(e, size, made, t, force, first)


@kernel
def spin_forces(size, data, own, e, f, v, a, first, alpha, coriolis, force, wrench, t):
    """Add the inertia of the sections' spin about the beam alone."""
    n = size[ROTATION]
    places, at = constant_places(size, 6), buffer_places(size, 6)[4]
    pv, pa = own[at + 3 * n : at + 6 * n], own[at + 6 * n : at + 9 * n]
    made = own[at + 12 * n : at + 15 * n]
    rotation(e, size, v, first, t, pv)
    rotation(e, size, a, first, t, pa)
    for k in range(n):
        one = 1.0 if k < 3 else 0.0
        pa[k] = e[POLAR] * (pa[k] + alpha * pv[k] + f[6] * one)
        pa[n + k] = e[POLAR] * ((pv[k] if coriolis else 0.0) + f[0] * one)
        pa[2 * n + k] = 0.0
    products(data[places[1] : places[2]], n, 3, pa, made)
    turning = 0.0
    for k in range(3):
        wrench[3] += made[k]
        turning += made[n + k]
    wrench[4] += f[2] * turning
    wrench[5] -= f[1] * turning
    for k in range(n):
        made[n + k] = 0.0
    spread_rotation(e, size, made, t, force, first)


@kernel
def inertia_coupling(size, data, own, e, d, first, coupling, inertia, t):
    """Write d(force)/d(link acceleration) of both ends into coupling (12, 6), of the modes into their rows.

    The link's own is added to inertia (6, 6), upper triangle.
    """
    places, buffers, n = constant_places(size, 6), buffer_places(size, 6), size[CENTRELINE]
    axial, width, centre = size[AXIALS], row_width(size, 6), buffers[3]
    plane = axial + size[Y_MODES]
    mass = data[places[0] : places[1]]
    c, q, g = own[centre : centre + 3 * n], own[centre + 12 * n : centre + 15 * n], t[0:4]
    centreline(e, size, d, first, 1.0, t, c)
    products(mass, n, 3, c, q)
    coupling[:] = 0.0
    for k in range(3):
        # a unit acceleration along e_k has the coefficients (1, 0, 1, 0)
        for i in range(4):
            for j in range(3):
                g[i, j] = 0.0
            g[i, k] = mass[i] + mass[2 * n + i]
        spatial_beam.spread(e, g, coupling[0:6, k], coupling[6:12, k])
        p, r = (k + 1) % 3, (k + 2) % 3
        for i in range(4):
            g[i, k] = 0.0
            g[i, p] = -q[r * n + i]
            g[i, r] = q[p * n + i]
        spatial_beam.spread(e, g, coupling[0:6, 3 + k], coupling[6:12, 3 + k])
    for i in range(size[MODES]):
        row = own[buffers[0] + i * width + 16 : buffers[0] + i * width + 22]
        for k in range(6):
            row[k] = 0.0
        if i < plane + size[Z_MODES]:
            at = 0 if i < axial else (1 if i < plane else 2)
            p, r = (at + 1) % 3, (at + 2) % 3
            row[at] = mass[4 + i] + mass[2 * n + 4 + i]
            row[3 + p] = q[r * n + 4 + i]
            row[3 + r] = -q[p * n + 4 + i]
    total = mass[0] + 2.0 * mass[2] + mass[2 * n + 2]
    sx, sy, sz = q[0] + q[2], q[n] + q[n + 2], q[2 * n] + q[2 * n + 2]
    for k in range(3):
        inertia[k, k] += total
    inertia[0, 4] += sz
    inertia[0, 5] -= sy
    inertia[1, 3] -= sz
    inertia[1, 5] += sx
    inertia[2, 3] += sy
    inertia[2, 4] -= sx
    xx = yy = zz = xy = xz = yz = 0.0
    for k in range(n):
        xx += c[k] * q[k]
        yy += c[n + k] * q[n + k]
        zz += c[2 * n + k] * q[2 * n + k]
        xy += c[k] * q[n + k]
        xz += c[k] * q[2 * n + k]
        yz += c[n + k] * q[2 * n + k]
    inertia[3, 3] += yy + zz
    inertia[4, 4] += xx + zz
    inertia[5, 5] += xx + yy
    inertia[3, 4] -= xy
    inertia[3, 5] -= xz
    inertia[4, 5] -= yz
    if e[INERTIA_Y] + e[INERTIA_Z] > 0.0:
        section_coupling(size, data, own, e, d, first, coupling, inertia, t)
    elif e[POLAR] > 0.0:
        n = size[ROTATION]
        section = data[places[1] : places[2]]
        g = t[0:3]
        for i in range(3):
            g[i, 0] = e[POLAR] * (section[i] + section[n + i] + section[2 * n + i])
            g[i, 1] = 0.0
            g[i, 2] = 0.0
            inertia[3, 3] += g[i, 0]
        spatial_beam.spread_rotation(e, g, coupling[0:6, 3], coupling[6:12, 3])
        for i in range(plane - axial + size[Z_MODES], size[MODES] - axial):
            one = section[3 + i] + section[n + 3 + i] + section[2 * n + 3 + i]
            own[buffers[0] + (axial + i) * width + 19] += e[POLAR] * one


@kernel
def section_coupling(size, data, own, e, d, first, coupling, inertia, t):
    """The sections' part of inertia_coupling."""
    iy, iz, n = e[INERTIA_Y], e[INERTIA_Z], size[ROTATION]
    places, buffers = constant_places(size, 6), buffer_places(size, 6)
    section, at, width = data[places[1] : places[2]], buffers[4], row_width(size, 6)
    phi, spun = own[at : at + 3 * n], own[at + 15 * n : at + 18 * n]
    axial, plane = size[AXIALS], size[Y_MODES]
    space = plane + size[Z_MODES]
    rotation(e, size, d, first, t, phi)
    products(section, n, 3, phi, spun)
    px = py = pz = 0.0
    for k in range(3):
        px += spun[k]
        py += spun[n + k]
        pz += spun[2 * n + k]
    xx = yy = zz = xy = xz = 0.0
    for k in range(n):
        xx += phi[k] * spun[k]
        yy += phi[n + k] * spun[n + k]
        zz += phi[2 * n + k] * spun[2 * n + k]
        xy += phi[k] * spun[n + k]
        xz += phi[k] * spun[2 * n + k]
    # products of the directors' components: y = (-phi_z, 1, phi_x), z = (phi_y, -phi_x, 1)
    length = e[LENGTH]
    dxx, dyy, dzz = iy * zz + iz * yy, iy * length + iz * xx, iy * xx + iz * length
    inertia[3, 3] += dyy + dzz
    inertia[4, 4] += dxx + dzz
    inertia[5, 5] += dxx + dyy
    inertia[3, 4] += iy * pz + iz * xy
    inertia[3, 5] += iy * xz - iz * py
    inertia[4, 5] += (iz - iy) * px
    # moments of e_k x q on phi = (y_z - z_y, z_x, -y_x) of the directors y and z
    gx, gy, gz = t[0:3], t[3:6], t[6:9]
    for i in range(3 + size[MODES] - axial):
        one = section[i] + section[n + i] + section[2 * n + i]
        sx, sy, sz = spun[i], spun[n + i], spun[2 * n + i]
        if i < 3:
            gx[i, 0], gx[i, 1], gx[i, 2] = (iy + iz) * one, 0.0, 0.0
            gy[i, 0], gy[i, 1], gy[i, 2] = iy * sz, iz * one, -iy * sx
            gz[i, 0], gz[i, 1], gz[i, 2] = -iz * sy, iz * sx, iy * one
            continue
        at = buffers[0] + (axial + i - 3) * width + 19
        if i - 3 < plane:
            own[at + 1] -= iy * sx
            own[at + 2] += iy * one
        elif i - 3 < space:
            own[at + 1] += iz * one
            own[at + 2] += iz * sx
        else:
            own[at] += (iy + iz) * one
            own[at + 1] += iy * sz
            own[at + 2] -= iz * sy
    spatial_beam.spread_rotation(e, gx, coupling[0:6, 3], coupling[6:12, 3])
    spatial_beam.spread_rotation(e, gy, coupling[0:6, 4], coupling[6:12, 4])
    spatial_beam.spread_rotation(e, gz, coupling[0:6, 5], coupling[6:12, 5])


@kernel
def modal_rows(size, data, own, e, d, first, scale, coupling, w, t):
    """Fill in the rows by which a link's modes and tensions are eliminated from the front w, and coupling.

    What the tensions stand for leaves w and the modes' pivots.
    """
    inertia_coupling(size, data, own, e, d, first, coupling, w[12:18, 12:18], t)
    mode_rows(size, data, own, 6, scale)
    if scale == 0.0:
        return
    tension = constant_places(size, 6)[3]
    for j in range(size[TENSIONS]):
        tension_row(size, data, own, e, 6, j, scale * data[tension + j], w)


@kernel
def axial_force(size, data, own, e, d, first, t):
    """Mean tension of a reduced link, N."""
    if size[TENSIONS] == 0:
        return spatial_beam.axial_force(e, d, first + 1)
    centre = buffer_places(size, 6)[3]
    centreline(e, size, d, first, 1.0, t, own[centre : centre + 3 * size[CENTRELINE]])
    return slope_energy(size, data, own, d, first, 6, 1)[1]
