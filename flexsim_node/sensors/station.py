"""A station on a beam: the section there, how it moves, and how it is strained.

Inside an element the nodal field is exact for loads at the nodes only.  What the inertia of the element
itself (gravity is part of it) and its axial force add between the nodes follows from the equilibrium of the
piece from its start to the station, so that forces and strains are as accurate as at the nodes:

    S_f' = mu p'',    S_m' + c' x S_f = m

S are the stress resultants on a section's positive face, p'' the acceleration against free fall, m the rate
of the section's own angular momentum.
"""

from __future__ import annotations

from ..compiled.kernel import kernel
from ..elements import spatial_beam
from ..elements.beam import (
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
    hermite,
    middle_rotation,
    shift,
    squared_helix,
    squared_slope,
)
from ..elements.spatial_strain import slopes as nodal_slopes
from ..elements.spatial_strain import strain_rates, strains
from ..model.chain import ALPHA, BETA, CORIOLIS, SPIN

GAUSS = 0.3872983346207417  # sqrt(3/5)/2; three points, exact to the fifth degree


@kernel
def interpolate(e, rows, xi, out):
    """Displacement and rotation of the section at xi (0 to 1) into out (6,); rows (2, 6) are the nodes'."""
    p, r, length = rows[0], rows[1], e[LENGTH]
    eta = 1.0 - xi
    out[0] = eta * p[0] + xi * r[0]
    out[3] = eta * p[3] + xi * r[3]
    n1, n3 = xi * eta * eta, -xi * xi * eta
    n0 = eta * eta * (1.0 + 2.0 * xi)
    n2 = 1.0 - n0
    c0, c1, c2, c3 = hermite(p[1], p[5], r[1], r[5], length, e[SHEAR_Z])
    out[1] = n0 * c0 + n1 * c1 + n2 * c2 + n3 * c3
    c0, c1, c2, c3 = hermite(p[2], -p[4], r[2], -r[4], length, e[SHEAR_Y])
    out[2] = n0 * c0 + n1 * c1 + n2 * c2 + n3 * c3
    q0, q1, q2 = eta * (1.0 - 2.0 * xi), 4.0 * xi * eta, xi * (2.0 * xi - 1.0)
    middle = -middle_rotation(p[2], -p[4], r[2], -r[4], length, e[SHEAR_Y])
    out[4] = q0 * p[4] + q1 * middle + q2 * r[4]
    middle = middle_rotation(p[1], p[5], r[1], r[5], length, e[SHEAR_Z])
    out[5] = q0 * p[5] + q1 * middle + q2 * r[5]


@kernel
def slopes(e, rows, xi):
    """Slopes (dy/dx, dz/dx) of the centreline at xi."""
    p, r, length = rows[0], rows[1], e[LENGTH]
    d0 = 6.0 * xi * (xi - 1.0)
    d1, d3 = 1.0 - 4.0 * xi + 3.0 * xi * xi, xi * (3.0 * xi - 2.0)
    c0, c1, c2, c3 = hermite(p[1], p[5], r[1], r[5], length, e[SHEAR_Z])
    y = d0 * (c0 - c2) + d1 * c1 + d3 * c3
    c0, c1, c2, c3 = hermite(p[2], -p[4], r[2], -r[4], length, e[SHEAR_Y])
    z = d0 * (c0 - c2) + d1 * c1 + d3 * c3
    return y / length, z / length


@kernel
def point_acceleration(frame, c, v, a, out):
    """Acceleration against free fall of a point c (3,) of a link, moving in it with v and a, into out."""
    w0, w1, w2 = frame[0], frame[1], frame[2]
    s0, s1, s2 = w1 * c[2] - w2 * c[1], w2 * c[0] - w0 * c[2], w0 * c[1] - w1 * c[0]
    t0, t1, t2 = s0 + 2.0 * v[0], s1 + 2.0 * v[1], s2 + 2.0 * v[2]
    out[0] = frame[3] + a[0] + frame[7] * c[2] - frame[8] * c[1] + w1 * t2 - w2 * t1
    out[1] = frame[4] + a[1] + frame[8] * c[0] - frame[6] * c[2] + w2 * t0 - w0 * t2
    out[2] = frame[5] + a[2] + frame[6] * c[1] - frame[7] * c[0] + w0 * t1 - w1 * t0


