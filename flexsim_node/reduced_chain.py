"""How a chain's reduced links lie in memory: a table, a tape of constants and a tape of buffers.

Passing an array to a compiled function costs as much as a few multiplications, so that there are few arrays;
each reduced link has its own stretch of both tapes, and its row of the table says where everything is.
"""

from __future__ import annotations

import numpy as np

from .kernel import kernel

# Columns of Chain.reduced (L, 30) int64: nodal rows after the link's end that hold its modes; modes (-1: the
# link is full), of them axial, bending in the beam's x-y and x-z planes; tensions; functions of the
# centreline and of the rotation, F and G, with zeros up to a multiple of four.
ROWS, MODES, AXIALS, Y_MODES, Z_MODES, TENSIONS, CENTRELINE, ROTATION = range(8)
# Where in Chain.modal are: the functions' products (F, F) and (G, G), those of their slopes (T, F, F), the
# tensions' stiffness (T,), modal mass and stiffness (P,), coupling of the modes with end and start node
# (P, 2b), the shapes of the nodes, the elements' rows.
MASS_GRAM, TURN_GRAM, SLOPE_GRAM, TENSION, MODAL_MASS, MODAL_STIFFNESS, COUPLING, SHAPE, PIECES = range(8, 17)
# Where in Workspace.modal are, with c components of a vector: rows of the factorisation (P + T, width), their
# columns over (end, start, A) times minus the inverse pivots (3b, height), weights (height), a front (3b),
# the number of tensions in the factorisation; the centreline's displacement, rate, acceleration, all of the
# latter, force (5, c, F), weights (c, 3c); the rotation's: in the plane displacement, rate, acceleration,
# inertia (2), their products (2) and one more (8, G), in space the first three of 3, inertia (7), its
# products (3) and the displacement's (22, G), weights; half the gradient of the squared slope in y and in z
# that each tension sees (T, c - 1, F).
PIVOTS, COLUMN, WEIGHT, FRONT, ACTIVE, LINE, MIX, TURN, TURN_MIX, GRADIENT = range(17, 27)
# Length of a row of the factorisation: end, start and A in lanes, the tensions' entries with zeros up to a
# multiple of four, the inverse pivot; and of a column, a multiple of four.  Where the link's buffers end.
WIDTH, HEIGHT, END = 27, 28, 29
COLUMNS = 30


@kernel
def lanes_of(b):
    """Places that the dofs of a node take in the rows of a factorisation: as many as a vector has."""
    return 4 if b == 3 else 8


def places(size: np.ndarray, b: int, constants: int, shapes: int, buffers: int) -> int:
    """Fill in where a link's constants and buffers are; returns where the buffers end.

    constants, buffers : where they start; shapes : length of those of the nodes
    """
    f, g, p, t = (int(size[k]) for k in (CENTRELINE, ROTATION, MODES, TENSIONS))
    c, turning = (2, 8) if b == 3 else (3, 22)
    lanes = 4 if b == 3 else 8
    size[WIDTH], size[HEIGHT] = 3 * lanes + -(-t // 4) * 4 + 1, -(-(p + t) // 4) * 4
    for column, length in (
        (MASS_GRAM, f * f), (TURN_GRAM, g * g), (SLOPE_GRAM, t * f * f), (TENSION, t),
        (MODAL_MASS, p), (MODAL_STIFFNESS, p), (COUPLING, 2 * b * p), (SHAPE, shapes), (PIECES, 0),
    ):  # fmt: skip
        size[column] = constants
        constants += length
    for column, length in (
        (PIVOTS, (p + t) * int(size[WIDTH])), (COLUMN, 3 * b * int(size[HEIGHT])),
        (WEIGHT, int(size[HEIGHT])), (FRONT, 3 * b), (ACTIVE, 1), (LINE, 5 * c * f),
        (MIX, 3 * c * c), (TURN, turning * g), (TURN_MIX, 63), (GRADIENT, t * (c - 1) * f),
    ):  # fmt: skip
        size[column] = buffers
        buffers += length
    size[END] = buffers
    return buffers


def buffer_length(table: np.ndarray) -> int:
    """Length of Workspace.modal."""
    return int(table[:, END].max(initial=0))
