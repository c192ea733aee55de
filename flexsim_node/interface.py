"""What a link hands its parent during a solve, and takes from it: matrix, load and answer over (end node, A).

Frames are those that `factorize` kept.
"""

from __future__ import annotations

from .chain import KIND, LEVER, PARENT, PRISMATIC, ROTATION, TIP
from .kernel import kernel
from .spatial_kinematics import to_child, to_parent


@kernel
def turned_block(f, z, i, k):
    """E B E^T for the 3 x 3 block B of z at (i, k) and the rotation E to the parent, as nine numbers."""
    e0, e1, e2 = f[ROTATION], f[ROTATION + 1], f[ROTATION + 2]
    e3, e4, e5 = f[ROTATION + 3], f[ROTATION + 4], f[ROTATION + 5]
    e6, e7, e8 = f[ROTATION + 6], f[ROTATION + 7], f[ROTATION + 8]
    x, y, u = z[i, k], z[i + 1, k], z[i + 2, k]
    a0, b0, c0 = e0 * x + e1 * y + e2 * u, e3 * x + e4 * y + e5 * u, e6 * x + e7 * y + e8 * u
    x, y, u = z[i, k + 1], z[i + 1, k + 1], z[i + 2, k + 1]
    a1, b1, c1 = e0 * x + e1 * y + e2 * u, e3 * x + e4 * y + e5 * u, e6 * x + e7 * y + e8 * u
    x, y, u = z[i, k + 2], z[i + 1, k + 2], z[i + 2, k + 2]
    a2, b2, c2 = e0 * x + e1 * y + e2 * u, e3 * x + e4 * y + e5 * u, e6 * x + e7 * y + e8 * u
    return (
        a0 * e0 + a1 * e1 + a2 * e2,
        a0 * e3 + a1 * e4 + a2 * e5,
        a0 * e6 + a1 * e7 + a2 * e8,
        b0 * e0 + b1 * e1 + b2 * e2,
        b0 * e3 + b1 * e4 + b2 * e5,
        b0 * e6 + b1 * e7 + b2 * e8,
        c0 * e0 + c1 * e1 + c2 * e2,
        c0 * e3 + c1 * e4 + c2 * e5,
        c0 * e6 + c1 * e7 + c2 * e8,
    )


@kernel
def lever(z, p, r, l0, l1, l2):
    """Congruence of a symmetric z for a lever: rotations r.. also move the point p.. by rotation x lever."""
    size = z.shape[0]
    for k in range(size):
        x, y, u = z[p, k], z[p + 1, k], z[p + 2, k]
        z[r, k] += l1 * u - l2 * y
        z[r + 1, k] += l2 * x - l0 * u
        z[r + 2, k] += l0 * y - l1 * x
    for i in range(size):
        x, y, u = z[i, p], z[i, p + 1], z[i, p + 2]
        z[i, r] += l1 * u - l2 * y
        z[i, r + 1] += l2 * x - l0 * u
        z[i, r + 2] += l0 * y - l1 * x


@kernel
def hand_over(chain, work, n, z):
    """Add the symmetric z over (start node, A) of link n, both triangles, to its parent's interface."""
    link, f, s = chain.link, work.kept[n], work.square
    out = work.interface[link[n, PARENT]]
    l0, l1, l2 = f[LEVER], f[LEVER + 1], f[LEVER + 2]
    for i in range(0, 12, 3):
        for k in range(i, 12, 3):
            v = turned_block(f, z, i, k)
            s[i, k], s[i, k + 1], s[i, k + 2] = v[0], v[1], v[2]
            s[i + 1, k], s[i + 1, k + 1], s[i + 1, k + 2] = v[3], v[4], v[5]
            s[i + 2, k], s[i + 2, k + 1], s[i + 2, k + 2] = v[6], v[7], v[8]
            if i != k:
                s[k, i], s[k, i + 1], s[k, i + 2] = v[0], v[3], v[6]
                s[k + 1, i], s[k + 1, i + 1], s[k + 1, i + 2] = v[1], v[4], v[7]
                s[k + 2, i], s[k + 2, i + 1], s[k + 2, i + 2] = v[2], v[5], v[8]
    lever(s, 6, 9, l0, l1, l2)
    if link[n, KIND] == PRISMATIC:
        lever(s, 0, 3, l0 - chain.joint[link[n, PARENT], TIP], l1, l2)
    for i in range(12):
        for k in range(12):
            out[i, k] += s[i, k]


