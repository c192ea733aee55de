"""Momenta M y of co-moving frames at rates y, of the links as they are; for damping.py."""

from __future__ import annotations

from ...compiled.kernel import kernel
from ...elements import planar_beam, spatial_beam
from ...model.chain import (
    ACCELERATION,
    ANGULAR,
    AXIS,
    BODIES,
    COUNT,
    DISPLACEMENT,
    FIRST,
    FIRST_ELEMENT,
    FIXED,
    KIND,
    LEAD,
    LINEAR,
    OMEGA,
    PARENT,
    PRISMATIC,
    REACH,
    REVOLUTE,
    ROTATION,
    SERIES,
    SLIDE,
    TURN,
    Q,
)
from . import plane, space
from .space import tangent, turned_back


@kernel
def momenta(dofs, chain, work, y, out):
    """Add M y to out (n,).

    Momentum is what inertia forces are of a robot without rates whose accelerations are y.
    """
    work.section_wrench[:] = 0.0
    if len(dofs) == 3:
        move_in_plane(chain, work, y)
        gather_in_plane(chain, work, out)
    else:
        move_in_space(chain, work, y)
        gather_in_space(chain, work, out)


@kernel
def move_in_plane(chain, work, y):
    """Velocities of carriers and sections, where `plane.accelerate` has accelerations."""
    link, index, acceleration = chain.link, chain.unknown, work.node[ACCELERATION]
    for n in range(link.shape[0]):
        parent, first = link[n, PARENT], link[n, FIRST]
        x = z = turn = 0.0
        if parent >= 0:
            e = work.section[link[parent, FIRST] + link[parent, COUNT]]
            x, z, turn = e[LINEAR], e[LINEAR + 1], e[ANGULAR + 2]
        if link[n, KIND] != FIXED:
            turn += chain.joint[n, AXIS + 2] * y[link[n, Q]]
        for i in range(first, first + link[n, COUNT] + 1):
            m, e = work.moving[i], work.section[i]
            c, s = m[ROTATION], m[ROTATION + 3]
            x, z = c * x + s * z, c * z - s * x
            if i > first:
                plane.node_row(index, i, y, acceleration[i])
                turn += acceleration[i, 1]
            m[OMEGA + 2], m[ANGULAR + 2], m[LINEAR], m[LINEAR + 1] = 0.0, turn, x, z
            if i > first:
                x += acceleration[i, 0]
                z += turn * m[REACH]
                turn += acceleration[i, 2]
            e[OMEGA + 2], e[ANGULAR + 2], e[LINEAR], e[LINEAR + 1] = 0.0, turn, x, z


@kernel
def gather_in_plane(chain, work, out):
    """`plane.gather` of the inertia forces alone."""
    link = chain.link
    d, v, a, force = work.pair[0], work.pair[1], work.pair[2], work.pair[3]
    wrench = work.row[0, 0:3]
    v[:] = 0.0
    for n in range(link.shape[0] - 1, -1, -1):
        first = link[n, FIRST]
        if link[n, BODIES] > 0:
            plane.body_forces(chain, work, n)
        for i in range(first + link[n, COUNT], first, -1):
            element = chain.element[link[n, FIRST_ELEMENT] + i - first - 1]
            plane.element_rows(work.node[DISPLACEMENT, i], d)
            plane.element_rows(work.node[ACCELERATION, i], a)
            force[:] = 0.0
            wrench[:] = 0.0
            planar_beam.inertia_force(element, work.moving[i], d, v, a, 1, 0.0, True, True, force, wrench)
            x, z, moment = wrench[0], wrench[1], wrench[2]
            f0, f1, f2 = force[1, 0], -force[0, 2], force[1, 2]
            plane.pass_on(chain.unknown, work, i, x, z, moment, f0, f1, f2, out)
        plane.pass_joint(chain, work, n, out)


