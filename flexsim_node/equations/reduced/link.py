"""Kernels of a reduced link that plane and space share; see reduction.py for what a reduced link is.

`size` is the link's row of Chain.reduced, `data` Chain.modal, `own` Workspace.modal; coefficients of
functions lie component by component.  In a factorisation the modes are eliminated before the link's end node.
So are the axial tensions T_j, which are unknowns of their own there: with b_j the gradient of an elongation,
K_j b_j b_j^T is what is left of [[., b_j], [b_j^T, -1 / K_j]], and the modes' pivots stay single numbers.
What the modes leave of the link's two ends then depends on the step alone, not on where the robot is.
"""

from __future__ import annotations

from ...compiled.flat import flat
from ...compiled.kernel import kernel
from ...compiled.lanes import broadcast, load, multiply_add, total
from ...compiled.weighted_sum import (
    add_combined,
    add_lanes_thrice,
    add_last_planar_rows,
    add_last_rows,
    add_later_planar_rows,
    add_later_rows,
    add_planar_row_pair,
    add_row_pair,
    add_six,
    add_twelve,
    add_twelve_thrice,
    add_whole_planar_rows,
    add_whole_rows,
    combine,
    dot,
    mix,
)
from ...elements.beam import LENGTH, SHEAR_Y, SHEAR_Z, hermite_transpose
from ...model.chain import FIRST
from ...model.reduced.layout import (
    ACTIVE,
    AXIALS,
    CENTRELINE,
    COLUMN,
    COUPLING,
    ENDS,
    FRONT,
    GRADIENT,
    HEIGHT,
    INVERSE,
    LATERAL,
    LATERAL_Y,
    LATERAL_Z,
    LINE,
    LOADS,
    MIX,
    MODAL_MASS,
    MODAL_STIFFNESS,
    MODES,
    PIVOTS,
    SCALED,
    SHAPE,
    SLOPE_Y,
    SLOPE_Z,
    TENSION,
    TENSIONS,
    WEIGHT,
    WIDTH,
    WOUND,
    Y_MODES,
    Z_MODES,
)
from .turning import add_wound_forces, fours, wound_elongation, wound_gradient, write_twists


@kernel
def products(parts, data, gram, n, own, y, out):
    """own[out:] = gram own[y:] for 1 to 3 components of n numbers each, a multiple of four.

    gram (n n,) is symmetric, and starts at data[gram].
    """
    if parts == 1:
        combine(n, own, y, data, gram, n, own, out, n)
    else:
        mix(parts, n, own, y, data, gram, n, own, out)


@kernel
def middle_forces(e, shear, g1):
    """Forces on the nodal (w, t) of start and end of a moment g1 on the middle section's rotation."""
    w = 1.5 * (1.0 - shear) * g1 / e[LENGTH]
    t = -(0.25 - 0.75 * shear) * g1
    return -w, t, w, t


@kernel
def slopes(size, data, own, b):
    """Write half the gradients of the squared slopes that the tensions see.

    The centreline's coefficients are in the buffers.
    """
    n, c, wide, high = size[CENTRELINE], size[LINE], size[LATERAL_Y], size[LATERAL_Z]
    tensions, y = size[TENSIONS], size[Y_MODES]
    if tensions == 0:
        return
    at, columns = size[GRADIENT], tensions * wide
    combine(4 + y, own, c + n, data, size[SLOPE_Y], columns, own, at, columns)
    if b == 6:
        at, columns = at + columns, tensions * high
        combine(4 + size[Z_MODES], own, c + 2 * n + y, data, size[SLOPE_Z], columns, own, at, columns)


@kernel
def weigh(size, own, b, displacement, rate):
    """Write the lateral coefficients, weights times displacement and rate, that `along` takes.

    Rates without a weight are not looked at.
    """
    n, c, u, r = size[CENTRELINE], size[LINE], size[LATERAL], size[MIX]
    wide, apart, count = size[LATERAL_Y], (2 if b == 3 else 3) * n, 1 if rate == 0.0 else 2
    own[r], own[r + 1] = displacement, rate
    combine(count, own, r, own, c + n, apart, own, u, wide)
    if b == 6:
        combine(count, own, r, own, c + 2 * n + size[Y_MODES], apart, own, u + wide, size[LATERAL_Z])


@kernel
def along(size, own, b, j):
    """Half the gradient of slope j times the coefficients that `weigh` has written."""
    wide, high, u, s = size[LATERAL_Y], size[LATERAL_Z], size[LATERAL], size[GRADIENT]
    found = broadcast(0.0)
    for k in range(0, wide, 4):
        found = multiply_add(load(own, u + k), load(own, s + j * wide + k), found)
    if b == 6:
        u, s = u + wide, s + size[TENSIONS] * wide + j * high
        for k in range(0, high, 4):
            found = multiply_add(load(own, u + k), load(own, s + k), found)
    return total(found)


