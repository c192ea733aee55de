"""Solve with the factors at hand (factorization.py), forth and back along the chain.

It works on the frames that `factorize` kept, wherever the links have been placed since.
"""

from __future__ import annotations

from ...compiled.kernel import kernel
from ...model.chain import BOWED, COUNT, FIRST, FIXED, KIND, MOTOR, PARENT, PHI, RELATIVE, Q
from ...model.reduced.layout import MODES
from ..forces.damping import oppose
from ..reduced import link as reduced_link
from . import co_moving_substitution as substitution
from . import node_substitution
from .factorization import bowed_row
from .interface import hand_load, take_answer
from .joint_elimination import free, joint_vectors

GRADIENTS = 200  # conjugate gradients at most
RESIDUAL = 1e-14  # of the energy of what is found, that conjugate gradients leave


@kernel
def solve(chain, work, rhs, out):
    """Solve for out (n,) with the factors at hand; rhs (n,) is kept.  Held joints get zero.

    With Rayleigh's alpha the nodes' velocities are spoiled: what looks at them comes before.
    """
    solve_within(chain, work, rhs, out, RESIDUAL)


@kernel
def solve_within(chain, work, rhs, out, residual):
    """solve, with Rayleigh's alpha but for this share of the energy of what is found."""
    solve_as(chain.co_moving, chain, work, rhs, out)
    solve_damped(chain, work, rhs, out, residual)


@kernel
def solve_damped(chain, work, rhs, out, residual):
    """Let out (n,) be the answer with Rayleigh's alpha, from that without.

    The factors have it where it is the nodes' own.  Elsewhere its matrix, alpha P^T M P (damping.py), couples
    every elastic unknown with every other, and the factors are those of the rest.  They precondition
    conjugate gradients, one to three where a step is short against 1/alpha.
    """
    if chain.setting[RELATIVE] == 0.0 or work.scale[1] == 0.0 or work.scale[3] != 1.0:
        return
    r, z, p, rest, whole = work.vector[11], work.vector[12], work.vector[13], work.vector[14], work.vector[15]
    n, factor, energy, found, apart = out.size, work.scale[1], 0.0, 0.0, 0.0
    for i in range(n):
        r[i], z[i], p[i], rest[i], out[i] = rhs[i], out[i], 0.0, 0.0, 0.0
    for k in range(GRADIENTS):
        last, energy = energy, 0.0
        for i in range(n):
            energy += r[i] * z[i]
        # a step of unit length leaves as much of what is left as both matrices are apart
        share = 0.0 if k == 0 else energy / last
        if not energy > 0.0 or (k > 0 and not max(apart * apart, share) * energy > residual * found):
            for i in range(n):
                out[i] += z[i]
            return
        for i in range(n):
            p[i] = z[i] + share * p[i]
            rest[i] = r[i] + share * rest[i]  # the matrix without alpha, times p
            whole[i] = 0.0
        oppose(chain, work, p, whole)
        plain = curvature = 0.0
        for i in range(n):
            whole[i] = rest[i] + factor * whole[i]
            plain += p[i] * rest[i]
            curvature += p[i] * whole[i]
        length, apart = energy / curvature, max(apart, curvature / plain - 1.0)
        found += length * energy
        for i in range(n):
            out[i] += length * p[i]
            r[i] -= length * whole[i]
        solve_as(chain.co_moving, chain, work, r, z)


@kernel
def solve_as(co, chain, work, rhs, out):
    """solve for either formulation."""
    if len(co) > 0:
        substitution.solve(chain, work, rhs, out)
    else:
        solve_erls(chain, work, rhs, out)


