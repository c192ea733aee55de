"""Constants of a beam's cross-section."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..scene.schema import Beam


class Section(NamedTuple):
    """Area (m2), second moments about beam y and z, torsion constant (m4), shear areas (m2)."""

    area: float
    iy: float
    iz: float
    j: float
    shear_area_y: float
    shear_area_z: float


def torsion_constant(width: float, depth: float) -> float:
    """Saint-Venant's constant of a rectangle, m4 (Timoshenko & Goodier, Theory of Elasticity, 109)."""
    a, b = max(width, depth), min(width, depth)
    n = np.arange(1, 40, 2)
    series = float(np.sum(np.tanh(0.5 * n * np.pi * a / b) / n**5))
    return a * b**3 / 3.0 * (1.0 - 192.0 / np.pi**5 * b / a * series)


def section(beam: Beam) -> Section:
    """Section constants; shear coefficient of a rectangle after Cowper, J. Appl. Mech. 33 (1966) 335."""
    nu = beam.poissons_ratio
    cowper = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu)
    if beam.width is not None and beam.depth is not None:
        width, depth = beam.width, beam.depth
        area = width * depth
        iy, iz = width * depth**3 / 12.0, depth * width**3 / 12.0
        j = torsion_constant(width, depth)
    else:
        assert beam.area and beam.iy and beam.iz and beam.j
        area, iy, iz, j = beam.area, beam.iy, beam.iz, beam.j
    return Section(area, iy, iz, j, beam.shear_area_y or cowper * area, beam.shear_area_z or cowper * area)
