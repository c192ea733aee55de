"""Factorise M + c K + joint terms in a time that is linear in links and elements.

The matrix over the unknowns is dense where joint coordinates couple to everything beyond them.  With the
accelerations A of each link's frame as intermediate unknowns it is a chain: a node couples to the node before
it and to A; a link hands its parent one symmetric matrix over (end node, A).  Nodes are eliminated from the
tip to the base, each link's joint last (the articulated-body idea, with elastic nodes).

substitution.py solves with the factors.
"""

from __future__ import annotations

from ...compiled.flat import flat
from ...compiled.kernel import kernel
from ...compiled.weighted_sum import (
    add_last_planar_rows,
    add_last_rows,
    add_later_planar_rows,
    add_later_rows,
)
from ...elements import planar_beam, rigid_body, spatial_beam
from ...elements.beam import STIFFENING, TURNING
from ...elements.spatial_strain import iteration_turning
from ...model.chain import (
    BODIES,
    BOW,
    BOWED,
    COUNT,
    DISPLACEMENT,
    FIRST,
    FIRST_BODY,
    FIRST_ELEMENT,
    PARENT,
    SPIN,
)
from ...model.reduced.layout import MODES, TENSION, TENSIONS
from ..forces.damping import nodal_alpha
from ..kinematics.nodal_motion import spatial_row
from ..reduced import link as reduced_link
from ..reduced import plane as planar_reduced_beam
from ..reduced import space_coupling as spatial_reduced_coupling
from . import co_moving_factorization as elimination
from .interface import hand_over, hand_over_planar
from .joint_elimination import eliminate_joint


@kernel
def set_scale(chain, work, stiffness, damping, spring):
    """Choose the matrix: M + stiffness * K + damping * (losses) + spring * (joints' springs)."""
    work.scale[0], work.scale[1], work.scale[2] = stiffness, damping, spring
    work.scale[3] = heavier = 1.0 + damping * nodal_alpha(chain)
    w = work.iteration
    for e in range(w.shape[0]):
        # where strains turn, the whole stiffness changes with the configuration
        constant = 0.0 if len(chain.dofs) == 6 and chain.element[e, TURNING] > 0.0 else stiffness
        for i in range(w.shape[1]):
            for k in range(w.shape[1]):
                w[e, i, k] = heavier * chain.mass[e, i, k] + constant * chain.stiffness[e, i, k]
    set_modal_scale(chain.reduction, chain, work, stiffness, heavier)


@kernel
def set_modal_scale(reduction, chain, work, scale, heavier):
    """Let the matrices of reduced links be what their modes leave of them."""
    if len(reduction) == 0:
        return
    for n in range(chain.link.shape[0]):
        size, w = chain.reduced[n], work.iteration[chain.link[n, FIRST_ELEMENT]]
        if size[MODES] >= 0:
            reduced_link.choose_matrix(size, chain.modal, work.modal, len(chain.dofs), scale, heavier, w)


@kernel
def fold(w, p, coefficient, b, size):
    """Replace unknown p of the front by a combination of unknowns 0..2b (p left out).

    Its own row and column stay as they are: nothing looks at them any more.
    """
    for j in range(2 * b):
        c = coefficient[j]
        if c == 0.0:
            continue
        for k in range(size):
            if k == p:
                continue
            value = c * (w[p, k] if p < k else w[k, p])
            if j < k:
                w[j, k] += value
            elif k < j:
                w[k, j] += value
            else:
                w[j, j] += 2.0 * value
        for k in range(j, 2 * b):
            w[j, k] += c * coefficient[k] * w[p, p]


@kernel
def bowed_row(dependency, f, b, row):
    """Write on what a rigid link's end depends along the link, with its start's slopes, into row."""
    for k in range(2 * b):
        row[k] = dependency[k]
    if b == 3:
        row[b + 2] -= f[BOW]
    else:
        row[b + 4] -= f[BOW]
        row[b + 5] -= f[BOW + 1]