@kernel
def inertia_between(e, frame, rows, rates, accelerations, alpha, coriolis, spin, xi, t, out):
    """Add the inertia of an element's part from its start to xi to out (9,).

    out: sum of mu p'' (3), sum of mu p'' times the distance to xi (3), rate of the sections' own angular
    momentum (3).  rows, rates, accelerations are (2, 6); coriolis and spin as in spatial_beam; t is scratch
    (7, 6).
    """
    length = e[LENGTH]
    d, v, a, c, f, g = t[0], t[1], t[2], t[3], t[4], t[5]
    moved = moved_rate = moved_acceleration = 0.0
    if e[STIFFENING] > 0.0:
        # the element's mass moves along with its squared slope (beam.py)
        for k in range(4, 6):
            p, r, pv, rv = rows[0, k], rows[1, k], rates[0, k], rates[1, k]
            moved += shift(e, p, r)
            moved_rate += length / 12.0 * (r * rv - p * pv)
            moved_acceleration += (
                length / 12.0 * (r * accelerations[1, k] - p * accelerations[0, k] + rv * rv - pv * pv)
            )
    for point in range(3):
        at = xi * (0.5 + GAUSS * (point - 1))
        weight = xi * length * (8.0 if point == 1 else 5.0) / 18.0
        interpolate(e, rows, at, d)
        interpolate(e, rates, at, v)
        interpolate(e, accelerations, at, a)
        d[0] += moved
        v[0] += moved_rate
        a[0] += moved_acceleration
        for k in range(6):
            a[k] += alpha * v[k]
            if not coriolis:
                v[k] = 0.0
        c[0], c[1], c[2] = e[START] + at * length + d[0], d[1], d[2]
        point_acceleration(frame, c, v, a, f)
        if not spin:
            towards_axis(frame, d, f)
        mass = weight * e[MASS] / length
        arm = (xi - at) * length
        for k in range(3):
            out[k] += mass * f[k]
            out[3 + k] += arm * mass * f[k]
        if e[INERTIA_Y] + e[INERTIA_Z] > 0.0:
            # directors of the section: images of e_y and e_z under the linear rotation
            c[0], c[1], c[2] = -d[5], 1.0, d[3]
            g[0], g[1], g[2] = -v[5], 0.0, v[3]
            g[3], g[4], g[5] = -a[5], 0.0, a[3]
            director_acceleration(frame, c, g, f)
            if not spin:
                c[1] = 0.0
                towards_axis(frame, c, f)
            out[6] += weight * e[INERTIA_Y] * f[2]
            out[8] -= weight * e[INERTIA_Y] * f[0]
            c[0], c[1], c[2] = d[4], -d[3], 1.0
            g[0], g[1], g[2] = v[4], -v[3], 0.0
            g[3], g[4], g[5] = a[4], -a[3], 0.0
            director_acceleration(frame, c, g, f)
            if not spin:
                c[2] = 0.0
                towards_axis(frame, c, f)
            out[6] -= weight * e[INERTIA_Z] * f[1]
            out[7] += weight * e[INERTIA_Z] * f[0]
        elif e[POLAR] > 0.0:
            out[6] += e[POLAR] * weight * (frame[6] + a[3])


@kernel
def take_part(e, frame, rows, rates, accelerations, setting, part, t, load, out):
    """Take the inertia of an element, from its start to `part`, off the wrench out (6,) about the frame.

    t is scratch (10, 6), load (9,).
    """
    alpha, coriolis, end = setting[ALPHA], setting[CORIOLIS] > 0.0, t[6]
    load[:] = 0.0
    inertia_between(e, frame, rows, rates, accelerations, alpha, coriolis, True, part, t, load)
    interpolate(e, rows, part, end)  # inertia_between sums arms up to there
    e0 = e[START] + part * e[LENGTH] + end[0]
    out[3] -= load[6] + end[1] * load[2] - end[2] * load[1]
    out[4] -= load[7] + end[2] * load[0] - e0 * load[2] + load[5]
    out[5] -= load[8] + e0 * load[1] - end[1] * load[0] - load[4]
    for p in range(3):
        out[p] -= load[p]


@kernel
def towards_axis(frame, u, out):
    """Take omega x (omega x u), of an elastic displacement u (3,), off an acceleration."""
    w0, w1, w2 = frame[0], frame[1], frame[2]
    s0, s1, s2 = w1 * u[2] - w2 * u[1], w2 * u[0] - w0 * u[2], w0 * u[1] - w1 * u[0]
    out[0] -= w1 * s2 - w2 * s1
    out[1] -= w2 * s0 - w0 * s2
    out[2] -= w0 * s1 - w1 * s0


@kernel
def director_acceleration(frame, c, g, out):
    """Second rate of a director c (3,) with rate and acceleration g (6,), as seen in the link's frame."""
    origin0, origin1, origin2 = frame[3], frame[4], frame[5]
    point_acceleration(frame, c, g[0:3], g[3:6], out)
    out[0] -= origin0
    out[1] -= origin1
    out[2] -= origin2


