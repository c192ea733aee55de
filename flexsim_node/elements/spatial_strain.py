"""Strains of a beam element in space to second order: what moments, torque and shear stiffen.

With the slopes v', w' of the centreline and the twist x of its sections (section_turn.py), a section's
curvatures in its own axes, and its twist, are to second order (D. H. Hodges & E. H. Dowell, NASA TN D-7818,
1974, for extension alone small)

    k_z = v'' + x w''      k_y = w'' - x v''      t = x' + (w' v'' - v' w'') / 2                     (T6)

An element's cubics have curvatures of two coefficients each, mean and slope along it.  With the differences
c of its end slopes, their mean m, the skew s = chord's slope - m, and the twist's mean x0 and half
difference x1, their products, projected on these two, give the five strains

    A_z = c_z + x0 c_y - 2 (1 - S_y) x1 s_y        D_z = s_z + x0 s_y - x1 c_y / 6
    A_y = c_y - x0 c_z + 2 (1 - S_z) x1 s_z        D_y = s_y - x0 s_z + x1 c_z / 6                   (T7)
    T = 2 x1 + (m_y / 2 + (1 - S_y) s_y) c_z - (m_z / 2 + (1 - S_z) s_z) c_y

with the energy E I_z/l (A_z^2 + 12 (1 - S_z) D_z^2)/2 + ... + G J/l T^2/2; S is Timoshenko's share of shear
(beam.py).  A projection can't lock, and leaves what is of first order in the stress resultants exact.
To first order these are the linear strains; they vanish to second order where the element turns as a body.
"""

from __future__ import annotations

from ..compiled.flat import flat
from ..compiled.kernel import kernel
from ..compiled.weighted_sum import add_twelve_thrice
from .beam import (
    AXIAL,
    BEND_Y,
    BEND_Z,
    HELIX,
    LENGTH,
    SHEAR_Y,
    SHEAR_Z,
    TORSION,
    pull_stiffness,
    squared_helix,
    squared_slope,
)


@kernel
def slopes(e, p, r):
    """c_z, s_z, m_z, c_y, s_y, m_y, x0, x1 (T7) of nodal rows p, r (6,), or of their rates."""
    m_z, m_y = 0.5 * (p[5] + r[5]), -0.5 * (p[4] + r[4])
    return (
        r[5] - p[5],
        (r[1] - p[1]) / e[LENGTH] - m_z,
        m_z,
        p[4] - r[4],
        (r[2] - p[2]) / e[LENGTH] - m_y,
        m_y,
        0.5 * (p[3] + r[3]),
        0.5 * (r[3] - p[3]),
    )


@kernel
def strains(e, c_z, s_z, m_z, c_y, s_y, m_y, x0, x1):
    """A_z, D_z, A_y, D_y, T (T7)."""
    o_z, o_y = 1.0 - e[SHEAR_Z], 1.0 - e[SHEAR_Y]
    return (
        c_z + x0 * c_y - 2.0 * o_y * x1 * s_y,
        s_z + x0 * s_y - x1 * c_y / 6.0,
        c_y - x0 * c_z + 2.0 * o_z * x1 * s_z,
        s_y - x0 * s_z + x1 * c_z / 6.0,
        2.0 * x1 + (0.5 * m_y + o_y * s_y) * c_z - (0.5 * m_z + o_z * s_z) * c_y,
    )


@kernel
def strain_rates(e, at, rate):
    """Rates of the five strains at the slopes `at` (8 numbers) for those of `rate`."""
    o_z, o_y = 1.0 - e[SHEAR_Z], 1.0 - e[SHEAR_Y]
    c_z, s_z, m_z, c_y, s_y, m_y, x0, x1 = at
    cv_z, sv_z, mv_z, cv_y, sv_y, mv_y, xv0, xv1 = rate
    twist = 2.0 * xv1 + (0.5 * mv_y + o_y * sv_y) * c_z + (0.5 * m_y + o_y * s_y) * cv_z
    twist -= (0.5 * mv_z + o_z * sv_z) * c_y + (0.5 * m_z + o_z * s_z) * cv_y
    return (
        cv_z + xv0 * c_y + x0 * cv_y - 2.0 * o_y * (xv1 * s_y + x1 * sv_y),
        sv_z + xv0 * s_y + x0 * sv_y - (xv1 * c_y + x1 * cv_y) / 6.0,
        cv_y - xv0 * c_z - x0 * cv_z + 2.0 * o_z * (xv1 * s_z + x1 * sv_z),
        sv_y - xv0 * s_z - x0 * sv_z + (xv1 * c_z + x1 * cv_z) / 6.0,
        twist,
    )


