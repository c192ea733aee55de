"""__init__.py in space: rows are (u, b_z, b_y, tau, c_y, c_z), joints turn, slide or are fixed."""

from __future__ import annotations

from math import cos, sin

from ...compiled.kernel import kernel
from ...elements import rigid_body, spatial_beam
from ...elements.beam import (
    AXIAL,
    HELIX,
    LENGTH,
    MASS,
    SHEAR_Y,
    SHEAR_Z,
    pull_stiffness,
    squared_helix,
    squared_slope,
)
from ...model.chain import (
    ACCELERATION,
    ALPHA,
    ANGLE,
    ANGULAR,
    AXIS,
    BETA,
    BODIES,
    COUNT,
    DISPLACEMENT,
    FIRST,
    FIRST_BODY,
    FIRST_ELEMENT,
    FIXED,
    GRAVITY,
    HALF,
    KIND,
    LEAD,
    LINEAR,
    OMEGA,
    PARENT,
    PARENT_AXIS,
    PRISMATIC,
    RATE,
    REACH,
    REVOLUTE,
    ROTATION,
    SERIES,
    SLIDE,
    TURN,
    Q,
)
from ...rotations.rotation_vector import coefficients, write_rotation


@kernel
def product(a, b, out):
    """out = a b for 3 x 3 matrices in rows of nine."""
    for i in range(0, 9, 3):
        x, y, z = a[i], a[i + 1], a[i + 2]
        out[i] = x * b[0] + y * b[3] + z * b[6]
        out[i + 1] = x * b[1] + y * b[4] + z * b[7]
        out[i + 2] = x * b[2] + y * b[5] + z * b[8]


@kernel
def turned(m, x, y, z):
    """m (x, y, z) for a 3 x 3 matrix in a row of nine."""
    return (
        m[0] * x + m[1] * y + m[2] * z,
        m[3] * x + m[4] * y + m[5] * z,
        m[6] * x + m[7] * y + m[8] * z,
    )


@kernel
def turned_back(m, x, y, z):
    """m^T (x, y, z)."""
    return (
        m[0] * x + m[3] * y + m[6] * z,
        m[1] * x + m[4] * y + m[7] * z,
        m[2] * x + m[5] * y + m[8] * z,
    )


@kernel
def node_row(index, i, y, row):
    """Write the row (u, b_z, b_y, tau, c_y, c_z) of node i from the unknowns y; zero where none is."""
    for k in range(6):
        p = index[i, k]
        row[k] = y[p] if p >= 0 else 0.0


@kernel
def write_half(m, at, series, x, y, z, out):
    """Write a rotation vector and its coefficients into m, its rotation into out (nine numbers)."""
    s = x * x + y * y + z * z
    k1, k2, d1, d2 = coefficients(s)
    m[at], m[at + 1], m[at + 2] = x, y, z
    m[series], m[series + 1], m[series + 2], m[series + 3] = k1, k2, d1, d2
    write_rotation(x, y, z, s, k1, k2, out)


@kernel
def spin(m, at, series, sign, u0, u1, u2, y0, y1, y2):
    """Angular velocity and its rate for the vector's rate u and acceleration y: by T (sign -1) or T^T (1)."""
    t0, t1, t2, k1, k2 = m[at], m[at + 1], m[at + 2], m[series], m[series + 1]
    twice = 2.0 * (t0 * u0 + t1 * u1 + t2 * u2)
    j1, j2 = sign * twice * m[series + 2], twice * m[series + 3]
    k1 = sign * k1
    # t x t', t x (t x t'), t' x (t x t'); t x t'', t x (t x t'')
    f0, f1, f2 = t1 * u2 - t2 * u1, t2 * u0 - t0 * u2, t0 * u1 - t1 * u0
    g0, g1, g2 = t1 * f2 - t2 * f1, t2 * f0 - t0 * f2, t0 * f1 - t1 * f0
    h0, h1, h2 = u1 * f2 - u2 * f1, u2 * f0 - u0 * f2, u0 * f1 - u1 * f0
    o0, o1, o2 = t1 * y2 - t2 * y1, t2 * y0 - t0 * y2, t0 * y1 - t1 * y0
    q0, q1, q2 = t1 * o2 - t2 * o1, t2 * o0 - t0 * o2, t0 * o1 - t1 * o0
    return (
        u0 + k1 * f0 + k2 * g0,
        u1 + k1 * f1 + k2 * g1,
        u2 + k1 * f2 + k2 * g2,
        y0 + k1 * o0 + j1 * f0 + k2 * (q0 + h0) + j2 * g0,
        y1 + k1 * o1 + j1 * f1 + k2 * (q1 + h1) + j2 * g1,
        y2 + k1 * o2 + j1 * f2 + k2 * (q2 + h2) + j2 * g2,
    )


