"""Inertia and elastic forces of a beam element in space; see beam.py for the field.

The functions work on one element whose nodes are rows i - 1 and i of the nodal arrays
(ux, uy, uz, rx, ry, rz), all in the beam axes of the link.
"""

from __future__ import annotations

from ..compiled.kernel import kernel
from ..rotations.section_turn import section_coupling, section_load
from .beam import (
    AXIAL,
    BEND_Y,
    BEND_Z,
    INERTIA_Y,
    INERTIA_Z,
    LENGTH,
    MASS,
    POLAR,
    SHEAR_Y,
    SHEAR_Z,
    START,
    STIFFENING,
    TORSION,
    TURNING,
    bending_force,
    hermite,
    hermite_mass,
    hermite_transpose,
    middle_rotation,
    quadratic_mass,
    shift,
    squared_helix,
    squared_slope,
)
from .spatial_strain import add_pulled, add_stress, slopes, strain_rates, strains, stresses


@kernel
def centreline(e, p, r, x, c):
    """Write the centreline's coefficients of nodal rows p, r into c (4, 3); x = 1 adds the rest shape."""
    length = e[LENGTH]
    stretch = r[0] - p[0] + x * length
    c[0, 0] = p[0] + x * e[START]
    c[1, 0] = stretch
    c[2, 0] = r[0] + x * (e[START] + length)
    c[3, 0] = stretch
    c[0, 1], c[1, 1], c[2, 1], c[3, 1] = hermite(p[1], p[5], r[1], r[5], length, e[SHEAR_Z])
    c[0, 2], c[1, 2], c[2, 2], c[3, 2] = hermite(p[2], -p[4], r[2], -r[4], length, e[SHEAR_Y])


@kernel
def section_rotation(e, p, r, phi):
    """Write the section's rotation at start, middle, end into phi (3, 3)."""
    length = e[LENGTH]
    for k in range(3):
        phi[0, k] = p[3 + k]
        phi[2, k] = r[3 + k]
    phi[1, 0] = 0.5 * (p[3] + r[3])
    phi[1, 1] = -middle_rotation(p[2], -p[4], r[2], -r[4], length, e[SHEAR_Y])
    phi[1, 2] = middle_rotation(p[1], p[5], r[1], r[5], length, e[SHEAR_Z])


@kernel
def spread(e, g, fp, fr):
    """Add forces g (4, 3) on the centreline's coefficients to the nodal forces fp, fr."""
    length = e[LENGTH]
    pull = g[1, 0] + g[3, 0]
    fp[0] += g[0, 0] - pull
    fr[0] += g[2, 0] + pull
    w1, t1, w2, t2 = hermite_transpose(g[0, 1], g[1, 1], g[2, 1], g[3, 1], length, e[SHEAR_Z])
    fp[1] += w1
    fp[5] += t1
    fr[1] += w2
    fr[5] += t2
    w1, t1, w2, t2 = hermite_transpose(g[0, 2], g[1, 2], g[2, 2], g[3, 2], length, e[SHEAR_Y])
    fp[2] += w1
    fp[4] -= t1
    fr[2] += w2
    fr[4] -= t2


@kernel
def spread_rotation(e, g, fp, fr):
    """Add moments g (3, 3) on the section's rotation (start, middle, end) to the nodal forces."""
    length = e[LENGTH]
    for k in range(3):
        fp[3 + k] += g[0, k]
        fr[3 + k] += g[2, k]
    fp[3] += 0.5 * g[1, 0]
    fr[3] += 0.5 * g[1, 0]
    s = e[SHEAR_Y]
    w = -1.5 * (1.0 - s) * g[1, 1] / length
    t = -(0.25 - 0.75 * s) * g[1, 1]
    fp[2] -= w
    fr[2] += w
    fp[4] += t
    fr[4] += t
    s = e[SHEAR_Z]
    w = 1.5 * (1.0 - s) * g[1, 2] / length
    t = -(0.25 - 0.75 * s) * g[1, 2]
    fp[1] -= w
    fr[1] += w
    fp[5] += t
    fr[5] += t