@kernel
def move_in_space(chain, work, y):
    """Velocities of carriers and sections, where `space.accelerate` has accelerations."""
    link, index, acceleration = chain.link, chain.unknown, work.node[ACCELERATION]
    for n in range(link.shape[0]):
        kind, parent, first = link[n, KIND], link[n, PARENT], link[n, FIRST]
        m, e = work.moving[first], work.section[first]
        w0 = w1 = w2 = p0 = p1 = p2 = 0.0
        if parent >= 0:
            before = work.section[link[parent, FIRST] + link[parent, COUNT]]
            w0, w1, w2 = before[ANGULAR], before[ANGULAR + 1], before[ANGULAR + 2]
            p0, p1, p2 = before[LINEAR], before[LINEAR + 1], before[LINEAR + 2]
        if kind == PRISMATIC:
            l0, l1, l2, rate = m[LEAD], m[LEAD + 1], m[LEAD + 2], y[link[n, Q]]
            p0 += w1 * l2 - w2 * l1 + rate * m[SLIDE]
            p1 += w2 * l0 - w0 * l2 + rate * m[SLIDE + 1]
            p2 += w0 * l1 - w1 * l0 + rate * m[SLIDE + 2]
        r = m[ROTATION : ROTATION + 9]
        w0, w1, w2 = turned_back(r, w0, w1, w2)
        p0, p1, p2 = turned_back(r, p0, p1, p2)
        if kind == REVOLUTE:
            rate = y[link[n, Q]]
            w0 += chain.joint[n, AXIS] * rate
            w1 += chain.joint[n, AXIS + 1] * rate
            w2 += chain.joint[n, AXIS + 2] * rate
        write_motion(m, p0, p1, p2, w0, w1, w2)
        write_motion(e, p0, p1, p2, w0, w1, w2)
        for i in range(first + 1, first + link[n, COUNT] + 1):
            m, e, u = work.moving[i], work.section[i], acceleration[i]
            space.node_row(index, i, y, u)
            r = m[ROTATION : ROTATION + 9]
            w0, w1, w2 = turned_back(r, w0, w1, w2)
            p0, p1, p2 = turned_back(r, p0, p1, p2)
            x0, x1, x2 = tangent(m, TURN, SERIES, -1.0, 0.5 * u[3], u[2], u[1])
            w0, w1, w2 = w0 + x0, w1 + x1, w2 + x2
            write_motion(m, p0, p1, p2, w0, w1, w2)
            p0, p1, p2 = p0 + u[0], p1 + w2 * m[REACH], p2 - w1 * m[REACH]
            x0, x1, x2 = tangent(m, TURN + 3, SERIES + 4, 1.0, 0.5 * u[3], u[4], u[5])
            w0, w1, w2 = w0 + x0, w1 + x1, w2 + x2
            write_motion(e, p0, p1, p2, w0, w1, w2)


@kernel
def write_motion(row, p0, p1, p2, w0, w1, w2):
    """Write a velocity, as an acceleration from rest, into a row of carriers or sections."""
    row[OMEGA], row[OMEGA + 1], row[OMEGA + 2] = 0.0, 0.0, 0.0
    row[LINEAR], row[LINEAR + 1], row[LINEAR + 2] = p0, p1, p2
    row[ANGULAR], row[ANGULAR + 1], row[ANGULAR + 2] = w0, w1, w2


@kernel
def gather_in_space(chain, work, out):
    """`space.gather` of the inertia forces alone."""
    link = chain.link
    d, v, a, force = work.pair[0], work.pair[1], work.pair[2], work.pair[3]
    wrench, own = work.row[0, 0:6], work.row[1, 0:6]
    v[:] = 0.0
    for n in range(link.shape[0] - 1, -1, -1):
        first = link[n, FIRST]
        if link[n, BODIES] > 0:
            space.body_forces(chain, work, n)
        for i in range(first + link[n, COUNT], first, -1):
            element, m = chain.element[link[n, FIRST_ELEMENT] + i - first - 1], work.moving[i]
            space.element_rows(work.node[DISPLACEMENT, i], d)
            space.element_rows(work.node[ACCELERATION, i], a)
            force[:] = 0.0
            wrench[:] = 0.0
            spatial_beam.inertia_force(element, m, d, v, a, 1, 0.0, True, True, force, wrench, work.scratch)
            space.own_forces(force, own)
            space.pass_on(chain.unknown, work, i, wrench, own, out)
        space.pass_joint(chain, work, n, out)
