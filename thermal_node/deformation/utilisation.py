"""How much of its yield strength a leaf uses, and where."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .deflection import Utilisation

Array = NDArray[np.float64]


def von_mises(stress: Array) -> Array:
    """Von Mises stress (...,), Pa, of plane stresses xx, yy, xy (..., 3)."""
    a, b, s = stress[..., 0], stress[..., 1], stress[..., 2]
    return np.asarray(np.sqrt(np.maximum(a * a + b * b - a * b + 3.0 * s * s, 0.0)))


def equivalent_strain(plastic: Array) -> float:
    """The largest equivalent plastic strain of strains xx, yy, xy (..., 3) that keep the volume.

    sqrt(2/3 e:e) with e_zz = -(e_xx + e_yy) and e_xy half of the engineering shear.
    """
    a, b, s = plastic[..., 0], plastic[..., 1], plastic[..., 2]
    square = 4.0 / 3.0 * (a * a + b * b + a * b) + s * s / 3.0
    return float(np.sqrt(square.max(initial=0.0)))


def most_used(
    stress: Array,
    strength: Array,
    temperature: Array,
    place: Array,
    kind: NDArray[np.int64],
    names: tuple[str, ...],
) -> Utilisation | None:
    """The point of the largest share, of stresses and strengths, Pa, temperatures, °C, places (..., 3), m."""
    share = stress / strength
    at = np.unravel_index(int(np.argmax(share)), share.shape)
    if not np.isfinite(strength[at]):
        return None
    x, y, z = (float(v) for v in place[at])
    return Utilisation(
        share=float(share[at]),
        stress=float(stress[at]),
        strength=float(strength[at]),
        temperature=float(temperature[at]),
        position=(x, y, z),
        material=names[kind[at]],
    )
