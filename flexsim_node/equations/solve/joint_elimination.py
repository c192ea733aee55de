"""Elimination of a link's joint: its elastic rotation and its coordinate, with the motor behind a spring.

The matrix is the symmetric z over (start node, A) that is left of a link; see factorization.py.
"""

from __future__ import annotations

from ...compiled.flat import flat
from ...compiled.kernel import kernel
from ...compiled.weighted_sum import add_later_rows, twelve_once
from ...model.chain import (
    AXIS,
    BY_Q,
    DAMPER,
    FIXED,
    KIND,
    MOTOR,
    PHI,
    REVOLUTE,
    ROTOR,
    SPRING,
    TURN_AXIS,
    VISCOUS,
)


@kernel
def free(link, held, n):
    """Whether a link's joint coordinate is an unknown: held joints are not, unless their motor is held."""
    return link[n, KIND] != FIXED and (link[n, MOTOR] >= 0 or not held[n])


@kernel
def joint_vectors(kind, joint, f, n, b, phi_column, q_column):
    """Directions of (start node, A) that belong to the joint's elastic rotation and to its coordinate."""
    for k in range(2 * b):
        phi_column[k] = 0.0
        q_column[k] = 0.0
    if b == 3:
        phi_column[2] = joint[n, AXIS + 2]
        q_column[0], q_column[1], q_column[2] = f[BY_Q], f[BY_Q + 1], f[BY_Q + 5]
        q_column[5] = joint[n, AXIS + 2]
        return
    h = 9 if kind == REVOLUTE else 6
    for k in range(3):
        phi_column[3 + k] = f[TURN_AXIS + k]
        q_column[k] = f[BY_Q + k]
        q_column[3 + k] = f[BY_Q + 3 + k]
        q_column[h + k] = joint[n, AXIS + k]


@kernel
def times(z, y, out, size):
    """out = z y for a symmetric z."""
    if size == 12:
        twelve_once(12, y, 0, 1, 0, flat(z), 0, 12, out, 0, 0)
        return
    for i in range(size):
        total = 0.0
        for k in range(size):
            total += z[i, k] * y[k]
        out[i] = total


@kernel
def rank_one(z, row, scale, size, weights):
    """z -= scale row row^T; weights is scratch."""
    if size == 12:
        for k in range(12):
            weights[k] = -scale * row[k]
        add_later_rows(1, weights, 0, 0, 1, row, 0, 0, flat(z), 0, 12)
        add_later_rows(1, weights, 6, 0, 1, row, 0, 0, flat(z), 72, 12)
        return
    for i in range(size):
        c = scale * row[i]
        for k in range(size):
            z[i, k] -= c * row[k]


@kernel
def own_pivot(chain, work, n):
    """What a joint's coordinate has in the matrix of its own: rotor and losses.

    A motor's own angle is eliminated here, and leaves its inertia behind the spring.
    """
    joint = chain.joint
    rotor = joint[n, ROTOR] + work.scale[1] * joint[n, VISCOUS]
    if chain.link[n, MOTOR] < 0:
        return rotor
    spring = work.scale[2] * joint[n, SPRING] + work.scale[1] * joint[n, DAMPER]
    inverse = 0.0 if work.held[n] else 1.0 / (rotor + spring)
    work.spring[n, 0], work.spring[n, 1] = spring, inverse
    return spring - spring * spring * inverse


@kernel
def eliminate_joint(chain, work, n, z, b, phi_column, q_column):
    """Eliminate the joint's elastic rotation and coordinate from z; False where a pivot is not positive."""
    link = chain.link
    moves = free(link, work.held, n)
    has_phi = link[n, PHI] >= 0
    if not (moves or has_phi):
        return True
    rotor = own_pivot(chain, work, n)
    joint_vectors(link[n, KIND], chain.joint, work.kept[n], n, b, phi_column, q_column)
    row_phi, row_q = work.joint_pivot[n, 0], work.joint_pivot[n, 1]
    across = 0.0
    size = 2 * b
    if moves:
        times(z, q_column, row_q, size)
        pivot = rotor
        for k in range(size):
            pivot += q_column[k] * row_q[k]
    if has_phi:
        times(z, phi_column, row_phi, size)
        own = rotor
        for k in range(size):
            own += phi_column[k] * row_phi[k]
            if moves:
                across += phi_column[k] * row_q[k]
        if not own > 0.0:
            return False
        row_phi[size] = 1.0 / own
        if moves:
            across += rotor
            row_phi[size + 1] = across
            pivot -= across * across / own
            for k in range(size):
                row_q[k] -= row_phi[k] * across / own
        rank_one(z, row_phi, row_phi[size], size, work.row[5])
    if moves:
        if not pivot > 0.0:
            return False
        row_q[size] = 1.0 / pivot
        rank_one(z, row_q, row_q[size], size, work.row[5])
    return True
