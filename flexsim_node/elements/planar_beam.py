"""Inertia and elastic forces of a beam element in the plane; see beam.py for the field.

The functions mirror spatial_beam.py for nodal rows (ux, uy, rz) and a link that moves in its x-y plane.
"""

from __future__ import annotations

from ..compiled.kernel import kernel
from .beam import (
    AXIAL,
    BEND_Z,
    INERTIA_Y,
    LENGTH,
    MASS,
    SHEAR_Z,
    START,
    STIFFENING,
    TURNING,
    bending_force,
    hermite,
    hermite_mass,
    hermite_transpose,
    middle_rotation,
    pull_stiffness,
    quadratic_mass,
    shift,
    squared_slope,
)


@kernel
def inertia_force(e, frame, d, v, a, i, alpha, coriolis, spin, force, wrench):
    """Add the element's inertia forces to the nodal forces and to the link's wrench (fx, fy, mz).

    frame, coriolis and spin are as in space: omega (0:3), acceleration of the link's origin (3:6), angular
    (6:9).
    """
    length, s, mass = e[LENGTH], e[SHEAR_Z], e[MASS]
    omega, turn = frame[2], frame[8]
    square = omega * omega
    d0, d1, v0, v1, a0, a1 = d[i - 1], d[i], v[i - 1], v[i], a[i - 1], a[i]
    stretch = length + d1[0] - d0[0]
    x0, x2 = e[START] + d0[0], e[START] + length + d1[0]
    p0, p2, f0, f2 = v0[0], v1[0], a0[0], a1[0]
    stiffened = e[STIFFENING] > 0.0
    if stiffened:
        moved = shift(e, d0[2], d1[2])
        x0, x2 = x0 + moved, x2 + moved
        moved = length * (d1[2] * v1[2] - d0[2] * v0[2]) / 12.0
        p0, p2 = p0 + moved, p2 + moved
        moved = length * (d1[2] * a1[2] - d0[2] * a0[2] + v1[2] * v1[2] - v0[2] * v0[2]) / 12.0
        f0, f2 = f0 + moved, f2 + moved
    y0, y1, y2, y3 = hermite(d0[1], d0[2], d1[1], d1[2], length, s)
    p1 = v1[0] - v0[0]
    q0, q1, q2, q3 = hermite(v0[1], v0[2], v1[1], v1[2], length, s)
    f1 = a1[0] - a0[0]
    h0, h1, h2, h3 = hermite(a0[1], a0[2], a1[1], a1[2], length, s)
    two = 2.0 * omega if coriolis else 0.0
    fx0 = frame[3] - square * x0 - turn * y0 - two * q0 + f0 + alpha * p0
    fx2 = frame[3] - square * x2 - turn * y2 - two * q2 + f2 + alpha * p2
    fx1 = -square * stretch - turn * y1 - two * q1 + f1 + alpha * p1
    fx3 = -square * stretch - turn * y3 - two * q3 + f1 + alpha * p1
    fy0 = frame[4] - square * y0 + turn * x0 + two * p0 + h0 + alpha * q0
    fy2 = frame[4] - square * y2 + turn * x2 + two * p2 + h2 + alpha * q2
    fy1 = -square * y1 + turn * stretch + two * p1 + h1 + alpha * q1
    fy3 = -square * y3 + turn * stretch + two * p1 + h3 + alpha * q3
    gx0, gx1, gx2, gx3 = hermite_mass(mass, fx0, fx1, fx2, fx3)
    gy0, gy1, gy2, gy3 = hermite_mass(mass, fy0, fy1, fy2, fy3)
    wrench[0] += gx0 + gx2
    wrench[1] += gy0 + gy2
    moment = x0 * gy0 + stretch * (gy1 + gy3) + x2 * gy2 - y0 * gx0 - y1 * gx1 - y2 * gx2 - y3 * gx3
    if not spin:
        # on the elastic displacement acts the centrifugal force of the rest shape alone
        x1 = d1[0] - d0[0]
        k0, k1, k2, k3 = hermite_mass(mass, d0[0], x1, d1[0], x1)
        j0, j1, j2, j3 = hermite_mass(mass, y0, y1, y2, y3)
        gx0, gx1, gx2, gx3 = gx0 + square * k0, gx1 + square * k1, gx2 + square * k2, gx3 + square * k3
        gy0, gy1, gy2, gy3 = gy0 + square * j0, gy1 + square * j1, gy2 + square * j2, gy3 + square * j3
    if stiffened:
        pull = length * (gx0 + gx2) / 12.0
        force[i - 1, 2] -= pull * d0[2]
        force[i, 2] += pull * d1[2]
    force[i - 1, 0] += gx0 - gx1 - gx3
    force[i, 0] += gx2 + gx1 + gx3
    w1, t1, w2, t2 = hermite_transpose(gy0, gy1, gy2, gy3, length, s)
    if e[INERTIA_Y] > 0.0:
        # director (-phi, 1)
        j = e[INERTIA_Y] * length
        m0, m2 = d0[2], d1[2]
        m1 = middle_rotation(d0[1], d0[2], d1[1], d1[2], length, s)
        r1 = middle_rotation(v0[1], v0[2], v1[1], v1[2], length, s)
        c1 = middle_rotation(a0[1], a0[2], a1[1], a1[2], length, s)
        r0, r2 = v0[2], v1[2]
        gx0, gx1, gx2 = quadratic_mass(
            j,
            square * m0 - turn - a0[2] - alpha * r0,
            square * m1 - turn - c1 - alpha * r1,
            square * m2 - turn - a1[2] - alpha * r2,
        )
        gy0, gy1, gy2 = quadratic_mass(
            j,
            -square - turn * m0 - two * r0,
            -square - turn * m1 - two * r1,
            -square - turn * m2 - two * r2,
        )
        moment -= m0 * gy0 + m1 * gy1 + m2 * gy2 + gx0 + gx1 + gx2
        if not spin:
            k0, k1, k2 = quadratic_mass(j, m0, m1, m2)
            gx0, gx1, gx2 = gx0 - square * k0, gx1 - square * k1, gx2 - square * k2
        middle = 1.5 * (1.0 - s) * gx1 / length
        w1 += middle
        w2 -= middle
        middle = (0.25 - 0.75 * s) * gx1
        t1 += middle - gx0
        t2 += middle - gx2
        if e[TURNING] > 0.0:
            # to second order the director is (-phi, 1 - phi^2 / 2), half at each end (section_turn.py)
            j *= 0.5
            t1 += j * square * m0
            t2 += j * square * m2
            moment -= j * (turn * (m0 * m0 + m2 * m2) + two * (m0 * r0 + m2 * r2))
    force[i - 1, 1] += w1
    force[i - 1, 2] += t1
    force[i, 1] += w2
    force[i, 2] += t2
    wrench[2] += moment