@kernel
def unrest(e, c):
    """Take the rest shape out of the centreline's coefficients c (4, 3)."""
    c[0, 0] -= e[START]
    c[1, 0] -= e[LENGTH]
    c[2, 0] -= e[START] + e[LENGTH]
    c[3, 0] -= e[LENGTH]


@kernel
def turned_director(phi, y, c):
    """Write what a rotation phi (3,) adds to the section's director y, or z, into c (3,)."""
    if y:
        c[0], c[1], c[2] = -phi[2], 0.0, phi[0]
    else:
        c[0], c[1], c[2] = phi[1], -phi[0], 0.0


@kernel
def leave_out_softening(frame, h, count, g):
    """Take the centrifugal force of displacements (h is mass times them) out of the forces g on them."""
    w0, w1, w2 = frame[0], frame[1], frame[2]
    square = w0 * w0 + w1 * w1 + w2 * w2
    for k in range(count):
        along = w0 * h[k, 0] + w1 * h[k, 1] + w2 * h[k, 2]
        g[k, 0] -= along * w0 - square * h[k, 0]
        g[k, 1] -= along * w1 - square * h[k, 1]
        g[k, 2] -= along * w2 - square * h[k, 2]


@kernel
def inertia_force(e, frame, d, v, a, i, alpha, coriolis, spin, force, wrench, t):
    """Add the element's inertia forces to the nodal forces and to the link's wrench.

    frame holds omega (0:3), the acceleration of the link's origin (3:6) and the angular acceleration
    (6:9); d, v, a are nodal displacements, rates and accelerations; alpha is Rayleigh's mass
    coefficient, which adds alpha c' to c''.  Without `coriolis` 2 omega x c' is left out, without `spin` the
    centrifugal force of the elastic displacement on itself.  t is scratch (30, 3).
    """
    w0, w1, w2 = frame[0], frame[1], frame[2]
    b00, b11, b22 = -w1 * w1 - w2 * w2, -w0 * w0 - w2 * w2, -w0 * w0 - w1 * w1
    b01, b10 = w0 * w1 - frame[8], w0 * w1 + frame[8]
    b02, b20 = w0 * w2 + frame[7], w0 * w2 - frame[7]
    b12, b21 = w1 * w2 - frame[6], w1 * w2 + frame[6]
    c, cv, ca, g = t[0:4], t[4:8], t[8:12], t[12:16]
    centreline(e, d[i - 1], d[i], 1.0, c)
    centreline(e, v[i - 1], v[i], 0.0, cv)
    centreline(e, a[i - 1], a[i], 0.0, ca)
    stiffened = e[STIFFENING] > 0.0
    if stiffened:
        p, r, pv, rv, pa, ra = d[i - 1], d[i], v[i - 1], v[i], a[i - 1], a[i]
        twelfth = e[LENGTH] / 12.0
        moved = shift(e, p[4], r[4]) + shift(e, p[5], r[5])
        c[0, 0] += moved
        c[2, 0] += moved
        moved = twelfth * (r[4] * rv[4] + r[5] * rv[5] - p[4] * pv[4] - p[5] * pv[5])
        cv[0, 0] += moved
        cv[2, 0] += moved
        moved = r[4] * ra[4] + r[5] * ra[5] - p[4] * pa[4] - p[5] * pa[5]
        moved += rv[4] * rv[4] + rv[5] * rv[5] - pv[4] * pv[4] - pv[5] * pv[5]
        ca[0, 0] += twelfth * moved
        ca[2, 0] += twelfth * moved
    for k in range(4):
        x, y, z = c[k, 0], c[k, 1], c[k, 2]
        u, p, q = cv[k, 0], cv[k, 1], cv[k, 2]
        ca[k, 0] += b00 * x + b01 * y + b02 * z + alpha * u
        ca[k, 1] += b10 * x + b11 * y + b12 * z + alpha * p
        ca[k, 2] += b20 * x + b21 * y + b22 * z + alpha * q
        if coriolis:
            ca[k, 0] += 2.0 * (w1 * q - w2 * p)
            ca[k, 1] += 2.0 * (w2 * u - w0 * q)
            ca[k, 2] += 2.0 * (w0 * p - w1 * u)
    for k in range(3):
        ca[0, k] += frame[3 + k]
        ca[2, k] += frame[3 + k]
        g[0, k], g[1, k], g[2, k], g[3, k] = hermite_mass(e[MASS], ca[0, k], ca[1, k], ca[2, k], ca[3, k])
        wrench[k] += g[0, k] + g[2, k]
    for k in range(4):
        wrench[3] += c[k, 1] * g[k, 2] - c[k, 2] * g[k, 1]
        wrench[4] += c[k, 2] * g[k, 0] - c[k, 0] * g[k, 2]
        wrench[5] += c[k, 0] * g[k, 1] - c[k, 1] * g[k, 0]
    if stiffened:
        pull = e[LENGTH] / 12.0 * (g[0, 0] + g[2, 0])
        for k in range(4, 6):
            force[i - 1, k] -= pull * d[i - 1, k]
            force[i, k] += pull * d[i, k]
    if not spin:
        h = t[16:20]
        unrest(e, c)
        for k in range(3):
            h[0, k], h[1, k], h[2, k], h[3, k] = hermite_mass(e[MASS], c[0, k], c[1, k], c[2, k], c[3, k])
        leave_out_softening(frame, h, 4, g)
    spread(e, g, force[i - 1], force[i])

    if e[INERTIA_Y] + e[INERTIA_Z] > 0.0:
        phi, pv, pa, moment = t[0:3], t[3:6], t[6:9], t[9:12]
        fy, fz = t[12:15], t[15:18]
        section_rotation(e, d[i - 1], d[i], phi)
        section_rotation(e, v[i - 1], v[i], pv)
        section_rotation(e, a[i - 1], a[i], pa)
        for k in range(3):
            px, py, pz = phi[k, 0], phi[k, 1], phi[k, 2]
            vx, vy, vz = pv[k, 0], pv[k, 1], pv[k, 2]
            ax, ay, az = pa[k, 0] + alpha * vx, pa[k, 1] + alpha * vy, pa[k, 2] + alpha * vz
            # director y = (-pz, 1, px), director z = (py, -px, 1)
            fy[k, 0] = -b00 * pz + b01 + b02 * px - az
            fy[k, 1] = -b10 * pz + b11 + b12 * px
            fy[k, 2] = -b20 * pz + b21 + b22 * px + ax
            fz[k, 0] = b00 * py - b01 * px + b02 + ay
            fz[k, 1] = b10 * py - b11 * px + b12 - ax
            fz[k, 2] = b20 * py - b21 * px + b22
            if coriolis:
                fy[k, 0] += 2.0 * w1 * vx
                fy[k, 1] -= 2.0 * (w2 * vz + w0 * vx)
                fy[k, 2] += 2.0 * w1 * vz
                fz[k, 0] += 2.0 * w2 * vx
                fz[k, 1] += 2.0 * w2 * vy
                fz[k, 2] -= 2.0 * (w0 * vx + w1 * vy)
        for k in range(3):
            fy[0, k], fy[1, k], fy[2, k] = quadratic_mass(
                e[INERTIA_Y] * e[LENGTH], fy[0, k], fy[1, k], fy[2, k]
            )
            fz[0, k], fz[1, k], fz[2, k] = quadratic_mass(
                e[INERTIA_Z] * e[LENGTH], fz[0, k], fz[1, k], fz[2, k]
            )
        for k in range(3):
            px, py, pz = phi[k, 0], phi[k, 1], phi[k, 2]
            wrench[3] += fy[k, 2] - px * fy[k, 1] - px * fz[k, 2] - fz[k, 1]
            wrench[4] += px * fy[k, 0] + pz * fy[k, 2] + fz[k, 0] - py * fz[k, 2]
            wrench[5] += -pz * fy[k, 1] - fy[k, 0] + py * fz[k, 1] + px * fz[k, 0]
        if not spin:
            director, h = t[18:21], t[21:24]
            for y in range(2):
                for k in range(3):
                    turned_director(phi[k], y == 0, director[k])
                for k in range(3):
                    h[0, k], h[1, k], h[2, k] = quadratic_mass(
                        (e[INERTIA_Y] if y == 0 else e[INERTIA_Z]) * e[LENGTH],
                        director[0, k],
                        director[1, k],
                        director[2, k],
                    )
                leave_out_softening(frame, h, 3, fy if y == 0 else fz)
        for k in range(3):
            moment[k, 0] = fy[k, 2] - fz[k, 1]
            moment[k, 1] = fz[k, 0]
            moment[k, 2] = -fy[k, 0]
        spread_rotation(e, moment, force[i - 1], force[i])
        if e[TURNING] > 0.0:
            # what they turn to second order, half at each end
            jy, jz = 0.5 * e[INERTIA_Y] * e[LENGTH], 0.5 * e[INERTIA_Z] * e[LENGTH]
            for k in range(i - 1, i + 1):
                f0, f1, f2 = section_load(jy, jz, frame, coriolis, d[k, 3:6], v[k, 3:6], a[k, 3:6], wrench)
                force[k, 3] += f0
                force[k, 4] += f1
                force[k, 5] += f2
    elif e[POLAR] > 0.0:
        # the section's spin about the beam alone: T = rho I_p (omega_x + phi_x')^2 / 2
        turning = w0 + (0.5 * (v[i - 1, 3] + v[i, 3]) if coriolis else 0.0)
        turning *= e[POLAR] * e[LENGTH]
        f0 = frame[6] + a[i - 1, 3] + alpha * v[i - 1, 3]
        f1 = frame[6] + a[i, 3] + alpha * v[i, 3]
        j = e[POLAR] * e[LENGTH] / 6.0
        g0, g1 = j * (2.0 * f0 + f1), j * (f0 + 2.0 * f1)
        force[i - 1, 3] += g0
        force[i, 3] += g1
        wrench[3] += g0 + g1
        wrench[4] += w2 * turning
        wrench[5] -= w1 * turning


