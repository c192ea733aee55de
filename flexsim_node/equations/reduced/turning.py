"""Moments, torque and shear of a reduced link in space turn with it: forces of its strains to second order.

A strain is q_k + sum_ab G_kab x_a y_b of the link's twists and slopes (turning_products.py), with the energy
K_k strain^2 / 2.  size, data, own as in link.py; e is the row of the link as one element.
"""

from __future__ import annotations

from ...compiled.kernel import kernel
from ...compiled.lanes import broadcast, load, multiply, multiply_add, store, total
from ...compiled.weighted_sum import add_combined, combine, mix
from ...elements.beam import LENGTH
from ...model.reduced.layout import (
    AXIALS,
    BACK_Y,
    BACK_Z,
    BENT,
    CROSS_Y,
    CROSS_Z,
    HELICES,
    MODES,
    STRAINS,
    TENSIONS,
    WOUND,
    Y_MODES,
    Z_MODES,
)


@kernel
def counts(size):
    """Numbers of twists and of slopes in y and in z."""
    y, z = 3 + size[Y_MODES], 3 + size[Z_MODES]
    return 2 + size[MODES] - size[AXIALS] - size[Y_MODES] - size[Z_MODES], y, z


@kernel
def stretches(size):
    """Where twists and slopes in y and in z are, each with their rates behind, and the forces on them."""
    twists, y, z = counts(size)
    at = size[BENT]
    at_y = at + fours(2 * twists)
    at_z = at_y + fours(2 * y)
    out = at_z + fours(2 * z)
    out_y = out + fours(twists)
    out_z = out_y + fours(y + 3)
    return at, at_y, at_z, out, out_y, out_z, out_z + fours(z + 3)


@kernel
def fours(n):
    """The next multiple of four."""
    return (n + 3) // 4 * 4


@kernel
def write_slopes(size, e, rows, first, own, at, at_y, at_z):
    """Write twists and slopes in y and in z of nodal rows, flat."""
    p, r, m = 6 * first, 6 * first + 6, 6 * first + 12 + size[AXIALS]
    twists, y, z = counts(size)
    own[at], own[at + 1] = 0.5 * (rows[p + 3] + rows[r + 3]), 0.5 * (rows[r + 3] - rows[p + 3])
    for k in range(2, twists):
        own[at + k] = rows[m + y + z - 8 + k]
    mean = 0.5 * (rows[p + 5] + rows[r + 5])
    own[at_y], own[at_y + 1] = mean, rows[r + 5] - rows[p + 5]
    own[at_y + 2] = (rows[r + 1] - rows[p + 1]) / e[LENGTH] - mean
    for k in range(3, y):
        own[at_y + k] = rows[m + k - 3]
    mean = -0.5 * (rows[p + 4] + rows[r + 4])
    own[at_z], own[at_z + 1] = mean, rows[p + 4] - rows[r + 4]
    own[at_z + 2] = (rows[r + 2] - rows[p + 2]) / e[LENGTH] - mean
    for k in range(3, z):
        own[at_z + k] = rows[m + y + k - 6]


@kernel
def add_slope_forces(size, e, own, at, at_y, at_z, force, first):
    """Add the forces on twists and slopes to those on the nodal rows, flat."""
    p, r, m = 6 * first, 6 * first + 6, 6 * first + 12 + size[AXIALS]
    twists, y, z = counts(size)
    force[p + 3] += 0.5 * (own[at] - own[at + 1])
    force[r + 3] += 0.5 * (own[at] + own[at + 1])
    for k in range(2, twists):
        force[m + y + z - 8 + k] += own[at + k]
    mean, pull = 0.5 * (own[at_y] - own[at_y + 2]), own[at_y + 2] / e[LENGTH]
    force[p + 1] -= pull
    force[r + 1] += pull
    force[p + 5] += mean - own[at_y + 1]
    force[r + 5] += mean + own[at_y + 1]
    for k in range(3, y):
        force[m + k - 3] += own[at_y + k]
    mean, pull = 0.5 * (own[at_z] - own[at_z + 2]), own[at_z + 2] / e[LENGTH]
    force[p + 2] -= pull
    force[r + 2] += pull
    force[p + 4] -= mean - own[at_z + 1]
    force[r + 4] -= mean + own[at_z + 1]
    for k in range(3, z):
        force[m + y + k - 6] += own[at_z + k]


