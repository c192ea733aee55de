"""factorization.py for co-moving frames: an element hands on one matrix over a section's acceleration.

An element's front is (its unknowns y, the acceleration A' that its carrier has from the section before it).
Its own carrier moves with A = A' + (0, G y'') and the section at its end with (A_a + A_w x r + u'',
A_w + P y''), G y'' = T(b) b'' and P y'' = T(c)^T c''.  The section's matrix, shifted to the carrier's origin,
therefore acts on A' + D y'' with D y'' = (u'' + r x P y'', (G + P) y'').
"""

from __future__ import annotations

from ...compiled.kernel import kernel
from ...elements import rigid_body
from ...elements.beam import STIFFENING
from ...model.chain import (
    AXIS,
    BODIES,
    COUNT,
    FIRST,
    FIRST_BODY,
    FIRST_ELEMENT,
    HALF,
    KEPT_MOMENT,
    KEPT_TURN,
    KIND,
    LEAD,
    PARENT,
    PRISMATIC,
    REACH,
    REVOLUTE,
    ROTATION,
    SERIES,
    TURN,
)
from ..co_moving import plane, space
from ..co_moving.space import tangent
from .joint_elimination import free, own_pivot


@kernel
def turn_matrix(r, z, dofs):
    """Replace the symmetric z (6, 6) or (3, 3), both triangles, by its congruence with the rotation r."""
    if len(dofs) == 3:
        c, s = r[0], r[3]
        xx, xy, yy, xz, yz = z[0, 0], z[0, 1], z[1, 1], z[0, 2], z[1, 2]
        z[0, 0] = c * c * xx - 2.0 * c * s * xy + s * s * yy
        z[1, 1] = s * s * xx + 2.0 * c * s * xy + c * c * yy
        z[0, 1] = z[1, 0] = c * s * (xx - yy) + (c * c - s * s) * xy
        z[0, 2] = z[2, 0] = c * xz - s * yz
        z[1, 2] = z[2, 1] = s * xz + c * yz
        return
    e0, e1, e2, e3, e4, e5, e6, e7, e8 = r[0], r[1], r[2], r[3], r[4], r[5], r[6], r[7], r[8]
    for i in range(0, 6, 3):
        for k in range(i, 6, 3):
            x, y, u = z[i, k], z[i + 1, k], z[i + 2, k]
            a0, b0, c0 = e0 * x + e1 * y + e2 * u, e3 * x + e4 * y + e5 * u, e6 * x + e7 * y + e8 * u
            x, y, u = z[i, k + 1], z[i + 1, k + 1], z[i + 2, k + 1]
            a1, b1, c1 = e0 * x + e1 * y + e2 * u, e3 * x + e4 * y + e5 * u, e6 * x + e7 * y + e8 * u
            x, y, u = z[i, k + 2], z[i + 1, k + 2], z[i + 2, k + 2]
            a2, b2, c2 = e0 * x + e1 * y + e2 * u, e3 * x + e4 * y + e5 * u, e6 * x + e7 * y + e8 * u
            z[i, k] = a0 * e0 + a1 * e1 + a2 * e2
            z[i, k + 1] = a0 * e3 + a1 * e4 + a2 * e5
            z[i, k + 2] = a0 * e6 + a1 * e7 + a2 * e8
            z[i + 1, k] = b0 * e0 + b1 * e1 + b2 * e2
            z[i + 1, k + 1] = b0 * e3 + b1 * e4 + b2 * e5
            z[i + 1, k + 2] = b0 * e6 + b1 * e7 + b2 * e8
            z[i + 2, k] = c0 * e0 + c1 * e1 + c2 * e2
            z[i + 2, k + 1] = c0 * e3 + c1 * e4 + c2 * e5
            z[i + 2, k + 2] = c0 * e6 + c1 * e7 + c2 * e8
    for i in range(3):
        for k in range(3, 6):
            z[k, i] = z[i, k]


@kernel
def shift(z, x, y, u, dofs):
    """Move the point that the symmetric z acts on by the lever (x, y, u): rotations also move it."""
    if len(dofs) == 3:
        for k in range(3):
            z[2, k] += x * z[1, k] - y * z[0, k]
        for k in range(3):
            z[k, 2] += x * z[k, 1] - y * z[k, 0]
        return
    for k in range(6):
        z0, z1, z2 = z[0, k], z[1, k], z[2, k]
        z[3, k] += y * z2 - u * z1
        z[4, k] += u * z0 - x * z2
        z[5, k] += x * z1 - y * z0
    for k in range(6):
        z0, z1, z2 = z[k, 0], z[k, 1], z[k, 2]
        z[k, 3] += y * z2 - u * z1
        z[k, 4] += u * z0 - x * z2
        z[k, 5] += x * z1 - y * z0