@kernel
def stretched(d, first, j, b):
    """Elongation j of the nodal rows d (flat) without the slopes': of the ends, or that of an axial mode."""
    if j == 0:
        return d[b * first + b] - d[b * first]
    return d[b * (first + 2) + j - 1]


@kernel
def twists(size, own, d, v, first):
    """Write the twists of the nodal rows d and their rates, of v, both flat, for `wound_elongation`."""
    count = 1 + size[MODES] - size[AXIALS] - size[Y_MODES] - size[Z_MODES]
    write_twists(size, d, first, own, size[WOUND])
    write_twists(size, v, first, own, size[WOUND] + fours(count))


@kernel
def stiffen(size, data, own, d, v, first, b, still, beta, force):
    """Add what the squared slope does: axial forces to `force`, lateral ones to those on the centreline.

    still is 1 for the forces of the displacements d; beta adds the stiffness at d times v.  d, v, force are
    nodal rows, flat.  Gradients of the slopes and the centreline's coefficients are in the buffers.
    """
    pulls, tensions = size[LOADS], size[TENSIONS]
    weigh(size, own, b, 0.5 * still, beta)
    if b == 6:
        twists(size, own, d, v, first)
    for j in range(tensions):
        extra = along(size, own, b, j)
        if b == 6:
            extra += wound_elongation(size, data, own, j, still, beta)
        pull = still * stretched(d, first, j, b) + beta * stretched(v, first, j, b)
        extra *= data[size[TENSION] + j]
        if j == 0:
            force[b * first] -= extra
            force[b * first + b] += extra
        else:
            force[b * (first + 2) + j - 1] += extra
        own[pulls + j] = data[size[TENSION] + j] * pull + extra
        if b == 6:
            add_wound_forces(size, own, own[pulls + j], force, first)
    n, s, wide, high = size[CENTRELINE], size[GRADIENT], size[LATERAL_Y], size[LATERAL_Z]
    g = size[LINE] + (9 if b == 3 else 13) * n
    add_combined(tensions, own, pulls, own, s, wide, own, g, wide)
    if b == 6:
        add_combined(tensions, own, pulls, own, s + tensions * wide, high, own, g + n + size[Y_MODES], high)


@kernel
def elastic_forces(size, data, own, d, v, first, b, still, beta, force):
    """Add stiffness times (still d + beta v) to `force`, nodal rows, but for what the squared slope does."""
    begin, u = b * first, size[FRONT]
    for k in range(2 * b):
        own[u + k] = still * d[begin + k] + beta * v[begin + k]
    if b == 3:
        add_six(6, own, u, 1, 0, data, size[ENDS], 8, force, begin, 0)
    else:
        add_twelve(12, own, u, 1, 0, data, size[ENDS], 12, force, begin, 0)
    begin += 2 * b
    for i in range(size[MODES]):
        force[begin + i] += data[size[MODAL_STIFFNESS] + i] * (still * d[begin + i] + beta * v[begin + i])


@kernel
def slope_energy(size, data, own, d, first, b):
    """What the mean squared slope adds to the strain energy of the placed link, and its mean tension."""
    total = mean = 0.0
    weigh(size, own, b, 0.5, 0.0)
    if b == 6:
        twists(size, own, flat(d), flat(d), first)
    for j in range(size[TENSIONS]):
        more, pull = along(size, own, b, j), stretched(flat(d), first, j, b)
        if b == 6:
            more += wound_elongation(size, data, own, j, 1.0, 0.0)
        total += data[size[TENSION] + j] * more * (pull + 0.5 * more)
        if j == 0:
            mean = data[size[TENSION]] * (pull + more)
    return total, mean


