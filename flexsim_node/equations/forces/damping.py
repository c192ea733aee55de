"""Rayleigh's alpha as a dissipation function: it damps the links' vibration and leaves rigid motion alone.

    D = alpha/2 w^T M w,    w = P v,

where w is the velocity of the elastic motion: that of the robot less that of the same robot moved rigidly by
its joints, deformation frozen. A joint turns at q' + phi', its coordinate's rate and its own elastic
rotation's; with that taken out (P v)_q = -phi', (P v)_phi = phi' and (P v)_u = u'. The force -alpha P^T M P v
takes energy at the rate 2 D, never gives any, does no work in rigid motion, and is the same whatever dofs are
zeroed, to the order of the elastic rotation times the elastic velocity. A joint's spring has a damper of its
own: its wind-up is motion of the joint here, and not of the links.

In the ERLS M is that of the undeformed links (what it leaves out is of the order of the elastic rotation);
moved with the links' frames, an element's or body's velocity is a nodal row, and its momentum one product
with a constant matrix. With co-moving frames it is that of the links as they are.

The thesis' own form (2.56), alpha M on the elastic rates alone but by virtual work on all coordinates, stands
in the inertia forces. Its power, minus alpha times the elastic velocity times the whole one, has no sign.
"""

from __future__ import annotations

from ...compiled.flat import flat
from ...compiled.kernel import kernel
from ...compiled.lanes import broadcast, load, multiply_add, plus, store
from ...model.chain import (
    AXIS,
    BODIES,
    COORDINATES,
    COUNT,
    FIRST,
    FIRST_BODY,
    FIRST_ELEMENT,
    FIXED,
    KIND,
    LEVER,
    PARENT,
    PHI,
    PRISMATIC,
    RELATIVE,
    REVOLUTE,
    ROTATION,
    TIP,
    TRIAL,
    Q,
)
from ...model.reduced.layout import COUPLING, MODAL_MASS, MODES
from .. import co_moving
from ..kinematics.dependent_nodes import fold_forces, own_nodes


@kernel
def elastic_rates(chain, v, out):
    """Write P v into out (n,): rates of the elastic motion alone, of rates v (n,)."""
    link = chain.link
    joints = int(chain.setting[COORDINATES])
    for i in range(joints):
        out[i] = 0.0
    for i in range(joints, out.size):
        out[i] = v[i]
    for n in range(link.shape[0]):
        if link[n, KIND] != FIXED and link[n, PHI] >= 0:
            out[link[n, Q]] = -v[link[n, PHI]]


@kernel
def nodal_alpha(chain):
    """Rayleigh's alpha where D is the nodes' own, alpha/2 u'^T M u' with the frames at rest; 0 elsewhere.

    So it is in the ERLS where no joint has an elastic rotation phi beside its coordinate.
    """
    if len(chain.co_moving) > 0:
        return 0.0
    for n in range(chain.link.shape[0]):
        if chain.link[n, PHI] >= 0:
            return 0.0
    return chain.setting[RELATIVE]


@kernel
def oppose(chain, work, v, out):
    """Add alpha P^T M P v, of the placed chain at rates v (n,), to out (n,)."""
    if chain.setting[RELATIVE] == 0.0:
        return
    link, alpha = chain.link, chain.setting[RELATIVE]
    y, momentum = work.vector[9], work.vector[10]
    elastic_rates(chain, v, y)
    momentum[:] = 0.0
    momenta(chain.co_moving, chain, work, y, momentum)
    for i in range(int(chain.setting[COORDINATES]), out.size):
        out[i] += alpha * momentum[i]
    for n in range(link.shape[0]):
        if link[n, KIND] != FIXED and link[n, PHI] >= 0:
            out[link[n, PHI]] -= alpha * momentum[link[n, Q]]


@kernel
def momenta(co, chain, work, y, out):
    """Add M y to out (n,), for either formulation."""
    if len(co) > 0:
        co_moving.momenta(chain, work, y, out)
    else:
        move(chain.dofs, chain, work, y, work.node[TRIAL])
        weigh(chain, work, work.node[TRIAL])
        gather_momenta(chain.dofs, chain, work, out)