@kernel
def axial_force(e, d, i):
    """Tension of the element, N."""
    p, r = d[i - 1], d[i]
    tension = e[AXIAL] * (r[0] - p[0])
    if e[STIFFENING] > 0.0:
        my, _, _, _, _ = squared_slope(p[1], p[5], r[1], r[5], e[LENGTH], e[SHEAR_Z])
        mz, _, _, _, _ = squared_slope(p[2], -p[4], r[2], -r[4], e[LENGTH], e[SHEAR_Y])
        mx, _ = squared_helix(e, p[3], r[3])
        tension += 0.5 * e[AXIAL] * e[LENGTH] * (mx + my + mz)
    return tension


@kernel
def elastic_force(e, d, i, force):
    """Add the elastic forces of the nodal displacements d to the nodal forces."""
    p, r, fp, fr = d[i - 1], d[i], force[i - 1], force[i]
    if e[TURNING] > 0.0:
        at = slopes(e, p, r)
        add_stress(e, at, stresses(e, *strains(e, *at)), 1.0, fp, fr)
    else:
        linear_force(e, p, r, 1.0, fp, fr)
    tension = e[AXIAL] * (r[0] - p[0])
    if e[STIFFENING] > 0.0:
        length = e[LENGTH]
        my, a0, a1, a2, a3 = squared_slope(p[1], p[5], r[1], r[5], length, e[SHEAR_Z])
        mz, b0, b1, b2, b3 = squared_slope(p[2], -p[4], r[2], -r[4], length, e[SHEAR_Y])
        mx, c = squared_helix(e, p[3], r[3])
        tension += 0.5 * e[AXIAL] * length * (mx + my + mz)
        add_pull(tension * length, a0, a1, a2, a3, b0, b1, b2, b3, c, fp, fr)
    fp[0] -= tension
    fr[0] += tension


