"""Forces and inertia coupling of a reduced link in the plane: planar_beam.py with the modes' functions added.

Rows first, first + 1 of the nodal arrays are the link's start and end; its modes follow, packed.  size, data,
own as in reduced_link.py; e is the row of the link as one element.
"""

from __future__ import annotations

from . import planar_beam
from .beam import INERTIA_Y, LENGTH, SHEAR_Z, hermite, hermite_transpose, middle_rotation
from .flat import flat
from .kernel import kernel
from .reduced_chain import (
    AXIALS,
    CENTRELINE,
    LINE,
    MASS_GRAM,
    MIX,
    MODAL_STIFFNESS,
    MODES,
    PIVOTS,
    ROTATION,
    TENSIONS,
    TURN,
    TURN_GRAM,
    TURN_MIX,
    WIDTH,
)
from .reduced_link import products, slope_energy, stiffen
from .weighted_sum import dot, four_twice


@kernel
def centreline(e, size, z, first, x, own, c):
    """Write the coefficients of the centreline's functions into own[c:] (2, F); x = 1 adds the rest shape.

    z are nodal rows, flat.  Of a mode only the one that is not always zero.
    """
    p, r, m, n, length = 3 * first, 3 * first + 3, 3 * first + 6, size[CENTRELINE], e[LENGTH]
    stretch = z[r] - z[p] + x * length
    own[c], own[c + 1], own[c + 2], own[c + 3] = z[p], stretch, z[r] + x * length, stretch
    own[c + n], own[c + n + 1], own[c + n + 2], own[c + n + 3] = hermite(
        z[p + 1], z[p + 2], z[r + 1], z[r + 2], length, e[SHEAR_Z]
    )
    for i in range(size[AXIALS]):
        own[c + 4 + i] = z[m + i]
    for i in range(size[AXIALS], size[MODES]):
        own[c + n + 4 + i] = z[m + i]


@kernel
def rotation(e, size, z, first, own, phi):
    """Write the coefficients of the section's rotation into own[phi:] (G,); z are nodal rows, flat."""
    p, r, axial = 3 * first, 3 * first + 3, size[AXIALS]
    own[phi], own[phi + 2] = z[p + 2], z[r + 2]
    own[phi + 1] = middle_rotation(z[p + 1], z[p + 2], z[r + 1], z[r + 2], e[LENGTH], e[SHEAR_Z])
    for i in range(size[MODES] - axial):
        own[phi + 3 + i] = z[r + 3 + axial + i]


@kernel
def spread(e, size, own, g, force, first):
    """Add forces own[g:] (2, F) on the centreline's functions to those of the ends and the modes, flat."""
    p, r, m, n = 3 * first, 3 * first + 3, 3 * first + 6, size[CENTRELINE]
    pull = own[g + 1] + own[g + 3]
    force[p] += own[g] - pull
    force[r] += own[g + 2] + pull
    w1, t1, w2, t2 = hermite_transpose(
        own[g + n], own[g + n + 1], own[g + n + 2], own[g + n + 3], e[LENGTH], e[SHEAR_Z]
    )
    force[p + 1] += w1
    force[p + 2] += t1
    force[r + 1] += w2
    force[r + 2] += t2
    for i in range(size[AXIALS]):
        force[m + i] += own[g + 4 + i]
    for i in range(size[AXIALS], size[MODES]):
        force[m + i] += own[g + n + 4 + i]


@kernel
def middle_forces(e, g1):
    """Forces on the nodal (w, t) of start and end of a moment g1 on the middle section's rotation."""
    w = 1.5 * (1.0 - e[SHEAR_Z]) * g1 / e[LENGTH]
    t = -(0.25 - 0.75 * e[SHEAR_Z]) * g1
    return -w, t, w, t


