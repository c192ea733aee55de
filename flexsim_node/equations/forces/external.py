"""Forces and moments from outside on the links' ends: a tool's contact, a hand, wind."""

from __future__ import annotations

from ...compiled.kernel import kernel
from ...model.chain import COUNT, DISPLACEMENT, FIRST, PARENT, ROTATION, SPIN, TIP
from ...rotations.section_turn import moment_on_row


@kernel
def external_forces(chain, work):
    """Take the loads on the links' ends from the forces, by virtual work at the displaced ends.

    The directions are those of the link's frame, or of the base; a load on an end moves with it.
    """
    link, d = chain.link, work.node[DISPLACEMENT]
    if work.loaded[1]:
        attitudes(chain, work)
    for n in range(link.shape[0]):
        i = link[n, FIRST] + link[n, COUNT]
        p0, p1, p2, m0, m1, m2 = work.external[0, n]
        if work.loaded[1]:
            r, b = work.attitude[n], work.external[1, n]
            p0 += r[0] * b[0] + r[3] * b[1] + r[6] * b[2]
            p1 += r[1] * b[0] + r[4] * b[1] + r[7] * b[2]
            p2 += r[2] * b[0] + r[5] * b[1] + r[8] * b[2]
            m0 += r[0] * b[3] + r[3] * b[4] + r[6] * b[5]
            m1 += r[1] * b[3] + r[4] * b[4] + r[7] * b[5]
            m2 += r[2] * b[3] + r[5] * b[4] + r[8] * b[5]
        x, y = chain.joint[n, TIP] + d[i, 0], d[i, 1]
        force, wrench = work.force[i], work.wrench[n]
        if len(chain.dofs) == 3:
            force[0] -= p0
            force[1] -= p1
            force[2] -= m2
            wrench[0] -= p0
            wrench[1] -= p1
            wrench[2] -= m2 + x * p1 - y * p0
        else:
            z = d[i, 2]
            force[0] -= p0
            force[1] -= p1
            force[2] -= p2
            if chain.setting[SPIN] > 0.0:
                f0, f1, f2 = moment_on_row(d[i, 3:6], m0, m1, m2)
            else:
                f0, f1, f2 = m0, m1, m2
            force[3] -= f0
            force[4] -= f1
            force[5] -= f2
            wrench[0] -= p0
            wrench[1] -= p1
            wrench[2] -= p2
            wrench[3] -= m0 + y * p2 - z * p1
            wrench[4] -= m1 + z * p0 - x * p2
            wrench[5] -= m2 + x * p1 - y * p0


@kernel
def load_at(work, at):
    """Put the loads at a fraction of the step in force, by the parabola through start, middle and end."""
    if not (work.loaded[0] or work.loaded[1]):
        return
    p = 2.0 * (at - 0.5) * (at - 1.0)
    q = 4.0 * at * (1.0 - at)
    r = 2.0 * at * (at - 0.5)
    course, external = work.course, work.external
    for axes in range(2):
        for n in range(external.shape[1]):
            for k in range(6):
                start, middle, end = course[0, axes, n, k], course[1, axes, n, k], course[2, axes, n, k]
                external[axes, n, k] = p * start + q * middle + r * end


@kernel
def attitudes(chain, work):
    """Rotations of the placed body frames to the base (row-wise)."""
    for n in range(chain.link.shape[0]):
        f, r, parent = work.frame[n], work.attitude[n], chain.link[n, PARENT]
        for i in range(3):
            for k in range(3):
                if parent < 0:
                    r[3 * i + k] = f[ROTATION + 3 * i + k]
                else:
                    q = work.attitude[parent]
                    r[3 * i + k] = (
                        q[3 * i] * f[ROTATION + k]
                        + q[3 * i + 1] * f[ROTATION + 3 + k]
                        + q[3 * i + 2] * f[ROTATION + 6 + k]
                    )