@kernel
def tangent(m, at, series, sign, x, y, z):
    """T^T (x, y, z) for sign 1, T (x, y, z) for sign -1."""
    t0, t1, t2, k1, k2 = m[at], m[at + 1], m[at + 2], sign * m[series], m[series + 1]
    k0 = 1.0 - k2 * (t0 * t0 + t1 * t1 + t2 * t2)
    along = k2 * (t0 * x + t1 * y + t2 * z)
    return (
        k0 * x + along * t0 + k1 * (t1 * z - t2 * y),
        k0 * y + along * t1 + k1 * (t2 * x - t0 * z),
        k0 * z + along * t2 + k1 * (t0 * y - t1 * x),
    )


@kernel
def joint_rotation(chain, n, q, out):
    """Write the rotation (row of nine) of a link to the section that its joint sits on."""
    rotation = chain.rotation
    angle = chain.joint[n, ANGLE] + (q if chain.link[n, KIND] == REVOLUTE else 0.0)
    cosine, sine = cos(angle), sin(angle)
    for i in range(3):
        for k in range(3):
            out[3 * i + k] = (
                rotation[n, 0, i, k] + cosine * rotation[n, 1, i, k] + sine * rotation[n, 2, i, k]
            )


@kernel
def place(chain, work, x):
    """Carriers and nodal displacements at the unknowns x."""
    link, joint, index, moving = chain.link, chain.joint, chain.unknown, work.moving
    d = work.node[DISPLACEMENT]
    turn = work.row[0, 0:9]
    for n in range(link.shape[0]):
        kind, parent, first = link[n, KIND], link[n, PARENT], link[n, FIRST]
        q = x[link[n, Q]] if kind != FIXED else 0.0
        m = moving[first]
        s0, s1, s2 = joint[n, PARENT_AXIS], joint[n, PARENT_AXIS + 1], joint[n, PARENT_AXIS + 2]
        if parent >= 0:
            joint_rotation(chain, n, q, turn)
            half = moving[link[parent, FIRST] + link[parent, COUNT], HALF : HALF + 9]
            product(half, turn, m[ROTATION : ROTATION + 9])
            if kind == PRISMATIC:
                s0, s1, s2 = turned(half, s0, s1, s2)
        else:
            joint_rotation(chain, n, q, m[ROTATION : ROTATION + 9])
        if kind == PRISMATIC:
            m[SLIDE], m[SLIDE + 1], m[SLIDE + 2] = s0, s1, s2
            m[LEAD], m[LEAD + 1], m[LEAD + 2] = q * s0, q * s1, q * s2
        for i in range(first + 1, first + link[n, COUNT] + 1):
            m, before = moving[i], moving[i - 1]
            node_row(index, i, x, d[i])
            half = 0.5 * d[i, 3]
            write_half(m, TURN, SERIES, half, d[i, 2], d[i, 1], turn)
            product(before[HALF : HALF + 9], turn, m[ROTATION : ROTATION + 9])
            write_half(m, TURN + 3, SERIES + 4, half, d[i, 4], d[i, 5], m[HALF : HALF + 9])
            m[REACH] = chain.place[i] - chain.place[i - 1] + d[i, 0]


