"""How a section of the ERLS is turned, to second order in its nodal row (docs/theory/second_order.md).

The rotational entries s of a nodal row are those of the rigid links' small rotations to first order.  To
second order (with the effect `centrifugal`) they are the twist and the slopes of the section's normal,
s = (twist, -w', v'), so that inside a link nothing but the strains is curved.  The rotation vector is

    phi = s + s_x (0, s_z, -s_y) / 2                                              (T3)

and the section's axes, images of the beam's, are to second order

    e_x: (1 - (s_y^2 + s_z^2) / 2, s_z, -s_y)
    e_y: (-s_z + s_x s_y, 1 - (s_x^2 + s_z^2) / 2, s_x + s_y s_z / 2)             (T4)
    e_z: (s_y + s_x s_z, -s_x + s_y s_z / 2, 1 - (s_x^2 + s_y^2) / 2)

with the angular velocity s' + (s_y s_z' - s_z s_y') / 2 e_x + s_x' (s_z e_y - s_y e_z)    (T5).
"""

from __future__ import annotations

from ..compiled.kernel import kernel


@kernel
def rotation_vector(s, out):
    """Rotation vector (3,) of the rotational entries s (3,) of a nodal row (T3)."""
    x, y, z = s[0], s[1], s[2]
    out[0], out[1], out[2] = x, y + 0.5 * x * z, z - 0.5 * x * y


@kernel
def rotation_vector_rate(s, rate, out):
    """Its rate for the rate (3,) of s."""
    x, y, z, vx, vy, vz = s[0], s[1], s[2], rate[0], rate[1], rate[2]
    out[0] = vx
    out[1] = vy + 0.5 * (vx * z + x * vz)
    out[2] = vz - 0.5 * (vx * y + x * vy)


@kernel
def moment_on_row(s, m0, m1, m2):
    """Forces on the entries s (3,) of a moment on the section, link's axes: the transpose of (T5)."""
    return m0 + s[2] * m1 - s[1] * m2, m1 - 0.5 * s[2] * m0, m2 + 0.5 * s[1] * m0


@kernel
def carried(second, s, r):
    """(R - 1) r of a point r (3,) of the section that s (3,) turns (T4); linear in s where second is 0."""
    x, y, z = s[0], s[1], s[2]
    h = 0.5 * second
    return (
        -h * (y * y + z * z) * r[0] + (second * x * y - z) * r[1] + (second * x * z + y) * r[2],
        z * r[0] - h * (x * x + z * z) * r[1] + (h * y * z - x) * r[2],
        -y * r[0] + (h * y * z + x) * r[1] - h * (x * x + y * y) * r[2],
    )


@kernel
def carried_rate(second, s, v, r):
    """Its rate for the rate v (3,) of s."""
    x, y, z, vx, vy, vz = second * s[0], second * s[1], second * s[2], v[0], v[1], v[2]
    shared = 0.5 * (vy * z + y * vz)
    return (
        -(y * vy + z * vz) * r[0] + (vx * y + x * vy - vz) * r[1] + (vx * z + x * vz + vy) * r[2],
        vz * r[0] - (x * vx + z * vz) * r[1] + (shared - vx) * r[2],
        -vy * r[0] + (shared + vx) * r[1] - (x * vx + y * vy) * r[2],
    )


@kernel
def carried_acceleration(second, v, r):
    """What is quadratic in the rates in its second rate."""
    xx, yy, zz = second * v[0] * v[0], second * v[1] * v[1], second * v[2] * v[2]
    xy, xz, yz = second * v[0] * v[1], second * v[0] * v[2], second * v[1] * v[2]
    return (
        -(yy + zz) * r[0] + 2.0 * (xy * r[1] + xz * r[2]),
        yz * r[2] - (xx + zz) * r[1],
        yz * r[1] - (xx + yy) * r[2],
    )


@kernel
def force_on_turn(second, s, r, fx, fy, fz):
    """Forces on s of a force (fx, fy, fz) on the point r: the transpose of `carried_rate`."""
    x, y, z = second * s[0], second * s[1], second * s[2]
    shared = 0.5 * (r[2] * fy + r[1] * fz)
    return (
        fx * (y * r[1] + z * r[2]) - fy * (x * r[1] + r[2]) + fz * (r[1] - x * r[2]),
        fx * (x * r[1] + r[2] - y * r[0]) - fz * (r[0] + y * r[2]) + z * shared,
        fx * (x * r[2] - r[1] - z * r[0]) + fy * (r[0] - z * r[1]) + y * shared,
    )


