"""nodal_motion.py for links in one plane: rows are (ux, uy, rz), joints turn about z or are fixed."""

from __future__ import annotations

from math import cos, sin

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
    PHI,
    RATE,
    ROTATION,
    TIP,
    Q,
)
from .dependent_nodes import fold_forces, own_nodes


@kernel
def place(chain, work, x):
    """Frames and nodal displacements at the unknowns x."""
    link, joint, rotation, frame = chain.link, chain.joint, chain.rotation, work.frame
    d = work.node[DISPLACEMENT]
    for n in range(link.shape[0]):
        parent, first, turning = link[n, PARENT], link[n, FIRST], link[n, KIND] != FIXED
        angle = joint[n, ANGLE]
        if turning:
            angle += x[link[n, Q]]
        cosine, sine = cos(angle), sin(angle)
        # cosine and sine of the turn from the parent's body frame (constant, cosine and sine part)
        c = rotation[n, 0, 0, 0] + cosine * rotation[n, 1, 0, 0] + sine * rotation[n, 2, 0, 0]
        s = rotation[n, 0, 1, 0] + cosine * rotation[n, 1, 1, 0] + sine * rotation[n, 2, 1, 0]
        frame[n, ROTATION], frame[n, ROTATION + 1] = c, -s
        frame[n, ROTATION + 3], frame[n, ROTATION + 4] = s, c
        frame[n, ROTATION + 8] = 1.0
        ux = uy = rz = 0.0
        frame[n, LEVER] = 0.0
        if parent >= 0:
            end = link[parent, FIRST] + link[parent, COUNT]
            ux, uy, rz = c * d[end, 0] + s * d[end, 1], c * d[end, 1] - s * d[end, 0], d[end, 2]
            frame[n, LEVER] = joint[parent, TIP]
        if turning:
            frame[n, BY_Q], frame[n, BY_Q + 1] = joint[n, AXIS + 2] * uy, -joint[n, AXIS + 2] * ux
            if link[n, PHI] >= 0:
                rz += joint[n, AXIS + 2] * x[link[n, PHI]]
        d[first, 0], d[first, 1], d[first, 2] = ux, uy, rz
        own_nodes(chain, n, x, d)
        if joint[n, BOWED] > 0.0:
            # half the squared slope pulls a rigid link's end back
            frame[n, BOW] = joint[n, BOWED] * rz
            d[first + link[n, COUNT], 0] -= 0.5 * frame[n, BOW] * rz


@kernel
def nodal_rates(chain, work, y, rows, quadratic, v):
    """Nodal rows of the unknowns' rates y; with `quadratic` of their accelerations, at rates v."""
    link, joint, frame, rate = chain.link, chain.joint, work.frame, work.node[RATE]
    for n in range(link.shape[0]):
        parent, first = link[n, PARENT], link[n, FIRST]
        ux = uy = rz = 0.0
        if parent >= 0:
            end = link[parent, FIRST] + link[parent, COUNT]
            c, s = frame[n, ROTATION], frame[n, ROTATION + 3]
            ux = c * rows[end, 0] + s * rows[end, 1]
            uy = c * rows[end, 1] - s * rows[end, 0]
            rz = rows[end, 2]
        if link[n, KIND] != FIXED:
            q, axis = link[n, Q], joint[n, AXIS + 2]
            if parent >= 0:
                ux += y[q] * frame[n, BY_Q]
                uy += y[q] * frame[n, BY_Q + 1]
                if quadratic:
                    # - qd z x (2 E^T u' + qd dr/dq)
                    turn = axis * v[q]
                    x1 = 2.0 * (c * rate[end, 0] + s * rate[end, 1]) + v[q] * frame[n, BY_Q]
                    y1 = 2.0 * (c * rate[end, 1] - s * rate[end, 0]) + v[q] * frame[n, BY_Q + 1]
                    ux += turn * y1
                    uy -= turn * x1
            if link[n, PHI] >= 0:
                rz += axis * y[link[n, PHI]]
        rows[first, 0], rows[first, 1], rows[first, 2] = ux, uy, rz
        own_nodes(chain, n, y, rows)
        if joint[n, BOWED] > 0.0:
            back = frame[n, BOW] * rz
            if quadratic:
                back += joint[n, BOWED] * rate[first, 2] ** 2
            rows[first + link[n, COUNT], 0] -= back


@kernel
def accelerate(chain, work, v, a):
    """Motion of frames and nodes; gravity enters as an acceleration -g of the base."""
    link, joint, frame, g = chain.link, chain.joint, work.frame, chain.setting
    for n in range(link.shape[0]):
        parent = link[n, PARENT]
        x, y, omega, turn = -g[GRAVITY], -g[GRAVITY + 1], 0.0, 0.0
        if parent >= 0:
            omega, turn = frame[parent, OMEGA + 2], frame[parent, ANGULAR + 2]
            lever = frame[n, LEVER]
            x = frame[parent, LINEAR] - omega * omega * lever
            y = frame[parent, LINEAR + 1] + turn * lever
        if link[n, KIND] != FIXED:
            omega += joint[n, AXIS + 2] * v[link[n, Q]]
            turn += joint[n, AXIS + 2] * a[link[n, Q]]
        c, s = frame[n, ROTATION], frame[n, ROTATION + 3]
        frame[n, OMEGA + 2], frame[n, ANGULAR + 2] = omega, turn
        frame[n, LINEAR], frame[n, LINEAR + 1] = c * x + s * y, c * y - s * x
    nodal_rates(chain, work, v, work.node[RATE], False, v)
    nodal_rates(chain, work, a, work.node[ACCELERATION], True, v)


@kernel
def gather(chain, work, out):
    """Add nodal forces and links' wrenches, through the transposed map, to the unknowns' forces."""
    link, joint, frame = chain.link, chain.joint, work.frame
    force, wrench = work.force, work.wrench
    for n in range(link.shape[0] - 1, -1, -1):
        parent, first = link[n, PARENT], link[n, FIRST]
        if joint[n, BOWED] > 0.0:
            force[first, 2] -= frame[n, BOW] * force[first + link[n, COUNT], 0]
        fold_forces(chain, n, force, out)
        fx, fy, m = force[first, 0], force[first, 1], force[first, 2]
        if link[n, KIND] != FIXED:
            axis = joint[n, AXIS + 2]
            if link[n, PHI] >= 0:
                out[link[n, PHI]] += axis * m
            out[link[n, Q]] += axis * wrench[n, 2]
            if parent >= 0:
                out[link[n, Q]] += frame[n, BY_Q] * fx + frame[n, BY_Q + 1] * fy
        if parent >= 0:
            c, s = frame[n, ROTATION], frame[n, ROTATION + 3]
            end = link[parent, FIRST] + link[parent, COUNT]
            force[end, 0] += c * fx - s * fy
            force[end, 1] += s * fx + c * fy
            force[end, 2] += m
            wx, wy = c * wrench[n, 0] - s * wrench[n, 1], s * wrench[n, 0] + c * wrench[n, 1]
            wrench[parent, 0] += wx
            wrench[parent, 1] += wy
            wrench[parent, 2] += wrench[n, 2] + frame[n, LEVER] * wy