@kernel
def section_bodies(chain, work, n, dofs):
    """Add the rigid bodies on link n's end to the matrix of its section."""
    link = chain.link
    i = link[n, FIRST] + link[n, COUNT]
    zero = work.row[0, 0:6]
    coupling, inertia = work.row[:, 18:24], work.row[:, 24:30]
    zero[:] = 0.0
    inertia[:] = 0.0
    for k in range(link[n, FIRST_BODY], link[n, FIRST_BODY] + link[n, BODIES]):
        rigid_body.inertia_coupling(chain.body[k], 0.0, zero, 0.0, coupling, inertia, work.scratch)
    b = len(dofs)
    z = work.square
    for j in range(b):
        p = 5 if len(dofs) == 3 and j == 2 else j
        for k in range(j, b):
            q = 5 if len(dofs) == 3 and k == 2 else k
            z[j, k] = z[k, j] = inertia[p, q]
    turn_matrix(work.moving[i, HALF : HALF + 9], z, dofs)
    out = work.section_matrix[i]
    for j in range(b):
        for k in range(b):
            out[j, k] += z[j, k]


@kernel
def keep(work, i, dofs):
    """Keep of node i's carrier what the solves need: rotation, reach, how unknowns move its section."""
    m, kept = work.moving[i], work.kept_moving[i]
    for k in range(9):
        kept[k] = m[ROTATION + k]
    x, y, u = m[REACH], m[REACH + 1], m[REACH + 2]
    kept[9], kept[10], kept[11] = x, y, u
    if len(dofs) == 3:
        kept[KEPT_MOMENT] = -x
        return
    turns, moments = kept[KEPT_TURN : KEPT_TURN + 15], kept[KEPT_MOMENT : KEPT_MOMENT + 9]
    # angular columns of b_z, b_y, tau, c_y, c_z: T of b, T^T of c
    for k in range(5):
        v0 = 1.0 if k == 2 else 0.0
        v1 = 1.0 if k == 1 or k == 3 else 0.0
        v2 = 1.0 if k == 0 or k == 4 else 0.0
        a = b = c = 0.0
        if k < 3:
            a, b, c = tangent(m, TURN, SERIES, -1.0, v0, v1, v2)
        if k > 1:
            p, q, r = tangent(m, TURN + 3, SERIES + 4, 1.0, v0, v1, v2)
            moments[3 * k - 6], moments[3 * k - 5], moments[3 * k - 4] = 0.0, -x * r, x * q
            a, b, c = a + p, b + q, c + r
        turns[3 * k], turns[3 * k + 1], turns[3 * k + 2] = a, b, c
    for k in range(3):
        turns[6 + k] *= 0.5
        moments[k] *= 0.5


@kernel
def add_section(work, i, y, a, w, dofs):
    """Add the matrix of node i's section to the front w (y, A'), upper triangle of y and of A'."""
    z, kept = work.section_matrix[i], work.kept_moving[i]
    shift(z, kept[9], kept[10], kept[11], dofs)
    if len(dofs) == 3:
        p = kept[KEPT_MOMENT]
        for k in range(3):
            w[0, 3 + k] += z[0, k]
            w[1, 3 + k] += z[2, k]
            y[k] = p * z[1, k] + z[2, k]
            w[2, 3 + k] += y[k]
            for j in range(k, 3):
                w[3 + k, 3 + j] += z[k, j]
        w[0, 0] += z[0, 0]
        w[0, 1] += z[0, 2]
        w[1, 1] += z[2, 2]
        w[0, 2] += y[0]
        w[1, 2] += y[2]
        w[2, 2] += p * y[1] + y[2]
        return
    s, p = kept[KEPT_TURN : KEPT_TURN + 15], kept[KEPT_MOMENT : KEPT_MOMENT + 9]
    for k in range(6):
        w[0, 6 + k] += z[0, k]
    w[0, 0] += z[0, 0]
    for j in range(5):
        s0, s1, s2 = s[3 * j], s[3 * j + 1], s[3 * j + 2]
        for k in range(6):
            a[k] = s0 * z[3, k] + s1 * z[4, k] + s2 * z[5, k]
        if j > 1:
            p1, p2 = p[3 * j - 5], p[3 * j - 4]
            for k in range(6):
                a[k] += p1 * z[1, k] + p2 * z[2, k]
        for k in range(6):
            w[1 + j, 6 + k] += a[k]
        w[0, 1 + j] += a[0]
        for k in range(j, 5):
            w[1 + j, 1 + k] += a[3] * s[3 * k] + a[4] * s[3 * k + 1] + a[5] * s[3 * k + 2]
            if k > 1:
                w[1 + j, 1 + k] += a[1] * p[3 * k - 5] + a[2] * p[3 * k - 4]
    for j in range(6):
        for k in range(j, 6):
            w[6 + j, 6 + k] += z[j, k]


