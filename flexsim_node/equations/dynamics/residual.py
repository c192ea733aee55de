"""Equations of motion by d'Alembert-Lagrange: forces and inertia forces of a chain.

All functions are free functions of (chain, workspace, state); x holds the unknowns (joint coordinates, then
elastic ones), v their rates, a their accelerations.
"""

from __future__ import annotations

from ...compiled.kernel import kernel
from ...elements import planar_beam, rigid_body, spatial_beam
from ...model.chain import (
    ACCELERATION,
    ALPHA,
    BETA,
    BODIES,
    CORIOLIS,
    COULOMB,
    COUNT,
    DAMPER,
    DISPLACEMENT,
    FIRST,
    FIRST_BODY,
    FIRST_ELEMENT,
    FIXED,
    KIND,
    MOTOR,
    PHI,
    RATE,
    ROTOR,
    SPIN,
    SPRING,
    TRIAL,
    VISCOUS,
    Q,
)
from ...model.reduced.layout import MODES
from .. import co_moving
from ..co_moving import loads
from ..constraints import friction
from ..forces.damping import oppose
from ..forces.external import external_forces
from ..kinematics.nodal_motion import accelerate, gather, nodal_rates, place, spatial_row
from ..reduced import plane as planar_reduced_beam
from ..reduced import space as spatial_reduced_beam


@kernel
def joint_force(chain, work, x, v, a, torque, out):
    """Add motor torque minus friction and rotor inertia, on the physical joint angle q + phi.

    Where a spring stands between motor and link they act on the motor's own angle.  Coulomb friction is the
    one at hand.
    """
    link, joint = chain.link, chain.joint
    m = 0
    rubs = 0
    for n in range(link.shape[0]):
        if link[n, KIND] == FIXED:
            continue
        q, phi = link[n, Q], link[n, PHI]
        rate, acceleration = v[q], a[q]
        if phi >= 0:
            rate += v[phi]
            acceleration += a[phi]
        motor, spring = link[n, MOTOR], 0.0
        if motor >= 0:
            angle = x[q] + (x[phi] if phi >= 0 else 0.0)
            spring = joint[n, SPRING] * (x[motor] - angle) + joint[n, DAMPER] * (v[motor] - rate)
            rate, acceleration = v[motor], a[motor]
        effort = torque[m] - joint[n, VISCOUS] * rate - joint[n, ROTOR] * acceleration
        if joint[n, COULOMB] > 0.0:
            effort -= work.rubbing[rubs, work.rubbing.shape[1] - friction.COLUMNS + friction.FORCE]
            rubs += 1
        if motor >= 0:
            out[motor] += effort - spring
            effort = spring
        out[q] += effort
        if phi >= 0:
            out[phi] += effort
        m += 1


@kernel
def element_force(dofs, e, f, d, v, a, i, setting, force, wrench, scratch):
    """Inertia, elastic and damping forces of the element that ends at node i."""
    alpha, beta = setting[ALPHA], setting[BETA]
    coriolis, spin = setting[CORIOLIS] > 0.0, setting[SPIN] > 0.0
    if len(dofs) == 3:
        planar_beam.inertia_force(e, f, d, v, a, i, alpha, coriolis, spin, force, wrench)
        planar_beam.elastic_force(e, d, i, force)
    else:
        spatial_beam.inertia_force(e, f, d, v, a, i, alpha, coriolis, spin, force, wrench, scratch)
        spatial_beam.elastic_force(e, d, i, force)
    if beta > 0.0:
        stiffness_force(dofs, e, d, v, i, beta, force)


@kernel
def stiffness_force(dofs, e, d, rows, i, scale, force):
    """scale * K times nodal rows, of the element that ends at node i."""
    if len(dofs) == 3:
        planar_beam.stiffness_product(e, d, rows, i, scale, force)
    else:
        spatial_beam.stiffness_product(e, d, rows, i, scale, force)


@kernel
def reduced_forces(reduction, dofs, chain, work, n):
    """The same of link n as a whole, where it is reduced to modes; False where it is not."""
    if len(reduction) == 0:
        return False
    size, e, f = chain.reduced[n], chain.element[chain.link[n, FIRST_ELEMENT]], work.frame[n]
    if size[MODES] < 0:
        return False
    d, v, a = work.node[DISPLACEMENT], work.node[RATE], work.node[ACCELERATION]
    first, force, wrench = chain.link[n, FIRST], work.force, work.wrench[n]
    alpha, beta = chain.setting[ALPHA], chain.setting[BETA]
    coriolis, spin = chain.setting[CORIOLIS] > 0.0, chain.setting[SPIN] > 0.0
    data, own = chain.modal, work.modal
    if len(dofs) == 3:
        planar_reduced_beam.forces(
            size, data, own, e, f, d, v, a, first, alpha, beta, coriolis, spin, force, wrench
        )
    else:
        spatial_reduced_beam.forces(
            size, data, own, e, f, d, v, a, first, alpha, beta, coriolis, spin, force, wrench
        )
    return True


@kernel
def reduced_stiffness(reduction, dofs, chain, work, n, rows, scale):
    """`stiffness_force` of link n as a whole, where it is reduced to modes; False where it is not."""
    if len(reduction) == 0:
        return False
    size, e, first = chain.reduced[n], chain.element[chain.link[n, FIRST_ELEMENT]], chain.link[n, FIRST]
    if size[MODES] < 0:
        return False
    d, force, data, own = work.node[DISPLACEMENT], work.force, chain.modal, work.modal
    if len(dofs) == 3:
        planar_reduced_beam.stiffness_product(size, data, own, e, d, rows, first, scale, force)
    else:
        spatial_reduced_beam.stiffness_product(size, data, own, e, d, rows, first, scale, force)
    return True