@kernel
def write_twists(size, rows, first, own, at):
    """Write half the difference of the ends' twists, modes that twist, and zeros up to four into own[at:]."""
    p, r, k = 6 * first, 6 * first + 6, size[AXIALS] + size[Y_MODES] + size[Z_MODES]
    count, m = 1 + size[MODES] - k, 6 * first + 12 + k
    own[at] = 0.5 * (rows[r + 3] - rows[p + 3])
    for i in range(1, fours(count)):
        own[at + i] = rows[m + i - 1] if i < count else 0.0


@kernel
def wound_gradient(size, data, own, count, j):
    """Write half the gradient of the squared twists that tension j sees behind the twists and their rates."""
    n, at = fours(count), size[WOUND]
    combine(count, own, at, data, size[HELICES] + j * count * n, n, own, at + 2 * n, n)


@kernel
def wound_elongation(size, data, own, j, still, beta):
    """How much the twist stretches the link in tension j, (T2): still times that, and beta times its rate.

    `write_twists` has written twists and rates into own[WOUND:]; their half gradient follows these.
    """
    count = 1 + size[MODES] - size[AXIALS] - size[Y_MODES] - size[Z_MODES]
    wound_gradient(size, data, own, count, j)
    n, at = fours(count), size[WOUND]
    half, other, found = broadcast(0.5 * still), broadcast(beta), broadcast(0.0)
    for k in range(at, at + n, 4):
        twist = multiply_add(half, load(own, k), multiply(other, load(own, k + n)))
        found = multiply_add(twist, load(own, k + 2 * n), found)
    return total(found)


@kernel
def add_wound_forces(size, own, pull, force, first):
    """Add a pull times the gradient that `wound_elongation` has left to the nodal rows, flat."""
    k = size[AXIALS] + size[Y_MODES] + size[Z_MODES]
    count, m = 1 + size[MODES] - k, 6 * first + 12 + k
    at = size[WOUND] + 2 * fours(count)
    force[6 * first + 3] -= 0.5 * pull * own[at]
    force[6 * first + 9] += 0.5 * pull * own[at]
    for i in range(1, count):
        force[m + i - 1] += pull * own[at + i]


@kernel
def product_counts(size):
    """Numbers of the bending's products with slopes in z, of these with the torsion's, of those in y."""
    twists, y, z = counts(size)
    bending = twists * fours(y - 1)
    return bending, bending + (twists - 1) * fours(y), twists * fours(z - 1)


@kernel
def bending_strains(size, plane):
    """Of the bending strains in y (plane 0) or in z (1): number, place of linear ones, products, stiffness.

    The products are counted from the first; behind those of plane 0 are those of the torsion.
    """
    _, y, z = counts(size)
    _, at_y, at_z, _, _, _, _ = stretches(size)
    if plane == 0:
        return y - 1, at_y + 1, 0, size[STRAINS]
    _, with_z, _ = product_counts(size)
    return z - 1, at_z + 1, with_z, size[STRAINS] + fours(y - 1)