@kernel
def section_load(jy, jz, frame, coriolis, s, v, a, wrench):
    """Inertia of a section's second-order turn: force on s (3,), which is returned; adds to the wrench (6,).

    jy, jz (kg m^2) are the second moments of the section's mass along its y and z.  Its axes turn by
    c2(s), what (T4) has of second order, and their inertia force is jy a_y . dc2_y + jz a_z . dc2_z with the
    accelerations a_y, a_z that the undeformed axes have; the Lagrangian's term is linear in c2, so that the
    elastic mass matrix stays constant (docs/theory/second_order.md, T8).
    """
    w0, w1, w2 = frame[0], frame[1], frame[2]
    b00, b11, b22 = -w1 * w1 - w2 * w2, -w0 * w0 - w2 * w2, -w0 * w0 - w1 * w1
    b01, b10 = w0 * w1 - frame[8], w0 * w1 + frame[8]
    b02, b20 = w0 * w2 + frame[7], w0 * w2 - frame[7]
    b12, b21 = w1 * w2 - frame[6], w1 * w2 + frame[6]
    x, y, z = s[0], s[1], s[2]
    # accelerations of the undeformed axes: (b01, b11, b21) of y, (b02, b12, b22) of z
    shared = 0.5 * (jy * b21 + jz * b12)
    f0 = -(jy * b11 + jz * b22) * x + jy * b01 * y + jz * b02 * z
    f1 = jy * b01 * x - jz * b22 * y + shared * z
    f2 = jz * b02 * x + shared * y - jy * b11 * z
    vx, vy, vz, ax, ay, az = v[0], v[1], v[2], a[0], a[1], a[2]
    # c2 of both axes, their rates and accelerations in the link
    yx, yy, zx, zz, yz = x * y, -0.5 * (x * x + z * z), x * z, -0.5 * (x * x + y * y), 0.5 * y * z
    vyx, vyy, vyz = vx * y + x * vy, -(x * vx + z * vz), 0.5 * (vy * z + y * vz)
    vzx, vzz = vx * z + x * vz, -(x * vx + y * vy)
    ayx, ayz = ax * y + 2.0 * vx * vy + x * ay, 0.5 * (ay * z + 2.0 * vy * vz + y * az)
    azx = ax * z + 2.0 * vx * vz + x * az
    two = 2.0 if coriolis else 0.0
    # their absolute accelerations, of y: (px, ., pz), of z: (qx, qy, .)
    px = ayx + two * (w1 * vyz - w2 * vyy) + b00 * yx + b01 * yy + b02 * yz
    pz = ayz + two * (w0 * vyy - w1 * vyx) + b20 * yx + b21 * yy + b22 * yz
    qx = azx + two * (w1 * vzz - w2 * vyz) + b00 * zx + b01 * yz + b02 * zz
    qy = ayz + two * (w2 * vzx - w0 * vzz) + b10 * zx + b11 * yz + b12 * zz
    wrench[3] += jy * (pz + yy * b21 - yz * b11) + jz * (-qy + yz * b22 - zz * b12)
    wrench[4] += jy * (yz * b01 - yx * b21) + jz * (qx + zz * b02 - zx * b22)
    wrench[5] += jy * (-px + yx * b11 - yy * b01) + jz * (zx * b12 - yz * b02)
    return f0, f1, f2


@kernel
def section_coupling(jy, jz, s, coupling, inertia):
    """Add what `section_load` has by the angular acceleration: coupling (3, 3) of s, and inertia (6, 6)."""
    x, y, z = s[0], s[1], s[2]
    half = 0.5 * (jy - jz)
    coupling[1, 0] += half * z
    coupling[2, 0] += half * y
    coupling[0, 1] += jz * z
    coupling[2, 1] += jz * x
    coupling[0, 2] -= jy * y
    coupling[1, 2] -= jy * x
    yy, zz, yz = -0.5 * (x * x + z * z), -0.5 * (x * x + y * y), 0.5 * y * z
    inertia[3, 3] += 2.0 * (jy * yy + jz * zz)
    inertia[4, 4] += 2.0 * jz * zz
    inertia[5, 5] += 2.0 * jy * yy
    inertia[3, 4] -= jy * x * y
    inertia[3, 5] -= jz * x * z
    inertia[4, 5] -= (jy + jz) * yz
