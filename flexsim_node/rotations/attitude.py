"""Finite rotations of a section from its nodal row: matrix, angular velocity, quaternion.

`section_turn` and `section_spin` alone say what the rotational dofs of a row mean: a rotation vector.
"""

from __future__ import annotations

import numpy as np

from ..compiled.kernel import kernel


@kernel
def section_turn(row, out):
    """Rotation matrix (3, 3) of a section with the row (6,) of its displacement, from its axes to a frame's.

    The frame is the link's, or with co-moving frames the element's carrier.
    """
    turn_matrix(row[3:6], out)


@kernel
def section_spin(row, rate, out):
    """Angular velocity (3,) of a section in its frame, in its own axes, from its row and the row's rate."""
    turn_rate(row[3:6], rate[3:6], out)


@kernel
def turn_matrix(r, out):
    """Rotation matrix of the rotation vector r (3,) into out (3, 3) (Rodrigues)."""
    x, y, z = r[0], r[1], r[2]
    square = x * x + y * y + z * z
    if square < 1e-8:
        s, c = 1.0 - square / 6.0, 0.5 - square / 24.0
    else:
        angle = np.sqrt(square)
        s, c = np.sin(angle) / angle, (1.0 - np.cos(angle)) / square
    out[0, 0] = 1.0 - c * (y * y + z * z)
    out[1, 1] = 1.0 - c * (x * x + z * z)
    out[2, 2] = 1.0 - c * (x * x + y * y)
    out[0, 1], out[1, 0] = c * x * y - s * z, c * x * y + s * z
    out[0, 2], out[2, 0] = c * x * z + s * y, c * x * z - s * y
    out[1, 2], out[2, 1] = c * y * z - s * x, c * y * z + s * x


@kernel
def turn_rate(r, rate, out):
    """Angular velocity, in the turned axes, of a rotation vector r (3,) with `rate`: its right Jacobian."""
    square = r[0] * r[0] + r[1] * r[1] + r[2] * r[2]
    if square < 1e-8:
        b, c = 0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0
    else:
        angle = np.sqrt(square)
        b = (1.0 - np.cos(angle)) / square
        c = (angle - np.sin(angle)) / (square * angle)
    s0 = r[1] * rate[2] - r[2] * rate[1]
    s1 = r[2] * rate[0] - r[0] * rate[2]
    s2 = r[0] * rate[1] - r[1] * rate[0]
    out[0] = rate[0] - b * s0 + c * (r[1] * s2 - r[2] * s1)
    out[1] = rate[1] - b * s1 + c * (r[2] * s0 - r[0] * s2)
    out[2] = rate[2] - b * s2 + c * (r[0] * s1 - r[1] * s0)


@kernel
def quaternion(m, out):
    """Quaternion (x, y, z, w), w >= 0, of a rotation matrix (3, 3) (Shepperd, J. Guidance 1 (1978) 223)."""
    trace = m[0, 0] + m[1, 1] + m[2, 2]
    largest, value = 3, trace
    for k in range(3):
        if m[k, k] > value:
            largest, value = k, m[k, k]
    if largest == 3:
        w = np.sqrt(max(1.0 + trace, 0.0))
        scale = 0.5 / w
        out[0] = scale * (m[2, 1] - m[1, 2])
        out[1] = scale * (m[0, 2] - m[2, 0])
        out[2] = scale * (m[1, 0] - m[0, 1])
        out[3] = 0.5 * w
    else:
        i = largest
        j, k = (i + 1) % 3, (i + 2) % 3
        root = np.sqrt(max(1.0 + m[i, i] - m[j, j] - m[k, k], 0.0))
        scale = 0.5 / root
        out[i] = 0.5 * root
        out[j] = scale * (m[j, i] + m[i, j])
        out[k] = scale * (m[k, i] + m[i, k])
        out[3] = scale * (m[k, j] - m[j, k])
    if out[3] < 0.0:
        for k in range(4):
            out[k] = -out[k]
