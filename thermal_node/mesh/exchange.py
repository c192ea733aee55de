"""What the nodes of bricks exchange: sums of the differences of a nodal field along edges, faces, bodies.

Trilinear bricks (8-node hexahedra) have matrices that are products of what they are along each
direction: D = [1 -1; -1 1] where the shape functions are differentiated, the mass M = L - D/6 where
they are not, with L the mass lumped at the ends. Multiplied out, a brick's conduction and heat capacity
are what is lumped at the nodes and products of D, each a difference s . f of the nodal field f:

    D_x              of an edge's two nodes, s = (+ -)
    D_x D_y          of a face's four, (+ - - +)
    D_x D_y D_z      of a body's eight, (+ - - + - + + -)

A part of weight w moves -w s_i (s . f) into its node i: what one node gains another loses, so heat is
conserved to rounding whatever the field. Finite volumes are the edges alone.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Exchange(NamedTuple):
    """The parts' weights by the directions they stretch along, each kept at the part's first node.

    Shapes (M, nz, ny, nx), or flat; of size 0 where there are none. The last node along a
    direction that a part stretches along has weight 0.
    """

    x: Array
    y: Array
    z: Array
    xy: Array
    xz: Array
    yz: Array
    xyz: Array
