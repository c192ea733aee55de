"""nodal_motion.py in space: rows are (ux, uy, uz, rx, ry, rz), joints turn, slide or are fixed."""

from __future__ import annotations

import numpy as np

from ...compiled.kernel import kernel
from ...model.chain import (
    ACCELERATION,
    ANGLE,
    ANGULAR,
    AXIS,
    BOW,
    BOWED,
    BY_Q,
    COUNT,
    DISPLACEMENT,
    FIRST,
    FIXED,
    GRAVITY,
    KIND,
    LEVER,
    LINEAR,
    OMEGA,
    PARENT,
    PARENT_AXIS,
    PHI,
    PRISMATIC,
    PSI,
    RATE,
    REVOLUTE,
    ROTATION,
    SLIDE_OVER,
    SPIN,
    START,
    TIP,
    TURN_AXIS,
    TURN_OVER,
    Q,
)
from .dependent_nodes import fold_forces, own_nodes
from .joint_turn import lead, lead_acceleration, to_vector, turn_acceleration, write_lead, write_turn


@kernel
def to_child(f, r):
    """Turn both halves of r (6,) from the parent's body frame into the link's (frame row f)."""
    for h in range(0, 6, 3):
        x, y, z = r[h], r[h + 1], r[h + 2]
        for k in range(3):
            r[h + k] = f[ROTATION + k] * x + f[ROTATION + 3 + k] * y + f[ROTATION + 6 + k] * z


@kernel
def to_parent(f, r):
    """Turn both halves of r (6,) from the link's body frame into the parent's."""
    for h in range(0, 6, 3):
        x, y, z = r[h], r[h + 1], r[h + 2]
        for k in range(3):
            p = ROTATION + 3 * k
            r[h + k] = f[p] * x + f[p + 1] * y + f[p + 2] * z


@kernel
def over(f, at, x, y, z):
    """The vector (x, y, z) of the parent's axes by the matrix at column `at` of frame row f."""
    return (
        f[at] * x + f[at + 3] * y + f[at + 6] * z,
        f[at + 1] * x + f[at + 4] * y + f[at + 7] * z,
        f[at + 2] * x + f[at + 5] * y + f[at + 8] * z,
    )


@kernel
def over_back(f, at, x, y, z):
    """The forces (x, y, z) of the link's axes by that matrix's transpose."""
    return (
        f[at] * x + f[at + 1] * y + f[at + 2] * z,
        f[at + 3] * x + f[at + 4] * y + f[at + 5] * z,
        f[at + 6] * x + f[at + 7] * y + f[at + 8] * z,
    )


