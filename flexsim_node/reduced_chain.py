"""How a chain's reduced links lie in memory: a table, a tape of constants and a tape of buffers.

Passing an array to a compiled function costs as much as a few multiplications, so that there are few arrays;
each reduced link has its own stretch of both tapes.
"""

from __future__ import annotations

import numpy as np

from .kernel import kernel

# columns of Chain.reduced (L, 12) int64: nodal rows after the link's end that hold its modes; modes (-1: the
# link is full), of them axial, bending in the beam's x-y and x-z planes; tensions; functions of the
# centreline and of the rotation, with zeros up to a multiple of four; where the constants, the shapes of the
# nodes and the elements' rows start in Chain.modal, and the buffers in Workspace.modal
ROWS, MODES, AXIALS, Y_MODES, Z_MODES, TENSIONS, CENTRELINE, ROTATION = range(8)
DATA, SHAPE, PIECES, BUFFER = range(8, 12)
COLUMNS = 12


@kernel
def lanes_of(b):
    """Places that the dofs of a node take in the rows of a factorisation: as many as a vector has."""
    return 4 if b == 3 else 8


@kernel
def row_width(size, b):
    """Length of a row of the factorisation: end, start and A in lanes, the tensions' entries, the pivot."""
    return 3 * lanes_of(b) + size[TENSIONS] + 1


@kernel
def column_height(size):
    """Length of a column of all rows, a multiple of four."""
    return (size[MODES] + size[TENSIONS] + 3) // 4 * 4


@kernel
def constant_places(size, b):
    """Where a link's constants start behind size[DATA].

    mass (F, F), section (G, G), slope (T, F, F), tension (T,), modal mass and stiffness (P,), coupling of the
    modes with end and start node (P, 2b); and the end of all.
    """
    f, g, p, t = size[CENTRELINE], size[ROTATION], size[MODES], size[TENSIONS]
    section = size[DATA] + f * f
    slope = section + g * g
    tension = slope + t * f * f
    mass = tension + t
    stiffness = mass + p
    coupling = stiffness + p
    return size[DATA], section, slope, tension, mass, stiffness, coupling, coupling + 2 * b * p


@kernel
def buffer_places(size, b):
    """Where a link's buffers start behind size[BUFFER].

    pivot rows (P + T, row_width), their columns over (end, start, A) times minus the inverse pivots (3b,
    column_height) and two more such columns, front (3b), 1 + tensions at hand (0: no rows yet) and the
    scale that the rows are for, centreline (displacement, rate, acceleration, all of it, force; 3 F), weights
    (3, 9), rotation (8, 3 G), half the gradient of a squared slope in y and in z (2, F); and the end of all.
    """
    f, g, p, t = size[CENTRELINE], size[ROTATION], size[MODES], size[TENSIONS]
    columns = size[BUFFER] + (p + t) * row_width(size, b)
    front = columns + (3 * b + 2) * column_height(size)
    active = front + 3 * b
    centre = active + 2
    turn = centre + 15 * f + 27
    slope = turn + 24 * g
    return size[BUFFER], front, active, centre, turn, slope, columns, slope + 2 * f


def buffer_length(table: np.ndarray, b: int) -> int:
    """Length of Workspace.modal."""
    return max((int(buffer_places(row, b)[-1]) for row in table if row[MODES] >= 0), default=0)
