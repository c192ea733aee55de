"""How a chain's reduced links lie in memory: a table, a tape of constants and a tape of buffers.

Passing an array to a compiled function costs as much as a few multiplications, so that there are few arrays;
each reduced link has its own stretch of both tapes, and its row of the table says where everything is.

Functions of the centreline are in the order modes in the x-y plane, Hermite's, modes in the x-z plane, axial
ones; those of the rotation modes in the x-y plane, quadratics, modes in the x-z plane, twists.  So the
functions of a deflection in y, and those of one in z, are neighbours.
"""

from __future__ import annotations

import numpy as np

# Columns of Chain.reduced (L, 51 + 2P) int64: nodal rows after the link's end that hold its modes; modes
# (-1: the link is full), of them axial, bending in the beam's x-y and x-z planes; tensions; functions of the
# centreline and of the rotation, F and G, with zeros up to a multiple of four; those of a deflection in y and
# in z, likewise, Y and Z.
ROWS, MODES, AXIALS, Y_MODES, Z_MODES, TENSIONS, CENTRELINE, ROTATION, LATERAL_Y, LATERAL_Z = range(10)
# Where in Chain.modal are: the functions' products (F, F) and (G, G), those of the slopes of the functions in
# y and in z for one tension beside the other (4 + y modes, T Y) and (4 + z modes, T Z), the tensions'
# stiffness (T,), modal mass and stiffness (P,), the stiffness of start and end with zeros up to a multiple of
# four (2b, .), coupling of the modes with end and start node (P, 2b), the shapes of the nodes, the elements'
# rows.  Every stretch of both tapes begins with a cache line.
MASS_GRAM, TURN_GRAM, SLOPE_Y, SLOPE_Z = 10, 11, 12, 13
TENSION, MODAL_MASS, MODAL_STIFFNESS, ENDS, COUPLING, SHAPE, PIECES = range(14, 21)
# Where in Workspace.modal are, with c components of a vector: rows of the factorisation (P + T, width), their
# inverse pivots (P + T), the tensions' rows times minus those (T, width); for modes the same over (end,
# start, A, tensions), column by column (3b + T, height); weights (P + T), a front (width), loads of the
# tensions (T), their number in the factorisation; the centreline's displacement, rate, acceleration, all of
# the latter, force (5, c, F), weights (3, 3 c); the rotation's displacement, rate and acceleration, inertia,
# its products: in the plane 1, 1, 1, 2, 2 and in space 3, 3, 3, 3, 3 components; weights of them; the
# displacement's products (1 or 3, G), in space with its integrals (3); half the gradients of the squared
# slope that the tensions see, in y and in z (T, Y) and (T, Z), and the lateral coefficients that they go
# with (Y + Z).
PIVOTS, INVERSE, SCALED, COLUMN, WEIGHT, FRONT, LOADS, ACTIVE = range(21, 29)
LINE, MIX, TURN, TURN_MIX, TURNED, GRADIENT, LATERAL = range(29, 36)
# Length of a row of the factorisation, over end, start, A and tensions, with zeros; and of a column, a
# multiple of four.  Where the link's buffers end.  For each mode where among the centreline's coefficients it
# is, and where among the rotation's (-1: nowhere).
WIDTH, HEIGHT, END = 36, 37, 38
# Where in Chain.modal the strains' products of second order are: of deflection in z with the twist, in the
# bending in y, and with that in y, in the torsion; of deflection in y with the twist, in the bending in z
# (turning.py); both transposed. And in Workspace.modal the slopes that they take and give, and the products
# with one factor, with its rate, and their weights.
CROSS_Z, CROSS_Y, BACK_Z, BACK_Y, BENT = range(39, 44)
# Where in Chain.modal are the products of the twists' slopes that each tension sees (T, 1 + t, .), and those
# of the rotation's functions at the elements' ends (G, G), where their turn of second order counts; and in
# Workspace.modal the twists, their rates and products (3, .), and the latter times the rotation (3, G), times
# its rate about y and z (2, G), weights (3, 3).
HELICES, LUMP_GRAM, WOUND, LUMPS = range(44, 48)
# Where in Chain.modal is the stiffness of those strains: of bending in y, in z, of torsion, the first two
# with zeros up to a multiple of four. And in Workspace.modal the rotation's products and those at the
# elements' ends, function by function (G, 8), and the sums of these with the rotation, its rate and its
# acceleration, component by component (3, 3, 8).
STRAINS, ACROSS, SUMS = range(48, 51)
FUNCTION = 51
COLUMNS = 51