@kernel
def link_forces(chain, work):
    """Inertia, elastic and damping forces of every element and body, at the placed and moving nodes."""
    link, element = chain.link, chain.element
    d, v, a = work.node[DISPLACEMENT], work.node[RATE], work.node[ACCELERATION]
    force, wrench = work.force, work.wrench
    alpha = chain.setting[ALPHA]
    coriolis, spin = chain.setting[CORIOLIS] > 0.0, chain.setting[SPIN] > 0.0
    planar = len(chain.dofs) == 3
    force[:] = 0.0
    wrench[:] = 0.0
    for n in range(link.shape[0]):
        f, first, start = work.frame[n], link[n, FIRST], link[n, FIRST_ELEMENT]
        whole = reduced_forces(chain.reduction, chain.dofs, chain, work, n)
        for k in range(0 if whole else link[n, COUNT]):
            e, i = element[start + k], first + k + 1
            element_force(chain.dofs, e, f, d, v, a, i, chain.setting, force, wrench[n], work.scratch)
        for k in range(link[n, FIRST_BODY], link[n, FIRST_BODY] + link[n, BODIES]):
            i = chain.body_place[k]
            r = work.row
            spatial_row(d[i], planar, r[1, 0:6])
            spatial_row(v[i], planar, r[2, 0:6])
            spatial_row(a[i], planar, r[3, 0:6])
            r[4, 0:6] = 0.0
            r[5, 0:6] = 0.0
            rigid_body.inertia_force(
                chain.body[k],
                chain.place[i],
                f,
                r[1],
                r[2],
                r[3],
                alpha,
                coriolis,
                spin,
                r[4],
                r[5],
                work.scratch,
            )
            if planar:
                for m, p in ((0, 0), (1, 1), (2, 5)):
                    force[i, m] += r[4, p]
                    wrench[n, m] += r[5, p]
            else:
                for m in range(6):
                    force[i, m] += r[4, m]
                    wrench[n, m] += r[5, m]


@kernel
def chain_forces(co, chain, work, v, a, out):
    """Add inertia, elastic and damping forces of the placed chain to out, whichever its formulation."""
    accelerate(chain, work, v, a)
    if len(co) > 0:
        work.section_wrench[:] = 0.0
        if work.loaded[0] or work.loaded[1]:
            loads.external_forces(chain, work)
        co_moving.gather(chain, work, out)
    else:
        link_forces(chain, work)
        if work.loaded[0] or work.loaded[1]:
            external_forces(chain, work)
        gather(chain, work, out)


@kernel
def residual(chain, work, x, v, a, torque, out):
    """Applied minus elastic, damping and inertia forces, f(x, v) - M(x) a, into out (n,).

    Coulomb friction is that of the rates v, none at rest.
    """
    friction.rub_by_rate(chain, work, v)
    imbalance(chain, work, x, v, a, torque, out)


@kernel
def imbalance(chain, work, x, v, a, torque, out):
    """`residual` with the Coulomb friction at hand, whatever the rates are."""
    place(chain, work, x)
    out[:] = 0.0
    oppose(chain, work, v, out)
    chain_forces(chain.co_moving, chain, work, v, a, out)
    for i in range(out.size):
        out[i] = -out[i]
    joint_force(chain, work, x, v, a, torque, out)


@kernel
def stiffness_times(chain, work, y, scale, out):
    """scale * K y into out (n,), at the placed configuration; springs between motors and links count."""
    stiffness_times_as(chain.co_moving, chain, work, y, scale, out)
    link, joint = chain.link, chain.joint
    for n in range(link.shape[0]):
        if link[n, MOTOR] >= 0:
            twist = y[link[n, Q]] - y[link[n, MOTOR]]
            if link[n, PHI] >= 0:
                twist += y[link[n, PHI]]
                out[link[n, PHI]] += scale * joint[n, SPRING] * twist
            out[link[n, Q]] += scale * joint[n, SPRING] * twist
            out[link[n, MOTOR]] -= scale * joint[n, SPRING] * twist


@kernel
def stiffness_times_as(co, chain, work, y, scale, out):
    """stiffness_times of the links, for either formulation."""
    if len(co) > 0:
        co_moving.stiffness_times(chain, work, y, scale, out)
    else:
        stiffness_times_erls(chain, work, y, scale, out)


@kernel
def stiffness_times_erls(chain, work, y, scale, out):
    """stiffness_times of the links, for frames of the ERLS."""
    link, element = chain.link, chain.element
    rows, d, force = work.node[TRIAL], work.node[DISPLACEMENT], work.force
    nodal_rates(chain, work, y, rows)
    force[:] = 0.0
    work.wrench[:] = 0.0
    for n in range(link.shape[0]):
        if reduced_stiffness(chain.reduction, chain.dofs, chain, work, n, rows, scale):
            continue
        for k in range(link[n, COUNT]):
            e, i = element[link[n, FIRST_ELEMENT] + k], link[n, FIRST] + k + 1
            stiffness_force(chain.dofs, e, d, rows, i, scale, force)
    out[:] = 0.0
    gather(chain, work, out)
