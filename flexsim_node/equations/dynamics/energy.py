"""Kinetic, elastic and gravitational energy of a chain, from its mass matrices rather than its forces."""

from __future__ import annotations

import numpy as np

from ...compiled.flat import flat
from ...compiled.kernel import allocating_kernel
from ...elements import planar_beam, rigid_body, spatial_beam
from ...elements.beam import LENGTH, MASS, STIFFENING, TURNING, stiffening_energy
from ...elements.spatial_strain import turning_energy
from ...model.chain import (
    BODIES,
    COUNT,
    DISPLACEMENT,
    FIRST,
    FIRST_BODY,
    FIRST_ELEMENT,
    FIXED,
    GRAVITY,
    KIND,
    LEVER,
    MOTOR,
    PARENT,
    PHI,
    PRISMATIC,
    RATE,
    REVOLUTE,
    ROTOR,
    SPIN,
    SPRING,
    Q,
)
from ...model.reduced.layout import COUPLING, MODAL_MASS, MODAL_STIFFNESS, MODES, PIVOTS, WIDTH
from ..co_moving import view
from ..kinematics.nodal_motion import nodal_rates, place, spatial_row
from ..kinematics.spatial_kinematics import to_child
from ..reduced import plane as planar_reduced_beam
from ..reduced import space_coupling as spatial_reduced_coupling
from ..reduced.link import slope_energy
from ..reduced.turning import turning_energy as reduced_turning_energy


@allocating_kernel
def quadratic_form(matrix, end, start, b):
    """Half of x^T matrix x for x = (end, start), two nodal rows."""
    total = 0.0
    for i in range(b):
        for k in range(b):
            total += end[i] * (matrix[i, k] * end[k] + matrix[i, b + k] * start[k])
            total += start[i] * (matrix[b + i, k] * end[k] + matrix[b + i, b + k] * start[k])
    return 0.5 * total


@allocating_kernel
def energy(chain, work, x, v, out):
    """Write kinetic, elastic and gravitational energy (J) into out (3,)."""
    energy_as(chain.co_moving, chain, work, x, v, out)


@allocating_kernel
def energy_as(co, chain, work, x, v, out):
    """energy for either formulation; the other one is not even compiled."""
    if len(co) > 0:
        place(chain, work, x)
        view.energy(chain.dofs, chain, work, x, v, out)
    else:
        energy_erls(chain, work, x, v, out)


@allocating_kernel
def element_coupling(dofs, e, d, i, coupling, inertia, t):
    """Inertia that couples an element's nodes and its link's motion."""
    if len(dofs) == 3:
        planar_beam.inertia_coupling(e, d, i, coupling, inertia)
    else:
        spatial_beam.inertia_coupling(e, d, i, coupling, inertia, t)