@kernel
def place(chain, work, x):
    """Frames and nodal displacements at the unknowns x."""
    link, joint, rotation, frame = chain.link, chain.joint, chain.rotation, work.frame
    d, h = work.node[DISPLACEMENT], 0.5 * chain.setting[SPIN]
    for n in range(link.shape[0]):
        f, a = frame[n], joint[n, AXIS : AXIS + 3]
        kind, parent, first = link[n, KIND], link[n, PARENT], link[n, FIRST]
        q = x[link[n, Q]] if kind != FIXED else 0.0
        angle = joint[n, ANGLE] + (q if kind == REVOLUTE else 0.0)
        cosine, sine = np.cos(angle), np.sin(angle)
        for i in range(3):
            for k in range(3):
                f[ROTATION + 3 * i + k] = (
                    rotation[n, 0, i, k] + cosine * rotation[n, 1, i, k] + sine * rotation[n, 2, i, k]
                )
        r = f[START : START + 6]
        g = f[BY_Q : BY_Q + 6]
        r[:] = 0.0
        g[:] = 0.0
        end = first
        d[end, 3:6] = 0.0
        if parent >= 0:
            end = link[parent, FIRST] + link[parent, COUNT]
            for k in range(6):
                r[k] = d[end, k]
        slide = q if kind == PRISMATIC else 0.0
        s0, s1, s2 = joint[n, PARENT_AXIS], joint[n, PARENT_AXIS + 1], joint[n, PARENT_AXIS + 2]
        f[LEVER], f[LEVER + 1], f[LEVER + 2] = slide * s0, slide * s1, slide * s2
        s_p = d[end, 3:6]
        x0, y0, z0 = to_vector(h, r[3], r[4], r[5])
        if kind == PRISMATIC:
            g[0], g[1], g[2] = lead(h, x0, y0, z0, s0, s1, s2)
            write_lead(h, f, x0, y0, z0, s_p, f[LEVER], f[LEVER + 1], f[LEVER + 2])
            r[0] += slide * g[0]
            r[1] += slide * g[1]
            r[2] += slide * g[2]
        if parent >= 0:
            f[LEVER] += joint[parent, TIP]
        r[3], r[4], r[5] = x0, y0, z0
        to_child(f, r)
        if kind == PRISMATIC:
            to_child(f, g)
        elif kind == REVOLUTE:
            g[0] = r[1] * a[2] - r[2] * a[1]
            g[1] = r[2] * a[0] - r[0] * a[2]
            g[2] = r[0] * a[1] - r[1] * a[0]
        psi = x[link[n, PHI]] if link[n, PHI] >= 0 else 0.0
        f[PSI] = psi
        row = d[first]
        row[0], row[1], row[2] = r[0], r[1], r[2]
        row[3], row[4], row[5] = write_turn(h, f, r[3:6], psi, a, s_p, kind == REVOLUTE)
        own_nodes(chain, n, x, d)
        if joint[n, BOWED] > 0.0:
            # half the squared slope pulls a rigid link's end back
            y0, z0 = row[4], row[5]
            f[BOW], f[BOW + 1] = joint[n, BOWED] * y0, joint[n, BOWED] * z0
            d[first + link[n, COUNT], 0] -= 0.5 * (f[BOW] * y0 + f[BOW + 1] * z0)


@kernel
def nodal_rates(chain, work, y, rows, quadratic, v):
    """Nodal rows of the unknowns' rates (or accelerations) y, at the placed configuration.

    With `quadratic` the terms that are quadratic in the rates v are added: the rows are accelerations then.
    """
    link, joint, frame, d, v_rows = (
        chain.link,
        chain.joint,
        work.frame,
        work.node[DISPLACEMENT],
        work.node[RATE],
    )
    h, still = 0.5 * chain.setting[SPIN], work.row[0, 0:6]
    still[:] = 0.0
    for n in range(link.shape[0]):
        f, a = frame[n], joint[n, AXIS : AXIS + 3]
        kind, parent, first = link[n, KIND], link[n, PARENT], link[n, FIRST]
        u0 = u1 = u2 = s0 = s1 = s2 = 0.0
        end = first
        qd = v[link[n, Q]] if quadratic and kind != FIXED else 0.0
        if parent >= 0:
            end = link[parent, FIRST] + link[parent, COUNT]
            u0, u1, u2 = over(f, ROTATION, rows[end, 0], rows[end, 1], rows[end, 2])
            s0, s1, s2 = over(f, TURN_OVER, rows[end, 3], rows[end, 4], rows[end, 5])
            if kind == PRISMATIC:
                w0, w1, w2 = over(f, SLIDE_OVER, rows[end, 3], rows[end, 4], rows[end, 5])
                u0, u1, u2 = u0 + w0, u1 + w1, u2 + w2
            if quadratic:
                if kind == REVOLUTE:
                    # - 2 qd z x (E^T u') + qd^2 z x (z x u) = (2 E^T u' + qd dr/dq) x z qd
                    w0, w1, w2 = over(f, ROTATION, v_rows[end, 0], v_rows[end, 1], v_rows[end, 2])
                    w0, w1, w2 = (
                        2.0 * w0 + qd * f[BY_Q],
                        2.0 * w1 + qd * f[BY_Q + 1],
                        2.0 * w2 + qd * f[BY_Q + 2],
                    )
                    u0 += qd * (w1 * a[2] - w2 * a[1])
                    u1 += qd * (w2 * a[0] - w0 * a[2])
                    u2 += qd * (w0 * a[1] - w1 * a[0])
                elif kind == PRISMATIC:
                    l0, l1, l2 = f[LEVER] - joint[parent, TIP], f[LEVER + 1], f[LEVER + 2]
                    k0, k1, k2 = joint[n, PARENT_AXIS], joint[n, PARENT_AXIS + 1], joint[n, PARENT_AXIS + 2]
                    w0, w1, w2 = lead_acceleration(
                        h,
                        d[end, 3:6],
                        v_rows[end, 3:6],
                        l0,
                        l1,
                        l2,
                        2.0 * qd * k0,
                        2.0 * qd * k1,
                        2.0 * qd * k2,
                    )
                    w0, w1, w2 = over(f, ROTATION, w0, w1, w2)
                    u0, u1, u2 = u0 + w0, u1 + w1, u2 + w2
        if quadratic:
            s_p, v_p = (d[end, 3:6], v_rows[end, 3:6]) if parent >= 0 else (still[0:3], still[3:6])
            psi_rate = v[link[n, PHI]] if link[n, PHI] >= 0 else 0.0
            turning = qd if kind == REVOLUTE else 0.0
            w0, w1, w2 = turn_acceleration(h, f, s_p, v_p, f[PSI], psi_rate, a, turning)
            s0, s1, s2 = s0 + w0, s1 + w1, s2 + w2
        if kind != FIXED:
            rate = y[link[n, Q]]
            u0, u1, u2 = u0 + rate * f[BY_Q], u1 + rate * f[BY_Q + 1], u2 + rate * f[BY_Q + 2]
            s0, s1, s2 = s0 + rate * f[BY_Q + 3], s1 + rate * f[BY_Q + 4], s2 + rate * f[BY_Q + 5]
        if link[n, PHI] >= 0:
            rate = y[link[n, PHI]]
            s0, s1, s2 = s0 + rate * f[TURN_AXIS], s1 + rate * f[TURN_AXIS + 1], s2 + rate * f[TURN_AXIS + 2]
        row = rows[first]
        row[0], row[1], row[2], row[3], row[4], row[5] = u0, u1, u2, s0, s1, s2
        own_nodes(chain, n, y, rows)
        if joint[n, BOWED] > 0.0:
            back = f[BOW] * s1 + f[BOW + 1] * s2
            if quadratic:
                back += joint[n, BOWED] * (v_rows[first, 4] ** 2 + v_rows[first, 5] ** 2)
            rows[first + link[n, COUNT], 0] -= back


