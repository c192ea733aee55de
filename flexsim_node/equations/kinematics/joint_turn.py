"""How the turned end of a link turns the start of the next, to second order (docs/theory/second_order.md).

The section at a link's start is turned by the end of the link before, then about the joint's axis a by the
joint's own elastic rotation psi.  With E the joint's rotation to the parent, s and s_p the rotational entries
of the start's row and of the parent's end (section_turn.py),

    phi_p = s_p + h s_px (0, s_pz, -s_py)
    r = E^T phi_p                                                                  (T9)
    phi = r + psi a + h psi (r x a)
    s = phi - h phi_x (0, phi_z, -phi_y)

where h is 1/2, or 0 without the effect `centrifugal`.  A start that slides along the lever k in the parent's
axes is displaced by phi_p x k + h phi_p x (phi_p x k).
"""

from __future__ import annotations

from ...compiled.kernel import kernel
from ...model.chain import BY_Q, ROTATION, SLIDE_OVER, TURN_AXIS, TURN_OVER


@kernel
def to_vector(h, s0, s1, s2):
    """phi_p (T9) of s_p."""
    return s0, s1 + h * s0 * s2, s2 - h * s0 * s1


@kernel
def to_vector_rate(h, s, v0, v1, v2):
    """Its rate for the rate v of s (3,)."""
    return v0, v1 + h * (v0 * s[2] + s[0] * v2), v2 - h * (v0 * s[1] + s[0] * v1)


@kernel
def to_slopes_rate(h, p0, p1, p2, v0, v1, v2):
    """Rate of s for the rate v of phi = p."""
    return v0, v1 - h * (v0 * p2 + p0 * v2), v2 + h * (v0 * p1 + p0 * v1)


@kernel
def about(h, a, v0, v1, v2):
    """v + h (v x a): rate of phi for the rate v of r, with h psi for h."""
    return (
        v0 + h * (v1 * a[2] - v2 * a[1]),
        v1 + h * (v2 * a[0] - v0 * a[2]),
        v2 + h * (v0 * a[1] - v1 * a[0]),
    )


@kernel
def back(f, v0, v1, v2):
    """E^T v, from the parent's axes to the link's of frame row f."""
    return (
        f[ROTATION] * v0 + f[ROTATION + 3] * v1 + f[ROTATION + 6] * v2,
        f[ROTATION + 1] * v0 + f[ROTATION + 4] * v1 + f[ROTATION + 7] * v2,
        f[ROTATION + 2] * v0 + f[ROTATION + 5] * v1 + f[ROTATION + 8] * v2,
    )


@kernel
def write_turn(h, f, r, psi, a, s_p, turns):
    """Write TURN_OVER, TURN_AXIS and BY_Q of the rotational entries into the frame row f; returns s.

    r (3,) is E^T phi_p, s_p (3,) belongs to the parent's end; ROTATION is in f.  `turns` says whether q does.
    """
    hp = h * psi
    p0, p1, p2 = about(hp, a, r[0], r[1], r[2])
    p0, p1, p2 = p0 + psi * a[0], p1 + psi * a[1], p2 + psi * a[2]
    x, y, z = r[1] * a[2] - r[2] * a[1], r[2] * a[0] - r[0] * a[2], r[0] * a[1] - r[1] * a[0]
    x0, x1, x2 = to_slopes_rate(h, p0, p1, p2, a[0] + h * x, a[1] + h * y, a[2] + h * z)
    f[TURN_AXIS], f[TURN_AXIS + 1], f[TURN_AXIS + 2] = x0, x1, x2
    if turns:
        # dr/dq = r x a
        x, y, z = about(hp, a, x, y, z)
        f[BY_Q + 3], f[BY_Q + 4], f[BY_Q + 5] = to_slopes_rate(h, p0, p1, p2, x, y, z)
    for i in range(3):
        x, y, z = unit_rate(h, s_p, i)
        x, y, z = back(f, x, y, z)
        x, y, z = about(hp, a, x, y, z)
        k = TURN_OVER + 3 * i
        f[k], f[k + 1], f[k + 2] = to_slopes_rate(h, p0, p1, p2, x, y, z)
    return p0, p1 - h * p0 * p2, p2 + h * p0 * p1


@kernel
def unit_rate(h, s, i):
    """Rate of phi_p for a unit rate of s[i]."""
    if i == 0:
        return 1.0, h * s[2], -h * s[1]
    if i == 1:
        return 0.0, 1.0, -h * s[0]
    return 0.0, h * s[0], 1.0


@kernel
def lead(h, x, y, z, k0, k1, k2):
    """Displacement of the end of a lever k that a section turned by (x, y, z) carries."""
    c0, c1, c2 = y * k2 - z * k1, z * k0 - x * k2, x * k1 - y * k0
    return c0 + h * (y * c2 - z * c1), c1 + h * (z * c0 - x * c2), c2 + h * (x * c1 - y * c0)


