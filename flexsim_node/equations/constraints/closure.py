"""Closing joints: what they equate, how that moves with the unknowns, and the forces that keep it so.

A loop is cut where two links' ends meet (or a link's end and the base); the links are a tree then, and each
closing joint adds equations g(x) = 0 between points and directions that ride on the two ends, elastic
displacement and rotation included (with co-moving frames, the rigid section's):

    d . (a - b) = 0     points a, b; direction d, fixed in a link or in the base
    a . b = 0           directions a, b

With G = dg/dx the motion obeys M a + G^T lambda = f and g'' = G a + (what is quadratic in the rates) = 0: no
mechanism needs formulas of its own.  `constrain` solves that with the factors of the tree, one solve an
equation, and a small dense matrix S = G M^-1 G^T, factorised with diagonal pivoting: an equation that follows
from the others (a planar loop written in space) has no pivot left and takes no part.  `close` then removes
what a step of an integrator leaves of g and of G v, along M^-1 G^T, which disturbs the motion least.
"""

from __future__ import annotations

import numpy as np

from ...compiled.kernel import kernel
from ...model.chain import (
    ACCELERATION,
    ANGULAR,
    COORDINATES,
    COUNT,
    DIRECTION,
    DISPLACEMENT,
    EQUATION,
    FIRST,
    GRAVITY,
    KIND,
    LEVER,
    LINEAR,
    LINK_A,
    LINK_B,
    LINK_D,
    OMEGA,
    PARENT,
    PARENT_AXIS,
    PRISMATIC,
    RATE,
    ROTATION,
    SPIN,
    Q,
)
from ...rotations.section_turn import carried, carried_acceleration, carried_rate, force_on_turn
from ..co_moving import closing, gather_wrenches
from ..kinematics.nodal_motion import accelerate, gather, place, spatial_row
from ..solve.substitution import solve

# columns of Workspace.closure after G and M^-1 G^T: S and, behind it, these
DEFECT, FORCE, ORDER, SCALE = range(4)
COLUMNS = 4
DEPENDENT = 1e-10  # share of an equation that must be its own for a pivot
CLOSED = 1e-12  # m and rad: what `close` asks for
OPEN = 1e-10  # m and rad: what it calls open if it gets no further
CLOSING_STEPS = 8


@kernel
def poses(chain, work, v):
    """Origin (3), rotation (9, row-wise) and the origin's velocity (3) of each link, base frame.

    Velocities are those of the last `accelerate`, with the same v.  With co-moving frames it is the frames at
    the links' ends.
    """
    poses_as(chain.co_moving, chain, work, v)


@kernel
def poses_as(co, chain, work, v):
    """poses for either formulation; the other one is not even compiled."""
    if len(co) > 0:
        closing.poses(chain, work, v)
    else:
        poses_erls(chain, work, v)


@kernel
def poses_erls(chain, work, v):
    """poses for frames of the ERLS."""
    link, frame, pose = chain.link, work.frame, work.pose
    for n in range(link.shape[0]):
        f, p, parent = frame[n], pose[n], link[n, PARENT]
        slide = v[link[n, Q]] if link[n, KIND] == PRISMATIC else 0.0
        if parent < 0:
            for i in range(3):
                p[i] = f[LEVER + i]
                p[12 + i] = slide * chain.joint[n, PARENT_AXIS + i]
                for k in range(3):
                    p[3 + 3 * i + k] = f[ROTATION + 3 * i + k]
            continue
        q, w = pose[parent], frame[parent]
        x, y, z = f[LEVER], f[LEVER + 1], f[LEVER + 2]
        vx = w[OMEGA + 1] * z - w[OMEGA + 2] * y + slide * chain.joint[n, PARENT_AXIS]
        vy = w[OMEGA + 2] * x - w[OMEGA] * z + slide * chain.joint[n, PARENT_AXIS + 1]
        vz = w[OMEGA] * y - w[OMEGA + 1] * x + slide * chain.joint[n, PARENT_AXIS + 2]
        for i in range(3):
            r0, r1, r2 = q[3 + 3 * i], q[4 + 3 * i], q[5 + 3 * i]
            p[i] = q[i] + r0 * x + r1 * y + r2 * z
            p[12 + i] = q[12 + i] + r0 * vx + r1 * vy + r2 * vz
            for k in range(3):
                p[3 + 3 * i + k] = r0 * f[ROTATION + k] + r1 * f[ROTATION + 3 + k] + r2 * f[ROTATION + 6 + k]