@kernel
def forces(size, data, own, e, f, d, v, a, first, alpha, beta, coriolis, spin, force, wrench):
    """Add inertia, elastic and damping forces of a reduced link to nodes, modes and the link's wrench.

    Frame, coriolis and spin as in spatial_beam.inertia_force.
    """
    omega, turn = f[2], f[8]
    square, two = omega * omega, 2.0 * omega if coriolis else 0.0
    n, c, r, out = size[CENTRELINE], size[LINE], size[MIX], flat(force)
    x, y = flat(d), flat(v)
    ca, g = c + 6 * n, c + 8 * n
    centreline(e, size, x, first, 1.0, own, c)
    centreline(e, size, y, first, 0.0, own, c + 2 * n)
    centreline(e, size, flat(a), first, 0.0, own, c + 4 * n)
    own[r], own[r + 1], own[r + 2], own[r + 3], own[r + 4] = -square, -turn, alpha, -two, 1.0
    own[r + 6], own[r + 7], own[r + 8], own[r + 9], own[r + 11] = turn, -square, two, alpha, 1.0
    for j in range(0, n, 4):
        four_twice(6, own, r, 1, 6, own, c + j, n, own, ca + j, n)
    own[ca] += f[3]
    own[ca + 2] += f[3]
    own[ca + n] += f[4]
    own[ca + n + 2] += f[4]
    products(2, data, size[MASS_GRAM], n, own, ca, g)
    wrench[0] += own[g] + own[g + 2]
    wrench[1] += own[g + n] + own[g + n + 2]
    moment = dot(n, own, c, own, g + n) - dot(n, own, c + n, own, g)
    if not spin:
        # on the elastic displacement acts the centrifugal force of the rest shape alone
        own[c + 1] -= e[LENGTH]
        own[c + 2] -= e[LENGTH]
        own[c + 3] -= e[LENGTH]
        products(2, data, size[MASS_GRAM], n, own, c, ca)
        for k in range(2 * n):
            own[g + k] += square * own[ca + k]
    if size[TENSIONS] > 0:
        stiffen(size, data, own, x, y, first, 3, 1.0, beta, out)
    spread(e, size, own, g, out, first)
    if e[INERTIA_Y] > 0.0:
        moment += section_forces(size, data, own, e, f, x, y, flat(a), first, alpha, two, spin, out)
    wrench[2] += moment
    planar_beam.elastic_force(e, d, first + 1, force)
    if beta > 0.0:
        planar_beam.stiffness_product(e, d, v, first + 1, beta, force)
    begin = 3 * first + 6
    for i in range(size[MODES]):
        out[begin + i] += data[size[MODAL_STIFFNESS] + i] * (x[begin + i] + beta * y[begin + i])


@kernel
def stiffness_product(size, data, own, e, d, y, first, scale, force):
    """Add scale times the stiffness at the displacements d times the nodal vector y to the forces.

    The stiffness is the tangent without the axial force's own (geometric) part.
    """
    n, c, g = size[CENTRELINE], size[LINE], size[LINE] + 8 * size[CENTRELINE]
    rows, out, begin = flat(y), flat(force), 3 * first + 6
    planar_beam.stiffness_product(e, d, y, first + 1, scale, force)
    for i in range(size[MODES]):
        out[begin + i] += scale * data[size[MODAL_STIFFNESS] + i] * rows[begin + i]
    if size[TENSIONS] > 0:
        centreline(e, size, flat(d), first, 1.0, own, c)
        centreline(e, size, rows, first, 0.0, own, c + 2 * n)
        for k in range(2 * n):
            own[g + k] = 0.0
        stiffen(size, data, own, flat(d), rows, first, 3, 0.0, scale, out)
        spread(e, size, own, g, out, first)


@kernel
def section_forces(size, data, own, e, f, d, v, a, first, alpha, two, spin, force):
    """Add the inertia forces of the sections' rotation, director (-phi, 1); returns their moment.

    All nodal rows are flat.
    """
    omega, turn, j = f[2], f[8], e[INERTIA_Y]
    square, axial, n = omega * omega, size[AXIALS], size[ROTATION]
    phi, r = size[TURN], size[TURN_MIX]
    given, made = phi + 3 * n, phi + 5 * n
    rotation(e, size, d, first, own, phi)
    rotation(e, size, v, first, own, phi + n)
    rotation(e, size, a, first, own, phi + 2 * n)
    own[r], own[r + 1], own[r + 2] = j * square, -j * alpha, -j
    own[r + 3], own[r + 4], own[r + 5] = -j * turn, -j * two, 0.0
    for k in range(0, n, 4):
        four_twice(3, own, r, 1, 3, own, phi + k, n, own, given + k, n)
    for k in range(3):
        own[given + k] -= j * turn
        own[given + n + k] -= j * square
    products(2, data, size[TURN_GRAM], n, own, given, made)
    moment = -own[made] - own[made + 1] - own[made + 2] - dot(n, own, phi, own, made + n)
    if not spin:
        products(1, data, size[TURN_GRAM], n, own, phi, phi + 7 * n)
        for k in range(n):
            own[made + k] -= j * square * own[phi + 7 * n + k]
    p = 3 * first
    w1, t1, w2, t2 = middle_forces(e, own[made + 1])
    force[p + 1] -= w1
    force[p + 2] -= own[made] + t1
    force[p + 4] -= w2
    force[p + 5] -= own[made + 2] + t2
    for i in range(size[MODES] - axial):
        force[p + 6 + axial + i] -= own[made + 3 + i]
    return moment