@kernel
def linear_force(e, p, r, scale, fp, fr):
    """Add scale times the forces of bending and torsion of the nodal rows p, r to fp, fr."""
    torque = scale * e[TORSION] * (r[3] - p[3])
    y0, y1, y2, y3 = bending_force(scale * e[BEND_Z], p[1], p[5], r[1], r[5], e[LENGTH], e[SHEAR_Z])
    z0, z1, z2, z3 = bending_force(scale * e[BEND_Y], p[2], -p[4], r[2], -r[4], e[LENGTH], e[SHEAR_Y])
    fp[1] += y0
    fp[2] += z0
    fp[3] -= torque
    fp[4] -= z1
    fp[5] += y1
    fr[1] += y2
    fr[2] += z2
    fr[3] += torque
    fr[4] -= z3
    fr[5] += y3


@kernel
def add_pull(pull, a0, a1, a2, a3, b0, b1, b2, b3, c, fp, fr):
    """Add what a tension does on the squared slopes, by half their gradients: a in y, b in z, c in twist."""
    fp[1] += pull * a0
    fp[2] += pull * b0
    fp[3] -= pull * c
    fp[4] -= pull * b1
    fp[5] += pull * a1
    fr[1] += pull * a2
    fr[2] += pull * b2
    fr[3] += pull * c
    fr[4] -= pull * b3
    fr[5] += pull * a3