@allocating_kernel
def modal_energy(chain, work, n, d, rate, w, out):
    """Add a reduced link's modes to kinetic and linear elastic energy; their coupling is in their rows."""
    size, data, first, b = chain.reduced[n], chain.modal, chain.link[n, FIRST], len(chain.dofs)
    for i in range(size[MODES]):
        z, speed = d[first + 2 + i // b, i % b], rate[first + 2 + i // b, i % b]
        momentum = 0.5 * data[size[MODAL_MASS] + i] * speed
        for k in range(b):
            coupling = work.modal[size[PIVOTS] + i * size[WIDTH] + 2 * b + k]
            momentum += coupling * (w[5] if b == 3 and k == 2 else w[k])
            momentum += data[size[COUPLING] + 2 * b * i + k] * rate[first + 1, k]
            momentum += data[size[COUPLING] + 2 * b * i + b + k] * rate[first, k]
        out[0] += momentum * speed
        out[1] += 0.5 * data[size[MODAL_STIFFNESS] + i] * z * z


@allocating_kernel
def reduced_coupling(reduction, dofs, chain, work, n, rate, w, coupling, inertia, out):
    """`element_coupling` of a link that is reduced to modes, and their energy; False where it is not."""
    if len(reduction) == 0:
        return False
    size, e, d = chain.reduced[n], chain.element[chain.link[n, FIRST_ELEMENT]], work.node[DISPLACEMENT]
    if size[MODES] < 0:
        return False
    data, own, first = chain.modal, work.modal, chain.link[n, FIRST]
    coupling[:] = 0.0
    start, end = coupling[: len(dofs)], coupling[len(dofs) : 2 * len(dofs)]
    if len(dofs) == 3:
        planar_reduced_beam.inertia_coupling(size, data, own, e, start, end, inertia)
    else:
        spatial_reduced_coupling.inertia_coupling(size, data, own, e, start, end, inertia)
    modal_energy(chain, work, n, d, rate, w, out)
    out[1] += slope_energy(size, data, own, d, first, len(dofs))[0]
    if len(dofs) == 6:
        out[1] += reduced_turning_energy(size, data, own, e, flat(d), first)
    return True


@allocating_kernel
def energy_erls(chain, work, x, v, out):
    """energy for frames of the ERLS."""
    link, joint = chain.link, chain.joint
    b = len(chain.dofs)
    planar = b == 3
    place(chain, work, x)
    nodal_rates(chain, work, v, work.node[RATE])
    d, rate = work.node[DISPLACEMENT], work.node[RATE]
    links = link.shape[0]
    twist = np.zeros((links, 6))
    gravity = np.zeros((links, 6))
    height = np.zeros(links)
    r, p, s = np.zeros(6), np.zeros(6), np.zeros(6)
    coupling, inertia = np.zeros((2 * b, b)), np.zeros((b, b))
    body_coupling, full, own = np.zeros((6, 6)), np.zeros((6, 6)), np.zeros((6, 6))
    t = np.zeros((24, 3))
    out[:] = 0.0
    for n in range(links):
        f, parent, kind = work.frame[n], link[n, PARENT], link[n, KIND]
        w, g = twist[n], gravity[n]
        if parent >= 0:
            u, gp = twist[parent], gravity[parent]
            l0, l1, l2 = f[LEVER], f[LEVER + 1], f[LEVER + 2]
            w[0] = u[0] + u[4] * l2 - u[5] * l1
            w[1] = u[1] + u[5] * l0 - u[3] * l2
            w[2] = u[2] + u[3] * l1 - u[4] * l0
            w[3], w[4], w[5] = u[3], u[4], u[5]
            g[0], g[1], g[2] = gp[0], gp[1], gp[2]
            height[n] = height[parent] + g[0] * l0 + g[1] * l1 + g[2] * l2
        else:
            for k in range(3):
                g[k] = chain.setting[GRAVITY + k]
                height[n] += g[k] * f[LEVER + k]
        if kind == PRISMATIC:
            for k in range(3):
                w[k] += joint[n, 4 + k] * v[link[n, Q]]
        to_child(f, w)
        to_child(f, g)
        if kind == REVOLUTE:
            for k in range(3):
                w[3 + k] += joint[n, 1 + k] * v[link[n, Q]]
        full[:] = 0.0
        for k in range(link[n, COUNT]):
            m, i = link[n, FIRST_ELEMENT] + k, link[n, FIRST] + k + 1
            e = chain.element[m]
            inertia[:] = 0.0
            if not reduced_coupling(
                chain.reduction, chain.dofs, chain, work, n, rate, w, coupling, inertia, out
            ):
                element_coupling(chain.dofs, e, d, i, coupling, inertia, t)
            for h in range(b):
                twist_h = w[5] if planar and h == 2 else w[h]
                full_h = 5 if planar and h == 2 else h
                for j in range(b):
                    out[0] += twist_h * (coupling[j, h] * rate[i - 1, j] + coupling[b + j, h] * rate[i, j])
                    full[full_h, 5 if planar and j == 2 else j] += inertia[h, j]
            out[0] += quadratic_form(chain.mass[m], rate[i], rate[i - 1], b)
            out[1] += quadratic_form(chain.stiffness[m], d[i], d[i - 1], b)
            if e[STIFFENING] > 0.0:
                spatial_row(d[i - 1], planar, p)
                spatial_row(d[i], planar, r)
                out[1] += stiffening_energy(e, p, r)
                if e[TURNING] > 0.0:
                    out[1] += turning_energy(e, p, r)
                spatial_row(rate[i - 1], planar, s)
                moved = p[4] * s[4] + p[5] * s[5]
                along = s[0]
                spatial_row(rate[i], planar, s)
                moved = e[LENGTH] / 12.0 * (r[4] * s[4] + r[5] * s[5] - moved)
                out[0] += 0.5 * e[MASS] * moved * (along + s[0] + moved)
        for k in range(link[n, FIRST_BODY], link[n, FIRST_BODY] + link[n, BODIES]):
            i = chain.body_place[k]
            spatial_row(d[i], planar, r)
            spatial_row(rate[i], planar, s)
            turning = chain.setting[SPIN]
            rigid_body.inertia_coupling(chain.body[k], chain.place[i], r, turning, body_coupling, full, t)
            rigid_body.own_mass(chain.body[k], r, turning, own, p, t)
            for h in range(6):
                for j in range(6):
                    out[0] += w[h] * body_coupling[j, h] * s[j]
            for h in range(6):
                for j in range(6):
                    out[0] += 0.5 * s[h] * own[h, j] * s[j]
        for h in range(6):
            out[0] += 0.5 * full[h, h] * w[h] * w[h]
            for j in range(h + 1, 6):
                out[0] += full[h, j] * w[h] * w[j]
        # mass and first moments stand in the mass matrix of the link's own motion
        out[2] -= full[0, 0] * height[n]
        out[2] -= full[1, 5] * g[0] - full[0, 5] * g[1]
        if not planar:
            out[2] -= full[0, 4] * g[2]
        if kind != FIXED:
            speed = v[link[n, Q]]
            if link[n, PHI] >= 0:
                speed += v[link[n, PHI]]
            motor = link[n, MOTOR]
            if motor >= 0:
                wound = x[motor] - x[link[n, Q]] - (x[link[n, PHI]] if link[n, PHI] >= 0 else 0.0)
                out[1] += 0.5 * joint[n, SPRING] * wound * wound
                speed = v[motor]
            out[0] += 0.5 * joint[n, ROTOR] * speed * speed