@kernel
def add_element(chain, work, m, i, w, dofs):
    """Add element m, whose end is node i, to the front w (y, A')."""
    b = len(chain.dofs)
    full, coupling, inertia = work.iteration[m], work.carrier[0], work.carrier[1]
    if len(dofs) == 3:
        plane.element_coupling(chain, work, m, i, coupling, inertia)
        if work.scale[0] > 0.0:
            plane.add_pulled_carrier(chain, work, m, i, work.scale[0], inertia)
    else:
        space.element_coupling(chain, work, m, i, coupling, inertia)
        if work.scale[0] > 0.0:
            space.add_pulled_carrier(chain, work, m, i, work.scale[0], inertia)
    for j in range(b):
        for k in range(j, b):
            w[j, k] += full[j, k]
            w[b + j, b + k] += inertia[j, k]
    if len(dofs) == 3:
        # the carrier turns with b
        for k in range(3):
            w[0, 3 + k] += coupling[0, k]
            w[1, 3 + k] += coupling[1, k] + inertia[2, k]
            w[2, 3 + k] += coupling[2, k]
        w[0, 1] += coupling[0, 2]
        w[1, 1] += 2.0 * coupling[1, 2] + inertia[2, 2]
        w[1, 2] += coupling[2, 2]
        if chain.element[m, STIFFENING] > 0.0:
            plane.shift_mass(chain, work, m, i, w)
            if work.scale[0] > 0.0:
                plane.stiffen(chain, work, m, i, work.scale[0], w)
        return
    f = work.moving[i]
    # G by columns, how the carrier turns with b_z, b_y and tau
    x0, x1, x2 = tangent(f, TURN, SERIES, -1.0, 0.0, 0.0, 1.0)
    y0, y1, y2 = tangent(f, TURN, SERIES, -1.0, 0.0, 1.0, 0.0)
    z0, z1, z2 = tangent(f, TURN, SERIES, -1.0, 0.5, 0.0, 0.0)
    # coupling + G^T inertia / 2, so that its product with G, made symmetric, is what G adds to y
    for k in range(6):
        a, b1, c = 0.5 * inertia[3, k], 0.5 * inertia[4, k], 0.5 * inertia[5, k]
        p, q, r = x0 * a + x1 * b1 + x2 * c, y0 * a + y1 * b1 + y2 * c, z0 * a + z1 * b1 + z2 * c
        coupling[1, k] += p
        coupling[2, k] += q
        coupling[3, k] += r
        w[0, 6 + k] += coupling[0, k]
        w[1, 6 + k] += coupling[1, k] + p
        w[2, 6 + k] += coupling[2, k] + q
        w[3, 6 + k] += coupling[3, k] + r
        w[4, 6 + k] += coupling[4, k]
        w[5, 6 + k] += coupling[5, k]
    for j in range(6):
        a, b1, c = coupling[j, 3], coupling[j, 4], coupling[j, 5]
        coupling[j, 0] = a * x0 + b1 * x1 + c * x2
        coupling[j, 1] = a * y0 + b1 * y1 + c * y2
        coupling[j, 2] = a * z0 + b1 * z1 + c * z2
    for k in range(3):
        w[0, 1 + k] += coupling[0, k]
        w[1 + k, 4] += coupling[4, k]
        w[1 + k, 5] += coupling[5, k]
        for j in range(k + 1):
            w[1 + j, 1 + k] += coupling[1 + j, k] + coupling[1 + k, j]
    if chain.element[m, STIFFENING] > 0.0:
        space.shift_mass(chain, work, m, i, w)
        if work.scale[0] > 0.0:
            space.stiffen(chain, work, m, i, work.scale[0], w)


