"""What a link hands its parent during a solve, and takes from it: matrix, load and answer over (end node, A).

Frames are those that `factorize` kept.
"""

from __future__ import annotations

from ...compiled.flat import flat
from ...compiled.kernel import kernel
from ...compiled.weighted_sum import add_twelve_thrice, twelve_thrice
from ...model.chain import KIND, LEVER, PARENT, PRISMATIC, ROTATION, SLIDE_OVER, TURN_OVER
from ..kinematics.spatial_kinematics import over, over_back, to_child, to_parent


@kernel
def turned_lever(f, l0, l1, l2, x, at):
    """Write l x E for the rotation E to the parent into x[at:] (3, 3)."""
    for k in range(3):
        e0, e1, e2 = f[ROTATION + k], f[ROTATION + 3 + k], f[ROTATION + 6 + k]
        x[at + k], x[at + 3 + k], x[at + 6 + k] = l1 * e2 - l2 * e1, l2 * e0 - l0 * e2, l0 * e1 - l1 * e0


@kernel
def hand_over(chain, work, n, z):
    """Add the symmetric z over (start node, A) of link n, both triangles, to its parent's interface.

    It is C z C^T with C of the rotation E to the parent and the levers l: forces F, moments E M + l x E F; of
    the start node's moments the transpose of what the joint makes of the parent's turn (joint_turn.py).
    """
    link, f, x, made, given = chain.link, work.kept[n], work.row[0], flat(work.square), flat(z)
    out = flat(work.interface[link[n, PARENT]])
    l0, l1, l2 = f[LEVER], f[LEVER + 1], f[LEVER + 2]
    turned_lever(f, l0, l1, l2, x, 0)
    slides = link[n, KIND] == PRISMATIC
    for p in range(0, 144, 36):
        twelve_thrice(3, f, TURN_OVER if p == 36 else ROTATION, 1, 3, given, p, 12, made, p, 12)
    add_twelve_thrice(3, x, 0, 1, 3, given, 72, 12, made, 108, 12)
    if slides:
        add_twelve_thrice(3, f, SLIDE_OVER, 1, 3, given, 0, 12, made, 36, 12)
    for i in range(12):
        for k in range(12):
            z[k, i] = work.square[i, k]
    for p in range(0, 144, 36):
        add_twelve_thrice(3, f, TURN_OVER if p == 36 else ROTATION, 1, 3, given, p, 12, out, p, 12)
    add_twelve_thrice(3, x, 0, 1, 3, given, 72, 12, out, 108, 12)
    if slides:
        add_twelve_thrice(3, f, SLIDE_OVER, 1, 3, given, 0, 12, out, 36, 12)


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
    r[3], r[4], r[5] = over_back(f, TURN_OVER, g[3], g[4], g[5])
    if link[n, KIND] == PRISMATIC:
        x, y, z = over_back(f, SLIDE_OVER, g[0], g[1], g[2])
        r[3], r[4], r[5] = r[3] + x, r[4] + y, r[5] + z
    r[0], r[1], r[2] = over_back(f, ROTATION, g[0], g[1], g[2])
    for k in range(6):
        s[k] = g[6 + k]
    to_parent(f, s)
    l0, l1, l2 = f[LEVER], f[LEVER + 1], f[LEVER + 2]
    s[3] += l1 * s[2] - l2 * s[1]
    s[4] += l2 * s[0] - l0 * s[2]
    s[5] += l0 * s[1] - l1 * s[0]
    for k in range(6):
        load[k] += r[k]
        load[6 + k] += s[k]


@kernel
def take_answer(chain, work, n, z, s, planar):
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
        s[k] = given[6 + k]
    l0, l1, l2 = f[LEVER], f[LEVER + 1], f[LEVER + 2]
    s[0] += s[4] * l2 - s[5] * l1
    s[1] += s[5] * l0 - s[3] * l2
    s[2] += s[3] * l1 - s[4] * l0
    to_child(f, s)
    z[0], z[1], z[2] = over(f, ROTATION, given[0], given[1], given[2])
    z[3], z[4], z[5] = over(f, TURN_OVER, given[3], given[4], given[5])
    if link[n, KIND] == PRISMATIC:
        x, y, w = over(f, SLIDE_OVER, given[3], given[4], given[5])
        z[0], z[1], z[2] = z[0] + x, z[1] + y, z[2] + w
    for k in range(6):
        z[6 + k] = s[k]
