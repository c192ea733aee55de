"""Forces and inertia coupling of a reduced link in the plane: planar_beam.py with the modes' functions added.

Rows first, first + 1 of the nodal arrays are the link's start and end; its modes follow, packed.  size, data,
own as in link.py; e is the row of the link as one element.
"""

from __future__ import annotations

from ...compiled.flat import flat
from ...compiled.kernel import kernel
from ...compiled.weighted_sum import dot, mix
from ...elements import planar_beam
from ...elements.beam import INERTIA_Y, LENGTH, SHEAR_Z, hermite, hermite_transpose, middle_rotation
from ...model.reduced.layout import (
    AXIALS,
    CENTRELINE,
    FUNCTION,
    LINE,
    LUMP_GRAM,
    LUMPS,
    MASS_GRAM,
    MIX,
    MODES,
    PIVOTS,
    ROTATION,
    TENSIONS,
    TURN,
    TURN_GRAM,
    TURN_MIX,
    TURNED,
    WIDTH,
    Y_MODES,
)
from .link import elastic_forces, middle_forces, products, slope_energy, slopes, stiffen


@kernel
def centreline(e, size, z, first, x, own, c):
    """Write the coefficients of the centreline's functions into own[c:] (2, F); x = 1 adds the rest shape.

    z are nodal rows, flat.  Of a mode only the one that is not always zero.
    """
    p, r, m, length, h = 3 * first, 3 * first + 3, 3 * first + 6, e[LENGTH], c + size[Y_MODES]
    stretch = z[r] - z[p] + x * length
    own[h], own[h + 1], own[h + 2], own[h + 3] = z[p], stretch, z[r] + x * length, stretch
    h += size[CENTRELINE]
    own[h], own[h + 1], own[h + 2], own[h + 3] = hermite(
        z[p + 1], z[p + 2], z[r + 1], z[r + 2], length, e[SHEAR_Z]
    )
    for i in range(size[MODES]):
        own[c + size[FUNCTION + 2 * i]] = z[m + i]


@kernel
def rotation(e, size, z, first, own, phi):
    """Write the coefficients of the section's rotation into own[phi:] (G,); z are nodal rows, flat."""
    p, r, m, h = 3 * first, 3 * first + 3, 3 * first + 6 + size[AXIALS], phi + size[Y_MODES]
    own[h], own[h + 2] = z[p + 2], z[r + 2]
    own[h + 1] = middle_rotation(z[p + 1], z[p + 2], z[r + 1], z[r + 2], e[LENGTH], e[SHEAR_Z])
    for i in range(size[Y_MODES]):
        own[phi + i] = z[m + i]


@kernel
def shape(size, data, own, e, d, first):
    """Write what the displacements d alone decide: coefficients, half gradients of the squared slopes."""
    centreline(e, size, flat(d), first, 1.0, own, size[LINE])
    slopes(size, data, own, 3)
    if e[INERTIA_Y] > 0.0:
        rotation(e, size, flat(d), first, own, size[TURN])
        if size[TENSIONS] > 0:
            products(1, data, size[LUMP_GRAM], size[ROTATION], own, size[TURN], size[LUMPS])


@kernel
def spread(e, size, own, g, force, first):
    """Add forces own[g:] (2, F) on the centreline's functions to those of the ends and the modes, flat."""
    p, r, m, h = 3 * first, 3 * first + 3, 3 * first + 6, g + size[Y_MODES]
    pull = own[h + 1] + own[h + 3]
    force[p] += own[h] - pull
    force[r] += own[h + 2] + pull
    h += size[CENTRELINE]
    w1, t1, w2, t2 = hermite_transpose(own[h], own[h + 1], own[h + 2], own[h + 3], e[LENGTH], e[SHEAR_Z])
    force[p + 1] += w1
    force[p + 2] += t1
    force[r + 1] += w2
    force[r + 2] += t2
    for i in range(size[MODES]):
        force[m + i] += own[g + size[FUNCTION + 2 * i]]