@kernel
def eliminate_unknowns(index, work, i, w, b):
    """Eliminate y of node i from the front, keep its rows; False where a pivot is not positive."""
    size = 2 * b
    for p in range(b):
        row = work.pivot[i * b + p]
        if index[i, p] < 0:
            for k in range(size + 1):
                row[k] = 0.0
            continue
        if not w[p, p] > 0.0:
            return False
        inverse = 1.0 / w[p, p]
        for k in range(p + 1):
            row[k] = 0.0
        for k in range(p + 1, size):
            row[k] = w[p, k]
        row[size] = inverse
        for j in range(p + 1, b):
            c = inverse * row[j]
            for k in range(j, size):
                w[j, k] -= c * row[k]
    r = work.pivot[i * b : i * b + b]
    if b == 3:
        for j in range(3, 6):
            c0, c1, c2 = r[0, j] * r[0, 6], r[1, j] * r[1, 6], r[2, j] * r[2, 6]
            for k in range(j, 6):
                w[j, k] -= c0 * r[0, k] + c1 * r[1, k] + c2 * r[2, k]
    else:
        for j in range(6, 12):
            c0, c1, c2 = r[0, j] * r[0, 12], r[1, j] * r[1, 12], r[2, j] * r[2, 12]
            c3, c4, c5 = r[3, j] * r[3, 12], r[4, j] * r[4, 12], r[5, j] * r[5, 12]
            for k in range(j, 12):
                w[j, k] -= (c0 * r[0, k] + c1 * r[1, k] + c2 * r[2, k]) + (
                    c3 * r[3, k] + c4 * r[4, k] + c5 * r[5, k]
                )
    return True


@kernel
def joint_column(chain, n, dofs, column):
    """Direction of the joint's coordinate in the acceleration of its link's start."""
    joint = chain.joint
    if len(dofs) == 3:
        column[0] = column[1] = 0.0
        column[2] = joint[n, AXIS + 2]
        return
    h = 3 if chain.link[n, KIND] == REVOLUTE else 0
    for k in range(3):
        column[k] = column[3 + k] = 0.0
    for k in range(3):
        column[h + k] = joint[n, AXIS + k]


@kernel
def eliminate_joint(chain, work, n, z, dofs):
    """Eliminate the joint's coordinate from z; False where its pivot is not positive."""
    if not free(chain.link, work.held, n):
        return True
    b = len(chain.dofs)
    column, row = work.row[3], work.joint_pivot[n, 1]
    joint_column(chain, n, dofs, column)
    pivot = own_pivot(chain, work, n)
    for i in range(b):
        total = 0.0
        for k in range(b):
            total += z[i, k] * column[k]
        row[i] = total
        pivot += column[i] * total
    if not pivot > 0.0:
        return False
    row[b] = 1.0 / pivot
    for i in range(b):
        c = row[b] * row[i]
        for k in range(b):
            z[i, k] -= c * row[k]
    return True


@kernel
def factorize(chain, work):
    """Factorise at the placed configuration; returns 0, or 1 + the link whose pivot is not positive."""
    link, index, w = chain.link, chain.unknown, work.front
    b = len(chain.dofs)
    dofs = chain.dofs
    work.section_matrix[:] = 0.0
    for n in range(link.shape[0] - 1, -1, -1):
        first, parent = link[n, FIRST], link[n, PARENT]
        if link[n, BODIES] > 0:
            section_bodies(chain, work, n, dofs)
        for i in range(first + link[n, COUNT], first, -1):
            for j in range(2 * b):
                for k in range(j, 2 * b):
                    w[j, k] = 0.0
            keep(work, i, dofs)
            add_element(chain, work, link[n, FIRST_ELEMENT] + i - first - 1, i, w, dofs)
            if work.section_matrix[i, 0, 0] > 0.0:
                add_section(work, i, work.row[1], work.row[2], w, dofs)
            if not eliminate_unknowns(index, work, i, w, b):
                return n + 1
            z, before = work.square, work.section_matrix[i - 1]
            for j in range(b):
                for k in range(j, b):
                    z[j, k] = z[k, j] = w[b + j, b + k]
            turn_matrix(work.moving[i, ROTATION : ROTATION + 9], z, dofs)
            for j in range(b):
                for k in range(b):
                    before[j, k] += z[j, k]
        z, m, kept = work.section_matrix[first], work.moving[first], work.kept_moving[first]
        for k in range(9):
            kept[k] = m[ROTATION + k]
        if not eliminate_joint(chain, work, n, z, dofs):
            return n + 1
        if parent >= 0:
            turn_matrix(m[ROTATION : ROTATION + 9], z, dofs)
            if link[n, KIND] == PRISMATIC:
                kept[9], kept[10], kept[11] = m[LEAD], m[LEAD + 1], m[LEAD + 2]
                shift(z, kept[9], kept[10], kept[11], dofs)
            before = work.section_matrix[link[parent, FIRST] + link[parent, COUNT]]
            for j in range(b):
                for k in range(b):
                    before[j, k] += z[j, k]
    return 0
