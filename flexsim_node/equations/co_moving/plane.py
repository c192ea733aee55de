"""__init__.py for links in one plane: rows are (u, b, c), joints turn about z or are fixed.

Rotations add here, so that a carrier's angular velocity is a sum.
"""

from __future__ import annotations

from math import cos, sin

from ...compiled.kernel import kernel
from ...elements import planar_beam, rigid_body
from ...elements.beam import AXIAL, LENGTH, MASS, SHEAR_Z, pull_stiffness, squared_slope
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
    LINEAR,
    OMEGA,
    PARENT,
    RATE,
    REACH,
    ROTATION,
    Q,
)


@kernel
def node_row(index, i, y, row):
    """Write the row (u, b, c) of node i from the unknowns y; zero where none is."""
    for k in range(3):
        p = index[i, k]
        row[k] = y[p] if p >= 0 else 0.0


@kernel
def write_turn(f, at, c, s):
    """Write the rotation of cosine c and sine s, row-wise, into f from column `at` on."""
    f[at], f[at + 1] = c, -s
    f[at + 3], f[at + 4] = s, c
    f[at + 8] = 1.0


@kernel
def place(chain, work, x):
    """Carriers and nodal displacements at the unknowns x."""
    link, joint, rotation, index = chain.link, chain.joint, chain.rotation, chain.unknown
    moving, d = work.moving, work.node[DISPLACEMENT]
    for n in range(link.shape[0]):
        parent, first = link[n, PARENT], link[n, FIRST]
        angle = joint[n, ANGLE]
        if link[n, KIND] != FIXED:
            angle += x[link[n, Q]]
        cosine, sine = cos(angle), sin(angle)
        c = rotation[n, 0, 0, 0] + cosine * rotation[n, 1, 0, 0] + sine * rotation[n, 2, 0, 0]
        s = rotation[n, 0, 1, 0] + cosine * rotation[n, 1, 1, 0] + sine * rotation[n, 2, 1, 0]
        if parent >= 0:
            h = moving[link[parent, FIRST] + link[parent, COUNT]]
            c, s = h[HALF] * c - h[HALF + 3] * s, h[HALF + 3] * c + h[HALF] * s
        write_turn(moving[first], ROTATION, c, s)
        for i in range(first + 1, first + link[n, COUNT] + 1):
            m, h = moving[i], moving[i - 1]
            node_row(index, i, x, d[i])
            write_turn(m, HALF, cos(d[i, 2]), sin(d[i, 2]))
            c, s = cos(d[i, 1]), sin(d[i, 1])
            write_turn(m, ROTATION, h[HALF] * c - h[HALF + 3] * s, h[HALF + 3] * c + h[HALF] * s)
            m[REACH] = chain.place[i] - chain.place[i - 1] + d[i, 0]


@kernel
def accelerate(chain, work, v, a):
    """Motion of carriers and sections at rates v and accelerations a; gravity accelerates the base."""
    link, joint, index, g = chain.link, chain.joint, chain.unknown, chain.setting
    rate, acceleration = work.node[RATE], work.node[ACCELERATION]
    for n in range(link.shape[0]):
        parent, first = link[n, PARENT], link[n, FIRST]
        x, y, omega, turn = -g[GRAVITY], -g[GRAVITY + 1], 0.0, 0.0
        if parent >= 0:
            e = work.section[link[parent, FIRST] + link[parent, COUNT]]
            x, y, omega, turn = e[LINEAR], e[LINEAR + 1], e[OMEGA + 2], e[ANGULAR + 2]
        if link[n, KIND] != FIXED:
            omega += joint[n, AXIS + 2] * v[link[n, Q]]
            turn += joint[n, AXIS + 2] * a[link[n, Q]]
        for i in range(first, first + link[n, COUNT] + 1):
            m, e = work.moving[i], work.section[i]
            c, s = m[ROTATION], m[ROTATION + 3]
            x, y = c * x + s * y, c * y - s * x
            if i > first:
                node_row(index, i, v, rate[i])
                node_row(index, i, a, acceleration[i])
                if g[ALPHA] > 0.0:
                    # alpha M on the elastic rates, joints at rest, is the inertia of alpha times these rates
                    for k in range(3):
                        acceleration[i, k] += g[ALPHA] * rate[i, k]
                omega += rate[i, 1]
                turn += acceleration[i, 1]
            m[OMEGA + 2], m[ANGULAR + 2], m[LINEAR], m[LINEAR + 1] = omega, turn, x, y
            if i > first:
                x += acceleration[i, 0] - omega * omega * m[REACH]
                y += turn * m[REACH] + 2.0 * omega * rate[i, 0]
                omega += rate[i, 2]
                turn += acceleration[i, 2]
            e[OMEGA + 2], e[ANGULAR + 2], e[LINEAR], e[LINEAR + 1] = omega, turn, x, y