@kernel
def elongation(size, data, own, d, v, first, b, piece, pieces):
    """How much a piece of the link is stretched where its tension is the reduced link's, m, and the rate.

    Gradients of the slopes and the centreline's coefficients are in the buffers.
    """
    width = 2 * b + size[MODES]
    total = change = 0.0
    if b == 6:
        twists(size, own, flat(d), flat(v), first)
    for j in range(size[TENSIONS]):
        weigh(size, own, b, 0.5, 0.0)
        long = along(size, own, b, j) + stretched(flat(d), first, j, b)
        weigh(size, own, b, 0.0, 1.0)
        rate = along(size, own, b, j) + stretched(flat(v), first, j, b)
        if b == 6:
            long += wound_elongation(size, data, own, j, 1.0, 0.0)
            rate += wound_elongation(size, data, own, j, 0.0, 1.0)
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
    width, rows, wide = size[WIDTH], size[PIVOTS], size[LATERAL_Y]
    axial, y, z = size[AXIALS], size[Y_MODES], size[Z_MODES]
    at, slope = rows + (size[MODES] + j) * width, size[GRADIENT] + j * wide
    for k in range(0, width, 4):
        own[at + k], own[at + k + 1], own[at + k + 2], own[at + k + 3] = 0.0, 0.0, 0.0, 0.0
    own[at + 3 * b + j] = -1.0 / stiffness
    entry = rows + axial * width + 3 * b + j
    for i in range(y):
        own[entry + i * width] = own[slope + i]
    slope += y
    w1, t1, w2, t2 = hermite_transpose(
        own[slope], own[slope + 1], own[slope + 2], own[slope + 3], e[LENGTH], e[SHEAR_Z]
    )
    own[at + 1], own[at + b - 1], own[at + b + 1], own[at + 2 * b - 1] = w2, t2, w1, t1
    if b == 6:
        slope = size[GRADIENT] + size[TENSIONS] * wide + j * size[LATERAL_Z]
        entry += y * width
        w1, t1, w2, t2 = hermite_transpose(
            own[slope], own[slope + 1], own[slope + 2], own[slope + 3], e[LENGTH], e[SHEAR_Y]
        )
        own[at + 2], own[at + 4], own[at + 8], own[at + 10] = w2, -t2, w1, -t1
        for i in range(z):
            own[entry + i * width] = own[slope + 4 + i]
        count = 1 + size[MODES] - axial - y - z
        wound_gradient(size, data, own, count, j)
        wound, entry = size[WOUND] + 2 * fours(count), entry + z * width
        own[at + 3], own[at + 9] = 0.5 * own[wound], -0.5 * own[wound]
        for i in range(count - 1):
            own[entry + i * width] = own[wound + 1 + i]
    if j == 0:
        own[at], own[at + b] = 1.0, -1.0


@kernel
def choose_matrix(size, data, own, b, scale, heavier, w):
    """Fill in what is constant of the modes' rows, and take it out of the matrix w (2b, 2b) of (end, start).

    What the axial tensions stand for leaves w and the pivots too.  Modes are orthogonal in mass and in
    stiffness and there is no stiffness between them and the ends: heavier M_i + scale K_i is a mode's pivot.
    """
    tensions = size[TENSIONS] if scale > 0.0 else 0
    width, height = size[WIDTH], size[HEIGHT]
    own[size[ACTIVE]] = tensions
    for i in range(size[MODES]):
        row, at = size[PIVOTS] + i * width, size[COUPLING] + 2 * b * i
        for k in range(width):
            own[row + k] = 0.0
        for k in range(2 * b):
            own[row + k] = heavier * data[at + k]
        pivot = heavier * data[size[MODAL_MASS] + i] + scale * data[size[MODAL_STIFFNESS] + i]
        if i < tensions - 1:
            pivot -= scale * data[size[TENSION] + i + 1]
            own[row + 3 * b + i + 1] = 1.0
        inverse = 1.0 / pivot
        own[size[INVERSE] + i] = inverse
        for k in range(2 * b):
            own[size[COLUMN] + k * height + i] = -inverse * own[row + k]
            for p in range(2 * b):
                w[k, p] -= inverse * own[row + k] * own[row + p]
    if tensions > 0:
        stiffness = scale * data[size[TENSION]]
        w[0, 0] -= stiffness
        w[b, b] -= stiffness
        w[0, b] += stiffness
        w[b, 0] += stiffness


@kernel
def add_pair(size, own, b, front, first, count, row):
    """Eliminate like modes from rows `row` of end and start, over A; the modes couple with them alike."""
    a, width, height = size[PIVOTS] + first * size[WIDTH] + 2 * b, size[WIDTH], size[HEIGHT]
    at, place = size[COLUMN] + row * height + first, 3 * b * row + 2 * b
    if b == 3:
        add_planar_row_pair(count, own, at, 1, 3 * height, own, a, width, front, place, 27)
    else:
        add_row_pair(count, own, at, 1, 6 * height, own, a, width, front, place, 108)