@kernel
def lead_rate(h, x, y, z, v0, v1, v2, k0, k1, k2):
    """Its rate for the rate v of (x, y, z)."""
    c0, c1, c2 = y * k2 - z * k1, z * k0 - x * k2, x * k1 - y * k0
    e0, e1, e2 = v1 * k2 - v2 * k1, v2 * k0 - v0 * k2, v0 * k1 - v1 * k0
    return (
        e0 + h * (v1 * c2 - v2 * c1 + y * e2 - z * e1),
        e1 + h * (v2 * c0 - v0 * c2 + z * e0 - x * e2),
        e2 + h * (v0 * c1 - v1 * c0 + x * e1 - y * e0),
    )


@kernel
def lead_acceleration(h, s_p, v_p, k0, k1, k2, r0, r1, r2):
    """What is quadratic in its second rate, for the rates v_p of s_p (3,); r is twice the lever's rate."""
    x, y, z = to_vector(h, s_p[0], s_p[1], s_p[2])
    v0, v1, v2 = to_vector_rate(h, s_p, v_p[0], v_p[1], v_p[2])
    a1, a2 = 2.0 * h * v_p[0] * v_p[2], -2.0 * h * v_p[0] * v_p[1]
    e0, e1, e2 = v1 * k2 - v2 * k1, v2 * k0 - v0 * k2, v0 * k1 - v1 * k0
    b0, b1, b2 = lead_rate(h, x, y, z, 0.0, a1, a2, k0, k1, k2)
    c0, c1, c2 = lead_rate(h, x, y, z, v0, v1, v2, r0, r1, r2)
    t = 2.0 * h
    return (
        b0 + c0 + t * (v1 * e2 - v2 * e1),
        b1 + c1 + t * (v2 * e0 - v0 * e2),
        b2 + c2 + t * (v0 * e1 - v1 * e0),
    )


@kernel
def write_lead(h, f, x, y, z, s_p, k0, k1, k2):
    """Write the derivatives of `lead` by s_p (3,), in the link's axes, into SLIDE_OVER of the frame row f."""
    for i in range(3):
        v0, v1, v2 = unit_rate(h, s_p, i)
        d0, d1, d2 = lead_rate(h, x, y, z, v0, v1, v2, k0, k1, k2)
        k = SLIDE_OVER + 3 * i
        f[k], f[k + 1], f[k + 2] = back(f, d0, d1, d2)


@kernel
def turn_acceleration(h, f, s_p, v_p, psi, psi_rate, a, qd):
    """What is quadratic in the second rate of s: in the rates v_p (3,) of s_p (3,), of psi, and qd of q.

    f is the frame row; a (3,) the joint's axis; qd is zero where the joint does not turn.
    """
    x, y, z = to_vector(h, s_p[0], s_p[1], s_p[2])
    r0, r1, r2 = back(f, x, y, z)
    x, y, z = to_vector_rate(h, s_p, v_p[0], v_p[1], v_p[2])
    e0, e1, e2 = back(f, x, y, z)
    q0, q1, q2 = back(f, 0.0, 2.0 * h * v_p[0] * v_p[2], -2.0 * h * v_p[0] * v_p[1])
    # r' = E^T phi_p' + qd r x a, and of r'' what is quadratic: + qd (2 E^T phi_p' + qd r x a) x a
    b0, b1, b2 = qd * (r1 * a[2] - r2 * a[1]), qd * (r2 * a[0] - r0 * a[2]), qd * (r0 * a[1] - r1 * a[0])
    t0, t1, t2 = 2.0 * e0 + b0, 2.0 * e1 + b1, 2.0 * e2 + b2
    q0 += qd * (t1 * a[2] - t2 * a[1])
    q1 += qd * (t2 * a[0] - t0 * a[2])
    q2 += qd * (t0 * a[1] - t1 * a[0])
    e0, e1, e2 = e0 + b0, e1 + b1, e2 + b2
    hp, twice = h * psi, 2.0 * h * psi_rate
    # phi' and the same of phi''
    v0, v1, v2 = about(hp, a, e0, e1, e2)
    w = psi_rate
    v0 += w * (a[0] + h * (r1 * a[2] - r2 * a[1]))
    v1 += w * (a[1] + h * (r2 * a[0] - r0 * a[2]))
    v2 += w * (a[2] + h * (r0 * a[1] - r1 * a[0]))
    q0, q1, q2 = about(hp, a, q0, q1, q2)
    q0 += twice * (e1 * a[2] - e2 * a[1])
    q1 += twice * (e2 * a[0] - e0 * a[2])
    q2 += twice * (e0 * a[1] - e1 * a[0])
    p0, p1, p2 = about(hp, a, r0, r1, r2)
    p0, p1, p2 = p0 + psi * a[0], p1 + psi * a[1], p2 + psi * a[2]
    q0, q1, q2 = to_slopes_rate(h, p0, p1, p2, q0, q1, q2)
    return q0, q1 - 2.0 * h * v0 * v2, q2 + 2.0 * h * v0 * v1