@kernel
def add_turning(size, data, own, e, d, v, first, still, beta, force):
    """Add what the second order does: still times the forces at d, and beta times the stiffness at d times v.

    d, v and force are nodal rows, flat; the linear forces are those of `elastic_forces`.
    """
    if size[TENSIONS] == 0:
        return
    twists, y, z = counts(size)
    at, at_y, at_z, out, out_y, out_z, by = stretches(size)
    write_slopes(size, e, d, first, own, at, at_y, at_z)
    write_slopes(size, e, v, first, own, at + twists, at_y + y, at_z + z)
    # G_kab y_b of the displacements and of the rates, and the weights of G_kab
    torsion, with_z, with_y = product_counts(size)
    weights = by + 2 * (with_z + with_y)
    stress = weights + with_z + with_y
    mix(2, z, own, at_z, data, size[CROSS_Z], with_z, own, by)
    mix(2, y, own, at_y, data, size[CROSS_Y], with_y, own, by + 2 * with_z)
    # twists that go with the products by displacement, and with those by rate
    for a in range(twists):
        own[stress + a] = still * own[at + a] + beta * own[at + twists + a]
        own[stress + twists + a] = beta * own[at + a]
        own[out + a] = 0.0
    own[out_y] = own[out_z] = 0.0
    one, other = broadcast(still), broadcast(beta)
    for plane in range(2):
        number, linear, place, stiffness = bending_strains(size, plane)
        wide, made = fours(number), by + 2 * place
        quickly, speed = made + (with_y if plane == 1 else with_z), linear + (z if plane == 1 else y)
        on_linear = (out_z if plane == 1 else out_y) + 1
        for k in range(0, wide, 4):
            second = broadcast(0.0)
            for a in range(twists):
                row = a * wide + k
                second = multiply_add(broadcast(own[stress + a]), load(own, made + row), second)
                second = multiply_add(broadcast(own[stress + twists + a]), load(own, quickly + row), second)
            strain = multiply_add(one, load(own, linear + k), second)
            strain = multiply_add(other, load(own, speed + k), strain)
            stiff = load(data, stiffness + k)
            store(own, on_linear + k, multiply(stiff, second))
            pull = multiply(stiff, strain)
            for a in range(twists):
                row = a * wide + k
                own[out + a] += total(multiply(pull, load(own, made + row)))
                store(own, weights + place + row, multiply(broadcast(own[at + a]), pull))
    wide = fours(y)
    for k in range(twists - 1):
        unit, row = 2.0 if k == 0 else 1.0, torsion + k * wide
        stiffness = data[size[STRAINS] + fours(y - 1) + fours(z - 1) + k]
        lanes = broadcast(0.0)
        for i in range(0, wide, 4):
            slope, fast = load(own, at_y + i), load(own, at_y + y + i)
            product = load(own, by + row + i)
            lanes = multiply_add(multiply(one, slope), product, lanes)
            quick = multiply_add(slope, load(own, by + row + with_z + i), multiply(fast, product))
            lanes = multiply_add(other, quick, lanes)
        second = total(lanes)
        own[out + 1 + k] += unit * stiffness * second
        tension = second + unit * (still * own[at + 1 + k] + beta * own[at + twists + 1 + k])
        pull = broadcast(stiffness * tension)
        for i in range(0, wide, 4):
            product, whole = load(own, by + row + i), load(own, out_y + i)
            store(own, out_y + i, multiply_add(pull, product, whole))
            store(own, weights + row + i, multiply(pull, load(own, at_y + i)))
    add_combined(with_z, own, weights, data, size[BACK_Z], fours(z), own, out_z, fours(z))
    add_combined(with_y, own, weights + with_z, data, size[BACK_Y], fours(y), own, out_y, fours(y))
    add_slope_forces(size, e, own, out, out_y, out_z, force, first)


@kernel
def turning_energy(size, data, own, e, d, first):
    """What the second order adds to the strain energy of the nodal rows d, flat, J."""
    if size[TENSIONS] == 0:
        return 0.0
    twists, y, z = counts(size)
    at, at_y, at_z, _, _, _, by = stretches(size)
    write_slopes(size, e, d, first, own, at, at_y, at_z)
    torsion, with_z, with_y = product_counts(size)
    combine(z, own, at_z, data, size[CROSS_Z], with_z, own, by, with_z)
    combine(y, own, at_y, data, size[CROSS_Y], with_y, own, by + with_z, with_y)
    total = 0.0
    for plane in range(2):
        number, linear, place, stiffness = bending_strains(size, plane)
        for k in range(number):
            more = 0.0
            for a in range(twists):
                more += own[at + a] * own[by + place + a * fours(number) + k]
            total += data[stiffness + k] * more * (own[linear + k] + 0.5 * more)
    for k in range(twists - 1):
        more = 0.0
        for a in range(y):
            more += own[at_y + a] * own[by + torsion + k * fours(y) + a]
        unit = 2.0 if k == 0 else 1.0
        stiffness = data[size[STRAINS] + fours(y - 1) + fours(z - 1) + k]
        total += stiffness * more * (unit * own[at + 1 + k] + 0.5 * more)
    return total