@kernel
def axial_force(e, d, i):
    """Tension of the element, N."""
    p, r = d[i - 1], d[i]
    tension = e[AXIAL] * (r[0] - p[0])
    if e[STIFFENING] > 0.0:
        mean, _, _, _, _ = squared_slope(p[1], p[2], r[1], r[2], e[LENGTH], e[SHEAR_Z])
        tension += 0.5 * e[AXIAL] * e[LENGTH] * mean
    return tension


@kernel
def elastic_force(e, d, i, force):
    """Add the elastic forces of the nodal displacements d to the nodal forces."""
    p, r, fp, fr = d[i - 1], d[i], force[i - 1], force[i]
    length, s = e[LENGTH], e[SHEAR_Z]
    tension = e[AXIAL] * (r[0] - p[0])
    f0, f1, f2, f3 = bending_force(e[BEND_Z], p[1], p[2], r[1], r[2], length, s)
    if e[STIFFENING] > 0.0:
        mean, b0, b1, b2, b3 = squared_slope(p[1], p[2], r[1], r[2], length, s)
        tension += 0.5 * e[AXIAL] * length * mean
        pull = tension * length
        f0 += pull * b0
        f1 += pull * b1
        f2 += pull * b2
        f3 += pull * b3
    fp[0] -= tension
    fp[1] += f0
    fp[2] += f1
    fr[0] += tension
    fr[1] += f2
    fr[2] += f3


@kernel
def stiffness_product(e, d, y, i, scale, force):
    """Add scale times stiffness at d times the nodal vector y to the nodal forces.

    The stiffness is the tangent without the axial force's own (geometric) part, as in iteration_stiffness.
    """
    p, r, yp, yr, fp, fr = d[i - 1], d[i], y[i - 1], y[i], force[i - 1], force[i]
    length, s = e[LENGTH], e[SHEAR_Z]
    tension = e[AXIAL] * (yr[0] - yp[0])
    f0, f1, f2, f3 = bending_force(e[BEND_Z], yp[1], yp[2], yr[1], yr[2], length, s)
    if e[STIFFENING] > 0.0:
        _, b0, b1, b2, b3 = squared_slope(p[1], p[2], r[1], r[2], length, s)
        tension += e[AXIAL] * length * (b0 * yp[1] + b1 * yp[2] + b2 * yr[1] + b3 * yr[2])
        pull = tension * length
        f0 += pull * b0
        f1 += pull * b1
        f2 += pull * b2
        f3 += pull * b3
    fp[0] -= scale * tension
    fp[1] += scale * f0
    fp[2] += scale * f1
    fr[0] += scale * tension
    fr[1] += scale * f2
    fr[2] += scale * f3


