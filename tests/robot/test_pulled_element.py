"""A step's iteration holds what a pull does: its matrix is the stiffness of a straight pulled element."""

import numpy as np
import pytest

from flexsim_node.elements import planar_beam, spatial_beam, spatial_strain
from flexsim_node.elements.beam import (
    AXIAL,
    BEND_Y,
    BEND_Z,
    COLUMNS,
    HELIX,
    LENGTH,
    SHEAR_Y,
    SHEAR_Z,
    STIFFENING,
    TORSION,
    TURNING,
)

pytestmark = pytest.mark.equations
STEP = 1e-6


def pulled(dofs: int, turning: bool) -> tuple[np.ndarray, np.ndarray]:
    """An element with a tension of 1 kN, and its nodal rows (2, dofs)."""
    e = np.zeros(COLUMNS)
    e[LENGTH], e[AXIAL], e[BEND_Z], e[BEND_Y], e[TORSION] = 0.3, 1e5, 3.0, 5.0, 2.0
    e[SHEAR_Z], e[SHEAR_Y], e[STIFFENING], e[HELIX], e[TURNING] = 0.2, 0.1, 1.0, 1e-3, turning
    rows = np.zeros((2, dofs))
    rows[1, 0] = 1e-2
    return e, rows


def columns(function, dofs: int) -> np.ndarray:
    """(2 dofs, 2 dofs) of a function of nodal rows (start, end) and forces on them, ordered (end, start)."""
    found = []
    for unit in np.eye(2 * dofs):
        force = np.zeros((2, dofs))
        function(np.array([unit[dofs:], unit[:dofs]]), force)
        found.append([*force[1], *force[0]])
    return np.array(found).T


@pytest.mark.parametrize(("dofs", "turning"), [(3, False), (6, False), (6, True)])
def test_iteration_has_the_whole_stiffness(dofs, turning):
    """Differences of the elastic forces are the right."""
    beam = planar_beam if dofs == 3 else spatial_beam
    e, rows = pulled(dofs, turning)

    def differences(unit, force):
        for sign in (1.0, -1.0):
            moved = np.zeros_like(force)
            beam.elastic_force(e, rows + sign * STEP * unit, 1, moved)
            force += sign * moved / (2.0 * STEP)

    right = columns(differences, dofs)
    front = np.zeros((3 * dofs, 3 * dofs))
    if turning:
        spatial_strain.iteration_turning(e, rows[0], rows[1], 1.0, np.zeros((12, 12)), front)
    else:
        beam.iteration_stiffness(e, rows, 1, 1.0, np.zeros(2 * dofs), front)
        straight = e.copy()
        straight[[STIFFENING, HELIX]] = 0.0
        front[: 2 * dofs, : 2 * dofs] += columns(
            lambda unit, force: beam.stiffness_product(straight, np.zeros_like(rows), unit, 1, 1.0, force),
            dofs,
        )
    upper = np.triu(front[: 2 * dofs, : 2 * dofs])
    found = upper + np.triu(upper, 1).T
    assert np.allclose(found, right, rtol=0, atol=1e-9 * np.max(np.abs(right)))
    # what the pull alone is in it
    assert np.max(np.abs(right[1, 1])) > 1.5 * 12.0 * 0.8 * e[BEND_Z] / e[LENGTH] ** 2
