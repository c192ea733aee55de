"""Kernels of a reduced link that plane and space share; see reduction.py for what a reduced link is.

`size` is the link's row of Chain.reduced, `data` Chain.modal, `own` Workspace.modal; coefficients of
functions lie component by component.  In a factorisation the modes are eliminated before the link's end node.
So are the axial tensions T_j, which are unknowns of their own there: with b_j the gradient of an elongation,
K_j b_j b_j^T is what is left of [[., b_j], [b_j^T, -1 / K_j]], and the modes' pivots stay single numbers.
"""

from __future__ import annotations

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
    constant_places,
)


@kernel
def two_products(gram, n, y, out):
    """out = gram y for two components of n numbers each; gram (n n,) is symmetric."""
    for i in range(n):
        a = b = 0.0
        for k in range(n):
            w = gram[i * n + k]
            a += w * y[k]
            b += w * y[n + k]
        out[i], out[n + i] = a, b


@kernel
def three_products(gram, n, y, out):
    """The same for three components."""
    for i in range(n):
        a = b = c = 0.0
        for k in range(n):
            w = gram[i * n + k]
            a += w * y[k]
            b += w * y[n + k]
            c += w * y[2 * n + k]
        out[i], out[n + i], out[2 * n + i] = a, b, c


@kernel
def slope_product(gram, n, y, at, start, out):
    """out (n,) = gram y for functions 0..3 of the component y[at:] and those past `start`; returns y out."""
    total = 0.0
    for i in range(n):
        value = 0.0
        for k in range(4):
            value += gram[i * n + k] * y[at + k]
        for k in range(4, n):
            value += gram[i * n + k] * y[at + start + k]
        out[i] = value
        total += value * (y[at + i] if i < 4 else y[at + start + i])
    return total


@kernel
def rate_of(n, q, y, at, start):
    """q (n,) times the functions 0..3 of the component y[at:] and those from `start` on."""
    total = 0.0
    for i in range(4):
        total += q[i] * y[at + i]
    for i in range(4, n):
        total += q[i] * y[at + start + i]
    return total


@kernel
def pull_slopes(n, tension, q, g, at, start):
    """Add tension times q (n,) to the forces g[at:] on the functions 0..3 and those from `start` on."""
    for i in range(4):
        g[at + i] += tension * q[i]
    for i in range(4, n):
        g[at + start + i] += tension * q[i]


@kernel
def stiffen(size, data, own, d, v, first, b, still, beta, force):
    """Add what the squared slope does: axial forces to `force`, lateral ones to those on the centreline.

    still is 1 for the forces of the displacements d; beta adds the stiffness at d times v.  The centreline's
    coefficients of d and v are in the buffers.
    """
    places, buffers = constant_places(size, b), buffer_places(size, b)
    axial, n, m = size[AXIALS], 4 + size[Y_MODES], 4 + size[Z_MODES]
    count = size[CENTRELINE]
    centre, slope = buffers[3], buffers[5]
    c, cv = own[centre : centre + 3 * count], own[centre + 3 * count : centre + 6 * count]
    g = own[centre + 9 * count : centre + 12 * count]
    p, r = first, first + 1
    after = axial + size[Y_MODES]
    for j in range(size[TENSIONS]):
        qy, qz = own[slope : slope + n], own[slope + n : slope + n + m]
        gram = data[places[2] + j * n * n : places[2] + (j + 1) * n * n]
        extra = 0.5 * slope_product(gram, n, c, count, axial, qy)
        i, k = first + 2 + (j - 1) // b, (j - 1) % b
        pull = d[r, 0] - d[p, 0] if j == 0 else d[i, k]
        rate = 0.0
        if beta > 0.0:
            rate = rate_of(n, qy, cv, count, axial)
        if b == 6:
            gram = data[places[3] + j * m * m : places[3] + (j + 1) * m * m]
            extra += 0.5 * slope_product(gram, m, c, 2 * count, after, qz)
            if beta > 0.0:
                rate += rate_of(m, qz, cv, 2 * count, after)
        extra *= still
        pull *= still
        if beta > 0.0:
            extra += beta * rate
            pull += beta * (v[r, 0] - v[p, 0] if j == 0 else v[i, k])
        extra *= data[places[4] + j]
        pull = data[places[4] + j] * pull + extra
        if j == 0:
            force[p, 0] -= extra
            force[r, 0] += extra
        else:
            force[i, k] += extra
        pull_slopes(n, pull, qy, g, count, axial)
        if b == 6:
            pull_slopes(m, pull, qz, g, 2 * count, after)