@kernel
def constitutive(e, rows, xi, out):
    """Write what the nodal field says of the section at xi: stress resultants (6,) into out."""
    p, r, length = rows[0], rows[1], e[LENGTH]
    d0, d1, d2 = (4.0 * xi - 3.0) / length, (4.0 - 8.0 * xi) / length, (4.0 * xi - 1.0) / length
    middle_y = -middle_rotation(p[2], -p[4], r[2], -r[4], length, e[SHEAR_Y])
    middle_z = middle_rotation(p[1], p[5], r[1], r[5], length, e[SHEAR_Z])
    bend_y, bend_z = e[BEND_Y] * length, e[BEND_Z] * length
    out[0] = e[AXIAL] * (r[0] - p[0])
    out[1] = -bend_z * 4.0 * (p[5] - 2.0 * middle_z + r[5]) / (length * length)
    out[2] = bend_y * 4.0 * (p[4] - 2.0 * middle_y + r[4]) / (length * length)
    out[3] = e[TORSION] * (r[3] - p[3])
    out[4] = bend_y * (d0 * p[4] + d1 * middle_y + d2 * r[4])
    out[5] = bend_z * (d0 * p[5] + d1 * middle_z + d2 * r[5])


@kernel
def turned_resultants(e, strain, xi, out):
    """Write bending, shear and torsion of the five strains (spatial_strain.py, T7) at xi into out (6,)."""
    a_z, d_z, a_y, d_y, twist = strain
    along = 6.0 * (2.0 * xi - 1.0)
    d_z, d_y = (1.0 - e[SHEAR_Z]) * d_z, (1.0 - e[SHEAR_Y]) * d_y
    out[1], out[2] = 12.0 * e[BEND_Z] * d_z / e[LENGTH], 12.0 * e[BEND_Y] * d_y / e[LENGTH]
    out[3] = e[TORSION] * twist
    out[4], out[5] = -e[BEND_Y] * (a_y - along * d_y), e[BEND_Z] * (a_z - along * d_z)


@kernel
def section_forces(e, frame, rows, rates, accelerations, setting, xi, t, load, scratch, out):
    """Stress resultants at xi on the positive face, section axes, into out (3, 6).

    Each row holds N, Qy, Qz, T, My, Mz: of the strains of the nodal field (times 1), of their rates (times
    beta), and of what the element's own load adds between its nodes.  Scratch: t (10, 6), load (9,), (24, 3).
    """
    length, alpha, beta = e[LENGTH], setting[ALPHA], setting[BETA]
    x = xi * length
    elastic, viscous, between = out[0], out[1], out[2]
    constitutive(e, rows, xi, elastic)
    constitutive(e, rates, xi, viscous)
    if e[TURNING] > 0.0:
        at = nodal_slopes(e, rows[0], rows[1])
        turned_resultants(e, strains(e, *at), xi, elastic)
        turned_resultants(e, strain_rates(e, at, nodal_slopes(e, rates[0], rates[1])), xi, viscous)
    between[:] = 0.0
    start, end, wrench = t[7], t[8], t[9]
    t[7:10] = 0.0
    # nodal forces of the element's inertia at its start, as in the equations
    coriolis, spin = setting[CORIOLIS] > 0.0, setting[SPIN] > 0.0
    spatial_beam.inertia_force(
        e, frame, rows, rates, accelerations, 1, alpha, coriolis, spin, t[7:9], wrench, scratch
    )
    if e[STIFFENING] > 0.0:
        p, r, yp, yr = rows[0], rows[1], rates[0], rates[1]
        my, a0, a1, a2, a3 = squared_slope(p[1], p[5], r[1], r[5], length, e[SHEAR_Z])
        mz, b0, b1, b2, b3 = squared_slope(p[2], -p[4], r[2], -r[4], length, e[SHEAR_Y])
        mx, c = squared_helix(e, p[3], r[3])
        elastic[0] += 0.5 * e[AXIAL] * length * (mx + my + mz)
        rate = a0 * yp[1] + a1 * yp[5] + a2 * yr[1] + a3 * yr[5]
        rate += b0 * yp[2] - b1 * yp[4] + b2 * yr[2] - b3 * yr[4] + c * (yr[3] - yp[3])
        viscous[0] += e[AXIAL] * length * rate
        tension = elastic[0] + beta * viscous[0]
        pull = tension * length
        start[1] += pull * a0
        start[5] += pull * a1
        start[2] += pull * b0
        start[3] -= pull * c
        start[4] -= pull * b1
        here = end
        interpolate(e, rows, xi, here)
        slope_y, slope_z = slopes(e, rows, xi)
        between[1] -= tension * slope_y
        between[2] -= tension * slope_z
        between[4] -= tension * (here[2] - p[2])
        between[5] += tension * (here[1] - p[1])
    load[:] = 0.0
    inertia_between(e, frame, rows, rates, accelerations, alpha, coriolis, spin, xi, t, load)
    for k in range(3):
        between[k] += load[k] - start[k]
        between[3 + k] += load[6 + k] - start[3 + k]
    between[4] += load[5] - x * start[2]
    between[5] += x * start[1] - load[4]