@kernel
def stresses(e, a_z, d_z, a_y, d_y, twist):
    """Stress resultants that do work on the five strains, N m."""
    k_z, k_y = e[BEND_Z], e[BEND_Y]
    return (
        k_z * a_z,
        12.0 * (1.0 - e[SHEAR_Z]) * k_z * d_z,
        k_y * a_y,
        12.0 * (1.0 - e[SHEAR_Y]) * k_y * d_y,
        e[TORSION] * twist,
    )


@kernel
def add_stress(e, at, stress, scale, fp, fr):
    """Add scale times the nodal forces of the stress resultants at the slopes `at` to fp, fr (6,)."""
    o_z, o_y = 1.0 - e[SHEAR_Z], 1.0 - e[SHEAR_Y]
    c_z, s_z, m_z, c_y, s_y, m_y, x0, x1 = at
    a_z, d_z, a_y, d_y, t = stress
    a_z, d_z, a_y, d_y, t = scale * a_z, scale * d_z, scale * a_y, scale * d_y, scale * t
    on_cz = a_z - x0 * a_y + x1 * d_y / 6.0 + (0.5 * m_y + o_y * s_y) * t
    on_cy = a_y + x0 * a_z - x1 * d_z / 6.0 - (0.5 * m_z + o_z * s_z) * t
    on_sz = d_z - x0 * d_y + o_z * (2.0 * x1 * a_y - c_y * t)
    on_sy = d_y + x0 * d_z - o_y * (2.0 * x1 * a_z - c_z * t)
    on_x0 = a_z * c_y - a_y * c_z + d_z * s_y - d_y * s_z
    on_x1 = 2.0 * (t - o_y * s_y * a_z + o_z * s_z * a_y) + (c_z * d_y - c_y * d_z) / 6.0
    force_z, force_y = on_sz / e[LENGTH], on_sy / e[LENGTH]
    on_mz, on_my = -0.5 * (0.5 * c_y * t + on_sz), 0.5 * (0.5 * c_z * t - on_sy)
    fp[1] -= force_z
    fp[2] -= force_y
    fp[3] += 0.5 * (on_x0 - on_x1)
    fp[4] += on_cy - on_my
    fp[5] += on_mz - on_cz
    fr[1] += force_z
    fr[2] += force_y
    fr[3] += 0.5 * (on_x0 + on_x1)
    fr[4] -= on_my + on_cy
    fr[5] += on_mz + on_cz


@kernel
def turning_energy(e, p, r):
    """What the second order adds to the energy of the linear strains, J; p, r are spatial rows (6,)."""
    at = slopes(e, p, r)
    a_z, d_z, a_y, d_y, t = strains(e, *at)
    c_z, s_z, _, c_y, s_y, _, _, x1 = at
    more = 0.5 * e[BEND_Z] * (a_z - c_z) * (a_z + c_z) + 0.5 * e[BEND_Y] * (a_y - c_y) * (a_y + c_y)
    more += 6.0 * (1.0 - e[SHEAR_Z]) * e[BEND_Z] * (d_z - s_z) * (d_z + s_z)
    more += 6.0 * (1.0 - e[SHEAR_Y]) * e[BEND_Y] * (d_y - s_y) * (d_y + s_y)
    return more + 0.5 * e[TORSION] * (t - 2.0 * x1) * (t + 2.0 * x1)


@kernel
def write_gradient(row, length, on_cz, on_sz, on_mz, on_cy, on_sy, on_my, on_x0, on_x1):
    """Write a strain's gradient by the dofs of (end, start) into row (12,), from that by the slopes."""
    z, y = on_sz / length, on_sy / length
    mean_z, mean_y = 0.5 * (on_mz - on_sz), 0.5 * (on_my - on_sy)
    row[0] = row[6] = 0.0
    row[1], row[7], row[2], row[8] = z, -z, y, -y
    row[3], row[9] = 0.5 * (on_x0 + on_x1), 0.5 * (on_x0 - on_x1)
    row[4], row[10] = -mean_y - on_cy, on_cy - mean_y
    row[5], row[11] = mean_z + on_cz, mean_z - on_cz