@kernel
def inertia_coupling(size, data, own, e, d, first, coupling, inertia):
    """Write d(force)/d(link acceleration) of both ends into coupling (6, 3), of the modes into their rows.

    The link's own is added to inertia (3, 3), upper triangle.
    """
    n, mass, axial, width = size[CENTRELINE], size[MASS_GRAM], size[AXIALS], size[WIDTH]
    length, s, c, at = e[LENGTH], e[SHEAR_Z], size[LINE], size[PIVOTS] + 8
    q = c + 8 * n
    centreline(e, size, flat(d), first, 1.0, own, c)
    products(2, data, mass, n, own, c, q)
    second = dot(2 * n, own, c, own, q)
    total = data[mass] + 2.0 * data[mass + 2] + data[mass + 2 * n + 2]
    inertia[0, 0] += total
    inertia[1, 1] += total
    inertia[0, 2] -= own[q + n] + own[q + n + 2]
    inertia[1, 2] += own[q] + own[q + 2]
    # a unit acceleration along x or y has the coefficients (1, 0, 1, 0)
    half, twelfth = 0.5 * total, total * length / 12.0
    w1, t1, w2, t2 = hermite_transpose(own[q], own[q + 1], own[q + 2], own[q + 3], length, s)
    pull = own[q + n + 1] + own[q + n + 3]
    coupling[0, 0], coupling[0, 1], coupling[0, 2] = half, 0.0, pull - own[q + n]
    coupling[1, 0], coupling[1, 1], coupling[1, 2] = 0.0, half, w1
    coupling[2, 0], coupling[2, 1], coupling[2, 2] = 0.0, twelfth, t1
    coupling[3, 0], coupling[3, 1], coupling[3, 2] = half, 0.0, -pull - own[q + n + 2]
    coupling[4, 0], coupling[4, 1], coupling[4, 2] = 0.0, half, w2
    coupling[5, 0], coupling[5, 1], coupling[5, 2] = 0.0, -twelfth, t2
    for i in range(axial):
        row = at + i * width
        own[row], own[row + 1] = data[mass + 4 + i] + data[mass + 2 * n + 4 + i], 0.0
        own[row + 2] = -own[q + n + 4 + i]
    for i in range(axial, size[MODES]):
        row = at + i * width
        own[row], own[row + 1] = 0.0, data[mass + 4 + i] + data[mass + 2 * n + 4 + i]
        own[row + 2] = own[q + 4 + i]
    if e[INERTIA_Y] > 0.0:
        # e_z x director = (-1, -phi); on phi acts the x-component, turned round
        section, j, m, phi = size[TURN_GRAM], e[INERTIA_Y], size[ROTATION], size[TURN]
        rotation(e, size, flat(d), first, own, phi)
        products(1, data, section, m, own, phi, phi + 7 * m)
        second += j * (length + dot(m, own, phi, own, phi + 7 * m))
        # of the quadratics the integrals are a sixth, two thirds and a sixth of the length
        w1, t1, w2, t2 = middle_forces(e, j * length / 1.5)
        coupling[1, 2] += w1
        coupling[2, 2] += t1 + j * length / 6.0
        coupling[4, 2] += w2
        coupling[5, 2] += t2 + j * length / 6.0
        for i in range(size[MODES] - axial):
            one = data[section + 3 + i] + data[section + m + 3 + i] + data[section + 2 * m + 3 + i]
            own[at + (axial + i) * width + 2] += j * one
    inertia[2, 2] += second


@kernel
def axial_force(size, data, own, e, d, first):
    """Mean tension of a reduced link, N."""
    if size[TENSIONS] == 0:
        return planar_beam.axial_force(e, d, first + 1)
    centreline(e, size, flat(d), first, 1.0, own, size[LINE])
    return slope_energy(size, data, own, d, first, 3, 1)[1]
