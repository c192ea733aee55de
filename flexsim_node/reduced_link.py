"""Kernels of a reduced link that plane and space share; see reduction.py for what a reduced link is.

`size` is the link's row of Chain.reduced, `data` Chain.modal, `own` Workspace.modal; coefficients of
functions lie component by component.  In a factorisation the modes are eliminated before the link's end node.
So are the axial tensions T_j, which are unknowns of their own there: with b_j the gradient of an elongation,
K_j b_j b_j^T is what is left of [[., b_j], [b_j^T, -1 / K_j]], and the modes' pivots stay single numbers.
"""

from __future__ import annotations

from .beam import LENGTH, SHEAR_Y, SHEAR_Z, hermite_transpose
from .chain import FIRST
from .kernel import kernel
from .reduced_chain import (
    AXIALS,
    CENTRELINE,
    MODES,
    SHAPE,
    TENSIONS,
    Y_MODES,
    Z_MODES,
    buffer_places,
    column_height,
    constant_places,
    lanes_of,
    row_width,
)
from .weighted_sum import sum_four, sum_six_of_eight, sum_three_of_four


@kernel
def products(gram, n, parts, y, out):
    """out = gram y for `parts` components of n numbers each, a multiple of four; gram (n n,) is symmetric."""
    for k in range(0, parts * n, n):
        for j in range(k, k + n, 4):
            out[j], out[j + 1], out[j + 2], out[j + 3] = 0.0, 0.0, 0.0, 0.0
            sum_four(n, y, k, 1, gram, j - k, n, out, j)


@kernel
def field(size, own, b, parts):
    """Combine the coefficients of d, v and a in the buffers, by the weights there, to those of all of it."""
    n, centre = size[CENTRELINE], buffer_places(size, b)[3]
    weights, out = centre + 15 * n, centre + 9 * n
    for k in range(parts):
        for j in range(0, n, 4):
            at = out + k * n + j
            own[at], own[at + 1], own[at + 2], own[at + 3] = 0.0, 0.0, 0.0, 0.0
            sum_four(9, own, weights + 9 * k, 1, own, centre + j, n, own, at)


@kernel
def slopes(size, data, own, b, j):
    """Write half the gradient of the squared slope that tension j sees to its buffer; returns the elongation.

    The centreline's lateral coefficients are in the buffers.
    """
    places, buffers, n = constant_places(size, b), buffer_places(size, b), size[CENTRELINE]
    at, slope = buffers[3] + n, buffers[5]
    parts = 1 if b == 3 else 2
    gram = data[places[2] + j * n * n : places[2] + (j + 1) * n * n]
    products(gram, n, parts, own[at : at + 2 * n], own[slope : slope + 2 * n])
    total = 0.0
    for k in range(parts * n):
        total += own[at + k] * own[slope + k]
    return 0.5 * total


@kernel
def slope_rate(size, own, b):
    """Rate of that; the centreline's rates are in the buffers too."""
    buffers, n = buffer_places(size, b), size[CENTRELINE]
    at, slope, total = buffers[3] + 4 * n, buffers[5], 0.0
    for k in range(n if b == 3 else 2 * n):
        total += own[at + k] * own[slope + k]
    return total