@kernel
def accelerate(chain, work, v, a):
    """Motion of frames and nodes; gravity enters as an acceleration -g of the base."""
    link, joint, frame = chain.link, chain.joint, work.frame
    g = chain.setting
    r = work.row[0, 0:6]
    for n in range(link.shape[0]):
        f = frame[n]
        axis = joint[n, AXIS : AXIS + 3]
        kind, parent = link[n, KIND], link[n, PARENT]
        p0 = p1 = p2 = 0.0
        w0 = w1 = w2 = 0.0
        b0 = b1 = b2 = 0.0
        if parent >= 0:
            fp = frame[parent]
            p0, p1, p2 = fp[LINEAR], fp[LINEAR + 1], fp[LINEAR + 2]
            w0, w1, w2 = fp[OMEGA], fp[OMEGA + 1], fp[OMEGA + 2]
            b0, b1, b2 = fp[ANGULAR], fp[ANGULAR + 1], fp[ANGULAR + 2]
            l0, l1, l2 = f[LEVER], f[LEVER + 1], f[LEVER + 2]
            c0, c1, c2 = w1 * l2 - w2 * l1, w2 * l0 - w0 * l2, w0 * l1 - w1 * l0
            p0 += b1 * l2 - b2 * l1 + w1 * c2 - w2 * c1
            p1 += b2 * l0 - b0 * l2 + w2 * c0 - w0 * c2
            p2 += b0 * l1 - b1 * l0 + w0 * c1 - w1 * c0
        else:
            p0, p1, p2 = -g[GRAVITY], -g[GRAVITY + 1], -g[GRAVITY + 2]
        if kind == PRISMATIC:
            qd, qdd = v[link[n, Q]], a[link[n, Q]]
            s0, s1, s2 = joint[n, PARENT_AXIS], joint[n, PARENT_AXIS + 1], joint[n, PARENT_AXIS + 2]
            p0 += s0 * qdd + 2.0 * qd * (w1 * s2 - w2 * s1)
            p1 += s1 * qdd + 2.0 * qd * (w2 * s0 - w0 * s2)
            p2 += s2 * qdd + 2.0 * qd * (w0 * s1 - w1 * s0)
        r[0], r[1], r[2], r[3], r[4], r[5] = w0, w1, w2, b0, b1, b2
        to_child(f, r)
        w0, w1, w2, b0, b1, b2 = r[0], r[1], r[2], r[3], r[4], r[5]
        if kind == REVOLUTE:
            qd, qdd = v[link[n, Q]], a[link[n, Q]]
            b0 += axis[0] * qdd + qd * (w1 * axis[2] - w2 * axis[1])
            b1 += axis[1] * qdd + qd * (w2 * axis[0] - w0 * axis[2])
            b2 += axis[2] * qdd + qd * (w0 * axis[1] - w1 * axis[0])
            w0 += axis[0] * qd
            w1 += axis[1] * qd
            w2 += axis[2] * qd
        r[0], r[1], r[2] = p0, p1, p2
        to_child(f, r)
        f[OMEGA], f[OMEGA + 1], f[OMEGA + 2] = w0, w1, w2
        f[LINEAR], f[LINEAR + 1], f[LINEAR + 2] = r[0], r[1], r[2]
        f[ANGULAR], f[ANGULAR + 1], f[ANGULAR + 2] = b0, b1, b2
    nodal_rates(chain, work, v, work.node[RATE], False, v)
    nodal_rates(chain, work, a, work.node[ACCELERATION], True, v)


