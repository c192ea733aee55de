"""Tangent matrices of the equations at rest: M a + C v + K (x - x0) = B tau about a configuration x0.

The residual is cubic in the elastic unknowns and quadratic in the rates, so that five-point differences
are exact there but for rounding; in the joint coordinates they are off by STEP^4 / 30.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ...model.chain import COULOMB, COULOMB_SPEED, workspace
from ...model.model import Model
from ..kinematics.nodal_motion import place
from .residual import residual, stiffness_times

STEP = 1e-4  # m and rad, of the differences: what is left out is of its fourth power
RATE_STEP = 0.1  # m/s and rad/s: rates count by their squares, so that any step is exact but for rounding
FRICTION_STEP = 0.01  # of coulomb_speed, where friction is smooth


def differences(
    function: Callable[[np.ndarray], np.ndarray],
    about: np.ndarray,
    directions: np.ndarray,
    step: float = STEP,
) -> np.ndarray:
    """(k, d) derivatives of function: (n,) -> (k,) at `about` (n,) along each of the directions (n, d)."""
    columns = np.zeros((np.size(function(about)), directions.shape[1]))
    for k, way in enumerate(directions.T):
        for ahead, weight in ((-2.0, 1.0), (-1.0, -8.0), (1.0, 8.0), (2.0, -1.0)):
            columns[:, k] += weight * function(about + ahead * step * way)
    return columns / (12.0 * step)


def mass_matrix(model: Model, x: np.ndarray) -> np.ndarray:
    """(n, n) mass matrix at the unknowns x (n,)."""
    n = model.unknowns
    work, torque = workspace(model.chain), np.zeros(model.joints)
    zero, base, column = np.zeros(n), np.zeros(n), np.zeros(n)
    mass = np.zeros((n, n))
    residual(model.chain, work, x, zero, zero, torque, base)
    for k, unit in enumerate(np.eye(n)):
        residual(model.chain, work, x, zero, unit, torque, column)
        mass[:, k] = base - column
    return 0.5 * (mass + mass.T)


def elastic_stiffness(model: Model, x: np.ndarray) -> np.ndarray:
    """(n, n) stiffness of the links at the unknowns x (n,), without that of loads."""
    n = model.unknowns
    work, column = workspace(model.chain), np.zeros(n)
    stiffness = np.zeros((n, n))
    place(model.chain, work, x)
    for k, unit in enumerate(np.eye(n)):
        stiffness_times(model.chain, work, unit, 1.0, column)
        stiffness[:, k] = column
    return 0.5 * (stiffness + stiffness.T)


def forces(model: Model, x: np.ndarray, v: np.ndarray | None = None) -> np.ndarray:
    """(n,) generalized forces without torque at the unknowns x (n,): at rest, or at steady rates v (n,)."""
    work, rhs, zero = workspace(model.chain), np.zeros(x.size), np.zeros(x.size)
    residual(model.chain, work, x, zero if v is None else v, zero, np.zeros(model.joints), rhs)
    return rhs


def stiffness_matrix(model: Model, x: np.ndarray, v: np.ndarray | None = None) -> np.ndarray:
    """(n, n) derivative of minus the forces: elastic and geometric stiffness, gravity's, and spin's at v."""
    work, rhs, zero = workspace(model.chain), np.zeros(x.size), np.zeros(x.size)
    rate = zero if v is None else v
    torque = np.zeros(model.joints)

    def standing(at: np.ndarray) -> np.ndarray:
        residual(model.chain, work, at, rate, zero, torque, rhs)
        return -rhs

    stiffness = differences(standing, x, np.eye(x.size))
    return 0.5 * (stiffness + stiffness.T)


def damping_matrix(model: Model, x: np.ndarray, v: np.ndarray | None = None) -> np.ndarray:
    """(n, n) derivative of minus the forces by the rates, at rest or at v: Rayleigh's damping, the joints'
    friction, and the gyroscopic forces of a spin.

    Smooth Coulomb friction counts with its slope, at standstill coulomb_friction / coulomb_speed.  Coulomb's
    law itself has none while a joint slides, and counts for nothing.
    """
    work, rhs, zero = workspace(model.chain), np.zeros(x.size), np.zeros(x.size)
    torque = np.zeros(model.joints)
    joint = model.chain.joint
    links = model.joint_links
    constant = np.where(joint[links, COULOMB_SPEED] == 0.0, joint[links, COULOMB], 0.0)
    own = np.flatnonzero((model.turn >= 0) & (model.motor < 0))

    def moving(v: np.ndarray) -> np.ndarray:
        residual(model.chain, work, x, v, zero, torque, rhs)
        friction = constant * np.sign(model.shown(v))
        rhs[model.turned] += friction
        rhs[model.turn[own]] += friction[own]
        return -rhs

    speeds = joint[joint[:, COULOMB_SPEED] > 0.0, COULOMB_SPEED]
    step = min(RATE_STEP, FRICTION_STEP * speeds.min(initial=np.inf))
    return differences(moving, zero if v is None else v, np.eye(x.size), step)