@kernel
def joint_motion(chain, work, n, v, a):
    """Motion of link n's carrier at its start, from that of the section its joint sits on."""
    link, joint, g = chain.link, chain.joint, chain.setting
    m = work.moving[link[n, FIRST]]
    kind, parent = link[n, KIND], link[n, PARENT]
    w0 = w1 = w2 = b0 = b1 = b2 = 0.0
    p0, p1, p2 = -g[GRAVITY], -g[GRAVITY + 1], -g[GRAVITY + 2]
    if parent >= 0:
        e = work.section[link[parent, FIRST] + link[parent, COUNT]]
        w0, w1, w2 = e[OMEGA], e[OMEGA + 1], e[OMEGA + 2]
        p0, p1, p2 = e[LINEAR], e[LINEAR + 1], e[LINEAR + 2]
        b0, b1, b2 = e[ANGULAR], e[ANGULAR + 1], e[ANGULAR + 2]
    if kind == PRISMATIC:
        qd, qdd = v[link[n, Q]], a[link[n, Q]]
        l0, l1, l2 = m[LEAD], m[LEAD + 1], m[LEAD + 2]
        s0, s1, s2 = m[SLIDE], m[SLIDE + 1], m[SLIDE + 2]
        # w x l + 2 qd s, under another w x
        c0 = w1 * l2 - w2 * l1 + 2.0 * qd * s0
        c1 = w2 * l0 - w0 * l2 + 2.0 * qd * s1
        c2 = w0 * l1 - w1 * l0 + 2.0 * qd * s2
        p0 += s0 * qdd + b1 * l2 - b2 * l1 + w1 * c2 - w2 * c1
        p1 += s1 * qdd + b2 * l0 - b0 * l2 + w2 * c0 - w0 * c2
        p2 += s2 * qdd + b0 * l1 - b1 * l0 + w0 * c1 - w1 * c0
    r = m[ROTATION : ROTATION + 9]
    w0, w1, w2 = turned_back(r, w0, w1, w2)
    p0, p1, p2 = turned_back(r, p0, p1, p2)
    b0, b1, b2 = turned_back(r, b0, b1, b2)
    if kind == REVOLUTE:
        qd, qdd = v[link[n, Q]], a[link[n, Q]]
        x, y, z = joint[n, AXIS], joint[n, AXIS + 1], joint[n, AXIS + 2]
        b0 += x * qdd + qd * (w1 * z - w2 * y)
        b1 += y * qdd + qd * (w2 * x - w0 * z)
        b2 += z * qdd + qd * (w0 * y - w1 * x)
        w0 += x * qd
        w1 += y * qd
        w2 += z * qd
    m[OMEGA], m[OMEGA + 1], m[OMEGA + 2] = w0, w1, w2
    m[LINEAR], m[LINEAR + 1], m[LINEAR + 2] = p0, p1, p2
    m[ANGULAR], m[ANGULAR + 1], m[ANGULAR + 2] = b0, b1, b2
    e = work.section[link[n, FIRST]]
    for k in range(9):
        e[k] = m[k]


@kernel
def accelerate(chain, work, v, a):
    """Motion of carriers and sections at rates v and accelerations a; gravity accelerates the base."""
    link, index = chain.link, chain.unknown
    rate, acceleration = work.node[RATE], work.node[ACCELERATION]
    alpha = chain.setting[ALPHA]
    for n in range(link.shape[0]):
        joint_motion(chain, work, n, v, a)
        first = link[n, FIRST]
        for i in range(first + 1, first + link[n, COUNT] + 1):
            m, e = work.moving[i], work.section[i]
            before = work.section[i - 1]
            node_row(index, i, v, rate[i])
            node_row(index, i, a, acceleration[i])
            if alpha > 0.0:
                # alpha M on the elastic rates, joints at rest, is the inertia of alpha times these rates
                for k in range(6):
                    acceleration[i, k] += alpha * rate[i, k]
            r = m[ROTATION : ROTATION + 9]
            w0, w1, w2 = turned_back(r, before[OMEGA], before[OMEGA + 1], before[OMEGA + 2])
            p0, p1, p2 = turned_back(r, before[LINEAR], before[LINEAR + 1], before[LINEAR + 2])
            b0, b1, b2 = turned_back(r, before[ANGULAR], before[ANGULAR + 1], before[ANGULAR + 2])
            u, y = rate[i], acceleration[i]
            # the carrier
            x0, x1, x2, y0, y1, y2 = spin(
                m, TURN, SERIES, -1.0, 0.5 * u[3], u[2], u[1], 0.5 * y[3], y[2], y[1]
            )
            w0 += x0
            w1 += x1
            w2 += x2
            b0 += w1 * x2 - w2 * x1 + y0
            b1 += w2 * x0 - w0 * x2 + y1
            b2 += w0 * x1 - w1 * x0 + y2
            m[OMEGA], m[OMEGA + 1], m[OMEGA + 2] = w0, w1, w2
            m[LINEAR], m[LINEAR + 1], m[LINEAR + 2] = p0, p1, p2
            m[ANGULAR], m[ANGULAR + 1], m[ANGULAR + 2] = b0, b1, b2
            # the section at its end, l e_x from the carrier's origin
            reach, ld = m[REACH], 2.0 * u[0]
            c1, c2 = w2 * reach, w1 * reach
            e[LINEAR] = p0 - w1 * c2 - w2 * c1 + y[0]
            e[LINEAR + 1] = p1 + b2 * reach + w0 * c2 + w2 * ld
            e[LINEAR + 2] = p2 - b1 * reach + w0 * c1 - w1 * ld
            x0, x1, x2, y0, y1, y2 = spin(
                m, TURN + 3, SERIES + 4, 1.0, 0.5 * u[3], u[4], u[5], 0.5 * y[3], y[4], y[5]
            )
            e[OMEGA], e[OMEGA + 1], e[OMEGA + 2] = w0 + x0, w1 + x1, w2 + x2
            e[ANGULAR] = b0 + w1 * x2 - w2 * x1 + y0
            e[ANGULAR + 1] = b1 + w2 * x0 - w0 * x2 + y1
            e[ANGULAR + 2] = b2 + w0 * x1 - w1 * x0 + y2