@kernel
def move(dofs, chain, work, y, rows):
    """Nodal velocities of the undeformed robot at rates y, with the frames' motion, in the links' axes."""
    link, joint, frame, b = chain.link, chain.joint, work.frame, len(dofs)
    for n in range(link.shape[0]):
        f, parent, first, kind = frame[n], link[n, PARENT], link[n, FIRST], link[n, KIND]
        start, own = rows[first], work.load[n]  # the velocity of the link's frame
        for k in range(b):
            start[k] = own[k] = 0.0
        if parent >= 0:
            end, before = rows[link[parent, FIRST] + link[parent, COUNT]], work.load[parent]
            for k in range(b):
                start[k], own[k] = end[k], before[k]
            tip = joint[parent, TIP] if kind == PRISMATIC else f[LEVER]
            lever(dofs, f[LEVER] - tip, f[LEVER + 1], f[LEVER + 2], start)
            lever(dofs, f[LEVER], f[LEVER + 1], f[LEVER + 2], own)
            turn_back(dofs, f, start)
            turn_back(dofs, f, own)
        if kind == REVOLUTE:
            rate = y[link[n, Q]]
            if len(dofs) == 3:
                own[2] += joint[n, AXIS + 2] * rate
            else:
                for k in range(3):
                    own[3 + k] += joint[n, AXIS + k] * rate
        for k in range(b):
            start[k] -= own[k]
        own_nodes(chain, n, y, rows)
        for i in range(first, first + link[n, COUNT] + 1):
            x, row = chain.place[i], rows[i]
            for k in range(b):
                row[k] += own[k]
            if len(dofs) == 3:
                row[1] += own[2] * x
            else:
                row[1] += own[5] * x
                row[2] -= own[4] * x


@kernel
def weigh(chain, work, rows):
    """Write the momenta of elements and bodies with the nodal velocities `rows` into work.force."""
    link, force, b = chain.link, work.force, len(chain.dofs)
    force[:] = 0.0
    for n in range(link.shape[0]):
        weigh_elements(chain.dofs, chain, work, n, rows)
        weigh_modes(chain.reduction, chain, work, n, rows)
        for m in range(link[n, FIRST_BODY], link[n, FIRST_BODY] + link[n, BODIES]):
            i, mass = chain.body_place[m], chain.body_mass[m]
            for j in range(b):
                total = 0.0
                for k in range(b):
                    total += mass[j, k] * rows[i, k]
                force[i, j] += total


@kernel
def weigh_elements(dofs, chain, work, n, rows):
    """Add the momenta of link n's elements to work.force, which is zero there."""
    first, count, force = chain.link[n, FIRST], chain.link[n, COUNT], work.force
    if len(dofs) == 6:
        spatial_momenta(flat(chain.mass), chain.link[n, FIRST_ELEMENT], first, count, flat(rows), flat(force))
        return
    made = work.row[0]
    for i in range(first + 1, first + count + 1):
        m = chain.link[n, FIRST_ELEMENT] + i - first - 1
        for j in range(6):
            made[j] = 0.0
            for k in range(3):
                made[j] += chain.mass[m, j, k] * rows[i, k] + chain.mass[m, j, 3 + k] * rows[i - 1, k]
        for j in range(3):
            force[i, j] += made[j]
            force[i - 1, j] += made[3 + j]


@kernel
def spatial_momenta(mass, element, first, count, y, out):
    """The same in space, y and out with six numbers a node: a node's are summed up in registers.

    Six numbers are two fours, which overlap in the middle.
    """
    nothing = broadcast(0.0)
    here, there = nothing, nothing  # of a node, what the element before has given it
    for i in range(first + 1, first + count + 1):
        at = 144 * (element + i - first - 1)
        end, end_too, start, start_too = nothing, nothing, here, there
        more, more_too = nothing, nothing
        for k in range(6):
            own, before, other = broadcast(y[6 * i + k]), broadcast(y[6 * i - 6 + k]), at + 72
            end = multiply_add(own, load(mass, at), end)
            end_too = multiply_add(own, load(mass, at + 2), end_too)
            start = multiply_add(own, load(mass, at + 6), start)
            start_too = multiply_add(own, load(mass, at + 8), start_too)
            more = multiply_add(before, load(mass, other), more)
            more_too = multiply_add(before, load(mass, other + 2), more_too)
            start = multiply_add(before, load(mass, other + 6), start)
            start_too = multiply_add(before, load(mass, other + 8), start_too)
            at += 12
        store(out, 6 * i - 6, start)
        store(out, 6 * i - 4, start_too)
        here, there = plus(end, more), plus(end_too, more_too)
    if count > 0:
        store(out, 6 * (first + count), here)
        store(out, 6 * (first + count) + 2, there)


