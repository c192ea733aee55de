"""The shape of a robot at rest, or at a steady spin, with its joints held."""

from __future__ import annotations

import numpy as np
from scipy.linalg import LinAlgError, cho_factor

from ..equations.dynamics.tangent import forces, stiffness_matrix
from ..model.model import Model
from ..scene.schema import Scene

ITERATIONS = 50


def joint_motion(model: Model, velocity: np.ndarray) -> np.ndarray:
    """(n,) rates of the unknowns when the joints turn at velocity (m,) and nothing deforms."""
    v = np.zeros(model.unknowns)
    v[: model.joints] = v[model.turned] = velocity
    return v


def rest_shape(model: Model, position: np.ndarray, velocity: np.ndarray | None = None) -> np.ndarray:
    """Unknowns (n,) of the equilibrium with the joints, as their encoders show them, at position (m,).

    With a velocity (m,) it is the steady shape at that spin.

    Newton's method on what the motors leave free.  Where a joint has an elastic rotation phi of its own, its
    coordinate q follows as position - phi; behind a spring q is free.
    """
    m, n = model.joints, model.unknowns
    x = np.zeros(n)
    x[:m] = position
    if n == m:
        return x
    held = model.turned
    x[held] = position
    along = np.delete(np.eye(n), held, axis=1)  # how all unknowns move with the free ones
    own = np.flatnonzero((model.turn >= 0) & (model.motor < 0))
    along[own] -= along[model.turn[own]]

    best = np.inf
    v = None if velocity is None else joint_motion(model, velocity)
    for _ in range(ITERATIONS):
        tangent = along.T @ stiffness_matrix(model, x, v) @ along
        try:
            # not definite before the load has stretched the links, whose tension holds it up
            step = np.linalg.solve(tangent, along.T @ forces(model, x, v))
        except (LinAlgError, ValueError):  # singular, or not finite
            break
        x += along @ step
        size = float(np.max(np.abs(step)))
        if size < 1e-15 or (size < 1e-11 and size >= best):
            if v is None and not is_definite(along.T @ stiffness_matrix(model, x) @ along):
                break
            return x
        best = min(best, size)
    raise ArithmeticError(
        f"{model.scene.name}: no static equilibrium found at {np.round(position, 6).tolist()};"
        " the links are too soft for their load, or buckle"
    )


def is_definite(matrix: np.ndarray) -> bool:
    """Whether a symmetric matrix is positive definite: of a stiffness, whether the equilibrium is stable."""
    try:
        cho_factor(matrix)
    except (LinAlgError, ValueError):
        return False
    return True


def check_position(scene: Scene, position: np.ndarray | list[float]) -> np.ndarray:
    """Joint coordinates as an array (m,), or a ValueError that says what is wrong.

    Where a scene has passive joints, the actuated ones alone will do; the others are as the scene starts.
    """
    q = np.asarray(position, dtype=float).reshape(-1)
    m = len(scene.joints)
    motors = [k for k, joint in enumerate(scene.joints) if joint.actuated]
    if q.size not in (m, len(motors)) or not np.all(np.isfinite(q)):
        less = f", or the {len(motors)} actuated ones" if len(motors) < m else ""
        raise ValueError(f"{scene.name}: position {position!r}; give {m} finite joint coordinates{less}")
    if q.size == m:
        return q
    full = scene.start("position")
    full[motors] = q
    return full


def unknowns_at(model: Model, position: np.ndarray) -> np.ndarray:
    """Unknowns (n,) of the undeformed robot with its joints at position (m,)."""
    x = np.zeros(model.unknowns)
    x[: model.joints] = x[model.turned] = position
    return x