@kernel
def element_rows(row, pair):
    """Write the rows of an element's start and end into pair (2, 6)."""
    pair[:] = 0.0
    pair[0, 3], pair[0, 4], pair[0, 5] = -0.5 * row[3], -row[2], -row[1]
    pair[1, 0], pair[1, 3], pair[1, 4], pair[1, 5] = row[0], 0.5 * row[3], row[4], row[5]


@kernel
def own_forces(force, row):
    """Write the forces on an element's own unknowns, of those on its rows (2, 6), into row (6,)."""
    row[0], row[1], row[2] = force[1, 0], -force[0, 5], -force[0, 4]
    row[3], row[4], row[5] = 0.5 * (force[1, 3] - force[0, 3]), force[1, 4], force[1, 5]


@kernel
def body_forces(chain, work, n):
    """Add the inertia forces of the bodies on link n's end to the wrench of its section."""
    link = chain.link
    i = link[n, FIRST] + link[n, COUNT]
    e, h = work.section[i], work.moving[i, HALF : HALF + 9]
    f, zero, force, wrench = work.row[0, 0:9], work.row[1, 0:6], work.row[2, 0:6], work.row[3, 0:6]
    for k in range(0, 9, 3):
        f[k], f[k + 1], f[k + 2] = turned_back(h, e[k], e[k + 1], e[k + 2])
    zero[:] = 0.0
    force[:] = 0.0
    wrench[:] = 0.0
    for k in range(link[n, FIRST_BODY], link[n, FIRST_BODY] + link[n, BODIES]):
        rigid_body.inertia_force(
            chain.body[k], 0.0, f, zero, zero, zero, 0.0, True, True, force, wrench, work.scratch
        )
    out = work.section_wrench[i]
    for k in range(0, 6, 3):
        x, y, z = turned(h, wrench[k], wrench[k + 1], wrench[k + 2])
        out[k] += x
        out[k + 1] += y
        out[k + 2] += z


@kernel
def pass_on(index, work, i, wrench, own, out):
    """Add to the unknowns' forces what the section at node i carries and element i's own forces (6,).

    Section and element (wrench (6,) about the carrier's origin) go on to the section before.
    """
    m, w, before = work.moving[i], work.section_wrench[i], work.section_wrench[i - 1]
    reach = m[REACH]
    own[0] += w[0]
    y0, y1, y2 = tangent(m, TURN + 3, SERIES + 4, -1.0, w[3], w[4], w[5])
    own[3] += 0.5 * y0
    own[4] += y1
    own[5] += y2
    x0, x1, x2 = wrench[0] + w[0], wrench[1] + w[1], wrench[2] + w[2]
    z0, z1, z2 = wrench[3] + w[3], wrench[4] + w[4] - reach * w[2], wrench[5] + w[5] + reach * w[1]
    y0, y1, y2 = tangent(m, TURN, SERIES, 1.0, z0, z1, z2)
    own[3] += 0.5 * y0
    own[2] += y1
    own[1] += y2
    for k in range(6):
        p = index[i, k]
        if p >= 0:
            out[p] += own[k]
    r = m[ROTATION : ROTATION + 9]
    x0, x1, x2 = turned(r, x0, x1, x2)
    z0, z1, z2 = turned(r, z0, z1, z2)
    before[0] += x0
    before[1] += x1
    before[2] += x2
    before[3] += z0
    before[4] += z1
    before[5] += z2