@kernel
def element_rows(row, pair):
    """Write the rows of an element's start and end into pair (2, 3)."""
    pair[0, 0] = pair[0, 1] = pair[1, 1] = 0.0
    pair[0, 2] = -row[1]
    pair[1, 0], pair[1, 2] = row[0], row[2]


@kernel
def body_forces(chain, work, n):
    """Add the inertia forces of the bodies on link n's end to the wrench of its section."""
    link = chain.link
    i = link[n, FIRST] + link[n, COUNT]
    e, h = work.section[i], work.moving[i]
    f, zero, force, wrench = work.row[0, 0:9], work.row[1, 0:6], work.row[2, 0:6], work.row[3, 0:6]
    f[:] = 0.0
    zero[:] = 0.0
    force[:] = 0.0
    wrench[:] = 0.0
    c, s = h[HALF], h[HALF + 3]
    f[OMEGA + 2], f[ANGULAR + 2] = e[OMEGA + 2], e[ANGULAR + 2]
    f[LINEAR] = c * e[LINEAR] + s * e[LINEAR + 1]
    f[LINEAR + 1] = c * e[LINEAR + 1] - s * e[LINEAR]
    for k in range(link[n, FIRST_BODY], link[n, FIRST_BODY] + link[n, BODIES]):
        rigid_body.inertia_force(
            chain.body[k], 0.0, f, zero, zero, zero, 0.0, True, True, force, wrench, work.scratch
        )
    out = work.section_wrench[i]
    out[0] += c * wrench[0] - s * wrench[1]
    out[1] += s * wrench[0] + c * wrench[1]
    out[2] += wrench[5]


@kernel
def pass_on(index, work, i, x, y, moment, f0, f1, f2, out):
    """Add to the unknowns' forces what the section at node i carries and element i's own (f0, f1, f2).

    Section and element (x, y, moment about the carrier's origin) go on to the section before.
    """
    m, w, before = work.moving[i], work.section_wrench[i], work.section_wrench[i - 1]
    moment += w[2] + m[REACH] * w[1]
    p, q, r = index[i, 0], index[i, 1], index[i, 2]
    if p >= 0:
        out[p] += f0 + w[0]
    if q >= 0:
        out[q] += f1 + moment
    if r >= 0:
        out[r] += f2 + w[2]
    x, y, c, s = w[0] + x, w[1] + y, m[ROTATION], m[ROTATION + 3]
    before[0] += c * x - s * y
    before[1] += s * x + c * y
    before[2] += moment


@kernel
def pass_joint(chain, work, n, out):
    """Add the wrench at link n's start to its joint's force and to the section that it sits on."""
    link, joint = chain.link, chain.joint
    parent, m, w = link[n, PARENT], work.moving[link[n, FIRST]], work.section_wrench[link[n, FIRST]]
    if link[n, KIND] != FIXED:
        out[link[n, Q]] += joint[n, AXIS + 2] * w[2]
    if parent >= 0:
        before = work.section_wrench[link[parent, FIRST] + link[parent, COUNT]]
        c, s = m[ROTATION], m[ROTATION + 3]
        before[0] += c * w[0] - s * w[1]
        before[1] += s * w[0] + c * w[1]
        before[2] += w[2]


@kernel
def gather_wrenches(chain, work, out):
    """Add the wrenches on the sections alone, without the links' own forces, to the unknowns' forces."""
    link = chain.link
    for n in range(link.shape[0] - 1, -1, -1):
        first = link[n, FIRST]
        for i in range(first + link[n, COUNT], first, -1):
            pass_on(chain.unknown, work, i, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, out)
        pass_joint(chain, work, n, out)