@kernel
def stiffness_product(e, d, y, i, scale, force):
    """Add scale times stiffness at d times the nodal vector y to the nodal forces.

    The stiffness is the tangent without the axial force's own (geometric) part, as in iteration_stiffness.
    """
    p, r, yp, yr, fp, fr = d[i - 1], d[i], y[i - 1], y[i], force[i - 1], force[i]
    if e[TURNING] > 0.0:
        at = slopes(e, p, r)
        add_stress(e, at, stresses(e, *strain_rates(e, at, slopes(e, yp, yr))), scale, fp, fr)
    else:
        linear_force(e, yp, yr, scale, fp, fr)
    tension = e[AXIAL] * (yr[0] - yp[0])
    if e[STIFFENING] > 0.0:
        length = e[LENGTH]
        _, a0, a1, a2, a3 = squared_slope(p[1], p[5], r[1], r[5], length, e[SHEAR_Z])
        _, b0, b1, b2, b3 = squared_slope(p[2], -p[4], r[2], -r[4], length, e[SHEAR_Y])
        rate = a0 * yp[1] + a1 * yp[5] + a2 * yr[1] + a3 * yr[5]
        rate += b0 * yp[2] - b1 * yp[4] + b2 * yr[2] - b3 * yr[4]
        _, c = squared_helix(e, p[3], r[3])
        rate += c * (yr[3] - yp[3])
        tension += e[AXIAL] * length * rate
        add_pull(scale * tension * length, a0, a1, a2, a3, b0, b1, b2, b3, c, fp, fr)
    fp[0] -= scale * tension
    fr[0] += scale * tension