@kernel
def add_pulled(e, tension, scale, w):
    """Add scale times the stiffness of a pull to w (12, 12), ordered (node i, node i - 1), upper triangle.

    It is fast where links are light.  A pressure's is left out: it could cost the definiteness.
    """
    if not tension > 0.0:
        return
    pull = scale * tension * e[LENGTH]
    ww, wt, tt, ts = pull_stiffness(pull, e[LENGTH], e[SHEAR_Z])
    w[1, 1] += ww
    w[7, 7] += ww
    w[1, 7] -= ww
    w[1, 5] -= wt
    w[1, 11] -= wt
    w[5, 7] += wt
    w[7, 11] += wt
    w[5, 5] += tt
    w[11, 11] += tt
    w[5, 11] += ts
    ww, wt, tt, ts = pull_stiffness(pull, e[LENGTH], e[SHEAR_Y])
    w[2, 2] += ww
    w[8, 8] += ww
    w[2, 8] -= ww
    w[2, 4] += wt
    w[2, 10] += wt
    w[4, 8] -= wt
    w[8, 10] -= wt
    w[4, 4] += tt
    w[10, 10] += tt
    w[4, 10] += ts
    twist = pull * e[HELIX] / (e[LENGTH] * e[LENGTH])
    w[3, 3] += twist
    w[9, 9] += twist
    w[3, 9] -= twist


@kernel
def iteration_turning(e, p, r, scale, b, w):
    """Add scale times the stiffness of an element to w (12, 12) of (18, 18).

    Of the stiffness of stresses it has a pull's alone.  w is ordered (node i, node i - 1); the scratch b
    (12, 12) gets the strains' gradients, and under them these times the stiffnesses.
    """
    c_z, s_z, m_z, c_y, s_y, m_y, x0, x1 = slopes(e, p, r)
    o_z, o_y, length = 1.0 - e[SHEAR_Z], 1.0 - e[SHEAR_Y], e[LENGTH]
    write_gradient(b[0], length, 1.0, 0.0, 0.0, x0, -2.0 * o_y * x1, 0.0, c_y, -2.0 * o_y * s_y)
    write_gradient(b[1], length, 0.0, 1.0, 0.0, -x1 / 6.0, x0, 0.0, s_y, -c_y / 6.0)
    write_gradient(b[2], length, -x0, 2.0 * o_z * x1, 0.0, 1.0, 0.0, 0.0, -c_z, 2.0 * o_z * s_z)
    write_gradient(b[3], length, x1 / 6.0, -x0, 0.0, 0.0, 1.0, 0.0, -s_z, c_z / 6.0)
    on_cz, on_cy = 0.5 * m_y + o_y * s_y, -0.5 * m_z - o_z * s_z
    write_gradient(b[4], length, on_cz, -o_z * c_y, -0.5 * c_y, on_cy, o_y * c_z, 0.5 * c_z, 0.0, 2.0)
    my, a0, a1, a2, a3 = squared_slope(p[1], p[5], r[1], r[5], length, e[SHEAR_Z])
    mz, b0, b1, b2, b3 = squared_slope(p[2], -p[4], r[2], -r[4], length, e[SHEAR_Y])
    row = b[5]
    mx, c = squared_helix(e, p[3], r[3])
    add_pulled(e, e[AXIAL] * (r[0] - p[0] + 0.5 * length * (mx + my + mz)), scale, w)
    row[0], row[3], row[6], row[9] = 1.0, length * c, -1.0, -length * c
    row[7], row[11], row[1], row[5] = length * a0, length * a1, length * a2, length * a3
    row[8], row[10], row[2], row[4] = length * b0, -length * b1, length * b2, -length * b3
    k_z, k_y = scale * e[BEND_Z], scale * e[BEND_Y]
    for k in range(12):
        b[6, k] = k_z * b[0, k]
        b[7, k] = 12.0 * o_z * k_z * b[1, k]
        b[8, k] = k_y * b[2, k]
        b[9, k] = 12.0 * o_y * k_y * b[3, k]
        b[10, k] = scale * e[TORSION] * b[4, k]
        b[11, k] = scale * e[AXIAL] * b[5, k]
    rows, out = flat(b), flat(w)
    for m in range(0, 12, 3):
        add_twelve_thrice(6, rows, 72 + m, 12, 1, rows, 0, 12, out, 18 * m, 18)