@kernel
def eliminate_modes(size, own, b, front):
    """Eliminate modes and tensions of a link from the upper triangle of the front (end, start, A)."""
    modes, tensions = size[MODES], int(own[size[ACTIVE]])
    width, height, entry = size[WIDTH], size[HEIGHT], 3 * b
    rows, columns, inverses, scaled = size[PIVOTS], size[COLUMN], size[INVERSE], size[SCALED]
    w = flat(front)
    for i in range(modes):
        row, inverse = rows + i * width, own[inverses + i]
        for k in range(2 * b, entry + tensions):
            own[columns + k * height + i] = -inverse * own[row + k]
    last, after = rows + modes * width, columns + entry * height
    together = 0
    if tensions >= 3 and b == 3 and width == 12:
        add_twelve_thrice(modes, own, after, 1, height, own, rows, width, own, last, width)
        together = 3
    elif tensions >= 3 and b == 6 and width == 24:
        add_lanes_thrice(modes, own, after, 1, height, own, rows, width, own, last, width)
        together = 3
    for j in range(together, tensions):
        add_combined(modes, own, after + j * height, own, rows, width, own, last + j * width, width)
    for j in range(tensions):
        row, made = last + j * width, scaled + j * width
        inverse = 1.0 / own[row + entry + j]
        own[inverses + modes + j] = inverse
        for k in range(0, width, 4):
            own[made + k], own[made + k + 1] = -inverse * own[row + k], -inverse * own[row + k + 1]
            own[made + k + 2], own[made + k + 3] = -inverse * own[row + k + 2], -inverse * own[row + k + 3]
        for k in range(j + 1, tensions):
            add_combined(1, own, made + entry + k, own, row, width, own, last + k * width, width)
    axial, y, z = size[AXIALS], size[Y_MODES], size[Z_MODES]
    add_pair(size, own, b, w, 0, axial, 0)
    add_pair(size, own, b, w, axial, y, 1)
    add_pair(size, own, b, w, axial, y, b - 1)
    a, at = rows + 2 * b, columns + 2 * b * height
    if b == 3:
        add_last_planar_rows(modes, own, at, 1, height, own, a, width, w, 60, 9)
        if tensions > 0:
            add_whole_planar_rows(tensions, own, scaled, width, 1, own, last, width, w, 0, 9)
            add_later_planar_rows(tensions, own, scaled + 3, width, 1, own, last + 3, width, w, 30, 9)
            add_last_planar_rows(tensions, own, scaled + 6, width, 1, own, last + 6, width, w, 60, 9)
    else:
        add_pair(size, own, b, w, axial + y, z, 2)
        add_pair(size, own, b, w, axial + y, z, 4)
        add_pair(size, own, b, w, axial + y + z, modes - axial - y - z, 3)
        add_last_rows(modes, own, at, 1, height, own, a, width, w, 228, 18)
        if tensions > 0:
            add_whole_rows(tensions, own, scaled, width, 1, own, last, width, w, 0, 18)
            add_later_rows(tensions, own, scaled + 6, width, 1, own, last + 6, width, w, 114, 18)
            add_last_rows(tensions, own, scaled + 12, width, 1, own, last + 12, width, w, 228, 18)


@kernel
def forward(size, own, unknown, first, b, rhs, out, f):
    """Take a link's modes and tensions out of the load f (end, start, A)."""
    modes, tensions = size[MODES], int(own[size[ACTIVE]])
    width, entry, rows, inverses = size[WIDTH], 3 * b, size[PIVOTS], size[INVERSE]
    weights, load, loads = size[WEIGHT], size[FRONT], size[LOADS]
    begin = unknown[first + 2, 0] if modes > 0 else 0
    for i in range(modes):
        y = rhs[begin + i] * own[inverses + i]
        out[begin + i] = y
        own[weights + i] = -y
    combine(modes, own, weights, own, rows, width, own, load, width)
    last = rows + modes * width
    for j in range(tensions):
        total = own[load + entry + j]
        for k in range(j):
            total += own[weights + k] * own[last + k * width + entry + j]
        y = total * own[inverses + modes + j]
        own[loads + j] = y
        own[weights + j] = -y
    add_combined(tensions, own, weights, own, last, width, own, load, width)
    for k in range(entry):
        f[k] += own[load + k]


@kernel
def backward(size, own, unknown, first, b, end, z, out):
    """Find a link's modes from its end node and z (start node, A)."""
    modes, tensions = size[MODES], int(own[size[ACTIVE]])
    width, height, entry = size[WIDTH], size[HEIGHT], 3 * b
    at, found, loads = size[FRONT], size[WEIGHT], size[LOADS]
    begin = unknown[first + 2, 0] if modes > 0 else 0
    for k in range(b):
        own[at + k] = end[k]
        own[at + b + k] = z[k]
        own[at + 2 * b + k] = z[b + k]
    for k in range(entry, width):
        own[at + k] = 0.0
    for j in range(tensions - 1, -1, -1):
        # of the tensions before this one nothing is there yet
        row = size[SCALED] + j * width
        own[at + entry + j] = own[loads + j] + dot(width, own, row, own, at)
    combine(entry + tensions, own, at, own, size[COLUMN], height, own, found, height)
    for i in range(modes):
        out[begin + i] += own[found + i]


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