@kernel
def inertia_coupling(e, d, i, coupling, inertia, t):
    """Write d(force)/d(link acceleration) of both nodes into coupling (12, 6) and add the link's own.

    inertia (6, 6) is the upper triangle of the mass matrix of (origin, angular) acceleration.
    t is scratch (30, 3).
    """
    coupling[:] = 0.0
    length, mass = e[LENGTH], e[MASS]
    half, twelfth = 0.5 * mass, mass * length / 12.0
    for k in range(3):
        coupling[k, k] = half
        coupling[6 + k, k] = half
        inertia[k, k] += mass
    coupling[5, 1] = twelfth
    coupling[11, 1] = -twelfth
    coupling[4, 2] = -twelfth
    coupling[10, 2] = twelfth
    c, q, g = t[0:4], t[4:8], t[8:12]
    centreline(e, d[i - 1], d[i], 1.0, c)
    stiffened = e[STIFFENING] > 0.0
    if stiffened:
        moved = shift(e, d[i - 1, 4], d[i, 4]) + shift(e, d[i - 1, 5], d[i, 5])
        c[0, 0] += moved
        c[2, 0] += moved
    for k in range(3):
        q[0, k], q[1, k], q[2, k], q[3, k] = hermite_mass(mass, c[0, k], c[1, k], c[2, k], c[3, k])
    sx, sy, sz = q[0, 0] + q[2, 0], q[0, 1] + q[2, 1], q[0, 2] + q[2, 2]
    inertia[0, 4] += sz
    inertia[0, 5] -= sy
    inertia[1, 3] -= sz
    inertia[1, 5] += sx
    inertia[2, 3] += sy
    inertia[2, 4] -= sx
    xx = yy = zz = xy = xz = yz = 0.0
    for k in range(4):
        xx += c[k, 0] * q[k, 0]
        yy += c[k, 1] * q[k, 1]
        zz += c[k, 2] * q[k, 2]
        xy += c[k, 0] * q[k, 1]
        xz += c[k, 0] * q[k, 2]
        yz += c[k, 1] * q[k, 2]
    inertia[3, 3] += yy + zz
    inertia[4, 4] += xx + zz
    inertia[5, 5] += xx + yy
    inertia[3, 4] -= xy
    inertia[3, 5] -= xz
    inertia[4, 5] -= yz
    for k in range(3):
        m, n = (k + 1) % 3, (k + 2) % 3
        for j in range(4):
            g[j, k] = 0.0
            g[j, m] = -q[j, n]
            g[j, n] = q[j, m]
        spread(e, g, coupling[0:6, 3 + k], coupling[6:12, 3 + k])
    if stiffened:
        twelfth = length / 12.0
        for k in range(4, 6):
            p, r = -twelfth * d[i - 1, k], twelfth * d[i, k]
            coupling[k, 0] += p * mass
            coupling[k, 4] += p * sz
            coupling[k, 5] -= p * sy
            coupling[6 + k, 0] += r * mass
            coupling[6 + k, 4] += r * sz
            coupling[6 + k, 5] -= r * sy

    if e[INERTIA_Y] + e[INERTIA_Z] > 0.0:
        phi, dy, dz, qy, qz, moment = t[0:3], t[3:6], t[6:9], t[9:12], t[12:15], t[15:18]
        section_rotation(e, d[i - 1], d[i], phi)
        for k in range(3):
            dy[k, 0], dy[k, 1], dy[k, 2] = -phi[k, 2], 1.0, phi[k, 0]
            dz[k, 0], dz[k, 1], dz[k, 2] = phi[k, 1], -phi[k, 0], 1.0
        for k in range(3):
            qy[0, k], qy[1, k], qy[2, k] = quadratic_mass(e[INERTIA_Y] * length, dy[0, k], dy[1, k], dy[2, k])
            qz[0, k], qz[1, k], qz[2, k] = quadratic_mass(e[INERTIA_Z] * length, dz[0, k], dz[1, k], dz[2, k])
        xx = yy = zz = xy = xz = yz = 0.0
        for k in range(3):
            xx += dy[k, 0] * qy[k, 0] + dz[k, 0] * qz[k, 0]
            yy += dy[k, 1] * qy[k, 1] + dz[k, 1] * qz[k, 1]
            zz += dy[k, 2] * qy[k, 2] + dz[k, 2] * qz[k, 2]
            xy += dy[k, 0] * qy[k, 1] + dz[k, 0] * qz[k, 1]
            xz += dy[k, 0] * qy[k, 2] + dz[k, 0] * qz[k, 2]
            yz += dy[k, 1] * qy[k, 2] + dz[k, 1] * qz[k, 2]
        inertia[3, 3] += yy + zz
        inertia[4, 4] += xx + zz
        inertia[5, 5] += xx + yy
        inertia[3, 4] -= xy
        inertia[3, 5] -= xz
        inertia[4, 5] -= yz
        # moments of e_k x q on phi = (y_z - z_y, z_x, -y_x) of the directors y and z
        # about x: e_x x q = (0, -q_z, q_y)
        for j in range(3):
            moment[j, 0] = qy[j, 1] + qz[j, 2]
            moment[j, 1] = 0.0
            moment[j, 2] = 0.0
        spread_rotation(e, moment, coupling[0:6, 3], coupling[6:12, 3])
        # about y: e_y x q = (q_z, 0, -q_x)
        for j in range(3):
            moment[j, 0] = -qy[j, 0]
            moment[j, 1] = qz[j, 2]
            moment[j, 2] = -qy[j, 2]
        spread_rotation(e, moment, coupling[0:6, 4], coupling[6:12, 4])
        # about z: e_z x q = (-q_y, q_x, 0)
        for j in range(3):
            moment[j, 0] = -qz[j, 0]
            moment[j, 1] = -qz[j, 1]
            moment[j, 2] = qy[j, 1]
        spread_rotation(e, moment, coupling[0:6, 5], coupling[6:12, 5])
        if e[TURNING] > 0.0:
            jy, jz = 0.5 * e[INERTIA_Y] * length, 0.5 * e[INERTIA_Z] * length
            section_coupling(jy, jz, d[i - 1, 3:6], coupling[3:6, 3:6], inertia)
            section_coupling(jy, jz, d[i, 3:6], coupling[9:12, 3:6], inertia)
    elif e[POLAR] > 0.0:
        half = 0.5 * e[POLAR] * length
        coupling[3, 3] += half
        coupling[9, 3] += half
        inertia[3, 3] += 2.0 * half


