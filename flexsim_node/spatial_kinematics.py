"""kinematics.py in space: rows are (ux, uy, uz, rx, ry, rz), joints turn, slide or are fixed."""

from __future__ import annotations

import numpy as np

from .chain import (
    ACCELERATION,
    ANGLE,
    ANGULAR,
    AXIS,
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
    RATE,
    REVOLUTE,
    ROTATION,
    START,
    TIP,
    Q,
)
from .dependent_nodes import fold_forces, own_nodes
from .kernel import kernel


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
def write_start(axis, turn, r, row):
    """Write the start row of a link: r (6,) and the joint's own elastic rotation `turn` about its axis."""
    for k in range(3):
        row[k] = r[k]
        row[3 + k] = r[3 + k] + axis[k] * turn


@kernel
def place(chain, work, x):
    """Frames and nodal displacements at the unknowns x."""
    link, joint, rotation, frame = chain.link, chain.joint, chain.rotation, work.frame
    d = work.node[DISPLACEMENT]
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
        if parent >= 0:
            end = link[parent, FIRST] + link[parent, COUNT]
            for k in range(6):
                r[k] = d[end, k]
        slide = q if kind == PRISMATIC else 0.0
        s0, s1, s2 = joint[n, PARENT_AXIS], joint[n, PARENT_AXIS + 1], joint[n, PARENT_AXIS + 2]
        f[LEVER], f[LEVER + 1], f[LEVER + 2] = slide * s0, slide * s1, slide * s2
        if parent >= 0:
            f[LEVER] += joint[parent, TIP]
        if kind == PRISMATIC:
            g[0] = r[4] * s2 - r[5] * s1
            g[1] = r[5] * s0 - r[3] * s2
            g[2] = r[3] * s1 - r[4] * s0
            r[0] += slide * g[0]
            r[1] += slide * g[1]
            r[2] += slide * g[2]
        to_child(f, r)
        if kind == PRISMATIC:
            to_child(f, g)
        elif kind == REVOLUTE:
            for h in range(0, 6, 3):
                g[h] = r[h + 1] * a[2] - r[h + 2] * a[1]
                g[h + 1] = r[h + 2] * a[0] - r[h] * a[2]
                g[h + 2] = r[h] * a[1] - r[h + 1] * a[0]
        turn = x[link[n, PHI]] if link[n, PHI] >= 0 else 0.0
        write_start(a, turn, r, d[first])
        own_nodes(chain, n, x, d)


@kernel
def nodal_rates(chain, work, y, rows, quadratic, v):
    """Nodal rows of the unknowns' rates (or accelerations) y, at the placed configuration.

    With `quadratic` the terms that are quadratic in the rates v are added: the rows are accelerations then.
    """
    link, joint, frame = chain.link, chain.joint, work.frame
    r, w = work.row[0, 0:6], work.row[0, 6:12]
    for n in range(link.shape[0]):
        f, a = frame[n], joint[n, AXIS : AXIS + 3]
        kind, parent, first = link[n, KIND], link[n, PARENT], link[n, FIRST]
        r[:] = 0.0
        if parent >= 0:
            end = link[parent, FIRST] + link[parent, COUNT]
            for k in range(6):
                r[k] = rows[end, k]
            if kind == PRISMATIC:
                lx = f[LEVER] - joint[parent, TIP]
                r[0] += r[4] * f[LEVER + 2] - r[5] * f[LEVER + 1]
                r[1] += r[5] * lx - r[3] * f[LEVER + 2]
                r[2] += r[3] * f[LEVER + 1] - r[4] * lx
            to_child(f, r)
            if quadratic and kind != FIXED:
                qd = v[link[n, Q]]
                for k in range(6):
                    w[k] = work.node[RATE, end, k]
                if kind == REVOLUTE:
                    # - 2 qd z x (E^T u') + qd^2 z x (z x u) = - qd z x (2 E^T u' + qd dr/dq)
                    to_child(f, w)
                    for h in range(0, 6, 3):
                        x = 2.0 * w[h] + qd * f[BY_Q + h]
                        y1 = 2.0 * w[h + 1] + qd * f[BY_Q + h + 1]
                        z = 2.0 * w[h + 2] + qd * f[BY_Q + h + 2]
                        r[h] -= qd * (a[1] * z - a[2] * y1)
                        r[h + 1] -= qd * (a[2] * x - a[0] * z)
                        r[h + 2] -= qd * (a[0] * y1 - a[1] * x)
                else:
                    s0, s1, s2 = (
                        joint[n, PARENT_AXIS],
                        joint[n, PARENT_AXIS + 1],
                        joint[n, PARENT_AXIS + 2],
                    )
                    w[0] = 2.0 * qd * (w[4] * s2 - w[5] * s1)
                    w[1] = 2.0 * qd * (w[5] * s0 - w[3] * s2)
                    w[2] = 2.0 * qd * (w[3] * s1 - w[4] * s0)
                    to_child(f, w)
                    r[0] += w[0]
                    r[1] += w[1]
                    r[2] += w[2]
        if kind != FIXED:
            rate = y[link[n, Q]]
            for k in range(6):
                r[k] += rate * f[BY_Q + k]
        turn = y[link[n, PHI]] if link[n, PHI] >= 0 else 0.0
        write_start(a, turn, r, rows[first])
        own_nodes(chain, n, y, rows)


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
    force, wrench = work.force, work.wrench
    r, w = work.row[0, 0:6], work.row[0, 6:12]
    for n in range(link.shape[0] - 1, -1, -1):
        f, a = frame[n], joint[n, AXIS : AXIS + 3]
        kind, parent, first = link[n, KIND], link[n, PARENT], link[n, FIRST]
        fold_forces(chain, n, force, out)
        for k in range(6):
            r[k] = force[first, k]
            w[k] = wrench[n, k]
        if link[n, PHI] >= 0:
            out[link[n, PHI]] += a[0] * r[3] + a[1] * r[4] + a[2] * r[5]
        if kind != FIXED:
            total = 0.0
            for k in range(6):
                total += f[BY_Q + k] * r[k]
            h = 3 if kind == REVOLUTE else 0
            out[link[n, Q]] += total + a[0] * w[h] + a[1] * w[h + 1] + a[2] * w[h + 2]
        if parent >= 0:
            to_parent(f, r)
            to_parent(f, w)
            l0, l1, l2 = f[LEVER], f[LEVER + 1], f[LEVER + 2]
            w[3] += l1 * w[2] - l2 * w[1]
            w[4] += l2 * w[0] - l0 * w[2]
            w[5] += l0 * w[1] - l1 * w[0]
            if kind == PRISMATIC:
                l0 -= joint[parent, TIP]
                r[3] += l1 * r[2] - l2 * r[1]
                r[4] += l2 * r[0] - l0 * r[2]
                r[5] += l0 * r[1] - l1 * r[0]
            end = link[parent, FIRST] + link[parent, COUNT]
            for k in range(6):
                force[end, k] += r[k]
                wrench[parent, k] += w[k]