def eights(n: int) -> int:
    """The next multiple of eight: stretches begin with a cache line where the tape does."""
    return -(-n // 8) * 8


def fours(n: int) -> int:
    """The next multiple of four."""
    return -(-n // 4) * 4


def places(size: np.ndarray, b: int, constants: int, shapes: int, buffers: int) -> int:
    """Fill in where a link's constants and buffers are; returns where the buffers end.

    constants, buffers : where they start; shapes : length of those of the nodes
    """
    f, g, p, t = (int(size[k]) for k in (CENTRELINE, ROTATION, MODES, TENSIONS))
    axial, y, z = (int(size[k]) for k in (AXIALS, Y_MODES, Z_MODES))
    twists = 2 + p - axial - y - z
    bent = sum(fours(2 * n + 3) + fours(n + 3) for n in (twists, 3 + y, 3 + z))
    with_z = twists * fours(2 + y) + (twists - 1) * fours(3 + y)
    with_y, strains = twists * fours(2 + z), 2 * twists
    size[LATERAL_Y], size[LATERAL_Z] = fours(4 + y), fours(4 + z) if b == 6 else 0
    wide, high = int(size[LATERAL_Y]), int(size[LATERAL_Z])
    c, turning, turned = (2, 7, g) if b == 3 else (3, 15, 3 * g + 3)
    size[WIDTH], size[HEIGHT] = max(fours(3 * b + t), 12 if b == 3 else 24), fours(p)
    for i in range(p):
        kind = sum(i >= edge for edge in (axial, axial + y, axial + y + z))
        k = i - (0, axial, axial + y, axial + y + z)[kind]
        line = (y + 4 + z, f, 2 * f + y + 4, -1 - k)[kind] + k
        turn = (-1 - k, 2 * g if b == 6 else 0, g + y + 3, y + 3 + z)[kind] + k
        size[FUNCTION + 2 * i], size[FUNCTION + 2 * i + 1] = line, turn
    for column, length in (
        (MASS_GRAM, f * f), (TURN_GRAM, g * g), (SLOPE_Y, (4 + y) * t * wide), (SLOPE_Z, (4 + z) * t * high),
        (TENSION, t), (MODAL_MASS, p), (MODAL_STIFFNESS, p), (ENDS, 2 * b * fours(2 * b)),
        (COUPLING, 2 * b * p), (SHAPE, shapes), (CROSS_Z, (3 + z) * with_z),
        (CROSS_Y, (3 + y) * with_y), (BACK_Z, with_z * fours(3 + z)), (BACK_Y, with_y * fours(3 + y)),
        (HELICES, t * (twists - 1) * fours(twists - 1) if b == 6 else 0), (LUMP_GRAM, g * g),
        (STRAINS, fours(2 + y) + fours(2 + z) + 1 + p - axial - y - z), (PIECES, 0),
    ):  # fmt: skip
        size[column] = constants
        constants += eights(length)
    width, height = int(size[WIDTH]), int(size[HEIGHT])
    for column, length in (
        (PIVOTS, (p + t) * width), (INVERSE, p + t), (SCALED, t * width), (COLUMN, (3 * b + t) * height),
        (WEIGHT, fours(p + t)), (FRONT, width), (LOADS, t), (ACTIVE, 1), (LINE, 5 * c * f), (MIX, 3 * c * c),
        (TURN, turning * g), (TURN_MIX, 27), (TURNED, turned), (GRADIENT, t * (wide + high)),
        (LATERAL, wide + high), (BENT, bent + 3 * (with_z + with_y) + strains),
        (WOUND, 3 * fours(twists - 1)), (LUMPS, (2 if b == 3 else 5) * g + 9),
        (ACROSS, 8 * g if b == 6 else 0), (SUMS, 72 if b == 6 else 0), (END, 0),
    ):  # fmt: skip
        size[column] = buffers
        buffers += eights(length)
    return buffers


def buffer_length(table: np.ndarray) -> int:
    """Length of Workspace.modal, with room for the last vector's surplus."""
    return int(table[:, END].max(initial=0)) + 24