@kernel
def shift_mass(e, d, i, b, w):
    """Add what the shift of the element's mass adds to its mass matrix to w (12, 12), upper triangle.

    w and b (12,), a scratch, are ordered (node i, node i - 1).
    """
    twelfth = e[LENGTH] / 12.0
    for k in range(12):
        b[k] = 0.0
    b[4], b[5] = twelfth * d[i, 4], twelfth * d[i, 5]
    b[10], b[11] = -twelfth * d[i - 1, 4], -twelfth * d[i - 1, 5]
    half = 0.5 * e[MASS]
    for k in (4, 5, 10, 11):
        w[0, k] += half * b[k]
        if k > 6:
            w[6, k] += half * b[k]
        else:
            w[k, 6] += half * b[k]
        for m in (4, 5, 10, 11):
            if m >= k:
                w[k, m] += e[MASS] * b[k] * b[m]


@kernel
def iteration_stiffness(e, d, i, scale, b, w):
    """Add scale times what the stiffening adds to the stiffness at d to w (12, 12), upper triangle.

    w and b (12,), a scratch, are ordered (node i, node i - 1).  Of the axial force's own (geometric) part a
    pull's is in it (add_pulled).
    """
    p, r = d[i - 1], d[i]
    length = e[LENGTH]
    my, a0, a1, a2, a3 = squared_slope(p[1], p[5], r[1], r[5], length, e[SHEAR_Z])
    mz, b0, b1, b2, b3 = squared_slope(p[2], -p[4], r[2], -r[4], length, e[SHEAR_Y])
    mx, c = squared_helix(e, p[3], r[3])
    add_pulled(e, e[AXIAL] * (r[0] - p[0] + 0.5 * length * (mx + my + mz)), scale, w)
    b[0], b[6], b[3], b[9] = 1.0, -1.0, length * c, -length * c
    b[7], b[11], b[1], b[5] = length * a0, length * a1, length * a2, length * a3
    b[8], b[10], b[2], b[4] = length * b0, -length * b1, length * b2, -length * b3
    k = scale * e[AXIAL]
    for m in range(12):
        for n in range(m, 12):
            w[m, n] += k * b[m] * b[n]
    w[0, 0] -= k
    w[6, 6] -= k
    w[0, 6] += k