@kernel
def forces(size, data, own, e, f, d, v, a, first, alpha, beta, coriolis, spin, force, wrench):
    """Add inertia, elastic and damping forces of the placed link to nodes, modes and the link's wrench.

    Frame, coriolis and spin as in spatial_beam.inertia_force.
    """
    omega, turn = f[2], f[8]
    square, two = omega * omega, 2.0 * omega if coriolis else 0.0
    n, c, r, out = size[CENTRELINE], size[LINE], size[MIX], flat(force)
    x, y = flat(d), flat(v)
    ca, g, h = c + 6 * n, c + 8 * n, size[Y_MODES]
    centreline(e, size, y, first, 0.0, own, c + 2 * n)
    centreline(e, size, flat(a), first, 0.0, own, c + 4 * n)
    own[r], own[r + 1], own[r + 2], own[r + 3], own[r + 4] = -square, -turn, alpha, -two, 1.0
    own[r + 6], own[r + 7], own[r + 8], own[r + 9], own[r + 11] = turn, -square, two, alpha, 1.0
    mix(2, 6, own, r, own, c, n, own, ca)
    own[ca + h] += f[3]
    own[ca + h + 2] += f[3]
    own[ca + h + n] += f[4]
    own[ca + h + n + 2] += f[4]
    products(2, data, size[MASS_GRAM], n, own, ca, g)
    wrench[0] += own[g + h] + own[g + h + 2]
    wrench[1] += own[g + h + n] + own[g + h + n + 2]
    moment = dot(n, own, c, own, g + n) - dot(n, own, c + n, own, g)
    if not spin:
        # on the elastic displacement acts the centrifugal force of the rest shape alone
        centreline(e, size, x, first, 0.0, own, c)
        products(2, data, size[MASS_GRAM], n, own, c, ca)
        for k in range(2 * n):
            own[g + k] += square * own[ca + k]
        centreline(e, size, x, first, 1.0, own, c)
    if size[TENSIONS] > 0:
        stiffen(size, data, own, x, y, first, 3, 1.0, beta, out)
    spread(e, size, own, g, out, first)
    if e[INERTIA_Y] > 0.0:
        moment += section_forces(size, data, own, e, f, y, flat(a), first, alpha, two, spin, out)
    wrench[2] += moment
    elastic_forces(size, data, own, x, y, first, 3, 1.0, beta, out)


@kernel
def stiffness_product(size, data, own, e, d, y, first, scale, force):
    """Add scale times the stiffness at the placed displacements d times the nodal vector y to the forces.

    The stiffness is the tangent without the axial force's own (geometric) part.
    """
    n, c, g = size[CENTRELINE], size[LINE], size[LINE] + 8 * size[CENTRELINE]
    rows, out = flat(y), flat(force)
    elastic_forces(size, data, own, rows, rows, first, 3, 0.0, scale, out)
    if size[TENSIONS] > 0:
        centreline(e, size, rows, first, 0.0, own, c + 2 * n)
        for k in range(2 * n):
            own[g + k] = 0.0
        stiffen(size, data, own, flat(d), rows, first, 3, 0.0, scale, out)
        spread(e, size, own, g, out, first)


@kernel
def section_forces(size, data, own, e, f, v, a, first, alpha, two, spin, force):
    """Add the inertia forces of the sections' rotation, director (-phi, 1); returns their moment.

    All nodal rows are flat.
    """
    omega, turn, j = f[2], f[8], e[INERTIA_Y]
    square, axial, n = omega * omega, size[AXIALS], size[ROTATION]
    phi, r, h = size[TURN], size[TURN_MIX], size[Y_MODES]
    given, made = phi + 3 * n, phi + 5 * n
    rotation(e, size, v, first, own, phi + n)
    rotation(e, size, a, first, own, phi + 2 * n)
    own[r], own[r + 1], own[r + 2] = j * square, -j * alpha, -j
    own[r + 3], own[r + 4], own[r + 5] = -j * turn, -j * two, 0.0
    mix(2, 3, own, r, own, phi, n, own, given)
    for k in range(h, h + 3):
        own[given + k] -= j * turn
        own[given + n + k] -= j * square
    products(2, data, size[TURN_GRAM], n, own, given, made)
    moment = -own[made + h] - own[made + h + 1] - own[made + h + 2] - dot(n, own, phi, own, made + n)
    if not spin:
        turned = size[TURNED]
        products(1, data, size[TURN_GRAM], n, own, phi, turned)
        for k in range(n):
            own[made + k] -= j * square * own[turned + k]
    if size[TENSIONS] > 0:
        # to second order the director is (-phi, 1 - phi^2 / 2), at the elements' ends
        lump = size[LUMPS]
        for k in range(n):
            own[made + k] -= j * square * own[lump + k]
        moment -= j * (turn * dot(n, own, phi, own, lump) + two * dot(n, own, phi + n, own, lump))
    p, m = 3 * first, 3 * first + 6 + axial
    for i in range(size[Y_MODES]):
        force[m + i] -= own[made + i]
    made += h
    w1, t1, w2, t2 = middle_forces(e, e[SHEAR_Z], own[made + 1])
    force[p + 1] -= w1
    force[p + 2] -= own[made] + t1
    force[p + 4] -= w2
    force[p + 5] -= own[made + 2] + t2
    return moment


