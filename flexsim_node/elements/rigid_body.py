"""A rigid body that rides on a node: payloads, wrist bodies, motors.

A point r of the body (from the node, in the link's beam axes) is at node + u + R(s) r, with the section's
axes to second order in the node's row (section_turn.py, T4), or where the effect `centrifugal` is off to
first.  So the body is four vectors, the node and the images of e_x, e_y, e_z, with the constant (4, 4) mass
matrix [[m, m c^T], [m c, integral of r r^T]].
"""

from __future__ import annotations

import numpy as np

from ..compiled.kernel import kernel
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
def body_vectors(row, x, rest, second, c):
    """Write node and directors of nodal row (6,) into c (4, 3); rest = 1 adds the undeformed shape.

    `second` is 1 for axes to second order, 0 for the linear ones.
    """
    sx, sy, sz = row[3], row[4], row[5]
    c[0, 0], c[0, 1], c[0, 2] = row[0] + rest * x, row[1], row[2]
    c[1, 0], c[1, 1], c[1, 2] = rest - 0.5 * second * (sy * sy + sz * sz), sz, -sy
    shared = 0.5 * second * sy * sz
    c[2, 0], c[2, 1], c[2, 2] = second * sx * sy - sz, rest - 0.5 * second * (sx * sx + sz * sz), sx + shared
    c[3, 0], c[3, 1], c[3, 2] = second * sx * sz + sy, shared - sx, rest - 0.5 * second * (sx * sx + sy * sy)


@kernel
def body_rates(row, rate, second, c):
    """Write the rates of node and directors at nodal row (6,) for its rate (6,) into c (4, 3)."""
    x, y, z = second * row[3], second * row[4], second * row[5]
    vx, vy, vz = rate[3], rate[4], rate[5]
    shared = 0.5 * (z * vy + y * vz)
    c[0, 0], c[0, 1], c[0, 2] = rate[0], rate[1], rate[2]
    c[1, 0], c[1, 1], c[1, 2] = -y * vy - z * vz, vz, -vy
    c[2, 0], c[2, 1], c[2, 2] = y * vx + x * vy - vz, -x * vx - z * vz, vx + shared
    c[3, 0], c[3, 1], c[3, 2] = z * vx + x * vz + vy, shared - vx, -x * vx - y * vy


@kernel
def spread(row, second, g, force):
    """Add forces g (4, 3) on node and directors at nodal row (6,) to the nodal force (6,)."""
    x, y, z = second * row[3], second * row[4], second * row[5]
    for k in range(3):
        force[k] += g[0, k]
    shared = 0.5 * (g[2, 2] + g[3, 1])
    force[3] += g[2, 2] - g[3, 1] + y * g[2, 0] - x * (g[2, 1] + g[3, 2]) + z * g[3, 0]
    force[4] += g[3, 0] - g[1, 2] + x * g[2, 0] - y * (g[1, 0] + g[3, 2]) + z * shared
    force[5] += g[1, 1] - g[2, 0] + x * g[3, 0] - z * (g[1, 0] + g[2, 1]) + y * shared


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
    second = 1.0 if spin else 0.0
    c, cv, ca, g = t[0:4], t[4:8], t[8:12], t[12:16]
    body_vectors(d, x, 1.0, second, c)
    body_rates(d, v, second, cv)
    body_rates(d, a, second, ca)
    if spin:
        vx, vy, vz = v[3], v[4], v[5]
        ca[1, 0] -= vy * vy + vz * vz
        ca[2, 0] += 2.0 * vx * vy
        ca[2, 1] -= vx * vx + vz * vz
        ca[2, 2] += vy * vz
        ca[3, 0] += 2.0 * vx * vz
        ca[3, 1] += vy * vz
        ca[3, 2] -= vx * vx + vy * vy
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
        body_vectors(d, x, 0.0, 0.0, c)
        h = t[16:20]
        products(mass, c, h)
        leave_out_softening(frame, h, 4, g)
    spread(d, second, g, force)


@kernel
def inertia_coupling(mass, x, d, second, coupling, inertia, t):
    """Write d(force)/d(link acceleration) into coupling (6, 6), add the link's own to inertia (6, 6)."""
    coupling[:] = 0.0
    c, q, g = t[0:4], t[4:8], t[8:12]
    body_vectors(d, x, 1.0, second, c)
    products(mass, c, q)
    for k in range(3):
        p, r = (k + 1) % 3, (k + 2) % 3
        inertia[k, k] += mass[0, 0]
        # translation along e_k
        for j in range(4):
            for n in range(3):
                g[j, n] = 0.0
            g[j, k] = mass[j, 0]
        spread(d, second, g, coupling[:, k])
        # rotation about e_k: e_k x q
        for j in range(4):
            g[j, k] = 0.0
            g[j, p] = -q[j, r]
            g[j, r] = q[j, p]
        spread(d, second, g, coupling[:, 3 + k])
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


@kernel
def own_mass(mass, d, second, out, unit, t):
    """Write the body's mass matrix over its node's row d (6,) into out (6, 6); unit (6,), t scratch."""
    c, g = t[0:4], t[4:8]
    for k in range(6):
        for j in range(6):
            unit[j] = 1.0 if j == k else 0.0
            out[k, j] = 0.0
        body_rates(d, unit, second, c)
        products(mass, c, g)
        spread(d, second, g, out[k])


def body_mass(matrix: np.ndarray) -> np.ndarray:
    """(6, 6) mass matrix of a body over the dofs of its undeformed node."""
    vectors, zero = np.zeros((6, 4, 3)), np.zeros(6)
    for k, unit in enumerate(np.eye(6)):
        body_rates(zero, unit, 0.0, vectors[k])
    return np.einsum("iak,ab,jbk->ij", vectors, matrix, vectors)