@kernel
def pass_joint(chain, work, n, out):
    """Add the wrench at link n's start to its joint's force and to the section that it sits on."""
    link, joint = chain.link, chain.joint
    kind, parent = link[n, KIND], link[n, PARENT]
    m, w = work.moving[link[n, FIRST]], work.section_wrench[link[n, FIRST]]
    if kind != FIXED:
        h = 3 if kind == REVOLUTE else 0
        out[link[n, Q]] += (
            joint[n, AXIS] * w[h] + joint[n, AXIS + 1] * w[h + 1] + joint[n, AXIS + 2] * w[h + 2]
        )
    if parent >= 0:
        r = m[ROTATION : ROTATION + 9]
        x0, x1, x2 = turned(r, w[0], w[1], w[2])
        z0, z1, z2 = turned(r, w[3], w[4], w[5])
        if kind == PRISMATIC:
            l0, l1, l2 = m[LEAD], m[LEAD + 1], m[LEAD + 2]
            z0 += l1 * x2 - l2 * x1
            z1 += l2 * x0 - l0 * x2
            z2 += l0 * x1 - l1 * x0
        before = work.section_wrench[link[parent, FIRST] + link[parent, COUNT]]
        before[0] += x0
        before[1] += x1
        before[2] += x2
        before[3] += z0
        before[4] += z1
        before[5] += z2


@kernel
def gather_wrenches(chain, work, out):
    """Add the wrenches on the sections alone, without the links' own forces, to the unknowns' forces."""
    link, nothing, own = chain.link, work.row[0, 0:6], work.row[1, 0:6]
    nothing[:] = 0.0
    for n in range(link.shape[0] - 1, -1, -1):
        first = link[n, FIRST]
        for i in range(first + link[n, COUNT], first, -1):
            own[:] = 0.0
            pass_on(chain.unknown, work, i, nothing, own, out)
        pass_joint(chain, work, n, out)


@kernel
def gather(chain, work, out):
    """Add inertia, elastic and damping forces of the placed and moving chain to the unknowns' forces."""
    link, index = chain.link, chain.unknown
    beta = chain.setting[BETA]
    d, v, a, force = work.pair[0], work.pair[1], work.pair[2], work.pair[3]
    wrench, own = work.row[0, 0:6], work.row[1, 0:6]
    for n in range(link.shape[0] - 1, -1, -1):
        first = link[n, FIRST]
        if link[n, BODIES] > 0:
            body_forces(chain, work, n)
        for i in range(first + link[n, COUNT], first, -1):
            element, m = chain.element[link[n, FIRST_ELEMENT] + i - first - 1], work.moving[i]
            element_rows(work.node[DISPLACEMENT, i], d)
            element_rows(work.node[RATE, i], v)
            element_rows(work.node[ACCELERATION, i], a)
            force[:] = 0.0
            wrench[:] = 0.0
            spatial_beam.inertia_force(element, m, d, v, a, 1, 0.0, True, True, force, wrench, work.scratch)
            spatial_beam.elastic_force(element, d, 1, force)
            if beta > 0.0:
                spatial_beam.stiffness_product(element, d, v, 1, beta, force)
            own_forces(force, own)
            pass_on(index, work, i, wrench, own, out)
        pass_joint(chain, work, n, out)


