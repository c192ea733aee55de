"""How a reduced link's twist and deflections strain it to second order: constant products of its functions.

Each element's strains to second order (spatial_strain.py, T7) are projected on the strains that the link's
own coordinates can take up, as its squared slope is: so they can't lock, follow from an energy, and are the
full model's where all modes are kept.  The coordinates are the link's twist (mean, half difference of the
ends, modes that twist) and its slopes in y and in z (mean of the ends, difference, skew, modes that bend).
"""

from __future__ import annotations

import numpy as np

from ...elements.beam import BEND_Y, BEND_Z, HELIX, LENGTH, SHEAR_Y, SHEAR_Z, TORSION
from ...elements.spatial_strain import slopes


def end_rows(length: float) -> np.ndarray:
    """(8, 12) nodal rows (start, end) of a link with one of x0, x1, m_z, c_z, s_z, m_y, c_y, s_y."""
    rows = np.zeros((8, 12))
    rows[0, [3, 9]] = 1.0
    rows[1, [3, 9]] = -1.0, 1.0
    rows[2, [5, 11, 7]] = 1.0, 1.0, length
    rows[3, [5, 11]] = -0.5, 0.5
    rows[4, 7] = length
    rows[5, [4, 10, 8]] = -1.0, -1.0, length
    rows[6, [4, 10]] = 0.5, -0.5
    rows[7, 8] = length
    return rows


def helices(rows: np.ndarray, shape: np.ndarray, counts: tuple[int, ...], weights: np.ndarray) -> np.ndarray:
    """(T, 1 + t, .) products of the twists' slopes in the elongation that each tension sees, with zeros.

    The coordinates are half the difference of the ends' twists and t modes that twist; weights (T, E) are the
    elongation's per element, over its length.
    """
    twist = np.concatenate([shape[:, 3, [9]] - shape[:, 3, [3]], shape[:, 3, 12 + sum(counts[:3]) :]], axis=1)
    wound = np.diff(twist, axis=0).T
    made = np.einsum("te,e,ae,be->tab", weights, rows[:, HELIX], wound, wound)
    return np.pad(made, ((0, 0), (0, 0), (0, -made.shape[2] % 4)))


def strain_stiffness(whole: np.ndarray, modal: np.ndarray, counts: tuple[int, ...]) -> np.ndarray:
    """Stiffness of a link's strains: of bending in y and in z, padded with zeros to fours, of torsion.

    whole : row of the link as one element; modal : (P,) stiffness of the modes; counts : of each kind
    """
    parts = np.split(modal, np.cumsum(counts[:3]))
    skew_z, skew_y = 12.0 * (1.0 - whole[SHEAR_Z]), 12.0 * (1.0 - whole[SHEAR_Y])
    bend_y = np.array([whole[BEND_Z], skew_z * whole[BEND_Z], *parts[1]])
    bend_z = np.array([whole[BEND_Y], skew_y * whole[BEND_Y], *parts[2]])
    return np.concatenate([padded(bend_y), padded(bend_z), [whole[TORSION]], parts[3]])


def turning_products(
    whole: np.ndarray, rows: np.ndarray, shape: np.ndarray, counts: tuple[int, ...], turns: bool
) -> tuple[np.ndarray, ...]:
    """Products of second order in a link's strains, two tables and their transposes; empty if it can't turn.

    The first table belongs to slopes in z: their products in the bending strains in y and in the torsion. The
    second belongs to slopes in y: their products in the bending strains in z.

    Parameters
    ----------
    whole : row of the link as one element; rows : (E, 14) of its elements
    shape : (nodes, 6, 12 + P) nodal rows of unit coordinates (start node, end node, modes)
    counts : modes of each kind

    Returns
    -------
    (3 + z, .), (3 + y, .) and both transposed, for y, z, t modes of the kinds. Columns of the first: twist by
    bending strain (2 + t, 2 + y), then torsion strain by slope in y (1 + t, 3 + y); of the second: twist by
    bending strain (2 + t, 2 + z). The last index of each has zeros up to a multiple of four.
    """
    if not turns:
        return (np.zeros(0),) * 4
    axial, y, z, _ = counts
    nodal = np.concatenate(
        [
            np.einsum("nik,ck->cni", shape[:, :, :12], end_rows(whole[LENGTH])),
            shape[:, :, 12:].transpose(2, 0, 1),
        ]
    )
    # (coordinates, elements, 8) slopes of every element
    found = np.array([[slopes(rows[e], u[e], u[e + 1]) for e in range(len(rows))] for u in nodal])
    modes = 8 + axial
    twist = found[[0, 1, *range(modes + y + z, len(found))]]
    bend_y = found[[2, 3, 4, *range(modes, modes + y)]]
    bend_z = found[[5, 6, 7, *range(modes + y, modes + y + z)]]
    c_z, s_z, m_z = bend_y[:, :, 0], bend_y[:, :, 1], bend_y[:, :, 2]
    c_y, s_y, m_y = bend_z[:, :, 3], bend_z[:, :, 4], bend_z[:, :, 5]
    x0, x1 = twist[:, :, 6], twist[:, :, 7]
    k_z, k_y, torsion = rows[:, BEND_Z], rows[:, BEND_Y], rows[:, TORSION]
    o_z, o_y = 1.0 - rows[:, SHEAR_Z], 1.0 - rows[:, SHEAR_Y]

    def products(left: np.ndarray, right: np.ndarray) -> np.ndarray:
        return np.einsum("ae,be->abe", left, right)

    def projected(strains: np.ndarray, stiffness: np.ndarray, parts: np.ndarray) -> np.ndarray:
        """Of parts (s, a, b, E) with linear strains (s, k, E) and stiffness (s, E): (b, a, k)."""
        own = np.einsum("ske,se->k", strains**2, stiffness)
        made = np.einsum("ske,se,sabe->kab", strains, stiffness, parts)
        found = np.divide(made, own[:, None, None], out=np.zeros_like(made), where=own[:, None, None] > 0.0)
        return found.T

    in_y = projected(
        np.array([c_z[1:], s_z[1:]]),
        np.array([k_z, 12.0 * o_z * k_z]),
        np.array(
            [products(x0, c_y) - 2.0 * o_y * products(x1, s_y), products(x0, s_y) - products(x1, c_y) / 6.0]
        ),
    )
    in_z = projected(
        np.array([c_y[1:], s_y[1:]]),
        np.array([k_y, 12.0 * o_y * k_y]),
        np.array(
            [2.0 * o_z * products(x1, s_z) - products(x0, c_z), products(x1, c_z) / 6.0 - products(x0, s_z)]
        ),
    )
    in_twist = projected(
        2.0 * x1[None, 1:],
        torsion[None],
        (products(c_z, 0.5 * m_y + o_y * s_y) - products(0.5 * m_z + o_z * s_z, c_y))[None],
    )
    # the ends' strain is the difference of their twists, 2 x1; a mode's is its coordinate
    in_twist[:, :, 0] *= 2.0
    with_z = np.concatenate([together(in_y), together(in_twist.transpose(0, 2, 1))], axis=1)
    with_y = together(in_z)
    return with_z, with_y, padded(with_z.T), padded(with_y.T)


def together(products: np.ndarray) -> np.ndarray:
    """(b, a, k) with the last two as one, and zeros behind each k."""
    return padded(products).reshape(len(products), -1)


def padded(rows: np.ndarray) -> np.ndarray:
    """Rows with zeros up to a multiple of four."""
    return np.pad(rows, [(0, 0)] * (rows.ndim - 1) + [(0, -rows.shape[-1] % 4)])
