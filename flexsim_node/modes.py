"""Natural frequencies of a robot in a configuration."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh

from .chain import workspace
from .dynamics import residual, stiffness_times
from .kinematics import place
from .model import Model, build_model
from .scene import Scene
from .schema import Erls
from .statics import check_position


def mass_and_stiffness(model: Model, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Dense (n, n) mass and elastic stiffness at the unknowns x (n,)."""
    n = model.unknowns
    work, torque = workspace(model.chain), np.zeros(model.joints)
    zero, base, column = np.zeros(n), np.zeros(n), np.zeros(n)
    mass, stiffness = np.zeros((n, n)), np.zeros((n, n))
    residual(model.chain, work, x, zero, zero, torque, base)
    for k, unit in enumerate(np.eye(n)):
        residual(model.chain, work, x, zero, unit, torque, column)
        mass[:, k] = base - column
    place(model.chain, work, x)
    for k, unit in enumerate(np.eye(n)):
        stiffness_times(model.chain, work, unit, 1.0, column)
        stiffness[:, k] = column
    return 0.5 * (mass + mass.T), 0.5 * (stiffness + stiffness.T)


def natural_frequencies(
    scene: Scene, position: np.ndarray | list[float], locked: bool = True
) -> np.ndarray:
    """Undamped natural frequencies of the undeformed robot, Hz, in rising order.

    Parameters
    ----------
    position : (m,) joint coordinates
    locked : joints held; where False they are free, and each gives a frequency of zero

    Bending, torsion and extension in space count, also where the scene's motion is planar; gravity does not.
    """
    # with `root` the joints' coordinates are the motors' angles, which is what is locked
    scene = scene.model_copy(update={"erls": Erls(zeroed="root")})
    model = build_model(scene, planar=False)
    m = model.joints
    x = np.zeros(model.unknowns)
    x[:m] = check_position(scene, position, m)
    mass, stiffness = mass_and_stiffness(model, x)
    if len(mass) == m:
        return np.zeros(0 if locked else m)
    held = _squared(mass[m:, m:], stiffness[m:, m:], 0.0)
    if locked:
        squared = held
    else:
        squared = _squared(mass, stiffness, held[0])
        squared[:m] = 0.0  # the joints turn freely, whatever rounding makes of it
    return np.sqrt(squared) / (2.0 * np.pi)


def _squared(mass: np.ndarray, stiffness: np.ndarray, shift: float) -> np.ndarray:
    """(n,) rising eigenvalues of K - s M; K + shift M is positive definite.

    K spans so many decades with many elements that rounding in it drowns the lowest modes: those come from
    its inverse, the others directly.
    """
    low = 1.0 / eigh(mass, stiffness + shift * mass, eigvals_only=True)[::-1] - shift
    high = eigh(stiffness, mass, eigvals_only=True)
    return np.where(high < np.sqrt(abs(low[0] + shift) * high[-1]), low, high)
