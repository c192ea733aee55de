"""Kernels of a reduced link that plane and space share; see reduction.py for what a reduced link is.

`size` is the link's row of Chain.reduced, `data` Chain.modal, `own` Workspace.modal; coefficients of
functions lie component by component.  In a factorisation the modes are eliminated before the link's end node.
So are the axial tensions T_j, which are unknowns of their own there: with b_j the gradient of an elongation,
K_j b_j b_j^T is what is left of [[., b_j], [b_j^T, -1 / K_j]], and the modes' pivots stay single numbers.
What the modes leave of the link's two ends then depends on the step alone, not on where the robot is.
"""

from __future__ import annotations

from .beam import LENGTH, SHEAR_Y, SHEAR_Z, hermite_transpose
from .chain import FIRST
from .flat import flat
from .kernel import kernel
from .reduced_chain import (
    ACTIVE,
    AXIALS,
    CENTRELINE,
    COLUMN,
    COUPLING,
    FRONT,
    GRADIENT,
    HEIGHT,
    LINE,
    MODAL_MASS,
    MODAL_STIFFNESS,
    MODES,
    PIVOTS,
    SHAPE,
    SLOPE_GRAM,
    TENSION,
    TENSIONS,
    WEIGHT,
    WIDTH,
    Y_MODES,
    Z_MODES,
    lanes_of,
)
from .weighted_sum import (
    add_eight,
    add_four,
    add_planar_block,
    add_planar_node,
    add_spatial_block,
    add_spatial_node,
    dot,
    four_once,
    four_thrice,
    four_twice,
)


@kernel
def products(parts, data, gram, n, own, y, out):
    """own[out:] = gram own[y:] for 1 to 3 components of n numbers each, a multiple of four.

    gram (n n,) is symmetric, and starts at data[gram].
    """
    for j in range(0, n, 4):
        if parts == 3:
            four_thrice(n, own, y, 1, n, data, gram + j, n, own, out + j, n)
        elif parts == 2:
            four_twice(n, own, y, 1, n, data, gram + j, n, own, out + j, n)
        else:
            four_once(n, own, y, 1, n, data, gram + j, n, own, out + j, n)


@kernel
def gradient_place(size, b, j):
    """Length of the centreline's lateral coefficients, and where half the gradient of slope j by them is."""
    lateral = size[CENTRELINE] if b == 3 else 2 * size[CENTRELINE]
    return lateral, size[GRADIENT] + j * lateral


@kernel
def slopes(size, data, own, b, j):
    """Write half the gradient of the squared slope that tension j sees to its buffer; returns the elongation.

    The centreline's lateral coefficients are in the buffers.
    """
    n, at = size[CENTRELINE], size[LINE] + size[CENTRELINE]
    gram = size[SLOPE_GRAM] + j * n * n
    lateral, slope = gradient_place(size, b, j)
    products(1 if b == 3 else 2, data, gram, n, own, at, slope)
    return 0.5 * dot(lateral, own, at, own, slope)


@kernel
def slope_rate(size, own, b, j):
    """Rate of that; the centreline's rates are in the buffers too."""
    lateral, slope = gradient_place(size, b, j)
    return dot(lateral, own, size[LINE] + (3 if b == 3 else 4) * size[CENTRELINE], own, slope)


@kernel
def stretched(d, first, j, b):
    """Elongation j of the nodal rows d (flat) without the slopes': of the ends, or that of an axial mode."""
    if j == 0:
        return d[b * first + b] - d[b * first]
    return d[b * (first + 2) + j - 1]


@kernel
def stiffen(size, data, own, d, v, first, b, still, beta, force):
    """Add what the squared slope does: axial forces to `force`, lateral ones to those on the centreline.

    still is 1 for the forces of the displacements d; beta adds the stiffness at d times v.  d, v, force are
    nodal rows, flat.  The centreline's coefficients of d and v are in the buffers.
    """
    pulls = size[WEIGHT]
    for j in range(size[TENSIONS]):
        extra = still * slopes(size, data, own, b, j)
        pull = still * stretched(d, first, j, b)
        if beta > 0.0:
            extra += beta * slope_rate(size, own, b, j)
            pull += beta * stretched(v, first, j, b)
        extra *= data[size[TENSION] + j]
        pull = data[size[TENSION] + j] * pull + extra
        if j == 0:
            force[b * first] -= extra
            force[b * first + b] += extra
        else:
            force[b * (first + 2) + j - 1] += extra
        own[pulls + j] = pull
    lateral, slope = gradient_place(size, b, 0)
    g = size[LINE] + (9 if b == 3 else 13) * size[CENTRELINE]
    for k in range(0, lateral, 4):
        add_four(size[TENSIONS], own, pulls, 1, 0, own, slope + k, lateral, own, g + k, 0)