@kernel
def inertia_coupling(size, data, own, e, start, end, inertia):
    """Add d(force)/d(link acceleration) of both ends to start and end (3, 3), of modes to their rows.

    The link's own is added to inertia (3, 3), upper triangle; the link is placed.
    """
    n, mass, axial, width, h = size[CENTRELINE], size[MASS_GRAM], size[AXIALS], size[WIDTH], size[Y_MODES]
    length, s, c, row = e[LENGTH], e[SHEAR_Z], size[LINE], size[PIVOTS] + 6
    line = c + 8 * n
    products(2, data, mass, n, own, c, line)
    second = dot(2 * n, own, c, own, line)
    q = line + h
    # the unit field is in the span of Hermite's functions: first and third
    first_one, second_one = mass + h * n, mass + (h + 2) * n
    total = data[first_one + h] + 2.0 * data[first_one + h + 2] + data[second_one + h + 2]
    inertia[0, 0] += total
    inertia[1, 1] += total
    inertia[0, 2] -= own[q + n] + own[q + n + 2]
    inertia[1, 2] += own[q] + own[q + 2]
    # a unit acceleration along x or y has the coefficients (1, 0, 1, 0)
    half, twelfth = 0.5 * total, total * length / 12.0
    w1, t1, w2, t2 = hermite_transpose(own[q], own[q + 1], own[q + 2], own[q + 3], length, s)
    pull = own[q + n + 1] + own[q + n + 3]
    start[0, 0] += half
    end[0, 0] += half
    start[0, 2] += pull - own[q + n]
    end[0, 2] -= pull + own[q + n + 2]
    start[1, 1] += half
    end[1, 1] += half
    start[2, 1] += twelfth
    end[2, 1] -= twelfth
    start[1, 2] += w1
    start[2, 2] += t1
    end[1, 2] += w2
    end[2, 2] += t2
    for k in range(h + 4, h + 4 + axial):
        own[row], own[row + 1] = data[first_one + k] + data[second_one + k], 0.0
        own[row + 2] = -own[line + n + k]
        row += width
    for k in range(h):
        own[row], own[row + 1] = 0.0, data[first_one + k] + data[second_one + k]
        own[row + 2] = own[line + k]
        row += width
    if e[INERTIA_Y] > 0.0:
        # e_z x director = (-1, -phi); on phi acts the x-component, turned round
        section, j, m, phi = size[TURN_GRAM], e[INERTIA_Y], size[ROTATION], size[TURN]
        products(1, data, section, m, own, phi, size[TURNED])
        second += j * (length + dot(m, own, phi, own, size[TURNED]))
        if size[TENSIONS] > 0:
            second -= j * dot(m, own, phi, own, size[LUMPS])
        # of the quadratics the integrals are a sixth, two thirds and a sixth of the length
        w1, t1, w2, t2 = middle_forces(e, e[SHEAR_Z], j * length / 1.5)
        start[1, 2] += w1
        start[2, 2] += t1 + j * length / 6.0
        end[1, 2] += w2
        end[2, 2] += t2 + j * length / 6.0
        row = size[PIVOTS] + 8 + axial * width
        for k in range(section + h * m, section + h * m + h):
            own[row] += j * (data[k] + data[k + m] + data[k + 2 * m])
            row += width
    inertia[2, 2] += second


@kernel
def axial_force(size, data, own, e, d, first):
    """Mean tension of a placed link, N."""
    if size[TENSIONS] == 0:
        return planar_beam.axial_force(e, d, first + 1)
    return slope_energy(size, data, own, d, first, 3)[1]
