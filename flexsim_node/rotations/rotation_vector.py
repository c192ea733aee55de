"""Finite rotations by their rotation vector, R = exp([t]x), without trouble at zero.

With s = t . t and c0 = sin(|t|)/|t|, c1 = (1 - cos |t|)/s, c2 = (1 - c0)/s:

    R = (1 - c1 s) 1 + c0 [t]x + c1 t t^T
    T = c0 1 - c1 [t]x + c2 t t^T,    R^T R' = [T t']x,    R' R^T = [T^T t']x

(Rodrigues' formula and its tangent; Geradin & Cardona, Flexible Multibody Dynamics, 2001, chapter 4).
"""

from __future__ import annotations

from math import atan2, cos, sin, sqrt

from ..compiled.kernel import kernel


@kernel
def coefficients(s):
    """c1, c2 and their derivatives by s, of the squared angle s (rad^2)."""
    if s > 1.0:
        angle = sqrt(s)
        c0 = sin(angle) / angle
        c1 = (1.0 - cos(angle)) / s
        c2 = (1.0 - c0) / s
        return c1, c2, (c0 - 2.0 * c1) / (2.0 * s), (c1 - 3.0 * c2) / (2.0 * s)
    # the series of 1/2! - s/4! + s^2/6! ... and 1/3! - s/5! + s^2/7! ..., each term from the one before
    p = 1.0 - s / 132.0 * (1.0 - s / 182.0 * (1.0 - s / 240.0))
    c1 = 0.5 - s / 24.0 * (1.0 - s / 30.0 * (1.0 - s / 56.0 * (1.0 - s / 90.0 * p)))
    p = 1.0 - s / 156.0 * (1.0 - s / 210.0 * (1.0 - s / 272.0))
    c2 = 1.0 / 6.0 - s / 120.0 * (1.0 - s / 42.0 * (1.0 - s / 72.0 * (1.0 - s / 110.0 * p)))
    p = 1.0 - s * 6.0 / 910.0 * (1.0 - s * 7.0 / 1440.0 * (1.0 - s * 8.0 / 2142.0))
    d1 = -1.0 / 24.0 + s / 360.0 * (
        1.0 - s * 3.0 / 112.0 * (1.0 - s * 4.0 / 270.0 * (1.0 - s * 5.0 / 528.0 * p))
    )
    p = 1.0 - s * 6.0 / 1050.0 * (1.0 - s * 7.0 / 1632.0 * (1.0 - s * 8.0 / 2394.0))
    d2 = -1.0 / 120.0 + s / 2520.0 * (
        1.0 - s * 3.0 / 144.0 * (1.0 - s * 4.0 / 330.0 * (1.0 - s * 5.0 / 624.0 * p))
    )
    return c1, c2, d1, d2


@kernel
def write_rotation(t0, t1, t2, s, c1, c2, out):
    """Write R (row-wise) into the first nine entries of out."""
    c0 = 1.0 - c2 * s
    d = 1.0 - c1 * s
    out[0] = d + c1 * t0 * t0
    out[1] = c1 * t0 * t1 - c0 * t2
    out[2] = c1 * t0 * t2 + c0 * t1
    out[3] = c1 * t1 * t0 + c0 * t2
    out[4] = d + c1 * t1 * t1
    out[5] = c1 * t1 * t2 - c0 * t0
    out[6] = c1 * t2 * t0 - c0 * t1
    out[7] = c1 * t2 * t1 + c0 * t0
    out[8] = d + c1 * t2 * t2


@kernel
def rotation_log(r, out):
    """Write the rotation vector of r (nine numbers, row-wise) into out (3,); the angle is at most pi."""
    # the quaternion by its largest component (Shepperd, J. Guid. Control 1 (1978) 223), then atan2
    trace, largest = r[0] + r[4] + r[8], max(r[0], r[4], r[8])
    w, x, y, z = 1.0 + trace, r[7] - r[5], r[2] - r[6], r[3] - r[1]
    if largest > trace:
        a, b, c = r[1] + r[3], r[2] + r[6], r[5] + r[7]
        if largest == r[0]:
            w, x, y, z = x, 1.0 + r[0] - r[4] - r[8], a, b
        elif largest == r[4]:
            w, x, y, z = y, a, 1.0 + r[4] - r[0] - r[8], c
        else:
            w, x, y, z = z, b, c, 1.0 + r[8] - r[0] - r[4]
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    size = sqrt(x * x + y * y + z * z)
    factor = 2.0 * atan2(size, w) / size if size > 1e-150 else 2.0 / w
    out[0], out[1], out[2] = factor * x, factor * y, factor * z