@kernel
def ride(chain, work, n, r, point, out):
    """What rides on the end of link n: value, rate and acceleration in the base frame, value in body axes.

    r (3,) is a point, from the end node, or a direction, in body axes (base frame where n < 0); rows of
    out (4, 3).  As everywhere, gravity is an acceleration -g of the base.
    """
    if n < 0:
        for k in range(3):
            out[0, k], out[1, k], out[2, k], out[3, k] = r[k], 0.0, 0.0, r[k]
            if point:
                out[2, k] = -chain.setting[GRAVITY + k]
        return
    ride_as(chain.co_moving, chain, work, n, r, point, out)


@kernel
def ride_as(co, chain, work, n, r, point, out):
    """ride on a link, for either formulation."""
    if len(co) > 0:
        closing.ride(chain, work, n, r, point, out)
    else:
        ride_erls(chain, work, n, r, point, out)


@kernel
def ride_erls(chain, work, n, r, point, out):
    """ride on a link, for frames of the ERLS."""
    planar = len(chain.dofs) == 3
    i, f, p = chain.link[n, FIRST] + chain.link[n, COUNT], work.frame[n], work.pose[n]
    u, du, ddu = work.row[3, 0:6], work.row[3, 6:12], work.row[3, 12:18]
    spatial_row(work.node[DISPLACEMENT, i], planar, u)
    spatial_row(work.node[RATE, i], planar, du)
    spatial_row(work.node[ACCELERATION, i], planar, ddu)
    c, vel, acc = work.scratch[21], work.scratch[22], work.scratch[23]
    second, turn, rate = chain.setting[SPIN], u[3:6], du[3:6]
    c[0], c[1], c[2] = carried(second, turn, r)
    vel[0], vel[1], vel[2] = carried_rate(second, turn, rate, r)
    acc[0], acc[1], acc[2] = carried_rate(second, turn, ddu[3:6], r)
    x, y, z = carried_acceleration(second, rate, r)
    acc[0], acc[1], acc[2] = acc[0] + x, acc[1] + y, acc[2] + z
    for k in range(3):
        c[k] += r[k]
        if point:
            c[k] += u[k]
            vel[k] += du[k]
            acc[k] += ddu[k] + f[LINEAR + k]
    if point:
        c[0] += chain.place[i]
    for k in range(3):
        s, t = (k + 1) % 3, (k + 2) % 3
        acc[k] += f[ANGULAR + s] * c[t] - f[ANGULAR + t] * c[s]
        acc[k] += 2.0 * (f[OMEGA + s] * vel[t] - f[OMEGA + t] * vel[s])
    x = f[OMEGA + 1] * c[2] - f[OMEGA + 2] * c[1]
    y = f[OMEGA + 2] * c[0] - f[OMEGA] * c[2]
    z = f[OMEGA] * c[1] - f[OMEGA + 1] * c[0]
    acc[0] += f[OMEGA + 1] * z - f[OMEGA + 2] * y
    acc[1] += f[OMEGA + 2] * x - f[OMEGA] * z
    acc[2] += f[OMEGA] * y - f[OMEGA + 1] * x
    vel[0] += x
    vel[1] += y
    vel[2] += z
    for k in range(3):
        r0, r1, r2 = p[3 + 3 * k], p[4 + 3 * k], p[5 + 3 * k]
        out[0, k] = r0 * c[0] + r1 * c[1] + r2 * c[2]
        out[1, k] = r0 * vel[0] + r1 * vel[1] + r2 * vel[2]
        out[2, k] = r0 * acc[0] + r1 * acc[1] + r2 * acc[2]
        out[3, k] = c[k]
        if point:
            out[0, k] += p[k]
            out[1, k] += p[12 + k]


@kernel
def equation(chain, work, k):
    """Evaluate equation k: value and second derivative; what rides on the links stays in scratch."""
    row, r, t = chain.closing[k], chain.anchor[k], work.scratch
    point = row[EQUATION] != DIRECTION
    a, b, d = t[0:4], t[4:8], t[8:12]
    ride(chain, work, row[LINK_A], r[0:3], point, a)
    ride(chain, work, row[LINK_B], r[3:6], point, b)
    value = second = 0.0
    if point:
        ride(chain, work, row[LINK_D], r[6:9], False, d)
        for i in range(3):
            value += d[0, i] * (a[0, i] - b[0, i])
            second += d[2, i] * (a[0, i] - b[0, i]) + 2.0 * d[1, i] * (a[1, i] - b[1, i])
            second += d[0, i] * (a[2, i] - b[2, i])
    else:
        for i in range(3):
            value += a[0, i] * b[0, i]
            second += a[2, i] * b[0, i] + 2.0 * a[1, i] * b[1, i] + a[0, i] * b[2, i]
    return value, second


@kernel
def pull(co, chain, work, n, r, point, c, x, y, z):
    """Add a force (x, y, z), base frame, on what rides on link n: c (3,) its value in body axes."""
    if n < 0:
        return
    if len(co) > 0:
        closing.pull(chain, work, n, point, c, x, y, z)
    else:
        pull_erls(chain, work, n, r, point, c, x, y, z)


