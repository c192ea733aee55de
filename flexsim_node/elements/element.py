"""A link's beam elements: their rows of constants, and their matrices."""

from __future__ import annotations

import numpy as np

from ..scene.load import Scene
from ..scene.schema import Link
from . import spatial_beam
from .beam import (
    AXIAL,
    BEND_Y,
    BEND_Z,
    COLUMNS,
    HELIX,
    HERMITE_MASS,
    INERTIA_Y,
    INERTIA_Z,
    LENGTH,
    MASS,
    POLAR,
    QUADRATIC_MASS,
    SHEAR_Y,
    SHEAR_Z,
    START,
    STIFFENING,
    TORSION,
    TURNING,
)
from .section import section


def stiffening(scene: Scene) -> bool:
    """Whether spin softens and stiffens the links: one effect, which needs the axial force."""
    return bool(scene.effects.centrifugal and scene.effects.axial)


def element_row(scene: Scene, link: Link, n: int, length: float, flexible: bool) -> np.ndarray:
    """Column values of element n of a link (see beam.py)."""
    row = np.zeros(COLUMNS)
    effects = scene.effects
    row[START], row[LENGTH] = n * length, length
    beam = link.beam
    if beam is None:
        return row
    s = section(beam)
    shear_modulus = beam.youngs_modulus / (2.0 * (1.0 + beam.poissons_ratio))
    row[MASS] = beam.density * s.area * length
    if effects.rotary_inertia:
        row[INERTIA_Y], row[INERTIA_Z] = beam.density * s.iz, beam.density * s.iy
    elif effects.torsion:
        row[POLAR] = beam.density * (s.iy + s.iz)
    row[TURNING] = 1.0 if stiffening(scene) else 0.0
    if not flexible:
        return row
    row[TORSION] = shear_modulus * s.j / length
    row[AXIAL] = beam.youngs_modulus * s.area / length
    row[BEND_Z] = beam.youngs_modulus * s.iz / length
    row[BEND_Y] = beam.youngs_modulus * s.iy / length
    if effects.shear:
        phi_z = 12.0 * beam.youngs_modulus * s.iz / (shear_modulus * s.shear_area_y * length**2)
        phi_y = 12.0 * beam.youngs_modulus * s.iy / (shear_modulus * s.shear_area_z * length**2)
        row[SHEAR_Z], row[SHEAR_Y] = phi_z / (1.0 + phi_z), phi_y / (1.0 + phi_y)
    if stiffening(scene):
        row[STIFFENING] = 1.0
        row[HELIX] = (s.iy + s.iz) / s.area
    return row


def element_matrices(row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(12, 12) mass and stiffness of an element, nodes ordered (end, start)."""
    units = np.eye(12)
    centre = np.zeros((12, 4, 3))
    turn = np.zeros((12, 3, 3))
    stiffness = np.zeros((12, 12))
    for k in range(12):
        end, start = units[k, :6].copy(), units[k, 6:].copy()
        spatial_beam.centreline(row, start, end, 0.0, centre[k])
        spatial_beam.section_rotation(row, start, end, turn[k])
        force = np.zeros((2, 6))
        nodes = np.array([start, end])
        spatial_beam.stiffness_product(row, np.zeros((2, 6)), nodes, 1, 1.0, force)
        stiffness[k] = np.concatenate([force[1], force[0]])
    mass = row[MASS] * np.einsum("iak,ab,jbk->ij", centre, HERMITE_MASS, centre)
    zero = np.zeros((12, 3))
    x, y, z = turn[:, :, 0], turn[:, :, 1], turn[:, :, 2]
    for inertia, director in ((row[INERTIA_Y], (-z, zero, x)), (row[INERTIA_Z], (y, -x, zero))):
        for part in director:
            mass += inertia * row[LENGTH] * part @ QUADRATIC_MASS @ part.T
    linear = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6.0
    for i, p in enumerate((9, 3)):
        for k, q in enumerate((9, 3)):
            mass[p, q] += row[POLAR] * row[LENGTH] * linear[i, k]
    return mass, stiffness


def own_matrix(matrix: np.ndarray) -> np.ndarray:
    """(B, B) of a (2B, 2B) matrix of nodes (end, start), over an element's unknowns (see co_moving/)."""
    b = len(matrix) // 2
    rows = np.zeros((2 * b, b))
    if b == 3:
        # u, start -b, end c
        rows[0, 0] = rows[2, 2] = 1.0
        rows[5, 1] = -1.0
    else:
        rows[0, 0] = rows[4, 4] = rows[5, 5] = 1.0
        rows[10, 2] = rows[11, 1] = -1.0
        rows[3, 3], rows[9, 3] = 0.5, -0.5
    return rows.T @ matrix @ rows
