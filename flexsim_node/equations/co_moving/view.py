"""Energy and positions of a chain with co-moving frames."""

from __future__ import annotations

import numpy as np

from ...compiled.kernel import allocating_kernel, kernel
from ...elements import planar_beam, rigid_body, spatial_beam
from ...elements.beam import LENGTH, MASS, STIFFENING, stiffening_energy
from ...model.chain import (
    BODIES,
    COUNT,
    DISPLACEMENT,
    FIRST,
    FIRST_BODY,
    FIRST_ELEMENT,
    FIXED,
    GRAVITY,
    HALF,
    KIND,
    LEAD,
    MOTOR,
    PARENT,
    PRISMATIC,
    REACH,
    REVOLUTE,
    ROTATION,
    ROTOR,
    SERIES,
    SLIDE,
    SPRING,
    TURN,
    Q,
)
from ...rotations.rotation_vector import rotation_log
from . import plane, space
from .space import product, tangent, turned, turned_back


@allocating_kernel
def kinetic(w, coupling, inertia, rate):
    """Kinetic energy of a carrier's twist w (6,) and nodal rates over the matrices of one element or body."""
    total = 0.0
    for i in range(6):
        total += 0.5 * inertia[i, i] * w[i] * w[i]
        for k in range(i + 1, 6):
            total += inertia[i, k] * w[i] * w[k]
        for k in range(rate.size):
            total += w[i] * coupling[k, i] * rate[k]
    return total