@kernel
def add_bodies(chain, work, n, i, w, at, b):
    """Add the rigid bodies on node i of link n, the one from row `at` on, to the front."""
    link = chain.link
    planar = b == 3
    for m in range(link[n, FIRST_BODY], link[n, FIRST_BODY] + link[n, BODIES]):
        if chain.body_place[m] != i:
            continue
        coupling = work.row[:, 18:24]
        inertia = work.row[:, 24:30]
        inertia[:] = 0.0
        r, turning = work.row[0, 0:6], chain.setting[SPIN]
        spatial_row(work.node[DISPLACEMENT, i], planar, r)
        rigid_body.inertia_coupling(
            chain.body[m], chain.place[i], r, turning, coupling, inertia, work.scratch
        )
        own, elastic = work.row[:, 30:36], work.scale[3] - 1.0
        rigid_body.own_mass(chain.body[m], r, turning, own, work.row[0, 6:12], work.scratch)
        for j in range(b):
            p = 5 if planar and j == 2 else j
            for k in range(b):
                q = 5 if planar and k == 2 else k
                w[at + j, 2 * b + k] += coupling[p, q]
                if k >= j:
                    w[at + j, at + k] += own[p, q] + elastic * chain.body_mass[m, j, k]
                    w[2 * b + j, 2 * b + k] += inertia[p, q]


@kernel
def element_terms(dofs, e, d, i, scale, coupling, row, gradients, scratch, w):
    """Add to the front over (node i, node before, A) what of an element is not constant."""
    b = len(dofs)
    if len(dofs) == 3:
        planar_beam.inertia_coupling(e, d, i, coupling, w[6:9, 6:9])
        if e[STIFFENING] > 0.0:
            planar_beam.shift_mass(e, d, i, w)
            if scale > 0.0:
                planar_beam.iteration_stiffness(e, d, i, scale, row, w)
    else:
        spatial_beam.inertia_coupling(e, d, i, coupling, w[12:18, 12:18], scratch)
        if e[STIFFENING] > 0.0:
            spatial_beam.shift_mass(e, d, i, row, w)
            if scale > 0.0 and e[TURNING] > 0.0:
                iteration_turning(e, d[i - 1], d[i], scale, gradients, w)
            elif scale > 0.0:
                spatial_beam.iteration_stiffness(e, d, i, scale, row, w)
    for j in range(b):
        for k in range(b):
            w[j, 2 * b + k] += coupling[b + j, k]
            w[b + j, 2 * b + k] += coupling[j, k]


@kernel
def reduced_terms(reduction, dofs, chain, work, n, w):
    """`element_terms` of link n as a whole, where it is reduced to modes; False where it is not.

    The modes are eliminated from the front here: their rows hold what they have in common with it.
    """
    if len(reduction) == 0:
        return False
    size, e = chain.reduced[n], chain.element[chain.link[n, FIRST_ELEMENT]]
    if size[MODES] < 0:
        return False
    data, own = chain.modal, work.modal
    b, scale = len(dofs), work.scale[0]
    if len(dofs) == 3:
        planar_reduced_beam.inertia_coupling(size, data, own, e, w[3:6, 6:9], w[0:3, 6:9], w[6:9, 6:9])
    else:
        start, end, inertia = w[6:12, 12:18], w[0:6, 12:18], w[12:18, 12:18]
        spatial_reduced_coupling.inertia_coupling(size, data, own, e, start, end, inertia)
    if scale > 0.0:
        for j in range(size[TENSIONS]):
            reduced_link.tension_row(size, data, own, e, b, j, scale * data[size[TENSION] + j])
    reduced_link.eliminate_modes(size, own, b, w)
    return True


@kernel
def hand_matrix(dofs, chain, work, n, z):
    """Add what is left of link n, over (start node, A), to its parent's interface."""
    if len(dofs) == 3:
        hand_over_planar(chain, work, n, z)
    else:
        hand_over(chain, work, n, z)


@kernel
def next_node(w, b):
    """Move the node before to the place of the one that is eliminated."""
    for j in range(b):
        for k in range(b):
            w[j, k] = w[b + j, b + k]
            w[j, b + k] = 0.0
            w[j, 2 * b + k] = w[b + j, 2 * b + k]
        for k in range(b, 3 * b):
            w[b + j, k] = 0.0