@kernel
def stiffness_times(chain, work, y, scale, out):
    """scale * K y into out (n,), at the placed configuration: an element's strains are its own unknowns'."""
    link, index = chain.link, chain.unknown
    d, v, force, row = work.pair[0], work.pair[1], work.pair[3], work.row[0, 0:6]
    out[:] = 0.0
    for n in range(link.shape[0]):
        for i in range(link[n, FIRST] + 1, link[n, FIRST] + link[n, COUNT] + 1):
            element_rows(work.node[DISPLACEMENT, i], d)
            node_row(index, i, y, row)
            element_rows(row, v)
            force[:] = 0.0
            element = chain.element[link[n, FIRST_ELEMENT] + i - link[n, FIRST] - 1]
            spatial_beam.stiffness_product(element, d, v, 1, scale, force)
            own_forces(force, row)
            for k in range(6):
                p = index[i, k]
                if p >= 0:
                    out[p] += row[k]


@kernel
def element_coupling(chain, work, m, i, coupling, inertia):
    """Write d(force on the node's unknowns)/d(carrier's acceleration) (6, 6) and the carrier's own (6, 6)."""
    d, raw = work.pair[0], work.coupling
    element_rows(work.node[DISPLACEMENT, i], d)
    inertia[:] = 0.0
    spatial_beam.inertia_coupling(chain.element[m], d, 1, raw, inertia, work.scratch)
    for k in range(6):
        coupling[0, k], coupling[1, k], coupling[2, k] = raw[6, k], -raw[5, k], -raw[4, k]
        coupling[3, k] = 0.5 * (raw[9, k] - raw[3, k])
        coupling[4, k], coupling[5, k] = raw[10, k], raw[11, k]
        for j in range(k):
            inertia[k, j] = inertia[j, k]


@kernel
def add_pulled_carrier(chain, work, m, i, scale, inertia):
    """Add scale times what a pull does against the carrier's turning to its inertia (6, 6)."""
    d = work.pair[0]
    element_rows(work.node[DISPLACEMENT, i], d)
    tension = spatial_beam.axial_force(chain.element[m], d, 1)
    turned = scale * max(0.0, tension) * work.moving[i, REACH]
    inertia[4, 4] += turned
    inertia[5, 5] += turned


@kernel
def shift_mass(chain, work, m, i, w):
    """Add what the shift of element m's mass adds to its mass matrix to w, upper triangle (6, 6)."""
    e, b, u = chain.element[m], work.row[1, 0:6], work.node[DISPLACEMENT, i]
    twelfth = e[LENGTH] / 12.0
    b[1], b[2], b[4], b[5] = -twelfth * u[1], -twelfth * u[2], twelfth * u[4], twelfth * u[5]
    for p in (1, 2, 4, 5):
        w[0, p] += 0.5 * e[MASS] * b[p]
        for q in (1, 2, 4, 5):
            if q >= p:
                w[p, q] += e[MASS] * b[p] * b[q]


@kernel
def stiffen(chain, work, m, i, scale, w):
    """Add scale times what the stiffening adds to the stiffness of element m to w, upper triangle (6, 6)."""
    e, b = chain.element[m], work.row[1, 0:6]
    u, length = work.node[DISPLACEMENT, i], e[LENGTH]
    my, _, a1, _, a3 = squared_slope(0.0, -u[1], 0.0, u[5], length, e[SHEAR_Z])
    mz, _, b1, _, b3 = squared_slope(0.0, u[2], 0.0, -u[4], length, e[SHEAR_Y])
    mx, c = squared_helix(e, 0.0, u[3])
    tension = e[AXIAL] * (u[0] + 0.5 * length * (mx + my + mz))
    if tension > 0.0:
        pull = scale * tension * length
        _, _, tt, ts = pull_stiffness(pull, length, e[SHEAR_Z])
        w[1, 1] += tt
        w[5, 5] += tt
        w[1, 5] -= ts
        _, _, tt, ts = pull_stiffness(pull, length, e[SHEAR_Y])
        w[2, 2] += tt
        w[4, 4] += tt
        w[2, 4] -= ts
        w[3, 3] += pull * e[HELIX] / (length * length)
    b[0], b[1], b[2] = 1.0, -length * a1, length * b1
    b[3], b[4], b[5] = length * c, -length * b3, length * a3
    k = scale * e[AXIAL]
    for p in range(6):
        for q in range(p, 6):
            w[p, q] += k * b[p] * b[q]
    w[0, 0] -= k