@kernel
def slope_energy(size, data, own, d, first, b, longest):
    """What the mean squared slope adds to the strain energy, and the link's mean tension.

    Tensions beyond the first `longest` are left out.  The centreline's coefficients are in the buffers.
    """
    total = mean = 0.0
    for j in range(min(longest, size[TENSIONS])):
        more, pull = slopes(size, data, own, b, j), stretched(flat(d), first, j, b)
        total += data[size[TENSION] + j] * more * (pull + 0.5 * more)
        if j == 0:
            mean = data[size[TENSION]] * (pull + more)
    return total, mean


@kernel
def elongation(size, data, own, d, v, first, b, piece, pieces):
    """How much a piece of the link is stretched where its tension is the reduced link's, m, and the rate.

    The centreline's coefficients of d and v are in the buffers.
    """
    width = 2 * b + size[MODES]
    total = change = 0.0
    for j in range(size[TENSIONS]):
        long = slopes(size, data, own, b, j) + stretched(flat(d), first, j, b)
        rate = slope_rate(size, own, b, j) + stretched(flat(v), first, j, b)
        share = 1.0 / pieces
        if j > 0:
            at = size[SHAPE] + piece * b * width + 2 * b + j - 1
            share = data[at + b * width] - data[at]
        total += share * long
        change += share * rate
    return total, change


@kernel
def tension_row(size, data, own, e, b, j, stiffness):
    """Fill in the row of tension j and the modes' entries for it."""
    n, lanes, width = size[CENTRELINE], lanes_of(b), size[WIDTH]
    _, slope = gradient_place(size, b, j)
    axial, bent = size[AXIALS], size[AXIALS] + size[Y_MODES]
    rows = size[PIVOTS]
    slopes(size, data, own, b, j)
    at = rows + (size[MODES] + j) * width
    for k in range(0, width - 1, 4):
        own[at + k], own[at + k + 1], own[at + k + 2], own[at + k + 3] = 0.0, 0.0, 0.0, 0.0
    own[at + 3 * lanes + j] = -1.0 / stiffness
    w1, t1, w2, t2 = hermite_transpose(
        own[slope], own[slope + 1], own[slope + 2], own[slope + 3], e[LENGTH], e[SHEAR_Z]
    )
    own[at + 1], own[at + b - 1], own[at + lanes + 1], own[at + lanes + b - 1] = w2, t2, w1, t1
    entry = rows + 3 * lanes + j
    for i in range(axial, bent):
        own[entry + i * width] = own[slope + 4 + i]
    if b == 6:
        slope += n
        w1, t1, w2, t2 = hermite_transpose(
            own[slope], own[slope + 1], own[slope + 2], own[slope + 3], e[LENGTH], e[SHEAR_Y]
        )
        own[at + 2], own[at + 4], own[at + lanes + 2], own[at + lanes + 4] = w2, -t2, w1, -t1
        for i in range(bent, bent + size[Z_MODES]):
            own[entry + i * width] = own[slope + 4 + i]
    if j == 0:
        own[at], own[at + lanes] = 1.0, -1.0


@kernel
def choose_matrix(size, data, own, b, scale, w):
    """Fill in what is constant of the modes' rows, and take it out of the matrix w (2b, 2b) of (end, start).

    What the axial tensions stand for leaves w and the pivots too.  Modes are orthogonal in mass and in
    stiffness and there is no stiffness between them and the ends: M_i + scale K_i is a mode's pivot.
    """
    tensions = size[TENSIONS] if scale > 0.0 else 0
    lanes, width, height = lanes_of(b), size[WIDTH], size[HEIGHT]
    own[size[ACTIVE]] = tensions
    for i in range(size[MODES]):
        row, at = size[PIVOTS] + i * width, size[COUPLING] + 2 * b * i
        for k in range(width):
            own[row + k] = 0.0
        for k in range(b):
            own[row + k] = data[at + k]
            own[row + lanes + k] = data[at + b + k]
        pivot = data[size[MODAL_MASS] + i] + scale * data[size[MODAL_STIFFNESS] + i]
        if i < tensions - 1:
            pivot -= scale * data[size[TENSION] + i + 1]
            own[row + 3 * lanes + i + 1] = 1.0
        inverse = 1.0 / pivot
        own[row + width - 1] = inverse
        for k in range(2 * b):
            own[size[COLUMN] + k * height + i] = -inverse * data[at + k]
            for p in range(2 * b):
                w[k, p] -= inverse * data[at + k] * data[at + p]
    if tensions > 0:
        stiffness = scale * data[size[TENSION]]
        w[0, 0] -= stiffness
        w[b, b] -= stiffness
        w[0, b] += stiffness
        w[b, 0] += stiffness


@kernel
def add_block(b, n, x, at, apart, rows, first, width, out, place):
    """Add sum_i x[at + i + p apart] times the rows' b entries from rows[first:] to b rows p of the front."""
    if b == 3:
        add_planar_block(n, x, at, 1, apart, rows, first, width, out, place, 9)
    else:
        add_spatial_block(n, x, at, 1, apart, rows, first, width, out, place, 18)