@allocating_kernel
def energy(dofs, chain, work, x, v, out):
    """Write kinetic, elastic and gravitational energy (J) of the chain, placed at x, into out (3,)."""
    link, joint, index, element = chain.link, chain.joint, chain.unknown, chain.element
    b = len(dofs)
    planar = b == 3
    nodes = index.shape[0]
    twist, gravity, height = np.zeros((nodes, 6)), np.zeros((nodes, 3)), np.zeros(nodes)
    row, rate, rows, rates = np.zeros(6), np.zeros(6), np.zeros((2, b)), np.zeros((2, b))
    raw, own, coupling, inertia = np.zeros((2 * b, b)), np.zeros((b, b)), np.zeros((12, 6)), np.zeros((6, 6))
    t, zero = np.zeros((30, 3)), np.zeros(6)
    out[:] = 0.0
    for n in range(link.shape[0]):
        kind, parent, first = link[n, KIND], link[n, PARENT], link[n, FIRST]
        m = work.moving[first]
        w, g = twist[first], gravity[first]
        if parent >= 0:
            end = link[parent, FIRST] + link[parent, COUNT]
            w[:], g[:], height[first] = twist[end], gravity[end], height[end]
        else:
            for k in range(3):
                g[k] = chain.setting[GRAVITY + k]
        if kind == PRISMATIC:
            l0, l1, l2, qd = m[LEAD], m[LEAD + 1], m[LEAD + 2], v[link[n, Q]]
            w[0] += w[4] * l2 - w[5] * l1 + qd * m[SLIDE]
            w[1] += w[5] * l0 - w[3] * l2 + qd * m[SLIDE + 1]
            w[2] += w[3] * l1 - w[4] * l0 + qd * m[SLIDE + 2]
            height[first] += g[0] * l0 + g[1] * l1 + g[2] * l2
        for i in range(first, first + link[n, COUNT] + 1):
            m, w, g = work.moving[i], twist[i], gravity[i]
            if i > first:
                # arrive from the section before
                w[:], g[:], height[i] = twist[i - 1], gravity[i - 1], height[i - 1]
            r = m[ROTATION : ROTATION + 9]
            w[0], w[1], w[2] = turned_back(r, w[0], w[1], w[2])
            w[3], w[4], w[5] = turned_back(r, w[3], w[4], w[5])
            g[0], g[1], g[2] = turned_back(r, g[0], g[1], g[2])
            if i == first:
                if kind == REVOLUTE:
                    for k in range(3):
                        w[3 + k] += joint[n, 1 + k] * v[link[n, Q]]
                continue
            e = element[link[n, FIRST_ELEMENT] + i - first - 1]
            d = work.node[DISPLACEMENT, i]
            if len(dofs) == 3:
                plane.node_row(index, i, v, rate)
                plane.element_rows(d, rows)
                plane.element_rows(rate, rates)
                w[5] += rate[1]
                c0, c1, c2 = 0.0, 0.0, rate[2]
            else:
                space.node_row(index, i, v, rate)
                space.element_rows(d, rows)
                space.element_rows(rate, rates)
                b0, b1, b2 = tangent(m, TURN, SERIES, -1.0, 0.5 * rate[3], rate[2], rate[1])
                w[3] += b0
                w[4] += b1
                w[5] += b2
                c0, c1, c2 = tangent(m, TURN + 3, SERIES + 4, 1.0, 0.5 * rate[3], rate[4], rate[5])
            # the element about its carrier
            own[:] = 0.0
            coupling[:] = 0.0
            inertia[:] = 0.0
            if len(dofs) == 3:
                planar_beam.inertia_coupling(e, rows, 1, raw, own)
            else:
                spatial_beam.inertia_coupling(e, rows, 1, raw, own, t)
            for j in range(b):
                for k in range(b):
                    inertia[5 if planar and j == 2 else j, 5 if planar and k == 2 else k] = own[j, k]
                for k in range(2 * b):
                    coupling[k, 5 if planar and j == 2 else j] = raw[k, j]
            out[0] += kinetic(w, coupling[: 2 * b], inertia, rates.ravel())
            mass = chain.mass[link[n, FIRST_ELEMENT] + i - first - 1]
            stiffness = chain.stiffness[link[n, FIRST_ELEMENT] + i - first - 1]
            for j in range(b):
                for k in range(b):
                    out[0] += 0.5 * rate[j] * mass[j, k] * rate[k]
                    out[1] += 0.5 * d[j] * stiffness[j, k] * d[k]
            if e[STIFFENING] > 0.0:
                out[1] += stretching(e, rows, planar)
                moved = 0.0
                for k in range(2, 3) if planar else range(4, 6):
                    moved += e[LENGTH] / 12.0 * (rows[1, k] * rates[1, k] - rows[0, k] * rates[0, k])
                out[0] += 0.5 * e[MASS] * moved * (rate[0] + moved)
            out[2] -= inertia[0, 0] * height[i] + inertia[1, 5] * g[0] - inertia[0, 5] * g[1]
            if not planar:
                out[2] -= inertia[0, 4] * g[2]
            # on to the section at its end
            height[i] += g[0] * m[REACH]
            w[0] += rate[0]
            w[1] += w[5] * m[REACH]
            w[2] -= w[4] * m[REACH]
            w[3] += c0
            w[4] += c1
            w[5] += c2
        i = first + link[n, COUNT]
        if link[n, BODIES] > 0:
            r, w, g = work.moving[i, HALF : HALF + 9], row, rate
            w[0], w[1], w[2] = turned_back(r, twist[i, 0], twist[i, 1], twist[i, 2])
            w[3], w[4], w[5] = turned_back(r, twist[i, 3], twist[i, 4], twist[i, 5])
            g[0], g[1], g[2] = turned_back(r, gravity[i, 0], gravity[i, 1], gravity[i, 2])
            coupling[:] = 0.0
            inertia[:] = 0.0
            for k in range(link[n, FIRST_BODY], link[n, FIRST_BODY] + link[n, BODIES]):
                rigid_body.inertia_coupling(chain.body[k], 0.0, zero, 0.0, coupling, inertia, t)
            out[0] += kinetic(w, coupling[:6], inertia, zero)
            out[2] -= inertia[0, 0] * height[i] + inertia[1, 5] * g[0] - inertia[0, 5] * g[1]
            out[2] -= inertia[0, 4] * g[2]
        if kind != FIXED:
            speed, motor = v[link[n, Q]], link[n, MOTOR]
            if motor >= 0:
                out[1] += 0.5 * joint[n, SPRING] * (x[motor] - x[link[n, Q]]) ** 2
                speed = v[motor]
            out[0] += 0.5 * joint[n, ROTOR] * speed * speed


@allocating_kernel
def stretching(e, rows, planar):
    """What the mean squared slope adds to an element's strain energy."""
    p, r = np.zeros(6), np.zeros(6)
    for k in range(rows.shape[1]):
        p[5 if planar and k == 2 else k] = rows[0, k]
        r[5 if planar and k == 2 else k] = rows[1, k]
    return stiffening_energy(e, p, r)


