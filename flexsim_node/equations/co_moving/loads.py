"""Loads on links' ends, and the validity watch, for co-moving frames."""

from __future__ import annotations

from ...compiled.kernel import kernel
from ...model.chain import COUNT, DISPLACEMENT, FIRST, OMEGA, PARENT, ROTATION
from .space import product, turned_back


@kernel
def external_forces(chain, work):
    """Take the loads on the links' ends from the wrenches of their sections.

    The directions are those of the link's frame at its start, or of the base; a load on an end moves with it.
    """
    link = chain.link
    if work.loaded[1]:
        attitudes(chain, work)
    for n in range(link.shape[0]):
        first, end = link[n, FIRST], link[n, FIRST] + link[n, COUNT]
        p0, p1, p2, m0, m1, m2 = work.external[0, n]
        if work.loaded[1]:
            r, b = work.attitude[n], work.external[1, n]
            x, y, z = turned_back(r, b[0], b[1], b[2])
            p0, p1, p2 = p0 + x, p1 + y, p2 + z
            x, y, z = turned_back(r, b[3], b[4], b[5])
            m0, m1, m2 = m0 + x, m1 + y, m2 + z
        for i in range(first + 1, end + 1):
            r = work.moving[i, ROTATION : ROTATION + 9]
            p0, p1, p2 = turned_back(r, p0, p1, p2)
            m0, m1, m2 = turned_back(r, m0, m1, m2)
        w = work.section_wrench[end]
        w[0] -= p0
        w[1] -= p1
        if len(chain.dofs) == 3:
            w[2] -= m2
        else:
            w[2] -= p2
            w[3] -= m0
            w[4] -= m1
            w[5] -= m2


@kernel
def attitudes(chain, work):
    """Rotations of the placed links' starts to the base (row-wise)."""
    link, moving = chain.link, work.moving
    here, other = work.row[0, 0:9], work.row[1, 0:9]
    for n in range(link.shape[0]):
        parent, r = link[n, PARENT], work.attitude[n]
        turn = moving[link[n, FIRST], ROTATION : ROTATION + 9]
        if parent < 0:
            for k in range(9):
                r[k] = turn[k]
            continue
        for k in range(9):
            here[k] = work.attitude[parent, k]
        for i in range(link[parent, FIRST] + 1, link[parent, FIRST] + link[parent, COUNT] + 1):
            product(here, moving[i, ROTATION : ROTATION + 9], other)
            for k in range(9):
                here[k] = other[k]
        product(here, turn, r)


@kernel
def measure(chain, work, n):
    """Link n's largest rotation inside an element, about its chord (rad), and its spin (rad/s)."""
    link, d = chain.link, work.node[DISPLACEMENT]
    planar = len(chain.dofs) == 3
    turn = spin = 0.0
    for i in range(link[n, FIRST] + 1, link[n, FIRST] + link[n, COUNT] + 1):
        f = work.moving[i]
        for k in range(1, d.shape[1]):
            turn = max(turn, 0.5 * abs(d[i, k]) if k == 3 else abs(d[i, k]))
        # about the beam's own axis it does not bend
        about = abs(f[OMEGA + 2]) if planar else (f[OMEGA + 1] ** 2 + f[OMEGA + 2] ** 2) ** 0.5
        spin = max(spin, about)
    return turn, spin