@kernel
def eliminate_modes(size, own, b, front):
    """Eliminate modes and tensions of a link from the upper triangle of the front (end, start, A).

    The modes' rows hold their pivot at the end, the tensions' among their entries.
    """
    modes, tensions, lanes = size[MODES], int(own[size[ACTIVE]]), lanes_of(b)
    width, height, entry = size[WIDTH], size[HEIGHT], 3 * lanes
    rows, columns, last, weights = size[PIVOTS], size[COLUMN], size[WIDTH] - 1, size[WEIGHT]
    w = flat(front)
    for j in range(tensions):
        r, n = rows + (modes + j) * width, modes + j
        for i in range(n):
            s = rows + i * width
            own[weights + i] = -own[s + entry + j] * own[s + last]
        if b == 6:
            for k in range(0, entry, 8):
                add_eight(n, own, weights, 1, 0, own, rows + k, width, own, r + k, 0)
        for k in range(0 if b == 3 else entry, width - 1, 4):
            add_four(n, own, weights, 1, 0, own, rows + k, width, own, r + k, 0)
        inverse = 1.0 / own[r + entry + j]
        own[r + last] = inverse
        for g in range(3):
            for k in range(b):
                own[columns + (g * b + k) * height + modes + j] = -inverse * own[r + g * lanes + k]
    for i in range(modes):
        s = rows + i * width
        inverse = own[s + last]
        for k in range(b):
            own[columns + (2 * b + k) * height + i] = -inverse * own[s + 2 * lanes + k]
    if tensions > 0:
        own_columns, own_rows = columns + modes, rows + modes * width
        start, below = columns + modes + b * height, 3 * b * b + b
        add_block(b, tensions, own, own_columns, height, own, own_rows, width, w, 0)
        add_block(b, tensions, own, own_columns, height, own, own_rows + lanes, width, w, b)
        add_block(b, tensions, own, start, height, own, own_rows + lanes, width, w, below)
    for g in range(3):
        at, place = columns + g * b * height, 3 * b * b * g + 2 * b
        add_block(b, modes + tensions, own, at, height, own, rows + 2 * lanes, width, w, place)


@kernel
def forward(size, own, unknown, first, b, rhs, out, f):
    """Take a link's modes and tensions out of the load f (end, start, A)."""
    modes, tensions, lanes = size[MODES], int(own[size[ACTIVE]]), lanes_of(b)
    width, entry, rows, last, weights = size[WIDTH], 3 * lanes, size[PIVOTS], size[WIDTH] - 1, size[WEIGHT]
    index, begin = flat(unknown), b * (first + 2)
    for i in range(modes):
        at = index[begin + i]
        y = rhs[at] * own[rows + i * width + last]
        out[at] = y
        own[weights + i] = -y
    for j in range(tensions):
        r, load = rows + (modes + j) * width, 0.0
        for i in range(modes + j):
            load += own[weights + i] * own[rows + i * width + entry + j]
        y = load * own[r + last]
        own[r + entry + j] = y  # the place of the tension's own pivot is free
        own[weights + modes + j] = -y
    for g in range(3):
        if b == 3:
            add_planar_node(modes + tensions, own, weights, 1, 0, own, rows + g * lanes, width, f, g * b, 0)
        else:
            add_spatial_node(modes + tensions, own, weights, 1, 0, own, rows + g * lanes, width, f, g * b, 0)


@kernel
def backward(size, own, unknown, first, b, end, z, out):
    """Find a link's modes from its end node and z (start node, A)."""
    modes, tensions, lanes = size[MODES], int(own[size[ACTIVE]]), lanes_of(b)
    width, height, entry = size[WIDTH], size[HEIGHT], 3 * lanes
    rows, last, at, found = size[PIVOTS], size[WIDTH] - 1, size[FRONT], size[WEIGHT]
    index, begin = flat(unknown), b * (first + 2)
    for k in range(b):
        own[at + k] = end[k]
        own[at + b + k] = z[k]
        own[at + 2 * b + k] = z[b + k]
    for i in range(0, height, 4):
        four_once(3 * b, own, at, 1, 0, own, size[COLUMN] + i, height, own, found + i, 0)
    for j in range(tensions - 1, -1, -1):
        r, total = rows + (modes + j) * width, 0.0
        for k in range(j + 1, tensions):
            total += own[r + entry + k] * own[found + modes + k]
        own[found + modes + j] += own[r + entry + j] - total * own[r + last]
    for i in range(modes):
        r, total = rows + i * width, 0.0
        for k in range(tensions):
            total += own[r + entry + k] * own[found + modes + k]
        out[index[begin + i]] += own[found + i] - total * own[r + last]


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