@kernel
def hand_over_planar(chain, work, n, z):
    """The same for a planar link: the rotation turns x and y alone."""
    f = work.kept[n]
    out = work.interface[chain.link[n, PARENT]]
    c, h, lx, ly = f[ROTATION], f[ROTATION + 3], f[LEVER], f[LEVER + 1]
    cc, ch, hh = c * c, c * h, h * h
    for p in (0, 3):
        xx, xy, yy = z[p, p], z[p, p + 1], z[p + 1, p + 1]
        xz, yz = z[p, p + 2], z[p + 1, p + 2]
        a, b, d = cc * xx - 2.0 * ch * xy + hh * yy, ch * (xx - yy) + (cc - hh) * xy, 0.0
        d = hh * xx + 2.0 * ch * xy + cc * yy
        u, v, w = c * xz - h * yz, h * xz + c * yz, z[p + 2, p + 2]
        if p == 3:
            w += 2.0 * (lx * v - ly * u) + lx * lx * d - 2.0 * lx * ly * b + ly * ly * a
            u += lx * b - ly * a
            v += lx * d - ly * b
        out[p, p] += a
        out[p, p + 1] += b
        out[p + 1, p + 1] += d
        out[p, p + 2] += u
        out[p + 1, p + 2] += v
        out[p + 2, p + 2] += w
    # coupling of the node (rows) with A (columns)
    for i in range(3):
        x, y = z[i, 3], z[i, 4]
        z[i, 3], z[i, 4] = c * x - h * y, h * x + c * y
        z[i, 5] += lx * z[i, 4] - ly * z[i, 3]
    for k in range(3, 6):
        x, y = z[0, k], z[1, k]
        out[0, k] += c * x - h * y
        out[1, k] += h * x + c * y
        out[2, k] += z[2, k]


@kernel
def hand_load(chain, work, n, g, r, s, planar):
    """Add the load g (start node, A) of link n to its parent's."""
    link, f = chain.link, work.kept[n]
    parent = link[n, PARENT]
    load = work.load[parent]
    if planar:
        c, h = f[ROTATION], f[ROTATION + 3]
        fx, fy = c * g[3] - h * g[4], h * g[3] + c * g[4]
        load[0] += c * g[0] - h * g[1]
        load[1] += h * g[0] + c * g[1]
        load[2] += g[2]
        load[3] += fx
        load[4] += fy
        load[5] += g[5] + f[LEVER] * fy - f[LEVER + 1] * fx
        return
    for k in range(6):
        r[k] = g[k]
        s[k] = g[6 + k]
    to_parent(f, r)
    to_parent(f, s)
    l0, l1, l2 = f[LEVER], f[LEVER + 1], f[LEVER + 2]
    s[3] += l1 * s[2] - l2 * s[1]
    s[4] += l2 * s[0] - l0 * s[2]
    s[5] += l0 * s[1] - l1 * s[0]
    if link[n, KIND] == PRISMATIC:
        l0 -= chain.joint[parent, TIP]
        r[3] += l1 * r[2] - l2 * r[1]
        r[4] += l2 * r[0] - l0 * r[2]
        r[5] += l0 * r[1] - l1 * r[0]
    for k in range(6):
        load[k] += r[k]
        load[6 + k] += s[k]


@kernel
def take_answer(chain, work, n, out, z, r, s, planar):
    """Write the parent's part of (start node, A) of link n into z."""
    link, f = chain.link, work.kept[n]
    parent = link[n, PARENT]
    given = work.answer[parent]
    if planar:
        c, h = f[ROTATION], f[ROTATION + 3]
        z[0], z[1], z[2] = c * given[0] + h * given[1], c * given[1] - h * given[0], given[2]
        x = given[3] - given[5] * f[LEVER + 1]
        y = given[4] + given[5] * f[LEVER]
        z[3], z[4], z[5] = c * x + h * y, c * y - h * x, given[5]
        return
    for k in range(6):
        r[k] = given[k]
        s[k] = given[6 + k]
    l0, l1, l2 = f[LEVER], f[LEVER + 1], f[LEVER + 2]
    s[0] += s[4] * l2 - s[5] * l1
    s[1] += s[5] * l0 - s[3] * l2
    s[2] += s[3] * l1 - s[4] * l0
    if link[n, KIND] == PRISMATIC:
        l0 -= chain.joint[parent, TIP]
        r[0] += r[4] * l2 - r[5] * l1
        r[1] += r[5] * l0 - r[3] * l2
        r[2] += r[3] * l1 - r[4] * l0
    to_child(f, r)
    to_child(f, s)
    for k in range(6):
        z[k] = r[k]
        z[6 + k] = s[k]