@kernel
def pull_erls(chain, work, n, r, point, c, x, y, z):
    """pull for frames of the ERLS."""
    p, i = work.pose[n], chain.link[n, FIRST] + chain.link[n, COUNT]
    fx = p[3] * x + p[6] * y + p[9] * z
    fy = p[4] * x + p[7] * y + p[10] * z
    fz = p[5] * x + p[8] * y + p[11] * z
    force, wrench, turn = work.force[i], work.wrench[n], work.row[3, 0:6]
    spatial_row(work.node[DISPLACEMENT, i], len(chain.dofs) == 3, turn)
    mx, my, mz = force_on_turn(chain.setting[SPIN], turn[3:6], r, fx, fy, fz)
    if len(chain.dofs) == 3:
        if point:
            force[0] += fx
            force[1] += fy
            wrench[0] += fx
            wrench[1] += fy
        force[2] += mz
        wrench[2] += c[0] * fy - c[1] * fx
        return
    if point:
        force[0] += fx
        force[1] += fy
        force[2] += fz
        wrench[0] += fx
        wrench[1] += fy
        wrench[2] += fz
    force[3] += mx
    force[4] += my
    force[5] += mz
    wrench[3] += c[1] * fz - c[2] * fy
    wrench[4] += c[2] * fx - c[0] * fz
    wrench[5] += c[0] * fy - c[1] * fx


@kernel
def gradient(chain, work, k, out):
    """Row k of G into out (n,), after `equation` for the same k: the work of unit forces."""
    row, r, t, co = chain.closing[k], chain.anchor[k], work.scratch, chain.co_moving
    a, b, d = t[0:4], t[4:8], t[8:12]
    loosen(co, work)
    out[:] = 0.0
    if row[EQUATION] != DIRECTION:
        pull(co, chain, work, row[LINK_A], r[0:3], True, a[3], d[0, 0], d[0, 1], d[0, 2])
        pull(co, chain, work, row[LINK_B], r[3:6], True, b[3], -d[0, 0], -d[0, 1], -d[0, 2])
        x, y, z = a[0, 0] - b[0, 0], a[0, 1] - b[0, 1], a[0, 2] - b[0, 2]
        pull(co, chain, work, row[LINK_D], r[6:9], False, d[3], x, y, z)
    else:
        pull(co, chain, work, row[LINK_A], r[0:3], False, a[3], b[0, 0], b[0, 1], b[0, 2])
        pull(co, chain, work, row[LINK_B], r[3:6], False, b[3], a[0, 0], a[0, 1], a[0, 2])
    gather_pull(co, chain, work, out)


@kernel
def loosen(co, work):
    """Clear the forces that `pull` adds to."""
    if len(co) > 0:
        work.section_wrench[:] = 0.0
    else:
        work.force[:] = 0.0
        work.wrench[:] = 0.0


@kernel
def gather_pull(co, chain, work, out):
    """Add the forces of `pull` to those of the unknowns."""
    if len(co) > 0:
        gather_wrenches(chain, work, out)
    else:
        gather(chain, work, out)


@kernel
def damping_share(co, chain, row, v):
    """What of an equation's second derivative, with row (n,) of G, is due to Rayleigh's alpha."""
    if len(co) > 0:
        return closing.damping_share(chain, row, v)
    return 0.0


@kernel
def linearise(chain, work, v):
    """Write G and the second derivatives at the placed configuration, moving as `accelerate` was told."""
    w, n = work.closure, work.memory.size
    tail = 2 * n + w.shape[0]
    poses(chain, work, v)
    for k in range(w.shape[0]):
        _, w[k, tail + DEFECT] = equation(chain, work, k)
        gradient(chain, work, k, w[k, 0:n])
        w[k, tail + DEFECT] -= damping_share(chain.co_moving, chain, w[k, 0:n], v)


@kernel
def decompose(w, n):
    """Factorise S in place, pivots from its diagonal as long as an equation has a part of its own."""
    count = w.shape[0]
    s, tail = 2 * n, 2 * n + count
    for i in range(count):
        w[i, tail + ORDER] = -1.0
        w[i, tail + SCALE] = w[i, s + i]
    for step in range(count):
        best, pivot = DEPENDENT, -1
        for i in range(count):
            if w[i, tail + ORDER] < 0.0 and w[i, tail + SCALE] > 0.0:
                share = w[i, s + i] / w[i, tail + SCALE]
                if share > best:
                    best, pivot = share, i
        if pivot < 0:
            return
        w[pivot, tail + ORDER] = float(step)
        inverse = 1.0 / w[pivot, s + pivot]
        for i in range(count):
            if w[i, tail + ORDER] < 0.0:
                factor = w[i, s + pivot] * inverse
                w[i, s + pivot] = factor
                for j in range(count):
                    if w[j, tail + ORDER] < 0.0:
                        w[i, s + j] -= factor * w[pivot, s + j]


