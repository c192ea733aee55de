"""What rides on the links' ends, for closure.py: on the rigid sections there, nothing linearised."""

from __future__ import annotations

from ...compiled.kernel import kernel
from ...model.chain import (
    ALPHA,
    ANGULAR,
    COORDINATES,
    COUNT,
    FIRST,
    HALF,
    KIND,
    LEAD,
    LINEAR,
    OMEGA,
    PARENT,
    PRISMATIC,
    RATE,
    REACH,
    ROTATION,
    SLIDE,
    Q,
)
from .space import product, turned, turned_back


@kernel
def poses(chain, work, v):
    """Place (3), rotation (9, row-wise) of the carrier and velocity (3) of each link's end, base frame.

    Velocities are those of the last `accelerate`, with the same v.
    """
    link, moving, pose = chain.link, work.moving, work.pose
    here, other = work.row[0, 0:9], work.row[1, 0:9]
    for n in range(link.shape[0]):
        p, first, parent = pose[n], link[n, FIRST], link[n, PARENT]
        m = moving[first]
        sliding = link[n, KIND] == PRISMATIC
        l0 = l1 = l2 = s0 = s1 = s2 = 0.0
        if sliding:
            rate = v[link[n, Q]]
            l0, l1, l2 = m[LEAD], m[LEAD + 1], m[LEAD + 2]
            s0, s1, s2 = rate * m[SLIDE], rate * m[SLIDE + 1], rate * m[SLIDE + 2]
        if parent >= 0:
            q = pose[parent]
            for k in range(15):
                p[k] = q[k]
            if sliding:
                w = work.section[link[parent, FIRST] + link[parent, COUNT]]
                s0 += w[OMEGA + 1] * l2 - w[OMEGA + 2] * l1
                s1 += w[OMEGA + 2] * l0 - w[OMEGA] * l2
                s2 += w[OMEGA] * l1 - w[OMEGA + 1] * l0
        else:
            for k in range(15):
                p[k] = 1.0 if k == 3 or k == 7 or k == 11 else 0.0
        for k in range(9):
            here[k] = p[3 + k]
        if sliding:
            add_turned(here, l0, l1, l2, p, 0)
            add_turned(here, s0, s1, s2, p, 12)
        for i in range(first, first + link[n, COUNT] + 1):
            m = moving[i]
            product(here, m[ROTATION : ROTATION + 9], other)
            for k in range(9):
                here[k] = other[k]
            if i > first:
                reach = m[REACH]
                add_turned(here, reach, 0.0, 0.0, p, 0)
                add_turned(here, work.node[RATE, i, 0], m[OMEGA + 2] * reach, -m[OMEGA + 1] * reach, p, 12)
        for k in range(9):
            p[3 + k] = here[k]


@kernel
def add_turned(r, x, y, z, out, at):
    """Add r (x, y, z) to three entries of out."""
    x, y, z = turned(r, x, y, z)
    out[at] += x
    out[at + 1] += y
    out[at + 2] += z


@kernel
def ride(chain, work, n, r, point, out):
    """closure.ride: r (3,) is a point, from the end, or a direction, in the axes of the section there.

    The last row of out holds it in the carrier's axes.
    """
    i, p = chain.link[n, FIRST] + chain.link[n, COUNT], work.pose[n]
    e, turn = work.section[i], p[3:12]
    x, y, z = turned(work.moving[i, HALF : HALF + 9], r[0], r[1], r[2])
    w0, w1, w2 = e[OMEGA], e[OMEGA + 1], e[OMEGA + 2]
    v0, v1, v2 = w1 * z - w2 * y, w2 * x - w0 * z, w0 * y - w1 * x
    b0, b1, b2 = e[ANGULAR], e[ANGULAR + 1], e[ANGULAR + 2]
    a0 = b1 * z - b2 * y + w1 * v2 - w2 * v1
    a1 = b2 * x - b0 * z + w2 * v0 - w0 * v2
    a2 = b0 * y - b1 * x + w0 * v1 - w1 * v0
    if point:
        a0, a1, a2 = a0 + e[LINEAR], a1 + e[LINEAR + 1], a2 + e[LINEAR + 2]
    out[0, 0], out[0, 1], out[0, 2] = turned(turn, x, y, z)
    out[1, 0], out[1, 1], out[1, 2] = turned(turn, v0, v1, v2)
    out[2, 0], out[2, 1], out[2, 2] = turned(turn, a0, a1, a2)
    out[3, 0], out[3, 1], out[3, 2] = x, y, z
    if point:
        for k in range(3):
            out[0, k] += p[k]
            out[1, k] += p[12 + k]


@kernel
def pull(chain, work, n, point, c, x, y, z):
    """Add a force (x, y, z), base frame, on what rides on link n: c (3,) its value in the carrier's axes."""
    i = chain.link[n, FIRST] + chain.link[n, COUNT]
    x, y, z = turned_back(work.pose[n, 3:12], x, y, z)
    w = work.section_wrench[i]
    if point:
        w[0] += x
        w[1] += y
    if len(chain.dofs) == 3:
        w[2] += c[0] * y - c[1] * x
        return
    if point:
        w[2] += z
    w[3] += c[1] * z - c[2] * y
    w[4] += c[2] * x - c[0] * z
    w[5] += c[0] * y - c[1] * x


@kernel
def damping_share(chain, row, v):
    """What `accelerate` adds to an equation's second derivative for Rayleigh's alpha; row (n,) of G.

    It moves the links with alpha times the elastic rates besides their accelerations.
    """
    total = 0.0
    if chain.setting[ALPHA] > 0.0:
        for i in range(int(chain.setting[COORDINATES]), row.size):
            total += row[i] * v[i]
    return chain.setting[ALPHA] * total