@kernel
def gather(chain, work, out):
    """Add inertia, elastic and damping forces of the placed and moving chain to the unknowns' forces."""
    link, index = chain.link, chain.unknown
    beta = chain.setting[BETA]
    d, v, a, force = work.pair[0], work.pair[1], work.pair[2], work.pair[3]
    wrench = work.row[0, 0:3]
    for n in range(link.shape[0] - 1, -1, -1):
        first = link[n, FIRST]
        if link[n, BODIES] > 0:
            body_forces(chain, work, n)
        for i in range(first + link[n, COUNT], first, -1):
            element = chain.element[link[n, FIRST_ELEMENT] + i - first - 1]
            element_rows(work.node[DISPLACEMENT, i], d)
            element_rows(work.node[RATE, i], v)
            element_rows(work.node[ACCELERATION, i], a)
            force[:] = 0.0
            wrench[:] = 0.0
            planar_beam.inertia_force(element, work.moving[i], d, v, a, 1, 0.0, True, True, force, wrench)
            planar_beam.elastic_force(element, d, 1, force)
            if beta > 0.0:
                planar_beam.stiffness_product(element, d, v, 1, beta, force)
            x, y, moment = wrench[0], wrench[1], wrench[2]
            pass_on(index, work, i, x, y, moment, force[1, 0], -force[0, 2], force[1, 2], out)
        pass_joint(chain, work, n, out)


@kernel
def stiffness_times(chain, work, y, scale, out):
    """scale * K y into out (n,), at the placed configuration: an element's strains are its own unknowns'."""
    link, index = chain.link, chain.unknown
    d, v, force, row = work.pair[0], work.pair[1], work.pair[3], work.row[0, 0:3]
    out[:] = 0.0
    for n in range(link.shape[0]):
        for i in range(link[n, FIRST] + 1, link[n, FIRST] + link[n, COUNT] + 1):
            element_rows(work.node[DISPLACEMENT, i], d)
            node_row(index, i, y, row)
            element_rows(row, v)
            force[:] = 0.0
            element = chain.element[link[n, FIRST_ELEMENT] + i - link[n, FIRST] - 1]
            planar_beam.stiffness_product(element, d, v, 1, scale, force)
            p, q, r = index[i, 0], index[i, 1], index[i, 2]
            if p >= 0:
                out[p] += force[1, 0]
            if q >= 0:
                out[q] -= force[0, 2]
            if r >= 0:
                out[r] += force[1, 2]


@kernel
def element_coupling(chain, work, m, i, coupling, inertia):
    """Write d(force on the node's unknowns)/d(carrier's acceleration) (3, 3) and the carrier's own (3, 3)."""
    d, raw = work.pair[0], work.coupling
    element_rows(work.node[DISPLACEMENT, i], d)
    inertia[:] = 0.0
    planar_beam.inertia_coupling(chain.element[m], d, 1, raw, inertia)
    for k in range(3):
        coupling[0, k], coupling[1, k], coupling[2, k] = raw[3, k], -raw[2, k], raw[5, k]
    inertia[2, 0], inertia[2, 1] = inertia[0, 2], inertia[1, 2]


@kernel
def add_pulled_carrier(chain, work, m, i, scale, inertia):
    """Add scale times what a pull does against the carrier's turning to its inertia (3, 3)."""
    d = work.pair[0]
    element_rows(work.node[DISPLACEMENT, i], d)
    tension = planar_beam.axial_force(chain.element[m], d, 1)
    inertia[2, 2] += scale * max(0.0, tension) * work.moving[i, REACH]


@kernel
def shift_mass(chain, work, m, i, w):
    """Add what the shift of element m's mass adds to its mass matrix to w, upper triangle (3, 3)."""
    e, u = chain.element[m], work.node[DISPLACEMENT, i]
    b, c = -e[LENGTH] * u[1] / 12.0, e[LENGTH] * u[2] / 12.0
    w[0, 1] += 0.5 * e[MASS] * b
    w[0, 2] += 0.5 * e[MASS] * c
    w[1, 1] += e[MASS] * b * b
    w[1, 2] += e[MASS] * b * c
    w[2, 2] += e[MASS] * c * c


@kernel
def stiffen(chain, work, m, i, scale, w):
    """Add scale times what the stiffening adds to the stiffness of element m to w, upper triangle (3, 3)."""
    e, u = chain.element[m], work.node[DISPLACEMENT, i]
    length = e[LENGTH]
    mean, _, b1, _, b3 = squared_slope(0.0, -u[1], 0.0, u[2], length, e[SHEAR_Z])
    tension = e[AXIAL] * (u[0] + 0.5 * length * mean)
    if tension > 0.0:
        _, _, tt, ts = pull_stiffness(scale * tension * length, length, e[SHEAR_Z])
        w[1, 1] += tt
        w[2, 2] += tt
        w[1, 2] -= ts
    k, b, c = scale * e[AXIAL], -length * b1, length * b3
    w[0, 1] += k * b
    w[0, 2] += k * c
    w[1, 1] += k * b * b
    w[1, 2] += k * b * c
    w[2, 2] += k * c * c