@kernel
def resolve(w, n):
    """Solve S FORCE = DEFECT; dependent equations get no force."""
    count = w.shape[0]
    s, tail = 2 * n, 2 * n + count
    for i in range(count):
        w[i, tail + FORCE] = w[i, tail + DEFECT] if w[i, tail + ORDER] >= 0.0 else 0.0
    for step in range(count):
        for p in range(count):
            if w[p, tail + ORDER] == step:
                for i in range(count):
                    if w[i, tail + ORDER] > step:
                        w[i, tail + FORCE] -= w[i, s + p] * w[p, tail + FORCE]
    for step in range(count - 1, -1, -1):
        for p in range(count):
            if w[p, tail + ORDER] == step:
                for j in range(count):
                    if w[j, tail + ORDER] > step:
                        w[p, tail + FORCE] -= w[p, s + j] * w[j, tail + FORCE]
                w[p, tail + FORCE] /= w[p, s + p]


@kernel
def linearise_loops(loops, chain, work, v):
    """`linearise` where there are loops, before what `keep_closed` is given is solved for."""
    if len(loops) > 0:
        linearise(chain, work, v)


@kernel
def keep_closed(loops, chain, work, da, damped):
    """Take from da, the free answer M^-1 f of the factorised tree at rates v, what would open the loops.

    `damped` scales the elastic part, as in the integrators.
    """
    if len(loops) > 0:
        constrain(chain, work, da, damped)


@kernel
def constrain(chain, work, da, damped):
    """`keep_closed` where there are loops, with G and the second derivatives of `linearise`."""
    w, n, m = work.closure, work.memory.size, int(chain.setting[COORDINATES])
    for i in range(m, n):
        da[i] *= damped
    count = w.shape[0]
    tail = 2 * n + count
    for k in range(count):
        solve(chain, work, w[k, 0:n], w[k, n : 2 * n])
        for i in range(m, n):
            w[k, n + i] *= damped
    for i in range(count):
        for k in range(count):
            total = 0.0
            for j in range(n):
                total += w[i, j] * w[k, n + j]
            w[i, 2 * n + k] = total
        for j in range(n):
            w[i, tail + DEFECT] += w[i, j] * da[j]
    decompose(w, n)
    resolve(w, n)
    subtract(w, n, da)
    for i in range(m, n):
        da[i] /= damped


@kernel
def subtract(w, n, y):
    """y -= M^-1 G^T FORCE."""
    force = 2 * n + w.shape[0] + FORCE
    for k in range(w.shape[0]):
        c = w[k, force]
        for i in range(n):
            y[i] -= c * w[k, n + i]


@kernel
def project(loops, chain, work, y):
    """Take from y (n,), an answer of the factorised tree, what would open the loops, after `keep_closed`."""
    if len(loops) == 0:
        return
    w, n = work.closure, work.memory.size
    at = 2 * n + w.shape[0] + DEFECT
    for k in range(w.shape[0]):
        total = 0.0
        for j in range(n):
            total += w[k, j] * y[j]
        w[k, at] = total
    resolve(w, n)
    subtract(w, n, y)


@kernel
def defects(chain, work, second):
    """Write the equations' values, or their second derivatives; returns the largest."""
    w = work.closure
    at = 2 * work.memory.size + w.shape[0] + DEFECT
    largest = 0.0
    for k in range(w.shape[0]):
        value, other = equation(chain, work, k)
        w[k, at] = other if second else value
        size = abs(w[k, at])
        if not size <= largest:
            largest = size
    return largest


@kernel
def close(loops, chain, work, x, v, still):
    """Close the loops at x and v with the factors of the last `keep_closed`; False where they stay open.

    still (n,) is a buffer.
    """
    if len(loops) == 0:
        return True
    w, n = work.closure, work.memory.size
    still[:] = 0.0
    size = before = np.inf
    for _ in range(CLOSING_STEPS):
        place(chain, work, x)
        poses(chain, work, still)
        size = defects(chain, work, False)
        if size <= CLOSED or not size < before:
            break
        before = size
        resolve(w, n)
        subtract(w, n, x)
    if not size <= OPEN:
        return False
    # without rates the second derivatives are linear in the accelerations: G v with v in their place
    before = np.inf
    for _ in range(CLOSING_STEPS):
        accelerate(chain, work, still, v)
        poses(chain, work, still)
        size = defects(chain, work, True)
        if size <= CLOSED or not size < before:
            break
        before = size
        resolve(w, n)
        subtract(w, n, v)
    accelerate(chain, work, v, still)  # the watch looks at how fast links turn
    return True