@kernel
def eliminate_node(index, work, i, b):
    """Eliminate node i from the front, keep its rows; False where a pivot is not positive."""
    w, size = work.front, 3 * b
    for p in range(b):
        row = work.pivot[i * b + p]
        if index[i, p] < 0:
            for k in range(size + 1):
                row[k] = 0.0
            continue
        if not w[p, p] > 0.0:
            return False
        inverse = 1.0 / w[p, p]
        for k in range(size):
            row[k] = w[p, k]
        row[size] = inverse
        for j in range(p + 1, b):
            c = inverse * row[j]
            for k in range(size):
                w[j, k] -= c * row[k]
    # what is left of node before and A, all pivots at once; the lower triangle is not looked at
    weights, rows, front = flat(work.row), flat(work.pivot), flat(w)
    first, width, apart = i * b * (size + 1), size + 1, work.row.shape[1]
    for p in range(b):
        row, at = work.pivot[i * b + p], p * apart
        for j in range(2 * b):
            weights[at + j] = -row[size] * row[b + j]
    if b == 3:
        add_later_planar_rows(3, weights, 0, apart, 1, rows, first + 3, width, front, 30, 9)
        add_last_planar_rows(3, weights, 3, apart, 1, rows, first + 6, width, front, 60, 9)
    else:
        add_later_rows(6, weights, 0, apart, 1, rows, first + 6, width, front, 114, 18)
        add_last_rows(6, weights, 6, apart, 1, rows, first + 12, width, front, 228, 18)
    return True


@kernel
def factorize(chain, work):
    """Factorise at the placed configuration; returns 0, or 1 + the link whose pivot is not positive."""
    return factorize_as(chain.co_moving, chain, work)


@kernel
def factorize_as(co, chain, work):
    """factorize for either formulation; the other one is not even compiled."""
    if len(co) > 0:
        return elimination.factorize(chain, work)
    else:
        return factorize_erls(chain, work)


@kernel
def factorize_erls(chain, work):
    """factorize for frames of the ERLS."""
    link = chain.link
    index, dependency = chain.unknown, chain.dependency
    b = len(chain.dofs)
    w, d = work.front, work.node[DISPLACEMENT]
    size = 3 * b
    work.interface[:] = 0.0
    for n in range(work.kept.shape[0]):
        for k in range(work.kept.shape[1]):
            work.kept[n, k] = work.frame[n, k]
    phi_column, q_column = work.row[2], work.row[3]
    for n in range(link.shape[0] - 1, -1, -1):
        first, count = link[n, FIRST], link[n, COUNT]
        w[:] = 0.0
        inside = work.interface[n]
        # the interface is ordered (end node, A), the front (node, node before, A)
        for i in range(b):
            for k in range(i, b):
                w[i, k] = inside[i, k]
                w[2 * b + i, 2 * b + k] = inside[b + i, b + k]
            for k in range(b):
                w[i, 2 * b + k] = inside[i, b + k]
        for i in range(first + count, first, -1):
            if i < first + count:
                next_node(w, b)
            m = link[n, FIRST_ELEMENT] + i - first - 1
            e = chain.element[m]
            if not reduced_terms(chain.reduction, chain.dofs, chain, work, n, w):
                own, scratch = work.coupling, work.scratch
                element_terms(chain.dofs, e, d, i, work.scale[0], own, work.row[4], work.gradient, scratch, w)
            full = work.iteration[m]
            for j in range(2 * b):
                for k in range(j, 2 * b):
                    w[j, k] += full[j, k]
            if link[n, BODIES] > 0:
                add_bodies(chain, work, n, i, w, 0, b)
            for p in range(b):
                if index[i, p] < 0:
                    if p == 0 and chain.joint[n, BOWED] > 0.0:
                        bowed_row(dependency[i, 0], work.kept[n], b, work.row[5])
                        fold(w, 0, work.row[5], b, size)
                    else:
                        fold(w, p, dependency[i, p], b, size)
            if not eliminate_node(index, work, i, b):
                return n + 1
        # a link without elements starts at its end
        start = b if count > 0 else 0
        if link[n, BODIES] > 0:
            add_bodies(chain, work, n, first, w, start, b)
        # (start node, A): pull the two blocks together, both triangles
        z = inside
        for i in range(b):
            for k in range(i, b):
                z[i, k] = z[k, i] = w[start + i, start + k]
                z[b + i, b + k] = z[b + k, b + i] = w[2 * b + i, 2 * b + k]
            for k in range(b):
                z[i, b + k] = z[b + k, i] = w[start + i, 2 * b + k]
        if not eliminate_joint(chain, work, n, z, b, phi_column, q_column):
            return n + 1
        if link[n, PARENT] >= 0:
            hand_matrix(chain.dofs, chain, work, n, z)
    return 0