@kernel
def inertia_coupling(e, d, i, coupling, inertia):
    """Write d(force)/d(link acceleration) of both nodes into coupling (6, 3), add to inertia (3, 3)."""
    length, s, mass = e[LENGTH], e[SHEAR_Z], e[MASS]
    d0, d1 = d[i - 1], d[i]
    stretch = length + d1[0] - d0[0]
    x0, x2 = e[START] + d0[0], e[START] + length + d1[0]
    turn0 = turn2 = 0.0
    if e[STIFFENING] > 0.0:
        moved = shift(e, d0[2], d1[2])
        x0, x2 = x0 + moved, x2 + moved
        turn0, turn2 = -length * d0[2] / 12.0, length * d1[2] / 12.0
    y0, y1, y2, y3 = hermite(d0[1], d0[2], d1[1], d1[2], length, s)
    qx0, qx1, qx2, qx3 = hermite_mass(mass, x0, stretch, x2, stretch)
    qy0, qy1, qy2, qy3 = hermite_mass(mass, y0, y1, y2, y3)
    w1, t1, w2, t2 = hermite_transpose(qx0, qx1, qx2, qx3, length, s)
    second = x0 * qx0 + stretch * (qx1 + qx3) + x2 * qx2
    second += y0 * qy0 + y1 * qy1 + y2 * qy2 + y3 * qy3
    inertia[0, 0] += mass
    inertia[1, 1] += mass
    inertia[0, 2] -= qy0 + qy2
    inertia[1, 2] += qx0 + qx2
    if e[INERTIA_Y] > 0.0:
        j = e[INERTIA_Y] * length
        m0, m2 = d0[2], d1[2]
        m1 = middle_rotation(d0[1], d0[2], d1[1], d1[2], length, s)
        g0, g1, g2 = quadratic_mass(j, m0, m1, m2)
        second += j + m0 * g0 + m1 * g1 + m2 * g2
        # e_z x director = (-1, -phi); on phi acts the x-component, turned round
        w1 -= (1.0 - s) * j / length
        w2 += (1.0 - s) * j / length
        middle = (0.25 - 0.75 * s) * j * 2.0 / 3.0
        t1 += j / 6.0 - middle
        t2 += j / 6.0 - middle
        if e[TURNING] > 0.0:
            second -= 0.5 * j * (m0 * m0 + m2 * m2)
    inertia[2, 2] += second
    half, twelfth = 0.5 * mass, mass * length / 12.0
    coupling[0, 0] = half
    coupling[0, 1] = 0.0
    coupling[0, 2] = -(qy0 - qy1 - qy3)
    coupling[1, 0] = 0.0
    coupling[1, 1] = half
    coupling[1, 2] = w1
    coupling[2, 0] = turn0 * mass
    coupling[2, 1] = twelfth
    coupling[2, 2] = t1 - turn0 * (qy0 + qy2)
    coupling[3, 0] = half
    coupling[3, 1] = 0.0
    coupling[3, 2] = -(qy2 + qy1 + qy3)
    coupling[4, 0] = 0.0
    coupling[4, 1] = half
    coupling[4, 2] = w2
    coupling[5, 0] = turn2 * mass
    coupling[5, 1] = -twelfth
    coupling[5, 2] = t2 - turn2 * (qy0 + qy2)


@kernel
def shift_mass(e, d, i, w):
    """Add what the shift of the element's mass adds to its mass matrix to w (6, 6), upper triangle.

    w is ordered (node i, node i - 1).
    """
    half = 0.5 * e[MASS]
    turn2, turn0 = e[LENGTH] * d[i, 2] / 12.0, -e[LENGTH] * d[i - 1, 2] / 12.0
    w[0, 2] += half * turn2
    w[0, 5] += half * turn0
    w[2, 3] += half * turn2
    w[3, 5] += half * turn0
    w[2, 2] += e[MASS] * turn2 * turn2
    w[2, 5] += e[MASS] * turn2 * turn0
    w[5, 5] += e[MASS] * turn0 * turn0


@kernel
def iteration_stiffness(e, d, i, scale, b, w):
    """Add scale times what the stiffening adds to the stiffness at d to w (6, 6), upper triangle.

    w and b (6,), a scratch, are ordered (node i, node i - 1).  Of the axial force's own (geometric) part a
    pull's is in it, which is fast where links are light; a pressure's could cost the definiteness.
    """
    p, r = d[i - 1], d[i]
    length = e[LENGTH]
    mean, b0, b1, b2, b3 = squared_slope(p[1], p[2], r[1], r[2], length, e[SHEAR_Z])
    b[0], b[3] = 1.0, -1.0
    b[4], b[5], b[1], b[2] = length * b0, length * b1, length * b2, length * b3
    k = scale * e[AXIAL]
    for m in range(6):
        for n in range(m, 6):
            w[m, n] += k * b[m] * b[n]
    w[0, 0] -= k
    w[3, 3] -= k
    w[0, 3] += k
    tension = e[AXIAL] * (r[0] - p[0] + 0.5 * length * mean)
    if tension > 0.0:
        ww, wt, tt, ts = pull_stiffness(scale * tension * length, length, e[SHEAR_Z])
        w[1, 1] += ww
        w[4, 4] += ww
        w[1, 4] -= ww
        w[1, 2] -= wt
        w[1, 5] -= wt
        w[2, 4] += wt
        w[4, 5] += wt
        w[2, 2] += tt
        w[5, 5] += tt
        w[2, 5] += ts