@kernel
def slope_energy(size, data, own, d, first, b, longest):
    """What the mean squared slope adds to the strain energy, and the link's mean tension.

    Tensions beyond the first `longest` are left out.  The centreline's coefficients are in the buffers.
    """
    places, buffers = constant_places(size, b), buffer_places(size, b)
    axial, n, m = size[AXIALS], 4 + size[Y_MODES], 4 + size[Z_MODES]
    count = size[CENTRELINE]
    centre, slope = buffers[3], buffers[5]
    c = own[centre : centre + 3 * count]
    qy, qz = own[slope : slope + n], own[slope + n : slope + n + m]
    total = mean = 0.0
    for j in range(min(longest, size[TENSIONS])):
        gram = data[places[2] + j * n * n : places[2] + (j + 1) * n * n]
        more = 0.5 * slope_product(gram, n, c, count, axial, qy)
        if b == 6:
            gram = data[places[3] + j * m * m : places[3] + (j + 1) * m * m]
            more += 0.5 * slope_product(gram, m, c, 2 * count, axial + size[Y_MODES], qz)
        i, k = first + 2 + (j - 1) // b, (j - 1) % b
        pull = d[first + 1, 0] - d[first, 0] if j == 0 else d[i, k]
        total += data[places[4] + j] * more * (pull + 0.5 * more)
        if j == 0:
            mean = data[places[4]] * (pull + more)
    return total, mean


@kernel
def elongation(size, data, own, d, v, first, b, piece, pieces):
    """How much a piece of the link is stretched where its tension is the reduced link's, m, and the rate.

    The centreline's coefficients of d and v are in the buffers.
    """
    places, buffers = constant_places(size, b), buffer_places(size, b)
    axial, n, m, count = size[AXIALS], 4 + size[Y_MODES], 4 + size[Z_MODES], size[CENTRELINE]
    centre, slope, after = buffers[3], buffers[5], axial + size[Y_MODES]
    c, cv = own[centre : centre + 3 * count], own[centre + 3 * count : centre + 6 * count]
    qy, qz = own[slope : slope + n], own[slope + n : slope + n + m]
    width = 2 * b + size[MODES]
    total = change = 0.0
    for j in range(size[TENSIONS]):
        gram = data[places[2] + j * n * n : places[2] + (j + 1) * n * n]
        long = 0.5 * slope_product(gram, n, c, count, axial, qy)
        rate = rate_of(n, qy, cv, count, axial)
        if b == 6:
            gram = data[places[3] + j * m * m : places[3] + (j + 1) * m * m]
            long += 0.5 * slope_product(gram, m, c, 2 * count, after, qz)
            rate += rate_of(m, qz, cv, 2 * count, after)
        if j == 0:
            long += d[first + 1, 0] - d[first, 0]
            rate += v[first + 1, 0] - v[first, 0]
            share = 1.0 / pieces
        else:
            i, k = first + 2 + (j - 1) // b, (j - 1) % b
            long += d[i, k]
            rate += v[i, k]
            at = size[SHAPE] + piece * b * width + 2 * b + j - 1
            share = data[at + b * width] - data[at]
        total += share * long
        change += share * rate
    return total, change


