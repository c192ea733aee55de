"""Forces and inertia coupling of a reduced link in the plane: planar_beam.py with the modes' functions added.

Rows first, first + 1 of the nodal arrays are the link's start and end; its modes follow, packed.  size, data,
own as in reduced_link.py; e is the row of the link as one element.
"""

from __future__ import annotations

from . import planar_beam
from .beam import INERTIA_Y, LENGTH, SHEAR_Z, hermite, hermite_transpose, middle_rotation
from .kernel import kernel
from .reduced_chain import (
    AXIALS,
    CENTRELINE,
    MODES,
    ROTATION,
    TENSIONS,
    buffer_places,
    constant_places,
    row_width,
)
from .reduced_link import field, mode_rows, products, slope_energy, stiffen, tension_row


@kernel
def centreline(e, size, rows, first, x, c):
    """Write the coefficients of the centreline's functions into c (2 F,); x = 1 adds the rest shape.

    Of a mode only the one that is not always zero.
    """
    p, r, length, n = rows[first], rows[first + 1], e[LENGTH], size[CENTRELINE]
    stretch = r[0] - p[0] + x * length
    c[0], c[1], c[2], c[3] = p[0], stretch, r[0] + x * length, stretch
    c[n], c[n + 1], c[n + 2], c[n + 3] = hermite(p[1], p[2], r[1], r[2], length, e[SHEAR_Z])
    for i in range(size[MODES]):
        value = rows[first + 2 + i // 3, i % 3]
        c[4 + i if i < size[AXIALS] else n + 4 + i] = value


@kernel
def rotation(e, size, rows, first, phi):
    """Write the coefficients of the section's rotation into phi (G,)."""
    p, r, axial = rows[first], rows[first + 1], size[AXIALS]
    phi[0], phi[2] = p[2], r[2]
    phi[1] = middle_rotation(p[1], p[2], r[1], r[2], e[LENGTH], e[SHEAR_Z])
    for i in range(axial, size[MODES]):
        phi[3 + i - axial] = rows[first + 2 + i // 3, i % 3]


@kernel
def spread(e, size, g, force, first):
    """Add forces g (2 F,) on the centreline's functions to those of the ends and the modes."""
    p, r, n = force[first], force[first + 1], size[CENTRELINE]
    pull = g[1] + g[3]
    p[0] += g[0] - pull
    r[0] += g[2] + pull
    w1, t1, w2, t2 = hermite_transpose(g[n], g[n + 1], g[n + 2], g[n + 3], e[LENGTH], e[SHEAR_Z])
    p[1] += w1
    p[2] += t1
    r[1] += w2
    r[2] += t2
    for i in range(size[MODES]):
        force[first + 2 + i // 3, i % 3] += g[4 + i] if i < size[AXIALS] else g[n + 4 + i]


@kernel
def spread_middle(e, g1, p, r):
    """Add a moment g1 on the middle section's rotation to the nodal forces p, r."""
    length, s = e[LENGTH], e[SHEAR_Z]
    middle = 1.5 * (1.0 - s) * g1 / length
    p[1] -= middle
    r[1] += middle
    middle = (0.25 - 0.75 * s) * g1
    p[2] -= middle
    r[2] -= middle


@kernel
def forces(size, data, own, e, f, d, v, a, first, alpha, beta, coriolis, spin, force, wrench):
    """Add inertia, elastic and damping forces of a reduced link to nodes, modes and the link's wrench.

    Frame, coriolis and spin as in spatial_beam.inertia_force.
    """
    omega, turn = f[2], f[8]
    square, two = omega * omega, 2.0 * omega if coriolis else 0.0
    places, centre, n = constant_places(size, 3), buffer_places(size, 3)[3], size[CENTRELINE]
    mass = data[places[0] : places[1]]
    # a component lies n further; stiffen leaves room for three
    c, ca = own[centre : centre + 3 * n], own[centre + 9 * n : centre + 12 * n]
    g, r = own[centre + 12 * n : centre + 15 * n], own[centre + 15 * n : centre + 15 * n + 18]
    centreline(e, size, d, first, 1.0, c)
    centreline(e, size, v, first, 0.0, own[centre + 3 * n : centre + 6 * n])
    centreline(e, size, a, first, 0.0, own[centre + 6 * n : centre + 9 * n])
    r[0], r[1], r[3], r[4], r[6] = -square, -turn, alpha, -two, 1.0
    r[9], r[10], r[12], r[13], r[16] = turn, -square, two, alpha, 1.0
    field(size, own, 3, 2)
    for k in range(2):
        ca[k * n] += f[3 + k]
        ca[k * n + 2] += f[3 + k]
    products(mass, n, 2, ca, g)
    moment = 0.0
    for k in range(n):
        moment += c[k] * g[n + k] - c[n + k] * g[k]
    wrench[0] += g[0] + g[2]
    wrench[1] += g[n] + g[n + 2]
    if not spin:
        # on the elastic displacement acts the centrifugal force of the rest shape alone
        c[1] -= e[LENGTH]
        c[2] -= e[LENGTH]
        c[3] -= e[LENGTH]
        products(mass, n, 2, c, ca)
        for k in range(2 * n):
            g[k] += square * ca[k]
    if size[TENSIONS] > 0:
        stiffen(size, data, own, d, v, first, 3, 1.0, beta, force)
    spread(e, size, g, force, first)
    if e[INERTIA_Y] > 0.0:
        moment += section_forces(size, data, own, e, f, d, v, a, first, alpha, two, spin, force)
    wrench[2] += moment
    planar_beam.elastic_force(e, d, first + 1, force)
    if beta > 0.0:
        planar_beam.stiffness_product(e, d, v, first + 1, beta, force)
    for i in range(size[MODES]):
        p, k = first + 2 + i // 3, i % 3
        force[p, k] += data[places[5] + i] * (d[p, k] + beta * v[p, k])


@kernel
def stiffness_product(size, data, own, e, d, y, first, scale, force):
    """Add scale times the stiffness at the displacements d times the nodal vector y to the forces.

    The stiffness is the tangent without the axial force's own (geometric) part.
    """
    places, centre, n = constant_places(size, 3), buffer_places(size, 3)[3], size[CENTRELINE]
    planar_beam.stiffness_product(e, d, y, first + 1, scale, force)
    for i in range(size[MODES]):
        p, q = first + 2 + i // 3, i % 3
        force[p, q] += scale * data[places[5] + i] * y[p, q]
    if size[TENSIONS] > 0:
        g = own[centre + 12 * n : centre + 15 * n]
        centreline(e, size, d, first, 1.0, own[centre : centre + 3 * n])
        centreline(e, size, y, first, 0.0, own[centre + 3 * n : centre + 6 * n])
        for k in range(2 * n):
            g[k] = 0.0
        stiffen(size, data, own, d, y, first, 3, 0.0, scale, force)
        spread(e, size, g, force, first)


@kernel
def section_forces(size, data, own, e, f, d, v, a, first, alpha, two, spin, force):
    """Add the inertia forces of the sections' rotation, director (-phi, 1); returns their moment."""
    omega, turn, j = f[2], f[8], e[INERTIA_Y]
    square, axial, n = omega * omega, size[AXIALS], size[ROTATION]
    places, at = constant_places(size, 3), buffer_places(size, 3)[4]
    section = data[places[1] : places[2]]
    phi, rate, change = own[at : at + n], own[at + n : at + 2 * n], own[at + 2 * n : at + 3 * n]
    given, made = own[at + 3 * n : at + 5 * n], own[at + 5 * n : at + 7 * n]
    rotation(e, size, d, first, phi)
    rotation(e, size, v, first, rate)
    rotation(e, size, a, first, change)
    for k in range(n):
        one = 1.0 if k < 3 else 0.0
        given[k] = j * (square * phi[k] - turn * one - change[k] - alpha * rate[k])
        given[n + k] = j * (-square * one - turn * phi[k] - two * rate[k])
    products(section, n, 2, given, made)
    moment = -made[0] - made[1] - made[2]
    for k in range(n):
        moment -= phi[k] * made[n + k]
    if not spin:
        for k in range(n):
            given[k], given[n + k] = j * square * phi[k], 0.0
        products(section, n, 2, given, own[at + 7 * n : at + 9 * n])
        for k in range(n):
            made[k] -= own[at + 7 * n + k]
    p, r = force[first], force[first + 1]
    p[2] -= made[0]
    r[2] -= made[2]
    spread_middle(e, -made[1], p, r)
    for i in range(size[MODES] - axial):
        force[first + 2 + (axial + i) // 3, (axial + i) % 3] -= made[3 + i]
    return moment


@kernel
def inertia_coupling(size, data, own, e, d, first, coupling, inertia):
    """Write d(force)/d(link acceleration) of both ends into coupling (6, 3), of the modes into their rows.

    The link's own is added to inertia (3, 3), upper triangle.
    """
    places, buffers, n = constant_places(size, 3), buffer_places(size, 3), size[CENTRELINE]
    axial, width, centre = size[AXIALS], row_width(size, 3), buffers[3]
    length, s, mass = e[LENGTH], e[SHEAR_Z], data[places[0] : places[1]]
    c, q = own[centre : centre + 3 * n], own[centre + 12 * n : centre + 15 * n]
    centreline(e, size, d, first, 1.0, c)
    products(mass, n, 2, c, q)
    second = 0.0
    for k in range(2 * n):
        second += c[k] * q[k]
    total = mass[0] + 2.0 * mass[2] + mass[2 * n + 2]
    inertia[0, 0] += total
    inertia[1, 1] += total
    inertia[0, 2] -= q[n] + q[n + 2]
    inertia[1, 2] += q[0] + q[2]
    # a unit acceleration along x or y has the coefficients (1, 0, 1, 0)
    f0, f1 = mass[0] + mass[2 * n], mass[1] + mass[2 * n + 1]
    f2, f3 = mass[2] + mass[2 * n + 2], mass[3] + mass[2 * n + 3]
    coupling[:] = 0.0
    coupling[0, 0], coupling[3, 0] = f0 - f1 - f3, f2 + f1 + f3
    coupling[1, 1], coupling[2, 1], coupling[4, 1], coupling[5, 1] = hermite_transpose(
        f0, f1, f2, f3, length, s
    )
    pull = q[n + 1] + q[n + 3]
    coupling[0, 2], coupling[3, 2] = pull - q[n], -pull - q[n + 2]
    coupling[1, 2], coupling[2, 2], coupling[4, 2], coupling[5, 2] = hermite_transpose(
        q[0], q[1], q[2], q[3], length, s
    )
    for i in range(size[MODES]):
        at, along = buffers[0] + i * width + 8, mass[4 + i] + mass[2 * n + 4 + i]
        bends = i >= axial
        own[at] = 0.0 if bends else along
        own[at + 1] = along if bends else 0.0
        own[at + 2] = q[4 + i] if bends else -q[n + 4 + i]
    if e[INERTIA_Y] > 0.0:
        # e_z x director = (-1, -phi); on phi acts the x-component, turned round
        section, j, m = data[places[1] : places[2]], e[INERTIA_Y], size[ROTATION]
        phi = own[buffers[4] : buffers[4] + m]
        rotation(e, size, d, first, phi)
        second += j * length
        for i in range(3 + size[MODES] - axial):
            total = 0.0
            for k in range(m):
                total += section[i * m + k] * phi[k]
            second += j * phi[i] * total
            one = j * (section[i] + section[m + i] + section[2 * m + i])
            if i == 1:
                spread_middle(e, one, coupling[0:3, 2], coupling[3:6, 2])
            elif i < 3:
                coupling[2 if i == 0 else 5, 2] += one
            else:
                own[buffers[0] + (axial + i - 3) * width + 10] += one
    inertia[2, 2] += second


@kernel
def modal_rows(size, data, own, e, d, first, scale, coupling, w):
    """Fill in the rows by which a link's modes and tensions are eliminated from the front w, and coupling.

    What the tensions stand for leaves w and the modes' pivots.
    """
    inertia_coupling(size, data, own, e, d, first, coupling, w[6:9, 6:9])
    mode_rows(size, data, own, 3, scale)
    if scale == 0.0:
        return
    tension = constant_places(size, 3)[3]
    for j in range(size[TENSIONS]):
        tension_row(size, data, own, e, 3, j, scale * data[tension + j], w)


@kernel
def axial_force(size, data, own, e, d, first):
    """Mean tension of a reduced link, N."""
    if size[TENSIONS] == 0:
        return planar_beam.axial_force(e, d, first + 1)
    centre = buffer_places(size, 3)[3]
    centreline(e, size, d, first, 1.0, own[centre : centre + 3 * size[CENTRELINE]])
    return slope_energy(size, data, own, d, first, 3, 1)[1]
