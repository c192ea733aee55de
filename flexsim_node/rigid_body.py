"""A rigid body that rides on a node: payloads, wrist bodies, motors.

A point r of the body (from the node, in the link's beam axes) is at node + u + r + theta x r, the same
linear field as a beam's section.  So the body is four vectors, the node and the images of e_x, e_y, e_z,
with the constant (4, 4) mass matrix [[m, m c^T], [m c, integral of r r^T]].
"""

from __future__ import annotations

import numpy as np

from .kernel import kernel
from .spatial_beam import leave_out_softening


def pseudo_inertia(mass: float, center: np.ndarray, inertia: np.ndarray) -> np.ndarray:
    """(4, 4) mass matrix of a body from mass (kg), centre of mass (3,) and inertia about it (3, 3)."""
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia + mass * np.outer(center, center)
    matrix = np.empty((4, 4))
    matrix[0, 0] = mass
    matrix[0, 1:] = matrix[1:, 0] = mass * np.asarray(center)
    matrix[1:, 1:] = second
    return matrix


@kernel
def body_vectors(row, x, rest, c):
    """Write node and directors of nodal row (6,) into c (4, 3); rest = 1 adds the undeformed shape."""
    c[0, 0], c[0, 1], c[0, 2] = row[0] + rest * x, row[1], row[2]
    c[1, 0], c[1, 1], c[1, 2] = rest, row[5], -row[4]
    c[2, 0], c[2, 1], c[2, 2] = -row[5], rest, row[3]
    c[3, 0], c[3, 1], c[3, 2] = row[4], -row[3], rest


@kernel
def spread(g, force):
    """Add forces g (4, 3) on node and directors to the nodal force (6,)."""
    for k in range(3):
        force[k] += g[0, k]
    force[3] += g[2, 2] - g[3, 1]
    force[4] += g[3, 0] - g[1, 2]
    force[5] += g[1, 1] - g[2, 0]


@kernel
def products(mass, c, out):
    """out = mass c, (4, 4) times (4, 3)."""
    for j in range(4):
        for k in range(3):
            total = 0.0
            for n in range(4):
                total += mass[j, n] * c[n, k]
            out[j, k] = total


@kernel
def inertia_force(mass, x, frame, d, v, a, alpha, coriolis, spin, force, wrench, t):
    """Add the body's inertia forces to the nodal force (6,) and the link's wrench (6,).

    mass is the (4, 4) matrix, x the node's place on the link; d, v, a are nodal rows (6,); frame,
    coriolis and spin as in spatial_beam, alpha Rayleigh's mass coefficient; t is scratch (30, 3).
    """
    c, cv, ca, g = t[0:4], t[4:8], t[8:12], t[12:16]
    body_vectors(d, x, 1.0, c)
    body_vectors(v, 0.0, 0.0, cv)
    body_vectors(a, 0.0, 0.0, ca)
    for k in range(4):
        for p in range(3):
            q, r = (p + 1) % 3, (p + 2) % 3
            ca[k, p] += alpha * cv[k, p]
            across = frame[q] * c[k, r] - frame[r] * c[k, q]
            ca[k, p] += frame[6 + q] * c[k, r] - frame[6 + r] * c[k, q]
            if coriolis:
                ca[k, p] += 2.0 * (frame[q] * cv[k, r] - frame[r] * cv[k, q])
            ca[k, q] += frame[r] * across
            ca[k, r] -= frame[q] * across
    for k in range(3):
        ca[0, k] += frame[3 + k]
    products(mass, ca, g)
    for k in range(3):
        p, q = (k + 1) % 3, (k + 2) % 3
        wrench[k] += g[0, k]
        for j in range(4):
            wrench[3 + k] += c[j, p] * g[j, q] - c[j, q] * g[j, p]
    if not spin:
        body_vectors(d, x, 0.0, c)
        h = t[16:20]
        products(mass, c, h)
        leave_out_softening(frame, h, 4, g)
    spread(g, force)


@kernel
def inertia_coupling(mass, x, d, coupling, inertia, t):
    """Write d(force)/d(link acceleration) into coupling (6, 6), add the link's own to inertia (6, 6)."""
    coupling[:] = 0.0
    c, q, g = t[0:4], t[4:8], t[8:12]
    body_vectors(d, x, 1.0, c)
    products(mass, c, q)
    for k in range(3):
        p, r = (k + 1) % 3, (k + 2) % 3
        inertia[k, k] += mass[0, 0]
        # translation along e_k
        for j in range(4):
            for n in range(3):
                g[j, n] = 0.0
            g[j, k] = mass[j, 0]
        spread(g, coupling[:, k])
        # rotation about e_k: e_k x q
        for j in range(4):
            g[j, k] = 0.0
            g[j, p] = -q[j, r]
            g[j, r] = q[j, p]
        spread(g, coupling[:, 3 + k])
        for j in range(4):
            inertia[3 + k, 3 + k] += c[j, p] * q[j, p] + c[j, r] * q[j, r]
        for n in range(k + 1, 3):
            for j in range(4):
                inertia[3 + k, 3 + n] -= c[j, k] * q[j, n]
    inertia[0, 4] += q[0, 2]
    inertia[0, 5] -= q[0, 1]
    inertia[1, 3] -= q[0, 2]
    inertia[1, 5] += q[0, 0]
    inertia[2, 3] += q[0, 1]
    inertia[2, 4] -= q[0, 0]


def body_mass(matrix: np.ndarray) -> np.ndarray:
    """(6, 6) mass matrix of a body over the dofs of its node."""
    vectors = np.zeros((6, 4, 3))
    for k, unit in enumerate(np.eye(6)):
        body_vectors(unit, 0.0, 0.0, vectors[k])
    return np.einsum("iak,ab,jbk->ij", vectors, matrix, vectors)