@kernel
def mode_rows(size, data, own, b, scale):
    """Fill in the modes' rows over (end, start), the tensions' columns, the pivots; those of A are there."""
    places, buffers = constant_places(size, b), buffer_places(size, b)
    modes, tensions = size[MODES], size[TENSIONS] if scale > 0.0 else 0
    width = 3 * b + size[TENSIONS] + 1
    own[buffers[2]] = tensions
    for i in range(modes):
        row = own[buffers[0] + i * width : buffers[0] + (i + 1) * width]
        for k in range(2 * b):
            row[k] = data[places[7] + 2 * b * i + k]
        for k in range(tensions):
            row[3 * b + k] = 0.0
        row[width - 1] = data[places[5] + i] + scale * data[places[6] + i]


@kernel
def eliminate_modes(size, own, b, w):
    """Eliminate modes and tensions of a link from the upper triangle of the front w (end, start, A).

    The modes' rows hold their pivot at the end, the tensions' among their entries.  False where a mode's is
    not positive.
    """
    buffers = buffer_places(size, b)
    modes, tensions, length = size[MODES], int(own[buffers[2]]), 3 * b
    width = length + size[TENSIONS] + 1
    rows = own[buffers[0] : buffers[1]]
    last = width - 1
    for i in range(modes):
        if not rows[i * width + last] > 0.0:
            return False
        rows[i * width + last] = 1.0 / rows[i * width + last]
    for j in range(tensions):
        r = rows[(modes + j) * width : (modes + j + 1) * width]
        for i in range(modes + j):
            s = rows[i * width : (i + 1) * width]
            c = s[length + j] * s[last]
            if c != 0.0:
                for k in range(length + tensions):
                    r[k] -= c * s[k]
        r[last] = 1.0 / r[length + j]
    for p in range(length):
        for i in range(modes + tensions):
            s = rows[i * width : (i + 1) * width]
            c = s[p] * s[last]
            if c != 0.0:
                for k in range(p, length):
                    w[p, k] -= c * s[k]
    return True


@kernel
def forward(size, own, unknown, first, b, rhs, out, f):
    """Take a link's modes and tensions out of the load f (end, start, A)."""
    buffers = buffer_places(size, b)
    modes, tensions, length = size[MODES], int(own[buffers[2]]), 3 * b
    width = length + size[TENSIONS] + 1
    g = own[buffers[1] : buffers[2]]
    for k in range(length):
        g[k] = f[k]
    for k in range(length, length + tensions):
        g[k] = 0.0
    for i in range(modes + tensions):
        row = own[buffers[0] + i * width : buffers[0] + (i + 1) * width]
        if i < modes:
            at = unknown[first + 2 + i // b, i % b]
            y = rhs[at] * row[width - 1]
            out[at] = y
            start = length
        else:
            start = length + i - modes
            y = g[start] * row[width - 1]
            row[start] = y  # the place of the tension's own pivot is free
            start += 1
        for k in range(length):
            g[k] -= row[k] * y
        for k in range(start, length + tensions):
            g[k] -= row[k] * y
    for k in range(length):
        f[k] = g[k]


@kernel
def backward(size, own, unknown, first, b, end, z, out):
    """Find a link's modes from its end node and z (start node, A)."""
    buffers = buffer_places(size, b)
    modes, tensions, length = size[MODES], int(own[buffers[2]]), 3 * b
    width = length + size[TENSIONS] + 1
    g = own[buffers[1] : buffers[2]]
    for k in range(b):
        g[k] = end[k]
        g[b + k] = z[k]
        g[2 * b + k] = z[b + k]
    for j in range(tensions - 1, -1, -1):
        row = own[buffers[0] + (modes + j) * width : buffers[0] + (modes + j + 1) * width]
        total = 0.0
        for k in range(length):
            total += row[k] * g[k]
        for k in range(length + j + 1, length + tensions):
            total += row[k] * g[k]
        g[length + j] = row[length + j] - total * row[width - 1]
    for i in range(modes):
        row = own[buffers[0] + i * width : buffers[0] + (i + 1) * width]
        at = unknown[first + 2 + i // b, i % b]
        total = 0.0
        for k in range(length + tensions):
            total += row[k] * g[k]
        out[at] -= total * row[width - 1]


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