@kernel
def observe(chain, work, axes, position, rigid_position, displacement, pose):
    """Write node positions, those of the undeformed links (N, 3) and displacements (N, 6) in link frames.

    An undeformed link starts where its deformed one does, in the same direction.  Displacements and rotation
    vectors are measured from it.  pose (L, 12) gets each link's origin and rotation (row-wise) at its start.
    """
    link, moving = chain.link, work.moving
    before, turn, here = work.row[0, 0:12], work.row[1, 0:12], work.row[2, 0:9]
    for n in range(link.shape[0]):
        kind, parent, first = link[n, KIND], link[n, PARENT], link[n, FIRST]
        m, p = moving[first], pose[n]
        if parent >= 0:
            section_pose(chain, work, parent, pose[parent], before, here)
        else:
            for k in range(12):
                before[k] = 1.0 if k == 3 or k == 7 or k == 11 else 0.0
        # before: where the joint sits, in the axes of its carrier
        p[0], p[1], p[2] = before[0], before[1], before[2]
        if kind == PRISMATIC:
            x, y, z = turned(before[3:12], m[LEAD], m[LEAD + 1], m[LEAD + 2])
            p[0] += x
            p[1] += y
            p[2] += z
        product(before[3:12], m[ROTATION : ROTATION + 9], p[3:12])
        # nodes from the link's start on: origin and rotation of the carrier, in the link's axes
        for k in range(12):
            before[k] = 1.0 if k == 3 or k == 7 or k == 11 else 0.0
        for i in range(first, first + link[n, COUNT] + 1):
            if i > first:
                m = moving[i]
                product(before[3:12], m[ROTATION : ROTATION + 9], here)
                for k in range(9):
                    before[3 + k] = here[k]
                x, y, z = turned(here, m[REACH], m[REACH + 1], m[REACH + 2])
                before[0] += x
                before[1] += y
                before[2] += z
            product(before[3:12], moving[i, HALF : HALF + 9], turn[0:9])
            write_node(chain.place[i], axes[n], p, before, turn, i, position, rigid_position, displacement)


@kernel
def carrier_pose(chain, work, n, i, pose, out, here):
    """Write origin and rotation (12,) of the carrier of link n's node i, base frame, into out.

    pose (12,) is that of the link's start, here (9,) scratch.
    """
    for k in range(12):
        out[k] = pose[k]
    first = chain.link[n, FIRST]
    for p in range(first + 1, i + 1):
        if p > first + 1:
            go_on(work.moving[p - 1], out)
        product(out[3:12], work.moving[p, ROTATION : ROTATION + 9], here)
        for k in range(9):
            out[3 + k] = here[k]


@kernel
def go_on(m, pose):
    """Move a carrier's origin in pose (12,) to the section at its element's end; m is its row."""
    x, y, z = turned(pose[3:12], m[REACH], m[REACH + 1], m[REACH + 2])
    pose[0] += x
    pose[1] += y
    pose[2] += z


@kernel
def section_pose(chain, work, n, pose, out, here):
    """Write where the section at link n's end is and how its carrier is turned, base frame, into out."""
    end = chain.link[n, FIRST] + chain.link[n, COUNT]
    carrier_pose(chain, work, n, end, pose, out, here)
    if end > chain.link[n, FIRST]:
        go_on(work.moving[end], out)


@kernel
def write_node(at, axes, pose, origin, turn, i, position, rigid_position, displacement):
    """Write node i, at `origin` and turned by `turn` (nine numbers) in the axes of a link at `pose`."""
    vector = turn[9:12]
    rotation_log(turn, vector)
    x, y, z = turned(pose[3:12], origin[0], origin[1], origin[2])
    position[i, 0], position[i, 1], position[i, 2] = pose[0] + x, pose[1] + y, pose[2] + z
    for k in range(3):
        rigid_position[i, k] = pose[k] + pose[3 + 3 * k] * at
        displacement[i, k] = axes[k, 0] * (origin[0] - at) + axes[k, 1] * origin[1] + axes[k, 2] * origin[2]
        displacement[i, 3 + k] = axes[k, 0] * vector[0] + axes[k, 1] * vector[1] + axes[k, 2] * vector[2]