@kernel
def stretched(d, first, j, b):
    """Elongation j of the nodal rows d without the slopes': of the ends, or that of an axial mode."""
    if j == 0:
        return d[first + 1, 0] - d[first, 0]
    return d[first + 2 + (j - 1) // b, (j - 1) % b]


@kernel
def stiffen(size, data, own, d, v, first, b, still, beta, force):
    """Add what the squared slope does: axial forces to `force`, lateral ones to those on the centreline.

    still is 1 for the forces of the displacements d; beta adds the stiffness at d times v.  The centreline's
    coefficients of d and v are in the buffers.
    """
    places, buffers, n = constant_places(size, b), buffer_places(size, b), size[CENTRELINE]
    g, slope = buffers[3] + 13 * n, buffers[5]
    for j in range(size[TENSIONS]):
        extra = still * slopes(size, data, own, b, j)
        pull = still * stretched(d, first, j, b)
        if beta > 0.0:
            extra += beta * slope_rate(size, own, b)
            pull += beta * stretched(v, first, j, b)
        extra *= data[places[3] + j]
        pull = data[places[3] + j] * pull + extra
        if j == 0:
            force[first, 0] -= extra
            force[first + 1, 0] += extra
        else:
            force[first + 2 + (j - 1) // b, (j - 1) % b] += extra
        for k in range(n if b == 3 else 2 * n):
            own[g + k] += pull * own[slope + k]


@kernel
def slope_energy(size, data, own, d, first, b, longest):
    """What the mean squared slope adds to the strain energy, and the link's mean tension.

    Tensions beyond the first `longest` are left out.  The centreline's coefficients are in the buffers.
    """
    places = constant_places(size, b)
    total = mean = 0.0
    for j in range(min(longest, size[TENSIONS])):
        more, pull = slopes(size, data, own, b, j), stretched(d, first, j, b)
        total += data[places[3] + j] * more * (pull + 0.5 * more)
        if j == 0:
            mean = data[places[3]] * (pull + more)
    return total, mean


@kernel
def elongation(size, data, own, d, v, first, b, piece, pieces):
    """How much a piece of the link is stretched where its tension is the reduced link's, m, and the rate.

    The centreline's coefficients of d and v are in the buffers.
    """
    width = 2 * b + size[MODES]
    total = change = 0.0
    for j in range(size[TENSIONS]):
        long = slopes(size, data, own, b, j) + stretched(d, first, j, b)
        rate = slope_rate(size, own, b) + stretched(v, first, j, b)
        share = 1.0 / pieces
        if j > 0:
            at = size[SHAPE] + piece * b * width + 2 * b + j - 1
            share = data[at + b * width] - data[at]
        total += share * long
        change += share * rate
    return total, change


@kernel
def tension_row(size, data, own, e, b, j, stiffness, w):
    """Fill in the row of tension j and the modes' entries for it; what it stands for leaves the ends' w."""
    buffers, n, lanes = buffer_places(size, b), size[CENTRELINE], lanes_of(b)
    width, axial, bent = row_width(size, b), size[AXIALS], size[AXIALS] + size[Y_MODES]
    rows, slope = buffers[0], buffers[5]
    slopes(size, data, own, b, j)
    q = own[slope : slope + 2 * n]
    at = rows + (size[MODES] + j) * width
    for k in range(width):
        own[at + k] = 0.0
    own[at + 3 * lanes + j] = -1.0 / stiffness
    w1, t1, w2, t2 = hermite_transpose(q[0], q[1], q[2], q[3], e[LENGTH], e[SHEAR_Z])
    own[at + 1], own[at + b - 1], own[at + lanes + 1], own[at + lanes + b - 1] = w2, t2, w1, t1
    for i in range(axial, bent):
        own[rows + i * width + 3 * lanes + j] = q[4 + i]
    if b == 6:
        w1, t1, w2, t2 = hermite_transpose(q[n], q[n + 1], q[n + 2], q[n + 3], e[LENGTH], e[SHEAR_Y])
        own[at + 2], own[at + 4], own[at + lanes + 2], own[at + lanes + 4] = w2, -t2, w1, -t1
        for i in range(bent, bent + size[Z_MODES]):
            own[rows + i * width + 3 * lanes + j] = q[n + 4 + i]
    if j == 0:
        own[at], own[at + lanes] = 1.0, -1.0
        w[0, 0] -= stiffness
        w[b, b] -= stiffness
        w[0, b] += stiffness


@kernel
def mode_rows(size, data, own, b, scale):
    """Fill in what is constant of the modes' rows, unless it is there: over (end, start), inverse pivots.

    What the axial tensions stand for has left the pivots; where one is not positive its inverse is -1.
    """
    places, buffers = constant_places(size, b), buffer_places(size, b)
    modes, tensions = size[MODES], size[TENSIONS] if scale > 0.0 else 0
    lanes, width, height = lanes_of(b), row_width(size, b), column_height(size)
    if own[buffers[2]] > 0.0 and own[buffers[2] + 1] == scale:
        return
    own[buffers[2]], own[buffers[2] + 1] = 1 + tensions, scale
    for i in range(modes):
        row, at = buffers[0] + i * width, places[6] + 2 * b * i
        for k in range(b):
            own[row + k] = data[at + k]
            own[row + lanes + k] = data[at + b + k]
        for k in range(tensions):
            own[row + 3 * lanes + k] = 0.0
        pivot = data[places[4] + i] + scale * data[places[5] + i]
        if i < tensions - 1:
            pivot -= scale * data[places[3] + i + 1]
            own[row + 3 * lanes + i + 1] = 1.0
        inverse = 1.0 / pivot if pivot > 0.0 else -1.0
        own[row + width - 1] = inverse
        for k in range(2 * b):
            own[buffers[6] + k * height + i] = -inverse * data[at + k]


@kernel
def add_lanes(b, n, x, at, rows, first, width, out, place):
    """Add sum_i x[at + i] times the rows' b entries from rows[first:] on to out[place:]."""
    if b == 3:
        sum_three_of_four(n, x, at, 1, rows, first, width, out, place)
    else:
        sum_six_of_eight(n, x, at, 1, rows, first, width, out, place)


@kernel
def eliminate_modes(size, own, b, w):
    """Eliminate modes and tensions of a link from the upper triangle of the front w (end, start, A).

    The modes' rows hold their pivot at the end, the tensions' among their entries.  False where a mode's is
    not positive.
    """
    buffers = buffer_places(size, b)
    modes, tensions, lanes = size[MODES], int(own[buffers[2]]) - 1, lanes_of(b)
    width, height, front = row_width(size, b), column_height(size), 3 * lanes
    rows, columns, last = buffers[0], buffers[6], width - 1
    weights = columns + 3 * b * height
    count = modes + tensions
    for i in range(modes):
        if not own[rows + i * width + last] > 0.0:
            return False
    for j in range(tensions):
        r, n = rows + (modes + j) * width, modes + j
        for i in range(n):
            s = rows + i * width
            c = -own[s + front + j] * own[s + last]
            own[weights + i] = c
            for k in range(j, tensions):
                own[r + front + k] += c * own[s + front + k]
        for k in range(0, front, 4):
            sum_four(n, own, weights, 1, own, rows + k, width, own, r + k)
        own[r + last] = 1.0 / own[r + front + j]
    for i in range(count):
        s = rows + i * width
        inverse = -own[s + last]
        for g in range(2 if i < modes else 0, 3):  # a mode's are constant over (end, start)
            for k in range(b):
                own[columns + (g * b + k) * height + i] = inverse * own[s + g * lanes + k]
    for g in range(3):
        for p in range(g * b, g * b + b):
            for k in range(g, 3):
                add_lanes(b, count, own, columns + p * height, own, rows + k * lanes, width, w[p], k * b)
    return True


@kernel
def forward(size, own, unknown, first, b, rhs, out, f):
    """Take a link's modes and tensions out of the load f (end, start, A)."""
    buffers = buffer_places(size, b)
    modes, tensions, lanes = size[MODES], int(own[buffers[2]]) - 1, lanes_of(b)
    width, height, front = row_width(size, b), column_height(size), 3 * lanes
    rows, last = buffers[0], width - 1
    weights = buffers[6] + 3 * b * height
    for i in range(modes):
        at = unknown[first + 2 + i // b, i % b]
        y = rhs[at] * own[rows + i * width + last]
        out[at] = y
        own[weights + i] = -y
    for j in range(tensions):
        r, load = rows + (modes + j) * width, 0.0
        for i in range(modes + j):
            load += own[weights + i] * own[rows + i * width + front + j]
        y = load * own[r + last]
        own[r + front + j] = y  # the place of the tension's own pivot is free
        own[weights + modes + j] = -y
    for g in range(3):
        add_lanes(b, modes + tensions, own, weights, own, rows + g * lanes, width, f, g * b)


@kernel
def backward(size, own, unknown, first, b, end, z, out):
    """Find a link's modes from its end node and z (start node, A)."""
    buffers = buffer_places(size, b)
    modes, tensions, lanes = size[MODES], int(own[buffers[2]]) - 1, lanes_of(b)
    width, height, front = row_width(size, b), column_height(size), 3 * lanes
    rows, columns, at, last = buffers[0], buffers[6], buffers[1], width - 1
    found = columns + 3 * b * height
    for k in range(b):
        own[at + k] = end[k]
        own[at + b + k] = z[k]
        own[at + 2 * b + k] = z[b + k]
    for i in range(0, height, 4):
        own[found + i], own[found + i + 1], own[found + i + 2], own[found + i + 3] = 0.0, 0.0, 0.0, 0.0
        sum_four(3 * b, own, at, 1, own, columns + i, height, own, found + i)
    for j in range(tensions - 1, -1, -1):
        r, total = rows + (modes + j) * width, 0.0
        for k in range(j + 1, tensions):
            total += own[r + front + k] * own[found + modes + k]
        own[found + modes + j] += own[r + front + j] - total * own[r + last]
    for i in range(modes):
        r, total = rows + i * width, 0.0
        for k in range(tensions):
            total += own[r + front + k] * own[found + modes + k]
        out[unknown[first + 2 + i // b, i % b]] += own[found + i] - total * own[r + last]


@kernel
def recover(chain, work, n, node, kind, row):
    """Write node `node` (from 0 at the start) of the reduced link n, displacement or rate, into row (b,)."""
    first, b = chain.link[n, FIRST], len(chain.dofs)
    count = 2 * b + chain.reduced[n, MODES]
    at = chain.reduced[n, SHAPE] + node * b * count
    d = work.node[kind]
    for p in range(b):
        total = 0.0
        for k in range(count):
            total += chain.modal[at + p * count + k] * d[first + k // b, k % b]
        row[p] = total