@kernel
def gather(chain, work, out):
    """Add the nodal forces and the links' wrenches, through the transposed map, to the unknowns' forces."""
    link, joint, frame = chain.link, chain.joint, work.frame
    force, wrench, w = work.force, work.wrench, work.row[0, 6:12]
    for n in range(link.shape[0] - 1, -1, -1):
        f, a = frame[n], joint[n, AXIS : AXIS + 3]
        kind, parent, first = link[n, KIND], link[n, PARENT], link[n, FIRST]
        if joint[n, BOWED] > 0.0:
            pull = force[first + link[n, COUNT], 0]
            force[first, 4] -= f[BOW] * pull
            force[first, 5] -= f[BOW + 1] * pull
        fold_forces(chain, n, force, out)
        f0, f1, f2, m0, m1, m2 = force[first]
        for k in range(6):
            w[k] = wrench[n, k]
        if link[n, PHI] >= 0:
            out[link[n, PHI]] += f[TURN_AXIS] * m0 + f[TURN_AXIS + 1] * m1 + f[TURN_AXIS + 2] * m2
        if kind != FIXED:
            total = f[BY_Q] * f0 + f[BY_Q + 1] * f1 + f[BY_Q + 2] * f2
            total += f[BY_Q + 3] * m0 + f[BY_Q + 4] * m1 + f[BY_Q + 5] * m2
            h = 3 if kind == REVOLUTE else 0
            out[link[n, Q]] += total + a[0] * w[h] + a[1] * w[h + 1] + a[2] * w[h + 2]
        if parent >= 0:
            to_parent(f, w)
            l0, l1, l2 = f[LEVER], f[LEVER + 1], f[LEVER + 2]
            w[3] += l1 * w[2] - l2 * w[1]
            w[4] += l2 * w[0] - l0 * w[2]
            w[5] += l0 * w[1] - l1 * w[0]
            m0, m1, m2 = over_back(f, TURN_OVER, m0, m1, m2)
            if kind == PRISMATIC:
                x, y, z = over_back(f, SLIDE_OVER, f0, f1, f2)
                m0, m1, m2 = m0 + x, m1 + y, m2 + z
            f0, f1, f2 = over_back(f, ROTATION, f0, f1, f2)
            r = force[link[parent, FIRST] + link[parent, COUNT]]
            r[0], r[1], r[2], r[3], r[4], r[5] = (
                r[0] + f0,
                r[1] + f1,
                r[2] + f2,
                r[3] + m0,
                r[4] + m1,
                r[5] + m2,
            )
            for k in range(6):
                wrench[parent, k] += w[k]