@kernel
def weigh_modes(reduction, chain, work, n, rows):
    """Add the momenta of a reduced link's modes, and what they have in common with its ends."""
    if len(reduction) == 0:
        return
    size, data, force = chain.reduced[n], chain.modal, work.force
    first, b = chain.link[n, FIRST], len(chain.dofs)
    for i in range(max(size[MODES], 0)):
        j, k = first + 2 + i // b, i % b
        speed, at = rows[j, k], size[COUPLING] + 2 * b * i
        total = data[size[MODAL_MASS] + i] * speed
        for p in range(b):
            total += data[at + p] * rows[first + 1, p] + data[at + b + p] * rows[first, p]
            force[first + 1, p] += data[at + p] * speed
            force[first, p] += data[at + b + p] * speed
        force[j, k] += total


@kernel
def gather_momenta(dofs, chain, work, out):
    """Add the momenta in work.force to those of the unknowns, by the transposed map of `move`."""
    link, joint, frame, b = chain.link, chain.joint, work.frame, len(dofs)
    force, wrench = work.force, work.wrench
    wrench[:] = 0.0
    for n in range(link.shape[0] - 1, -1, -1):
        f, parent, first, kind = frame[n], link[n, PARENT], link[n, FIRST], link[n, KIND]
        start, own = force[first], wrench[n]
        for i in range(first + 1, first + link[n, COUNT] + 1):
            x, row = chain.place[i], force[i]
            for k in range(b):
                own[k] += row[k]
            if len(dofs) == 3:
                own[2] += row[1] * x
            else:
                own[5] += row[1] * x
                own[4] -= row[2] * x
        # the start moves with what is before, and relative to the frame by what the frame does not
        for k in range(b):
            own[k] += start[k]
        fold_forces(chain, n, force, out)
        for k in range(b):
            own[k] -= start[k]
        if kind == REVOLUTE:
            if len(dofs) == 3:
                out[link[n, Q]] += joint[n, AXIS + 2] * own[2]
            else:
                for k in range(3):
                    out[link[n, Q]] += joint[n, AXIS + k] * own[3 + k]
        if parent < 0:
            continue
        turn_on(dofs, f, start)
        turn_on(dofs, f, own)
        tip = joint[parent, TIP] if kind == PRISMATIC else f[LEVER]
        lever_moment(dofs, f[LEVER] - tip, f[LEVER + 1], f[LEVER + 2], start)
        lever_moment(dofs, f[LEVER], f[LEVER + 1], f[LEVER + 2], own)
        end, before = force[link[parent, FIRST] + link[parent, COUNT]], wrench[parent]
        for k in range(b):
            end[k] += start[k]
            before[k] += own[k]


@kernel
def lever(dofs, x, y, z, r):
    """Move the point of a velocity r (b,) by a lever."""
    if len(dofs) == 3:
        r[0] -= r[2] * y
        r[1] += r[2] * x
        return
    r[0] += r[4] * z - r[5] * y
    r[1] += r[5] * x - r[3] * z
    r[2] += r[3] * y - r[4] * x


@kernel
def lever_moment(dofs, x, y, z, r):
    """Move the point of a force r (b,) back by a lever."""
    if len(dofs) == 3:
        r[2] += x * r[1] - y * r[0]
        return
    r[3] += y * r[2] - z * r[1]
    r[4] += z * r[0] - x * r[2]
    r[5] += x * r[1] - y * r[0]


@kernel
def turn_back(dofs, f, r):
    """Turn r (b,) from the parent's axes into the link's, frame row f."""
    if len(dofs) == 3:
        c, s, x, y = f[ROTATION], f[ROTATION + 3], r[0], r[1]
        r[0], r[1] = c * x + s * y, c * y - s * x
        return
    for h in range(0, 6, 3):
        x, y, z = r[h], r[h + 1], r[h + 2]
        for k in range(3):
            r[h + k] = f[ROTATION + k] * x + f[ROTATION + 3 + k] * y + f[ROTATION + 6 + k] * z


@kernel
def turn_on(dofs, f, r):
    """Turn r (b,) from the link's axes into the parent's, frame row f."""
    if len(dofs) == 3:
        c, s, x, y = f[ROTATION], f[ROTATION + 3], r[0], r[1]
        r[0], r[1] = c * x - s * y, s * x + c * y
        return
    for h in range(0, 6, 3):
        x, y, z = r[h], r[h + 1], r[h + 2]
        for k in range(3):
            p = ROTATION + 3 * k
            r[h + k] = f[p] * x + f[p + 1] * y + f[p + 2] * z