@kernel
def solve_erls(chain, work, rhs, out):
    """solve for frames of the ERLS."""
    link = chain.link
    index, dependency = chain.unknown, chain.dependency
    b = len(chain.dofs)
    planar = b == 3
    load, answer = work.load, work.answer
    load[:] = 0.0
    f = work.row[1]
    phi_column, q_column = work.row[2], work.row[3]
    r, s = work.row[0, 0:6], work.row[0, 6:12]
    for n in range(link.shape[0] - 1, -1, -1):
        first, count = link[n, FIRST], link[n, COUNT]
        for k in range(b):
            f[k] = load[n, k]
            f[b + k] = 0.0
            f[2 * b + k] = load[n, b + k]
        modal_loads(chain.reduction, chain, work, n, rhs, out, f)
        i = first + count
        while i > first:
            i = nodes_forward(chain.dofs, chain, work, i, first, rhs, f, out)
            if i == first:
                break
            if chain.joint[n, BOWED] > 0.0:
                bowed_row(dependency[i, 0], work.kept[n], b, work.row[5])
                for j in range(2 * b):
                    f[j] += (work.row[5, j] - dependency[i, 0, j]) * f[0]
            for p in range(b):
                if index[i, p] < 0:
                    for j in range(2 * b):
                        f[j] += dependency[i, p, j] * f[p]
                    f[p] = 0.0
            for p in range(b):
                if index[i, p] < 0:
                    continue
                row = work.pivot[i * b + p]
                y = (f[p] + rhs[index[i, p]]) * row[3 * b]
                out[index[i, p]] = y
                for k in range(3 * b):
                    f[k] -= row[k] * y
            for k in range(b):
                f[k] = f[b + k]
                f[b + k] = 0.0
            i -= 1
        moves = free(link, work.held, n)
        g = load[n]
        for k in range(b):
            g[k] = f[k]
            g[b + k] = f[2 * b + k]
        if moves or link[n, PHI] >= 0:
            joint_vectors(link[n, KIND], chain.joint, work.kept[n], n, b, phi_column, q_column)
            row_phi, row_q = work.joint_pivot[n, 0], work.joint_pivot[n, 1]
            y = pull = 0.0
            if link[n, MOTOR] >= 0:
                pull = work.spring[n, 0] * work.spring[n, 1] * rhs[link[n, MOTOR]]
            if moves:
                y = rhs[link[n, Q]] + pull
                for k in range(2 * b):
                    y += q_column[k] * g[k]
            if link[n, PHI] >= 0:
                turn = rhs[link[n, PHI]] + pull
                for k in range(2 * b):
                    turn += phi_column[k] * g[k]
                turn *= row_phi[2 * b]
                out[link[n, PHI]] = turn
                y -= row_phi[2 * b + 1] * turn if moves else 0.0
                for k in range(2 * b):
                    g[k] -= row_phi[k] * turn
            if moves:
                y *= row_q[2 * b]
                out[link[n, Q]] = y
                for k in range(2 * b):
                    g[k] -= row_q[k] * y
        parent = link[n, PARENT]
        if parent >= 0:
            hand_load(chain, work, n, g, r, s, planar)
    for n in range(link.shape[0]):
        first, count, parent = link[n, FIRST], link[n, COUNT], link[n, PARENT]
        z = answer[n]
        for k in range(2 * b):
            z[k] = 0.0
        if parent >= 0:
            take_answer(chain, work, n, z, s, planar)
        moves = free(link, work.held, n)
        if moves or link[n, PHI] >= 0:
            joint_vectors(link[n, KIND], chain.joint, work.kept[n], n, b, phi_column, q_column)
            row_phi, row_q = work.joint_pivot[n, 0], work.joint_pivot[n, 1]
            y = turn = 0.0
            if moves:
                y = out[link[n, Q]]
                for k in range(2 * b):
                    y -= row_q[2 * b] * row_q[k] * z[k]
                out[link[n, Q]] = y
            if link[n, PHI] >= 0:
                turn = row_phi[2 * b + 1] * y if moves else 0.0
                for k in range(2 * b):
                    turn += row_phi[k] * z[k]
                turn = out[link[n, PHI]] - row_phi[2 * b] * turn
                out[link[n, PHI]] = turn
            for k in range(2 * b):
                z[k] += q_column[k] * y + phi_column[k] * turn
            motor = link[n, MOTOR]
            if motor >= 0:
                out[motor] = work.spring[n, 1] * (rhs[motor] + work.spring[n, 0] * (y + turn))
        if link[n, KIND] != FIXED and not moves:
            out[link[n, Q]] = 0.0
        # f holds (node, node before, A)
        for k in range(b):
            f[b + k] = z[k]
            f[2 * b + k] = z[b + k]
        i = first + 1
        while i <= first + count:
            i = nodes_backward(chain.dofs, chain, work, i, first + count, f, out)
            if i > first + count:
                break
            for p in range(b):
                f[p] = 0.0
            for p in range(b - 1, -1, -1):
                if index[i, p] < 0:
                    continue
                row = work.pivot[i * b + p]
                total = 0.0
                for k in range(p + 1, 3 * b):
                    total += row[k] * f[k]
                f[p] = out[index[i, p]] - row[3 * b] * total
                out[index[i, p]] = f[p]
            for p in range(b):
                if index[i, p] < 0:
                    total = 0.0
                    for j in range(2 * b):
                        total += dependency[i, p, j] * f[j]
                    f[p] = total
            if chain.joint[n, BOWED] > 0.0:
                bowed_row(dependency[i, 0], work.kept[n], b, work.row[5])
                for j in range(b, 2 * b):
                    f[0] += (work.row[5, j] - dependency[i, 0, j]) * f[j]
            for k in range(b):
                f[b + k] = f[k]
            i += 1
        modal_answers(chain.reduction, chain, work, n, f, z, out)
        for k in range(b):
            z[k] = f[b + k]


@kernel
def nodes_forward(dofs, chain, work, i, first, rhs, f, out):
    """The first half of `solve` along nodes with unknowns alone; returns the node where it ends."""
    if len(dofs) == 6:
        return node_substitution.forward(chain, work, i, first, rhs, f, out)
    return i


@kernel
def nodes_backward(dofs, chain, work, i, last, f, out):
    """The second half of `solve` along nodes with unknowns alone; returns the node where it ends."""
    if len(dofs) == 6:
        return node_substitution.backward(chain, work, i, last, f, out)
    return i


@kernel
def modal_loads(reduction, chain, work, n, rhs, out, f):
    """First half of `solve` for the modes of link n, where it is reduced."""
    if len(reduction) == 0:
        return
    size, first = chain.reduced[n], chain.link[n, FIRST]
    if size[MODES] >= 0:
        reduced_link.forward(size, work.modal, chain.unknown, first, len(chain.dofs), rhs, out, f)


@kernel
def modal_answers(reduction, chain, work, n, f, z, out):
    """Second half of `solve` for the modes of link n, where it is reduced."""
    if len(reduction) == 0:
        return
    size, first, b = chain.reduced[n], chain.link[n, FIRST], len(chain.dofs)
    if size[MODES] >= 0:
        reduced_link.backward(size, work.modal, chain.unknown, first, b, f[b : 2 * b], z, out)
