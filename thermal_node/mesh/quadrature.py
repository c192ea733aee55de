"""How a line's bricks share what they hold among its nodes.

The trapezium rule halves each brick between its two nodes: second order, and its error sits at the
ends of a layer and where bricks grow. Here a brick's integral is that of the cubic through its two
nodes and the next on either side, at a layer's end of the parabola that is left of it, so that heat,
surfaces and cross-sections are summed to fourth order while every node keeps a positive share. With
even bricks that is Gregory's rule of second differences: 3/8, 7/6, 23/24, 1, 1, ...
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST = 0.5
"""The smallest share of a node, relative to the trapezium rule's; where a cubic would give less (a
layer of few, very uneven bricks), the layer goes as far towards it as this allows."""

GAUSS = np.array([-np.sqrt(0.6), 0.0, np.sqrt(0.6)]), np.array([5.0, 8.0, 5.0]) / 18.0


def halves(nodes: int) -> Array:
    """The trapezium rule's shares (nodes, bricks): half of each brick to either node."""
    if nodes == 1:
        return np.ones((1, 1))
    out = np.zeros((nodes, nodes - 1))
    brick = np.arange(nodes - 1)
    out[brick, brick] = out[brick + 1, brick] = 0.5
    return out


def shares(line: Array, run: NDArray[np.int64], even: tuple[bool, bool]) -> Array:
    """The share (nodes, bricks) of each brick's size that each node stands for; columns sum to 1.

    line (nodes,) : node positions, m, one where the direction is not resolved
    run (bricks,) : which layer a brick belongs to; a cubic does not look across layers, since the
        temperature has a kink there
    even : whether the field is even about the line's first and its last node (a plane of symmetry)
    """
    if len(line) == 1:
        return np.ones((1, 1))
    out = np.zeros((len(line), len(line) - 1))
    for each in np.unique(run):
        bricks = np.flatnonzero(run == each)
        first, last = bricks[0], bricks[-1] + 1
        mirrored = even[0] and first == 0, even[1] and last == len(line) - 1
        out[first : last + 1, first:last] = _layer(line[first : last + 1], mirrored)
    return out


def _layer(x: Array, mirrored: tuple[bool, bool]) -> Array:
    n = len(x)
    if x[-1] == x[0]:
        return halves(n)
    source = np.arange(n)
    before = source[1:3][::-1] if mirrored[0] else source[:0]
    after = source[-3:-1][::-1] if mirrored[1] else source[:0]
    position = np.concatenate([2.0 * x[0] - x[before], x, 2.0 * x[-1] - x[after]])
    source = np.concatenate([before, source, after])
    trapezium = halves(n)
    cubic = np.zeros((n, n - 1))
    for brick in range(n - 1):
        at = brick + len(before)
        window = slice(max(0, at - 1), at + 3)
        middle, half = 0.5 * (x[brick] + x[brick + 1]), 0.5 * (x[brick + 1] - x[brick])
        mean = _mean_of_lagrange(position[window], middle + half * GAUSS[0])
        np.add.at(cubic[:, brick], source[window], mean)
    width = np.diff(x)
    plain = trapezium @ width
    lost = np.max((plain - cubic @ width) / plain)
    part = min(1.0, (1.0 - LEAST) / lost) if lost > 0.0 else 1.0
    return np.asarray(trapezium + part * (cubic - trapezium))


def _mean_of_lagrange(nodes: Array, at: Array) -> Array:
    """The mean of each node's Lagrange polynomial over a brick with Gauss points `at`."""
    value = np.ones((len(nodes), len(at)))
    for i in range(len(nodes)):
        for j in range(len(nodes)):
            if i != j:
                value[i] *= (at - nodes[j]) / (nodes[i] - nodes[j])
    return value @ GAUSS[1]
